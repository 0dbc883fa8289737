"""Lines of switching through one cell, and where coasting meets them."""

import math
from typing import NamedTuple

from tgvdp._jit import leaf, part
from tgvdp.methods.costate.forward_rows import ON_CURVE, coast, coast_on, ended, rows_needed, saturated
from tgvdp.physics.cell import append, rest_of
from tgvdp.physics.codes import TRACTION
from tgvdp.physics.march import march
from tgvdp.physics.roots import Bracket, narrowed, secant

#: Full traction begins above a line that it cannot follow: the place is looked for so many times at most, until the run
#: ends on the line within this share of v².
_BEGINNINGS = 20
_LANDS = 1e-9
#: Coasting meets the line of switching after so many steps of the secant, at most: both are nearly straight.
_MEETING_STEPS = 20


class Lines(NamedTuple):
    """Lines of switching through one cell, in squared speeds, m²/s²: full traction below the first one, coasting above.

    Attributes
    ----------
    before_a, before_b, before_c, before_e, before_g, before_top : float
        Where traction ends, dynamic braking begins, all brakes do, the interval lies in which it works, too, and the
        envelope, at the start of the cell. The first two may lie beyond the envelope.
    a, b, c, e, g, top : float
        The same at its end.
    coasts : float
        Speed at the end of a run that coasts from the line's start on, a'.
    held : float
        Speed that is held up to the start of the cell, if the first line falls from there; infinite if not.
    """

    before_a: float
    before_b: float
    before_c: float
    before_e: float
    before_g: float
    before_top: float
    a: float
    coasts: float
    b: float
    c: float
    e: float
    g: float
    top: float
    held: float


class Line(NamedTuple):
    """A line through a cell, in squared speeds, m²/s²: polynomial of the distance from its end, in metres."""

    length: float
    end_w: float
    rise: float
    bend: float
    twist: float


@leaf
def height(line, x):
    """Squared speed of a line some metres after the start of its cell."""
    rest = line.length - x
    return line.end_w + rest * (line.rise + rest * (line.bend + rest * line.twist))


@part
def meeting_place(train, cell, w, line, landed):
    """Where in a cell coasting from w, which leads to ``landed``, meets a line that it crosses, from either side."""
    begins = height(line, 0.0)
    sense = 1.0 if w > begins else -1.0
    if landed == 0.0:  # beyond its standstill a train is as slow everywhere, which no secant can tell apart
        landed = coast_on(train, cell, cell.length_m, w)
    bracket = Bracket(0.0, cell.length_m, sense * (begins - w), sense * (line.end_w - landed), 0)
    x = 0.0
    for _ in range(_MEETING_STEPS):
        x = secant(bracket)
        below = height(line, x) - coast_on(train, cell, x, w)
        if abs(below) <= ON_CURVE * begins:
            break
        bracket = narrowed(bracket, x, sense * below)
    return x


@part
def coast_to(train, cell, x, w, line, rows, n):
    """Append the rows of coasting over the first x metres of a cell, nearly to a line; returns where, and how many."""
    parts = rows_needed(train, cell.air, x, w, line)
    for i in range(1, parts + 1):
        w = coast(train, cell, x / parts, w)
        n = append(cell.start_m + i * x / parts, w, rows, n)
    return w, n


@part
def coast_then_pull(train, cell, w, x, target, rows, n):
    """Append coasting, and full traction that slows down to ``target`` at the end of the cell: from before x on.

    Where a train that coasts meets its line at x traction may no longer hold it there. Returns the number of rows: none
    more where traction all the way would not do either.
    """
    full = march(train, TRACTION, 1.0, cell, cell.length_m, w, math.inf, rows, n)[1]
    met_w, late = coast(train, cell, x, w), rest_of(cell, cell.start_m + x, cell.length_m - x)
    least = march(train, TRACTION, 1.0, late, late.length_m, met_w, math.inf, rows, n)[1]
    if not full > target > least:
        return n
    bracket = Bracket(0.0, x, target - full, target - least, 0)
    for _ in range(_BEGINNINGS):
        x = secant(bracket)
        met_w, late = coast(train, cell, x, w), rest_of(cell, cell.start_m + x, cell.length_m - x)
        lacking = target - march(train, TRACTION, 1.0, late, late.length_m, met_w, math.inf, rows, n)[1]
        if abs(lacking) <= _LANDS * target:
            break
        bracket = narrowed(bracket, x, lacking)
    met_w, first = coast_to(train, cell, x, w, met_w, rows, n)
    if first < 0:
        return first
    last = saturated(train, TRACTION, late, met_w, math.inf, rows, first)[2]
    return ended(late, target, rows, first, last)
