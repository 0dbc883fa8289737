"""Margins side by side, for a whole journey: time, energy, and how far each is from the linear time anywhere."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.cores import side_by_side
from tgvdp.errors import BudgetExceededError
from tgvdp.margins.curve import Curve
from tgvdp.margins.economy import economy_run
from tgvdp.margins.linear import linear_run
from tgvdp.margins.parts import Part, parts_of, time_within
from tgvdp.margins.uniform import uniform_run
from tgvdp.methods.budget import Clock
from tgvdp.methods.costate.multipliers import OutOfTime
from tgvdp.model.margin import MarginRange, checked_ranges
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile, profile_of

_Floats = NDArray[np.float64]


class MarginRuns(NamedTuple):
    """Runs of all sections of a journey by each margin."""

    linear: tuple[Profile, ...]
    economy: tuple[Profile, ...]
    uniform: tuple[Profile, ...]


def margin_runs(
    sections: Sequence[tuple[Trip, Profile]], ranges: Sequence[MarginRange], within: float, clock: Clock
) -> MarginRuns:
    """Slow the fastest runs of a journey's sections down.

    Parameters
    ----------
    sections : sequence of (Trip, Profile)
        From stop to stop, with their fastest runs.
    ranges : sequence of MarginRange
        How much, and where.
    within : float
        Of the uniform margin: how far times between any two points may be from the linear ones, as a share.
    clock : Clock

    Raises
    ------
    InputError
        When ranges are none, overlap, or do not lie on the line.
    InfeasibleError
        When a part cannot take its time.
    BudgetExceededError
        When the time is up.
    """
    ordered = checked_ranges(ranges, sections[0][0].track.length_m)
    fastest_s = [sum(time_within(*section, one.from_m, one.to_m) for section in sections) for one in ordered]

    def slowed(section: tuple[Trip, Profile]) -> MarginRuns:
        if clock.expired:
            raise OutOfTime
        trip, fastest = section
        parts = parts_of(trip, fastest, ordered, fastest_s)
        linear = [linear_run(part) for part in parts]
        economy = [economy_run(part) for part in parts]
        uniform = [uniform_run(part, own, within, clock) for part, own in zip(parts, linear, strict=True)]
        return MarginRuns(*((_joined(trip, parts, runs),) for runs in (linear, economy, uniform)))

    try:
        done = side_by_side(slowed, sections)
    except OutOfTime:
        raise BudgetExceededError("the time limit ended the margins: there is no uniform one yet") from None
    return MarginRuns(*(tuple(one[0] for one in runs) for runs in zip(*done, strict=True)))


def _joined(trip: Trip, parts: Sequence[Part], runs: Sequence[Curve]) -> Profile:
    """Profile of a section from the runs of its parts."""
    columns = [
        (run.x_m[first:] + (part.trip.origin_m - trip.origin_m), run.w[first:])
        for first, part, run in zip([0] + [1] * len(parts), parts, runs, strict=False)
    ]
    x_m, w = map(np.concatenate, zip(*columns, strict=True))
    x_m[-1] = trip.distance_m
    return profile_of(trip, x_m, w)


def largest_deviation_s(runs: Sequence[Profile], linear: Sequence[Profile]) -> float:
    """Largest distance in time from the linear run at any place of a journey, s; without dwells."""
    most_s = ahead_s = 0.0
    for run, own in zip(runs, linear, strict=True):
        most_s = max(most_s, float(np.abs(deviation_s(run, own)[1] + ahead_s).max()))
        ahead_s += run.duration_s - own.duration_s
    return most_s


def deviation_s(run: Profile, linear: Profile) -> tuple[_Floats, _Floats]:
    """Where rows of either run are, m, and how much later a run is there than the linear one, s; of one section."""
    position_m = np.union1d(run.position_m, linear.position_m)
    return position_m, passing_s(run, position_m) - passing_s(linear, position_m)


def passing_s(run: Profile, position_m: _Floats) -> _Floats:
    """When a run of one section passes positions, s; acceleration is constant between its rows."""
    at = np.searchsorted(run.position_m, position_m, side="right").clip(1, len(run.position_m) - 1) - 1
    speed = np.sqrt(np.interp(position_m, run.position_m, run.speed_mps**2))
    begin = run.speed_mps[at]
    both = np.where(begin + speed > 0.0, begin + speed, 1.0)  # nothing is driven where both stand
    return np.asarray(run.time_s[at] + 2.0 * (position_m - run.position_m[at]) / both)
