"""The wall of the costate polyline, and curves of dynamic braking along which p jumps as it does at the wall.

Runs that come from below meet either of them somewhere within the cell. Their p is known there, and it is carried back
over the length that they coast, or brake by the dynamic brake, before.
"""

import math

from tgvdp._jit import leaf, part
from tgvdp.methods.costate.brake_jumps import saturated_image
from tgvdp.methods.costate.characteristics import coast_image
from tgvdp.physics.codes import DYNAMIC

#: Runs that meet the wall within a cell have costates at so many points per relative change of w, at most, ...
_WALL_PIECES = 40.0
_MOST_WALL_PIECES = 8.0
#: ... down to this share of it before the cell.
LEAST_WALL = 1e-3
#: Where trains are slow p varies as 1/v: points are no further apart than this factor of w.
SPREAD = 1.2
#: Squared speeds nearer than this share are one, and so are costates.
ROUNDING = 1e-9


@leaf
def dynamic_suffices(step):
    """Whether the dynamic brake alone brakes along the wall from ``top`` on."""
    return step.dynamic_w >= step.top * (1.0 - ROUNDING)


@leaf
def is_wall(step, w):
    """Whether a squared speed after the cell is that of the wall."""
    return w >= step.wall * (1.0 - ROUNDING)


@leaf
def jump_from(step, line, first, last):
    """The first of some points, from one on, at which p jumps, at the wall or before it; −1 if it does at none of them.

    Runs with any p in between go through it.
    """
    w, p = line
    if first > 0 and w[first] == w[first - 1] and p[first] > p[first - 1] + ROUNDING:
        return first
    at = first  # the first of those at its speed: a crossing of a level may have been put there
    for i in range(first, last + 1):
        if w[i] != w[at]:
            at = i
        if is_wall(step, w[at]) or p[i] > p[at] + ROUNDING:
            return at
    return -1


@leaf
def _pieces(w1, w0):
    """Into how many pieces a curve of braking from w0 to w1 is cut."""
    return math.ceil(min(max(_WALL_PIECES * (1.0 - w1 / w0), 1.0), _MOST_WALL_PIECES)) if w0 > 0.0 else 1


@part
def _dynamic_m(train, step, w1, length):
    """Over which part of a length a run brakes by the dynamic brake, at its end, that comes to w1 with p = 0.

    Where λ is high p falls to −r/2 on the way back: before that a run coasts.
    """
    level = -0.5 * step.returned
    p0 = saturated_image(train, DYNAMIC, step, length, w1, 0.0)[1]
    if p0 >= level:
        return length
    part_m = length * level / p0
    p0 = saturated_image(train, DYNAMIC, step, part_m, w1, 0.0)[1]
    return min(part_m * level / p0, length)


@leaf
def frictionless_m(train, step):
    """Over which part of the cell a run brakes by the dynamic brake that comes to the end of the wall with p = 0."""
    return _dynamic_m(train, step, max(step.wall, LEAST_WALL * step.top), step.length)


@part
def _wall_image(train, regime, step, rest):
    """Image of the wall's point a share ``rest`` of the cell after its start."""
    w1 = max(step.top + rest * (step.wall - step.top), LEAST_WALL * step.top)
    length = rest * step.length
    level = -0.5 * step.returned
    if regime == DYNAMIC:
        braked_m = _dynamic_m(train, step, w1, length)
        w0, p0 = saturated_image(train, DYNAMIC, step, braked_m, w1, 0.0)
        if braked_m < length:
            return coast_image(train, step, length - braked_m, w0, level)
        return step.dynamic_w if rest == 1.0 else w0, p0
    return coast_image(train, step, length, w1, level)


@part
def wall_region(train, regime, step, images, m):
    """Append costates of runs that meet the wall within the cell, from ``top`` to ``wall``, and brake along it.

    They come to it by coasting, p = −r/2 there, where the dynamic brake alone follows it; else by that brake, p = 0,
    from where p is −r/2.
    On a steep descent only a part of the wall is met from ``bottom`` on: an edge is put there.
    """
    x, y = images
    top = step.top
    fall = top - step.wall
    w, p = _wall_image(train, regime, step, 1.0)
    span = max(top - w, ROUNDING * top)
    pieces = _pieces(min(max(w, step.bottom), step.wall), top)
    rest = 1.0
    if w < step.bottom:
        rest = (top - step.bottom) / span
        w = step.bottom
        p = _wall_image(train, regime, step, rest)[1]
    even = rest / pieces
    while True:
        x[m] = min(w, top)
        y[m] = p
        m += 1
        if rest == 0.0:
            return m
        slowest_w = max(min(top - rest * span, top - rest * fall), LEAST_WALL * top)
        rest -= min(even, (SPREAD - 1.0) * slowest_w / max(span, fall))
        if rest < 0.5 * even:
            rest = 0.0
        w, p = _wall_image(train, regime, step, rest)


@part
def _fan_image(train, step, w1, braked_m):
    """Image of a run that coasts, and brakes by the dynamic brake over the last part of the cell, to w1."""
    w = saturated_image(train, DYNAMIC, step, braked_m, max(w1, LEAST_WALL * step.top), 0.0)[0]
    return coast_image(train, step, step.length - braked_m, w, -0.5 * step.returned)


@part
def fan_region(train, step, w1, w0, length, images, m):
    """Append costates of runs that coast until they meet the curve of dynamic braking from w0 to w1, where p jumps.

    They meet it with p = −r/2, as runs that brake by the dynamic brake alone meet the wall, over the last ``length`` of
    the cell. On a descent they may meet it from ``bottom`` on, however slow that is: an edge is put there.
    """
    x, y = images
    coasted_w = _fan_image(train, step, w1, 0.0)[0]
    span = max(_fan_image(train, step, w1, length)[0] - coasted_w, ROUNDING * step.top)
    share = max(step.bottom - coasted_w, 0.0) / span
    if not share < 1.0:  # nor where the curve comes from a standstill
        return m
    even = (1.0 - share) / _pieces(min(w1, max(coasted_w, step.bottom)), w0)
    if share > 0.0:
        p = _fan_image(train, step, w1, share * length)[1]
        if p <= -0.5 * step.returned:  # no number where the curve does not reach as far back
            x[m] = step.bottom
            y[m] = p
            m += 1
    while True:
        share += min(even, (SPREAD - 1.0) * (coasted_w + share * span) / span)
        if share > 1.0 - 0.5 * even:
            return m
        w, p = _fan_image(train, step, w1, share * length)
        if step.bottom < w < w0:
            x[m] = w
            y[m] = p
            m += 1
