"""Edges of regions: images beyond a level of the costate are cut, and p is put beside speeds at which brakes jump."""

import math

from tgvdp._jit import leaf, part
from tgvdp.methods.costate.brake_jumps import begun_costate, beyond_jump, beyond_rate, drop_above, is_kept, rise_above
from tgvdp.methods.costate.characteristics import saturated_back
from tgvdp.methods.costate.polyline import insert
from tgvdp.methods.costate.step_wall import ROUNDING
from tgvdp.physics.codes import DYNAMIC

#: A point just above the speed of a step of the braking rates is so many times `ROUNDING` above it, and one just below
#: a rise of the dynamic brake so many times below.
ABOVE_RATE = 4.0
#: Runs that come to a speed and keep it have costates at so many points on either side.
_KEPT_PIECES = 4


@part
def at_rates(train, line, n):
    """Make points just below and above the speeds at which braking rates step, that characteristics part at them.

    Returns the number of points.
    """
    w, p = line
    i = 1
    for j in range(1, train.rates.shape[0]):
        step_w = train.rates[j, 0] * train.rates[j, 0]
        below_w = step_w * (1.0 - ROUNDING)
        while i < n and w[i] < below_w:
            i += 1
        if i == n or w[0] >= below_w:
            continue
        above_w = step_w * (1.0 + ABOVE_RATE * ROUNDING)
        if w[i] <= above_w:  # they are there
            continue
        share = (step_w - w[i - 1]) / (w[i] - w[i - 1])
        step_p = p[i - 1] + share * (p[i] - p[i - 1])
        n = insert(line, n, i, below_w, step_p)
        n = insert(line, n, i + 1, above_w, step_p)
    return n


@leaf
def _just_below(rise_w):
    """A squared speed just below that of a rise of the dynamic brake."""
    return rise_w * (1.0 - ABOVE_RATE * ROUNDING)


@part
def at_rises(train, line, n):
    """Make points just below and at the speeds at which the dynamic brake rises, that characteristics part at them.

    Where one is the wall friction does not help below it yet. Returns the number of points.
    """
    w, p = line
    i = 1
    rise_w = rise_above(train, w[0])
    while rise_w <= w[n - 1]:
        below_w = _just_below(rise_w)
        while w[i] < below_w:
            i += 1
        if w[i] > below_w:  # else they are there
            share = (rise_w - w[i - 1]) / (w[i] - w[i - 1])
            rise_p = p[i - 1] + share * (p[i] - p[i - 1])
            is_there = w[i] <= rise_w
            n = insert(line, n, i, below_w, min(rise_p, -ROUNDING))
            if not is_there:
                n = insert(line, n, i + 1, rise_w, rise_p)
        rise_w = rise_above(train, rise_w)
    return n


@part
def rate_edges(train, regime, step, line, i, images, m, w):
    """Append p below and above speeds at which braking rates step, between the last image and that of the point i, w.

    Only where trains slow down through them.
    """
    x, y = images
    for j in range(1, train.rates.shape[0]):
        v = train.rates[j, 0]
        step_w = v * v
        if x[m - 1] < step_w * (1.0 - ROUNDING) and step_w * (1.0 + ROUNDING) < w:
            share = (step_w - x[m - 1]) / (w - x[m - 1])
            w1 = line.w[i - 1] + share * (line.w[i] - line.w[i - 1])
            p1 = line.p[i - 1] + share * (line.p[i] - line.p[i - 1])
            below_p = saturated_back(train, regime, step, step.length, w1, p1)[1]
            above_p = beyond_rate(train, regime, step, v, below_p)
            if above_p != below_p:
                x[m] = step_w * (1.0 - ROUNDING)
                y[m] = below_p
                x[m + 1] = step_w * (1.0 + ABOVE_RATE * ROUNDING)
                y[m + 1] = above_p
                m += 2
    return m


@part
def drop_edges(train, step, images, m, w):
    """Append p below and above the speeds between the last image and another one at which the dynamic brake drops."""
    x, y = images
    drop_w = drop_above(train, x[m - 1])
    while drop_w < w:
        x[m] = drop_w * (1.0 - ROUNDING)
        y[m] = y[m - 1]
        x[m + 1] = drop_w
        y[m + 1] = beyond_jump(train, step, math.sqrt(drop_w), y[m])
        m += 2
        drop_w = drop_above(train, drop_w)
    return m


@part
def rise_edges(train, step, line, i, images, m, w):
    """Append p below and at speeds at which the dynamic brake rises, between the last image and that of the point i, w.

    Where runs come to one from both sides they keep it.
    """
    x, y = images
    rise_w = rise_above(train, x[m - 1])
    while rise_w < w:
        v = math.sqrt(rise_w)
        below_w = _just_below(rise_w)
        if x[m - 1] < below_w and is_kept(train, step, v):
            m = _kept_region(train, step, below_w, rise_w, images, m, w)
        elif x[m - 1] < below_w:
            share = (rise_w - x[m - 1]) / (w - x[m - 1])
            w1 = line.w[i - 1] + share * (line.w[i] - line.w[i - 1])
            p1 = line.p[i - 1] + share * (line.p[i] - line.p[i - 1])
            x[m] = below_w
            y[m] = saturated_back(train, DYNAMIC, step, step.length, w1, p1)[1]
            x[m + 1] = rise_w
            y[m + 1] = beyond_jump(train, step, v, y[m])
            m += 2
        rise_w = rise_above(train, rise_w)
    return m


@part
def begun_edges(train, step, below_w, below_p, w, p, images, m):
    """Append p below and at the speed at which the dynamic brake begins, between two images under coasting."""
    x, y = images
    from_mps = train.brakes_from_mps
    from_w = from_mps * from_mps
    p += (from_w - w) / (w - below_w) * (p - below_p)
    x[m] = _just_below(from_w)
    y[m] = p
    x[m + 1] = from_w
    y[m + 1] = begun_costate(train, step, p)
    return m + 2


@part
def _kept_region(train, step, below_w, rise_w, images, m, w):
    """Append p of runs that come to the speed of a rise within the cell, from below or from above, up to an image w.

    There p = −r/2: to keep it takes a part of the dynamic brake. Where p is less before that they had better coast.
    """
    x, y = images
    before_w = x[m - 1]
    for j in range(2 * _KEPT_PIECES):
        rest = abs(j - _KEPT_PIECES + (1 if j < _KEPT_PIECES else 0)) / _KEPT_PIECES
        w1 = below_w if j < _KEPT_PIECES else rise_w
        w0, p0 = saturated_back(train, DYNAMIC, step, rest * step.length, w1, -0.5 * step.returned)
        if before_w < w0 < w:
            x[m] = w0
            y[m] = p0
            m += 1
    return m


@part
def cut_above(level, images, first, m, beyond):
    """Drop images after the ``first`` that lie above a level, but for an edge at the level; returns what is left.

    Those from a squared speed ``beyond`` on are right.
    """
    x, y = images
    i = first
    while i < m and y[i] <= level:
        i += 1
    if i == m or x[i] >= beyond:
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
