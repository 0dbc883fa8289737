"""Many runs of one trip, side by side: what is asked of each of them takes one call of a kernel, not one per run."""

from collections.abc import Sequence
from itertools import pairwise
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
        first = np.cumsum([0, *(len(x_m) for x_m, _ in runs)])
        x_m, w = (np.concatenate(columns) for columns in zip(*runs, strict=True))
        return cls(x_m, w, first)

    def runs(self) -> list[tuple[Floats, Floats]]:
        """Positions and squared speeds of each run."""
        ends = pairwise(self.first.tolist())
        return [(self.x_m[start:end], self.w[start:end]) for start, end in ends]


def totals_of(trip: Trip, runs: Batch) -> tuple[Floats, Floats]:
    """Running times, s, and energies by the trip's model, J, of runs, (n,) float64, as their `profile_of` has them."""
    totals = measured(trip, *runs, _NO_COLUMNS)
    return totals[:, 0].copy(), totals[:, 1].copy()
