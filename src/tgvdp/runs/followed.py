"""From the rows in which a search drives to those of true runs: their resistance, and the bends of their motion."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tgvdp.cores import even_parts, shares, side_by_side
from tgvdp.line.piecewise import Floats
from tgvdp.line.resolved import ResolvedLine, resolve
from tgvdp.model.trip import Trip
from tgvdp.runs.batch import ROWS_OF_A_THREAD, Batch, totals_of
from tgvdp.runs.bends import cut_at_bends, most_off_s
from tgvdp.runs.resistance_correction import follow


def follow_all(
    trip: Trip,
    time_s: list[float],
    rows: list[tuple[Floats, Floats]],
    regimes: list[NDArray[np.int8] | None],
    start: int = 0,
) -> dict[int, tuple[float, float]]:
    """Give runs their true resistance, and cut their rows where an effort drops or motion bends.

    Parameters
    ----------
    trip : Trip
    time_s : list of float
        Running times by the rows given.
    rows : list of ((n,) float64, (n,) float64), modified in place
        Positions from the origin, m, with all breaks among them, and squared speeds, m²/s², of each run.
    regimes : list of (n − 1,) int8 or None, modified in place
        Regime of each row, where they are known.
    start : int
        Runs before this one are true already.

    Returns
    -------
    dict
        Running time, s, and energy by the trip's model, J, of those runs that have other rows now.
    """
    line = resolve(trip)
    changed: list[int] = []
    for i, (given_m, given_w) in enumerate(rows[start:], start):
        x_m, w = follow(trip.train, line, given_m, given_w)
        rows[i] = x_m, w
        known = regimes[i]
        if known is not None and len(x_m) > len(given_m):
            regimes[i] = known[np.searchsorted(given_m, 0.5 * (x_m[1:] + x_m[:-1])) - 1]
        if len(x_m) > len(given_m) or (line.even and most_off_s(time_s[i]) > 0.0):
            changed.append(i)
    if not changed:
        return {}
    parts = even_parts(changed, shares(sum(len(rows[i][0]) for i in changed), ROWS_OF_A_THREAD))
    totals: dict[int, tuple[float, float]] = {}
    for part in side_by_side(lambda own: _cut(trip, line, own, rows, regimes), parts):
        totals |= part
    return totals


def _cut(
    trip: Trip,
    line: ResolvedLine,
    changed: Sequence[int],
    rows: list[tuple[Floats, Floats]],
    regimes: list[NDArray[np.int8] | None],
) -> dict[int, tuple[float, float]]:
    """Cut rows of some runs at bends, and add up their times and energies."""
    batch = Batch.of([rows[i] for i in changed])
    if line.even:  # where the resistance changes along a row, its effort is no law to cut it by
        given = batch
        batch, parts = cut_at_bends(trip.train, line, given)
        for i, run, first in zip(changed, batch.runs(), given.first.tolist(), strict=False):
            known = regimes[i]
            if known is not None:
                regimes[i] = known.repeat(parts[first : first + len(known)])
            rows[i] = run
    totals = zip(*(column.tolist() for column in totals_of(trip, batch)), strict=True)
    return dict(zip(changed, totals, strict=True))
