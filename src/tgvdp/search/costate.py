"""The costate dynamic program: switching speeds for one multiplier (backward pass of the front method).

For a multiplier λ (J/s) minimise J = E + λT. Let V_k(w) be the cost to go from station k at w = v², per unit of
inertia, and p_k = dV_k/dw its costate. Only three regimes and holding occur (Pontryagin; Howlett & Pudney 1995,
Albrecht et al. 2016): with e = 1 for wheel energy, the effort's coefficient in the Hamiltonian is e + 2p, so

    p < −½        full traction          −½ < p ≤ 0    coasting

and p never rises above 0: a faster train can always brake to a slower one, for nothing. Braking is therefore left to
the envelope of feasible speeds, where p is a wall, and one switching speed per station, a where p = −½, is the whole
policy. Where the dynamic brake returns r joules per joule of its work (traction work costing 1) there is a second
level: above b, where p = −½·r, the train brakes by it. V is convex in w, so p rises with w.

p_k is carried backward as a monotone polyline of points (w, p). A point moves along the flow of its regime,
w0 = φ(w1) by the explicit midpoint rule, and since V_k(w0) = E + λT + V_{k+1}(w1),

    p0 = (∂E/∂w1 + λ·∂T/∂w1 + p1) / φ'(w1),     ∂T/∂w1 = −d/(v0+v1)²·(φ'/v0 + 1/v1).

The crossing point moves along both flows; between the two images the optimal run holds a by partial effort, and
between the image of the wall and the envelope it brakes to the wall. There the target w1 is fixed, and
p0 = ∂X/∂w0 + λ·∂T/∂w0 (without ∂X when braking) follows from the arc (`characteristics`, `polyline`). The derivation
is in docs/front-method.md.
"""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.physics.forces import mean_effort, mean_resistance
from tgvdp.search.characteristics import braking_costate, holding_costate, transport
from tgvdp.search.polyline import make_monotone, thin

#: Room for points of the polyline.
ROOM = 4096
#: More points than this are thinned with a looser tolerance; the polyline is thinned again when it has grown by ...
_MANY_POINTS = 300
_GROWTH = 6

DONE = 0
CROWDED = 1  # too many points


@leaf
def _level(davis_b, length, air, effort_price, price, w):
    """Costate at which w itself is the optimal target speed near holding.

    Stationarity in w1 of X·e + λT + V(w1):  p + e·(½ + d·(½C + ¼B/v)/m_eff) − λ·d/(4v³) = 0.
    """
    v = math.sqrt(w)
    work_w = 0.5 + length * (0.5 * air + 0.25 * davis_b / v)
    return price * length * 0.25 / (w * v) - effort_price * work_w


@part
def _crossing(davis_b, length, air, effort_price, price, w, p, n, first):
    """Where the polyline crosses a level, from ``first`` on: first index above it, w and p there.

    Its two ends are vertical walls.
    """
    # Levels are never below the one at the lowest speed without its time term: most points need no more than that.
    lowest = _level(davis_b, length, air, effort_price, 0.0, w[first])
    i = first
    while i < n and p[i] < lowest:
        i += 1
    while i < n and p[i] < _level(davis_b, length, air, effort_price, price, w[i]):
        i += 1
    if i == first:
        return i, w[i], _level(davis_b, length, air, effort_price, price, w[i])
    before = p[i - 1] - _level(davis_b, length, air, effort_price, price, w[i - 1])
    if i == n:
        return n, w[n - 1], p[n - 1] - before
    after = p[i] - _level(davis_b, length, air, effort_price, price, w[i])
    share = before / (before - after)
    return i, w[i - 1] + share * (w[i] - w[i - 1]), p[i - 1] + share * (p[i] - p[i - 1])


@part
def _insert(w, p, n, at, cross_w, cross_p):
    """Make a crossing a point of the polyline; returns its new number of points."""
    for i in range(n, at, -1):
        w[i] = w[i - 1]
        p[i] = p[i - 1]
    w[at] = cross_w
    p[at] = cross_p
    return n + 1


@leaf
def _arc_costate(train, length, air, returned, price, braking, w0, w1):
    """Costate of an arc to a given end speed: by traction (0), the dynamic brake (1), or all brakes (2)."""
    if braking == 2:
        return braking_costate(train, length, returned, price, w0, w1)
    return holding_costate(train.davis_b, length, air, 1.0 if braking == 0 else returned, price, w0, w1)


