"""The costate dynamic program: switching speeds for one multiplier (backward pass of the front method).

For a multiplier λ (J/s) minimise J = E + λT. Let V_k(w) be the cost to go from station k at w = v², per unit of
inertia, and p_k = dV_k/dw its costate. Only three regimes and holding occur (Pontryagin; Howlett & Pudney 1995,
Albrecht et al. 2016): with e = 1 for wheel energy, the effort's coefficient in the Hamiltonian is e + 2p, so

    p < −½        full traction          −½ < p ≤ 0    coasting

and p never rises above 0: a faster train can always brake to a slower one, for nothing. Braking is therefore left to
the envelope of feasible speeds, where p is a wall, and one switching speed per station, a where p = −½, is the whole
policy. V is convex in w, so p rises with w. p_k is carried backward as a monotone polyline of points (w, p). A point
moves along the flow of its regime, w0 = φ(w1) by the explicit midpoint rule, and since V_k(w0) = E + λT + V_{k+1}(w1),

    p0 = (∂E/∂w1 + λ·∂T/∂w1 + p1) / φ'(w1),     ∂T/∂w1 = −d/(v0+v1)²·(φ'/v0 + 1/v1).

The crossing point moves along both flows; between the two images the optimal run holds a by partial effort, and
between the image of the wall and the envelope it brakes to the wall. There the target w1 is fixed, and
p0 = ∂X/∂w0 + λ·∂T/∂w0 (without ∂X when braking) follows from the arc. The derivation is in docs/front-method.md.
"""

import math

import numpy as np

from tgvdp._jit import kernel, leaf, part
from tgvdp.physics.forces import effort_and_slope, mean_resistance, resistance_at, unpowered
from tgvdp.physics.motion import COASTING, TRACTION
from tgvdp.physics.resolved import POWERED

#: Room for points of the polyline, before and after thinning.
_ROOM = 4096
_MOST_POINTS = 600
#: Neighbouring images are no further apart than this factor of w, below this share of the envelope.
_SPREAD = 2.0
_SLOW_SHARE = 0.1

DONE = 0
CROWDED = 1  # too many points


@leaf
def _flow(train, regime, grade, air, per_mass, v, per_v):
    """Slope g = dw/ds, its derivative by w, and dF/dw / m_eff of traction (0 otherwise) at v under a regime."""
    load = (resistance_at(train, air, v) + grade) * per_mass
    load_w = (0.5 * train.davis_b * per_v + air) * per_mass
    if regime == TRACTION:
        effort, slope = effort_and_slope(train.traction, v)
        force = effort * per_mass
        if force - load < train.max_acceleration:
            force_w = 0.5 * slope * per_v * per_mass
            return 2.0 * (force - load), 2.0 * (force_w - load_w), force_w
        return 2.0 * train.max_acceleration, 0.0, load_w
    return -2.0 * load, -2.0 * load_w, 0.0


@leaf
def _carry_back(train, regime, length, grade, air, per_mass, price, floor, w1, p1):
    """Move a point (w1, p1) of the polyline back over a cell; p is only defined where the image is above 0."""
    v1 = math.sqrt(w1)
    per_v1 = 1.0 / v1
    g1, g1_w, _ = _flow(train, regime, grade, air, per_mass, v1, per_v1)
    middle = math.sqrt(max(w1 - 0.5 * length * g1, floor))
    middle_w = 1.0 - 0.5 * length * g1_w
    g, g_w, force_w = _flow(train, regime, grade, air, per_mass, middle, 1.0 / middle)
    w0 = w1 - length * g
    if w0 <= 0.25 * floor:
        return w0, 0.0
    image_w = max(1.0 - length * g_w * middle_w, 1e-3)
    v0 = math.sqrt(w0)
    per_s = 1.0 / (v0 + v1)
    time_w = -length * per_s * per_s * (image_w / v0 + per_v1)
    return w0, (length * force_w * middle_w + price * time_w + p1) / image_w


@kernel
def _holding_costate(train, length, air, effort_price, price, w0, w1):
    """Costate at w0 of partial effort towards a fixed w1: derivative of X·e + λT by w0, per unit of inertia."""
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    s = v0 + v1
    linear = 0.0
    if train.davis_b != 0.0:
        mean_v_w = (2.0 / 3.0) * ((1.0 + 0.5 * v1 / v0) * s - (w0 + w1 + v0 * v1) * 0.5 / v0) / (s * s)
        linear = train.davis_b * mean_v_w
    work_w = -0.5 + length * (0.5 * air + linear) / train.inertia_kg
    return effort_price * work_w - price * length / (s * s * v0)


@leaf
def _level(train, length, air, effort_price, price, w):
    """Costate at which w itself is the optimal target speed near holding.

    Stationarity in w1 of X·e + λT + V(w1):  p + e·(½ + d·(½C + ¼B/v)/m_eff) − λ·d/(4v³) = 0.
    """
    v = math.sqrt(w)
    work_w = 0.5 + length * (0.5 * air + 0.25 * train.davis_b / v) / train.inertia_kg
    return price * length * 0.25 / (w * v) - effort_price * work_w


