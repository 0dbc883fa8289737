"""Driving under a saturated regime: full traction, coasting, full braking, full dynamic braking.

The equation of motion in w = v² is dw/ds = 2·(F(v) − R(v) − G)/m_eff. `march` follows it through a uniform cell in
rows of constant acceleration. A row is chosen by its end speed, never by its length: the mean net force between two
speeds does not depend on the length of the row, so the length follows in closed form,

    d = ½·m_eff·(w1 − w0) / (mean effort − mean resistance − G).

Rows are short enough that the effort limit changes by `STEP` at most within a row, so that the mean of a limit is
the limit, and that the duration is right to `TIME_RTOL`: if the net force changes by a share e between v0 and v1,
constant acceleration misses the duration by e/6·(v1 − v0)/(v0 + v1), most of all next to standstill. A row ends where
a comfort limit begins or ends to cut the effort: its forces have another slope from there on.
The same function drives backwards (sign = −1), which is how braking curves are made.
"""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.physics.codes import BRAKING, COASTING, DYNAMIC, TRACTION
from tgvdp.physics.forces import (
    brake_at,
    effort_and_slope,
    effort_at,
    mean_brake,
    mean_effort,
    mean_resistance,
    piece_at,
    resistance_at,
)

#: Largest relative change of the effort limit within a row; halved, it bounds the pointwise excess over the limit.
STEP = 0.03

#: Largest relative error of a row's duration.
TIME_RTOL = 1e-4

#: Largest change of the net force within a row, as a share; and the share of the speed that is left of an approach to
#: the balancing speed when the train counts as balanced.
NET_STEP = 0.1
BALANCED = 1e-8

#: How often a change of speed is halved to find where a comfort limit begins or ends to cut the effort.
_HALVINGS = 30
#: ... and the share of the speed within which it does so at once.
_AT_ONCE = 1e-6

#: The share of w by which the last step of `land` may still change it, how many steps there are at most, and the share
#: of what there is to lose below which nothing is left.
_LANDED = 1e-9
_LANDINGS = 60
_STALLED = 1e-12

#: A train that a drop of the effort curve holds runs this share of v² below the drop.
BELOW_DROP = 1e-9


@leaf
def _net(train, regime, load, effort):
    """Net force in N of an effort and a load, which a comfort limit cuts: to none where the load alone does more."""
    if regime == TRACTION:
        return min(effort - load, max(train.inertia_kg * train.max_acceleration, -load))
    if regime == COASTING:
        return -load
    return max(-effort - load, min(-train.inertia_kg * train.max_deceleration, -load))


@leaf
def net_force(train, regime, cell, v0, v1):
    """Mean net force in N between two speeds under a saturated regime, within its comfort limit."""
    load = mean_resistance(train, cell.air, v0, v1) + cell.grade_n
    effort = 0.0
    if regime == TRACTION:
        effort = mean_effort(train.traction, v0, v1)
    elif regime == BRAKING:
        effort = mean_brake(train, load, v0, v1)
    elif regime == DYNAMIC:
        effort = mean_effort(train.braking, v0, v1)
        if train.rates.shape[0] > 0:
            effort = min(effort, mean_brake(train, load, v0, v1))
    return _net(train, regime, load, effort)


@leaf
def net_force_at(train, regime, cell, v):
    """`net_force` at one speed."""
    load = resistance_at(train, cell.air, v) + cell.grade_n
    effort = 0.0
    if regime == TRACTION:
        effort = effort_at(train.traction, v)
    elif regime == BRAKING:
        effort = brake_at(train, load, v)
    elif regime == DYNAMIC:
        effort = effort_at(train.braking, v)
        if train.rates.shape[0] > 0:
            effort = min(effort, brake_at(train, load, v))
    return _net(train, regime, load, effort)


@leaf
def _damping(train, cell, factor, v):
    """By what a step of `_landed` is to be divided: the resistance changes with the speed that is reached."""
    linear = 0.25 * train.davis_b / v if v > 0.0 else 0.0
    return max(1.0 + factor * (0.5 * cell.air + linear), 1.0)


