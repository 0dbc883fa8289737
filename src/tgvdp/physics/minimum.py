"""The least value of a/v + b0 + b1·v + b2·v² + b3·v³ over a range of speeds, from below."""

import math

from tgvdp._jit import kernel, leaf


@leaf
def _value(a, b0, b1, b2, b3, v):
    return a / v + b0 + v * (b1 + v * (b2 + v * b3))


@leaf
def _slope(a, b1, b2, b3, v):
    """v² times the derivative of `_value`."""
    return -a + v * v * (b1 + v * (2.0 * b2 + v * 3.0 * b3))


@kernel
def _interior_minimum(a, b0, b1, b2, b3, lo, hi):
    """Lower bound of the minimum between ``lo`` and ``hi``, where `_slope` rises through its only root.

    Newton's rule with bisection as its guard. The slope is monotone, hence |v²·H'| between the root and the last
    point is at most its value g there: H at the root is at least H there − |g|·(width of the bracket)/(its lower end)².
    """
    v = 0.5 * (lo + hi)
    if b1 == 0.0 and b3 == 0.0:
        v = min(max((a / (2.0 * b2)) ** (1.0 / 3.0), lo), hi)
    for _ in range(60):
        g = _slope(a, b1, b2, b3, v)
        if g < 0.0:
            lo = v
        else:
            hi = v
        curve = v * (2.0 * b1 + v * (6.0 * b2 + v * 12.0 * b3))
        step = g / curve if curve > 0.0 else math.inf
        if abs(step) <= 1e-9 * v:
            break
        v -= step
        if not lo < v < hi:
            v = 0.5 * (lo + hi)
    below = v * (1.0 - 1e-8)
    above = v * (1.0 + 1e-8)
    if below > lo and _slope(a, b1, b2, b3, below) < 0.0:
        lo = below
    if above < hi and _slope(a, b1, b2, b3, above) > 0.0:
        hi = above
    g = abs(_slope(a, b1, b2, b3, v))
    return _value(a, b0, b1, b2, b3, v) - g * (hi - lo) / (lo * lo), v


@kernel
def least_on_piece(a, b0, b1, b2, b3, lo, hi, best, at):
    """Update the least value and where it is taken by those of a/v + b0 + b1·v + b2·v² + b3·v³ on [lo, hi]."""
    # Term by term: most pieces cannot hold the least value.
    rough = (
        min(a / lo if lo > 0.0 else 0.0, a / hi) + b0 + min(b1 * lo, b1 * hi)
        + min(b2 * lo * lo, b2 * hi * hi) + min(b3 * lo * lo * lo, b3 * hi * hi * hi)
    )  # fmt: skip
    if lo > 0.0 and rough > best + 1e-9 * abs(best):
        return best, at
    value = _value(a, b0, b1, b2, b3, hi)
    if value < best:
        best = value
        at = hi
    if lo > 0.0:
        value = _value(a, b0, b1, b2, b3, lo)
        if value < best:
            best = value
            at = lo
    # Between the roots of b1 + 3·b2·v + 6·b3·v² the slope is monotone.
    first = hi
    second = hi
    if b3 != 0.0:
        discriminant = 9.0 * b2 * b2 - 24.0 * b1 * b3
        if discriminant > 0.0:
            q = -0.5 * (3.0 * b2 + math.copysign(math.sqrt(discriminant), b2))
            first = min(q / (6.0 * b3), b1 / q) if q != 0.0 else 0.0
            second = max(q / (6.0 * b3), b1 / q) if q != 0.0 else 0.0
    elif b2 != 0.0:
        first = -b1 / (3.0 * b2)
    first = min(max(first, lo), hi)
    second = min(max(second, first), hi)
    for part in range(3):
        u = lo if part == 0 else (first if part == 1 else second)
        v = first if part == 0 else (second if part == 1 else hi)
        if v <= u:
            continue
        if u == 0.0:  # the slope is −a < 0 there
            u = v
            while _slope(a, b1, b2, b3, u) >= 0.0:
                u *= 0.5
            if u == v:
                continue
            v = 2.0 * u
        if _slope(a, b1, b2, b3, u) < 0.0 < _slope(a, b1, b2, b3, v):
            value, where = _interior_minimum(a, b0, b1, b2, b3, u, v)
            if value < best:
                best = value
                at = where
    return best, at
