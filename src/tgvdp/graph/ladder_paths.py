"""Optimal paths over a ladder: one of them, and how many there are (see `tgvdp.graph.ladder` for the graph)."""

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel
from tgvdp.graph.ladder import LIMB_BITS, Ints


@kernel
def one_path(low: Ints, start: Ints, moves: NDArray[np.uint8], rise: int, fall: int) -> Ints:
    """Follow cheapest moves from the start, up before along before down.

    Returns
    -------
    (N+1,) int64
        Levels of the path.
    """
    steps = low.shape[0] - 1
    levels = np.zeros(steps + 1, dtype=np.int64)
    v, s = 0, 0
    for k in range(steps):
        move = moves[start[k, v] + s - low[k, v]]
        if move & 1:
            v += rise
        elif not move & 2:
            v -= fall
        s += v
        levels[k + 1] = v
    return levels


@kernel
def roughly_count(low: Ints, start: Ints, moves: NDArray[np.uint8], rise: int, fall: int) -> np.float64:
    """Number of optimal paths in floating point, perhaps infinite: how many limbs the exact number needs."""
    layers, levels = low.shape
    widest = np.max(start[:, levels] - start[:, 0])
    now, after = np.zeros(widest), np.zeros(widest)
    now[0 - low[0, 0]] = 1.0
    for k in range(layers - 1):
        after[:] = 0.0
        first, first_after = start[k, 0], start[k + 1, 0]
        for v in range(levels):
            for i in range(start[k, v], start[k, v + 1]):
                if now[i - first] > 0.0:
                    s = low[k, v] + i - start[k, v]
                    for kind in range(3):
                        if moves[i] & (1 << kind):
                            w = v + rise if kind == 0 else (v if kind == 1 else v - fall)
                            after[start[k + 1, w] - first_after + s + w - low[k + 1, w]] += now[i - first]
        now, after = after, now
    total: np.float64 = now[: start[layers - 1, 1] - start[layers - 1, 0]].sum()
    return total


@kernel
def count(low: Ints, start: Ints, moves: NDArray[np.uint8], rise: int, fall: int, limbs: int) -> Ints:
    """Count the optimal paths exactly.

    Parameters
    ----------
    low : (N+1, H+1) int64
        Lowest height of each window.
    start : (N+1, H+2) int64
        Where each window starts in ``moves``.
    moves : (states,) uint8
        As `tgvdp.graph.ladder.cheapest_moves` leaves them.
    rise, fall : int
    limbs : int
        Limbs of `LIMB_BITS` bits that the count needs.

    Returns
    -------
    (limbs,) int64
        Lowest limb first.
    """
    layers, levels = low.shape
    widest = np.max(start[:, levels] - start[:, 0])
    now = np.zeros((widest, limbs), dtype=np.int64)
    after = np.zeros((widest, limbs), dtype=np.int64)
    now[0 - low[0, 0], 0] = 1
    mask = (np.int64(1) << LIMB_BITS) - 1
    for k in range(layers - 1):
        after[:] = 0
        first, first_after = start[k, 0], start[k + 1, 0]
        for v in range(levels):
            for i in range(start[k, v], start[k, v + 1]):
                paths = now[i - first]
                carry = np.int64(0)
                for limb in range(limbs):  # at most three sums came in since the last carry
                    carry += paths[limb]
                    paths[limb] = carry & mask
                    carry >>= LIMB_BITS
                if not paths.any():
                    continue
                s = low[k, v] + i - start[k, v]
                for kind in range(3):
                    if moves[i] & (1 << kind):
                        w = v + rise if kind == 0 else (v if kind == 1 else v - fall)
                        target = after[start[k + 1, w] - first_after + s + w - low[k + 1, w]]
                        for limb in range(limbs):
                            target[limb] += paths[limb]
        now, after = after, now
    total: Ints = now[: start[layers - 1, 1] - start[layers - 1, 0]].sum(axis=0)
    return total