@part
def _landed(train, regime, sign, cell, length_m, w, net, x):
    """`land` from a guess x on, where ``net`` is the net force at the start."""
    v = math.sqrt(w)
    factor = sign * 2.0 * length_m / train.inertia_kg
    damping = _damping(train, cell, factor, v)
    before_x = w
    before = w + factor * net
    stalls = _STALLED * (w + abs(factor * net))
    lo = 0.0
    hi = math.inf
    for _ in range(_LANDINGS):
        reached = w + factor * net_force(train, regime, cell, v, math.sqrt(x))
        if reached > x:
            lo = x
        else:
            hi = x
        slope = (reached - before) / (x - before_x) if x != before_x else 1.0 - damping
        before_x = x
        before = reached
        x += (reached - x) / min(max(1.0 - slope, 0.5), 2.0 * damping)
        if not lo <= x <= hi:  # the effort jumps on the way
            x = 0.5 * (lo + hi)
        if abs(x - before_x) <= _LANDED * x:
            return x
        if hi <= stalls:
            return 0.0
    return x


@kernel
def land(train, regime, sign, cell, length_m, w):
    """Squared speed after one row of the given length (sign = −1: before it); 0 if the train stalls.

    Solves x = w + sign·2·d/m_eff·net(w, x) to rounding by the secant rule, or by halves where an effort jumps: mostly
    the right side hardly depends on x. What is met from both sides has to be so near: where it was not (to 1e-8, by the
    slope of the resistance alone), runs left the curve of the dynamic brake at the end of each cell.
    """
    v = math.sqrt(w)
    factor = sign * 2.0 * length_m / train.inertia_kg
    net = net_force_at(train, regime, cell, v)
    guess = w + factor * net / _damping(train, cell, factor, v)
    return _landed(train, regime, sign, cell, length_m, w, net, max(guess, 0.0))


@leaf
def _net_slope(train, regime, air, v, net, effort_slope):
    """Derivative by speed, N/(m/s), of the net force ``net``; 0 where a braking rate binds.

    Where a comfort limit does, that of the resistance: rows must be so short that a constant effort drives them, too.
    """
    if net >= train.inertia_kg * train.max_acceleration or -net >= train.inertia_kg * train.max_deceleration:
        return -train.davis_b
    if regime == BRAKING and train.rates.shape[0] > 0:
        return 0.0
    return effort_slope - (train.davis_b + 2.0 * air * v)


@leaf
def _speed_step(slope, air, v, net, rows):
    """Change of speed in a row for `TIME_RTOL`, where the net force is ``net`` and its slope ``slope``.

    For ``rows`` times as many rows.
    Solves e·step/(2·v + step)/6 = TIME_RTOL for e = slope·step/net, and for the drag alone, e = air·step²/net.
    """
    step = math.inf
    share = 6.0 * TIME_RTOL / (rows * rows) * abs(net)
    if air > 0.0:
        step = math.sqrt(share / air) + 0.01 * v / rows
    if slope != 0.0:
        q = share / abs(slope)
        step = min(step, 0.5 * (q + math.sqrt(q * (q + 8.0 * v))), NET_STEP / rows * abs(net / slope))
    return step


@leaf
def _row_end(table, extra, v, rising, rows):
    """Speed at which the effort limit has changed by STEP, or the next break of the curve if that comes first.

    The limit is that of the curve with the ``extra`` effort beside it: where the dynamic brake fades, friction stays.
    Returns the slope of the curve, too, on the side to which the speed changes.
    """
    n = table.shape[0]
    i = piece_at(table, v)
    if i > 0 and not rising and table[i, 0] >= v:
        i -= 1
    effort, slope = effort_and_slope(table, i, v)
    step = math.inf
    if slope != 0.0:
        step = STEP * max((abs(effort) + extra) / abs(slope), 0.25 * v) / rows
    if v == 0.0 and effort + extra == 0.0:  # a brake without effort at standstill
        step = STEP / rows * table[i + 1, 0] if i + 1 < n else math.inf
    if rising:
        return min(v + step, table[i + 1, 0]) if i + 1 < n else v + step, slope
    return max(v - step, table[i, 0]), slope


@leaf
def _to_comfort(train, regime, cell, v, net, end):
    """Speed at the end of a row that is to end at one, or where a comfort limit begins or ends to cut the effort."""
    sense = 1.0 if regime == TRACTION else -1.0
    most = train.inertia_kg * (train.max_acceleration if regime == TRACTION else train.max_deceleration)
    cuts = sense * net >= most
    if most == math.inf or (sense * net_force_at(train, regime, cell, end) >= most) == cuts:
        return end
    before = v
    after = end
    for _ in range(_HALVINGS):
        middle = 0.5 * (before + after)
        if (sense * net_force_at(train, regime, cell, middle) >= most) == cuts:
            before = middle
        else:
            after = middle
    return after if abs(after - v) > _AT_ONCE * v else end


