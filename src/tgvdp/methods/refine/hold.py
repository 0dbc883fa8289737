"""Runs of a given time, improved by sweeps: the multiplier is what keeps the time.

Where the running time jumps over the multiplier, runs of the times between are no minima of E + λT, and sweeps at any
λ lead away from them. But among the speeds around a run there are runs of nearly its own time, and the cheapest of
these is found by the multiplier at which a faster one and a slower one cost the same: the largest of the lower bounds
min E + λ(T − t). Small steps keep the run from jumping.
"""

import math

from tgvdp._jit import kernel, part
from tgvdp.methods.refine.sweep import GAIN, NOBODY, program, speed

#: The multiplier is looked for upwards or downwards by this factor, so often at most, and then by so many chords; a
#: run is on a chord that it misses by that share of what it costs.
_FACTOR = 1.5
_FACTORS = 24
_CHORDS = 24
_ON_CHORD = 1e-12


@part
def _tried(train, tables, cells, low, fast, multiplier, half, step, start_w, w, scratch, into):
    """Put the steps of the best run around w into a row of ``scratch.around``; returns its time and energy.

    Both are infinite where no run around w is feasible.
    """
    if program(train, tables, cells, low, fast, multiplier, half, step, start_w, w, scratch) == math.inf:
        return math.inf, math.inf
    width = 2 * half + 1
    rows = scratch.known.shape[0] // width**2
    at = scratch.lowest[0]
    scratch.around[into, 0] = at
    seconds = 0.0
    joules = 0.0
    i = 0
    for k in range(w.shape[0] - 1):
        i = scratch.best[k, i]
        to = scratch.lowest[k + 1] + i
        slot = (k % rows * width + at % width) * width + to % width
        seconds += scratch.seconds[slot]
        joules += scratch.joules[slot]
        scratch.around[into, k + 1] = to
        at = to
    return seconds, joules


@part
def _tied(train, tables, cells, low, fast, multiplier, half, step, target_s, start_w, w, scratch):
    """Multiplier at which a run on each side of a time costs the same; what that is, J, and the row of the nearer one.

    The cost is infinite where all runs around w are on one side, and the row −1 where none is feasible.
    """
    quick, late, free = 0, 1, 2
    quick_s = -math.inf
    late_s = math.inf
    quick_j = 0.0
    late_j = 0.0
    for _ in range(_FACTORS):
        seconds, joules = _tried(train, tables, cells, low, fast, multiplier, half, step, start_w, w, scratch, free)
        if joules == math.inf:
            return multiplier, math.inf, -1
        if seconds > target_s:
            late, free, late_s, late_j = free, late, seconds, joules
            multiplier *= _FACTOR
        else:
            quick, free, quick_s, quick_j = free, quick, seconds, joules
            multiplier /= _FACTOR
        if quick_s > -math.inf and late_s < math.inf:
            break
    nearer = quick if target_s - quick_s <= late_s - target_s else late
    if quick_s == -math.inf or late_s == math.inf:
        return multiplier, math.inf, nearer
    cost = math.inf
    for _ in range(_CHORDS):
        chord = (quick_j - late_j) / (late_s - quick_s)
        cost = quick_j + chord * (quick_s - target_s)
        if chord <= 0.0:
            break
        multiplier = chord
        seconds, joules = _tried(train, tables, cells, low, fast, multiplier, half, step, start_w, w, scratch, free)
        if joules + multiplier * (seconds - target_s) >= cost - _ON_CHORD * abs(cost):
            break
        if seconds > target_s:
            late, free, late_s, late_j = free, late, seconds, joules
        else:
            quick, free, quick_s, quick_j = free, quick, seconds, joules
    return multiplier, cost, quick if target_s - quick_s <= late_s - target_s else late


@kernel
def hold(train, tables, cells, low, fast, multiplier, half, step, target_s, cost, most, w, start_w, scratch):
    """Improve a run by sweeps of one step that keep its time, until it is stationary, or has been swept so often.

    Parameters
    ----------
    train, tables, cells, low, fast, half, step, most, w, start_w, scratch
        As those of `tgvdp.methods.refine.sweep.descend`.
    multiplier : float
        Where to look for the multiplier first, J/s.
    target_s : float
        The running time, s; that of the run is near it.
    cost : float
        Energy at that time by the sweep before, J; infinite where there was none.

    Returns
    -------
    sweeps : int
    multiplier : float
        What the time costs, J/s.
    cost : float
        Energy at that time, J: between those of two runs, each a few steps away. Infinite where there are none; a run
        that is not feasible, and has no feasible ones around, stays.
    stationary : bool
    """
    scratch.steps[:] = 0
    scratch.known[:] = NOBODY
    for done in range(most):
        before = cost
        multiplier, cost, row = _tied(
            train, tables, cells, low, fast, multiplier, half, step, target_s, start_w, w, scratch
        )
        for k in range(1, w.shape[0] if row >= 0 else 0):
            scratch.steps[k] = scratch.around[row, k]
            w[k] = speed(start_w[k], scratch.steps[k], step, low[k], fast[k])
        if cost == math.inf or before - cost <= GAIN * abs(cost):
            return done + 1, multiplier, cost, True
    return most, multiplier, cost, False
