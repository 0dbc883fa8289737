"""Regions of the costate polyline: which points are carried back by which regime, and what lies between and beyond.

Full traction keeps p ≤ −½ within the cell, coasting p ≥ −½ (and p ≤ −r/2), dynamic braking p ≥ −r/2 (and p ≤ 0), all
brakes p ≥ 0: images that do not are dropped. Between two regimes runs change from one to the other within the cell, or
hold a speed, and p is interpolated. Beyond the last image runs meet the wall within the cell.
"""

import math

from tgvdp._jit import loop, part
from tgvdp.methods.costate.brake_jumps import (
    begun_image,
    drop_above,
    half_helped,
    helped_before,
    last_coasted,
    saturated_image,
)
from tgvdp.methods.costate.characteristics import (
    LOST,
    coast_back,
    coast_image,
    dynamic_before,
    held_back_w,
    saturated_back,
)
from tgvdp.methods.costate.polyline import cross_once
from tgvdp.methods.costate.step_edges import begun_edges, cut_above, drop_below, drop_edges, rate_edges, rise_edges
from tgvdp.methods.costate.step_held import hold
from tgvdp.methods.costate.step_wall import (
    ROUNDING,
    SPREAD,
    dynamic_suffices,
    fan_region,
    frictionless_m,
    is_wall,
    jump_from,
)
from tgvdp.physics.codes import BRAKING, COASTING, DYNAMIC, TRACTION

#: Below this costate it is clear for many cells that a run drives.
_CLEAR = -1.0


@part
def drive_region(train, step, line, last, images):
    """Images under full traction of the points up to ``last`` that lie above ``bottom`` and keep p ≤ −½.

    They are made from the last one down. Of those lost below ``bottom`` one remains, at ``bottom``: p is so low there
    that the regime is clear. Where traction is weak runs may slow down at full effort, points come from there to the
    line of switching, and p bends on the way: gaps are filled. Returns the number of images, and the speed after the
    cell of the last one.
    """
    w, p = line
    x, y = images
    bottom = step.bottom
    end = 2 * last + 4  # room for one more between any two, and for two edges
    j = end
    switch = w[last]
    above_w = above_p = 0.0
    for i in range(last, -1, -1):
        w0, p0 = saturated_back(train, TRACTION, step, step.length, w[i], p[i])
        if w0 < bottom:
            if j < end:
                share = (bottom - w0) / (above_w - w0)
                edge_w = w[i] + share * (w[i + 1] - w[i])
                edge_p = p[i] + share * (p[i + 1] - p[i])
                j = _fill_down(train, step, edge_w, edge_p, w[i + 1], p[i + 1], images, j)
                edge_w, edge_p = saturated_image(train, TRACTION, step, step.length, edge_w, edge_p)
                j -= 1
                x[j] = bottom
                y[j] = edge_p if edge_w > LOST * bottom and edge_p <= y[j + 1] else min(p[i], y[j + 1])
            break
        if j < end:
            j = _fill_down(train, step, w[i], p[i], w[i + 1], p[i + 1], images, j)
        elif p0 <= -0.5 and i < last:
            share = (-0.5 - p0) / (above_p - p0)
            switch = w[i] + share * (w[i + 1] - w[i])
            j -= 1
            x[j] = w0 + share * (above_w - w0)
            y[j] = -0.5
        if p0 <= -0.5 or j < end:
            j -= 1
            x[j] = w0
            y[j] = p0
        above_w = w0
        above_p = p0
    for i in range(j, end):
        x[i - j] = x[i]
        y[i - j] = y[i]
    return end - j, switch


@part
def _between(train, regime, step, below_w, below_p, w, p):
    """Image of the middle of two points at full effort, (0, 0) where they are near each other: between them p bends."""
    if w <= SPREAD * below_w:
        return 0.0, 0.0
    return saturated_back(train, regime, step, step.length, 0.5 * (below_w + w), 0.5 * (below_p + p))


