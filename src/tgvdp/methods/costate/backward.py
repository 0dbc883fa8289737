"""The costate dynamic program: switching speeds for one multiplier (backward pass of the front method).

For a multiplier λ (J/s) minimise J = E + λT. Let V_k(w) be the cost to go from station k at w = v², per unit of
inertia, and p_k = dV_k/dw its costate. Only three regimes and holding occur (Pontryagin; Howlett & Pudney 1995,
Albrecht et al. 2016): with e = 1 for wheel energy, the effort's coefficient in the Hamiltonian is e + 2p, so

    p < −½        full traction          −½ < p ≤ 0    coasting

and p never rises above 0: a faster train can always brake to a slower one, for nothing. Braking is therefore left to
the envelope of feasible speeds, where p is a wall, and the line of switching, along which p = −½, is the whole policy:
per cell its end a, and the end a' of a run that coasts from the cell's start on. Where the dynamic brake returns r
joules per joule of its work (traction work costing 1) there is a second level: above b, where p = −½·r, the train
brakes by it. V is convex in w, so p rises with w.

p_k is carried backward as a monotone polyline of points (w, p). A point moves along the flow of its regime,
w0 = φ(w1) by the explicit midpoint rule, and since V_k(w0) = E + λT + V_{k+1}(w1),

    p0 = (∂E/∂w1 + λ·∂T/∂w1 + p1) / φ'(w1),     ∂T/∂w1 = −d/(v0+v1)²·(φ'/v0 + 1/v1).

What lies between the images of two regimes, and between the last one and the wall, is in `regions`. The derivation
is in docs/front-method.md.
"""

import math

from tgvdp._jit import kernel, part
from tgvdp.methods.costate.characteristics import coast_image, holding_costate, holding_w, saturated_image
from tgvdp.methods.costate.polyline import insert, make_monotone, thin
from tgvdp.methods.costate.step import transport
from tgvdp.methods.costate.step_regions import LEAST_WALL, dynamic_suffices, wall_region
from tgvdp.physics.codes import COASTING, CROWDED, DYNAMIC, OK

#: Room for points of the polyline.
ROOM = 4096
#: More points than this are thinned with a looser tolerance; the polyline is thinned again when it has grown by ...
_MANY_POINTS = 300
_GROWTH = 6
#: Points of partial effort before the last cell.
_LAST_POINTS = 12


@part
def _crossing(level, w, p, n, first):
    """Where the polyline crosses a level, from ``first`` on: first index above it, and w there.

    Its two ends are vertical walls.
    """
    i = first
    while i < n and p[i] < level:
        i += 1
    if i == first:
        return i, w[i]
    if i == n:
        return n, w[n - 1]
    share = (level - p[i - 1]) / (p[i] - p[i - 1])
    return i, w[i - 1] + share * (w[i] - w[i - 1])


@part
def _snapped(held, slack, level, w, p, n, at, cross_w):
    """A crossing, moved to the speed that is held if p is at the level there, within the error of the polyline.

    Next to that speed p hardly changes: thinning alone would move the crossing about.
    """
    if not w[0] < held < w[n - 1]:
        return at, cross_w
    i = at if at < n else n - 1
    while i > 1 and w[i - 1] >= held:
        i -= 1
    while w[i] < held:
        i += 1
    here = p[i] if w[i] <= w[i - 1] else p[i - 1] + (p[i] - p[i - 1]) * (held - w[i - 1]) / (w[i] - w[i - 1])
    return (i, held) if abs(here - level) <= slack else (at, cross_w)


@part
def _last_cell(train, returned, length, load, air, price, bottom, top, end_w, w, p):
    """Costates before the last cell, whose end speed is given.

    Partial effort up to the speed from which the train coasts there, then coasting until braking begins, dynamically as
    long as that suffices.
    """
    some_w = max(end_w, LEAST_WALL * top)
    coasts = min(max(coast_image(train.davis_b, length, load, air, price, bottom, some_w, 0.0)[0], bottom), top)
    ratio = (coasts / bottom) ** (1.0 / (_LAST_POINTS - 1))
    w0 = bottom
    for n in range(_LAST_POINTS):
        w[n] = w0
        w0 *= ratio
        p[n] = holding_costate(train.davis_b, length, air, 1.0, price, w[n], end_w)
    n = _LAST_POINTS
    regime = COASTING
    if returned > 0.0 and not dynamic_suffices(train, length, load, air, top, end_w):
        regime = DYNAMIC
        brakes = saturated_image(train, DYNAMIC, returned, length, load, air, price, bottom, some_w, 0.0)[0]
        w[n] = min(max(brakes, coasts), top)
        p[n] = -0.5 * returned
        n += 1
    return wall_region(train, regime, returned, length, load, air, price, bottom, top, end_w, w, p, n)


