"""Brake in the interval of speeds, below those at which a run coasts, in which a dynamic brake that rises works."""

from tgvdp._jit import part
from tgvdp.methods.costate.forward_brakes import brakes_do
from tgvdp.methods.costate.forward_lines import Line, coast_to, height, meeting_place
from tgvdp.methods.costate.forward_rows import ON_CURVE, saturated
from tgvdp.methods.costate.step_held import HELD
from tgvdp.physics.cell import rest_of
from tgvdp.physics.codes import DYNAMIC


@part
def is_kept(train, cell, w, landed, lines):
    """Whether a run that is at the lower end of the interval is kept there by a part of the brake, down a descent.

    ``landed`` is where coasting leads, from the start of the lines on.
    """
    at_end = abs(w - lines.before_e) <= HELD * w and lines.e <= lines.top
    return at_end and landed > lines.e * (1.0 + ON_CURVE) and brakes_do(train, cell, w, lines.e, False, 1.0)


@part
def brake_between(train, cell, w, landed, lines, rows, n):
    """Append coasting from w down to the upper end of the interval, and dynamic braking to its lower one.

    ``landed`` is where coasting through the whole cell leads. Both ends go straight through the cell. Returns the rest
    of the cell, the squared speed and the number of rows.
    """
    length = cell.length_m
    x = 0.0
    if w > lines.before_g * (1.0 + ON_CURVE):
        if landed >= lines.g:
            return length, w, n
        upper = Line(length, lines.g, (lines.before_g - lines.g) / length, 0.0, 0.0)
        x = meeting_place(train, cell, w, upper, landed)
        w, n = coast_to(train, cell, x, w, height(upper, x), rows, n)
    lower_w = lines.before_e + x / length * (lines.e - lines.before_e)
    if w <= lower_w * (1.0 + ON_CURVE):
        return length - x, w, n
    return saturated(train, DYNAMIC, rest_of(cell, cell.start_m + x, length - x), w, lower_w, rows, n)
