"""The economy margin as railways compute it: the algorithm MARECO of the SNCF, as OSRD publishes it.

The train accelerates in full to a speed v1, holds it, and coasts where that speed would soon be lost for nothing:
before it brakes, down to

    vf = W·v1/(W + R(v1)·v1),    W = v1²·R'(v1),

with the running resistance R, and before descents on which it would have to brake to hold its speed V, entered no
slower than

    v = 1/(1/V + R(V)/(W·(1 − b/a))),

a > 0 being its mean acceleration by itself on the descent and b ≤ 0 that before it, so that it is at V again where the
descent ends. W is the multiplier at which v1 is held on level track, and vf the speed at which coasting ends there
(Howlett & Pudney, Energy-Efficient Train Control, 1995). One v1 is sought that takes the time. (OSRD:
`MarecoAllowance`, `BrakingPhaseCoast`, `AcceleratingSlopeCoast`, after the paper "MARECO" on osrd.fr.) Unlike there, no
speed is too low for the line's capacity; and where the time jumps as v1 changes, the train begins to coast later.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.line.cells import cells_of
from tgvdp.line.resolved import resolve
from tgvdp.margins.curve import Curve, blended, mirrored
from tgvdp.margins.linear import joints_of
from tgvdp.margins.parts import Part, met
from tgvdp.model.train import Train
from tgvdp.physics.codes import BRAKING, COASTING
from tgvdp.runs.caps import lowest_cap_mps
from tgvdp.runs.fastest import envelope_of
from tgvdp.runs.profile import Profile, profile_of

#: The cap leaves this much more than the length in which the train comes down from a neighbour's speed.
_SPARE = 1.001
#: The lowest cap tried, as a share of the slowest mean speed that is asked for.
_LEAST = 0.2
#: The lowest cap that is possible is known to this factor.
_KNOWN = 1.001
#: Relative difference below which speeds are the same.
_SAME = 1e-9


class _Opportunity(NamedTuple):
    """Where coasting may end: position, m, v² there, and the least v² while it lasts, m²/s²."""

    x_m: float
    w: float
    least_w: float


def economy_run(part: Part) -> Curve:
    """Run of a part by the economy margin.

    Raises
    ------
    InfeasibleError
        When no cap on the speed takes the time.
    """
    if part.ratio <= 1.0 + _SAME:
        return part.base
    train = part.trip.train
    top_mps = math.sqrt(float(part.base.w.max()))
    fast = top_mps
    while coasting_ends_mps(train, fast) < top_mps and fast < 1e3 * top_mps:
        fast *= 2.0
    slow = _least_possible(part, _LEAST * part.trip.distance_m / part.time_s, fast)

    def later(first: Curve, second: Curve, share: float) -> Curve:
        return part.driven(_coasted_later(part, first, second, (1.0 - share) * part.trip.distance_m))

    # Running times are more nearly linear in the pace of the cap than in its speed.
    return met(part, lambda pace: part.driven(_run(part, 1.0 / pace)), 1.0 / fast, 1.0 / slow, later, blended)


def _least_possible(part: Part, slow_mps: float, fast_mps: float) -> float:
    """The lowest cap from a slow one on, m/s, under which the train gets over the climbs and up to its end speed."""

    def is_possible(held_mps: float) -> bool:
        try:
            _capped(part, held_mps)
        except InfeasibleError:
            return False
        return True

    return slow_mps if is_possible(slow_mps) else lowest_cap_mps(is_possible, slow_mps, fast_mps, _KNOWN)


def coasting_ends_mps(train: Train, held_mps: float) -> float:
    """Speed vf at which coasting before a brake ends, of a train that holds v1 on the way, m/s."""
    resistance_n = train.resistance_n(held_mps)
    hold_w = _multiplier(train, held_mps)
    return hold_w * held_mps / (hold_w + resistance_n * held_mps) if hold_w > 0.0 else 0.0


def _multiplier(train: Train, held_mps: float) -> float:
    """W = v1²·R'(v1), the multiplier at which a speed is held on level track, J/s."""
    return held_mps**2 * (train.davis_b_n_per_mps + 2.0 * train.davis_c_n_per_mps2 * held_mps)


def _run(part: Part, held_mps: float) -> Curve:
    """The run that holds v1 where it can, and coasts."""
    capped = _capped(part, held_mps)
    ends_w = coasting_ends_mps(part.trip.train, held_mps) ** 2
    opportunities = sorted(
        (*_before_braking(capped, ends_w), *_before_descents(part, capped, held_mps, ends_w)), reverse=True
    )
    base = Curve(capped.position_m - part.trip.origin_m, capped.speed_mps**2)
    run, begins_m = base, math.inf
    for opportunity in opportunities:
        if opportunity.x_m <= begins_m and (coast := _coasted(part, base, opportunity)) is not None:
            run, begins_m = run.replaced(coast), float(coast.x_m[0])
    return run


