"""The fastest run by explicit steps in distance, as TrainRuns.jl integrates it: to reproduce its running times.

Each step holds the acceleration that it starts with, v² then is linear in position, and a step that would pass a target
(the end of a section, a speed limit, the point where braking must begin) ends on it:

    w(x) = w + 2·a(v)·(x − s)        dt = 2·ds/(v0 + v1)

From standstill the effort of 0 km/h thus pulls over the whole first step, which is what makes the result a fraction of
a percent faster than the converged run. Sections are the line's cells, as in TrainRuns.jl, whose steps start anew at
each change of speed limit or resistance (Kannenberg, TrainRuns.jl 1.0, `behavior.jl`). It approaches such targets by
steps of 1/10, 1/100 and 1/1000 instead of cutting the last one, and starts steps anew at points of interest as well;
both change the running times of its own tests by less than 0.005 s.

Braking is stepped backwards from where it ends. At constant deceleration that is exact.
"""

import itertools
import math
from bisect import bisect_right
from collections.abc import Callable
from typing import NamedTuple

from tgvdp.errors import BudgetExceededError
from tgvdp.line.cells import Cells, cells_of
from tgvdp.memory import ask_for
from tgvdp.model.trip import Trip

_ON_ENVELOPE = 1e-12
#: Steps between two looks at the clock: some milliseconds.
_STEPS_PER_LOOK = 1000
#: Memory of a step of the braking envelope, B: two numbers of Python in two lists.
_STEP_B = 64.0


class _Cell(NamedTuple):
    """One cell of the line: ends in m, grade force in N, coefficient of v² in N/(m/s)², squared limit in m²/s².

    ``powered`` is False in neutral sections: there is neither traction nor dynamic brake.
    """

    start_m: float
    end_m: float
    grade_n: float
    air: float
    limit_w: float
    powered: bool


class _Envelope(NamedTuple):
    """Largest squared speed in a cell, m²/s², linear between positions: the limit, then braking to what follows."""

    x_m: list[float]
    w: list[float]

    def segment(self, x_m: float) -> int:
        """Index of the segment that starts at or before a position inside the cell."""
        return min(bisect_right(self.x_m, x_m), len(self.x_m) - 1) - 1

    def slope(self, index: int) -> float:
        """dw/dx in a segment, m/s²."""
        return (self.w[index + 1] - self.w[index]) / (self.x_m[index + 1] - self.x_m[index])

    def at(self, x_m: float) -> float:
        """Value at a position, m²/s²."""
        index = self.segment(x_m)
        return self.w[index] + self.slope(index) * (x_m - self.x_m[index])


def stepped_time_s(trip: Trip, step_m: float, cells: Cells | None = None, expired: Callable[[], bool] = bool) -> float:
    """Running time of the fastest run by explicit steps.

    Parameters
    ----------
    trip : Trip
    step_m : float
        Length of a step, m; TrainRuns.jl takes 20.
    cells : Cells, optional
        Of the trip, where they are known already.
    expired : callable, optional
        Whether the time for it is up.

    Returns
    -------
    float
        s; infinite where steps of that length stall.

    Raises
    ------
    BudgetExceededError
        When the time is up.
    """
    ask_for(_STEP_B * trip.distance_m / step_m, "the explicit steps of the convention")
    watch = _watch(expired)
    columns = cells_of(trip) if cells is None else cells
    rows = [
        _Cell(start_m, end_m, grade_n, air, limit_w, _is_powered(trip, 0.5 * (start_m + end_m)))
        for start_m, end_m, grade_n, air, limit_w in zip(
            columns.station_m[:-1].tolist(),
            columns.station_m[1:].tolist(),
            columns.grade_n.tolist(),
            columns.air.tolist(),
            columns.limit_w.tolist(),
            strict=True,
        )
    ]
    envelopes = _envelopes(trip, rows, step_m, watch)
    time_s, w = 0.0, trip.start_speed_mps**2
    for cell, envelope in zip(rows, envelopes, strict=True):
        in_cell_s, w = _drive(trip, cell, envelope, step_m, min(w, envelope.w[0]), watch)
        time_s += in_cell_s
        if math.isinf(time_s):
            break
    return time_s


def _is_powered(trip: Trip, at_m: float) -> bool:
    """Whether there is current at a position, counted from the origin."""
    return not any(
        row.position_m <= trip.origin_m + at_m < row.position_m + row.length_m for row in trip.track.neutral_sections
    )


def _watch(expired: Callable[[], bool]) -> Callable[[], None]:
    """Count steps, and look at the clock after some thousand of them."""
    steps = itertools.count(1)

    def watch() -> None:
        if next(steps) % _STEPS_PER_LOOK == 0 and expired():
            raise BudgetExceededError("the time limit passed among the explicit steps of the convention")

    return watch


