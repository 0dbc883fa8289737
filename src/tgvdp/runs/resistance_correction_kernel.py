"""Kernels of `runs.resistance_correction`: one walk along the rows of a run and the pieces of the line beside them."""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.line.walk import piece_from, sum_to
from tgvdp.physics.energy import follows_dynamic
from tgvdp.physics.forces import brake_at, effort_at, mean_effort, mean_rate, mean_resistance
from tgvdp.physics.motion import BELOW_DROP
from tgvdp.runs.effort_jumps import NO_EFFORT
from tgvdp.runs.resistance_correction_effort import MOST_TAKEN, bounds_of_change, find_needed, keep_within_effort

#: An acceleration within this share of its limit is at the limit.
_AT_LIMIT = 1e-6
#: ... and at the end of a row within this share of the change from its middle on.
_AT_END = 0.05
#: An effort above this share of its limit keeps that share along a row: as it is, it could be beyond the limit.
NEARLY_FULL = 0.9
#: A speed is held by choice where the effort is below this share of its limit.
_SPARE_EFFORT = 0.98
#: ... and above this share of the starting effort: less is coasting at the balancing speed.
_COASTING_SHARE = 1e-4
#: Relative difference of squared speeds that are one.
_SAME_W = 1e-8
#: Largest bend of the difference along a row, as a share of w, and the rows that one is cut into at most.
_BEND = 1e-5
_MOST_PARTS = 64
#: Parts of a row are known once a sweep along them changes the speed half-way by no more than this share of w, as it
#: leaves that times the share by which forces change along the row; and after so many sweeps at most. Next to a
#: standstill, where w is below a share of what it is at the other end, that is a share of the least w of a part, and
#: resistance changes too much along the row for a parabola.
_SAME_CUT_W = 1e-7
_CUT_SWEEPS = 20
_STANDING_W = 0.05


@leaf
def _gain_at(line, at, x, w):
    """What w differs by at x where the resistance is the true one and the effort the same as on the steps.

    ``at`` are the indices of the step, and of the pieces of force and drag.
    """
    step = at[0]
    past = x - line.break_m[step]
    if past <= 0.0 or x >= line.break_m[-1]:
        return 0.0
    force_j = line.grade_n[step] * past - (sum_to(line.force, at[1], x) - line.force_nm[step])
    drag_j = line.air[step] * past - (sum_to(line.drag, at[2], x) - line.drag_nm[step])
    return 2.0 / line.inertia_kg * (force_j + drag_j * w)


@leaf
def _walk(line, at, x):
    """Indices at x, from those before it."""
    return (
        piece_from(line.break_m, at[0], x),
        piece_from(line.force.knot_m, at[1], x),
        piece_from(line.drag.knot_m, at[2], x),
    )


@kernel
def count_parts(line, x, w, parts):
    """Into how many parts each row is to be cut, so that the difference is nearly linear along each; returns the sum.

    ``parts`` (n − 1,) in place.
    """
    total = 0
    at = (0, 0, 0)
    gain0 = 0.0
    for k in range(x.shape[0] - 1):
        bend = 0.0
        first = at
        end = _walk(line, at, x[k + 1])
        gain1 = _gain_at(line, end, x[k + 1], w[k + 1])
        at = first
        for quarter in range(1, 4):
            share = 0.25 * quarter
            here_m = x[k] + share * (x[k + 1] - x[k])
            here_w = w[k] + share * (w[k + 1] - w[k])
            at = _walk(line, at, here_m)
            gain = _gain_at(line, at, here_m, here_w)
            bend = max(bend, abs(gain - gain0 - share * (gain1 - gain0)) / here_w)
        parts[k] = math.ceil(min(_MOST_PARTS, max(1.0, math.sqrt(bend / _BEND))))
        total += parts[k]
        at = end
        gain0 = gain1
    return total


@leaf
def is_comfort(train, effort, gain):
    """Whether an acceleration is at a comfort limit.

    The line may go beyond it, but no effort does: where one seems to, a row begins or ends a hair away from its run.
    """
    limit = train.max_acceleration if gain > 0.0 else train.max_deceleration
    if abs(gain) > (1.0 + _AT_LIMIT) * limit:
        return effort * gain > 0.0 and abs(effort) > NO_EFFORT * effort_at(train.traction, 0.0)
    return abs(gain) >= (1.0 - _AT_LIMIT) * limit


