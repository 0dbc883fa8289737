"""Images of points where brakes jump with speed on the way through a cell.

The least energy from a place on has a kink at such a speed, wherever the train is. It has the same slope along the line
on both sides, so that the Hamiltonian is the same: p steps, up where braking rates or the dynamic brake drop as speed
rises, and down where that brake cuts out as speed falls. Everything here is per unit of inertia.
"""

import math

from tgvdp._jit import leaf, part
from tgvdp.methods.costate.characteristics import BEYOND, coast_image, saturated_back, saturated_slope
from tgvdp.physics.cell import Cell
from tgvdp.physics.codes import BRAKING, DYNAMIC, TRACTION
from tgvdp.physics.forces import JUMPS, effort_at, piece_effort, resistance_at
from tgvdp.physics.march import march

#: Squared speeds within this share are that of a jump, which is come to in so many trials.
_AT_STEP = 1e-9
_STEPS_TO_JUMP = 3
#: ... and so they are for the dynamic brake where rows of a run, or images, came to it.
AT_CUT = 1e-5
_AT_DROP = 2e-9
#: A dynamic brake that begins at a speed with so many times the resistance cuts out there: runs that coast through it
#: do not use it just above, as what it saves is a share of R/(R + D) of what a joule of it is worth.
_CUTS_OUT = 5.0
#: ... or, where it rises steeply, at the speed at which it comes to that, found in so many halvings: within this factor
#: of the speed at which it begins to rise, and with no more than this share of what it has at most.
_HALVINGS = 40
_STEEP = 1.3
_BY_THEN = 1.0 / 3.0
#: ... and below which it has no more than this share of that effort.
NOTHING = 0.01


@part
def cut_out_w(train):
    """Squared speed below which the dynamic brake gives next to nothing, and above which it gives much; 0 if none.

    Where it rises steeply from nothing, that is where it has so much that runs use it.
    """
    table = train.braking
    last = table.shape[0] - 1
    most = 0.0
    for i in range(last + 1):
        most = max(most, piece_effort(table, i, table[i, 0]))
    first = 0
    while first < last and piece_effort(table, first, table[first + 1, 0]) <= NOTHING * most >= piece_effort(
        table, first, table[first, 0]
    ):
        first += 1
    begins = table[first, 0]
    for i in range(first, last + 1):
        v = table[i, 0]
        if i < last and not _is_used(train, i, v) and _is_used(train, i, table[i + 1, 0]):
            v = _rises_to(train, i, v, table[i + 1, 0])
        if _is_used(train, i, v):
            is_steep = v <= _STEEP * begins and piece_effort(table, i, v) <= _BY_THEN * most
            return v * v if v == begins or is_steep else 0.0
    return 0.0


@leaf
def _is_used(train, i, v):
    """Whether the dynamic brake has, by the piece i of its curve, so much at a speed that it cuts out below."""
    return piece_effort(train.braking, i, v) > _CUTS_OUT * resistance_at(train, 0.0, v)


@part
def _rises_to(train, i, before, after):
    """Speed between two on the piece i from which on the dynamic brake has so much."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (before + after)
        if _is_used(train, i, middle):
            after = middle
        else:
            before = middle
    return after


@part
def cut_out_image(train, step, w1, p1):
    """`coast_image` of a point below the speed at which the dynamic brake cuts out, where that is above it.

    Above that speed kinetic energy is worth what the brake returns for it, −r/2: a run that had more of it would brake.
    """
    length = step.length
    level = -0.5 * step.returned
    part_m = length
    p_cut = p1
    for _ in range(_STEPS_TO_JUMP):
        w0, p_cut = coast_image(train, step, part_m, w1, p1)
        part_m = min(part_m * (step.cut_w - w1) / max(w0 - w1, 0.5 * (step.cut_w - w1)), length)
    if p_cut <= level:
        return coast_image(train, step, length, w1, p1)
    return coast_image(train, step, length - part_m, step.cut_w, level * (1.0 + _AT_STEP))


@part
def saturated_image(train, regime, step, length, w1, p1):
    """`saturated_back`, but not inlined, and where braking rates step or the dynamic brake drops, from jump to jump."""
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
        drop_w = drop_above(train, w1)
        while drop_w < math.inf:
            below_m, p0 = _to_jump(train, regime, step, length, w1, p1, drop_w)
            if below_m < 0.0:
                break
            length -= below_m
            w1 = drop_w
            p1 = beyond_drop(train, step, math.sqrt(drop_w), p0)
            regime = BRAKING if p1 > 0.0 else DYNAMIC
            drop_w = drop_above(train, w1)
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
def drop_above(train, w):
    """Least squared speed above one at which the dynamic brake drops; infinite where it drops at none."""
    if w < train.last_drop_mps * train.last_drop_mps * (1.0 - _AT_STEP):
        table = train.braking
        for i in range(1, table.shape[0]):
            v = table[i, 0]
            drops = piece_effort(table, i - 1, v) > (1.0 + JUMPS) * piece_effort(table, i, v)
            if drops and w < v * v * (1.0 - _AT_STEP):
                return v * v
    return math.inf


@part
def is_drop(train, w):
    """Whether a squared speed is one at which the dynamic brake drops, or next to it."""
    return abs(drop_above(train, w * (1.0 - 2.0 * _AT_DROP)) - w) <= _AT_DROP * w


@part
def beyond_drop(train, step, v, below_p):
    """Costate just above the speed of a drop of the dynamic brake, of runs with ``below_p`` below it.

    The Hamiltonian is the least of what a metre costs under coasting, under the dynamic brake, and under all brakes. So
    friction may help above that speed, and not below it.
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
    return max(p, below_p)


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
