"""Runs that a search found, in a table: what is asked of all of them takes one expression, not one each."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.costate.mesh import Run
from tgvdp.runs.batch import Batch

_NO_ROWS = np.empty(0)


class Found(NamedTuple):
    """Runs, n of them.

    Attributes
    ----------
    outcome : (n, 3) float64
        Running times, s, energies, J, and multipliers, J/s.
    rows : Batch
        Their rows, from the origin.
    """

    outcome: NDArray[np.float64]
    rows: Batch

    @classmethod
    def none(cls) -> "Found":
        """No run."""
        return cls(np.empty((0, 3)), Batch(_NO_ROWS, _NO_ROWS, np.zeros(1, dtype=np.int64)))

    @classmethod
    def of(cls, runs: Sequence[Run]) -> "Found":
        """Some runs, one at least."""
        return cls(np.array([run[:3] for run in runs]), Batch.of([(run.x_m, run.w) for run in runs]))

    @classmethod
    def joined(cls, parts: Sequence["Found"]) -> "Found":
        """The runs of some tables, one at least, in one."""
        if len(parts) == 1:
            return parts[0]
        return cls(np.concatenate([one.outcome for one in parts]), Batch.joined([one.rows for one in parts]))

    def picked(self, which: NDArray[np.intp]) -> "Found":
        """Some of the runs, (m,), in that order."""
        if len(which) == 0:
            return Found.none()
        if len(which) == len(self.outcome) and (which[1:] > which[:-1]).all():
            return self
        ends = [0, *(np.flatnonzero(which[1:] != which[:-1] + 1) + 1).tolist(), len(which)]
        rows = [self.rows.part(slice(which[first], which[last - 1] + 1)) for first, last in pairwise(ends)]
        return Found(self.outcome[which], Batch.joined(rows))
