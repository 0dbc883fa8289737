"""Drive through one cell by its switching speeds: rows that are exact, whatever the policy."""

import math

from tgvdp._jit import leaf, part
from tgvdp.methods.costate.forward_brakes import NEAR, Lines, coast_through, coast_to, meeting_place
from tgvdp.methods.costate.forward_rows import (
    ON_CURVE,
    SAME_PLACE,
    coast,
    ended,
    evenly,
    pull,
    saturated,
)
from tgvdp.methods.costate.step_held import HELD
from tgvdp.physics.cell import Cell, append, rest_of
from tgvdp.physics.codes import BRAKING, TRACTION
from tgvdp.physics.energy import FULL_EFFORT
from tgvdp.physics.forces import effort_at, resistance_at
from tgvdp.runs.braking_point import braked_w, drive_then_brake

#: A share of a cell below which traction that ends before it ends with it: the error of its rows in what is left would
#: be an effort of its own.
_LITTLE = 1e-4


@part
def _hold_to_line(cell, w, share, line, slope, top, rows, n):
    """Append holding w until the line of switching has fallen to it, or to the end of the cell.

    ``share`` is the `pull` that takes. Not where it is that of brakes, or more than there is, nor where the envelope
    falls below w. Returns as `_drive_to_line`.
    """
    length = cell.length_m
    rest = length
    held = length if slope >= 0.0 else min((w - line) / slope, length)
    if 0.0 <= share < math.inf and top >= w * (1.0 - ON_CURVE) and held > 0.0:
        rest = length - held if held < length * (1.0 - SAME_PLACE) else 0.0
        n = append(cell.end_m - rest, w, rows, n)
    return rest, w, n


@part
def _drive_to_line(train, cell, w, line, slope, top, rows, n):
    """Append full traction, and holding at the speed limit, from w up to the line of switching.

    Returns the rest of the cell, the squared speed and the number of rows.
    """
    most = min(cell.limit_w, max(line, line + slope * cell.length_m))
    if w >= cell.limit_w * (1.0 - ON_CURVE):
        share = pull(train, cell, w, w)
        if share < math.inf:
            return _hold_to_line(cell, w, share, line, slope, top, rows, n)
        most = math.inf  # traction cannot hold it, and slows down
    left, landed, last = saturated(train, TRACTION, cell, w, most, rows, n)
    x0 = cell.start_m
    below = line - w
    for i in range(n, last):
        excess = rows.w[i] - line - slope * (rows.x[i] - cell.start_m)
        if excess >= 0.0:
            met = x0 + (rows.x[i] - x0) * below / (below + excess)
            driven = Cell(cell.start_m, met, met - cell.start_m, cell.grade_n, cell.air, cell.limit_w)
            left, landed, last = saturated(train, TRACTION, driven, w, most, rows, n)
            return cell.end_m - met + left, landed, last
        x0 = rows.x[i]
        below = -excess
    if left <= 0.0:
        return left, landed, last
    rest = rest_of(cell, x0, left)
    share = pull(train, rest, landed, landed)
    return _hold_to_line(rest, landed, share, landed + below, slope, top, rows, last)


@part
def _coast_to_line(train, cell, w, landed, line, slope, rows, n):
    """Append coasting from above the line of switching down to it, if it is met, and if traction can follow it.

    ``landed`` is where coasting through the whole cell leads. Returns the rest of the cell, the squared speed and the
    number of rows.
    """
    length = cell.length_m
    end_w = line + slope * length
    if end_w <= landed:
        return length, w, n
    x = meeting_place(train, cell, w, line, slope, landed)
    first = n
    met_w, n = coast_to(train, cell, x, w, line + slope * x, rows, n)
    if pull(train, rest_of(cell, cell.start_m + x, length - x), met_w, end_w) < math.inf:
        return length - x, met_w, n
    return length, w, first


@leaf
def coasted_from(train, cell, w):
    """Squared speed at the start of a cell from which coasting leads to w, nearly."""
    return w + 2.0 * cell.length_m / train.inertia_kg * (resistance_at(train, cell.air, math.sqrt(w)) + cell.grade_n)


