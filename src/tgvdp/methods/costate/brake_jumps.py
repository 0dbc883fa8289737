"""Images of points where brakes jump with speed on the way through a cell.

The least energy from a place on has a kink at such a speed, wherever the train is. It has the same slope along the line
on both sides, so that the Hamiltonian is the same: p steps, up where braking rates or the dynamic brake drop as speed
rises, and down where that brake rises. Everything here is per unit of inertia.
"""

import math

from tgvdp._jit import part
from tgvdp.methods.costate.characteristics import BEYOND, coast_image, saturated_back, saturated_slope
from tgvdp.physics.brake_shape import JUMPS
from tgvdp.physics.cell import Cell
from tgvdp.physics.codes import BRAKING, DYNAMIC, TRACTION
from tgvdp.physics.forces import effort_at, piece_effort
from tgvdp.physics.march import march

#: Squared speeds within this share are that of a jump, which is come to in so many trials.
_AT_STEP = 1e-9
_STEPS_TO_JUMP = 3
#: ... and so they are for the dynamic brake where rows of a run, or images, came to it.
AT_RISE = 1e-5
_AT_DROP = 2e-9
#: Images stop where the dynamic brake has risen by such a part of what it rises to.
_RAMP_STOPS = 8.0


@part
def saturated_image(train, regime, step, length, w1, p1):
    """`saturated_back`, but not inlined, and where braking rates step or the dynamic brake jumps, from jump to jump."""
    if regime != TRACTION:
        for i in range(1, train.rates.shape[0]):
            step_w = train.rates[i, 0] * train.rates[i, 0]
            to_go = step_w - w1
            if to_go > _AT_STEP * step_w:
                below_m, p0 = _to_jump(train, regime, step, length, w1, p1, step_w)
                if below_m < 0.0:
                    break
                length -= below_m
                p1 = p0
            if to_go >= -_AT_STEP * step_w:
                p1 = beyond_rate(train, regime, step, train.rates[i, 0], p1)
                w1 = step_w * (1.0 + 2.0 * _AT_STEP)
        while True:
            jump_w = min(drop_above(train, w1), rise_above(train, w1))
            stop_w = min(jump_w, ramp_above(train, w1))
            if stop_w == math.inf:
                break
            below_m, p0 = _to_jump(train, regime, step, length, w1, p1, stop_w)
            if below_m < 0.0:
                break
            length -= below_m
            w1 = stop_w
            p1 = p0
            if stop_w == jump_w:
                p1 = beyond_jump(train, step, math.sqrt(jump_w), p0)
                if p1 < p0 and p1 <= -0.5 * step.returned:
                    return coast_image(train, step, length, w1, p1)
                regime = BRAKING if p1 > 0.0 else DYNAMIC
    return saturated_back(train, regime, step, length, w1, p1)


@part
def _to_jump(train, regime, step, length, w1, p1, jump_w):
    """Over which part of a length a point comes from the speed of a jump, below 0 if from none; its costate there."""
    to_go = jump_w - w1
    slope = saturated_slope(train, regime, step.load, step.air, math.sqrt(w1))[0]
    if to_go >= -slope * length:
        return -1.0, p1
    below_m = -to_go / slope
    p0 = p1
    for _ in range(_STEPS_TO_JUMP):
        w0, p0 = saturated_back(train, regime, step, below_m, w1, p1)
        below_m = min(below_m * to_go / max(w0 - w1, 0.5 * to_go), length)
    return below_m, p0


@part
def beyond_rate(train, regime, step, v, below_p):
    """Costate just above the speed of a step of the braking rates, of runs with ``below_p`` below it."""
    resistance = step.load + v * (train.davis_b + v * step.air)
    brake = effort_at(train.braking, v)
    below_w = saturated_slope(train, regime, step.load, step.air, v * (1.0 - _AT_STEP))[0]
    above_w = saturated_slope(train, regime, step.load, step.air, v * (1.0 + _AT_STEP))[0]
    below = min(brake, -0.5 * below_w - resistance)
    above = min(brake, -0.5 * above_w - resistance)
    if below_w >= 0.0 or above_w >= 0.0:  # the train does not slow down through it
        return below_p
    return (below_p * below_w - step.returned * (below - above)) / above_w


@part
def _jump_above(train, w, last_mps, rises):
    """Least squared speed above one at which the dynamic brake rises, or drops; infinite where it does at none."""
    if w < last_mps * last_mps * (1.0 - _AT_STEP):
        table = train.braking
        for i in range(1, table.shape[0]):
            v = table[i, 0]
            below = piece_effort(table, i - 1, v)
            above = piece_effort(table, i, v)
            jumps = above > (1.0 + JUMPS) * below if rises else below > (1.0 + JUMPS) * above
            jumps = jumps or (rises and v == train.brakes_from_mps)
            if jumps and w < v * v * (1.0 - _AT_STEP):
                return v * v
    return math.inf


@part
def drop_above(train, w):
    """Least squared speed above one at which the dynamic brake drops; infinite where it drops at none."""
    return _jump_above(train, w, train.last_drop_mps, False)


@part
def rise_above(train, w):
    """Least squared speed above one at which the dynamic brake rises; infinite where it rises at none."""
    return _jump_above(train, w, train.last_rise_mps, True)


