"""Rows of one kind through a cell: of one regime, of one effort, of brakes applied as late as possible."""

import math

from tgvdp._jit import leaf, part
from tgvdp.constants import FEASIBILITY_RTOL
from tgvdp.physics.arc import arc, duration_and_work
from tgvdp.physics.cell import Cell, append, limited
from tgvdp.physics.codes import BRAKING, COASTING, OK, TRACTION
from tgvdp.physics.energy import FULL_EFFORT
from tgvdp.physics.forces import brake_at, least_effort, mean_brake, mean_effort, resistance_at
from tgvdp.physics.march import march
from tgvdp.physics.motion import net_force_at
from tgvdp.runs.braking_point import braking_curve, drive_onto, drive_then_brake
from tgvdp.runs.resistance_correction_kernel import NEARLY_FULL, cut_row, even_speeds, part_end

#: Coasting and partial effort take so many rows in a cell that their constant accelerations miss the duration by this
#: share, over the square of the train's `rows`, as those under full traction do over a run; at most ...
_TIME_RTOL = 3.2e-5
_MOST_ROWS = 24.0
#: ... in so many sweeps, each of which corrects the effort of all rows by what the last one would have to make up for.
_EFFORT_SWEEPS = 3
#: Rows of nearly full braking whose limit changes along a cell.
_BRAKING_ROWS = 4
#: Steps of Newton's rule that find where coasting leads, at most; one that changes v² by this share leaves less than
#: 1e-10 of it. Most take one; from next to a standstill down a steep gradient it takes ten.
_COAST_STEPS = 30
_COAST_RTOL = 2e-5
#: Relative distance in v² within which a run is on the braking curve.
ON_CURVE = 1e-8
#: Share of a length within which two positions are one.
SAME_PLACE = 1e-12


@leaf
def pull(train, cell, w0, w1):
    """Share of full traction that takes the train from w0 to w1; infinite beyond limits, negative if it must brake."""
    if w0 + w1 <= 0.0:  # a train at a stand must be driven, if only by a hair
        return math.inf
    length = cell.length_m
    work = duration_and_work(train, length, cell.grade_n, cell.air, w0, w1)[1]
    slack = 1.0 + FEASIBILITY_RTOL
    if work <= 0.0:
        return -1.0 if work < 0.0 else 0.0
    effort = mean_effort(train.traction, math.sqrt(w0), math.sqrt(w1))
    if work > length * effort * slack or w1 - w0 > 2.0 * length * train.max_acceleration * slack:
        return math.inf
    return work / (length * effort)


@leaf
def rows_needed(train, air, length, w0, w1):
    """Rows that a change of squared speed at one effort takes over a length.

    Constant acceleration misses the duration by e/6·(v1 − v0)/(v0 + v1), where e is the change of the resistance as a
    share of the net force ½·m·(w1 − w0)/d, and by 1/n² of that in n rows.
    """
    both = math.sqrt(w0) + math.sqrt(w1)
    missed = length * abs(w1 - w0) * (train.davis_b / both + air) / (3.0 * train.inertia_kg * both * both)
    return int(min(_MOST_ROWS, 1.0 + train.rows * math.sqrt(missed / _TIME_RTOL)))


@leaf
def _slope(train, air, v):
    """Derivative of a row's mean resistance by the squared speed at its end, N/(m/s)², at a speed."""
    return 0.5 * air + (0.25 * train.davis_b / v if v > 0.0 else 0.0)


@part
def coast_on(train, cell, length, w):
    """`land` under coasting, without its generality: the resistance is nearly linear in w1, one step solves it.

    Where the train comes to a stand on the way it is below 0, by as much as the load would still take.
    """
    v = math.sqrt(w)
    factor = 2.0 * length / train.inertia_kg
    slope = _slope(train, cell.air, v)
    damping = 1.0 / (1.0 + factor * slope)
    x = w - factor * damping * (resistance_at(train, cell.air, v) + cell.grade_n)
    if train.davis_b > 0.0:
        for _ in range(_COAST_STEPS):
            v1 = math.sqrt(max(x, 0.0))
            both = v + v1
            per = 1.0 / both if both > 0.0 else 0.0
            linear = train.davis_b * (2.0 / 3.0) * (both - v * v1 * per)  # as of `mean_resistance`
            load = train.davis_a_n + linear + 0.5 * cell.air * (w + v1 * v1) + cell.grade_n
            steeper = 0.5 * cell.air + train.davis_b * (both + v) * per * per / 3.0 - slope
            step = damping / (1.0 + damping * factor * steeper) * (w - factor * load - x)
            x += step
            if abs(step) <= _COAST_RTOL * abs(x):
                break
    return x


