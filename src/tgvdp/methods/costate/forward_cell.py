"""Drive through one cell by its switching speeds: rows that are exact, whatever the policy."""

import math

from tgvdp._jit import leaf, part
from tgvdp.methods.costate.characteristics import LEAST_MIDDLE, coasted, coasting_law
from tgvdp.methods.costate.forward_brakes import NEAR, coast_through
from tgvdp.methods.costate.forward_interval import brake_between, is_kept
from tgvdp.methods.costate.forward_lines import Line, Lines, coast_then_pull, coast_to, height, meeting_place
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
from tgvdp.physics.cell import Cell, append, limited, rest_of
from tgvdp.physics.codes import BRAKING, TRACTION
from tgvdp.physics.energy import FULL_EFFORT
from tgvdp.physics.forces import effort_at, resistance_at
from tgvdp.runs.braking_point import braked_w, drive_then_brake

#: A share of a cell below which traction or coasting that ends before it ends with it: the error of its rows in what is
#: left would be an effort of its own.
_LITTLE = 1e-4
#: A shorter row of traction gains more than its share of a longer one: the place where a run meets its line is looked
#: for so many times at most, until it is on it within this share of v².
_MEETINGS = 3
_MET = 1e-7
#: Steps of Newton's rule that find where a line, which is nearly a parabola, has fallen to a speed.
_FALLING_STEPS = 2


@leaf
def _falls_to(line, w):
    """Metres after which a line that starts above w has fallen to it, as on a parabola, and then by Newton's rule."""
    above = w - line.end_w
    steepness = line.rise * line.rise + 4.0 * line.bend * above
    if above <= 0.0 or line.rise <= 0.0 or steepness < 0.0:
        return line.length
    rest = 2.0 * above / (line.rise + math.sqrt(steepness))
    for _ in range(_FALLING_STEPS):
        excess = height(line, line.length - rest) - w
        rest -= excess / (line.rise + rest * (2.0 * line.bend + rest * 3.0 * line.twist))
    return min(max(line.length - rest, 0.0), line.length)


@part
def _hold_to_line(cell, w, share, line, top, rows, n):
    """Append holding w until the line of switching has fallen to it, or to the end of the cell.

    ``share`` is the `pull` that takes. Not where it is that of brakes, or more than there is, nor where the envelope
    falls below w. Returns as `_drive_to_line`.
    """
    length = cell.length_m
    rest = length
    held = _falls_to(line, w)
    if 0.0 <= share < math.inf and top >= w * (1.0 - ON_CURVE) and held > 0.0:
        rest = length - held if held < length * (1.0 - SAME_PLACE) else 0.0
        n = append(cell.end_m - rest, w, rows, n)
    return rest, w, n


@part
def _drive_to_line(train, cell, w, line, top, rows, n):
    """Append full traction, and holding at the speed limit, from w up to the line of switching.

    Returns the rest of the cell, the squared speed and the number of rows.
    """
    length = cell.length_m
    begins = height(line, 0.0)
    most = min(cell.limit_w, max(begins, line.end_w) + max(-line.bend, 0.0) * length * length)
    if w >= cell.limit_w * (1.0 - ON_CURVE):
        share = pull(train, cell, w, w)
        if share < math.inf:
            return _hold_to_line(cell, w, share, line, top, rows, n)
        most = math.inf  # traction cannot hold it, and slows down
    left, landed, last = saturated(train, TRACTION, cell, w, most, rows, n)
    x0 = cell.start_m
    below = begins - w
    for i in range(n, last):
        excess = rows.w[i] - height(line, rows.x[i] - cell.start_m)
        if excess >= 0.0:
            per_metre = (below + excess) / (rows.x[i] - x0)
            met = x0 + below / per_metre
            w0 = rows.w[i - 1] if i > n else w
            for _ in range(_MEETINGS):
                driven = Cell(x0, met, met - x0, cell.grade_n, cell.air, cell.limit_w)
                left, landed, last = saturated(train, TRACTION, driven, w0, most, rows, i)
                off = landed - height(line, met - left - cell.start_m)
                if last < 0 or abs(off) <= _MET * landed:
                    break
                met = min(max(met - off / per_metre, x0), cell.end_m)
            return cell.end_m - driven.end_m + left, landed, last
        x0 = rows.x[i]
        below = -excess
    if left <= 0.0:
        return left, landed, last
    rest = rest_of(cell, x0, left)
    share = pull(train, rest, landed, landed)
    ahead = Line(rest.length_m, line.end_w, line.rise, line.bend, line.twist)
    return _hold_to_line(rest, landed, share, ahead, top, rows, last)


