"""The referee's drive: the equation of motion along each row, by the force law of the row (see `referee.replay`)."""

import math

import numpy as np

from tgvdp._jit import kernel, leaf, part
from tgvdp.model.track import LOWERED, POWERED
from tgvdp.physics.energy import FULL_EFFORT
from tgvdp.physics.forces import effort_at, unpowered
from tgvdp.referee.law import (
    INSIDE,
    KEPT,
    commanded,
    drawn_per_metre,
    dynamic_share,
    full_braking,
    map_power_at,
    mean_limit,
    slope_at,
    sub_steps,
)
from tgvdp.referee.line import met, parts_at

#: An effort below this share of the starting effort counts as none.
_NO_EFFORT = 1e-4
#: An acceleration within this share of a comfort limit is kept.
_AT_COMFORT = 1e-6
#: Speeds nearer to each other than this share of a row's change of speed are one.
_SAME_SPEED = 1e-9
#: The way to a break of the effort limit is found to this share of w, by so many steps at most.
_AT_BREAK = 1e-12
_SEARCHES = 60


@leaf
def _next_break(table, v, rising, end):
    """First speed on the way from v to ``end`` at which a piece of an effort curve ends; ``end`` if there is none."""
    found = end
    for i in range(1, table.shape[0]):
        if (v < table[i, 0] < found) if rising else (v > table[i, 0] > found):
            found = table[i, 0]
    return found


@leaf
def _next_edge(table, other, v, rising, end):
    """The same of two curves, which may be one."""
    found = _next_break(table, v, rising, end)
    return found if other is table else _next_break(other, v, rising, found)


@leaf
def _sub_step(law, line, parts, before, x, h, last, w):
    """One step of the Runge–Kutta scheme from x, where the train meets ``before``; ``last`` is where a row ends.

    Returns the squared speed after it, what the train meets before it, half-way and after it, and the efforts and
    squared speeds of the four stages, the first of which is w.
    """
    middle = met(line, parts, min(x + 0.5 * h, last))
    after = met(line, parts, min(x + h, last))
    k1, f1 = slope_at(*law, *before, w)
    w2 = w + 0.5 * h * k1
    k2, f2 = slope_at(*law, *middle, w2)
    w3 = w + 0.5 * h * k2
    k3, f3 = slope_at(*law, *middle, w3)
    w4 = w + h * k3
    k4, f4 = slope_at(*law, *after, w4)
    end = w + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return end, (before, middle, after), (f1, f2, f3, f4), (w2, w3, w4)


@part
def _way_to(law, line, parts, before, x, h, last, w, after, aim):
    """Part of a step of length h, at the end of which w is ``after``, at the end of which it is ``aim``."""
    lo, hi = 0.0, h
    f_lo, f_hi = w - aim, after - aim
    way = h
    side = 0
    for _ in range(_SEARCHES):
        way = (lo * f_hi - hi * f_lo) / (f_hi - f_lo)
        f = _sub_step(law, line, parts, before, x, way, last, w)[0] - aim
        if abs(f) <= _AT_BREAK * aim or hi - lo <= _AT_BREAK * h:
            break
        if (f < 0.0) == (f_lo < 0.0):
            lo = way
            f_lo = f
            f_hi *= 0.5 if side < 0 else 1.0
            side = -1
        else:
            hi = way
            f_hi = f
            f_lo *= 0.5 if side > 0 else 1.0
            side = 1
    return way


@leaf
def _seconds(h, w, after):
    """Duration of a step, s."""
    v = math.sqrt(max(w, 0.0))
    if after > 0.0:
        return 2.0 * h / (v + math.sqrt(after))
    if w > 0.0:  # it stops within this sub-step; a w below 0 is the energy that it lacks
        return 2.0 * h * w / (w - after) / v
    return 0.0


@leaf
def _drawn(law, tables, h, w, after, seconds, lines, efforts, stages):
    """Energy in J that a step draws, without auxiliaries."""
    train, command, lever, dynamic, lo, hi = law
    if tables.speed_mps.shape[0] > 0:  # the speed is nearly linear in time, the power is not singular at standstill
        pull = (train, tables, command, lever, dynamic, lo, hi)
        v0 = math.sqrt(max(w, 0.0))
        v1 = math.sqrt(max(after, 0.0))
        powers = map_power_at(*pull, *lines[0], v0) + 4.0 * map_power_at(*pull, *lines[1], 0.5 * (v0 + v1))
        return seconds / 6.0 * (powers + map_power_at(*pull, *lines[2], v1))
    ends = drawn_per_metre(train, tables, efforts[0], lo, hi, w)
    ends += drawn_per_metre(train, tables, efforts[3], lo, hi, stages[2])
    inner = drawn_per_metre(train, tables, efforts[1], lo, hi, stages[0])
    inner += drawn_per_metre(train, tables, efforts[2], lo, hi, stages[1])
    return h / 6.0 * (ends + 2.0 * inner)