@leaf
def coast(train, cell, length, w):
    """Squared speed to which coasting leads over a length; 0 where the train comes to a stand."""
    return max(coast_on(train, cell, length, w), 0.0)


@leaf
def _gives(train, cell, effort, v0, v1):
    """Whether a train gives an effort at all speeds between two, within its comfort limits."""
    lo = min(v0, v1)
    hi = max(v0, v1)
    least = resistance_at(train, cell.air, lo) + cell.grade_n
    most = resistance_at(train, cell.air, hi) + cell.grade_n
    if effort >= 0.0:
        comfortable = effort == 0.0 or effort - least <= train.inertia_kg * train.max_acceleration
        return comfortable and effort <= least_effort(train.traction, lo, hi)
    if effort - most < -train.inertia_kg * train.max_deceleration:
        return False
    if train.rates.shape[0] > 0:  # rates leave less to the brakes the more the load slows down
        return -effort <= max(least_effort(train.rates, lo, hi) - most, 0.0)
    return -effort <= least_effort(train.braking, lo, hi) + train.friction_n


@part
def saturated(train, regime, cell, w, target, rows, n):
    """Append the rows of one regime through a cell, or until a target speed is met; returns what is left of it.

    Without room for them nothing is left, and their number is −1.
    """
    first = n
    used, w, n = march(train, regime, 1.0, cell, cell.length_m, w, target, rows, n)
    if n < 0:
        return 0.0, w, n
    for i in range(first, n):
        rows.x[i] += cell.start_m
    if used >= cell.length_m * (1.0 - SAME_PLACE):
        rows.x[n - 1] = cell.end_m
        used = cell.length_m
    return cell.length_m - used, w, n


@leaf
def ended(cell, target, rows, first, n):
    """Let the last of a cell's rows, from ``first`` on, end where the cell does, at the target; returns their number.

    What they lack of it is shared by all of them: the last one may be short, and its effort beyond the limit then.
    """
    if n > first:
        lacking = (target - rows.w[n - 1]) / (cell.end_m - cell.start_m)
        for i in range(first, n - 1):
            rows.w[i] += lacking * (rows.x[i] - cell.start_m)
        rows.x[n - 1] = cell.end_m
        rows.w[n - 1] = target
    return n


@part
def _in_parts(train, cell, effort, w, target, rows, n):
    """Append rows of one effort through a cell, near one that takes a single row; returns that effort and their number.

    An effort that one row would pull, and several would brake, is none, nor is one that they would pull where it
    brakes: the other may not be allowed at all.
    """
    parts = rows_needed(train, cell.air, cell.length_m, w, target)
    factor = 2.0 * cell.length_m / train.inertia_kg
    per_effort = factor / (1.0 + factor * _slope(train, cell.air, math.sqrt(w)))
    pulls = effort >= 0.0
    driven = effort
    step = 0.0
    before = w
    last = n
    coasts = False
    for sweep in range(_EFFORT_SWEEPS if parts > 1 else 1):
        driven = effort
        pushed = Cell(cell.start_m, cell.end_m, cell.length_m, cell.grade_n - effort, cell.air, cell.limit_w)
        last = n
        landed = w
        for i in range(1, parts + 1):
            landed = coast(train, pushed, cell.length_m / parts, landed)
            last = append(cell.start_m + i * cell.length_m / parts, landed, rows, last)
        if sweep > 0 and step != 0.0 and landed != before:
            per_effort = (landed - before) / step
        step = (target - landed) / per_effort
        before = landed
        coasts = effort == 0.0
        if abs(target - landed) <= ON_CURVE * target:
            break
        effort = max(effort + step, 0.0) if pulls else min(effort + step, 0.0)
    if last > 0:
        rows.x[last - 1] = cell.end_m
        if parts == 1 or not coasts:
            rows.w[last - 1] = target
    return driven, last


@leaf
def _gives_share(train, cell, share, v):
    """Whether a train gives a share, below 0, of the limit of its brakes at a speed, within its comfort limits."""
    return _gives(train, cell, share * brake_at(train, 0.0, v), v, v)


