"""Coasting above and below speeds at which the dynamic brake works: regions of the costate polyline.

A brake that begins at a speed, or rises steeply with it, works in an interval of speeds above that, and runs coast
above the interval, too (`fold`). Each of these regions has images of its own, which may overlap those of the next one.
"""

import math

from tgvdp._jit import part
from tgvdp.methods.costate.brake_jumps import saturated_image
from tgvdp.methods.costate.step_edges import cut_above, drop_below, rate_edges, rise_edges
from tgvdp.methods.costate.step_regions import coast_region, fill_up
from tgvdp.physics.codes import DYNAMIC


@part
def coasting_regions(train, step, line, first, early, late, last, images, m):
    """Append the images of the points ``first`` .. ``last``, of which those from ``early`` to ``late`` brake.

    These two are one point where none does. Returns how many images there are, and from which of them on the images of
    runs that brake above them all may cut theirs.
    """
    w = line.w
    from_w = train.brakes_from_mps * train.brakes_from_mps
    begins = first
    if step.returned > 0.0 and train.last_drop_mps == 0.0:
        while begins <= last and w[begins] < from_w:
            begins += 1
    start = m
    if early == late:
        if begins == first:
            return coast_region(train, step, line, first, last, images, m), start
        m = coast_region(train, step, line, first, begins - 1, images, m)
        start = m
        if begins < last or line.p[last] <= -0.5 * step.returned:  # else runs brake down to where that begins
            m = coast_region(train, step, line, begins, last, images, m)
        return m, start
    if w[early] > from_w:
        m = coast_region(train, step, line, first, early, images, m)
        while start < m and images.w[start] < from_w:
            start += 1
        m = cut_above(-0.5 * step.returned, images, start, m, math.inf)
    elif begins > first:
        m = coast_region(train, step, line, first, begins - 1, images, m)
    m = _interval(train, step, line, early, late, images, m)
    return coast_region(train, step, line, late, last, images, m), m


@part
def _interval(train, step, line, first, last, images, m):
    """Append images under the dynamic brake of points that keep p ≥ −r/2; returns how many there are then."""
    w, p = line
    x, y = images
    level = -0.5 * step.returned
    before = m
    for i in range(first, last + 1):
        w0, p0 = saturated_image(train, DYNAMIC, step, step.length, w[i], max(p[i], level))
        if w0 < step.bottom:
            continue
        if m > before:
            m = rate_edges(train, DYNAMIC, step, line, i, images, m, w0)
            m = rise_edges(train, step, line, i, images, m, w0)
            m = fill_up(train, DYNAMIC, step, line, i, level, images, m, w0)
        x[m] = w0
        y[m] = p0
        m += 1
        if w0 > step.top:
            break
    m = drop_below(level, images, before, m)
    end = m
    while end > before and y[end - 1] < level:
        end -= 1
    if before < end < m:
        share = (level - y[end - 1]) / (y[end] - y[end - 1])
        x[end] = x[end - 1] + share * (x[end] - x[end - 1])
        y[end] = level
        end += 1
    return end