@leaf
def is_bound(train, effort, gain, v):
    """Whether an acceleration is at a comfort limit or at a braking rate, at a mean speed."""
    if is_comfort(train, effort, gain):
        return True
    return train.rates.shape[0] > 0 and abs(gain * train.inertia_kg / effort_at(train.rates, v) + 1.0) <= _AT_LIMIT


@leaf
def drag_change(train, air, v0, middle, v1):
    """By how much the mean resistance of the second half of a row is more than that of the first, N."""
    return mean_resistance(train, air, middle, v1) - mean_resistance(train, air, v0, middle)


@leaf
def passes(gaining, slowing, effort, acceleration, change):
    """Whether an effort whose acceleration is more, or less, at the ends of a row passes a limit of these somewhere.

    Not where it does so throughout: that is the line alone; nor where it does at one end alone, where the limit begins.
    """
    most = (1.0 - _AT_END) * abs(change)
    if effort > 0.0:
        return acceleration <= gaining < acceleration + most
    return effort < 0.0 and -acceleration <= slowing < most - acceleration


@leaf
def follows_traction(train, effort, mean, v0, v1):
    """Whether an effort on a row of a mean limit has to follow that: as it is, it would be beyond it, or nearly."""
    return mean > 0.0 and (effort >= NEARLY_FULL * mean or effort > effort_at(train.traction, max(v0, v1)))


@leaf
def _law_of(train, grade, air, d, w0, w1):
    """What a row keeps to: whether its acceleration, and else the share of an effort limit beside constant effort.

    The share is 0 where all is constant, and below 0 where the dynamic brake follows its limit. A constant effort that
    would pass a comfort limit or a braking rate somewhere gives way to a constant acceleration.
    """
    acceleration = 0.5 * (w1 - w0) / d
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    effort = train.inertia_kg * acceleration + mean_resistance(train, air, v0, v1) + grade
    kept = is_comfort(train, effort, acceleration)
    slowing = train.max_deceleration
    table = train.traction if effort >= 0.0 else train.braking
    mean = mean_effort(table, v0, v1)
    share = 0.0
    if effort >= 0.0:
        share = effort / mean if follows_traction(train, effort, mean, v0, v1) else 0.0
    elif follows_dynamic(train, d, -effort, v0, v1):
        share = max(effort / mean, -1.0)
        most = train.inertia_kg * train.max_deceleration
        if train.rates.shape[0] > 0:
            most = min(most, mean_rate(train.rates, v0, v1))
        peak = max(effort_at(train.braking, v0), effort_at(train.braking, v1))
        if -train.inertia_kg * acceleration - share * (peak - mean) > most:  # it would pass the rate where it peaks
            share = 0.0
    elif train.rates.shape[0] == 0:
        full = mean + train.friction_n
        share = effort / full if -effort >= NEARLY_FULL * full > 0.0 else 0.0
    else:
        rate = mean_rate(train.rates, v0, v1)
        braking = -acceleration * train.inertia_kg / rate
        kept = kept or abs(braking - 1.0) <= _AT_LIMIT  # beyond its rate it is the load alone that slows a train
        if abs(effort_at(train.rates, 0.5 * (v0 + v1)) / rate - 1.0) <= _AT_LIMIT:  # no step of it
            slowing = min(slowing, rate / train.inertia_kg)
    if share == 0.0 and abs(effort) > NO_EFFORT * effort_at(train.traction, 0.0):
        middle = math.sqrt(0.5 * (w0 + w1))
        change = drag_change(train, air, v0, middle, v1) / train.inertia_kg
        kept = kept or passes(train.max_acceleration, slowing, effort, acceleration, change)
    return kept, share


@leaf
def even_speeds(parts, w0, w1):
    """First and second coefficient, by the number of a part, of the share of a row before its end.

    Parts share the speeds of the row evenly: motion bends most next to a standstill.
    """
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    per_part = 1.0 / ((v0 + v1) * parts)
    return 2.0 * v0 * per_part, (v1 - v0) * per_part / parts


@leaf
def part_end(ends, i):
    """Share of a row before the end of its part i, from 1 on, by the coefficients of `even_speeds`."""
    return i * (ends[0] + i * ends[1])


