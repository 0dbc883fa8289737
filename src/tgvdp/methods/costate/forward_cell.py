"""Drive through one cell by its switching speeds: rows that are exact, whatever the policy."""

import math

from tgvdp._jit import leaf, part
from tgvdp.constants import FEASIBILITY_RTOL
from tgvdp.physics.arc import OK, arc, duration_and_work
from tgvdp.physics.forces import mean_effort, mean_resistance, resistance_at
from tgvdp.physics.motion import BRAKING, COASTING, DYNAMIC, TRACTION, land, march
from tgvdp.runs.braking_point import braked_w, drive_then_brake

#: Where full effort would take less than this share of a cell, a change of speed is spread over the cell: it is a drift
#: of the holding speed.
_GENTLE_SHARE = 0.5
#: ... if it changes v² by no more than this share.
_DRIFT = 0.1
#: Two squared speeds nearer than this share are one speed that is held.
_HELD = 1e-5
#: Coasting takes so many rows in a cell per relative change of speed, so that a row's constant deceleration misses the
#: duration by 1e-6 or two; at most ...
_COAST_ROWS = 100.0
_MOST_COAST_ROWS = 4.0
#: Relative distance in v² within which a run is on the braking curve.
ON_CURVE = 1e-8
#: Share of a length within which two positions are one.
_SAME_PLACE = 1e-12


@leaf
def _pull(train, length, grade, air, w0, w1):
    """Share of full traction that takes the train from w0 to w1; infinite beyond its limits.

    Negative if it must brake, or would slow down on a climb by more than comfort allows.
    """
    if w0 + w1 <= 0.0:  # a train at a stand must be driven, if only by a hair
        return math.inf
    work = duration_and_work(train, length, grade, air, w0, w1)[1]
    slack = 1.0 + FEASIBILITY_RTOL
    if work < 0.0 or w0 - w1 > 2.0 * length * train.max_deceleration * slack:
        return -1.0
    effort = mean_effort(train.traction, math.sqrt(w0), math.sqrt(w1))
    if work > length * effort * slack or w1 - w0 > 2.0 * length * train.max_acceleration * slack:
        return math.inf
    return work / (length * effort) if work > 0.0 else 0.0


@part
def _append(x, w, xs, ws, n):
    xs[n] = x
    ws[n] = w
    return n + 1


@part
def coast(train, length, grade, air, w):
    """`land` under coasting, without its generality: the resistance is nearly linear in w1, three sweeps solve it."""
    v = math.sqrt(w)
    factor = 2.0 * length / train.inertia_kg
    slope = 0.5 * air
    if v > 0.0:
        slope += 0.25 * train.davis_b / v
    damping = 1.0 / (1.0 + factor * slope)
    x = max(w - factor * damping * (resistance_at(train, air, v) + grade), 0.0)
    if train.davis_b > 0.0:
        for _ in range(2):
            load = mean_resistance(train, air, v, math.sqrt(x)) + grade
            x = max(x + damping * (w - factor * load - x), 0.0)
    gain = 0.5 * (x - w) / length
    if gain > train.max_acceleration or -gain > train.max_deceleration:
        return land(train, COASTING, 1.0, length, grade, air, w)
    return x


@part
def _saturated(train, regime, start, rest, end, grade, air, w, target, xs, ws, n):
    """Append the rows of one regime through the rest of a cell, or until a target speed is met."""
    first = n
    used, w, n = march(train, regime, 1.0, rest, grade, air, w, target, xs, ws, n)
    for i in range(first, n):
        xs[i] += start
    if used >= rest * (1.0 - _SAME_PLACE):
        xs[n - 1] = end
        used = rest
    return rest - used, w, n


@part
def _brake_late(train, regime, start, rest, end, grade, air, limit, w, top, bx, bw, xs, ws, n):
    """Drive in a regime from w and brake as late as possible to end at ``top``, where the regime would end above it."""
    braked = braked_w(train, BRAKING, grade, air, top, limit, rest, bx, bw)
    if w > braked * (1.0 + ON_CURVE):
        return _saturated(train, BRAKING, start, rest, end, grade, air, w, top, xs, ws, n)[2]
    return drive_then_brake(train, regime, BRAKING, start, end, rest, grade, air, limit, w, top, bx, bw, xs, ws, n)


@part
def _regenerate(train, start, rest, end, grade, air, limit, w, b, top, bx, bw, xs, ws, n):
    """Slow down to b, or to the envelope if that is lower, where coasting would end above it: by the dynamic brake.

    All brakes only where that one would leave the envelope.
    """
    target = min(b, top)
    status, _, work = arc(train, rest, grade, air, w, target)
    limit_n = mean_effort(train.braking, math.sqrt(w), math.sqrt(target))
    if status == OK and -work <= _GENTLE_SHARE * rest * limit_n:
        return _append(end, target, xs, ws, n)
    if w < target:  # the descent accelerates the train to b, where the dynamic brake holds it if it can
        left, w, n = _saturated(train, COASTING, start, rest, end, grade, air, w, target, xs, ws, n)
        start = end - left
        rest = left
        if rest <= 0.0:
            return n
    braked = braked_w(train, DYNAMIC, grade, air, target, limit, rest, bx, bw)
    if w <= braked * (1.0 + ON_CURVE):
        return drive_then_brake(
            train, COASTING, DYNAMIC, start, end, rest, grade, air, max(w, target), w, target, bx, bw, xs, ws, n
        )
    first = n
    landed, n = _saturated(train, DYNAMIC, start, rest, end, grade, air, w, target, xs, ws, n)[1:]
    if landed <= top * (1.0 + ON_CURVE):
        xs[n - 1] = end  # its rows may meet the target a hair before the braking curve does
        return n
    return _brake_late(train, DYNAMIC, start, rest, end, grade, air, limit, w, top, bx, bw, xs, ws, first)


