"""Paths over a ladder of levels in a fixed number of steps, whose total height is given: the kernels of the exact DP.

The graph has layers k = 0..N of levels v = 0..H. A step goes ``rise`` levels up, stays, or goes ``fall`` levels down,
at a cost that depends on the level it starts from; each layer has a cap. A path starts and ends at level 0, and its
height s = Σ v_k must end in a given range. In the binary model levels are speeds and the height is the distance.

States (k, v, s) would be too many: a Lagrangian bound keeps, for each (k, v), one window of heights. For any
multipliers μ and ν, with F_μ the cheapest cost + μ·height of a prefix and B_ν that of a suffix (a level counts on
arrival),

    cost of a path through (k, v, s) ≥ F_μ(k, v) − μ·s + B_ν(k, v) − ν·(S − s),

so its largest over all μ and ν is convex in s, and the heights where it stays below an upper bound form an interval.
Costs are whole numbers: values, ties and counts of optimal paths are exact.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import allocating

Ints: TypeAlias = NDArray[np.int64]
Floats: TypeAlias = NDArray[np.float64]

#: Above every cost of a path (which the caller keeps below 2⁶¹), and safe to add a cost to.
NEVER = np.int64(1) << np.int64(62)

#: Counts of paths are kept in limbs of so many bits: three limbs and a carry still fit into 64.
LIMB_BITS = 60

RISE, STAY, FALL = 1, 2, 4


@allocating
def prices_of_suffixes(caps: Ints, rise: int, fall: int, cost: Ints, touch: int, multipliers: Floats) -> Floats:
    """Cheapest cost + μ·height from every (k, v) to the end, of paths that reach the level ``touch`` at least once.

    Parameters
    ----------
    caps : (N+1,) int64
        Largest level of each layer; 0 in the first and the last.
    rise, fall : int
        Levels of one step up and one step down.
    cost : (3, H+1) int64
        Of a step up, along and down from each level; higher levels are forbidden.
    touch : int
        Paths that never reach it do not count; 0 for all paths.
    multipliers : (M,) float64

    Returns
    -------
    (N+1, 2, M, H+1) float64
        [:, 0] where the level is still to be reached, [:, 1] where it has been; infinite where no suffix exists.
    """
    steps = caps.size - 1
    top = cost.shape[1] - 1
    price = np.full((steps + 1, 2, multipliers.size, top + 1), np.inf)
    price[steps, 1, :, 0] = 0.0
    for k in range(steps - 1, -1, -1):
        after_cap = min(caps[k + 1], top)
        for m in range(multipliers.size):
            mu = multipliers[m]
            for reached in range(2):
                now = price[k, reached, m]
                for v in range(min(caps[k], top, top if reached else touch - 1) + 1):
                    best = np.inf
                    for kind in range(3):
                        w = v + rise if kind == 0 else (v if kind == 1 else v - fall)
                        if 0 <= w <= after_cap:
                            after = price[k + 1, 1 if reached or w >= touch else 0, m, w]
                            best = min(best, cost[kind, v] + mu * w + after)
                    now[v] = best
    return price


@allocating
def prices_of_prefixes(caps: Ints, rise: int, fall: int, cost: Ints, touch: int, multipliers: Floats) -> Floats:
    """Cheapest cost + μ·height from the start to every (k, v); arguments and result as `prices_of_suffixes`."""
    steps = caps.size - 1
    top = cost.shape[1] - 1
    price = np.full((steps + 1, 2, multipliers.size, top + 1), np.inf)
    price[0, 0 if touch > 0 else 1, :, 0] = 0.0
    for k in range(steps):
        before_cap = min(caps[k], top)
        for m in range(multipliers.size):
            mu = multipliers[m]
            for w in range(min(caps[k + 1], top) + 1):
                untouched, touched = np.inf, np.inf
                for kind in range(3):
                    v = w - rise if kind == 0 else (w if kind == 1 else w + fall)
                    if 0 <= v <= before_cap:
                        untouched = min(untouched, price[k, 0, m, v] + cost[kind, v])
                        touched = min(touched, price[k, 1, m, v] + cost[kind, v])
                if w >= touch:
                    touched, untouched = min(touched, untouched), np.inf
                price[k + 1, 0, m, w] = untouched + mu * w
                price[k + 1, 1, m, w] = touched + mu * w
    return price


@allocating
def cheapest_path(
    caps: Ints, rise: int, fall: int, cost: Ints, touch: int, multiplier: float
) -> tuple[np.int64, np.int64]:
    """Cost and height of one path of least cost + μ·height among those that reach ``touch``.

    Returns
    -------
    cost, height : int64
        NEVER and 0 where there is no such path.
    """
    price = prices_of_suffixes(caps, rise, fall, cost, touch, np.array([multiplier]))
    total, height, v = np.int64(0), np.int64(0), 0
    reached = 0 if touch > 0 else 1
    if not price[0, reached, 0, 0] < np.inf:
        return NEVER, height
    for k in range(caps.size - 1):
        best, move, arrival = np.inf, 0, 0
        for kind in range(3):
            w = v + rise if kind == 0 else (v if kind == 1 else v - fall)
            if 0 <= w < cost.shape[1]:
                worth = cost[kind, v] + multiplier * w + price[k + 1, 1 if reached or w >= touch else 0, 0, w]
                if worth < best:
                    best, move, arrival = worth, kind, w
        total += cost[move, v]
        v = arrival
        height += v
        if v >= touch:
            reached = 1
    return total, height


@allocating
def heights_of_suffixes(caps: Ints, rise: int, fall: int, top: int, sign: int) -> Ints:
    """Least (sign 1) or largest (sign −1) height still to come from every (k, v): (N+1, top+1) int64, else ±NEVER."""
    steps = caps.size - 1
    height = np.full((steps + 1, top + 1), sign * NEVER)
    height[steps, 0] = 0
    for k in range(steps - 1, -1, -1):
        after_cap = min(caps[k + 1], top)
        for v in range(min(caps[k], top) + 1):
            best = NEVER
            for w in (v - fall, v, v + rise):
                if 0 <= w <= after_cap and abs(height[k + 1, w]) < NEVER:
                    best = min(best, sign * (height[k + 1, w] + w))
            height[k, v] = sign * best
    return height


@allocating
def windows(
    low_height: int,
    high_height: int,
    prefixes: Floats,
    suffixes: Floats,
    multipliers: Floats,
    heights: Ints,
    bound: float,
) -> tuple[Ints, Ints]:
    """Heights of each (k, reached, v) that a path of cost ≤ bound may have.

    Parameters
    ----------
    low_height, high_height : int
        Range of the total height.
    prefixes, suffixes : (N+1, 2, M, L) float64
        Prices.
    multipliers : (M,) float64
    heights : (2, N+1, ≥ L) int64
        Least and largest heights still to come.
    bound : float
        Upper bound on the cost, with the slack that rounding needs.

    Returns
    -------
    low, high : (N+1, 2·L) int64
        The windows; empty where low > high. Row L + v is that of level v when the level to touch has been reached, row
        v that before.
    """
    layers, _, several, levels = prefixes.shape
    low = np.ones((layers, 2 * levels), dtype=np.int64)
    high = np.zeros((layers, 2 * levels), dtype=np.int64)
    for k in range(layers):
        for v in range(levels):
            for reached in range(2):
                if not (prefixes[k, reached, 0, v] < np.inf and suffixes[k, reached, 0, v] < np.inf):
                    continue
                # As floats: the bounds below are quotients.
                least = max(0.0, float(low_height - heights[1, k, v]))
                most = float(high_height - heights[0, k, v])
                for m in range(several):
                    mu, prefix = multipliers[m], prefixes[k, reached, m, v]
                    for n in range(several):
                        nu = multipliers[n]
                        reach = nu * (high_height if nu > 0.0 else low_height)
                        room = bound - prefix - suffixes[k, reached, n, v] + reach
                        slope = nu - mu
                        if slope > 0.0:
                            most = min(most, room / slope)
                        elif slope < 0.0:
                            least = max(least, room / slope)
                        elif room < 0.0:
                            most = -1.0
                if least <= most + 2e-6:
                    low[k, reached * levels + v] = int(np.ceil(least - 1e-6))
                    high[k, reached * levels + v] = int(np.floor(most + 1e-6))
    return low, high


@allocating
def _relax(best: Ints, moves: NDArray[np.uint8], ahead: Ints, step: int, bit: np.uint8) -> None:
    """Improve the (n,) best costs by a move of cost ``step`` to states of costs ``ahead``; modified in place.

    There is no branch, so that this runs on several states at once: three times as fast as testing whether a state
    ahead can reach the end. (Compiled like what makes arrays, by numba's own steps: five times as fast as otherwise,
    where states come one by one.) Costs of states that cannot drift a little below NEVER therefore, and their moves
    mean nothing; no path from a state that can leads there.
    """
    for i in range(best.size):
        value = ahead[i] + step
        known = best[i]
        kept = moves[i] if value >= known else np.uint8(0)
        moves[i] = kept | bit if value <= known else kept
        best[i] = min(value, known)


@allocating
def cheapest_moves(
    low: Ints,
    high: Ints,
    start: Ints,
    low_height: int,
    high_height: int,
    rise: int,
    fall: int,
    cost: Ints,
    touch: int,
    moves: NDArray[np.uint8],
) -> np.int64:
    """Dynamic program over the states in the windows, from the end to the start.

    Parameters
    ----------
    low, high : (N+1, 2·L) int64
        Windows, as `windows` returns them.
    start : (N+1, 2·L+1) int64
        Where each window starts in ``moves``; the last column is the end of the layer.
    low_height, high_height, rise, fall : int
    cost : (3, L) int64
    touch : int
    moves : (states,) uint8
        Filled in place: all moves that are cheapest, as a sum of RISE, STAY and FALL; 0 where there is none.

    Returns
    -------
    int64
        Cost of the cheapest path from level 0 and height 0 in layer 0; NEVER where there is none.
    """
    layers, rows = low.shape
    levels = rows // 2
    widest = np.max(start[:, rows] - start[:, 0])
    after, now = np.full(widest, NEVER), np.empty(widest, dtype=np.int64)
    moves[:] = 0
    for s in range(max(low[layers - 1, levels], low_height), min(high[layers - 1, levels], high_height) + 1):
        after[start[layers - 1, levels] - start[layers - 1, 0] + s - low[layers - 1, levels]] = 0
    for k in range(layers - 2, -1, -1):
        first, first_after = start[k, 0], start[k + 1, 0]
        for row in range(rows):
            begin, end = start[k, row] - first, start[k, row + 1] - first
            if begin == end:
                continue
            now[begin:end] = NEVER
            v = row % levels
            for kind in range(3):
                w = v + rise if kind == 0 else (v if kind == 1 else v - fall)
                if not 0 <= w < levels:
                    continue
                target = w + levels if row >= levels or w >= touch else w
                # Heights s of this window whose successor s + w lies in the other.
                lowest = max(low[k, row], low[k + 1, target] - w)
                highest = min(high[k, row], high[k + 1, target] - w)
                if lowest > highest:
                    continue
                here = begin + lowest - low[k, row]
                there = start[k + 1, target] - first_after + w + lowest - low[k + 1, target]
                size = highest - lowest + 1
                _relax(
                    now[here : here + size], moves[first + here : first + here + size], after[there : there + size],
                    cost[kind, v], np.uint8(1 << kind),
                )  # fmt: skip
        after, now = now, after
    root = 0 if touch > 0 else levels
    found = low[0, root] == 0 and high[0, root] >= 0
    least = after[start[0, root] - start[0, 0]] if found else NEVER
    return least if least < NEVER // 2 else NEVER
