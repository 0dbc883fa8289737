"""Where V is far from convex: levels that the costate polyline passes three times, and images that turn back.

A dynamic brake that begins at a speed, or rises steeply with it, brakes runs in an interval of speeds just above that,
and again from a higher speed on; in between they coast. So p passes −r/2 up, down and up again, and runs that brake in
the interval overtake those that coast. The points are (w, p) of a `polyline.Polyline`, and dV = p·dw along it.
"""

import math

from tgvdp._jit import leaf, part

#: What does not reach a level ends so far below it.
JUST_BELOW = 1e-12
#: Parts of the polyline below a level and above it, at most: below, above, below, above.
_MOST_PARTS = 4
#: A part whose area, relative to the last w, is less than this is one by a rounding.
_NO_AREA = 1e-10
#: The place where two branches have the same V is looked for in so many halvings.
_HALVINGS = 30


@leaf
def _areas(before, after, d):
    """Areas on either side of a level of a straight line from ``before`` above it to ``after``: up to it and behind."""
    if (before < 0.0) == (after < 0.0):
        return 0.5 * abs(before + after) * d, 0.0
    share = before / (before - after)
    return 0.5 * abs(before) * share * d, 0.5 * abs(after) * (1.0 - share) * d


@part
def _least_part(line, first, m, level):
    """Into how many parts a level cuts the points from ``first`` on, of which one below it is the first.

    Returns their number and, of the one of least area, that area, its first point and the one after it. A part below
    the level from the first point on does not count, nor one above it up to the last.
    """
    x, y = line
    parts = 1 if y[first] < level else 2
    least = math.inf
    least_from = least_to = start = first
    area = 0.0
    for i in range(first + 1, m + 1):
        rest = 0.0
        if i < m:
            added, rest = _areas(y[i - 1] - level, y[i] - level, x[i] - x[i - 1])
            area += added
            if (y[i - 1] < level) == (y[i] < level):
                continue
        is_end = i == m if y[i - 1] >= level else start == first
        if area < least and not is_end:
            least, least_from, least_to = area, start, i
        parts += 1 if i < m else 0
        start = i
        area = rest
    return parts, least, least_from, least_to


@part
def cross_thrice(line, first, m, level):
    """Make p pass a level up, down and up again at most, from the point ``first`` on.

    As long as it passes it more often, the part of the polyline on one side of the level that has the least area is put
    at it, or just below. A part that has none but by a rounding goes in any case, and elsewhere p stays what it is.
    """
    while True:
        parts, least, least_from, least_to = _least_part(line, first, m, level)
        if least == math.inf or (parts <= _MOST_PARTS and least > _NO_AREA * line.w[m - 1]):
            return
        put = level - JUST_BELOW if line.p[least_from] >= level else level
        for i in range(least_from, least_to):
            line.p[i] = put


@leaf
def _between(before_w, before_p, w, p, at_w):
    """Costate at a squared speed on the straight line between two points."""
    d = w - before_w
    return before_p + (at_w - before_w) / d * (p - before_p) if d > 0.0 else before_p


@part
def _fall_to(line, n, w):
    """By how much V falls from the last of ``n`` points down to a squared speed, and p there."""
    x, y = line
    fall = 0.0
    for i in range(n - 1, 0, -1):
        if x[i - 1] <= w:
            p = _between(x[i - 1], y[i - 1], x[i], y[i], w)
            return fall + 0.5 * (p + y[i]) * (x[i] - w), p
        fall += 0.5 * (y[i - 1] + y[i]) * (x[i] - x[i - 1])
    return fall, y[0]


@part
def _excess(line, n, fold, before_w, before_p, w, p, at_w):
    """V at a squared speed between an image and the next one, less V of the points kept.

    ``fold`` is V at the image less V at the last of the points kept, the peak.
    """
    at_p = _between(before_w, before_p, w, p, at_w)
    return fold + 0.5 * (before_p + at_p) * (at_w - before_w) + _fall_to(line, n, at_w)[0]


@part
def _cross(line, n, fold, before_w, before_p, w, p):
    """Go over to the branch that leads from an image to the next one, where its V is no more; the number of points."""
    x, y = line
    low_w = before_w
    high_w = min(w, x[n - 1])
    if _excess(line, n, fold, before_w, before_p, w, p, low_w) <= 0.0:
        high_w = low_w
    for _ in range(_HALVINGS):
        middle = 0.5 * (low_w + high_w)
        if _excess(line, n, fold, before_w, before_p, w, p, middle) > 0.0:
            low_w = middle
        else:
            high_w = middle
    kept_p = _fall_to(line, n, high_w)[1]
    while n > 0 and x[n - 1] >= high_w:
        n -= 1
    x[n], y[n] = high_w, kept_p
    x[n + 1], y[n + 1] = high_w, _between(before_w, before_p, w, p, high_w)
    return n + 2


@part
def _fold(line, n, i, m):
    """Go on from the image i, which turns back behind the last of ``n`` points; the next image, and number of points.

    Where p rises on the way back the images stay as they are, up to where they come again.
    """
    x, y = line
    peak_w = before_w = x[n - 1]
    before_p = y[n - 1]
    fold = 0.0
    comes = False
    for j in range(i, m):
        w = x[j]
        p = y[j]
        if w > before_w:
            if not comes and _excess(line, n, fold, before_w, before_p, w, p, before_w) <= 0.0:
                break
            comes = True
            if w >= peak_w or _excess(line, n, fold, before_w, before_p, w, p, w) <= 0.0:
                return j, _cross(line, n, fold, before_w, before_p, w, p)
        fold += 0.5 * (before_p + p) * (w - before_w)
        before_w = w
        before_p = p
    if comes:
        return m, n
    while i < m and x[i] < peak_w:
        x[n], y[n] = x[i], y[i]
        n += 1
        i += 1
    return i, n


@part
def unfold(line, m):
    """Where images turn back and come again take the branch of less V; returns the number of points left.

    V changes by p·dw along the images, too: it is the same where they have cut off equal areas on either side. If it is
    nowhere, the branch that comes again goes on from the peak, or ends before it and is left out.
    """
    x, y = line
    n = 1
    i = 1
    while i < m:
        if x[i] < x[n - 1]:
            i, n = _fold(line, n, i, m)
            if i == m:
                return n
        x[n], y[n] = x[i], y[i]
        n += 1
        i += 1
    return n
