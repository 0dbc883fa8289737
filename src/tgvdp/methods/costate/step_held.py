"""Speeds that are held: the costate there, and those of runs that come to them within a cell and hold them."""

import math

from tgvdp._jit import part
from tgvdp.methods.costate.brake_jumps import saturated_image
from tgvdp.methods.costate.characteristics import coast_image
from tgvdp.methods.costate.polyline import insert
from tgvdp.physics.codes import COASTING

#: Squared speeds nearer than this share are one speed that is held, at which a line of switching is level.
HELD = 1e-5
#: Runs that come to a speed and hold it have costates at so many points per relative change of w, at most ...
_MEETING_PIECES = 8.0
_MOST_MEETING_PIECES = 8.0


@part
def hold(train, below, above, step, held, level, first, m, images):
    """Make the speed that is held a point of the images, if it lies before the ``first`` one; their new number.

    Runs come to it within the cell by a regime from ``below`` and by another from ``above``, and hold it from there on.
    """
    x, y = images
    if not x[first - 1] < held < x[first] or y[first] < level:
        return m
    at = first
    if y[first - 1] >= level and first > 1 and x[first - 2] == x[first - 1]:  # p jumps there, and from there on rises
        come_m = _coming_m(train, below, step, held, level, x[first - 1])
        y[first - 1] = max(min(_meeting_image(train, below, step, come_m, held, level)[1], level), y[first - 2])
    if y[first - 1] >= level:  # an edge, from which a run would switch to that speed only to hold it
        at = first - 1
        x[at] = held
    else:
        m = insert(images, m, first, held, level)
    if at + 1 < m:
        m = meet_region(train, above, step, held, level, at + 1, x[at + 1], images, m)
    if at > 0:
        m = meet_region(train, below, step, held, level, at, x[at - 1], images, m)
    return m


@part
def meet_region(train, regime, step, held, level, at, edge, images, m):
    """Insert costates of runs that come to a speed within the cell and hold it, before the image ``at``.

    They are between that speed, which one may move at no cost where they come to it, and an edge. A straight line would
    do next to it, but not down to a standstill. Returns the number of images.
    """
    pieces = math.ceil(min(_MEETING_PIECES * abs(held - edge) / held, _MOST_MEETING_PIECES))
    if pieces < 2:
        return m
    come_m = _coming_m(train, regime, step, held, level, edge)
    if come_m == 0.0:
        return m
    for i in range(1, pieces):
        w, p = _meeting_image(train, regime, step, i / pieces * come_m, held, level)
        if min(held, edge) < w < max(held, edge) and (p - level) * (w - held) >= 0.0:
            m = insert(images, m, at, w, p)
            at += 1 if edge > held else 0
    return m


@part
def _coming_m(train, regime, step, held, level, edge):
    """Over which length of the cell, at most, a run comes from an edge to a speed by a regime; 0 if it never does."""
    reached = _meeting_image(train, regime, step, step.length, held, level)[0]
    if (reached - held) * (edge - held) <= 0.0:
        return 0.0
    return step.length * min((edge - held) / (reached - held), 1.0)


@part
def _meeting_image(train, regime, step, length, held, level):
    if regime == COASTING:
        return coast_image(train, step, length, held, level)
    return saturated_image(train, regime, step, length, held, level)