@kernel
def switching_speeds(
    train, returned, cells, low, fast, end_w, price, tolerance, typical_m, floor_w, policy, room
):
    """Backward pass: the optimal switching speeds a, a' and b for one multiplier.

    Full traction below the line of switching, which ends each cell at a; coasting above it, from the cell's start on to
    a' or more; full dynamic braking above b ≥ a. All forces are per unit of inertia, and energy is counted so that
    traction work costs 1.

    Parameters
    ----------
    train : KernelTrain
    returned : float
        Energy that the dynamic brake returns per joule of its work, below 1. If it is 0, b is the envelope.
    cells : Cells
        Grade forces and drag per unit of inertia.
    low, fast : (K + 1,) float64
        Slowest and fastest feasible squared speed at each station, m²/s².
    end_w : float
        Squared speed at the destination.
    price : float
        Multiplier λ per unit of inertia, J/(s·kg).
    tolerance : float
        Error of p allowed by thinning in a cell of ``typical_m``.
    typical_m : float
        Typical cell length, m.
    floor_w : float
        Below this squared speed the polyline is not carried.
    policy : (K + 1, 3) float64, modified in place
        Squared switching speeds a, a' and b for the station at the end of each cell.
    room : (4, size) float64
        Scratch for the polyline; `ROOM` points are plenty.

    Returns
    -------
    status : int
        OK or CROWDED.
    points : int
        Points carried in all, the work done.
    """
    count = length.shape[0]
    w = room[0]
    p = room[1]
    x = room[2]
    y = room[3]
    policy[count] = end_w
    policy[0] = fast[0]
    points = 0
    if count == 1:
        return OK, points
    k = count - 1
    bottom = max(low[k], min(floor_w, 0.1 * fast[k]))
    load = train.davis_a_n + grade[k]
    n = _last_cell(train, returned, length[k], load, air[k], price, bottom, fast[k], end_w, w, p)
    n = make_monotone(w, p, n, fast[k])
    loosen = 1.0
    thinned = n
    held_air = -1.0
    held_w = math.inf
    held_brake_w = math.inf
    for k in range(count - 2, -1, -1):
        d = length[k]
        if air[k] != held_air:
            held_air = air[k]
            held_w = holding_w(train.davis_b, held_air, price)
            held_brake_w = holding_w(train.davis_b, held_air, price / returned) if returned > 0.0 else math.inf
        slack = tolerance * loosen * d / typical_m
        drives, a = _crossing(-0.5, w, p, n, 0)
        drives, a = _snapped(held_w, slack, -0.5, w, p, n, drives, a)
        n = insert(w, p, n, drives, a, -0.5)
        coasts = n - 1
        b = fast[k + 1]
        if returned > 0.0:
            coasts, b = _crossing(-0.5 * returned, w, p, n, drives)
            n = insert(w, p, n, coasts, b, -0.5 * returned)
        policy[k + 1, 0] = a
        policy[k + 1, 1] = a
        policy[k + 1, 2] = b
        if k == 0:
            break
        points += n
        bottom = max(low[k], min(floor_w, 0.1 * fast[k]))
        load = train.davis_a_n + grade[k]
        m, coast_w = transport(
            train, returned, d, load, held_air, price, held_w, held_brake_w, bottom, fast[k], fast[k + 1], w, p, n,
            drives, coasts, x, y,
        )  # fmt: skip
        policy[k + 1, 1] = coast_w
        m = make_monotone(x, y, m, fast[k])
        if m <= thinned + _GROWTH:
            w, x = x, w
            p, y = y, p
            n = m
            continue
        n = thin(x, y, m, -0.5 * returned, slack, w, p)
        thinned = n
        if n > _MANY_POINTS:
            loosen *= 1.5
        elif loosen > 1.0 and n < _MANY_POINTS // 2:
            loosen = max(1.0, loosen / 1.2)
        if n > room.shape[1] // 2 - 64:
            return CROWDED, points
    return OK, points
