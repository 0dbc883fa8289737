"""The parts of a run that take a time each: from stop to stop, cut where the margin changes on the way."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.line.cells import cells_of
from tgvdp.line.resolved import resolve
from tgvdp.margins.curve import Curve, Driver
from tgvdp.model.margin import MarginRange
from tgvdp.model.trip import Trip
from tgvdp.physics.forces import kernel_train
from tgvdp.physics.roots import Bracket
from tgvdp.runs.fastest import envelope_of, fastest_run
from tgvdp.runs.profile import Profile
from tgvdp.runs.resistance_correction import follow

_Floats = NDArray[np.float64]

#: Rows of what is driven, per usual one. One curve leaves another within a row, whose first part then has the effort of
#: the whole row: it is off its own limit by half of `physics.march.STEP` over this number at most, less than the
#: referee allows.
_ROWS = 32.0
#: Parts share a v² that is lower than that of the faster one by this share: it has to be possible on both sides.
_ROUNDING = 1e-6
#: A part's time is met to this, s, or to this share of it if that is less.
_MET_S, _MET_SHARE = 1e-3, 1e-6
#: Steps of the search for what meets a time, and the relative width below which it jumps there.
_STEPS, _WIDTH = 60, 1e-12


#: A run so far on the way, from 0 to 1, from one run to another.
Mix = Callable[[Curve, Curve, float], Curve]


class Part(NamedTuple):
    """A part of a run.

    Attributes
    ----------
    trip : Trip
        From its begin to its end, with the speeds that it shares with its neighbours.
    base : Curve
        The fastest run of the whole section along it, whose speeds there are no lower.
    time_s : float
        What it shall take, s.
    """

    trip: Trip
    base: Curve
    time_s: float

    @property
    def ratio(self) -> float:
        """What it shall take over what the fastest run takes."""
        return self.time_s / self.base.duration_s

    @property
    def driver(self) -> Driver:
        """The train on this part of the line."""
        return Driver(kernel_train(self.trip.train)._replace(rows=_ROWS), cells_of(self.trip))

    def driven(self, curve: Curve) -> Curve:
        """A curve that was made on steps of the resistance, under the true one."""
        return Curve(*follow(self.trip.train, resolve(self.trip), *curve))


def parts_of(trip: Trip, fastest: Profile, ranges: Sequence[MarginRange], fastest_s: Sequence[float]) -> list[Part]:
    """Cut a section where ranges end inside it.

    Parameters
    ----------
    trip : Trip
    fastest : Profile
        Its fastest run.
    ranges : sequence of MarginRange
        In the order of the line; there is no supplement between them.
    fastest_s : sequence of float
        Time of the fastest run of the whole journey in each range, s.

    Raises
    ------
    InfeasibleError
        When a part does not lead from the speed at its begin to that at its end.
    """
    ends_m = {0.0, trip.distance_m}
    for one in ranges:
        ends_m |= {at_m - trip.origin_m for at_m in (one.from_m, one.to_m)}
    inside_m = sorted(at_m for at_m in ends_m if 0.0 <= at_m <= trip.distance_m)
    base = _base(trip, fastest, inside_m)
    stretches = [base.between(*ends) for ends in pairwise(inside_m)]
    ratios = [_ratio(trip.origin_m, one, ranges, fastest_s) for one in stretches]
    border_w = [
        trip.start_speed_mps**2,
        *(
            (1.0 - _ROUNDING) * base.at(at_m) / min(before, after) ** 2
            for at_m, before, after in zip(inside_m[1:-1], ratios[:-1], ratios[1:], strict=True)
        ),
        trip.end_speed_mps**2,
    ]
    ends = zip(pairwise(inside_m), pairwise(border_w), strict=True)
    trips = [_between(trip, along, speeds) for along, speeds in ends]
    for part, ratio in zip(trips, ratios, strict=True):
        if ratio > 1.0 and len(trips) > 1:
            _require_run(part)
    return [
        Part(part, _from_its_begin(stretch, part.distance_m), ratio * stretch.duration_s)
        for part, stretch, ratio in zip(trips, stretches, ratios, strict=True)
    ]


def _from_its_begin(stretch: Curve, length_m: float) -> Curve:
    """A stretch by the distance along it, to the very end of its trip."""
    x_m = stretch.x_m - stretch.x_m[0]
    x_m[-1] = length_m
    return Curve(x_m, stretch.w)


def _base(trip: Trip, fastest: Profile, ends_m: Sequence[float]) -> Curve:
    """The fastest run, with rows where parts meet: those of a part then follow its limits as closely."""
    if not ends_m[1:-1]:
        return Curve(fastest.position_m - trip.origin_m, fastest.speed_mps**2)
    train = kernel_train(trip.train)._replace(rows=_ROWS)
    envelope = envelope_of(trip, cells_of(trip, np.array(ends_m)), train)
    return Curve(*follow(trip.train, resolve(trip), envelope.x_m, envelope.w))


def _between(trip: Trip, along_m: tuple[float, float], borders_w: tuple[float, float]) -> Trip:
    """A part of a trip, with the v² at its ends."""
    start_mps, end_mps = map(math.sqrt, borders_w)
    return replace(
        trip,
        origin_m=trip.origin_m + along_m[0],
        destination_m=trip.origin_m + along_m[1] if along_m[1] < trip.distance_m else trip.destination_m,
        start_speed_mps=start_mps,
        end_speed_mps=end_mps,
    )


def _require_run(part: Trip) -> None:
    """Refuse a part that begins too slowly to be as fast at its end as the margin behind it has it."""
    try:
        fastest_run(part)
    except InfeasibleError as error:
        raise InfeasibleError(
            f"margins: from {part.origin_m:.6g} m to {part.destination_m:.6g} m, between the speeds of other margins:"
            f" {error}"
        ) from None


def _ratio(origin_m: float, base: Curve, ranges: Sequence[MarginRange], fastest_s: Sequence[float]) -> float:
    """What a stretch shall take over what the fastest run takes."""
    middle_m = origin_m + 0.5 * float(base.x_m[0] + base.x_m[-1])
    for one, whole_s in zip(ranges, fastest_s, strict=True):
        if one.from_m <= middle_m <= one.to_m:
            own_s, length_m = base.duration_s, float(base.x_m[-1] - base.x_m[0])
            given = one.supplement
            return 1.0 + given.share + given.s_per_m * length_m / own_s + given.total_s / whole_s
    return 1.0


def time_within(trip: Trip, fastest: Profile, from_m: float, to_m: float) -> float:
    """Time of a section's fastest run between two positions of the line, as far as they lie in it, s."""
    first_m, last_m = max(from_m - trip.origin_m, 0.0), min(to_m - trip.origin_m, trip.distance_m)
    if first_m >= last_m:
        return 0.0
    return Curve(fastest.position_m - trip.origin_m, fastest.speed_mps**2).between(first_m, last_m).duration_s