@part
def _fill_down(train, step, below_w, below_p, w, p, images, j):
    """Put an image under traction between those of two points before the image ``j``, where p is not clear."""
    x, y = images
    if p > _CLEAR:
        w0, p0 = _between(train, TRACTION, step, below_w, below_p, w, p)
        if step.bottom < w0 < x[j] and p0 <= y[j]:
            j -= 1
            x[j] = w0
            y[j] = p0
    return j


@part
def fill_up(train, regime, step, line, i, level, images, m, w):
    """Append an image under braking between that of the point before i and that of i, w; their new number."""
    x, y = images
    below_p = max(line.p[i - 1], level)
    w0, p0 = _between(train, regime, step, line.w[i - 1], below_p, line.w[i], max(line.p[i], level))
    if x[m - 1] < w0 < w:
        x[m] = w0
        y[m] = p0
        m += 1
    return m


@loop
def _coast_all(train, step, w, p, x, y):
    """Images (x, y) under coasting of all points (w, p)."""
    for i in range(w.shape[0]):
        x[i], y[i] = coast_back(train, step, step.length, w[i], p[i])


@part
def coast_region(train, step, line, first, last, images, m):
    """Append the images under coasting of the points ``first`` .. ``last``; returns how many there are then.

    Between them p bends on the way, as 1/v where trains are slow: gaps between neighbouring images are filled, from the
    edge at ``bottom`` on, with points interpolated before the cell. Where the dynamic brake begins p falls.
    """
    w, p = line
    x, y = images
    bottom = step.bottom
    count = last + 1 - first
    base = x.shape[0] - count
    from_w = train.brakes_from_mps * train.brakes_from_mps
    _coast_all(train, step, w[first : last + 1], p[first : last + 1], x[base:], y[base:])
    for i in range(count):
        w0 = x[base + i]
        if w0 < bottom:
            continue
        if step.returned > 0.0 and w0 >= from_w > w[first + i] > 0.0:
            if i > 0 and bottom <= x[base + i - 1] < from_w and m + 2 < base + i:
                m = begun_edges(train, step, x[base + i - 1], y[base + i - 1], w0, y[base + i], images, m)
            begun_w, begun_p = begun_image(train, step, w[first + i], p[first + i])
            if i > 0 and y[m - 1] < -0.5 * step.returned < begun_p:  # they part, one braking and one coasting
                last_w, last_p = last_coasted(train, step, w[first + i], p[first + i])
                if last_w < begun_w and y[m - 1] < last_p:
                    x[m] = max(last_w, x[m - 1])
                    y[m] = last_p
                    m += 1
            x[m] = begun_w
            y[m] = begun_p
            m += 1
            continue
        if i > 0:
            image = x[base + i - 1]
            target = bottom if image < bottom else SPREAD * image
            while target < w0 and m + 1 < base + i:
                share = (target - image) / (w0 - image)
                fill_w = w[first + i - 1] + share * (w[first + i] - w[first + i - 1])
                fill_p = p[first + i - 1] + share * (p[first + i] - p[first + i - 1])
                fill_w, fill_p = coast_image(train, step, step.length, fill_w, fill_p)
                if fill_w > LOST * bottom and fill_p <= y[base + i]:
                    x[m] = bottom if target == bottom else fill_w
                    y[m] = fill_p
                    m += 1
                target *= SPREAD
        x[m] = w0
        y[m] = y[base + i]
        m += 1
    return m


