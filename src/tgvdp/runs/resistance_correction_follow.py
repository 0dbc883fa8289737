"""Kernel of `runs.resistance_correction` that follows the true resistance: squared speeds of the rows as they are."""

import math

from tgvdp._jit import kernel, part
from tgvdp.line.walk import piece_from, sum_to
from tgvdp.physics.forces import brake_at, effort_at
from tgvdp.physics.march import BELOW_DROP
from tgvdp.runs.resistance_correction_effort import MOST_TAKEN, bounds_of_change, find_needed, keep_within_effort
from tgvdp.runs.resistance_correction_kernel import gain_at, is_bound, walk

#: A speed is held by choice where the effort is below this share of its limit.
_SPARE_EFFORT = 0.98
#: ... and above this share of the starting effort: less is coasting at the balancing speed.
_COASTING_SHARE = 1e-4
#: Relative difference of squared speeds that are one.
_SAME_W = 1e-8


@part
def _is_held(train, least, effort, v):
    """Whether a speed that stays the same is held by choice."""
    if abs(effort) <= least:
        return False
    if effort < 0.0 and train.rates.shape[0] > 0:
        return True
    limit = effort_at(train.traction, v) if effort >= 0.0 else brake_at(train, 0.0, v)
    return abs(effort) <= _SPARE_EFFORT * limit


@part
def _at_rate_break(train, w):
    for i in range(1, train.rates.shape[0]):
        break_w = train.rates[i, 0] * train.rates[i, 0]
        if abs(w - break_w) <= _SAME_W * break_w:
            return True
    return False


@part
def _look(train, line, x, w, gain, top, effort, sums, bound, held):
    """Gain, speed limit and integrals of force and drag, (n,), effort and what is kept between rows, (n − 1,)."""
    at = (0, 0, 0)
    least = _COASTING_SHARE * effort_at(train.traction, 0.0)
    between = 0
    limit_before = math.inf
    for k in range(x.shape[0]):
        at = walk(line, at, x[k])
        gain[k] = gain_at(line, at, x[k], w[k])
        sums[0, k] = sum_to(line.force, at[1], x[k])
        sums[1, k] = sum_to(line.drag, at[2], x[k])
        limit_mps = line.limit_mps[at[0]]
        top[k] = max(min(limit_mps, limit_before) ** 2, w[k])
        limit_before = limit_mps
        if k + 1 == x.shape[0]:
            break
        d = x[k + 1] - x[k]
        between = piece_from(line.break_m, between, 0.5 * (x[k] + x[k + 1]))
        mean_w = 0.5 * (w[k] + w[k + 1])
        v = math.sqrt(mean_w)
        resistance = train.davis_a_n + train.davis_b * v + line.air[between] * mean_w
        effort[k] = train.inertia_kg * 0.5 * (w[k + 1] - w[k]) / d + resistance + line.grade_n[between]
        bound[k] = is_bound(train, effort[k], 0.5 * (w[k + 1] - w[k]) / d, v)
        held[k] = abs(w[k + 1] - w[k]) <= _SAME_W * w[k + 1] and _is_held(train, least, effort[k], v)


@part
def _kept_gain(train, x, w, gain, top, bound, held, kept):
    """Gain where something else than the effort is given: linear between rows that are free; ``kept`` in place.

    A speed limit is held as it is: what the rows before and after it are short of it is left to their efforts.
    """
    last = x.shape[0] - 1
    before = 0
    kept[0] = gain[0]
    for k in range(1, last + 1):
        inner = 0 < k < last
        fixed = inner and bound[k - 1] and bound[k] and _at_rate_break(train, w[k])
        fixed |= inner and (held[k - 1] or held[k]) and w[k] >= top[k] * (1.0 - _SAME_W)
        kept[k] = 0.0 if fixed else gain[k]
        if inner and not fixed and (bound[k - 1] or held[k - 1]) and (bound[k] or held[k]):
            continue
        slope = (kept[k] - kept[before]) / (x[k] - x[before])
        for i in range(before + 1, k):
            kept[i] = slope * (x[i] - x[before]) + kept[before]
        before = k


@part
def _cap_at_drops(drops, w, effort, followed):
    """Carry no run under traction past a drop of the effort curve; ``followed`` in place."""
    for k in range(w.shape[0]):
        near = (k > 0 and effort[k - 1] > 0.0) or (k + 1 < w.shape[0] and effort[k] > 0.0)
        if not near:
            continue
        for i in range(drops.shape[0]):
            drop_w = drops[i] ** 2
            if w[k] <= drop_w * (1.0 + _SAME_W) and followed[k] > drop_w:
                followed[k] = max(w[k], drop_w * (1.0 - BELOW_DROP))


@kernel
def follow_rows(train, line, drops, x, w, followed, scratch, bound, held):
    """Squared speeds of the run that follows the true resistance; ``followed`` (n,) in place.

    ``scratch`` (7, n) float64, ``bound`` and ``held`` (n − 1,) bool are room to work in.
    """
    gain, kept, effort, rise, fall = scratch[0], scratch[1], scratch[2, :-1], scratch[3, :-1], scratch[4, :-1]
    sums = scratch[5:]
    _look(train, line, x, w, gain, followed, effort, sums, bound, held)
    _kept_gain(train, x, w, gain, followed, bound, held, kept)
    for k in range(x.shape[0]):
        followed[k] = min(max(w[k] + kept[k], (1.0 - MOST_TAKEN) * w[k]), followed[k])
    _cap_at_drops(drops, w, effort, followed)
    bounds_of_change(train, x, w, gain, effort, bound, held, rise, fall)
    find_needed(w, rise, kept)
    keep_within_effort(train, line, x, w, sums, effort, held, rise, fall, kept, followed)
