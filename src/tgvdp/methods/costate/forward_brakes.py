"""Coast and brake through one cell, above its line of switching: by the dynamic brake, by all brakes."""

import math

from tgvdp._jit import leaf, part
from tgvdp.methods.costate.brake_jumps import drop_above, is_drop
from tgvdp.methods.costate.forward_lines import Line, coast_to, height, meeting_place
from tgvdp.methods.costate.forward_rows import (
    ON_CURVE,
    brake_late,
    coast,
    ended,
    evenly,
    rows_needed,
    saturated,
)
from tgvdp.methods.costate.step_held import HELD
from tgvdp.physics.arc import arc
from tgvdp.physics.cell import append, begin_of, limited, rest_of
from tgvdp.physics.codes import BRAKING, COASTING, DYNAMIC, OK
from tgvdp.physics.energy import FULL_EFFORT
from tgvdp.physics.forces import mean_effort
from tgvdp.physics.march import march
from tgvdp.runs.braking_point import braked_w, drive_then_brake, emit_driven

#: Changes of v² by less than this share within a cell are a drift of the holding speed, spread over the cell.
_DRIFT = 0.01
#: The line of all brakes may rise by this share within a cell for a run to keep to it: where it rises faster, friction
#: ends somewhere within the cell.
_RISE = 5e-3
#: A run that enters a cell nearer to the line of switching than this share of v² is on it; but full traction goes on up
#: to the line, or the running time would jump where it ends next to a station.
NEAR = 1e-3
#: Coasting that ends above a limit by less than this share of v² brakes a little all the way, which takes longer by a
#: quarter of that share: brakes for the last hand's breadth would be none that one applies.
_TOUCH = 1e-4
#: What rows of dynamic braking are amiss is shared by them up to this share of what they brake: as much more effort.
_AMISS = 5e-4
#: Halvings of the distance over which all brakes work before the dynamic one alone does: to rounding.
_HALVINGS = 40


@leaf
def _drifts(before, after, w):
    """Whether a line of switching, and a run on it or above it, change so little that they are a speed that is held.

    From below a run coasts up to the line.
    """
    near = _DRIFT * after
    return abs(before - after) <= near and w - after <= near and w >= before * (1.0 - NEAR)


@leaf
def _follows(lines, after, w):
    """Whether a run is on the line of all brakes, which ends the cell at ``after``, and keeps to it if it can."""
    near = _DRIFT * after
    known = lines.before_c < lines.before_top or abs(lines.before_c - after) <= near
    return known and after - lines.before_c <= _RISE * after and abs(w - lines.before_c) <= near


@part
def brakes_do(train, cell, w, target, friction, share):
    """Whether brakes take the train through a cell at one effort: a share of the dynamic one, or with ``friction``.

    A drop of the dynamic brake within it is none for one effort.
    """
    status, _, work = arc(train, cell.length_m, cell.grade_n, cell.air, w, target)
    dynamic = cell.length_m * mean_effort(train.braking, math.sqrt(w), math.sqrt(target))
    return status == OK and (friction or (-work <= share * dynamic and drop_above(train, target) >= w))


@part
def _hold_then_regenerate(train, cell, w, target, rows, n):
    """Append a speed that all brakes hold for as long as the dynamic one alone may still end at ``target``, and that.

    Where friction ends within a cell in which it held a speed. Returns the number of rows: none more if that leads
    nowhere.
    """
    used_m, met_w, _ = march(train, DYNAMIC, -1.0, cell, cell.length_m, target, w, rows, n)
    held_m = cell.length_m - used_m
    held = begin_of(cell, cell.start_m + held_m, held_m)
    if met_w != w or held_m <= 0.0 or not brakes_do(train, held, w, w, True, 1.0):
        return n
    n = append(held.end_m, w, rows, n)
    if n < 0:
        return n
    rest = rest_of(cell, held.end_m, used_m)
    last = saturated(train, DYNAMIC, rest, w, target, rows, n)[2]
    return ended(rest, target, rows, n, last)


