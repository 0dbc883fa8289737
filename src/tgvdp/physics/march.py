"""Driving through a uniform cell under a saturated regime, in rows of constant acceleration.

A row is chosen by its end speed, never by its length: the mean net force between two speeds does not depend on the
length of the row, so the length follows in closed form,

    d = ½·m_eff·(w1 − w0) / (mean effort − mean resistance − G).

Rows are short enough that the effort limit changes by `STEP` at most within a row, so that the mean of a limit is
the limit, and that the duration is right to `TIME_RTOL`: if the net force changes by a share e between v0 and v1,
constant acceleration misses the duration by e/6·(v1 − v0)/(v0 + v1), most of all next to standstill. A row ends where
a comfort limit begins or ends to cut the effort, and at each break of its curve: its forces have another slope from
there on. The same function drives backwards (sign = −1), which is how braking curves are made.
"""

import math
from typing import NamedTuple

from tgvdp._jit import kernel, leaf, part
from tgvdp.physics.codes import BRAKING, COASTING, DYNAMIC, TRACTION
from tgvdp.physics.forces import effort_and_slope, mean_resistance, piece_at, piece_mean, resistance_at
from tgvdp.physics.motion import landed_from, net_force, net_force_at, net_of

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

#: A train that a drop of the effort curve holds runs this share of v² below the drop.
BELOW_DROP = 1e-9


class _Sizes(NamedTuple):
    """What limits the rows of a march in a cell.

    Attributes
    ----------
    effort, net : float
        Largest change of the effort limit, and of the net force, as shares.
    time : float
        Six times the share of its duration that a row may miss.
    drag, speed : float
        Change of speed that drag alone allows for: so much for the root of a newton of net force, and so much of the
        speed. Infinite where there is no drag.
    """

    effort: float
    net: float
    time: float
    drag: float
    speed: float


@leaf
def _sizes_of(air, rows):
    """Sizes of ``rows`` times as many rows as usual."""
    share = 1.0 / rows
    time = 6.0 * TIME_RTOL * share * share
    return _Sizes(STEP * share, NET_STEP * share, time, math.sqrt(time / air) if air > 0.0 else math.inf, 0.01 * share)


@leaf
def _net_slope(train, has_rate, air, v, net, effort_slope):
    """Derivative by speed, N/(m/s), of the net force ``net``; 0 where a braking rate binds.

    Where a comfort limit does, that of the resistance: rows must be so short that a constant effort drives them, too.
    """
    if net >= train.inertia_kg * train.max_acceleration or -net >= train.inertia_kg * train.max_deceleration:
        return -train.davis_b
    if has_rate:
        return 0.0
    return effort_slope - (train.davis_b + 2.0 * air * v)


@leaf
def _speed_step(sizes, slope, v, net):
    """Change of speed in a row for its share of the duration, where the net force is ``net`` and its slope ``slope``.

    Solves e·step/(2·v + step)/6 = share for e = slope·step/net, and for the drag alone, e = air·step²/net.
    """
    step = math.inf
    if sizes.drag < math.inf:
        step = sizes.drag * math.sqrt(abs(net)) + sizes.speed * v
    if slope != 0.0:
        scale = abs(net / slope)
        q = sizes.time * scale
        step = min(step, 0.5 * (q + math.sqrt(q * (q + 8.0 * v))), sizes.net * scale)
    return step


@leaf
def _curve_end(sizes, table, i, extra, v, effort, slope, rising):
    """Speed at which the piece i of an effort curve has changed by its share, or ends if that comes first.

    The limit is that of the curve with the ``extra`` effort beside it: where the dynamic brake fades, friction stays.
    """
    last = i + 1 == table.shape[0]
    step = math.inf
    if slope != 0.0:
        step = sizes.effort * max((abs(effort) + extra) / abs(slope), 0.25 * v)
    if v == 0.0 and effort + extra == 0.0:  # a brake without effort at standstill
        step = math.inf if last else sizes.effort * table[i + 1, 0]
    if rising:
        return v + step if last else min(v + step, table[i + 1, 0])
    if i == 0 and not last and v <= sizes.effort * table[1, 0] and slope * v >= 0.5 * (effort + extra):
        return 0.0  # where such a brake has no effort: by shares of that a train would never come to its stand
    return max(v - step, table[i, 0])


@leaf
def _piece_from(table, i, v, rising):
    """The piece of an effort curve on the side to which a speed on its piece i changes."""
    return i - 1 if i > 0 and not rising and table[i, 0] >= v else i


