"""Driving under a saturated regime: full traction, coasting, full braking, full dynamic braking.

The equation of motion in w = v² is dw/ds = 2·(F(v) − R(v) − G)/m_eff: its right side, at a speed and as a mean between
two, and a single row of given length. `physics.march` follows it through a cell.
"""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.physics.codes import BRAKING, COASTING, DYNAMIC, TRACTION
from tgvdp.physics.forces import (
    brake_at,
    effort_at,
    mean_brake,
    mean_effort,
    mean_resistance,
    resistance_at,
)

#: The share of w by which the last step of `land` may still change it, how many steps there are at most, and the share
#: of what there is to lose below which nothing is left.
_LANDED = 1e-9
_LANDINGS = 60
_STALLED = 1e-12


@leaf
def net_of(train, regime, load, effort):
    """Net force in N of an effort and a load, which a comfort limit cuts: to none where the load alone does more."""
    if regime == TRACTION:
        return min(effort - load, max(train.inertia_kg * train.max_acceleration, -load))
    if regime == COASTING:
        return -load
    return max(-effort - load, min(-train.inertia_kg * train.max_deceleration, -load))


@leaf
def net_force(train, regime, cell, v0, v1):
    """Mean net force in N between two speeds under a saturated regime, within its comfort limit."""
    load = mean_resistance(train, cell.air, v0, v1) + cell.grade_n
    effort = 0.0
    if regime == TRACTION:
        effort = mean_effort(train.traction, v0, v1)
    elif regime == BRAKING:
        effort = mean_brake(train, load, v0, v1)
    elif regime == DYNAMIC:
        effort = mean_effort(train.braking, v0, v1)
        if train.rates.shape[0] > 0:
            effort = min(effort, mean_brake(train, load, v0, v1))
    return net_of(train, regime, load, effort)


@leaf
def net_force_at(train, regime, cell, v):
    """`net_force` at one speed."""
    load = resistance_at(train, cell.air, v) + cell.grade_n
    effort = 0.0
    if regime == TRACTION:
        effort = effort_at(train.traction, v)
    elif regime == BRAKING:
        effort = brake_at(train, load, v)
    elif regime == DYNAMIC:
        effort = effort_at(train.braking, v)
        if train.rates.shape[0] > 0:
            effort = min(effort, brake_at(train, load, v))
    return net_of(train, regime, load, effort)


@leaf
def _damping(train, cell, factor, v):
    """By what a step of `landed_from` is to be divided: the resistance changes with the speed that is reached."""
    linear = 0.25 * train.davis_b / v if v > 0.0 else 0.0
    return max(1.0 + factor * (0.5 * cell.air + linear), 1.0)


@part
def landed_from(train, regime, sign, cell, length_m, w, net, x):
    """`land` from a guess x on, where ``net`` is the net force at the start."""
    v = math.sqrt(w)
    factor = sign * 2.0 * length_m / train.inertia_kg
    damping = _damping(train, cell, factor, v)
    before_x = w
    before = w + factor * net
    stalls = _STALLED * (w + abs(factor * net))
    lo = 0.0
    hi = math.inf
    for _ in range(_LANDINGS):
        reached = w + factor * net_force(train, regime, cell, v, math.sqrt(x))
        if reached > x:
            lo = x
        else:
            hi = x
        slope = (reached - before) / (x - before_x) if x != before_x else 1.0 - damping
        before_x = x
        before = reached
        x += (reached - x) / min(max(1.0 - slope, 0.5), 2.0 * damping)
        if not lo <= x <= hi:  # the effort jumps on the way
            x = 0.5 * (lo + hi)
        if abs(x - before_x) <= _LANDED * x:
            return x
        if hi <= stalls:
            return 0.0
    return x


@kernel
def land(train, regime, sign, cell, length_m, w):
    """Squared speed after one row of the given length (sign = −1: before it); 0 if the train stalls.

    Solves x = w + sign·2·d/m_eff·net(w, x) to rounding by the secant rule, or by halves where an effort jumps: mostly
    the right side hardly depends on x. What is met from both sides has to be so near: where it was not (to 1e-8, by the
    slope of the resistance alone), runs left the curve of the dynamic brake at the end of each cell.
    """
    v = math.sqrt(w)
    factor = sign * 2.0 * length_m / train.inertia_kg
    net = net_force_at(train, regime, cell, v)
    guess = w + factor * net / _damping(train, cell, factor, v)
    return landed_from(train, regime, sign, cell, length_m, w, net, max(guess, 0.0))