def _capped(part: Part, held_mps: float) -> Profile:
    """The fastest run with its speed capped, but next to faster neighbours."""
    cap_w, trip, length_m = held_mps**2, part.trip, part.trip.distance_m
    down, up = joints_of(part, cap_w, 0.0)
    from_m, to_m = 0.0, length_m
    if down is not None:  # to the first row below the cap
        above = np.flatnonzero(down.w >= cap_w)
        from_m = _SPARE * float(down.x_m[min(above[-1] + 1, len(down.x_m) - 1)])
    if up is not None and (up.w > cap_w).any():  # from the last row below it on
        to_m = float(up.x_m[max(int(np.argmax(up.w > cap_w)) - 1, 0)])
    cells = cells_of(trip, np.array([from_m, to_m]))
    middle_m = 0.5 * (cells.station_m[1:] + cells.station_m[:-1])
    limit_w = np.where((middle_m > from_m) & (middle_m < to_m), cap_w, math.inf)
    capped = cells._replace(limit_w=np.minimum(cells.limit_w, limit_w))
    envelope = envelope_of(trip, capped, part.driver.train)
    return profile_of(trip, envelope.x_m, envelope.w)


def _before_braking(run: Profile, ends_w: float) -> Iterator[_Opportunity]:
    """Where braking ends, or passes the speed at which coasting ends."""
    x_m, w = run.position_m - run.position_m[0], run.speed_mps**2
    falling = (run.regime[:-1] == BRAKING) & (np.diff(w) < 0.0)
    for first, last in _stretches(falling):
        if w[last] > ends_w:
            yield _Opportunity(float(x_m[last]), float(w[last]), ends_w)
        elif w[first] > ends_w:
            at_m = float(np.interp(-ends_w, -w[first : last + 1], x_m[first : last + 1]))
            yield _Opportunity(at_m, ends_w, ends_w)


def _before_descents(part: Part, run: Profile, held_mps: float, ends_w: float) -> Iterator[_Opportunity]:
    """Where descents end on which a speed is held by brakes."""
    train, line = part.trip.train, resolve(part.trip)
    x_m, w = run.position_m - run.position_m[0], run.speed_mps**2
    pulled = (np.abs(np.diff(w)) <= _SAME * w[1:]) & (run.force_n[:-1] < 0.0)
    for first, last in _stretches(pulled):
        speed = float(run.speed_mps[first])
        if speed**2 <= ends_w:
            continue
        length_m = np.diff(x_m[first : last + 1])
        a = -float(np.average(run.force_n[first:last], weights=length_m)) / train.inertia_kg
        step = line.step_at(np.array([max(x_m[first] - train.length_m - _SAME, 0.0)]))[0]
        before_n = train.davis_a_n + speed * (train.davis_b_n_per_mps + speed * line.air[step]) + line.grade_n[step]
        b = -max(float(before_n), 0.0) / train.inertia_kg
        slowed = train.resistance_n(speed) / (_multiplier(train, held_mps) * (1.0 - b / a))
        least_w = max(1.0 / (1.0 / speed + slowed) ** 2, ends_w)
        yield _Opportunity(float(x_m[last]), float(w[last]), least_w)


def _stretches(which: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """First and last rows of what lies together."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], which, [False])).astype(np.int8)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def _coasted(part: Part, base: Curve, end: _Opportunity) -> Curve | None:
    """Coasting from a run to where it may end, or back to that run before; None where there is none."""
    driver = part.driver
    back, held = driver.backwards(COASTING, end.x_m, end.w, end.least_w, base)
    met_m = mirrored(back, end.x_m).first_meeting_m(mirrored(base.between(0.0, end.x_m), end.x_m))
    begins_m = 0.0 if met_m is None else end.x_m - met_m
    if met_m is not None and not held:
        return back.between(begins_m, end.x_m)
    forth = driver.forwards(COASTING, begins_m, base.at(begins_m), base)
    over_m = forth.first_meeting_m(base)
    return None if over_m is None else forth.between(begins_m, over_m)


def _coasted_later(part: Part, fast: Curve, slow: Curve, from_m: float) -> Curve:
    """A run that is the fast one before a position, and from there on coasts where only the slow one does."""
    apart = fast.at(from_m) - slow.at(from_m)
    if apart <= _SAME * fast.at(from_m):
        return fast.until(from_m, slow)
    joined_m = slow.between(from_m, part.trip.distance_m).first_meeting_m(fast)
    coast = part.driver.forwards(COASTING, from_m, fast.at(from_m), fast)
    met_m = coast.first_meeting_m(fast)
    end_m = part.trip.distance_m if joined_m is None else joined_m
    run = fast.until(end_m, slow)
    return run if met_m is None or met_m > end_m else run.replaced(coast.between(from_m, met_m))
