"""Regions of the costate polyline: which points are carried back by which regime, and what lies between and beyond.

Full traction keeps p ≤ −½ within the cell, coasting p ≥ −½ (and p ≤ −r/2), dynamic braking p ≥ −r/2 (and p ≤ 0), all
brakes p ≥ 0: images that do not are dropped. Between two regimes runs change from one to the other within the cell, or
hold a speed, and p is interpolated. Beyond the last image runs meet the wall within the cell.
"""

import math

from tgvdp._jit import kernel, part
from tgvdp.methods.costate.characteristics import (
    LOST,
    coast_back,
    coast_image,
    dynamic_before,
    held_back_w,
    saturated_back,
    saturated_image,
)
from tgvdp.methods.costate.step_held import hold
from tgvdp.methods.costate.step_wall import SPREAD, dynamic_suffices, fan_region, frictionless_m, is_wall, jump_from
from tgvdp.physics.codes import BRAKING, COASTING, DYNAMIC, TRACTION

#: Neighbouring images count as slow below this share of the envelope.
_SLOW_SHARE = 0.5


@part
def drive_region(train, step, line, last, images):
    """Images under full traction of the points up to ``last`` that lie above ``bottom`` and keep p ≤ −½.

    They are made from the last one down. Of those lost below ``bottom`` one remains, at ``bottom``: p is so low there
    that the regime is clear. Returns their number, and the speed after the cell of the last one.
    """
    w, p = line
    x, y = images
    bottom = step.bottom
    first = last + 1
    edge = last
    switch = w[last]
    above_w = 0.0
    above_p = 0.0
    for i in range(last, -1, -1):
        w0, p0 = saturated_back(train, TRACTION, step, step.length, w[i], p[i])
        if w0 < bottom:
            if first <= last:
                share = (bottom - w0) / (x[first] - w0)
                edge_w = w[i] + share * (w[first] - w[i])
                edge_p = p[i] + share * (p[first] - p[i])
                edge_w, edge_p = saturated_image(train, TRACTION, step, step.length, edge_w, edge_p)
                if edge_w > LOST * bottom and edge_p <= y[first]:
                    first -= 1
                    x[first] = bottom
                    y[first] = edge_p
            break
        if p0 > -0.5 and first > last:
            edge = i - 1
        elif i == edge < last:
            share = (-0.5 - p0) / (above_p - p0)
            switch = w[i] + share * (w[i + 1] - w[i])
            edge = i + 1
            x[edge] = w0 + share * (above_w - w0)
            y[edge] = -0.5
            first = i
        else:
            first = i
        x[i] = w0
        y[i] = p0
        above_w = w0
        above_p = p0
    for i in range(first, edge + 1):
        x[i - first] = x[i]
        y[i - first] = y[i]
    return edge + 1 - first if edge >= first else 0, switch


@kernel
def _coast_all(train, step, w, p, x, y):
    """Images (x, y) under coasting of all points (w, p): indices from 0, so that the loop becomes one of vectors."""
    for i in range(w.shape[0]):
        x[i], y[i] = coast_back(train, step, step.length, w[i], p[i])


@part
def _is_dense(w, bottom, slow):
    """Whether squared speeds, (n,), are above ``bottom`` and have no gaps below ``slow``."""
    if not w[0] >= bottom:
        return False
    i = 1
    while i < w.shape[0] and w[i - 1] < slow:
        if not w[i] <= SPREAD * w[i - 1] and SPREAD * w[i - 1] < slow:
            return False
        i += 1
    return True


