"""The force law of the referee: what a train does along a row of a profile, given the row's mean effort.

A row at full effort follows the effort limit: F(v) = θ·F_limit(v), with the θ that gives the row's mean effort. Where
energy is by a map, so does a row of any traction, and one of braking for which the dynamic brake suffices: θ is its
demand. A row at a comfort limit keeps its acceleration: F(v) = m·a + R(v) + G. Where the limit D of the dynamic brake
passes the effort within a row but changes by little, the brake follows it, and friction is constant: F(v) = θ·D(v) + c,
with θ ≤ 1 and c = 0 if θ < 1. Any other row holds a commanded force, as far as the limit allows: F(v) =
min(c, F_limit(v)), c being the mean effort but where the limit falls below it.
"""

import numpy as np

from tgvdp._jit import kernel, leaf
from tgvdp.physics.energy import FOLLOWED, FULL_EFFORT, map_power
from tgvdp.physics.forces import brake_at, effort_at, resistance_at
from tgvdp.referee.line import met, parts_at

#: The line at the end of a row is looked up this share of the row inside it: a break there belongs to the next one.
INSIDE = 1e-6
#: A row's share of its effort limit where it keeps its acceleration: its force is the net one then.
KEPT = -1.0
_SUB_STEPS = 8
_MOST_SUB_STEPS = 100_000
#: Bracket and bisection of a commanded force.
_DOUBLINGS = 10
_HALVINGS = 30


@leaf
def limit_at(train, braking, load, v):
    """Effort limit at speed v; braking rates are kept whatever the ``load``, grade force and resistance, is."""
    return brake_at(train, load, v) if braking else effort_at(train.traction, v)


@kernel
def mean_limit(train, line, braking, cap, x, d, w0, w1):
    """Mean along a row of the effort limit, capped; v² is linear. The midpoint rule on 16 parts between its breaks.

    A braking rate counts by the distance that it takes, which is the change of v² over twice the rate.
    """
    table = train.traction
    if braking:
        table = train.rates if train.rates.shape[0] > 0 else train.braking
    lo = min(w0, w1)
    hi = max(w0, w1)
    parts = parts_at(line, x)
    total = 0.0
    weights = 0.0
    start = lo
    for i in range(1, table.shape[0] + 1):
        end = hi
        if i < table.shape[0]:
            end = min(max(table[i, 0] * table[i, 0], start), hi)
        span = end - start
        for j in range(16 if span > 0.0 or lo == hi else 0):
            w = start + (j + 0.5) / 16.0 * span
            v = np.sqrt(w)
            load = 0.0
            weight = span if lo < hi else 1.0
            if braking and train.rates.shape[0] > 0:
                share = (w - w0) / (w1 - w0) if w1 != w0 else (j + 0.5) / 16.0
                grade, air = met(line, parts, x + min(share, 1.0 - INSIDE) * d)
                load = resistance_at(train, air, v) + grade
                weight /= effort_at(table, v)
            total += weight * min(limit_at(train, braking, load, v), cap)
            weights += weight
        if lo == hi:
            break
        start = end
    return total / weights


@kernel
def full_braking(train, line, x, d, v):
    """Net force that slows a train at full braking half-way along a row: its rate, or the load where that is more, N.

    Brakes are left the difference of the two, to which rows keep as well as to these forces themselves.
    """
    grade, air = met(line, parts_at(line, x), x + 0.5 * d)
    return max(effort_at(train.rates, v), resistance_at(train, air, v) + grade)


@kernel
def commanded(train, line, force, limit, x, d, w0, w1):
    """Force that a driver commands for the mean effort of a row, where the limit is below that on a part of it."""
    braking = force < 0.0
    effort = abs(force)
    if effort >= FULL_EFFORT * limit or mean_limit(train, line, braking, effort, x, d, w0, w1) >= effort:
        return force
    low = effort
    high = 2.0 * effort
    for _ in range(_DOUBLINGS):
        if mean_limit(train, line, braking, high, x, d, w0, w1) >= effort:
            break
        high *= 2.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if mean_limit(train, line, braking, middle, x, d, w0, w1) < effort:
            low = middle
        else:
            high = middle
    return -high if braking else high