@part
def _drive_row(rule, tables, line, parts, x, d, w0, w1):
    """Drive along one row; returns w at its end, seconds, energy drawn without auxiliaries, and sub-steps.

    The ``rule`` is of train, commanded force, share of the effort limit and of that of the dynamic brake.

    Where the effort limit has a break between the speeds of the row, a step ends there: the scheme is of fourth order
    on each side of it, and of none across a jump.
    """
    train, command, lever, dynamic = rule
    table = other = train.traction
    if dynamic > 0.0:
        table = other = train.braking
    elif command < 0.0:
        table = other = train.braking
        if train.rates.shape[0] > 0:  # by which it brakes, while the dynamic brake returns by its own limit
            table = train.rates
    v0, v1 = math.sqrt(w0), math.sqrt(w1)
    nudge = _SAME_SPEED * abs(v1 - v0)
    lo, hi = min(v0, v1) + nudge, max(v0, v1) - nudge
    rising = v1 > v0
    passed, end_mps = (lo, hi) if rising else (hi, lo)
    edge = _next_edge(table, other, passed, rising, end_mps)
    count = sub_steps(*rule, lo, hi, *met(line, parts, x + 0.5 * d), d, max(w0, w1))
    inside_m = INSIDE * d
    last = x + d - inside_m
    before = met(line, parts, x + inside_m)
    w = w0
    seconds = 0.0
    drawn = 0.0
    done = 0.0
    j = 0
    way = math.inf  # to the next break, where it is within the step
    while j < count:
        u = (j + 1.0) / count
        end = d * u * u * (3.0 - 2.0 * u)
        h = min(end - done, way)
        lo, hi = (passed, edge - nudge) if rising else (edge, passed - nudge)
        law = (train, command, lever, dynamic, lo, hi)
        after, lines, efforts, stages = _sub_step(law, line, parts, before, x + done, h, last, w)
        if way == math.inf and edge != end_mps and ((after > edge * edge) if rising else (after < edge * edge)):
            way = _way_to(law, line, parts, before, x + done, h, last, w, after, edge * edge)
            continue
        step = _seconds(h, w, after)
        seconds += step
        drawn += _drawn(law, tables, h, w, after, step, lines, efforts, stages)
        w = after
        before = lines[2]
        if way < math.inf:
            done += h
            passed = edge
            edge = _next_edge(table, other, passed, rising, end_mps)
            way = math.inf
        else:
            done = end
            j += 1
    return w, seconds, drawn, count


@kernel
def replay_rows(train, tables, line, supply, x, speed, force, time, energy, first, most_sub_steps):
    """Replay rows from the ``first`` on, until so many sub-steps are made; cumulative time and energy in place.

    Returns the row that comes next, effort excess and speed error; these are infinite where there is nothing to replay.
    """
    excess = -1.0
    speed_error = 0.0
    dark = unpowered(train)
    by_map = tables.speed_mps.shape[0] > 0
    if first == 0:
        time[0] = 0.0
        energy[0] = 0.0
    last = x.shape[0] - 1
    made = 0
    i = first
    while i < last and made < most_sub_steps:
        d = x[i + 1] - x[i]
        w0 = speed[i] * speed[i]
        w1 = speed[i + 1] * speed[i + 1]
        here = train if supply[i] == POWERED else dark
        limit = mean_limit(here, line, force[i] < 0.0, np.inf, x[i], d, w0, w1)
        lever = abs(force[i]) / limit if limit > 0.0 else 0.0
        keeps_rate = force[i] < 0.0 and train.rates.shape[0] > 0
        if limit == 0.0 and not keeps_rate:  # no current, or no brake: shares are of the starting effort
            share = abs(force[i]) / effort_at(train.traction, 0.0)
            if share > _NO_EFFORT:
                return last, np.inf, np.inf
        acceleration = 0.5 * (w1 - w0) / d
        if keeps_rate:  # of the deceleration: next to nothing is left to brakes where the load slows enough
            full = full_braking(here, line, x[i], d, 0.5 * (speed[i] + speed[i + 1]))
            excess = max(excess, (-force[i] - limit) / full)
        else:
            excess = max(excess, lever - 1.0)
        # Comfort limits what the effort does: the line alone may do more.
        push = force[i] / train.inertia_kg
        excess = max(excess, min(acceleration / train.max_acceleration - 1.0, push / train.max_acceleration))
        excess = max(excess, min(-acceleration / train.max_deceleration - 1.0, -push / train.max_deceleration))
        dynamic = 0.0
        bound = train.max_acceleration if force[i] > 0.0 else -train.max_deceleration
        if abs(acceleration / bound - 1.0) <= _AT_COMFORT:
            command, lever = train.inertia_kg * acceleration, KEPT
        else:
            command = commanded(here, line, force[i], limit, x[i], d, w0, w1)
            if force[i] < 0.0 and lever < FULL_EFFORT and acceleration > FULL_EFFORT * bound:
                dynamic, friction = dynamic_share(here, -force[i], by_map, w0, w1)
                command = -friction if dynamic > 0.0 else command
            if lever < FULL_EFFORT and not (force[i] > 0.0 and by_map):
                lever = 0.0
        rule = (here, command, lever, dynamic)
        w, seconds, drawn, count = _drive_row(rule, tables, line, parts_at(line, x[i]), x[i], d, w0, w1)
        time[i + 1] = time[i] + seconds
        drawn = 0.0 if supply[i] == LOWERED else drawn + tables.auxiliary_w * seconds
        energy[i + 1] = energy[i] + drawn + 0.5 * train.inertia_kg * abs(w1 - w)
        speed_error = max(speed_error, abs(np.sqrt(max(w, 0.0)) - speed[i + 1]))
        made += count
        i += 1
    return i, excess, speed_error
