"""Many runs of one trip, side by side: what is asked of each of them takes one call of a kernel, not one per run."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.piecewise import Floats
from tgvdp.model.trip import Trip
from tgvdp.runs.measure import Columns, measured

_NO_COLUMNS = Columns.of(0)


class Batch(NamedTuple):
    """Rows of n runs, one behind the other.

    Attributes
    ----------
    x_m, w : (N,) float64
        Positions from the origin, m, with all breaks of the line among those of each run, and squared speeds, m²/s².
    first : (n + 1,) int64
        Row with which each run begins, and N.
    """

    x_m: Floats
    w: Floats
    first: NDArray[np.int64]

    @classmethod
    def of(cls, runs: Sequence[tuple[Floats, Floats]]) -> "Batch":
        """Put runs, each its positions and squared speeds, one behind the other."""
        if len(runs) == 1:
            ((x_m, w),) = runs
            return cls(x_m, w, np.array([0, len(x_m)]))
        first = np.cumsum([0, *(len(x_m) for x_m, _ in runs)])
        x_m, w = (np.concatenate(columns) for columns in zip(*runs, strict=True))
        return cls(x_m, w, first)

    @classmethod
    def joined(cls, batches: Sequence["Batch"]) -> "Batch":
        """The runs of some batches, one at least, in one: itself where it is alone."""
        if len(batches) == 1:
            return batches[0]
        first = np.concatenate(([0], *(one.sizes for one in batches))).cumsum()
        return cls(np.concatenate([one.x_m for one in batches]), np.concatenate([one.w for one in batches]), first)

    @property
    def size(self) -> int:
        """How many runs there are."""
        return len(self.first) - 1

    @property
    def sizes(self) -> NDArray[np.int64]:
        """How many rows each of them has, (n,)."""
        return self.first[1:] - self.first[:-1]

    def run(self, index: int) -> tuple[Floats, Floats]:
        """Positions and squared speeds of one run."""
        rows = slice(self.first[index], self.first[index + 1])
        return self.x_m[rows], self.w[rows]

    def runs(self) -> list[tuple[Floats, Floats]]:
        """Positions and squared speeds of each run."""
        return [self.run(index) for index in range(self.size)]

    def part(self, runs: slice) -> "Batch":
        """Neighbouring runs, one at least."""
        first = self.first[runs.start : runs.stop + 1]
        rows = slice(first[0], first[-1])
        return Batch(self.x_m[rows], self.w[rows], first - first[0])


def totals_of(trip: Trip, runs: Batch) -> tuple[Floats, Floats]:
    """Running times, s, and energies by the trip's model, J, of runs, (n,) float64, as their `profile_of` has them."""
    totals = measured(trip, *runs, _NO_COLUMNS)
    return totals[:, 0].copy(), totals[:, 1].copy()
