"""The costate polyline: points (w, p) of rising w and p, kept monotone, cut at the envelope, and thinned."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part

#: Away from the levels the thinning tolerance grows by this multiple of itself per unit of p.
_FAR = 400.0
#: ... from this distance on.
_NEAR_LEVEL = 0.005
#: Where p falls by less it is level; what is level instead of a dent is found in so many halvings.
_LEVEL = 1e-9
_HALVINGS = 24


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
def _above(line, first, m, i, level):
    """Area of p above a level less that below it, next to where p falls through it at the point ``i``.

    Returns also the first and the last of the points in these areas, and the squared speeds where they begin and end.
    """
    x, y = line
    lo = i - 1
    hi = i
    area = (0.5 * (y[lo] + y[hi]) - level) * (x[hi] - x[lo])
    while lo > first and y[lo - 1] > level:
        lo -= 1
        area += (0.5 * (y[lo] + y[lo + 1]) - level) * (x[lo + 1] - x[lo])
    begins = x[lo]
    if lo > first:
        above = y[lo] - level
        begins -= above / (y[lo] - y[lo - 1]) * (x[lo] - x[lo - 1])
        area += 0.5 * above * (x[lo] - begins)
    while hi + 1 < m and y[hi + 1] < level:
        hi += 1
        area += (0.5 * (y[hi - 1] + y[hi]) - level) * (x[hi] - x[hi - 1])
    ends = x[hi]
    if hi + 1 < m:
        below = level - y[hi]
        ends += below / (y[hi + 1] - y[hi]) * (x[hi + 1] - x[hi])
        area -= 0.5 * below * (ends - x[hi])
    return area, lo, hi, begins, ends


@part
def make_rise(line, first, m, drops):
    """Make p rise from the point ``first`` on: where it falls, it is made level, with as much above that as below it.

    Where p falls with w, V is concave, and what is wanted is the slope of its convex hull (Maxwell's rule): a narrow
    dent does not decide about all that is beyond it. Where the dynamic brake ``drops`` images of two regimes overlap,
    and the higher p is right.
    """
    x, y = line
    for i in range(first + 1, m):
        if y[i] >= y[i - 1]:
            continue
        if drops or y[i] >= y[i - 1] - _LEVEL:
            y[i] = y[i - 1]
            continue
        lowest = y[i]
        highest = y[i - 1]
        for _ in range(_HALVINGS):
            level = 0.5 * (lowest + highest)
            if _above(line, first, m, i, level)[0] > 0.0:
                lowest = level
            else:
                highest = level
        level = 0.5 * (lowest + highest)
        _, lo, hi, begins, ends = _above(line, first, m, i, level)
        for j in range(lo, hi + 1):
            y[j] = level
        x[lo] = begins
        x[hi] = ends


@part
def make_monotone(line, m, top, cut_w, level, drops):
    """Make w and p rise, the one by its running maximum, cut at ``top``; returns the number of points left.

    At ``cut_w``, where the dynamic brake cuts out, p may fall from above a ``level`` to below it, and is as it is from
    there on. ``drops`` is that of `make_rise`.
    """
    x, y = line
    last_x = x[0]
    falls = False
    cut = n = m
    for i in range(1, m):
        if y[i] < y[i - 1]:
            falls = True
            if x[i - 1] < cut_w <= x[i] and y[i - 1] > level > y[i]:
                cut = i
        last_x = max(x[i], last_x)
        x[i] = last_x
        if last_x >= top:
            n = i + 1
            break
    if falls:
        make_rise(line, 0, min(cut, n), drops)
        make_rise(line, cut, n, drops)
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