@part
def _crossing(train, length, air, effort_price, price, w, p, n):
    """Where the polyline crosses a level: first index above it, w and p there. Its two ends are vertical walls."""
    # Levels are never below the one at the lowest speed without its time term: most points need no more than that.
    lowest = _level(train, length, air, effort_price, 0.0, w[0])
    i = 0
    while i < n and p[i] < lowest:
        i += 1
    while i < n and p[i] < _level(train, length, air, effort_price, price, w[i]):
        i += 1
    if i == 0:
        return 0, w[0], _level(train, length, air, effort_price, price, w[0])
    before = p[i - 1] - _level(train, length, air, effort_price, price, w[i - 1])
    if i == n:
        return n, w[n - 1], p[n - 1] - before
    after = p[i] - _level(train, length, air, effort_price, price, w[i])
    share = before / (before - after)
    return i, w[i - 1] + share * (w[i] - w[i - 1]), p[i - 1] + share * (p[i] - p[i - 1])


@part
def _last_cell(train, length, grade, air, price, bottom, top, end_w, w, p):
    """Costates before the last cell, whose end speed is given: straight from the arc, with its jump at X = 0."""
    n = 0
    count = 12
    ratio = (top / bottom) ** (1.0 / (count - 1)) if top > bottom else 1.0
    w0 = bottom
    before = 1.0
    for i in range(count):
        if i == count - 1:
            w0 = top
        v0 = math.sqrt(w0)
        load = length * (mean_resistance(train, air, v0, math.sqrt(end_w)) + grade)
        work = 0.5 * train.inertia_kg * (end_w - w0) + load
        if n > 0 and before > 0.0 >= work:
            root = w[n - 1] + (w0 - w[n - 1]) * before / (before - work)
            w[n] = root
            p[n] = _holding_costate(train, length, air, 1.0, price, root, end_w)
            w[n + 1] = root
            p[n + 1] = _holding_costate(train, length, air, 0.0, price, root, end_w)
            n += 2
        w[n] = w0
        p[n] = _holding_costate(train, length, air, 1.0 if work > 0.0 else 0.0, price, w0, end_w)
        n += 1
        before = work
        w0 *= ratio
    return n


@kernel
def _carry_region(train, regime, length, grade, air, price, bottom, top, w, p, first, last, x, y, m):
    """Append the images of the points ``first`` .. ``last`` that lie above ``bottom``, until one passes ``top``."""
    per_mass = 1.0 / train.inertia_kg
    lost_w = -1.0
    last_w = -1.0
    last_p = 0.0
    image = 0.0
    for i in range(first, last + 1):
        w0, p0 = _carry_back(train, regime, length, grade, air, per_mass, price, bottom, w[i], p[i])
        if w0 < bottom:
            lost_w = w[i]
            last_w = w[i]
            last_p = p[i]
            image = w0
            continue
        # Next to standstill p varies as 1/v, which no straight line follows: fill gaps, from the edge at ``bottom`` on.
        # Below the crossing the regime is full traction whatever p is, so there the edge alone will do.
        target = _SPREAD * image if regime == COASTING else math.inf
        if lost_w >= 0.0:
            target = bottom
        while last_w >= 0.0 and target < min(w0, _SLOW_SHARE * top):
            share = (target - image) / (w0 - image)
            edge_w, edge_p = _carry_back(
                train, regime, length, grade, air, per_mass, price, bottom,
                last_w + share * (w[i] - last_w), last_p + share * (p[i] - last_p),
            )  # fmt: skip
            if edge_w > 0.25 * bottom and edge_p <= p0:
                x[m] = target if target == bottom else edge_w
                y[m] = edge_p
                m += 1
            target = _SPREAD * target if regime == COASTING else math.inf
        lost_w = -1.0
        last_w = w[i]
        last_p = p[i]
        image = w0
        x[m] = w0
        y[m] = p0
        m += 1
        if w0 > top:
            break
    return m


@part
def _transport(train, length, grade, air, price, bottom, top, wall, w, p, n, cut, x, y):
    """Images (x, y) of the polyline one cell back; point ``cut`` of it is the crossing, ``wall`` the cap behind it."""
    m = _carry_region(train, TRACTION, length, grade, air, price, bottom, top, w, p, 0, cut, x, y, 0)
    if m > 0 and x[m - 1] > top:
        return m
    hold = w[cut]
    below = m
    if m == 0:
        x[0] = bottom
        y[0] = _holding_costate(train, length, air, 1.0, price, bottom, hold)
        m = 1
    m = m + 1  # room for holding, if it lies between the images
    after = _carry_region(train, COASTING, length, grade, air, price, bottom, top, w, p, cut, n - 1, x, y, m)
    if after > m and below == 0 and x[m] <= bottom:  # coasting alone covers everything
        x[0] = x[m]
        y[0] = y[m]
    if x[m - 2] < hold and (after == m or hold < x[m]):
        x[m - 1] = min(hold, top)
        y[m - 1] = _holding_costate(train, length, air, 1.0, price, x[m - 1], hold)
    else:
        x[m - 1] = x[m - 2]
        y[m - 1] = y[m - 2]
    m = after
    if x[m - 1] < top:  # braking to the wall
        x[m] = x[m - 1]
        y[m] = _holding_costate(train, length, air, 0.0, price, x[m], wall)
        x[m + 1] = top
        y[m + 1] = _holding_costate(train, length, air, 0.0, price, top, wall)
        m += 2
    return m


