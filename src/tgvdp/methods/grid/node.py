"""A node: one partial path, as people see it.

The mapping to what kernels see, a pool of columns with one entry per label (tskit's rule: columns are the truth, rows
are views):

    ===============  =========  ==========================================================================
    column           dtype      `Node`
    ===============  =========  ==========================================================================
    station          int32      ``distance_m = station_m[station]``
    level            int16      ``speed_mps = level_mps[level]``
    duration_s       float64    ``duration_s``
    energy_j         float64    ``energy_j``
    parent           int32      ``parent``, another label of the pool; -1 marks the root; gives ``history``
    ===============  =========  ==========================================================================

In `best_first_kernel` the station and the level are one int32, the number of the graph's node, which
implies both. `exact` stores the parent alone: station and level follow from the place of a label in its station's
list, and the costs from adding up the path.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class LabelPool:
    """Labels as columns of shape (n_labels,), with the stations and speeds that they refer to, SI."""

    station_m: NDArray[np.float64]
    level_mps: NDArray[np.float64]
    station: NDArray[np.int32]
    level: NDArray[np.int16]
    duration_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]
    parent: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.parent)

    def node(self, label: int) -> "Node":
        """View of one label."""
        return Node(
            speed_mps=float(self.level_mps[self.level[label]]),
            distance_m=float(self.station_m[self.station[label]]),
            duration_s=float(self.duration_s[label]),
            energy_j=float(self.energy_j[label]),
            pool=self,
            label=label,
        )


@dataclass(frozen=True)
class Node:
    """A partial path: where it ends, how fast, and what it cost.

    Attributes
    ----------
    speed_mps : float
        Speed at its end, m/s.
    distance_m : float
        Distance travelled from the root, m.
    duration_s : float
        Time since the root, s.
    energy_j : float
        Energy consumed since the root, J.
    """

    speed_mps: float
    distance_m: float
    duration_s: float
    energy_j: float
    pool: LabelPool = field(repr=False, compare=False)
    label: int = field(repr=False, compare=False)

    @property
    def parent(self) -> "Node | None":
        """The node before this one; None for the root."""
        parent = int(self.pool.parent[self.label])
        return None if parent < 0 else self.pool.node(parent)

    @property
    def history(self) -> tuple[float, ...]:
        """Previous speeds, root first, m/s."""
        return tuple(node.speed_mps for node in self.ancestors())[::-1]

    def ancestors(self) -> Iterator["Node"]:
        """Walk from the parent back to the root."""
        node = self.parent
        while node is not None:
            yield node
            node = node.parent