@part
def brake_region(train, regime, step, line, first, last, images, start, m, scratch):
    """Append images under full braking of the points ``first`` .. ``last`` that keep p above the level of the regime.

    That is −r/2 for the dynamic brake, 0 for all brakes. Of the images from ``start`` on those remain that keep p below
    it. Where the dynamic brake holds the envelope there are none: runs come to that by coasting. Returns the number of
    images.
    """
    x, y = images
    level = -0.5 * step.returned if regime == DYNAMIC else 0.0
    while start < m and x[start] < train.brakes_from_mps * train.brakes_from_mps:  # no dynamic brake works there
        start += 1
    # Friction may help above a drop of the dynamic brake alone.
    drop_w = drop_above(train, line.w[first] * (1.0 - 4.0 * ROUNDING)) if regime == BRAKING else math.inf
    if train.last_drop_mps == 0.0:  # a dent is no place to cut
        cross_once(images, start, m, level)
    m = cut_above(level, images, start, m, drop_w)
    edge_w = math.inf  # where p jumps
    edge_image = helped_image = 0.0
    jump = jump_from(step, line, first, last) if regime == DYNAMIC else -1
    if jump >= 0:
        edge_w = line.w[jump]
        edge_image = step.dynamic_w
        braked_m = step.length
        if is_wall(step, edge_w):
            braked_m = frictionless_m(train, step)
        else:
            edge_image = dynamic_before(train, step.length, step.load, step.air, edge_w, step.top, scratch)
        helped_image = helped_before(train, step, edge_w, scratch)
        follows = is_wall(step, edge_w) and dynamic_suffices(step)  # no curve is met: the wall is
        if y[m - 1] < level and edge_w == line.w[first] and not follows:
            m = fan_region(train, step, edge_w, edge_image, braked_m, images, m)
        if braked_m < step.length:  # friction helps before the wall's end, wherever runs come from
            return m
    before = m
    for i in range(first, last + 1):
        w0, p0 = saturated_image(train, regime, step, step.length, line.w[i], max(line.p[i], level))
        if m > before:
            m = rate_edges(train, regime, step, line, i, images, m, w0)
            if regime == DYNAMIC:
                m = drop_edges(train, step, images, m, w0)
                m = rise_edges(train, step, line, i, images, m, w0)
        if line.w[i] == edge_w:  # a run that is faster by the error of the image would end with friction
            helped = w0 > 0.5 * (edge_image + helped_image) > edge_image
            if helped and x[m - 1] == edge_image:  # p jumps where friction begins to help, and not where it does most
                x[m] = edge_image
                y[m] = half_helped(train, step, step.length, edge_w)
                m += 1
            w0 = helped_image if helped else edge_image
        if w0 >= step.bottom:
            if m > before:
                m = fill_up(train, regime, step, line, i, level, images, m, w0)
            x[m] = w0
            y[m] = p0
            m += 1
            if w0 > step.top:
                if m == before + 1 and is_wall(step, line.w[first]):  # the envelope is held
                    if regime == DYNAMIC and dynamic_suffices(step):
                        return before
                    x[before] = step.top
                    y[before] = level
                break
    if m == before:
        return m
    beyond = x[m - 1]
    m = drop_below(level, images, before, m)
    if m > before:
        if regime == BRAKING:
            held_w = held_back_w(train, step.returned, step.multiplier, step.top)
            return hold(train, DYNAMIC, BRAKING, step, held_w, level, before, m, images)
        return hold(train, COASTING, DYNAMIC, step, step.held_brake_w, level, before, m, images)
    x[m] = beyond  # below the level up to the wall
    y[m] = level
    return m + 1


@part
def friction_region(train, step, line, first, last, images, slowest, start, m, scratch):
    """Append images under all brakes of the points ``first`` .. ``last`` where p passes 0; returns how many there are.

    Of the images from ``start`` on those remain that keep p ≤ 0. The ``slowest`` image of a run that coasts is that
    one, or lies before it.
    """
    x, y = images
    highest = 0.0
    for i in range(start, m):
        highest = max(highest, y[i])
    if highest == 0.0 and first == last:
        return m
    if start == slowest and y[start] > 0.0:  # a descent so long that all slower runs come to the speed that is held
        x[start] = step.bottom
        y[start] = -0.5 * step.returned
        m = start + 1
    m = brake_region(train, BRAKING, step, line, first, last, images, start, m, scratch)
    if x[m - 1] < step.top:  # all brakes follow the wall
        x[m] = step.top
        y[m] = y[m - 1]
        m += 1
    return m
