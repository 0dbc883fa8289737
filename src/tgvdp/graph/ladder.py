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

from tgvdp._jit import kernel

Ints: TypeAlias = NDArray[np.int64]
Floats: TypeAlias = NDArray[np.float64]

#: Above every cost of a path (which the caller keeps below 2⁶¹), and safe to add a cost to.
NEVER = np.int64(1) << np.int64(62)

#: Counts of paths are kept in limbs of so many bits: three limbs and a carry still fit into 64.
LIMB_BITS = 60

RISE, STAY, FALL = 1, 2, 4


@kernel
def prices_of_suffixes(caps: Ints, rise: int, fall: int, cost: Ints, multipliers: Floats) -> Floats:
    """Cheapest cost + μ·height from every (k, v) to the end.

    Parameters
    ----------
    caps : (N+1,) int64
        Largest level of each layer; 0 in the first and the last.
    rise, fall : int
        Levels of one step up and one step down.
    cost : (3, H+1) int64
        Of a step up, along and down from each level.
    multipliers : (M,) float64

    Returns
    -------
    (N+1, M, H+1) float64, infinite where no suffix exists.
    """
    steps = caps.size - 1
    top = cost.shape[1] - 1
    price = np.full((steps + 1, multipliers.size, top + 1), np.inf)
    price[steps, :, 0] = 0.0
    for k in range(steps - 1, -1, -1):
        after_cap = min(caps[k + 1], top)
        for m in range(multipliers.size):
            mu = multipliers[m]
            after, now = price[k + 1, m], price[k, m]
            for v in range(min(caps[k], top) + 1):
                best = np.inf
                if v <= after_cap:
                    best = cost[1, v] + mu * v + after[v]
                if v + rise <= after_cap:
                    best = min(best, cost[0, v] + mu * (v + rise) + after[v + rise])
                if v >= fall and v - fall <= after_cap:
                    best = min(best, cost[2, v] + mu * (v - fall) + after[v - fall])
                now[v] = best
    return price


@kernel
def prices_of_prefixes(caps: Ints, rise: int, fall: int, cost: Ints, multipliers: Floats) -> Floats:
    """Cheapest cost + μ·height from the start to every (k, v); arguments and result as `prices_of_suffixes`."""
    steps = caps.size - 1
    top = cost.shape[1] - 1
    price = np.full((steps + 1, multipliers.size, top + 1), np.inf)
    price[0, :, 0] = 0.0
    for k in range(steps):
        before_cap = min(caps[k], top)
        for m in range(multipliers.size):
            mu = multipliers[m]
            now, after = price[k, m], price[k + 1, m]
            for v in range(min(caps[k + 1], top) + 1):
                best = np.inf
                if v <= before_cap:
                    best = now[v] + cost[1, v]
                if v >= rise and v - rise <= before_cap:
                    best = min(best, now[v - rise] + cost[0, v - rise])
                if v + fall <= before_cap:
                    best = min(best, now[v + fall] + cost[2, v + fall])
                after[v] = best + mu * v
    return price


@kernel
def cheapest_path(caps: Ints, rise: int, fall: int, cost: Ints, multiplier: float) -> tuple[np.int64, np.int64]:
    """Cost and height of one path of least cost + μ·height, for which `prices_of_suffixes` must be finite.

    Returns
    -------
    cost, height : int64
    """
    single = np.array([multiplier])
    price = prices_of_suffixes(caps, rise, fall, cost, single)
    total, height, v = np.int64(0), np.int64(0), 0
    for k in range(caps.size - 1):
        after = price[k + 1, 0]
        best, move, arrival = np.inf, 0, 0
        for kind in range(3):
            w = v + rise if kind == 0 else (v if kind == 1 else v - fall)
            if 0 <= w < after.size:
                worth = cost[kind, v] + multiplier * w + after[w]
                if worth < best:
                    best, move, arrival = worth, kind, w
        total += cost[move, v]
        v = arrival
        height += v
    return total, height


@kernel
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