@part
def _last_cell(train, length, grade, air, returned, price, bottom, top, end_w, w, p):
    """Costates before the last cell, whose end speed is given: straight from the arc.

    They jump where its work is 0, and where it is all that the dynamic brake can do.
    """
    n = 0
    count = 12
    ratio = (top / bottom) ** (1.0 / (count - 1)) if top > bottom else 1.0
    w0 = bottom
    last_w = bottom
    braking = 0
    before = (0.0, 0.0)
    end_v = math.sqrt(end_w)
    for i in range(count):
        if i == count - 1:
            w0 = top
        v0 = math.sqrt(w0)
        work = 0.5 * (end_w - w0) + length * (mean_resistance(train, air, v0, end_v) + grade)
        excess = (work, work + length * mean_effort(train.braking, v0, end_v))
        for level in range(2):
            if braking == level and excess[level] <= 0.0:
                braking = level + 1
                if i > 0:
                    root = last_w + (w0 - last_w) * before[level] / (before[level] - excess[level])
                    for side in range(2):
                        w[n] = root
                        p[n] = _arc_costate(train, length, air, returned, price, level + side, root, end_w)
                        n += 1
        w[n] = w0
        p[n] = _arc_costate(train, length, air, returned, price, braking, w0, end_w)
        n += 1
        before = excess
        last_w = w0
        w0 *= ratio
    return n


@kernel
def switching_speeds(
    train, returned, length, grade, air, low, fast, end_w, price, tolerance, typical_m, floor_w, policy, room
):
    """Backward pass: the optimal switching speeds a ≤ b for one multiplier.

    Full traction below a, coasting from a to b, full dynamic braking above b. All forces are per unit of inertia, and
    energy is counted so that traction work costs 1.

    Parameters
    ----------
    train : KernelTrain
    returned : float
        Energy that the dynamic brake returns per joule of its work, below 1. If it is 0, b is the envelope.
    length, grade, air
        Lengths, grade forces and drag of the cells, (K,) float64.
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
    policy : (K + 1, 2) float64, modified in place
        Squared switching speeds a and b for the station at the end of each cell.
    room : (4, size) float64
        Scratch for the polyline; `ROOM` points are plenty.

    Returns
    -------
    status : int
        DONE or CROWDED.
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
        return DONE, points
    k = count - 1
    bottom = max(low[k], min(floor_w, 0.1 * fast[k]))
    n = _last_cell(train, length[k], grade[k], air[k], returned, price, bottom, fast[k], end_w, w, p)
    n = make_monotone(w, p, n, fast[k])
    loosen = 1.0
    thinned = n
    for k in range(count - 2, -1, -1):
        d = length[k]
        drives, cross_w, cross_p = _crossing(train.davis_b, d, air[k], 1.0, price, w, p, n, 0)
        policy[k + 1, 0] = cross_w
        n = _insert(w, p, n, drives, cross_w, cross_p)
        coasts = n - 1
        policy[k + 1, 1] = fast[k + 1]
        if returned > 0.0:
            coasts, cross_w, cross_p = _crossing(train.davis_b, d, air[k], returned, price, w, p, n, drives)
            policy[k + 1, 1] = cross_w
            n = _insert(w, p, n, coasts, cross_w, cross_p)
        if k == 0:
            break
        points += n
        bottom = max(low[k], min(floor_w, 0.1 * fast[k]))
        load = train.davis_a_n + grade[k]
        m = transport(
            train, returned, d, load, air[k], price, bottom, fast[k], fast[k + 1], w, p, n, drives, coasts, x, y
        )
        m = make_monotone(x, y, m, fast[k])
        if m <= thinned + _GROWTH:
            w, x = x, w
            p, y = y, p
            n = m
            continue
        n = thin(x, y, m, -0.5 * returned, tolerance * loosen * d / typical_m, w, p)
        thinned = n
        if n > _MANY_POINTS:
            loosen *= 1.5
        elif loosen > 1.0 and n < _MANY_POINTS // 2:
            loosen = max(1.0, loosen / 1.2)
        if n > room.shape[1] // 2 - 64:
            return CROWDED, points
    return DONE, points
