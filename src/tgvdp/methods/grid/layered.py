"""A layered directed graph with two costs per arc, as CSR arrays.

Layer k holds the nodes ``layer_ptr[k] .. layer_ptr[k + 1] - 1``; arcs lead from a layer to the next one, so that node
numbers increase along every path. The first layer is the root alone, the last one the terminal alone.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tgvdp._jit import kernel
from tgvdp.errors import InputError

#: Arcs that are looked at in one go.
_PART = 1 << 20


class Incoming(NamedTuple):
    """The same arcs sorted by the node where they end; arcs into one node come in the order of their sources.

    Attributes
    ----------
    arc_ptr : (n_nodes + 1,) int64
    arc_from : (n_arcs,) int32
    duration_s, energy_j : (n_arcs,) float64
    """

    arc_ptr: NDArray[np.int64]
    arc_from: NDArray[np.int32]
    duration_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]


class LayeredGraph(NamedTuple):
    """Arcs sorted by the node where they start.

    Attributes
    ----------
    layer_ptr : (n_layers + 1,) int64
        First node of each layer.
    arc_ptr : (n_nodes + 1,) int64
        First arc of each node.
    arc_to : (n_arcs,) int32
        Node where the arc ends.
    duration_s, energy_j : (n_arcs,) float64
        Costs, not negative.
    """

    layer_ptr: NDArray[np.int64]
    arc_ptr: NDArray[np.int64]
    arc_to: NDArray[np.int32]
    duration_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return len(self.arc_ptr) - 1

    @property
    def n_layers(self) -> int:
        """Number of layers, root and terminal included."""
        return len(self.layer_ptr) - 1

    @property
    def layer(self) -> NDArray[np.int32]:
        """Layer of each node, (n_nodes,) int32."""
        return np.repeat(np.arange(self.n_layers, dtype=np.int32), np.diff(self.layer_ptr))

    @property
    def arc_from(self) -> NDArray[np.int32]:
        """Node where each arc starts, (n_arcs,) int32."""
        return np.repeat(np.arange(self.n_nodes, dtype=np.int32), np.diff(self.arc_ptr))

    def incoming(self) -> Incoming:
        """Sort the arcs by the node where they end."""
        counts = np.bincount(self.arc_to, minlength=self.n_nodes)
        arc_ptr = np.concatenate(([0], np.cumsum(counts))).astype(np.int64)
        n_arcs = len(self.arc_to)
        incoming = Incoming(arc_ptr, np.empty(n_arcs, dtype=np.int32), np.empty(n_arcs), np.empty(n_arcs))
        _sort_by_end(self, incoming, arc_ptr[:-1].copy())
        return incoming


@kernel
def _sort_by_end(graph: LayeredGraph, incoming: Incoming, place: NDArray[np.int64]) -> None:
    """Counting sort, which keeps the order of the starts; ``place`` holds where each node's arcs begin, and is used."""
    for node in range(graph.arc_ptr.size - 1):
        for a in range(graph.arc_ptr[node], graph.arc_ptr[node + 1]):
            slot = place[graph.arc_to[a]]
            place[graph.arc_to[a]] = slot + 1
            incoming.arc_from[slot] = node
            incoming.duration_s[slot] = graph.duration_s[a]
            incoming.energy_j[slot] = graph.energy_j[a]


def _in_order(source: NDArray[np.int32], target: NDArray[np.int32]) -> bool:
    """Whether arcs are sorted by source and target, and none comes twice; in parts, between which Ctrl-C is heard."""
    for at in range(0, len(source) - 1, _PART):
        before, after = slice(at, at + _PART), slice(at + 1, at + 1 + _PART)
        starts, ends = source[after], target[after]
        same = source[before][: len(starts)] == starts
        if not np.all(np.where(same, target[before][: len(ends)] < ends, source[before][: len(starts)] < starts)):
            return False
    return True


def layered_graph(
    layer_sizes: ArrayLike, arc_from: ArrayLike, arc_to: ArrayLike, duration_s: ArrayLike, energy_j: ArrayLike
) -> LayeredGraph:
    """Build a graph from arcs in any order.

    Parameters
    ----------
    layer_sizes : (n_layers,) int
        Number of nodes of each layer; the first and the last are 1.
    arc_from, arc_to : (n_arcs,) int
        Nodes, numbered through the layers.
    duration_s, energy_j : (n_arcs,) float
        Costs, finite and not negative.

    Raises
    ------
    InputError
        When an end layer has more than one node, an arc skips a layer or comes twice, or a cost is negative or not
        finite.
    """
    sizes = np.asarray(layer_sizes, dtype=np.int64)
    source = np.asarray(arc_from, dtype=np.int32)
    target = np.asarray(arc_to, dtype=np.int32)
    duration = np.asarray(duration_s, dtype=np.float64)
    energy = np.asarray(energy_j, dtype=np.float64)
    if len(sizes) < 2 or sizes[0] != 1 or sizes[-1] != 1:
        raise InputError(f"graph: the first and the last of two or more layers hold one node, got sizes {list(sizes)}")
    layer_ptr = np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)
    n_nodes = int(layer_ptr[-1])
    if source.size and (min(source.min(), target.min()) < 0 or max(source.max(), target.max()) >= n_nodes):
        raise InputError(f"graph: arcs must join nodes 0 .. {n_nodes - 1}")
    for name, cost in (("duration_s", duration), ("energy_j", energy)):
        if cost.size and not (cost.min() >= 0.0 and cost.max() < np.inf):  # nan passes neither
            raise InputError(f"graph: {name} must be finite and not negative on every arc")
    if not _in_order(source, target):
        order = np.lexsort((target, source))
        source, target, duration, energy = source[order], target[order], duration[order], energy[order]
        if not _in_order(source, target):
            raise InputError("graph: an arc is given twice")
    arc_ptr = np.searchsorted(source, np.arange(n_nodes + 1, dtype=np.int32))
    for first, end, next_end in zip(layer_ptr[:-1], layer_ptr[1:], [*layer_ptr[2:], n_nodes], strict=True):
        ends = target[arc_ptr[first] : arc_ptr[end]]  # a layer at a time: an interrupt need not wait for all
        if ends.size and not (end <= ends.min() and ends.max() < next_end):
            raise InputError("graph: every arc must lead to the next layer")
    return LayeredGraph(layer_ptr, arc_ptr, target, duration, energy)