@kernel
def windows(
    low_height: int,
    high_height: int,
    prefixes: Floats,
    suffixes: Floats,
    multipliers: Floats,
    heights: Ints,
    bound: float,
) -> tuple[Ints, Ints]:
    """Heights of each (k, v) that a path of cost ≤ bound may have.

    Parameters
    ----------
    low_height, high_height : int
        Range of the total height.
    prefixes, suffixes : (N+1, M, H+1) float64
        Prices of prefixes and suffixes.
    multipliers : (M,) float64
    heights : (2, N+1, H+1) int64
        Least and largest heights still to come.
    bound : float
        Upper bound on the cost, with the slack that rounding needs.

    Returns
    -------
    low, high : (N+1, H+1) int64
        The window; empty where low > high.
    """
    layers, several, levels = prefixes.shape
    low = np.ones((layers, levels), dtype=np.int64)
    high = np.zeros((layers, levels), dtype=np.int64)
    for k in range(layers):
        for v in range(levels):
            if not (prefixes[k, 0, v] < np.inf and suffixes[k, 0, v] < np.inf):
                continue
            # As floats: the bounds below are quotients.
            least = float(low_height - heights[1, k, v])
            most = float(high_height - heights[0, k, v])
            for m in range(several):
                mu, prefix = multipliers[m], prefixes[k, m, v]
                for n in range(several):
                    nu = multipliers[n]
                    reach = nu * (high_height if nu > 0.0 else low_height)
                    room = bound - prefix - suffixes[k, n, v] + reach
                    slope = nu - mu
                    if slope > 0.0:
                        most = min(most, room / slope)
                    elif slope < 0.0:
                        least = max(least, room / slope)
                    elif room < 0.0:
                        most = -1.0
            low[k, v] = max(0, int(np.ceil(least - 1e-6)))
            high[k, v] = int(np.floor(most + 1e-6)) if most >= 0.0 else -1
    return low, high


@kernel
def cheapest_moves(
    low: Ints,
    high: Ints,
    start: Ints,
    low_height: int,
    high_height: int,
    rise: int,
    fall: int,
    cost: Ints,
    moves: NDArray[np.uint8],
) -> np.int64:
    """Dynamic program over the states in the windows, from the end to the start.

    Parameters
    ----------
    low, high : (N+1, H+1) int64
        Windows.
    start : (N+1, H+2) int64
        Where each window starts in ``moves``; the last column is the end of the layer.
    low_height, high_height, rise, fall : int
    cost : (3, H+1) int64
    moves : (states,) uint8
        Filled in place: all moves that are cheapest, as a sum of RISE, STAY and FALL; 0 where there is none.

    Returns
    -------
    int64
        Cost of the cheapest path from level 0 and height 0 in layer 0; NEVER where there is none.
    """
    layers, levels = low.shape
    widest = np.max(start[:, levels] - start[:, 0])
    after, now = np.empty(widest, dtype=np.int64), np.empty(widest, dtype=np.int64)
    moves[:] = 0
    for s in range(low[layers - 1, 0], high[layers - 1, 0] + 1):
        after[s - low[layers - 1, 0]] = 0 if low_height <= s <= high_height else NEVER
    for k in range(layers - 2, -1, -1):
        first, first_after = start[k, 0], start[k + 1, 0]
        for v in range(levels):
            begin, end = start[k, v] - first, start[k, v + 1] - first
            now[begin:end] = NEVER
            if begin == end:
                continue
            for kind in range(3):
                w = v + rise if kind == 0 else (v if kind == 1 else v - fall)
                if not 0 <= w < levels or start[k + 1, w] == start[k + 1, w + 1]:
                    continue
                step, bit = cost[kind, v], np.uint8(1 << kind)
                # Heights s of this window whose successor s + w lies in the other.
                lowest = max(low[k, v], low[k + 1, w] - w)
                highest = min(high[k, v], high[k + 1, w] - w)
                here = begin - low[k, v]
                there = start[k + 1, w] - first_after + w - low[k + 1, w]
                for s in range(lowest, highest + 1):
                    ahead = after[there + s]
                    if ahead < NEVER:
                        value = ahead + step
                        if value < now[here + s]:
                            now[here + s] = value
                            moves[first + here + s] = bit
                        elif value == now[here + s]:
                            moves[first + here + s] |= bit
        after, now = now, after
    found = start[0, 0] < start[0, 1] and low[0, 0] == 0
    return after[0] if found else NEVER
