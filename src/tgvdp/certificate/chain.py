"""The top of a concave function along a chain of costates, by dynamic programming on its derivative.

Unknowns are the costates at the two ends of each cell, 2k and 2k + 1 for cell k. The function is a sum of three kinds
of terms: of each unknown, a parabola with downward steps of its slope at some levels; of the two ends of a cell, a
product; and between two cells p may jump, down at a price. Let V(p) be the best sum of all terms up to an
unknown, over all values of those before. V is concave, and its derivative a falling polyline, which is carried from
unknown to unknown by moving its points (Bellman 1957; Johnson, J. Comput. Graph. Stat. 22, 2013, for the chain of the
fused lasso):

- from x to y, the ends of a cell with the term −c·(x − x₀)·(y − y₀): at the best x, V' = c·(y − y₀), and there the
  derivative by y is −c·(x − x₀);
- from an end to the next start: p may have been higher at the price of ``cap``, and lower at none, so that all slopes
  are between the two; or it must be the same, and the polyline stays as it is.

Backwards from the best value of the last unknown each polyline tells the one before.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf, part

#: Points of a polyline at most, but for those that one unknown adds.
_MOST_POINTS = 60
#: Levels at which the slope of an unknown may step down.
LEVELS = 3


class Chain(NamedTuple):
    """Terms of a concave function of unknowns ``i``, and room for its solution, float64 where not said otherwise.

    Attributes
    ----------
    at : (n,)
        Values around which the terms are given.
    lowest, highest : (n,)
        Range of each unknown.
    slope : (n,)
        Slope below ``at``, from below, without the drops of levels that are below it.
    bend : (n,)
        Second derivative, negative.
    link : (n,)
        Coefficient c of the product of unknowns i − 1 and i, of odd i.
    cap : (n,)
        Price of a jump down to unknown i, of even i; infinite where it is the same as that before.
    level : (n, LEVELS)
        Values at which slopes step down, in increasing order.
    drop : (n, LEVELS)
        How far they do.
    best : (n,)
        The solution.
    p, d : (m,)
        Points of all polylines.
    first : (n + 1,) int64
        Where each begins.
    """

    at: NDArray[np.float64]
    lowest: NDArray[np.float64]
    highest: NDArray[np.float64]
    slope: NDArray[np.float64]
    bend: NDArray[np.float64]
    link: NDArray[np.float64]
    cap: NDArray[np.float64]
    level: NDArray[np.float64]
    drop: NDArray[np.float64]
    best: NDArray[np.float64]
    p: NDArray[np.float64]
    d: NDArray[np.float64]
    first: NDArray[np.int64]


def chain_of(unknowns: int) -> Chain:
    """Room for a chain of so many unknowns."""
    at, lowest, highest, slope, bend, link, cap, best = np.zeros((8, unknowns))
    p, d = np.empty((2, _MOST_POINTS * (unknowns + 8)))
    level, drop = np.zeros((2, unknowns, LEVELS))
    first = np.zeros(unknowns + 1, dtype=np.int64)
    return Chain(at, lowest, highest, slope, bend, link, cap, level, drop, best, p, d, first)


@part
def _put(chain, n, p, d):
    chain.p[n] = p
    chain.d[n] = d
    return n + 1


@part
def _thin(chain, start, n, loss):
    """Drop points that change V by no more than ``loss`` each, and more if there are still too many; the new end."""
    least = loss
    while True:
        smallest = math.inf
        kept = start + 1
        for j in range(start + 1, n):
            drop = False
            if j < n - 1:
                p0 = chain.p[kept - 1]
                d0 = chain.d[kept - 1]
                area = abs((chain.p[j + 1] - p0) * (chain.d[j] - d0) - (chain.p[j] - p0) * (chain.d[j + 1] - d0))
                drop = area <= least
                if not drop:
                    smallest = min(smallest, area)
            if not drop:
                chain.p[kept] = chain.p[j]
                chain.d[kept] = chain.d[j]
                kept += 1
        n = kept
        if n - start <= _MOST_POINTS:
            return n
        least = max(4.0 * least, 2.0 * smallest)


@part
def _add_own(chain, i, start, end, n, loss):
    """Add the terms of an unknown to points ``start`` to ``end`` − 1, p not falling, written from ``n`` on.

    Returns the end of what is written.
    """
    first = n
    slope, bend, at = chain.slope[i], chain.bend[i], chain.at[i]
    k = 0  # the next level; slopes have stepped down at all before
    while k < LEVELS and chain.level[i, k] < chain.p[start]:
        slope -= chain.drop[i, k]
        k += 1
    before, before_d = chain.p[start], chain.d[start]
    for j in range(start, end):
        p, d = chain.p[j], chain.d[j]
        while k < LEVELS and chain.level[i, k] < p:
            level = chain.level[i, k]
            here = before_d + (d - before_d) * (level - before) / (p - before)
            n = _put(chain, n, level, here + slope - bend * (level - at))
            while k < LEVELS and chain.level[i, k] == level:
                slope -= chain.drop[i, k]
                k += 1
            n = _put(chain, n, level, here + slope - bend * (level - at))
        n = _put(chain, n, p, d + slope - bend * (p - at))
        if k < LEVELS and chain.level[i, k] == p and (j + 1 == end or chain.p[j + 1] > p):
            while k < LEVELS and chain.level[i, k] == p:
                slope -= chain.drop[i, k]
                k += 1
            n = _put(chain, n, p, d + slope - bend * (p - at))
        before, before_d = p, d
    for j in range(first + 1, n):  # falling, but for rounding
        chain.d[j] = min(chain.d[j], chain.d[j - 1])
    return _thin(chain, first, n, loss)


@part
def _clip(chain, start, end, low, high, n):
    """Points ``start`` to ``end`` − 1, p not falling, within a range, and level beyond them; from ``n`` on."""
    if chain.p[start] > low:
        n = _put(chain, n, low, chain.d[start])
    if chain.p[start] > high:
        return _put(chain, n, high, chain.d[start])
    for j in range(start, end):
        p = chain.p[j]
        d = chain.d[j]
        if j > start and p > chain.p[j - 1]:
            before = chain.p[j - 1]
            rise = (d - chain.d[j - 1]) / (p - before)
            if before < low < p:
                n = _put(chain, n, low, chain.d[j - 1] + rise * (low - before))
            if before < high < p:
                n = _put(chain, n, high, chain.d[j - 1] + rise * (high - before))
        if low <= p <= high:
            n = _put(chain, n, p, d)
    last = chain.p[end - 1]
    if last < high:
        n = _put(chain, n, max(last, low), chain.d[end - 1])
        n = _put(chain, n, high, chain.d[end - 1])
    return n


@part
def _across_cell(chain, i, start, end, n):
    """Polyline of the unknown at the end of a cell, i, without its own terms, from that at its start."""
    link = chain.link[i]
    if abs(link) * (chain.highest[i] - chain.lowest[i]) * (chain.highest[i - 1] - chain.lowest[i - 1]) < 1e-300:
        n = _put(chain, n, chain.lowest[i], 0.0)
        return _put(chain, n, chain.highest[i], 0.0), n - 1
    moved = n
    for m in range(end - start):
        j = start + m if link < 0.0 else end - 1 - m
        n = _put(chain, n, chain.at[i] + chain.d[j] / link, -link * (chain.p[j] - chain.at[i - 1]))
    return _clip(chain, moved, n, chain.lowest[i], chain.highest[i], n), n


@part
def _across_jump(chain, i, start, end, n):
    """Polyline of the unknown at the start of a cell, i, without its own terms, from that at the end of the last.

    It is that between 0 and ``cap``: a jump down has that price, a jump up none.
    """
    cap = chain.cap[i]
    if cap == math.inf:
        return _clip(chain, start, end, chain.lowest[i], chain.highest[i], n), n
    first = n
    for j in range(start, end):
        p = chain.p[j]
        d = chain.d[j]
        if j > start:
            before = chain.d[j - 1]
            for bound in (cap, 0.0):
                if before > bound > d:
                    share = (before - bound) / (before - d)
                    n = _put(chain, n, chain.p[j - 1] + share * (p - chain.p[j - 1]), bound)
        if 0.0 <= d <= cap:
            n = _put(chain, n, p, d)
    if n == first:
        n = _put(chain, n, chain.p[start], cap if chain.d[end - 1] > cap else 0.0)
    return _clip(chain, first, n, chain.lowest[i], chain.highest[i], n), n


@part
def _meets(chain, start, end, d):
    """Where a falling polyline is d; an end of it where it is nowhere."""
    lo = start
    hi = end - 1
    if chain.d[lo] <= d:
        return chain.p[lo]
    if chain.d[hi] >= d:
        return chain.p[hi]
    while hi - lo > 1:
        middle = (lo + hi) // 2
        if chain.d[middle] > d:
            lo = middle
        else:
            hi = middle
    return chain.p[lo] + (chain.p[hi] - chain.p[lo]) * (chain.d[lo] - d) / (chain.d[lo] - chain.d[hi])


@kernel
def solve_chain(start, end, loss, chain):
    """Fill in the best values of the unknowns ``start`` to ``end``; ``start`` is even, ``end`` odd.

    Polylines are thinned by points that change the best sum by no more than ``loss`` each, or by more where there are
    too many.
    """
    n = 0
    chain.first[start] = 0
    n = _put(chain, n, chain.lowest[start], 0.0)
    n = _put(chain, n, chain.highest[start], 0.0)
    raw = 0
    raw_end = n
    for i in range(start, end + 1):
        if i > start:
            before = chain.first[i - 1]
            if i % 2 == 1:
                raw_end, raw = _across_cell(chain, i, before, n, n)
            else:
                raw_end, raw = _across_jump(chain, i, before, n, n)
        own_end = _add_own(chain, i, raw, raw_end, raw_end, loss)
        chain.first[i] = n
        for j in range(own_end - raw_end):  # over what they were made of
            chain.p[n + j] = chain.p[raw_end + j]
            chain.d[n + j] = chain.d[raw_end + j]
        n += own_end - raw_end
    chain.first[end + 1] = n
    chain.best[end] = _meets(chain, chain.first[end], n, 0.0)
    for i in range(end - 1, start - 1, -1):
        first, last = chain.first[i], chain.first[i + 1]
        after = chain.best[i + 1]
        if i % 2 == 0:
            chain.best[i] = _meets(chain, first, last, chain.link[i + 1] * (after - chain.at[i + 1]))
        elif chain.cap[i + 1] == math.inf:
            chain.best[i] = after
        else:
            highest = _meets(chain, first, last, 0.0)
            chain.best[i] = min(max(after, _meets(chain, first, last, chain.cap[i + 1])), max(highest, chain.p[first]))


@leaf
def own_gain(chain, i, p):
    """What the terms of one unknown alone gain from where they are given to p."""
    step = p - chain.at[i]
    gain = step * (chain.slope[i] - 0.5 * chain.bend[i] * step)
    for j in range(LEVELS):
        gain -= chain.drop[i, j] * (max(p - chain.level[i, j], 0.0) - max(chain.at[i] - chain.level[i, j], 0.0))
    return gain


@leaf
def link_gain(chain, i):
    """What the product of unknowns i − 1 and i gains by the solution, i odd."""
    return -chain.link[i] * (chain.best[i - 1] - chain.at[i - 1]) * (chain.best[i] - chain.at[i])