@kernel
def _make_monotone(x, y, m, top):
    """Running maximum in both coordinates, p ≤ 0, cut at ``top``; returns the number of points left."""
    y[0] = min(y[0], 0.0)
    for i in range(1, m):
        x[i] = max(x[i], x[i - 1])
        y[i] = min(max(y[i], y[i - 1]), 0.0)
    while m > 1 and x[m - 2] >= top:
        m -= 1
    if x[m - 1] > top:
        if m > 1 and x[m - 1] > x[m - 2]:
            share = (top - x[m - 2]) / (x[m - 1] - x[m - 2])
            y[m - 1] = y[m - 2] + share * (y[m - 1] - y[m - 2])
        x[m - 1] = top
    return m


@part
def _thin(x, y, m, near, far, w, p):
    """Swinging-door thinning of (x, y) into (w, p): within ``near`` at the levels, looser away from them."""
    w[0] = x[0]
    p[0] = y[0]
    n = 1
    if m == 1:
        return n
    door_x = x[0]
    door_y = y[0]
    steepest = math.inf
    flattest = -math.inf
    tiny = 1e-12 * x[m - 1]
    for i in range(1, m):
        dx = max(x[i] - door_x, tiny)
        slope = (y[i] - door_y) / dx
        if slope < flattest or slope > steepest:
            w[n] = x[i - 1]
            p[n] = y[i - 1]
            n += 1
            door_x = x[i - 1]
            door_y = y[i - 1]
            steepest = math.inf
            flattest = -math.inf
            dx = max(x[i] - door_x, tiny)
        if y[i] < -0.5:
            away = -0.5 - y[i]
            slack = near + min(0.5 * away, 0.25) * away
        else:
            away = min(y[i] + 0.5, -y[i])
            slack = near + far * max(0.0, away - 0.005)
        steepest = min(steepest, (y[i] + slack - door_y) / dx)
        flattest = max(flattest, (y[i] - slack - door_y) / dx)
    w[n] = x[m - 1]
    p[n] = y[m - 1]
    return n + 1


@kernel
def switching_speeds(train, length, grade, air, supply, low, fast, end_w, price, tolerance, typical_m, floor_w, switch):
    """Backward pass: the optimal switching speeds for one multiplier: full traction below, coasting above.

    Parameters
    ----------
    train : KernelTrain
    length, grade, air, supply
        Arrays of `Cells`, (K,) each.
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
    switch : (K + 1,) float64, modified in place
        Squared switching speed for the station at the end of each cell.

    Returns
    -------
    status : int
        DONE or CROWDED.
    points : int
        Points carried in all, the work done.
    """
    count = length.shape[0]
    w = np.empty(_ROOM)
    p = np.empty(_ROOM)
    x = np.empty(_ROOM)
    y = np.empty(_ROOM)
    switch[count] = end_w
    switch[0] = fast[0]
    points = 0
    if count == 1:
        return DONE, points
    k = count - 1
    bottom = max(low[k], min(floor_w, 0.1 * fast[k]))
    n = _last_cell(train, length[k], grade[k], air[k], price, bottom, fast[k], end_w, w, p)
    n = _make_monotone(w, p, n, fast[k])
    loosen = 1.0
    dark = unpowered(train)
    for k in range(count - 2, -1, -1):
        d = length[k]
        cut, cross_w, cross_p = _crossing(train, d, air[k], 1.0, price, w, p, n)
        switch[k + 1] = cross_w
        if k == 0:
            break
        for i in range(n, cut, -1):  # the crossing becomes a point of the polyline
            w[i] = w[i - 1]
            p[i] = p[i - 1]
        w[cut] = cross_w
        p[cut] = cross_p
        bottom = max(low[k], min(floor_w, 0.1 * fast[k]))
        here = train if supply[k] == POWERED else dark
        m = _transport(here, d, grade[k], air[k], price, bottom, fast[k], fast[k + 1], w, p, n + 1, cut, x, y)
        m = _make_monotone(x, y, m, fast[k])
        near = tolerance * loosen * d / typical_m
        n = _thin(x, y, m, near, 400.0 * near, w, p)
        points += n
        if n > _MOST_POINTS // 2:
            loosen *= 1.5
        elif loosen > 1.0 and n < _MOST_POINTS // 4:
            loosen = max(1.0, loosen / 1.2)
        if n > _ROOM // 2 - 8:
            return CROWDED, points
    return DONE, points
