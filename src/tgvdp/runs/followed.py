"""From the rows in which a search drives to those of true runs: their resistance, and the bends of their motion."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.piecewise import Floats
from tgvdp.line.resolved import ResolvedLine, resolve
from tgvdp.model.trip import Trip
from tgvdp.runs.batch import Batch, totals_of
from tgvdp.runs.bends import cut_at_bends
from tgvdp.runs.effort_jumps import jumps_of
from tgvdp.runs.resistance_correction import follow

_Regime = NDArray[np.int8]


class Followed(NamedTuple):
    """True runs.

    Attributes
    ----------
    runs : Batch
        n of them, of N rows in all.
    regime : (N,) int8 or None
        As it was given.
    time_s, energy_j : (n,) float64
        Running times, and energies by the trip's model.
    """

    runs: Batch
    regime: _Regime | None
    time_s: Floats
    energy_j: Floats

    def part(self, index: int) -> "Followed":
        """One of the runs."""
        one, first = slice(index, index + 1), self.runs.first
        regime = None if self.regime is None else self.regime[first[index] : first[index + 1]]
        return Followed(self.runs.part(one), regime, self.time_s[one], self.energy_j[one])

    def regimes(self, index: int) -> _Regime | None:
        """Regimes of the rows of one run, but for its last one."""
        first = self.runs.first
        return None if self.regime is None else self.regime[first[index] : first[index + 1] - 1]


def follow_all(
    trip: Trip, runs: Batch, regime: _Regime | None, time_s: Floats, energy_j: Floats, most_s: Floats, *, bends: bool
) -> Followed:
    """Give runs their true resistance, and cut their rows where an effort drops or motion bends.

    Parameters
    ----------
    trip : Trip
    runs : Batch
        n of them, one at least, of N rows in all.
    regime : (N,) int8 or None
        Regime of the row that starts there, if known; that of the last row of a run means nothing.
    time_s, energy_j : (n,) float64
        Running times, s, and energies by the trip's model, J, by the rows given.
    most_s : (n,) float64
        How far their times may be off, s (`bends.allowed_off_s`).
    bends : bool
        `bends.are_cut` of the runs of a front that are searched for, of which these may be some; those whose efforts
        jump are cut in any case.
    """
    line = resolve(trip)
    true, regime = _corrected(trip, line, runs, regime)
    if bends or (line.even and true is not runs):
        cut, parts = cut_at_bends(trip.train, line, true, most_s)
        if cut is not true:
            true, regime = cut, None if regime is None else regime.repeat(parts)
    if true is runs:
        return Followed(runs, regime, time_s, energy_j)
    return Followed(true, regime, *totals_of(trip, true))


def _corrected(trip: Trip, line: ResolvedLine, runs: Batch, regime: _Regime | None) -> tuple[Batch, _Regime | None]:
    """Runs by their true resistance, with rows that end where an effort jumps: those given, where all are true."""
    if line.even and not any(jumps_of(trip.train)):
        return runs, regime
    given = runs.runs()
    rows = [follow(trip.train, line, *one) for one in given]
    corrected = Batch.of(rows)
    if regime is not None and len(corrected.x_m) > len(runs.x_m):
        regimes = [regime[start : start + len(x_m)] for start, (x_m, _) in zip(runs.first, given, strict=False)]
        regime = np.concatenate([_placed(*one) for one in zip(regimes, given, rows, strict=True)])
    return corrected, regime


def _placed(regime: _Regime, given: tuple[Floats, Floats], rows: tuple[Floats, Floats]) -> _Regime:
    """Regime of rows, each of which lies within one of those given."""
    middle_m = 0.5 * (rows[0][1:] + rows[0][:-1])
    return np.append(regime[np.searchsorted(given[0], middle_m) - 1], regime[-1])
