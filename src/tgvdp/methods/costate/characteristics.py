"""Characteristics of the costate: points (w, p) carried back over one cell along the flow of their regime.

Everything here is per unit of inertia: the train's forces are accelerations. A point moves by the explicit midpoint
rule w0 = φ(w1), and its costate by the derivative of the cost of the arc along that map (docs/front-method.md),

    p0 = (∂E/∂w1 + λ·∂T/∂w1 + p1) / φ'(w1),     ∂T/∂w1 = −d/(v0+v1)²·(φ'/v0 + 1/v1).

Where brakes jump with speed on the way is in `brake_jumps`.
"""

import math
from typing import NamedTuple

from tgvdp._jit import leaf, part
from tgvdp.physics.cell import Cell
from tgvdp.physics.codes import BRAKING, DYNAMIC, TRACTION
from tgvdp.physics.forces import effort_at, piece_at
from tgvdp.physics.march import march
from tgvdp.physics.minimum import least_on_piece

#: An image below this share of the floor has no costate: it is taken to be there.
LOST = 0.25
#: Runs that gain so much speed by coasting that in the middle they had less than this share of v² are slow in any case.
LEAST_MIDDLE = 0.25
#: Braking curves are followed backwards to this multiple of the fastest squared speed at most.
BEYOND = 1.01


class Step(NamedTuple):
    """One step of the backward pass, over one cell; forces per unit of inertia, traction work costs 1.

    Attributes
    ----------
    length, load, air : float
        The cell: length, m, resistance A and grade force, m/s², and coefficient of v², 1/m.
    multiplier : float
        λ, J/(s·kg).
    returned : float
        Energy that the dynamic brake returns per joule of its work, below 1.
    held_w, held_brake_w : float
        Squared speeds that are held by traction and by the dynamic brake (`holding_w`).
    bottom, top, wall : float
        Squared speeds: the slowest and fastest of the images, and the fastest after the cell.
    dynamic_w : float
        Squared speed before the cell from which the dynamic brake leads to the wall, from `dynamic_before`.
    """

    length: float
    load: float
    air: float
    multiplier: float
    returned: float
    held_w: float
    held_brake_w: float
    bottom: float
    top: float
    wall: float
    dynamic_w: float


@leaf
def holding_costate(train, step, w0, w1):
    """Costate at w0 of partial traction towards a fixed w1: derivative of X + λT by w0."""
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    s = v0 + v1
    linear = 0.0
    if train.davis_b != 0.0:
        mean_v_w = (2.0 / 3.0) * ((1.0 + 0.5 * v1 / v0) * s - (w0 + w1 + v0 * v1) * 0.5 / v0) / (s * s)
        linear = train.davis_b * mean_v_w
    work_w = -0.5 + step.length * (0.5 * step.air + linear)
    return work_w - step.multiplier * step.length / (s * s * v0)


@leaf
def _costate_before(step, price, length, v1, w0, image_w, work_w, p1):
    """Costate at the image w0 of v1², whose derivative is ``image_w``, where a second costs a price.

    ``work_w`` is the derivative of the effort's work per metre, but for what is counted by the second.
    """
    lost = LOST * step.bottom
    v0 = math.sqrt(w0 if w0 > lost else lost)
    s = v0 + v1
    span = s * s * v0 * v1
    return ((length * work_w + p1) * span - price * length * (image_w * v1 + v0)) / (span * image_w)


@leaf
def coasting_law(davis_b, load, air, middle, w):
    """By how much v² falls per metre under coasting at a squared speed, and how much more it does per m²/s².

    By the slope that the resistance has at another one, in the middle of the way: along that v² is exponential.
    """
    middle_v = math.sqrt(middle)
    more = 2.0 * air + (davis_b / middle_v if middle_v > 0.0 else 0.0)
    return 2.0 * load + davis_b * middle_v + more * w, more


@leaf
def coasted(w, length, falls, more):
    """Squared speed some metres before that of a `coasting_law`, or behind it if they are below 0, and its slope."""
    x = length * more
    growth = 1.0 + x * (0.5 + x * (1.0 / 6.0))
    return w + length * falls * growth, 1.0 + x * growth


@leaf
def coast_back(train, step, length, w1, p1):
    """Image of a point under coasting over a length; its p means nothing where that is below `LOST` of the bottom.

    No branch is in here: the loop over the polyline runs in vector registers.
    """
    v1 = math.sqrt(w1)
    middle = w1 + length * (step.load + train.davis_b * v1 + step.air * w1)
    least = LEAST_MIDDLE * w1
    least = least if least > step.bottom else step.bottom
    falls, more = coasting_law(train.davis_b, step.load, step.air, middle if middle > least else least, w1)
    w0, image_w = coasted(w1, length, falls, more)
    return w0, _costate_before(step, step.multiplier, length, v1, w0, image_w, 0.0, p1)


