"""Characteristics of the costate: points (w, p) carried back over one cell along the flow of their regime.

Everything here is per unit of inertia: the train's forces are accelerations. A point moves by the explicit midpoint
rule w0 = φ(w1), and its costate by the derivative of the cost of the arc along that map (docs/front-method.md),

    p0 = (∂E/∂w1 + λ·∂T/∂w1 + p1) / φ'(w1),     ∂T/∂w1 = −d/(v0+v1)²·(φ'/v0 + 1/v1).
"""

import math
from typing import NamedTuple

from tgvdp._jit import leaf, part
from tgvdp.physics.cell import Cell
from tgvdp.physics.codes import BRAKING, DYNAMIC, TRACTION
from tgvdp.physics.forces import effort_at, resistance_at
from tgvdp.physics.minimum import least_on_piece
from tgvdp.physics.motion import march

#: An image below this share of the floor has no costate: it is taken to be there.
LOST = 0.25
#: Squared speeds within this share are that of a step of the braking rates, which is come to in so many trials.
_AT_STEP = 1e-9
_STEPS_TO_RATE = 3
#: Braking curves are followed backwards to this multiple of the fastest squared speed at most.
_BEYOND = 1.01
#: A squared speed of a run that is nearer than this share to that at which the dynamic brake cuts out is that.
AT_CUT = 1e-7
#: An effort that changes by this share at one speed drops there.
_DROPS = 0.02
#: A dynamic brake that begins at a speed with so many times the resistance cuts out there: runs that coast through it
#: do not use it just above, as what it saves is a share of R/(R + D) of what a joule of it is worth.
_CUTS_OUT = 5.0


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
    cut_w : float
        Squared speed below which the dynamic brake cuts out (`cut_out_w`).
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
    cut_w: float


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
def coast_back(train, step, length, w1, p1):
    """Image of a point under coasting over a length; its p means nothing where that is below `LOST` of the bottom.

    No branch and no call is in here: the loop over the polyline runs in vector registers.
    """
    v1 = math.sqrt(w1)
    middle = w1 + length * (step.load + train.davis_b * v1 + step.air * w1)
    middle = middle if middle > step.bottom else step.bottom
    middle_v = math.sqrt(middle)
    per_v = 0.5 * train.davis_b / (v1 * middle_v)
    middle_w = 1.0 + length * (per_v * middle_v + step.air)
    w0 = w1 + 2.0 * length * (step.load + train.davis_b * middle_v + step.air * middle)
    image_w = 1.0 + 2.0 * length * (per_v * v1 + step.air) * middle_w
    return w0, _costate_before(step, step.multiplier, length, v1, w0, image_w, 0.0, p1)


@leaf
def _saturated_slope(train, regime, load, air, v):
    """Slope dw/ds, its derivative by w, and the work that counts, under full traction or full braking.

    Of traction, or of the dynamic brake, alone or with friction: the derivative by w of the effort but for the part of
    constant power, and that power, whose work is that of the time. (By the effort in the middle it would be nearly
    that: at multipliers next to the power that is returned, where speed is worth nothing, p had any sign.)
    """
    table = train.traction if regime == TRACTION else train.braking
    i = table.shape[0] - 1
    while i > 0 and table[i, 0] > v:
        i -= 1
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
    g, g_w, _, _ = _saturated_slope(train, regime, step.load, step.air, v1)
    middle_v = math.sqrt(max(w1 - 0.5 * length * g, step.bottom))
    middle_w = 1.0 - 0.5 * length * g_w
    g, g_w, work_w, power = _saturated_slope(train, regime, step.load, step.air, middle_v)
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
def cut_out_image(train, step, w1, p1):
    """`coast_image` of a point below the speed at which the dynamic brake cuts out, where that is above it.

    Above that speed kinetic energy is worth what the brake returns for it, −r/2: a run that had more of it would brake.
    """
    length = step.length
    level = -0.5 * step.returned
    part_m = length
    p_cut = p1
    for _ in range(_STEPS_TO_RATE):
        w0, p_cut = coast_image(train, step, part_m, w1, p1)
        part_m = min(part_m * (step.cut_w - w1) / max(w0 - w1, 0.5 * (step.cut_w - w1)), length)
    if p_cut <= level:
        return coast_image(train, step, length, w1, p1)
    return coast_image(train, step, length - part_m, step.cut_w, level * (1.0 + _AT_STEP))


@part
def saturated_image(train, regime, step, length, w1, p1):
    """`saturated_back`, but not inlined, and where braking rates step on the way, from step to step."""
    if regime != TRACTION:
        for i in range(1, train.rates.shape[0]):
            step_w = train.rates[i, 0] * train.rates[i, 0]
            to_go = step_w - w1
            if to_go > _AT_STEP * step_w:
                slope = _saturated_slope(train, regime, step.load, step.air, math.sqrt(w1))[0]
                if to_go >= -slope * length:
                    break
                below_m = -to_go / slope
                p0 = p1
                for _ in range(_STEPS_TO_RATE):
                    w0, p0 = saturated_back(train, regime, step, below_m, w1, p1)
                    below_m = min(below_m * to_go / max(w0 - w1, 0.5 * to_go), length)
                length -= below_m
                p1 = p0
            if to_go >= -_AT_STEP * step_w:
                p1 = _beyond_rate(train, regime, step, train.rates[i, 0], p1)
                w1 = step_w * (1.0 + 2.0 * _AT_STEP)
        drop_w = drop_above(train, w1)
        while drop_w < math.inf:
            met_m, p0 = _to_drop(train, regime, step, length, w1, p1, drop_w)
            if met_m == length:
                break
            length -= met_m
            w1 = drop_w
            p1 = beyond_drop(train, step, math.sqrt(drop_w), p0)
            regime = BRAKING if p1 > 0.0 else DYNAMIC
            drop_w = drop_above(train, w1)
    return saturated_back(train, regime, step, length, w1, p1)


