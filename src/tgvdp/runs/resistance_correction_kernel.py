"""Kernels of `runs.resistance_correction`: one walk along the rows of a run and the pieces of the line beside them."""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.line.walk import piece_from, sum_to
from tgvdp.physics.energy import follows_dynamic
from tgvdp.physics.forces import effort_at, mean_effort, mean_rate, mean_resistance
from tgvdp.runs.effort_jumps import NO_EFFORT

#: An acceleration within this share of its limit is at the limit.
_AT_LIMIT = 1e-6
#: ... and at the end of a row within this share of the change from its middle on.
_AT_END = 0.05
#: An effort above this share of its limit keeps that share along a row: as it is, it could be beyond the limit.
NEARLY_FULL = 0.9
#: Largest bend of the difference along a row, as a share of w, and the rows that one is cut into at most.
_BEND = 1e-5
_MOST_PARTS = 64
#: Parts of a row are known once a sweep along them leaves the speed half-way right to this share of w, which is what it
#: changes times the share by which forces change along the row; and after so many sweeps at most. Next to a standstill,
#: where w is below a share of what it is at the other end, a sweep has to change no more than that share of the least w
#: of a part, as resistance changes too much along the row for a parabola.
_SAME_CUT_W = 1e-7
_CUT_SWEEPS = 20
_STANDING_W = 0.05


@leaf
def gain_at(line, at, x, w):
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
def walk(line, at, x):
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
        end = walk(line, at, x[k + 1])
        gain1 = gain_at(line, end, x[k + 1], w[k + 1])
        at = first
        for quarter in range(1, 4):
            share = 0.25 * quarter
            here_m = x[k] + share * (x[k + 1] - x[k])
            here_w = w[k] + share * (w[k + 1] - w[k])
            at = walk(line, at, here_m)
            gain = gain_at(line, at, here_m, here_w)
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
    # A parabola is off by about bow²/Δw, and what a sweep leaves is less than what it changes by bow/Δw.
    left = 1.0 if stands else min(abs(bow) / max(abs(w1 - w0), most_w), 1.0)
    enough = bow == 0.0 or (not stands and abs(bow) * left <= most_w)
    for _ in range(0 if enough else _CUT_SWEEPS):
        before_w = cut_w[middle]
        _sweep(train, share, air, d, w0, w1, ends, parts, cut_w)
        if abs(cut_w[middle] - before_w) * left <= most_w:
            break
    cut_w[parts - 1] = w1


@part
def append_parts(train, line, step, x, w, k, parts, cut_x, cut_w, n):
    """Append row k, cut into parts; returns the step of the line that it is on, or one before it, and how many rows."""
    cut_x[n] = x[k]
    cut_w[n] = w[k]
    n += 1
    if parts > 1:
        d = x[k + 1] - x[k]
        step = piece_from(line.break_m, step, 0.5 * (x[k] + x[k + 1]))
        law = _law_of(train, line.grade_n[step], line.air[step], d, w[k], w[k + 1])
        cut_row(train, law, line.air[step], d, w[k], w[k + 1], parts, cut_w[n:])
        ends = even_speeds(parts, w[k], w[k + 1])
        for i in range(1, parts):
            cut_x[n] = x[k] + part_end(ends, i) * d
            n += 1
    return step, n


@kernel
def cut_rows(train, line, x, w, parts, cut_x, cut_w):
    """Cut rows into parts: the effort keeps its share of the limit if it is nearly full, its value if not.

    Returns how many positions there are then.
    """
    step = 0
    n = 0
    for k in range(x.shape[0] - 1):
        step, n = append_parts(train, line, step, x, w, k, parts[k], cut_x, cut_w, n)
    cut_x[n] = x[-1]
    cut_w[n] = w[-1]
    return n + 1
