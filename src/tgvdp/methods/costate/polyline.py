"""The costate polyline: points (w, p) of rising w, which pass each level once, cut at the envelope, and thinned.

Where the dynamic brake rises with speed its level may be passed three times, and images turn back (`fold`).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part
from tgvdp.methods.costate.fold import JUST_BELOW, cross_thrice, unfold

#: Away from the levels the thinning tolerance grows by this multiple of itself per unit of p.
_FAR = 400.0
#: ... from this distance on.
_NEAR_LEVEL = 0.005


class Polyline(NamedTuple):
    """Room for points: squared speeds, m²/s², and costates, (size,) float64 each."""

    w: NDArray[np.float64]
    p: NDArray[np.float64]


@part
def insert(line, n, at, w, p):
    """Make (w, p) the point ``at`` of the polyline; returns its new number of points."""
    for i in range(n, at, -1):
        line.w[i] = line.w[i - 1]
        line.p[i] = line.p[i - 1]
    line.w[at] = w
    line.p[at] = p
    return n + 1


@part
def cross_once(line, first, m, level):
    """Make p pass a level once, from the point ``first`` on: at the squared speed w where V − level·w is least.

    Where V is not convex p passes it several times. What is on the wrong side of that speed is put at the level, and
    just below it: elsewhere p stays what it is, for runs there keep to their regime whatever its slope.
    """
    x, y = line
    at = first
    area = least = 0.0
    for i in range(first + 1, m):
        before = y[i - 1] - level
        after = y[i] - level
        d = x[i] - x[i - 1]
        if before < 0.0 <= after:
            there = area + 0.5 * before * d * before / (before - after)
            if there <= least:
                least = there
                at = i
        area += 0.5 * (before + after) * d
    if area <= least and y[m - 1] < level:
        at = m
    for i in range(first, at):
        y[i] = min(y[i], level - JUST_BELOW)
    for i in range(at, m):
        y[i] = max(y[i], level)


@part
def make_unique(line, m, top, level, brakes_w, rises, drops):
    """Make w rise, cut at ``top``, and p pass −½, ``level`` and 0 once each; returns the number of points left.

    Below ``brakes_w``, where the dynamic brake has no effort, its ``level`` means nothing. Where it ``rises`` with
    speed its level may be passed up, down and up again, and where images overlap the one with less V is right; else
    that with the higher p: faster runs come there from farther on. Above 0, where the dynamic brake ``drops``, each
    cell puts two points at that speed, the upper one for friction, which would go on as teeth: p rises.
    """
    x, y = line
    if rises:
        m = unfold(line, m)
    last_x = x[0]
    falls = False
    brakes = 0
    n = m
    for i in range(1, m):
        if x[i] < last_x:
            y[i] = max(y[i], y[i - 1])
        falls = falls or y[i] < y[i - 1]
        last_x = max(x[i], last_x)
        x[i] = last_x
        if last_x < brakes_w:
            brakes = i + 1
        if last_x >= top:
            n = i + 1
            break
    if falls:
        cross_once(line, 0, n, -0.5)
        if level < 0.0 and rises:
            cross_thrice(line, min(brakes, n - 1), n, level)
        elif level < 0.0:
            cross_once(line, min(brakes, n - 1), n, level)
        cross_once(line, 0, n, 0.0)
        if drops:
            for i in range(1, n):
                if y[i - 1] > 0.0:
                    y[i] = max(y[i], y[i - 1])
    if x[n - 1] > top:
        if n > 1 and x[n - 1] > x[n - 2]:
            share = (top - x[n - 2]) / (x[n - 1] - x[n - 2])
            y[n - 1] = y[n - 2] + share * (y[n - 1] - y[n - 2])
        x[n - 1] = top
    return n


@leaf
def _slack(p, level, near, far):
    """How far the polyline may pass a point: near −½, ``level`` and 0 the tolerance, more away from them."""
    if p == -0.5 or p == level or p == 0.0:  # a line of switching goes through it
        return 0.0
    if p < -0.5:
        away = -0.5 - p
        return near + far * min(0.5 * away, 0.25) * away
    away = min(p + 0.5, abs(p - level), -p)
    return near + _FAR * near * max(0.0, away - _NEAR_LEVEL)


@part
def thin(line, m, level, near, far, thinned):
    """Swinging-door thinning of a polyline into another, within ``near`` where p is next to −½, ``level`` or 0.

    Points at these levels stay. Far below −½ the tolerance is quadratic, and ``far`` of that.
    """
    x = line.w
    y = line.p
    w = thinned.w
    p = thinned.p
    door_x = x[0]
    door_y = y[0]
    w[0] = door_x
    p[0] = door_y
    n = 1
    if m == 1:
        return n
    steepest = math.inf
    flattest = -math.inf
    tiny = 1e-12 * x[m - 1]
    for i in range(1, m):
        per_dx = 1.0 / max(x[i] - door_x, tiny)
        slope = (y[i] - door_y) * per_dx
        if slope < flattest or slope > steepest:
            door_x = x[i - 1]
            door_y = y[i - 1]
            w[n] = door_x
            p[n] = door_y
            n += 1
            steepest = math.inf
            flattest = -math.inf
            per_dx = 1.0 / max(x[i] - door_x, tiny)
        slack = _slack(y[i], level, near, far)
        steepest = min(steepest, (y[i] + slack - door_y) * per_dx)
        flattest = max(flattest, (y[i] - slack - door_y) * per_dx)
    w[n] = x[m - 1]
    p[n] = y[m - 1]
    return n + 1
