"""Edges of regions: images beyond a level of the costate are cut, and p is put beside speeds at which brakes jump."""

import math

from tgvdp._jit import part
from tgvdp.methods.costate.brake_jumps import beyond_drop, beyond_rate, drop_above
from tgvdp.methods.costate.characteristics import saturated_back
from tgvdp.methods.costate.polyline import insert
from tgvdp.methods.costate.step_wall import ROUNDING

#: A point just above the speed of a step of the braking rates is so many times `ROUNDING` above it.
ABOVE_RATE = 4.0


@part
def cut_out_edges(step, below_w, below_p, w, p, images, m):
    """Append p below and above the speed at which the dynamic brake cuts out, between two images under coasting."""
    x, y = images
    level = -0.5 * step.returned
    p += (step.cut_w - w) / (w - below_w) * (p - below_p)
    x[m] = step.cut_w * (1.0 - ROUNDING)
    y[m] = p
    x[m + 1] = step.cut_w
    y[m + 1] = min(p, level * (1.0 + ROUNDING))
    return m + 2


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
        y[m + 1] = beyond_drop(train, step, math.sqrt(drop_w), y[m])
        m += 2
        drop_w = drop_above(train, drop_w)
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