@part
def _brake_by_share(train, cell, share, w, target, rows, n):
    """Append braking through a cell by a share, below 0, of what the brakes give; −1 where rows would take more.

    A single row may be within the limits as its mean drag is that of a straight line, and several rows not.
    """
    if not (_gives_share(train, cell, share, math.sqrt(w)) and _gives_share(train, cell, share, math.sqrt(target))):
        return -1
    first = n
    cut_row(train, (False, share), cell.air, cell.length_m, w, target, _BRAKING_ROWS, rows.w[n:])
    ends = even_speeds(_BRAKING_ROWS, w, target)
    used = 0.0
    for i in range(1, _BRAKING_ROWS + 1):
        before = w if n == first else rows.w[n - 1]
        length = part_end(ends, i) * cell.length_m - used
        if arc(train, length, cell.grade_n, cell.air, before, rows.w[n])[0] != OK:
            return -1
        used += length
        rows.x[n] = cell.start_m + used
        n += 1
    rows.x[n - 1] = cell.end_m
    return n


@part
def _brake_nearly_fully(train, cell, effort, w, target, rows, n):
    """Append braking through a cell by an effort that the brakes give at one end only, as their limit changes.

    It keeps its share of that limit; rows of full braking follow it, and the comfort limit. Else it is a single row.
    """
    full = mean_brake(train, 0.0, math.sqrt(w), math.sqrt(target))
    share = effort / full if full > 0.0 else 0.0
    if train.rates.shape[0] > 0 or share > -NEARLY_FULL:
        return append(cell.end_m, target, rows, n)
    if n < 0 or n + _BRAKING_ROWS > rows.x.shape[0]:
        return -1
    last = -1 if share <= -FULL_EFFORT else _brake_by_share(train, cell, share, w, target, rows, n)
    if last > 0:
        return last
    left, landed, last = saturated(train, BRAKING, cell, w, target, rows, n)
    if last < 0 or left <= (1.0 - FULL_EFFORT) * cell.length_m:
        return ended(cell, landed, rows, n, last)
    return append(cell.end_m, target, rows, n)


@part
def evenly(train, cell, w, target, scratch, rows, n):
    """Append rows of one effort through a cell; a single one, of one acceleration, where a limit is near.

    One that the train gives at one end only, or for a single row only, is full traction, and holding where that leads
    to, or coasting downhill; or full traction that slows down, or that is held by a drop of its effort before it comes
    there.
    """
    effort = duration_and_work(train, cell.length_m, cell.grade_n, cell.air, w, target)[1] / cell.length_m
    v0, v1 = math.sqrt(w), math.sqrt(target)
    if _gives(train, cell, effort, v0, v1):
        driven, last = _in_parts(train, cell, effort, w, target, rows, n)
        if last < 0 or _gives(train, cell, driven, v0, v1):
            return last
    if effort > 0.0:
        first = n
        share = pull(train, cell, target, target) if w < target else math.inf
        left, landed, n = saturated(train, TRACTION, cell, w, target, rows, n)
        if left <= (1.0 - FULL_EFFORT) * cell.length_m:
            # A hair below the target, where its rows take a little longer than one, or at a drop that leaves too little
            # traction above it; slowing down, to the target.
            return ended(cell, landed if w < target else target, rows, first, n)
        if share < 0.0:
            return drive_then_brake(train, TRACTION, COASTING, cell, w, target, scratch, rows, first)
        return append(cell.end_m, target, rows, n if share < math.inf else first)
    return _brake_nearly_fully(train, cell, effort, w, target, rows, n)


@part
def brake_late(train, regime, cell, w, top, scratch, rows, n):
    """Drive in a regime from w and brake as late as possible to end at ``top``, where the regime would end above it."""
    if net_force_at(train, regime, cell, math.sqrt(w)) < 0.0:  # it is nowhere faster: the curve of braking ends there
        cell = limited(cell, min(cell.limit_w, max(w, top)))
    curve = braking_curve(train, BRAKING, cell, top, scratch)
    if w > curve.start_w * (1.0 + ON_CURVE):  # where not even all brakes hold a train, it may pass that from below
        n = saturated(train, BRAKING, cell, w, top if w > top else 0.0, rows, n)[2]
        if n > 0:
            rows.x[n - 1] = cell.end_m
        return n
    return drive_onto(train, regime, BRAKING, cell, w, top, curve, scratch, rows, n)