@part
def drop_above(train, w):
    """Least squared speed above one at which the dynamic brake drops; infinite where it drops at none."""
    for i in range(1, train.braking.shape[0]):
        v = train.braking[i, 0]
        if w < v * v * (1.0 - _AT_STEP) and drops_at(train.braking, i):
            return v * v
    return math.inf


@leaf
def drops_at(table, i):
    """Whether an effort drops, as speed rises, where a piece of its curve begins."""
    v = table[i, 0]
    return effort_at(table, v * (1.0 - _AT_STEP)) > effort_at(table, v) * (1.0 + _DROPS)


@part
def _to_drop(train, regime, step, length, w1, p1, drop_w):
    """Over which part of a length a point comes from the speed of a drop, all of it if from none; its costate there."""
    to_go = drop_w - w1
    slope = _saturated_slope(train, regime, step.load, step.air, math.sqrt(w1))[0]
    if to_go >= -slope * length:
        return length, p1
    part_m = -to_go / slope
    p0 = p1
    for _ in range(_STEPS_TO_RATE):
        w0, p0 = saturated_back(train, regime, step, part_m, w1, p1)
        part_m = min(part_m * to_go / max(w0 - w1, 0.5 * to_go), length)
    return part_m, p0


@part
def beyond_drop(train, step, v, below_p):
    """Costate just above the speed of a drop of the dynamic brake, of runs with ``below_p`` below it.

    The Hamiltonian is the same on both sides (`_beyond_rate`): the least of what a metre costs under coasting, under
    the dynamic brake, and under all brakes. So friction may help above that speed, and not below it.
    """
    resistance = step.load + v * (train.davis_b + v * step.air)
    rate = effort_at(train.rates, v) if train.rates.shape[0] > 0 else train.max_deceleration
    most = max(rate - resistance, 0.0)
    below = min(effort_at(train.braking, v * (1.0 - _AT_STEP)), most)
    above = min(effort_at(train.braking, v), most)
    cost = -2.0 * below_p * resistance
    cost = min(cost, -step.returned * below - 2.0 * below_p * (resistance + below))
    cost = min(cost, -step.returned * below - 2.0 * below_p * (resistance + min(below + train.friction_n, most)))
    p = math.inf
    for brakes, returns in ((0.0, 0.0), (above, above), (min(above + train.friction_n, most), above)):
        if resistance + brakes > 0.0:
            p = min(p, -0.5 * (cost + step.returned * returns) / (resistance + brakes))
    return max(p, below_p) if p < math.inf else below_p


@part
def _beyond_rate(train, regime, step, v, below_p):
    """Costate just above the speed of a step of the braking rates, of runs with ``below_p`` below it.

    The least energy from a place on has a kink at that speed, wherever the train is. It has the same slope along the
    line on both sides, so that the Hamiltonian is the same.
    """
    resistance = step.load + v * (train.davis_b + v * step.air)
    brake = effort_at(train.braking, v)
    below_w = _saturated_slope(train, regime, step.load, step.air, v * (1.0 - _AT_STEP))[0]
    above_w = _saturated_slope(train, regime, step.load, step.air, v * (1.0 + _AT_STEP))[0]
    below = min(brake, -0.5 * below_w - resistance)
    above = min(brake, -0.5 * above_w - resistance)
    if below_w >= 0.0 or above_w >= 0.0:  # the train does not slow down through it
        return below_p
    return (below_p * below_w - step.returned * (below - above)) / above_w


@part
def dynamic_before(train, length, load, air, w1, top, scratch):
    """Squared speed before a cell from which the dynamic brake leads to w1, in rows as a run has them; 0 if none does.

    Where that is above ``top``, somewhat more than it.
    """
    cell = Cell(0.0, length, length, load - train.davis_a_n, air, math.inf)
    return march(train, DYNAMIC, -1.0, cell, length, w1, _BEYOND * max(top, w1), scratch, 0)[1]


@part
def cut_out_w(train):
    """Squared speed below which the dynamic brake gives nothing, and above which it gives much at once; 0 if none."""
    table = train.braking
    for i in range(table.shape[0]):
        v = table[i, 0]
        effort = effort_at(table, v)
        if effort > 0.0:
            return v * v if effort > _CUTS_OUT * resistance_at(train, 0.0, v) else 0.0
        for j in range(1, table.shape[1]):
            if table[i, j] != 0.0:
                return 0.0
    return 0.0


@part
def helped_before(train, step, w1, scratch):
    """`dynamic_before` with friction above a drop of the dynamic brake; 0 where that is not come from."""
    cell = Cell(0.0, step.length, step.length, step.load - train.davis_a_n, step.air, math.inf)
    drop_w = drop_above(train, w1)
    if drop_w == math.inf:
        return 0.0
    used_m, w, _ = march(train, DYNAMIC, -1.0, cell, step.length, w1, drop_w, scratch, 0)
    if w < drop_w:
        return 0.0
    rest_m = step.length - used_m
    return march(train, BRAKING, -1.0, cell, rest_m, drop_w, _BEYOND * max(step.top, drop_w), scratch, 0)[1]


@leaf
def coast_on(train, step, w0):
    """Squared speed after coasting through a cell, by the midpoint rule."""
    middle = max(w0 - step.length * (step.load + train.davis_b * math.sqrt(w0) + step.air * w0), 0.0)
    return max(w0 - 2.0 * step.length * (step.load + train.davis_b * math.sqrt(middle) + step.air * middle), 0.0)


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