@kernel
def march(train, regime, sign, cell, length_m, w, target_w, rows, n):
    """Drive through a uniform cell, for a length or until a target speed.

    Parameters
    ----------
    train : KernelTrain
    regime : int
        TRACTION, COASTING, BRAKING or DYNAMIC.
    sign : float
        1.0 drives forwards, −1.0 backwards.
    cell : Cell
    length_m : float
        How far at most, m.
    w, target_w : float
        Squared speed at the start, and where to stop if it is met, m²/s².
    rows : Rows, modified in place
        Ends of rows are appended from index ``n`` on: distance from the start of the march, squared speed.
    n : int

    Returns
    -------
    x_m, w : float
        Where the march ended; ``w`` is 0 when the train stalls (or, backwards, cannot have come from anywhere).
    n : int
        New number of entries; −1 when the buffers are full.
    """
    x = 0.0
    xs = rows.x
    ws = rows.w
    per_usual = train.rows if regime == TRACTION else train.rows * train.other_rows
    while True:
        if n < 0 or n >= xs.shape[0]:
            return x, w, -1
        v = math.sqrt(w)
        net = net_force_at(train, regime, cell, v)
        rising = sign * net > 0.0
        if regime == TRACTION and sign > 0.0 and net < 0.0:  # what is below counts: the effort may drop at v
            below = v * (1.0 - BELOW_DROP)
            net = net_force_at(train, regime, cell, below)
            if net >= 0.0:  # above the drop the train slows down, below it gains speed
                xs[n] = length_m
                ws[n] = w * (1.0 - BELOW_DROP)
                return length_m, ws[n], n + 1
        end = math.inf if rising else 0.0
        effort_slope = 0.0
        if regime == TRACTION:
            end, effort_slope = _row_end(train.traction, 0.0, v, rising, per_usual)
        elif regime != COASTING:
            if regime == DYNAMIC or train.rates.shape[0] == 0:
                friction = train.friction_n if regime == BRAKING else 0.0
                end, brake_slope = _row_end(train.braking, friction, v, rising, per_usual)
                effort_slope = -brake_slope
            if train.rates.shape[0] > 0:
                other = _row_end(train.rates, 0.0, v, rising, per_usual)[0]
                end = min(end, other) if rising else max(end, other)
        slope = _net_slope(train, regime, cell.air, v, net, effort_slope)
        balanced = sign * slope < 0.0 and abs(net) <= -sign * slope * BALANCED * v
        if rising and regime == TRACTION and sign > 0.0 and w >= end * end * (1.0 - 2.0 * BELOW_DROP):
            balanced = net_force_at(train, regime, cell, end) <= 0.0
        if balanced:
            xs[n] = length_m
            ws[n] = w
            return length_m, w, n + 1
        step = _speed_step(slope, cell.air, v, net, per_usual)
        end = min(end, v + step) if rising else max(end, v - step)
        if regime != COASTING and end < math.inf:
            end = _to_comfort(train, regime, cell, v, net, end)
        next_w = end * end
        if rising and w < target_w:
            next_w = min(next_w, target_w)
        elif not rising and w > target_w:
            next_w = max(next_w, target_w)
        row_m = math.inf
        per_w = 0.0  # how the mean force changes with the speed that is reached
        if next_w != w and next_w < math.inf:
            mean = sign * net_force(train, regime, cell, v, math.sqrt(next_w))
            per_w = (mean - sign * net) / (next_w - w)
            if mean * (next_w - w) > 0.0:
                row_m = 0.5 * train.inertia_kg * (next_w - w) / mean
        if x + row_m < length_m:
            x += row_m
            w = next_w
        else:
            per_force = 2.0 * (length_m - x) / train.inertia_kg
            guess = w + per_force * sign * net / max(1.0 - per_force * per_w, 0.5)
            landed = _landed(train, regime, sign, cell, length_m - x, w, net, max(guess, 0.0))
            w = min(landed, next_w) if rising else max(landed, next_w)
            x = length_m
        xs[n] = x
        ws[n] = w
        n += 1
        if x >= length_m or w == target_w or w <= 0.0:
            return x, w, n