@leaf
def saturated_slope(train, regime, load, air, v):
    """Slope dw/ds, its derivative by w, and the work that counts, under full traction or full braking.

    Of traction, or of the dynamic brake, alone or with friction: the derivative by w of the effort but for the part of
    constant power, and that power, whose work is that of the time. (By the effort in the middle it would be nearly
    that: at multipliers next to the power that is returned, where speed is worth nothing, p had any sign.)
    """
    table = train.traction if regime == TRACTION else train.braking
    i = piece_at(table, v)
    per_v = 1.0 / v
    power = table[i, 1]
    effort = power * per_v + table[i, 2] + v * (table[i, 3] + v * (table[i, 4] + v * table[i, 5]))
    slope = table[i, 3] + v * (2.0 * table[i, 4] + v * 3.0 * table[i, 5])
    if regime != TRACTION:
        effort = -effort
        slope = -slope
        power = -power
    resistance = load + v * (train.davis_b + v * air)
    resistance_w = 0.5 * train.davis_b * per_v + air
    net = effort - resistance
    if regime == TRACTION and net >= train.max_acceleration:
        if resistance <= -train.max_acceleration:  # downhill it gains more than that by itself
            return -2.0 * resistance, -2.0 * resistance_w, 0.0, 0.0
        return 2.0 * train.max_acceleration, 0.0, resistance_w, 0.0
    work_w = 0.5 * slope * per_v
    effort_w = work_w - 0.5 * power * per_v * per_v * per_v
    if regime != TRACTION:
        full = train.friction_n - effort if regime == BRAKING else -effort
        rate = effort_at(train.rates, v) if train.rates.shape[0] > 0 else train.max_deceleration
        if rate < full + resistance:
            if rate <= resistance:  # the load slows it down more than that by itself
                return -2.0 * resistance, -2.0 * resistance_w, 0.0, 0.0
            if rate - resistance < -effort:
                return -2.0 * rate, 0.0, resistance_w, 0.0
            return -2.0 * rate, 0.0, work_w, power
        return -2.0 * (full + resistance), 2.0 * (effort_w - resistance_w), work_w, power
    return 2.0 * net, 2.0 * (effort_w - resistance_w), work_w, power


@leaf
def saturated_back(train, regime, step, length, w1, p1):
    """Image of a point under full traction or full braking, dynamic or by all brakes, over a length."""
    v1 = math.sqrt(w1)
    g, g_w, _, _ = saturated_slope(train, regime, step.load, step.air, v1)
    middle_v = math.sqrt(max(w1 - 0.5 * length * g, step.bottom))
    middle_w = 1.0 - 0.5 * length * g_w
    g, g_w, work_w, power = saturated_slope(train, regime, step.load, step.air, middle_v)
    w0 = w1 - length * g
    image_w = max(1.0 - length * g_w * middle_w, 1e-3)
    per_joule = 1.0 if regime == TRACTION else step.returned
    price = step.multiplier + per_joule * power
    return w0, _costate_before(step, price, length, v1, w0, image_w, per_joule * work_w * middle_w, p1)


@part
def coast_image(train, step, length, w1, p1):
    """`coast_back`, but not inlined: half of the compilation where it is no inner loop."""
    return coast_back(train, step, length, w1, p1)


@part
def dynamic_before(train, length, load, air, w1, top, scratch):
    """Squared speed before a cell from which the dynamic brake leads to w1, in rows as a run has them; 0 if none does.

    Where that is above ``top``, somewhat more than it.
    """
    cell = Cell(0.0, length, length, load - train.davis_a_n, air, math.inf)
    return march(train, DYNAMIC, -1.0, cell, length, w1, BEYOND * max(top, w1), scratch, 0)[1]


@leaf
def coast_on(train, step, w0):
    """Squared speed after coasting through a cell, as `coast_back` has it."""
    middle = w0 - step.length * (step.load + train.davis_b * math.sqrt(w0) + step.air * w0)
    falls, more = coasting_law(train.davis_b, step.load, step.air, max(middle, LEAST_MIDDLE * w0), w0)
    return max(coasted(w0, -step.length, falls, more)[0], 0.0)


@part
def holding_w(davis_b, air, multiplier):
    """Squared speed V² that is held for a multiplier in units of the price of work: λ = V²·R'(V); may be infinite.

    Newton's rule from above, where the derivative rises.
    """
    v = math.inf
    if air > 0.0:
        v = (0.5 * multiplier / air) ** (1.0 / 3.0) * (1.0 + 1e-12)
    if davis_b > 0.0:
        v = min(v, math.sqrt(multiplier / davis_b))
    if davis_b > 0.0 and air > 0.0:
        for _ in range(20):
            step = (v * v * (davis_b + 2.0 * air * v) - multiplier) / (v * (2.0 * davis_b + 6.0 * air * v))
            v -= step
            if step <= 1e-15 * v:
                break
    return v * v


@part
def held_back_w(train, returned, multiplier, top_w):
    """Squared speed v² ≤ ``top_w`` that is held by the whole dynamic brake and friction: the least λ/v − r·D(v).

    On a descent that the dynamic brake cannot hold, that is what a metre costs: its time less the energy returned.
    """
    top_v = math.sqrt(top_w)
    table = train.braking
    least = math.inf
    at = top_v
    for i in range(table.shape[0]):
        lo = table[i, 0]
        if lo >= top_v:
            break
        hi = min(table[i + 1, 0], top_v) if i + 1 < table.shape[0] else top_v
        least, at = least_on_piece(
            multiplier - returned * table[i, 1], -returned * table[i, 2], -returned * table[i, 3],
            -returned * table[i, 4], -returned * table[i, 5], lo, hi, least, at,
        )  # fmt: skip
    return at * at
