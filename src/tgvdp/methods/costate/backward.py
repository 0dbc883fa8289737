"""The costate dynamic program: switching speeds for one multiplier (backward pass of the front method).

For a multiplier λ (J/s) minimise J = E + λT. Let V_k(w) be the cost to go from station k at w = v², per unit of
inertia, and p_k = dV_k/dw its costate. Only three regimes and holding occur (Pontryagin; Howlett & Pudney 1995,
Albrecht et al. 2016): with e = 1 for wheel energy, the effort's coefficient in the Hamiltonian is e + 2p, so

    p < −½        full traction          −½ < p ≤ 0    coasting

and p never rises above 0: a faster train can always brake to a slower one, for nothing. Braking is therefore left to
the envelope of feasible speeds, where p is a wall, and the line of switching, along which p = −½, is the whole policy:
per cell its end a, and the end a' of a run that coasts from the cell's start on. Where the dynamic brake returns r
joules per joule of its work (traction work costing 1) there are two more levels: above b, where p = −½·r, the train
brakes by it, and above c, where p = 0, friction helps: at a lower speed a brake of limited power returns more. V is
convex in w, so p rises with w.

p_k is carried backward as a monotone polyline of points (w, p). A point moves along the flow of its regime,
w0 = φ(w1) by the explicit midpoint rule, and since V_k(w0) = E + λT + V_{k+1}(w1),

    p0 = (∂E/∂w1 + λ·∂T/∂w1 + p1) / φ'(w1),     ∂T/∂w1 = −d/(v0+v1)²·(φ'/v0 + 1/v1).

What lies between the images of two regimes, and between the last one and the wall, is in `step_regions` and
`step_wall`. The derivation is in docs/front-method.md.
"""

import math

from tgvdp._jit import entry, part
from tgvdp.methods.costate.blend import LINES
from tgvdp.methods.costate.brake_jumps import snapped_to_rise
from tgvdp.methods.costate.characteristics import Step, coast_image, dynamic_before, holding_costate, holding_w
from tgvdp.methods.costate.crossings import braking_points, crossing
from tgvdp.methods.costate.polyline import Polyline, insert, make_unique, thin
from tgvdp.methods.costate.step import coast_over, transport
from tgvdp.methods.costate.step_edges import at_rates, at_rises
from tgvdp.methods.costate.step_wall import (
    LEAST_WALL,
    ROUNDING,
    dynamic_suffices,
    fan_region,
    frictionless_m,
    is_wall,
    wall_region,
)
from tgvdp.model.track import POWERED
from tgvdp.physics.cell import Rows
from tgvdp.physics.codes import COASTING, CROWDED, DYNAMIC, OK
from tgvdp.physics.forces import unpowered

#: Room for points of the polyline.
ROOM = 4096
#: More points than this are thinned with a looser tolerance; the polyline is thinned again when it has grown by ...
_MANY_POINTS = 300
_GROWTH = 6
#: Points of partial effort before the last cell.
_LAST_POINTS = 12


@part
def _last_cell(train, step, line):
    """Costates before the last cell, whose end speed, the wall of this step, is given.

    Partial effort up to the speed from which the train coasts there, then coasting until braking begins, dynamically as
    long as that suffices.
    """
    bottom = step.bottom
    top = step.top
    some_w = max(step.wall, LEAST_WALL * top)
    coasts = min(max(coast_image(train, step, step.length, some_w, 0.0)[0], bottom), top)
    ratio = (coasts / bottom) ** (1.0 / (_LAST_POINTS - 1))
    w0 = bottom
    for n in range(_LAST_POINTS):
        line.w[n] = w0
        w0 *= ratio
        line.p[n] = holding_costate(train, step, line.w[n], step.wall)
    n = _LAST_POINTS
    regime = COASTING
    if step.returned > 0.0 and not dynamic_suffices(step):
        regime = DYNAMIC
        braked_m = frictionless_m(train, step)
        n = fan_region(train, step, step.wall, step.dynamic_w, braked_m, line, n)
        if braked_m == step.length:
            line.w[n] = min(max(step.dynamic_w, coasts), top)
            line.p[n] = -0.5 * step.returned
            n += 1
    n = wall_region(train, regime, step, line, n)
    for i in range(n):
        line.p[i] = min(line.p[i], 0.0)  # here all brakes work on the envelope only
    return n


@part
def _step(train, returned, cells, k, price, held_w, held_brake_w, low, fast, floor_w, wall, scratch):
    """The step over cell k, in which a second costs a price.

    At the start a run has one speed, but the line of switching that it meets in the first cell begins beyond that.
    """
    top = snapped_to_rise(train, fast[k] if k > 0 else max(fast[0], fast[1]))
    wall = snapped_to_rise(train, wall)
    bottom = max(low[k], min(floor_w, 0.1 * top))
    load = train.davis_a_n + cells.grade_n[k]
    if cells.supply[k] != POWERED or max(top, wall) <= train.brakes_from_mps * train.brakes_from_mps:
        returned = 0.0
    length = cells.length_m[k]
    air = cells.air[k]
    dynamic_w = dynamic_before(train, length, load, air, wall, top, scratch) if returned > 0.0 else 0.0
    return Step(length, load, air, price, returned, held_w, held_brake_w, bottom, top, wall, dynamic_w)