@part
def _brake_fully(train, regime, cell, w, lines, scratch, rows, n):
    """Drive in a regime that would end above c, or above the envelope if that is lower, and with all brakes end there.

    A run that is on the line of all brakes keeps to it; elsewhere c is held, if all brakes can, and the envelope is
    met as late as possible.
    """
    target = min(lines.c, lines.top)
    if lines.c < lines.top:
        if _follows(lines, target, w) and brakes_do(train, cell, w, target, True, 1.0):
            return evenly(train, cell, w, target, scratch, rows, n)
        if regime == DYNAMIC and min(lines.before_c, lines.before_top) * (1.0 - NEAR) <= w < target:
            first = n
            n = _hold_then_regenerate(train, cell, w, target, rows, first)
            if n != first:
                return n
        cell = limited(cell, max(w, lines.c))
    drop_w = drop_above(train, target)
    if regime == DYNAMIC and drop_w < w:  # below it the dynamic brake alone
        used_m, met_w, _ = march(train, DYNAMIC, -1.0, cell, cell.length_m, target, drop_w, scratch, 0)
        if met_w == drop_w:
            met_m = cell.end_m - used_m
            above = begin_of(cell, met_m, met_m - cell.start_m)
            if w <= braked_w(train, BRAKING, above, drop_w, above.length_m, scratch) * (1.0 + ON_CURVE):
                n = brake_late(train, regime, above, w, drop_w, scratch, rows, n)
                below = rest_of(cell, met_m, used_m)
                last = saturated(train, DYNAMIC, below, drop_w, target, rows, n)[2]
                return ended(below, target, rows, n, last)
    return brake_late(train, regime, cell, w, target, scratch, rows, n)


@part
def _coast_then_regenerate(train, cell, w, lines, rows, n):
    """Append coasting, and holding the speed limit, up to the line of dynamic braking, and that from there on.

    The line is a straight one. Returns where it ends, and the number of rows.
    """
    length = cell.length_m
    line = Line(length, lines.b, (lines.before_b - lines.b) / length, 0.0, 0.0)
    x = meeting_place(train, cell, w, line, coast(train, cell, length, w))
    if height(line, x) > cell.limit_w:
        x = (lines.before_b - cell.limit_w) / line.rise
        n = emit_driven(train, COASTING, cell, x, w, rows, n)
        w = cell.limit_w
    else:
        w, n = coast_to(train, cell, x, w, height(line, x), rows, n)
    if n < 0:
        return math.inf, n
    return saturated(train, DYNAMIC, rest_of(cell, cell.start_m + x, length - x), w, 0.0, rows, n)[1:]


@part
def _brake_to_drop(train, cell, w, drop_w, rows, n):
    """Append all brakes down to a speed at which the dynamic brake drops, and that alone from there on.

    Returns where that ends, and the number of rows.
    """
    left, landed, n = saturated(train, BRAKING, cell, w, drop_w, rows, n)
    if left > 0.0 and n > 0:
        _, landed, n = saturated(train, DYNAMIC, rest_of(cell, cell.end_m - left, left), landed, 0.0, rows, n)
        if n > 0:
            rows.x[n - 1] = cell.end_m
    return landed, n


@part
def _brake_then_regenerate(train, cell, w, target, scratch, rows, n):
    """All brakes for as long as the dynamic one alone would end above a squared speed, and that from there on."""
    low, high = 0.0, cell.length_m
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        met_w = march(train, BRAKING, 1.0, cell, middle, w, 0.0, scratch, 0)[1]
        rest = rest_of(cell, cell.start_m + middle, cell.length_m - middle)
        if march(train, DYNAMIC, 1.0, rest, rest.length_m, met_w, 0.0, scratch, 0)[1] > target:
            low = middle
        else:
            high = middle
    first = n
    above = begin_of(cell, cell.start_m + high, high)
    _, landed, n = saturated(train, BRAKING, above, w, 0.0, rows, n)
    if n > 0:
        rest = rest_of(cell, cell.start_m + high, cell.length_m - high)
        n = saturated(train, DYNAMIC, rest, landed, 0.0, rows, n)[2]
    return ended(cell, target, rows, first, n)