def met(part: Part, run: Callable[[float], Curve], fast: float, slow: float, *mixes: Mix) -> Curve:
    """Find the run of a family that takes a part's time.

    Parameters
    ----------
    part : Part
    run : callable
        The run of a parameter.
    fast, slow : float
        Parameters of a run that is too fast and of one that is too slow.
    *mixes : callable
        What stands between two runs where the time jumps at some parameter: one way, or the next where that jumps, too.

    Raises
    ------
    InfeasibleError
        When the slow one is too fast.
    """
    tolerance_s = min(_MET_S, _MET_SHARE * part.time_s)
    runs = {fast: run(fast), slow: run(slow)}
    over_s = {at: one.duration_s - part.time_s for at, one in runs.items()}
    for at in (fast, slow):
        if abs(over_s[at]) <= tolerance_s:
            return runs[at]
    if over_s[slow] < 0.0:
        raise InfeasibleError(
            f"margins: one of them has no run that takes {part.time_s:.6g} s from {part.trip.origin_m:.6g} m to"
            f" {part.trip.destination_m:.6g} m: the slowest of its kind takes {runs[slow].duration_s:.6g} s"
        )
    if over_s[fast] > 0.0:
        raise InfeasibleError(
            f"margins: no run takes {part.time_s:.6g} s from {part.trip.origin_m:.6g} m to"
            f" {part.trip.destination_m:.6g} m with its neighbours' speeds at its ends: the fastest takes"
            f" {runs[fast].duration_s:.6g} s"
        )
    bracket = Bracket(fast, slow, over_s[fast], over_s[slow])
    for _ in range(_STEPS):
        at = bracket.secant()
        one = run(at)
        over = one.duration_s - part.time_s
        if abs(over) <= tolerance_s:
            return one
        runs[at] = one
        bracket = bracket.narrowed(at, over)
        if abs(bracket.hi - bracket.lo) <= _WIDTH * abs(bracket.hi):
            break
    first, second = runs[bracket.lo], runs[bracket.hi]
    mix, *rest = mixes
    return met(part, lambda share: mix(first, second, share), 0.0, 1.0, *rest)