@part
def _hold_to_line(train, start, length, end, grade, air, w, line, slope, top, xs, ws, n):
    """Append holding w until the line of switching has fallen to it, or to the end of the cell.

    Not where holding takes brakes, nor where the envelope falls below w. Returns as `_drive_to_line`.
    """
    rest = length
    held = length if slope >= 0.0 else min((w - line) / slope, length)
    if 0.0 <= _pull(train, length, grade, air, w, w) < math.inf and top >= w * (1.0 - ON_CURVE) and held > 0.0:
        rest = length - held if held < length * (1.0 - _SAME_PLACE) else 0.0
        n = _append(end - rest, w, xs, ws, n)
    return rest, w, n


@part
def _drive_to_line(train, start, length, end, grade, air, limit, w, line, slope, top, xs, ws, n):
    """Append full traction, and holding at the speed limit, from w up to the line of switching.

    Returns the rest of the cell, the squared speed and the number of rows.
    """
    if w >= limit * (1.0 - ON_CURVE):
        return _hold_to_line(train, start, length, end, grade, air, w, line, slope, top, xs, ws, n)
    most = min(limit, max(line, line + slope * length))
    left, landed, last = _saturated(train, TRACTION, start, length, end, grade, air, w, most, xs, ws, n)
    x0 = start
    below = line - w
    for i in range(n, last):
        excess = ws[i] - line - slope * (xs[i] - start)
        if excess >= 0.0:
            met = line + slope * (x0 + (xs[i] - x0) * below / (below + excess) - start)
            return _saturated(train, TRACTION, start, length, end, grade, air, w, met, xs, ws, n)
        x0 = xs[i]
        below = -excess
    if left <= 0.0:
        return left, landed, last
    return _hold_to_line(train, x0, left, end, grade, air, landed, landed + below, slope, top, xs, ws, last)


@part
def drive_cell(train, regenerates, start, end, length, grade, air, limit, w, a, coasts, b, top, bx, bw, xs, ws, n):
    """Append the rows of one cell from w.

    The line of switching between traction and coasting ends at a; a run that coasts from its start on ends at
    ``coasts``. b is where dynamic braking begins, ``top`` the envelope at the end.
    """
    if coasts < a:
        a = 0.5 * (a + coasts)
        coasts = a
    drop = 0.0
    if coasts > a * (1.0 + _HELD) or grade < 0.0:
        drop = 2.0 * length / train.inertia_kg * (resistance_at(train, air, math.sqrt(coasts)) + grade)
    # What the line falls by more than the end speed does: all that coasting loses, or nothing where a speed is held.
    steep = min(drop, coasts - a)
    line = coasts + steep
    rest = length
    aim = coasts
    if w < line * (1.0 - ON_CURVE):
        if 0.0 <= steep <= 0.5 * drop and line <= limit and w >= (1.0 - _DRIFT) * coasts:
            share = _pull(train, length, grade, air, w, coasts)
            if 0.0 <= share < _GENTLE_SHARE:
                return _append(end, coasts + share * (a - coasts), xs, ws, n)
        slope = (a - line) / length
        rest, w, n = _drive_to_line(train, start, length, end, grade, air, limit, w, line, slope, top, xs, ws, n)
        if rest <= 0.0:
            return n
        aim = a + rest / length * (coasts - a)
    start = end - rest
    share = _pull(train, rest, grade, air, w, aim)
    if 0.0 <= share < math.inf:
        return _append(end, aim, xs, ws, n)
    if share > 0.0:
        return _saturated(train, TRACTION, start, rest, end, grade, air, w, math.inf, xs, ws, n)[2]
    landed = coast(train, rest, grade, air, w)
    if landed <= min(b, top) * (1.0 + ON_CURVE):
        rows = int(min(1.0 + _COAST_ROWS * abs(w - landed) / (w + landed), _MOST_COAST_ROWS))
        for i in range(1, rows + 1):
            w = landed if rows == 1 else coast(train, rest / rows, grade, air, w)
            xs[n] = start + i * rest / rows if i < rows else end
            ws[n] = w
            n += 1
        ws[n - 1] = min(w, b, top)  # a rounding error above, and braking would be a sliver
        return n
    if regenerates:
        return _regenerate(train, start, rest, end, grade, air, limit, w, b, top, bx, bw, xs, ws, n)
    return _brake_late(train, COASTING, start, rest, end, grade, air, limit, w, top, bx, bw, xs, ws, n)