@part
def ramp_above(train, w):
    """Least squared speed above one at which an image stops where the dynamic brake rises steadily; infinite if none.

    Those are the ends of pieces that rise, and so many in between that it rises by a share of itself from one to the
    next: over less than a cell it may do so from nothing to all of it.
    """
    if w < train.ramps_to_mps * train.ramps_to_mps * (1.0 - _AT_STEP):
        table = train.braking
        for i in range(table.shape[0] - 1):
            low_w = table[i, 0] * table[i, 0]
            high_w = table[i + 1, 0] * table[i + 1, 0]
            if w >= high_w * (1.0 - _AT_STEP):
                continue
            low_n = piece_effort(table, i, table[i, 0])
            high_n = piece_effort(table, i, table[i + 1, 0])
            if high_n > (1.0 + JUMPS) * low_n:
                if w < low_w * (1.0 - _AT_STEP):
                    return low_w
                stop_w = (high_w - low_w) / math.ceil(_RAMP_STOPS * (1.0 - low_n / high_n))
                return low_w + stop_w * (1.0 + math.floor((w - low_w) / stop_w + _AT_STEP))
    return math.inf


@part
def is_kept(train, step, v):
    """Whether runs come to a speed at which the dynamic brake rises from both sides: below it cannot hold the train."""
    resistance = step.load + v * (train.davis_b + v * step.air)
    return resistance + effort_at(train.braking, v * (1.0 - _AT_STEP)) <= 0.0 < resistance + effort_at(train.braking, v)


@part
def _from_begin(train, step, w1, p1):
    """Over which length a point is carried back above the speed at which the dynamic brake begins, and p just below."""
    from_w = train.brakes_from_mps * train.brakes_from_mps
    part_m = step.length
    from_p = p1
    for _ in range(_STEPS_TO_JUMP):
        w0, from_p = coast_image(train, step, part_m, w1, p1)
        part_m = min(part_m * (from_w - w1) / max(w0 - w1, 0.5 * (from_w - w1)), step.length)
    return step.length - part_m, from_p


@part
def begun_image(train, step, w1, p1):
    """Image of a point below the speed at which the dynamic brake begins, where coasting leads to it from above that.

    A run that is faster there by a little brakes to that speed, and coasts on, if p is above −r/2.
    """
    from_w = train.brakes_from_mps * train.brakes_from_mps
    rest_m, from_p = _from_begin(train, step, w1, p1)
    level = -0.5 * step.returned
    if from_p <= level:
        return coast_image(train, step, step.length, w1, p1)
    above_p = begun_costate(train, step, from_p)
    if above_p > level:
        return saturated_image(train, DYNAMIC, step, rest_m, from_w, above_p)
    return coast_image(train, step, rest_m, from_w, above_p)


@part
def last_coasted(train, step, w1, p1):
    """Image of the run that comes to the same speed as that of `begun_image`, with so low a costate that it coasts."""
    from_w = train.brakes_from_mps * train.brakes_from_mps
    rest_m, _ = _from_begin(train, step, w1, p1)
    return coast_image(train, step, rest_m, from_w, -0.5 * step.returned)


@part
def begun_costate(train, step, below_p):
    """Costate just above the speed at which the dynamic brake begins, of runs with ``below_p`` below it.

    Where the brake drops elsewhere no run brakes to that speed only to coast on: it is no more than −r/2.
    """
    if train.last_drop_mps > 0.0:
        return min(below_p, -0.5 * step.returned * (1.0 + _AT_STEP))
    return beyond_jump(train, step, train.brakes_from_mps, below_p)


@part
def snapped_to_rise(train, w):
    """A squared speed, or that at which the dynamic brake rises, where it is that but for the error of its rows."""
    rise_w = rise_above(train, w * (1.0 - AT_RISE))
    return rise_w if abs(w - rise_w) <= AT_RISE * w else w


@part
def is_drop(train, w):
    """Whether a squared speed is one at which the dynamic brake drops, or next to it."""
    return abs(drop_above(train, w * (1.0 - 2.0 * _AT_DROP)) - w) <= _AT_DROP * w


@part
def beyond_jump(train, step, v, below_p):
    """Costate just above the speed of a jump of the dynamic brake, of runs with ``below_p`` below it.

    The Hamiltonian is the least of what a metre costs under coasting, under the dynamic brake, and under all brakes. So
    friction may help above a drop, and not below it.
    """
    resistance = step.load + v * (train.davis_b + v * step.air)
    rate = effort_at(train.rates, v) if train.rates.shape[0] > 0 else train.max_deceleration
    most = max(rate - resistance, 0.0)
    below = min(effort_at(train.braking, v * (1.0 - _AT_STEP)), most)
    above = min(effort_at(train.braking, v), most)
    if resistance + above <= 0.0:  # without friction the train does not slow down through it
        return below_p
    cost = -2.0 * below_p * resistance
    cost = min(cost, -step.returned * below - 2.0 * below_p * (resistance + below))
    cost = min(cost, -step.returned * below - 2.0 * below_p * (resistance + min(below + train.friction_n, most)))
    p = math.inf
    for brakes, returns in ((0.0, 0.0), (above, above), (min(above + train.friction_n, most), above)):
        if resistance + brakes > 0.0:
            p = min(p, -0.5 * (cost + step.returned * returns) / (resistance + brakes))
    return min(p, below_p) if above > below else max(p, below_p)


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
    return march(train, BRAKING, -1.0, cell, rest_m, drop_w, BEYOND * max(step.top, drop_w), scratch, 0)[1]


@part
def half_helped(train, step, length, w1):
    """Costate of a run that comes to a place with friction from the last moment above a drop on, or hardly any.

    How much friction helps there does not matter to it: p = 0 just above the drop.
    """
    drop_w = drop_above(train, w1)
    below_m, _ = _to_jump(train, DYNAMIC, step, length, w1, 0.0, drop_w)
    return saturated_back(train, DYNAMIC, step, length - max(below_m, 0.0), drop_w, 0.0)[1]