@entry
def switching_speeds(
    train, returned, cells, low, fast, end_w, multipliers, unit, usual, tolerance, typical_m, floor_w, policies, room
):
    """Backward pass: the optimal switching speeds a, a', b and c for some multipliers, one after the other.

    Full traction below the line of switching, which ends each cell at a; coasting above it, from the cell's start on to
    a' or more; full dynamic braking above b ≥ a, all brakes above c ≥ b. In a neutral section only c means anything.
    Where a is a speed that is held in the next cell, or the envelope, a' = a, and nowhere else. All forces are per unit
    of inertia, and energy is counted so that traction work costs 1.

    Parameters
    ----------
    train : KernelTrain
    returned : float
        Energy that the dynamic brake returns per joule of its work, below 1. If it is 0, b and c are the envelope.
    cells : Cells
        Grade forces, drag and power of auxiliaries per unit of inertia.
    low : (m, K + 1) float64
        Squared speed at each station, m²/s², below which the run of a multiplier is not sought.
    fast : (K + 1,) float64
        Fastest feasible one.
    end_w : float
        Squared speed at the destination.
    multipliers : (m,) float64
        λ, J/s.
    unit : float
        What makes it λ per unit of inertia and joule of traction work.
    usual : float
        The usual multiplier, J/s.
    tolerance : float
        Error of p allowed by thinning in a cell of ``typical_m``; less below the usual multiplier.
    typical_m : float
        Typical cell length, m.
    floor_w : float
        Below this squared speed the polyline is not carried.
    policies : (m, K + 1, 4 or 6) float64, modified in place
        Squared switching speeds a, a', b and c for the station at the end of each cell. If there are two more they are
        the ends e and g of an interval in which the train brakes dynamically, too, which may be none, e = g.
    room : (6, size) float64
        Scratch for the polyline, and for rows; `ROOM` points are plenty.

    Returns
    -------
    done : int
        Multipliers that are solved: all, or those before one that is CROWDED.
    points : int
        Points carried in all, the work done.
    """
    points = 0
    for i in range(multipliers.shape[0]):
        status, carried = _solve(
            train, returned, cells, low[i], fast, end_w, multipliers[i] / unit,
            tolerance * min(1.0, multipliers[i] / usual), typical_m, floor_w, policies[i], room,
        )  # fmt: skip
        points += carried
        if status != OK:
            return i, points
    return multipliers.shape[0], points


@part
def _solve(train, returned, cells, low, fast, end_w, multiplier, tolerance, typical_m, floor_w, policy, room):
    """Fill in the ``policy`` of one multiplier, (K + 1, 4 or 6); returns OK or CROWDED, and the points carried."""
    count = cells.length_m.shape[0]
    line = Polyline(room[0], room[1])
    images = Polyline(room[2], room[3])
    scratch = Rows(room[4], room[5])
    dark = unpowered(train)
    drops = returned > 0.0 and train.last_drop_mps > 0.0
    rises = policy.shape[1] > LINES
    brakes_w = train.brakes_from_mps * train.brakes_from_mps
    policy[count] = end_w
    policy[0] = fast[0]
    policy[:, LINES:] = brakes_w
    points = 0
    if count == 1:
        return OK, points
    k = count - 1
    price = multiplier - cells.saved_w[k]
    step = _step(train, returned, cells, k, price, math.inf, math.inf, low, fast, floor_w, end_w, scratch)
    n = make_unique(line, _last_cell(train, step, line), step.top, -0.5 * returned, brakes_w, rises, drops)
    loosen = 1.0
    thinned = n
    held_air = -1.0
    held_w = math.inf
    held_brake_w = math.inf
    for k in range(count - 2, -1, -1):
        before = price
        after_w = held_w  # what is held in the cell behind
        price = multiplier - cells.saved_w[k]
        if cells.air[k] != held_air or price != before:
            held_air = cells.air[k]
            held_w = holding_w(train.davis_b, held_air, price)
            held_brake_w = holding_w(train.davis_b, held_air, price / returned) if returned > 0.0 else math.inf
        share = loosen * cells.length_m[k] / typical_m
        slack = tolerance * share
        wall = fast[k + 1]
        step = _step(train, returned, cells, k, price, held_w, held_brake_w, low, fast, floor_w, wall, scratch)
        policy[k + 1, :LINES] = fast[k + 1]
        powered = cells.supply[k] == POWERED
        if step.returned > 0.0:
            n = at_rises(train, line, at_rates(train, line, n))
        drives, a = crossing(-0.5, line, n, 0)
        policy[k + 1, 0] = a
        policy[k + 1, 1] = a
        early = late = coasts = 0
        if powered:
            n = insert(line, n, drives, a, -0.5)
            early = late = coasts = n - 1
            if step.returned > 0.0:
                n, early, late, coasts = braking_points(train, returned, step, line, n, drives, rises, policy[k + 1])
        brakes = n - 1
        if returned > 0.0:
            brakes, c = crossing(0.0, line, n, coasts)
            if is_wall(step, c):  # by a rounding before it, or at it
                brakes = n - 1
            elif brakes < n:
                n = insert(line, n, brakes, c, 0.0)
                policy[k + 1, 3] = c
            brakes = min(brakes, n - 1)
        points += n
        if powered:
            m, switch = transport(train, step, line, n, drives, early, late, coasts, brakes, images, scratch)
            if switch == a < wall and abs(a - after_w) > ROUNDING * a:
                switch = a * (1.0 + 4.0 * ROUNDING)  # else a speed is held there
            policy[k + 1, 1] = switch
        else:
            m = coast_over(dark, step, line, n, brakes, images, scratch)
        if k == 0:
            break
        m = make_unique(images, m, step.top, -0.5 * returned, brakes_w, rises, drops)
        if m <= thinned + _GROWTH:
            line, images = images, line
            n = m
            thinned = min(thinned, n)
            continue
        n = thin(images, m, -0.5 * returned, slack, min(share, 1.0), line)
        thinned = n
        if n > _MANY_POINTS:
            loosen *= 1.5
        elif loosen > 1.0 and n < _MANY_POINTS // 2:
            loosen = max(1.0, loosen / 1.2)
        if n > room.shape[1] // 2 - 64:
            return CROWDED, points
    return OK, points