@part
def _coast_to_line(train, cell, w, landed, line, rows, n):
    """Append coasting from above the line of switching down to it, or to where traction can still come to its end.

    ``landed``, below its end, is where coasting through the whole cell leads. Returns the rest of the cell, the squared
    speed and the number of rows.
    """
    length = cell.length_m
    x = meeting_place(train, cell, w, line, landed)
    first = n
    met_w, n = coast_to(train, cell, x, w, height(line, x), rows, n)
    if pull(train, rest_of(cell, cell.start_m + x, length - x), met_w, line.end_w) < math.inf:
        return length - x, met_w, n
    n = coast_then_pull(train, cell, w, x, line.end_w, rows, first)
    return (0.0 if n != first else length), w, n


@leaf
def _falls_by(train, cell, w):
    """By how much v² falls per metre where coasting through a cell ends at w, and how much more per m²/s² above it.

    As costates are carried back.
    """
    middle = w + cell.length_m / train.inertia_kg * (resistance_at(train, cell.air, math.sqrt(w)) + cell.grade_n)
    load = train.davis_a_n + cell.grade_n
    falls, more = coasting_law(train.davis_b, load, cell.air, max(middle, LEAST_MIDDLE * w), w)
    return falls / train.inertia_kg, more / train.inertia_kg


@leaf
def coasted_from(train, cell, w):
    """Squared speed at the start of a cell from which coasting leads to w, nearly."""
    falls, more = _falls_by(train, cell, w)
    return coasted(w, cell.length_m, falls, more)[0]


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
def _beginning(train, cell, lines, w):
    """Where the line of switching begins a cell that a run enters at w, and the speed beyond which it does not drive.

    Where the line comes to a speed that is held it begins beyond that, which is held until it has fallen to it.
    """
    begins = _line_before(train, cell, lines)
    if w <= lines.held * (1.0 + NEAR) < math.inf:
        from_w = coasted_from(train, cell, lines.coasts)
        if from_w > lines.coasts:
            return max(begins, from_w), min(cell.limit_w, lines.held)
    return begins, cell.limit_w


@leaf
def _line_of(train, cell, lines, begins):
    """The line of switching through a cell.

    A run that meets it coasts to a speed between a and a', evenly by the place: the line bends as coasting does.
    """
    length = cell.length_m
    bend = twist = 0.0
    if lines.coasts > lines.a:
        falls, more = _falls_by(train, cell, lines.a)
        extra = (lines.coasts - lines.a) / length
        bends = min(0.5 * (lines.coasts / lines.a - 1.0) / HELD, 1.0)  # blends of lines that do come to it evenly
        bend = bends * more * (0.5 * falls + extra)
        twist = bends * more * more * (falls / 6.0 + 0.5 * extra)
    rise = (begins - lines.a) / length
    bends_by = length * (bend + length * twist)
    if bends_by > 0.0:  # in a long cell it would fall below its end, and below 0
        part = min(max(rise, 0.0) / bends_by, 1.0)
        bend *= part
        twist *= part
        bends_by *= part
    return Line(length, lines.a, rise - bends_by, bend, twist)


