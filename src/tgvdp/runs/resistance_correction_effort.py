"""Kernels that keep a followed run within the efforts that it may use (see `runs.resistance_correction`)."""

import math

from tgvdp._jit import leaf, part
from tgvdp.line.walk import piece_from
from tgvdp.model.track import POWERED
from tgvdp.physics.forces import effort_at, mean_brake, mean_effort, mean_rate, mean_resistance, unpowered
from tgvdp.physics.roots import Bracket, narrowed, secant
from tgvdp.runs.effort_jumps import NO_EFFORT

#: No more than this share of w is taken from a run: it is next to standstill there.
MOST_TAKEN = 0.75
#: Share of the effort by which a run may exceed that of the run on steps, and its limit.
_SPARE = 3e-4
#: An effort that is below this share of the starting effort on the steps may have the other sign on the line.
_SMALL_SHARE = 1e-2
#: What sums of squared speeds are off by, as a share of them.
_ROUNDING = 1e-14
#: The speed at which a limit is met is found to this share of w, by so many steps at most.
_SAME_PLACE = 1e-12
_SEARCHES = 60


@leaf
def _excess_n(train, none, pulls, d, grade, air, w0, w1):
    """Mean effort between two rows above its limit, N: of traction, or of all brakes; ``none`` counts as no effort."""
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    push = 0.5 * train.inertia_kg * (w1 - w0) / d
    load = mean_resistance(train, air, v0, v1) + grade
    effort = push + load
    if pulls:
        limit = mean_effort(train.traction, v0, v1)
        most = train.inertia_kg * train.max_acceleration
        uncomfortable = min(push - (1.0 + _SPARE) * most, effort - none)
        return max(effort - max((1.0 + _SPARE) * limit, none), uncomfortable)
    limit = mean_brake(train, load, v0, v1)
    spare = _SPARE * (mean_rate(train.rates, v0, v1) if train.rates.shape[0] > 0 else limit)
    most = train.inertia_kg * train.max_deceleration
    uncomfortable = min(-push - (1.0 + _SPARE) * most, -effort - none)
    return max(-effort - max(limit + spare, none), uncomfortable)


@part
def _within_limit(train, none, pulls, d, grade, air, w, low, high):
    """Largest squared speed from ``low`` to ``high`` at the other end of a row that keeps the effort to its limit.

    After a row that starts with w, by traction, or before one that ends with w, by all brakes (Illinois rule).
    """
    lo, hi = low, high
    f_hi = _excess_n(train, none, pulls, d, grade, air, w if pulls else hi, hi if pulls else w)
    if f_hi <= 0.0 or lo >= hi:
        return hi
    f_lo = _excess_n(train, none, pulls, d, grade, air, w if pulls else lo, lo if pulls else w)
    if f_lo >= 0.0:
        return lo
    bracket = Bracket(lo, hi, f_lo, f_hi, 0)
    for _ in range(_SEARCHES):
        x = secant(bracket)
        f = _excess_n(train, none, pulls, d, grade, air, w if pulls else x, x if pulls else w)
        bracket = narrowed(bracket, x, f)
        if bracket.hi - bracket.lo <= _SAME_PLACE * bracket.hi:
            break
    return bracket.lo


@part
def bounds_of_change(train, x, w, gain, effort, bound, held, rise, fall):
    """Most that w may rise and fall by along each row, (n − 1,) in place: the effort may not grow nor change its sign.

    Traction and brakes may be released. Where a speed is held only their limits count.
    """
    for k in range(x.shape[0] - 1):
        if held[k]:
            rise[k] = math.inf
            fall[k] = math.inf
            continue
        change = w[k + 1] - w[k]
        if not bound[k]:
            change = (w[k + 1] + gain[k + 1]) - (w[k] + gain[k])
        work = 2.0 / train.inertia_kg * abs(effort[k]) * (x[k + 1] - x[k])
        rounding = _ROUNDING * max(w[k], w[k + 1])
        rise[k] = (_SPARE if effort[k] > 0.0 else 1.0) * work + change + rounding
        fall[k] = (_SPARE if effort[k] < 0.0 else 1.0) * work - change + rounding


@part
def find_needed(w, rise, needed):
    """Squared speed from which a run that keeps its efforts comes to its end; ``needed`` (n,) in place."""
    last = rise.shape[0]
    needed[last] = w[last]
    for k in range(last - 1, -1, -1):
        needed[k] = max((1.0 - MOST_TAKEN) * w[k], needed[k + 1] - rise[k])


@part
def keep_within_effort(train, line, x, w, sums, effort, held, rise, fall, needed, followed):
    """Lower ``followed``, in place, where it would rise or fall by more than the efforts of the run on steps.

    Its ends stay.
    """
    dark = unpowered(train)
    start_n = effort_at(train.traction, 0.0)
    least = _SMALL_SHARE * start_n
    last = rise.shape[0] - 1
    step = 0
    for k in range(last):
        if followed[k + 1] > followed[k] + rise[k]:
            followed[k + 1] = min(max(followed[k] + rise[k], needed[k + 1]), followed[k + 1])
        if held[k] or effort[k] > -least:
            step = piece_from(line.break_m, step, 0.5 * (x[k] + x[k + 1]))
            d = x[k + 1] - x[k]
            followed[k + 1] = _within_limit(
                train if line.supply[step] == POWERED else dark, NO_EFFORT * start_n, True, d,
                (sums[0, k + 1] - sums[0, k]) / d, (sums[1, k + 1] - sums[1, k]) / d,
                followed[k], (1.0 - MOST_TAKEN) * w[k + 1], followed[k + 1],
            )  # fmt: skip
    step = line.grade_n.shape[0] - 1
    for k in range(last, 0, -1):
        if followed[k] > followed[k + 1] + fall[k]:
            followed[k] = max(followed[k + 1] + fall[k], (1.0 - MOST_TAKEN) * w[k])
        if held[k] or effort[k] < least:
            while line.break_m[step] > 0.5 * (x[k] + x[k + 1]):
                step -= 1
            d = x[k + 1] - x[k]
            followed[k] = _within_limit(
                train if line.supply[step] == POWERED else dark, NO_EFFORT * start_n, False, d,
                (sums[0, k + 1] - sums[0, k]) / d, (sums[1, k + 1] - sums[1, k]) / d,
                followed[k + 1], (1.0 - MOST_TAKEN) * w[k], followed[k],
            )  # fmt: skip