@part
def _regenerate(train, cell, w, coasted, lines, scratch, rows, n):
    """Slow down to b, or to the envelope if that is lower, where coasting would end above it: by the dynamic brake.

    All brakes only where that one would end above c, or leave the envelope.
    """
    target = min(lines.b, lines.top)
    helps = w > lines.c and (w > lines.before_c * (1.0 + HELD) or lines.before_c >= lines.before_top)
    if helps and lines.c < lines.top and is_drop(train, lines.c):
        landed, last = _brake_to_drop(train, cell, w, lines.c, rows, n)
        if last < 0 or target * (1.0 - ON_CURVE) <= landed <= lines.top * (1.0 + ON_CURVE):
            return last
        if landed < target < saturated(train, DYNAMIC, cell, w, 0.0, rows, n)[1]:
            return _brake_then_regenerate(train, cell, w, target, scratch, rows, n)
    # A line that falls from the envelope is no speed that was held: braking begins within the cell.
    begins = lines.before_b >= lines.before_top and target < lines.before_b * (1.0 - ON_CURVE)
    if not begins and _drifts(lines.before_b, target, w) and brakes_do(train, cell, w, target, False, 1.0):
        if w <= target or brakes_do(train, cell, w, target, False, FULL_EFFORT):
            return evenly(train, cell, w, target, scratch, rows, n)
        # One effort would be more than the dynamic brake has where the train is faster, and friction would help it.
        left, landed, last = saturated(train, DYNAMIC, cell, w, target, rows, n)
        if last < 0 or (left <= (1.0 - FULL_EFFORT) * cell.length_m and landed <= target * (1.0 + HELD)):
            return ended(cell, target, rows, n, last)
    # By how much the curve of braking passes the run and its line at the start of the cell is of no account.
    enough = limited(cell, min(cell.limit_w, (1.0 + 4.0 * NEAR) * max(w, target, lines.before_b)))
    braked = braked_w(train, DYNAMIC, enough, target, cell.length_m, scratch)
    if lines.b < lines.top and lines.before_b > max(w, braked * (1.0 + NEAR)):
        first = n
        landed, n = _coast_then_regenerate(train, cell, w, lines, rows, n)
        if n < 0:
            return n
        if target <= landed <= min(lines.c, lines.top) * (1.0 + ON_CURVE):
            rows.x[n - 1] = cell.end_m
            return n
        n = first
    if 0.0 < braked and w <= braked * (1.0 + ON_CURVE):  # 0: it passes the target even from a standstill
        if w > max(target, braked * (1.0 - NEAR)):
            left, _, last = saturated(train, DYNAMIC, cell, w, target, rows, n)
            if last < 0 or left <= (1.0 - FULL_EFFORT) * cell.length_m:
                return ended(cell, target, rows, n, last)
        highest = max(w, target, min(lines.before_b, lines.before_top))
        held = limited(cell, highest)
        return drive_then_brake(train, COASTING, DYNAMIC, held, w, target, scratch, rows, n)
    first = n
    landed, n = saturated(train, DYNAMIC, cell, w, target if w > target else 0.0, rows, n)[1:]
    if n < 0:
        return n
    most = min(lines.c, lines.top)
    # Its rows may meet the braking curve a hair before it does, or behind: in a short cell a share of what they brake.
    if landed - most <= min(HELD * most, _AMISS * (coasted - landed)):
        return ended(cell, min(landed, most), rows, first, n)
    return _brake_fully(train, DYNAMIC, cell, w, lines, scratch, rows, first)


@part
def coast_through(train, regenerates, cell, w, landed, lines, scratch, rows, n):
    """Append the rows of one cell from w: coasting, and braking where that would end above b or the envelope.

    ``landed`` is where coasting leads.
    """
    rest = cell.length_m
    most = min(lines.b, lines.top)
    if landed <= most * (1.0 + ON_CURVE):
        parts = rows_needed(train, cell.air, rest, w, landed)
        first = n
        for i in range(1, parts + 1):
            w = landed if parts == 1 else coast(train, cell, rest / parts, w)
            n = append(cell.start_m + i * rest / parts if i < parts else cell.end_m, w, rows, n)
        # A rounding error above b, and braking would be a sliver; but what several rows lead to beyond one is none.
        if w <= most * (1.0 + ON_CURVE):
            w = min(w, most)
        return ended(cell, min(w, lines.top), rows, first, n)
    # A cell may be as short as that hand's breadth: by friction only the envelope is met.
    near = landed <= most * (1.0 + _TOUCH)
    if near and brakes_do(train, cell, w, most, lines.top <= lines.b, 1.0):
        return evenly(train, cell, w, most, scratch, rows, n)
    if regenerates:
        return _regenerate(train, cell, w, landed, lines, scratch, rows, n)
    return _brake_fully(train, COASTING, cell, w, lines, scratch, rows, n)