@kernel
def dynamic_share(train, effort, by_map, w0, w1):
    """Share θ of its limit that the dynamic brake follows along a row, and the constant effort of friction, N.

    The share is 0 where it follows nothing, as its limit does not pass the effort, or changes by too much. By a map
    a brake that suffices keeps its share, too, which is its demand.
    """
    limit0 = effort_at(train.braking, np.sqrt(w0))
    limit1 = effort_at(train.braking, np.sqrt(w1))
    mean = 0.0
    for j in range(16):
        mean += effort_at(train.braking, np.sqrt(w0 + (j + 0.5) / 16.0 * (w1 - w0))) / 16.0
    suffices = effort <= min(limit0, limit1)
    passes = effort < max(limit0, limit1) and abs(limit0 - limit1) <= FOLLOWED * mean
    if by_map if suffices else passes:
        return min(effort / mean, 1.0), max(effort - mean, 0.0)
    return 0.0, 0.0


@leaf
def force_at(train, force, lever, dynamic, lo, hi, load, v):
    """Effort at the wheel; the effort curve is looked up within the row's speeds lo..hi, not beyond a jump there.

    It follows a share of the limit where the ``lever`` is above 0; a share of the dynamic brake's limit, if that is
    above 0, and the force is that of friction.
    """
    inside = min(max(v, lo), hi)
    effort = force + load if lever == KEPT else force
    braking = effort < 0.0 or dynamic > 0.0
    if dynamic > 0.0:
        amount = dynamic * effort_at(train.braking, inside) - force
    else:
        limit = limit_at(train, braking, load, inside)
        amount = lever * limit if lever > 0.0 else min(abs(effort), limit)
    return -amount if braking else amount


@leaf
def drawn_per_metre(train, tables, effort, lo, hi, w):
    """Energy in J per metre that constant efficiencies draw from the line for an effort, without auxiliaries."""
    if effort >= 0.0:
        return tables.traction * effort
    if tables.regeneration == 0.0:
        return 0.0
    inside = min(max(np.sqrt(max(w, 0.0)), lo), hi)
    return -tables.regeneration * min(-effort, effort_at(train.braking, inside))


@kernel
def map_power_at(train, tables, force, lever, dynamic, lo, hi, grade, air, v):
    """Power in W that a map draws from the line at speed v under the force law of a row, without auxiliaries."""
    effort = force_at(train, force, lever, dynamic, lo, hi, resistance_at(train, air, v) + grade, v)
    limit = effort_at(train.traction if effort >= 0.0 else train.braking, min(max(v, lo), hi))
    demand = min(max(effort / limit, -1.0), 1.0) if limit > 0.0 else 0.0
    return map_power(tables, v, demand)


@leaf
def slope_at(train, force, lever, dynamic, lo, hi, grade, air, w):
    """Return dw/ds in m/s² and the effort in N at a squared speed, under the force law of a row."""
    v = np.sqrt(max(w, 0.0))
    load = resistance_at(train, air, v) + grade
    effort = force_at(train, force, lever, dynamic, lo, hi, load, v)
    return 2.0 * (effort - load) / train.inertia_kg, effort


@kernel
def sub_steps(train, force, lever, dynamic, lo, hi, grade, air, d, w):
    """Sub-steps of a row: more where d·∂(dw/ds)/∂w is large, for the scheme is only stable for steps below 2.7."""
    nearby = 0.999 * w
    if nearby <= 0.0:
        return _SUB_STEPS
    here = slope_at(train, force, lever, dynamic, 0.0, hi, grade, air, w)[0]
    there = slope_at(train, force, lever, dynamic, 0.0, hi, grade, air, nearby)[0]
    return int(min(_MOST_SUB_STEPS, _SUB_STEPS + 2.0 * d * abs(here - there) / (w - nearby)))