@part
def coast_region(train, step, line, first, last, images, m):
    """Append the images under coasting of the points ``first`` .. ``last``.

    Between slow ones p varies as 1/v, which no straight line follows: gaps between neighbouring images are filled
    there, from the edge at ``bottom`` on, with points interpolated before the cell.
    """
    w, p = line
    x, y = images
    bottom = step.bottom
    slow = _SLOW_SHARE * step.top
    count = last + 1 - first
    _coast_all(train, step, w[first : last + 1], p[first : last + 1], x[m:], y[m:])
    if count > 0 and _is_dense(x[m : m + count], bottom, slow):
        return m + count
    image = 0.0
    lost = False
    i = first
    while i <= last:
        w0, p0 = coast_image(train, step, step.length, w[i], p[i])
        if w0 < bottom:
            lost = True
        else:
            target = bottom if lost else SPREAD * image
            while i > first and target < min(w0, slow) and m + last + 8 < x.shape[0]:
                share = (target - image) / (w0 - image)
                fill_w = w[i - 1] + share * (w[i] - w[i - 1])
                fill_p = p[i - 1] + share * (p[i] - p[i - 1])
                fill_w, fill_p = coast_image(train, step, step.length, fill_w, fill_p)
                if fill_w > LOST * bottom and fill_p <= p0:
                    x[m] = bottom if target == bottom else fill_w
                    y[m] = fill_p
                    m += 1
                target *= SPREAD
            lost = False
            x[m] = w0
            y[m] = p0
            m += 1
        image = w0
        i += 1
        if w0 >= slow and not lost:
            break
    _coast_all(train, step, w[i : last + 1], p[i : last + 1], x[m:], y[m:])
    return m + last + 1 - i


@part
def brake_region(train, regime, step, line, first, last, images, start, m, scratch):
    """Append images under full braking of the points ``first`` .. ``last`` that keep p above the level of the regime.

    That is −r/2 for the dynamic brake, 0 for all brakes. Of the images from ``start`` on those remain that keep p below
    it. Where the dynamic brake holds the envelope there are none: runs come to that by coasting. Returns the number of
    images.
    """
    x, y = images
    level = -0.5 * step.returned if regime == DYNAMIC else 0.0
    m = cut_above(level, images, start, m)
    edge_w = math.inf  # where p jumps
    edge_image = 0.0
    jump = jump_from(step, line, first, last) if regime == DYNAMIC else -1
    if jump >= 0:
        edge_w = line.w[jump]
        edge_image = step.dynamic_w
        braked_m = step.length
        if is_wall(step, edge_w):
            braked_m = frictionless_m(train, step)
        else:
            edge_image = dynamic_before(train, step.length, step.load, step.air, edge_w, step.top, scratch)
        if y[m - 1] < level and edge_w == line.w[first]:
            m = fan_region(train, step, edge_w, edge_image, braked_m, images, m)
        if braked_m < step.length:  # friction helps before the wall's end, wherever runs come from
            return m
    before = m
    for i in range(first, last + 1):
        w0, p0 = saturated_image(train, regime, step, step.length, line.w[i], max(line.p[i], level))
        if line.w[i] == edge_w:  # a run that is faster by the error of the image would end with friction
            w0 = edge_image
        if w0 >= step.bottom:
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
def friction_region(train, step, line, first, last, images, start, m, scratch):
    """Append images under all brakes of the points ``first`` .. ``last`` where p passes 0; returns how many there are.

    Of the images from ``start`` on those remain that keep p ≤ 0.
    """
    x, y = images
    highest = 0.0
    for i in range(start, m):
        highest = max(highest, y[i])
    if highest == 0.0 and first == last:
        return m
    if y[start] > 0.0:  # a descent so long that runs from all lower speeds come to the one that is held
        x[start] = step.bottom
        y[start] = -0.5 * step.returned
        m = start + 1
    m = brake_region(train, BRAKING, step, line, first, last, images, start, m, scratch)
    if x[m - 1] < step.top:  # all brakes follow the wall
        x[m] = step.top
        y[m] = y[m - 1]
        m += 1
    return m


@part
def cut_above(level, images, first, m):
    """Drop images after the ``first`` that lie above a level, but for an edge at the level; returns what is left."""
    x, y = images
    i = first
    while i < m and y[i] <= level:
        i += 1
    if i == m:
        return m
    if i > first:
        x[i] -= (x[i] - x[i - 1]) * (y[i] - level) / (y[i] - y[i - 1])
    y[i] = level
    return i + 1


@part
def drop_below(level, images, first, m):
    """Drop the images from ``first`` on that lie below a level, but for an edge at the level; returns what is left.

    Where no image reaches the level, nothing is left.
    """
    x, y = images
    i = first
    while i < m and y[i] < level:
        i += 1
    if i == m:
        return first
    if i == first:
        return m
    share = (level - y[i - 1]) / (y[i] - y[i - 1])
    x[i - 1] += share * (x[i] - x[i - 1])
    y[i - 1] = level
    dropped = i - 1 - first
    for j in range(first, m - dropped):
        x[j] = x[j + dropped]
        y[j] = y[j + dropped]
    return m - dropped