@leaf
def _lines_of_rest(lines, share):
    """The lines of the last share of a cell, on which dynamic braking begins and ends along straight ones."""
    return Lines(
        lines.before_a, lines.b + share * (lines.before_b - lines.b), lines.before_c,
        lines.e + share * (lines.before_e - lines.e), lines.g + share * (lines.before_g - lines.g), lines.before_top,
        lines.a, lines.coasts, lines.b, lines.c, lines.e, lines.g, lines.top, lines.held,
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


@leaf
def _is_little(rest, length, rows, first, n):
    """Whether what is left of a cell is too little for a row, behind rows ``first`` to ``n`` − 1 of it."""
    return first < n and rest <= _LITTLE * length and rest < rows.x[n - 1] - rows.x[n - 2]


@leaf
def _lengthened(cell, rest, top, rows, first, n):
    """Make the last row longer by what is left of a cell; returns the number of rows."""
    rows.w[n - 1] += rest * (rows.w[n - 1] - rows.w[n - 2]) / (rows.x[n - 1] - rows.x[n - 2])
    return ended(cell, min(rows.w[n - 1], top), rows, first, n)


@part
def drive_cell(train, regenerates, before, cell, w, lines, scratch, rows, n):
    """Append the rows of one cell from w: to the line of switching, and along it or above it from there on."""
    a = lines.a
    begins, most = _beginning(train, cell, lines, w)
    length = cell.length_m
    rest = length
    landed = math.nan
    at_limit = w >= most * (1.0 - ON_CURVE)  # it is held for as long as it may be, and no phase is new
    below = w < begins * (1.0 - (ON_CURVE if at_limit else NEAR))
    if not below and w < begins * (1.0 - ON_CURVE):
        below = _comes_under_traction(train, before, rows, n)
    if below:
        first, start_w = n, w
        driven = limited(cell, most)
        line = _line_of(train, cell, lines, begins)
        rest, w, n = _drive_to_line(train, driven, w, line, lines.top, rows, n)
        if rest <= 0.0 or n < 0:
            return n
        if _is_little(rest, length, rows, first, n):
            return _lengthened(cell, rest, lines.top, rows, first, n)
        if _passes(train, rest_of(cell, cell.end_m - rest, rest), w, lines.top, scratch):
            return drive_then_brake(train, TRACTION, BRAKING, cell, start_w, lines.top, scratch, rows, first)
    elif w > begins * (1.0 + NEAR):
        landed = coast(train, cell, length, w)
        if landed < a:
            first = n
            line = _line_of(train, cell, lines, begins)
            rest, w, n = _coast_to_line(train, cell, w, landed, line, rows, n)
            if rest == 0.0 or n < 0:
                return n
            if _is_little(rest, length, rows, first, n):
                return _lengthened(cell, rest, lines.top, rows, first, n)
    if n < 0:
        return n
    cell = rest_of(cell, cell.end_m - rest, rest)
    if rest != length or math.isnan(landed):
        landed = coast(train, cell, rest, w)
    aim = min(a, lines.top)
    # Where the line falls as a run does that coasts, what that is short of it by a rounding takes no traction.
    if landed > aim or (landed > aim * (1.0 - HELD) and a < lines.top):
        if rest != length and lines.b < lines.top:
            lines = _lines_of_rest(lines, rest / length)
        if regenerates and (lines.g > lines.e or lines.before_g > lines.before_e):
            left, slower, last = brake_between(train, cell, w, landed, lines, rows, n)
            after = rest_of(cell, cell.end_m - left, left)
            if last < 0 or not _passes(train, after, slower, lines.top, scratch):  # else friction has to help before
                if left <= 0.0 or last < 0:
                    return last
                lines = _lines_of_rest(lines, left / cell.length_m)
                cell, w, n = after, slower, last
                landed = coast(train, cell, left, w)
                if is_kept(train, cell, w, landed, lines):
                    return evenly(train, cell, w, lines.e, scratch, rows, n)
        return coast_through(train, regenerates, cell, w, landed, lines, scratch, rows, n)
    if pull(train, cell, w, aim) < math.inf:
        return evenly(train, cell, w, aim, scratch, rows, n)
    return saturated(train, TRACTION, cell, w, math.inf, rows, n)[2]