@part
def _sweep(train, share, air, d, w0, w1, ends, parts, cut_w):
    """Squared speeds at the end of each part of a row by the forces between those that there are, (parts,) in place.

    Parts have one effort alike beside the ``share`` of its limit: the one that leads to w1.
    """
    table = train.traction if share > 0.0 else train.braking
    per_force = 2.0 / train.inertia_kg * d
    led_w = w0
    v0 = math.sqrt(w0)
    before = 0.0
    for j in range(parts):
        v1 = math.sqrt(cut_w[j])
        force = -mean_resistance(train, air, v0, v1)
        if share != 0.0:
            force += share * mean_effort(table, v0, v1)
        after = part_end(ends, j + 1)
        led_w += per_force * (after - before) * force
        cut_w[j] = led_w
        v0 = v1
        before = after
    alike_w = w1 - led_w
    for j in range(parts):
        cut_w[j] = max(0.0, cut_w[j] + part_end(ends, j + 1) * alike_w)


@part
def _bow(train, share, air, d, w0, w1):
    """How far the squared speed is above a straight line half-way along a row, by the forces along its halves."""
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    middle = math.sqrt(0.5 * (w0 + w1))
    change = drag_change(train, air, v0, middle, v1)
    if share != 0.0:
        table = train.traction if share > 0.0 else train.braking
        change += share * (mean_effort(table, v0, middle) - mean_effort(table, middle, v1))
    return 0.5 * d * change / train.inertia_kg


@part
def cut_row(train, law, air, d, w0, w1, parts, cut_w):
    """Squared speeds at the end of each part of a row, by `even_speeds`, (parts,) in place; the last one is w1.

    All parts at once, from a parabola on: no part waits for the one before it, and none makes up for the others.
    """
    kept, share = law
    bow = 0.0 if kept else _bow(train, share, air, d, w0, w1)
    ends = even_speeds(parts, w0, w1)
    for j in range(parts):
        u = part_end(ends, j + 1)
        cut_w[j] = max(0.0, w0 + u * (w1 - w0 + 4.0 * (1.0 - u) * bow))
    most_w = _SAME_CUT_W * max(w0, w1)
    middle = (parts - 1) // 2
    stands = min(w0, w1) < _STANDING_W * max(w0, w1)
    if stands and parts > 1:
        most_w = _SAME_CUT_W * min(cut_w[0], cut_w[parts - 2])
    # A parabola is off by about bow²/Δw.
    enough = bow == 0.0 or (not stands and bow * bow <= most_w * abs(w1 - w0))
    for _ in range(0 if enough else _CUT_SWEEPS):
        before_w = cut_w[middle]
        _sweep(train, share, air, d, w0, w1, ends, parts, cut_w)
        if abs(cut_w[middle] - before_w) <= most_w:
            break
    cut_w[parts - 1] = w1


@kernel
def cut_rows(train, line, x, w, parts, cut_x, cut_w):
    """Cut rows into parts: the effort keeps its share of the limit if it is nearly full, its value if not.

    Returns how many positions there are then.
    """
    step = 0
    n = 0
    for k in range(x.shape[0] - 1):
        cut_x[n] = x[k]
        cut_w[n] = w[k]
        n += 1
        if parts[k] > 1:
            d = x[k + 1] - x[k]
            step = piece_from(line.break_m, step, 0.5 * (x[k] + x[k + 1]))
            law = _law_of(train, line.grade_n[step], line.air[step], d, w[k], w[k + 1])
            cut_row(train, law, line.air[step], d, w[k], w[k + 1], parts[k], cut_w[n:])
            ends = even_speeds(parts[k], w[k], w[k + 1])
            for i in range(1, parts[k]):
                cut_x[n] = x[k] + part_end(ends, i) * d
                n += 1
    cut_x[n] = x[-1]
    cut_w[n] = w[-1]
    return n + 1


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
        at = _walk(line, at, x[k])
        gain[k] = _gain_at(line, at, x[k], w[k])
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
def _kept_gain(train, x, w, gain, bound, held, kept):
    """Gain where something else than the effort is given: linear between rows that are free; ``kept`` in place."""
    last = x.shape[0] - 1
    before = 0
    kept[0] = gain[0]
    for k in range(1, last + 1):
        inner = 0 < k < last
        fixed = inner and bound[k - 1] and bound[k] and _at_rate_break(train, w[k])
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
    _kept_gain(train, x, w, gain, bound, held, kept)
    for k in range(x.shape[0]):
        followed[k] = min(max(w[k] + kept[k], (1.0 - MOST_TAKEN) * w[k]), followed[k])
    _cap_at_drops(drops, w, effort, followed)
    bounds_of_change(train, x, w, gain, effort, bound, held, rise, fall)
    find_needed(w, rise, kept)
    keep_within_effort(train, line, x, w, sums, effort, held, rise, fall, kept, followed)