@part
def _to_comfort(train, regime, cell, v, net, end):
    """Speed at the end of a row that is to end at one, or where a comfort limit begins or ends to cut the effort."""
    sense = 1.0 if regime == TRACTION else -1.0
    most = train.inertia_kg * (train.max_acceleration if regime == TRACTION else train.max_deceleration)
    cuts = sense * net >= most
    if (sense * net_force_at(train, regime, cell, end) >= most) == cuts:
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
    pulls = regime == TRACTION
    has_rate = not pulls and regime != COASTING and train.rates.shape[0] > 0
    has_curve = pulls or regime == DYNAMIC or (regime == BRAKING and not has_rate)
    table = train.traction if pulls else train.braking
    friction = train.friction_n if regime == BRAKING else 0.0
    comfort = train.max_acceleration if pulls else train.max_deceleration
    sizes = _sizes_of(cell.air, train.rows if pulls else train.rows * train.other_rows)
    v = math.sqrt(w)
    while True:
        if n < 0 or n >= xs.shape[0]:
            return x, w, -1
        i = 0
        effort = 0.0
        effort_slope = 0.0
        if has_curve:
            i = piece_at(table, v)
            effort, effort_slope = effort_and_slope(table, i, v)
        if has_rate:
            net = net_force_at(train, regime, cell, v)
        else:
            net = net_of(train, regime, resistance_at(train, cell.air, v) + cell.grade_n, effort + friction)
        rising = sign * net > 0.0
        if pulls and sign > 0.0 and net < 0.0:  # what is below counts: the effort may drop at v
            below = v * (1.0 - BELOW_DROP)
            net = net_force_at(train, regime, cell, below)
            if net >= 0.0:  # above the drop the train slows down, below it gains speed
                xs[n] = length_m
                ws[n] = w * (1.0 - BELOW_DROP)
                return length_m, ws[n], n + 1
        end = math.inf if rising else 0.0
        if has_curve:
            side = _piece_from(table, i, v, rising)
            if side != i:
                i = side
                effort, effort_slope = effort_and_slope(table, i, v)
            end = _curve_end(sizes, table, i, friction, v, effort, effort_slope, rising)
        if has_rate:
            rate = _piece_from(train.rates, piece_at(train.rates, v), v, rising)
            kept, _ = effort_and_slope(train.rates, rate, v)
            other = _curve_end(sizes, train.rates, rate, 0.0, v, kept, 0.0, rising)
            end = min(end, other) if rising else max(end, other)
        slope = _net_slope(
            train, has_rate and regime == BRAKING, cell.air, v, net, effort_slope if pulls else -effort_slope
        )
        balanced = sign * slope < 0.0 and abs(net) <= -sign * slope * BALANCED * v
        if rising and pulls and sign > 0.0 and w >= end * end * (1.0 - 2.0 * BELOW_DROP):
            balanced = net_force_at(train, regime, cell, end) <= 0.0
        if balanced:
            xs[n] = length_m
            ws[n] = w
            return length_m, w, n + 1
        step = _speed_step(sizes, slope, v, net)
        end = min(end, v + step) if rising else max(end, v - step)
        if comfort < math.inf and regime != COASTING and end < math.inf:
            end = _to_comfort(train, regime, cell, v, net, end)
        next_w = end * end
        if (rising and w < target_w < next_w) or (not rising and w > target_w > next_w):
            next_w = target_w
            end = math.sqrt(target_w)
        row_m = math.inf
        mean = sign * net
        if next_w != w and next_w < math.inf:
            if has_rate:
                mean = sign * net_force(train, regime, cell, v, end)
            else:
                load = mean_resistance(train, cell.air, v, end) + cell.grade_n
                pushed = friction
                if has_curve:
                    pushed += piece_mean(table, i, min(v, end), max(v, end))
                mean = sign * net_of(train, regime, load, pushed)
            if mean * (next_w - w) > 0.0:
                row_m = 0.5 * train.inertia_kg * (next_w - w) / mean
        if x + row_m < length_m:
            x += row_m
            w = next_w
            v = end
        else:
            # How the mean force changes with the speed that is reached.
            per_w = (mean - sign * net) / (next_w - w) if next_w != w and next_w < math.inf else 0.0
            per_force = 2.0 * (length_m - x) / train.inertia_kg
            guess = w + per_force * sign * net / max(1.0 - per_force * per_w, 0.5)
            landed = landed_from(train, regime, sign, cell, length_m - x, w, net, max(guess, 0.0))
            w = min(landed, next_w) if rising else max(landed, next_w)
            x = length_m
        xs[n] = x
        ws[n] = w
        n += 1
        if x >= length_m or w == target_w or w <= 0.0:
            return x, w, n
