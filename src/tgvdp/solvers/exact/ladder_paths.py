"""Optimal paths over a ladder: one of them, and how many there are (see `tgvdp.solvers.exact.ladder` for the graph)."""

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import allocating, kernel
from tgvdp.solvers.exact.ladder import LIMB_BITS, Ints


@allocating
def one_path(low: Ints, start: Ints, moves: NDArray[np.uint8], rise: int, fall: int, touch: int) -> Ints:
    """Follow cheapest moves from the start, up before along before down; arguments as `count`.

    Returns
    -------
    (N+1,) int64
        Levels of the path.
    """
    steps, rows = low.shape[0] - 1, low.shape[1]
    path = np.zeros(steps + 1, dtype=np.int64)
    v, s, reached = 0, 0, touch == 0
    for k in range(steps):
        row = v + rows // 2 if reached else v
        move = moves[start[k, row] + s - low[k, row]]
        if move & 1:
            v += rise
        elif not move & 2:
            v -= fall
        s += v
        reached = reached or v >= touch
        path[k + 1] = v
    return path


#: Beyond all states.
_FAR = np.int64(1) << np.int64(62)


@allocating
def _nowhere(rows: int) -> Ints:
    """First and last state of each window that optimal paths reach, (rows, 2): none so far.

    Windows are much wider than what is reached.
    """
    reached = np.empty((rows, 2), dtype=np.int64)
    reached[:, 0], reached[:, 1] = _FAR, -1
    return reached


@kernel
def _widen(reached: Ints, state: int) -> None:
    reached[0] = min(reached[0], state)
    reached[1] = max(reached[1], state)


@allocating
def roughly_count(low: Ints, start: Ints, moves: NDArray[np.uint8], rise: int, fall: int, touch: int) -> np.float64:
    """Number of optimal paths in floating point, perhaps infinite: how many limbs the exact number needs."""
    layers, rows = low.shape
    levels = rows // 2
    widest = np.max(start[:, rows] - start[:, 0])
    now, after = np.zeros(widest), np.zeros(widest)
    here, ahead = _nowhere(rows), _nowhere(rows)
    root = 0 if touch > 0 else levels
    origin = start[0, root] - low[0, root]
    now[origin - start[0, 0]] = 1.0
    here[root, 0], here[root, 1] = origin, origin
    for k in range(layers - 1):
        first, first_after = start[k, 0], start[k + 1, 0]
        for row in range(rows):
            v = row % levels
            for i in range(here[row, 0], here[row, 1] + 1):
                if now[i - first] > 0.0:
                    s = low[k, row] + i - start[k, row]
                    for kind in range(3):
                        if moves[i] & (1 << kind):
                            w = v + rise if kind == 0 else (v if kind == 1 else v - fall)
                            target = w + levels if row >= levels or w >= touch else w
                            there = start[k + 1, target] + s + w - low[k + 1, target]
                            after[there - first_after] += now[i - first]
                            _widen(ahead[target], there)
            if here[row, 0] <= here[row, 1]:
                now[here[row, 0] - first : here[row, 1] + 1 - first] = 0.0
                here[row, 0], here[row, 1] = _FAR, -1
        now, after, here, ahead = after, now, ahead, here
    total: np.float64 = now.sum()
    return total


@allocating
def count(low: Ints, start: Ints, moves: NDArray[np.uint8], rise: int, fall: int, touch: int, limbs: int) -> Ints:
    """Count the optimal paths exactly.

    Parameters
    ----------
    low : (N+1, 2·L) int64
        Lowest height of each window.
    start : (N+1, 2·L+1) int64
        Where each window starts in ``moves``.
    moves : (states,) uint8
        As `tgvdp.solvers.exact.ladder.cheapest_moves` leaves them.
    rise, fall, touch : int
    limbs : int
        Limbs of `LIMB_BITS` bits that the count needs.

    Returns
    -------
    (limbs,) int64
        Lowest limb first.
    """
    layers, rows = low.shape
    levels = rows // 2
    widest = np.max(start[:, rows] - start[:, 0])
    now = np.zeros((widest, limbs), dtype=np.int64)
    after = np.zeros((widest, limbs), dtype=np.int64)
    here, ahead = _nowhere(rows), _nowhere(rows)
    root = 0 if touch > 0 else levels
    origin = start[0, root] - low[0, root]
    now[origin - start[0, 0], 0] = 1
    here[root, 0], here[root, 1] = origin, origin
    mask = (np.int64(1) << LIMB_BITS) - 1
    for k in range(layers - 1):
        first, first_after = start[k, 0], start[k + 1, 0]
        for row in range(rows):
            v = row % levels
            for i in range(here[row, 0], here[row, 1] + 1):
                paths = now[i - first]
                carry = np.int64(0)
                for limb in range(limbs):  # at most three sums came in since the last carry
                    carry += paths[limb]
                    paths[limb] = carry & mask
                    carry >>= LIMB_BITS
                if not paths.any():
                    continue
                s = low[k, row] + i - start[k, row]
                for kind in range(3):
                    if moves[i] & (1 << kind):
                        w = v + rise if kind == 0 else (v if kind == 1 else v - fall)
                        target = w + levels if row >= levels or w >= touch else w
                        there = start[k + 1, target] + s + w - low[k + 1, target]
                        sums = after[there - first_after]
                        for limb in range(limbs):
                            sums[limb] += paths[limb]
                        _widen(ahead[target], there)
            if here[row, 0] <= here[row, 1]:
                now[here[row, 0] - first : here[row, 1] + 1 - first] = 0
                here[row, 0], here[row, 1] = _FAR, -1
        now, after, here, ahead = after, now, ahead, here
    total: Ints = now.sum(axis=0)
    return total