@leaf
def _line_before(train, cell, lines):
    """Squared speed at which the line of switching begins a cell.

    Where it is the envelope, for it begins beyond and no blend tells where, it falls to its end as a run does that
    coasts, and by a' − a more than that; or it is the level of a speed that is held.
    """
    if lines.before_a != lines.before_top:
        return lines.before_a
    coasts = lines.coasts
    if lines.before_top <= coasts <= lines.a * (1.0 + HELD):
        v = math.sqrt(coasts)
        if 0.0 <= resistance_at(train, cell.air, v) + cell.grade_n <= effort_at(train.traction, v):
            return coasts
    return max(coasted_from(train, cell, coasts), lines.before_top)


@leaf
def _lines_of_rest(lines, share):
    """The lines of the last share of a cell, on which dynamic braking begins along a straight one."""
    return Lines(
        lines.before_a, lines.b + share * (lines.before_b - lines.b), lines.before_c, lines.before_top, lines.a,
        lines.coasts, lines.b, lines.c, lines.top,
    )  # fmt: skip


@part
def _passes(train, cell, w, top, scratch):
    """Whether not even all brakes keep a run through a cell from ending above the envelope, at ``top``."""
    too_fast = coast(train, cell, cell.length_m, w) > top * (1.0 + ON_CURVE)
    return too_fast and w > braked_w(train, BRAKING, cell, top, cell.length_m, scratch) * (1.0 + ON_CURVE)


@part
def _comes_under_traction(train, before, rows, n):
    """Whether a run comes out of the cell before under full traction, so that a little more of it is no new phase.

    Or under as much of it as its acceleration may be.
    """
    if n < 2:
        return True
    row = rest_of(before, rows.x[n - 2], rows.x[n - 1] - rows.x[n - 2])
    w0, w1 = rows.w[n - 2], rows.w[n - 1]
    most = 2.0 * row.length_m * train.max_acceleration
    return w1 - w0 >= FULL_EFFORT * most or FULL_EFFORT <= pull(train, row, w0, w1) < math.inf


@part
def drive_cell(train, regenerates, before, cell, w, lines, scratch, rows, n):
    """Append the rows of one cell from w: to the line of switching, and along it or above it from there on."""
    a = lines.a
    line = _line_before(train, cell, lines)
    length = cell.length_m
    slope = (a - line) / length
    rest = length
    landed = math.nan
    at_limit = w >= cell.limit_w * (1.0 - ON_CURVE)  # it is held for as long as it may be, and no phase is new
    below = w < line * (1.0 - (ON_CURVE if at_limit else NEAR))
    if not below and w < line * (1.0 - ON_CURVE):
        below = _comes_under_traction(train, before, rows, n)
    if below:
        first, start_w = n, w
        rest, w, n = _drive_to_line(train, cell, w, line, slope, lines.top, rows, n)
        if rest <= 0.0 or n < 0:
            return n
        last_m = rows.x[n - 1] - rows.x[n - 2]
        if rest <= _LITTLE * length and rest < last_m:  # the last row is longer by that
            rows.w[n - 1] += rest * (w - rows.w[n - 2]) / last_m
            return ended(cell, min(rows.w[n - 1], lines.top), rows, first, n)
        if _passes(train, rest_of(cell, cell.end_m - rest, rest), w, lines.top, scratch):
            return drive_then_brake(train, TRACTION, BRAKING, cell, start_w, lines.top, scratch, rows, first)
    elif w > line * (1.0 + NEAR):
        landed = coast(train, cell, length, w)
        rest, w, n = _coast_to_line(train, cell, w, landed, line, slope, rows, n)
    if n < 0:
        return n
    cell = rest_of(cell, cell.end_m - rest, rest)
    if rest != length or math.isnan(landed):
        landed = coast(train, cell, rest, w)
    aim = min(a, lines.top)
    if landed > aim:
        if rest != length and lines.b < lines.top:
            lines = _lines_of_rest(lines, rest / length)
        return coast_through(train, regenerates, cell, w, landed, lines, scratch, rows, n)
    if pull(train, cell, w, aim) < math.inf:
        return evenly(train, cell, w, aim, scratch, rows, n)
    return saturated(train, TRACTION, cell, w, math.inf, rows, n)[2]