def _envelopes(trip: Trip, cells: list[_Cell], step_m: float, watch: Callable[[], None]) -> list[_Envelope]:
    """Envelopes of all cells, made backwards from the destination."""
    made: list[_Envelope] = []
    w = trip.end_speed_mps**2
    for cell in reversed(cells):
        made.append(_envelope(trip, cell, step_m, min(w, cell.limit_w), watch))
        w = made[-1].w[0]
    return made[::-1]


def _envelope(trip: Trip, cell: _Cell, step_m: float, w: float, watch: Callable[[], None]) -> _Envelope:
    """Step backwards from the end of a cell at full braking, up to the limit."""
    positions_m, squares = [cell.end_m], [w]
    while positions_m[-1] > cell.start_m:
        watch()
        rate, change_w = _deceleration_mps2(trip, cell, w)
        top_w = min(change_w, cell.limit_w)
        to_m = max(positions_m[-1] - step_m, cell.start_m)
        if w >= cell.limit_w:
            to_m = cell.start_m
        elif rate > 0.0 and (top_w - w) / (2.0 * rate) <= positions_m[-1] - to_m:
            to_m, w = positions_m[-1] - (top_w - w) / (2.0 * rate), top_w
        else:
            w = max(w + 2.0 * rate * (positions_m[-1] - to_m), 0.0)
        if to_m < positions_m[-1]:  # not when the way to the next speed is lost in rounding
            positions_m.append(to_m)
            squares.append(w)
    return _Envelope(positions_m[::-1], squares[::-1])


def _drive(
    trip: Trip, cell: _Cell, envelope: _Envelope, step_m: float, w: float, watch: Callable[[], None]
) -> tuple[float, float]:
    """Duration of a cell, s, and squared speed at its end, by forward steps under its envelope."""
    time_s, x_m = 0.0, cell.start_m
    while x_m < cell.end_m:
        watch()
        index = envelope.segment(x_m)
        slope = 2.0 * _acceleration_mps2(trip, cell, w)
        if w >= envelope.at(x_m) * (1.0 - _ON_ENVELOPE) and slope >= envelope.slope(index):
            next_m, next_w = envelope.x_m[index + 1], envelope.w[index + 1]
        else:
            next_m, next_w = _step(cell, envelope, x_m, w, slope, step_m)
        speeds_mps = math.sqrt(w) + math.sqrt(max(next_w, 0.0))
        if next_w < 0.0 or speeds_mps == 0.0:
            return math.inf, 0.0
        time_s += 2.0 * (next_m - x_m) / speeds_mps
        x_m, w = next_m, next_w
    return time_s, w


def _step(cell: _Cell, envelope: _Envelope, x_m: float, w: float, slope: float, step_m: float) -> tuple[float, float]:
    """Position and squared speed after one step, or where it meets the envelope before."""
    end_m = min(x_m + step_m, cell.end_m)
    for index in range(envelope.segment(x_m), len(envelope.x_m) - 1):
        from_m, to_m = max(envelope.x_m[index], x_m), min(envelope.x_m[index + 1], end_m)
        if from_m >= end_m:
            break
        closing = slope - envelope.slope(index)
        gap = envelope.at(from_m) - (w + slope * (from_m - x_m))
        if closing > 0.0 and gap < closing * (to_m - from_m):
            meets_m = from_m + max(gap, 0.0) / closing
            return meets_m, envelope.at(meets_m)
    return end_m, w + slope * (end_m - x_m)


def _acceleration_mps2(trip: Trip, cell: _Cell, w: float) -> float:
    """Acceleration at full traction."""
    train, speed_mps = trip.train, math.sqrt(w)
    effort_n = train.traction_limit.effort_n(speed_mps) if cell.powered else 0.0
    load_n = _load_n(trip, cell, speed_mps)
    return min((effort_n - load_n) / train.inertia_kg, max(train.max_acceleration_mps2, -load_n / train.inertia_kg))


def _deceleration_mps2(trip: Trip, cell: _Cell, w: float) -> tuple[float, float]:
    """Deceleration at full braking, and the squared speed up to which it holds at most, m²/s²."""
    train, speed_mps = trip.train, math.sqrt(w)
    if not train.braking_rates:
        brake_n = train.friction_brake_n + (train.dynamic_brake_limit.effort_n(speed_mps) if cell.powered else 0.0)
        load_n = _load_n(trip, cell, speed_mps)
        comfortable_mps2 = max(train.max_deceleration_mps2, load_n / train.inertia_kg)
        return min((brake_n + load_n) / train.inertia_kg, comfortable_mps2), math.inf
    starts_w = [rate.from_mps**2 for rate in train.braking_rates]
    index = bisect_right(starts_w, w) - 1
    change_w = starts_w[index + 1] if index + 1 < len(starts_w) else math.inf
    return min(train.braking_rates[index].deceleration_mps2, train.max_deceleration_mps2), change_w


def _load_n(trip: Trip, cell: _Cell, speed_mps: float) -> float:
    """Running resistance and grade, N."""
    train = trip.train
    return train.davis_a_n + speed_mps * (train.davis_b_n_per_mps + speed_mps * cell.air) + cell.grade_n
