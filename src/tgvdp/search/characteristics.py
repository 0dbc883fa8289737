"""Characteristics of the costate: points (w, p) carried back over one cell along the flow of their regime.

Everything here is per unit of inertia: the train's forces are accelerations. A point moves by the explicit midpoint
rule w0 = φ(w1), and its costate by the derivative of the cost of the arc along that map (docs/front-method.md),

    p0 = (∂E/∂w1 + λ·∂T/∂w1 + p1) / φ'(w1),     ∂T/∂w1 = −d/(v0+v1)²·(φ'/v0 + 1/v1).
"""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.physics.forces import effort_and_slope, mean_effort, mean_resistance
from tgvdp.physics.motion import COASTING, DYNAMIC, TRACTION

#: Neighbouring images are no further apart than this factor of w, below this share of the envelope.
_SPREAD = 2.0
_SLOW_SHARE = 0.1
#: An image below this share of the floor has no costate: it is taken to be there.
_LOST = 0.25
#: Runs that meet the wall within a cell have costates at so many points per relative change of the wall, at most, ...
_WALL_PIECES = 40.0
_MOST_WALL_PIECES = 8
#: ... down to this share of it before the cell.
LEAST_WALL = 1e-3
#: Rows of braking curves keep to the brake's effort to this share.
_ROUNDING = 0.01
#: A switching speed beyond the wall is at most this multiple of it.
_BEYOND = 4.0


@leaf
def holding_costate(davis_b, length, air, effort_price, price, w0, w1):
    """Costate at w0 of partial effort towards a fixed w1: derivative of X·e + λT by w0."""
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    s = v0 + v1
    linear = 0.0
    if davis_b != 0.0:
        mean_v_w = (2.0 / 3.0) * ((1.0 + 0.5 * v1 / v0) * s - (w0 + w1 + v0 * v1) * 0.5 / v0) / (s * s)
        linear = davis_b * mean_v_w
    work_w = -0.5 + length * (0.5 * air + linear)
    return effort_price * work_w - price * length / (s * s * v0)


@leaf
def _costate_before(length, price, lost, v1, w0, image_w, work_w, p1):
    """Costate at the image w0 of v1², whose derivative is ``image_w``; ``work_w`` is that of the effort's work."""
    v0 = math.sqrt(w0 if w0 > lost else lost)
    s = v0 + v1
    span = s * s * v0 * v1
    return ((length * work_w + p1) * span - price * length * (image_w * v1 + v0)) / (span * image_w)


@leaf
def coast_back(davis_b, length, load, air, price, floor, w1, p1):
    """Image of a point under coasting; its p means nothing where the image is below `_LOST` of the floor.

    No branch and no call is in here: the loop over the polyline runs in vector registers.
    """
    v1 = math.sqrt(w1)
    middle = w1 + length * (load + davis_b * v1 + air * w1)
    middle = middle if middle > floor else floor
    middle_v = math.sqrt(middle)
    per_v = 0.5 * davis_b / (v1 * middle_v)
    middle_w = 1.0 + length * (per_v * middle_v + air)
    w0 = w1 + 2.0 * length * (load + davis_b * middle_v + air * middle)
    image_w = 1.0 + 2.0 * length * (per_v * v1 + air) * middle_w
    return w0, _costate_before(length, price, _LOST * floor, v1, w0, image_w, 0.0, p1)


@leaf
def _saturated_slope(train, regime, load, air, v):
    """Slope dw/ds, its derivative by w, and that of the effort, under full traction or full dynamic braking."""
    table = train.traction if regime == TRACTION else train.braking
    i = table.shape[0] - 1
    while i > 0 and table[i, 0] > v:
        i -= 1
    per_v = 1.0 / v
    hyperbolic = table[i, 1] * per_v
    effort = hyperbolic + table[i, 2] + v * (table[i, 3] + v * (table[i, 4] + v * table[i, 5]))
    slope = table[i, 3] + v * (2.0 * table[i, 4] + v * 3.0 * table[i, 5]) - hyperbolic * per_v
    if regime != TRACTION:
        effort = -effort
        slope = -slope
    resistance = load + v * (train.davis_b + v * air)
    resistance_w = 0.5 * train.davis_b * per_v + air
    net = effort - resistance
    if regime == TRACTION and net >= train.max_acceleration:
        return 2.0 * train.max_acceleration, 0.0, resistance_w
    if regime != TRACTION and net <= -train.max_deceleration:
        return -2.0 * train.max_deceleration, 0.0, resistance_w
    effort_w = 0.5 * slope * per_v
    return 2.0 * net, 2.0 * (effort_w - resistance_w), effort_w


@leaf
def saturated_back(train, regime, effort_price, length, load, air, price, floor, w1, p1):
    """Image of a point under full traction or full dynamic braking."""
    v1 = math.sqrt(w1)
    g, g_w, _ = _saturated_slope(train, regime, load, air, v1)
    middle_v = math.sqrt(max(w1 - 0.5 * length * g, floor))
    middle_w = 1.0 - 0.5 * length * g_w
    g, g_w, effort_w = _saturated_slope(train, regime, load, air, middle_v)
    w0 = w1 - length * g
    image_w = max(1.0 - length * g_w * middle_w, 1e-3)
    return w0, _costate_before(length, price, _LOST * floor, v1, w0, image_w, effort_price * effort_w * middle_w, p1)


@part
def _drive_region(train, length, load, air, price, bottom, w, p, last, x, y):
    """Images under full traction of the points up to ``last`` that lie above ``bottom`` and keep p ≤ −½.

    They are made from the last one down. Of those lost below ``bottom`` one remains, at ``bottom``: p is so low there
    that the regime is clear. Returns their number, and the speed after the cell of the last one.
    """
    first = last + 1
    edge = last
    switch = w[last]
    above_w = 0.0
    above_p = 0.0
    for i in range(last, -1, -1):
        w0, p0 = saturated_back(train, TRACTION, 1.0, length, load, air, price, bottom, w[i], p[i])
        if w0 < bottom:
            if first <= last:
                share = (bottom - w0) / (x[first] - w0)
                edge_w = w[i] + share * (w[first] - w[i])
                edge_p = p[i] + share * (p[first] - p[i])
                edge_w, edge_p = saturated_back(train, TRACTION, 1.0, length, load, air, price, bottom, edge_w, edge_p)
                if edge_w > _LOST * bottom and edge_p <= y[first]:
                    first -= 1
                    x[first] = bottom
                    y[first] = edge_p
            break
        if p0 > -0.5 and first > last:
            edge = i - 1
        elif i == edge < last:
            share = (-0.5 - p0) / (above_p - p0)
            switch = w[i] + share * (w[i + 1] - w[i])
            edge = i + 1
            x[edge] = w0 + share * (above_w - w0)
            y[edge] = -0.5
            first = i
        else:
            first = i
        x[i] = w0
        y[i] = p0
        above_w = w0
        above_p = p0
    for i in range(first, edge + 1):
        x[i - first] = x[i]
        y[i - first] = y[i]
    return max(edge + 1 - first, 0), switch


@kernel
def _coast_all(davis_b, length, load, air, price, floor, w, p, x, y):
    """Images (x, y) under coasting of all points (w, p): indices from 0, so that the loop becomes one of vectors."""
    for i in range(w.shape[0]):
        x[i], y[i] = coast_back(davis_b, length, load, air, price, floor, w[i], p[i])


@part
def _coast_region(davis_b, length, load, air, price, bottom, top, w, p, first, last, x, y, m):
    """Append the images under coasting of the points ``first`` .. ``last``.

    Next to standstill p varies as 1/v, which no straight line follows: gaps between neighbouring images are filled
    there, from the edge at ``bottom`` on, with points interpolated before the cell.
    """
    slow = _SLOW_SHARE * top
    image = 0.0
    lost = False
    i = first
    while i <= last:
        w0, p0 = coast_back(davis_b, length, load, air, price, bottom, w[i], p[i])
        if w0 < bottom:
            lost = True
        else:
            target = bottom if lost else _SPREAD * image
            while i > first and target < min(w0, slow) and m + last + 8 < x.shape[0]:
                share = (target - image) / (w0 - image)
                fill_w = w[i - 1] + share * (w[i] - w[i - 1])
                fill_p = p[i - 1] + share * (p[i] - p[i - 1])
                fill_w, fill_p = coast_back(davis_b, length, load, air, price, bottom, fill_w, fill_p)
                if fill_w > _LOST * bottom and fill_p <= p0:
                    x[m] = bottom if target == bottom else fill_w
                    y[m] = fill_p
                    m += 1
                target *= _SPREAD
            lost = False
            x[m] = w0
            y[m] = p0
            m += 1
        image = w0
        i += 1
        if w0 >= slow and not lost:
            break
    _coast_all(davis_b, length, load, air, price, bottom, w[i : last + 1], p[i : last + 1], x[m:], y[m:])
    return m + last + 1 - i


@part
def holding_w(davis_b, air, price):
    """Squared speed V² that is held for a price of time in units of that of work: price = V²·R'(V); may be infinite.

    Newton's rule from above, where the derivative rises.
    """
    v = math.inf
    if air > 0.0:
        v = (0.5 * price / air) ** (1.0 / 3.0) * (1.0 + 1e-12)
    if davis_b > 0.0:
        v = min(v, math.sqrt(price / davis_b))
    if davis_b > 0.0 and air > 0.0:
        for _ in range(20):
            step = (v * v * (davis_b + 2.0 * air * v) - price) / (v * (2.0 * davis_b + 6.0 * air * v))
            v -= step
            if step <= 1e-15 * v:
                break
    return v * v


@part
def _hold(held, level, first, m, x, y):
    """Make the speed that is held a point of the images, if it lies before the ``first`` one; their new number."""
    if not x[first - 1] < held < x[first] or y[first] < level:
        return m
    if y[first - 1] >= level:  # an edge, from which a run would switch to that speed only to hold it
        x[first - 1] = held
        return m
    for i in range(m, first, -1):
        x[i] = x[i - 1]
        y[i] = y[i - 1]
    x[first] = held
    y[first] = level
    return m + 1


@leaf
def _coast_on(davis_b, length, load, air, w0):
    """Squared speed after coasting through a cell, by the midpoint rule."""
    middle = max(w0 - length * (load + davis_b * math.sqrt(w0) + air * w0), 0.0)
    return max(w0 - 2.0 * length * (load + davis_b * math.sqrt(middle) + air * middle), 0.0)


@part
def dynamic_suffices(train, length, load, air, top, wall):
    """Whether the dynamic brake alone brakes along the wall from ``top`` on, within a rounding of its rows."""
    v0 = math.sqrt(top)
    v1 = math.sqrt(wall)
    work = 0.5 * (wall - top) + length * (load - train.davis_a_n + mean_resistance(train, air, v0, v1))
    return -work <= (1.0 + _ROUNDING) * length * mean_effort(train.braking, v0, v1)


@part
def wall_region(train, regime, returned, length, load, air, price, bottom, top, wall, x, y, m):
    """Append costates of runs that meet the wall within the cell, from ``top`` to ``wall``, and brake along it.

    They come to it by coasting, p = −r/2 there, where the dynamic brake alone follows it; else by that brake, p = 0.
    """
    pieces = min(max(math.ceil(_WALL_PIECES * (1.0 - wall / top)), 1), _MOST_WALL_PIECES)
    for i in range(pieces + 1):
        rest = 1.0 - i / pieces
        w1 = max(top + rest * (wall - top), LEAST_WALL * top)
        if regime == DYNAMIC:
            w0, p0 = saturated_back(train, DYNAMIC, returned, rest * length, load, air, price, bottom, w1, 0.0)
        else:
            w0, p0 = coast_back(train.davis_b, rest * length, load, air, price, bottom, w1, -0.5 * returned)
        x[m] = min(w0, top)
        y[m] = min(p0, 0.0)
        m += 1
    return m


@part
def _drop_below(level, x, y, first, m):
    """Drop the images from ``first`` on that lie below a level, but for an edge at the level; returns what is left.

    Where no image reaches the level, nothing is left.
    """
    i = first
    while i < m and y[i] < level:
        i += 1
    if i == m:
        return first
    if i == first:
        return m
    share = (level - y[i - 1]) / (y[i] - y[i - 1])
    x[i - 1] += share * (x[i] - x[i - 1])
    y[i - 1] = level
    dropped = i - 1 - first
    for j in range(first, m - dropped):
        x[j] = x[j + dropped]
        y[j] = y[j + dropped]
    return m - dropped


@part
def _brake_region(
    train, returned, length, load, air, price, held_w, bottom, top, w, p, first, last, x, y, start, m
):
    """Append images under full dynamic braking of the points ``first`` .. ``last``, of p ≥ −r/2.

    Of the images under coasting from ``start`` on those remain that keep p ≤ −r/2. Returns the number of images, and the
    speed after the cell of a run that brakes throughout, with p = −r/2 before it.
    """
    level = -0.5 * returned
    switch = w[first]
    while m > start + 1 and y[m - 2] > level:
        m -= 1
    if m > start + 1 and y[m - 1] > level > y[m - 2]:
        share = (level - y[m - 2]) / (y[m - 1] - y[m - 2])
        x[m - 1] = x[m - 2] + share * (x[m - 1] - x[m - 2])
        y[m - 1] = level
        switch = _coast_on(train.davis_b, length, load, air, x[m - 1])
    before = m
    for i in range(first, last + 1):
        w0, p0 = saturated_back(train, DYNAMIC, returned, length, load, air, price, bottom, w[i], p[i])
        if w0 >= bottom:
            x[m] = w0
            y[m] = p0
            m += 1
            if p0 >= level and m > before + 1 and y[m - 2] < level:
                share = (level - y[m - 2]) / (p0 - y[m - 2])
                switch = w[i - 1] + share * (w[i] - w[i - 1])
            if w0 > top:
                if m == before + 1:  # the envelope is held
                    x[before] = top
                    y[before] = level
                break
    if m == before:
        return m, switch
    last = x[m - 1]
    m = _drop_below(level, x, y, before, m)
    if m > before:
        return _hold(held_w, level, before, m, x, y), switch
    x[m] = last  # below the level up to the wall
    y[m] = level
    return m + 1, switch


@kernel
def transport(
    train, returned, length, load, air, price, held_w, held_brake_w, bottom, top, wall, w, p, n, drives, coasts, x, y
):
    """Images (x, y) of the polyline one cell back.

    Full traction keeps p ≤ −½ within the cell, coasting p ≥ −½ (and p ≤ −r/2, dynamic braking p ≥ −r/2): images that do
    not are dropped. Where p rises along the cell, as it does below the holding speed, runs between the two regimes
    change from one to the other within it; there, and where a speed is held, p is interpolated.

    Parameters
    ----------
    train : KernelTrain
        Per unit of inertia, as are ``load`` (resistance A and grade force) and ``air``.
    returned : float
        Energy that the dynamic brake returns per joule of its work.
    length, load, air, price : float
        The cell, and the multiplier.
    held_w, held_brake_w : float
        Squared speeds that are held by traction and by the dynamic brake (`holding_w`).
    bottom, top, wall : float
        Squared speeds: the slowest and fastest of the images, and the fastest after the cell.
    w, p : (size,) float64
        The polyline, of ``n`` points, the crossings of its levels among them.
    n, drives, coasts : int
        Points up to the crossing ``drives`` drive, from there up to ``coasts`` they coast, the others brake.
    x, y : (size,) float64, modified in place

    Returns
    -------
    m : int
        Number of images, in the order of the points, not necessarily monotone.
    a, b : float
        Squared speeds after the cell of runs with p = −½ before it and one regime throughout, and with p = −r/2.
    """
    davis_b = train.davis_b
    a = w[drives]
    b = w[coasts]
    m, switch = _drive_region(train, length, load, air, price, bottom, w, p, drives, x, y)
    while m > 1 and x[m - 2] > top:
        m -= 1
    if m > 0 and x[m - 1] > top:
        return m, a, b
    driven = m > 0
    if not driven:
        x[0] = bottom
        y[0] = min(holding_costate(davis_b, length, air, 1.0, price, bottom, a), -0.5)
        m = 1
    first = m
    m = _coast_region(davis_b, length, load, air, price, bottom, top, w, p, drives, coasts, x, y, m)
    if not driven and m > first and x[first] <= bottom:  # coasting alone covers everything
        x[0] = x[first]
        y[0] = y[first]
    if x[m - 1] < top:
        regime = COASTING
        if returned > 0.0:
            if not dynamic_suffices(train, length, load, air, top, wall):
                regime = DYNAMIC
            if regime == DYNAMIC or coasts < n - 1:
                m, b = _brake_region(
                    train, returned, length, load, air, price, held_brake_w, bottom, top, w, p, coasts, n - 1,
                    x, y, first, m,
                )  # fmt: skip
        if x[m - 1] < top:
            m = wall_region(train, regime, returned, length, load, air, price, bottom, top, wall, x, y, m)
    if m == first:
        return m, switch, b
    if y[first] >= -0.5:
        return _hold(held_w, -0.5, first, m, x, y), switch, b
    lowest = y[first]
    highest = y[m - 1]
    m = _drop_below(-0.5, x, y, first, m)
    if m > first:
        switch = min(_coast_on(davis_b, length, load, air, x[first]), wall)
        return _hold(held_w, -0.5, first, m, x, y), switch, b
    # Below −½ up to the wall: only from beyond it would a run coast throughout.
    switch = wall
    if a < wall and highest > lowest:
        switch = min(a + (wall - a) * (-0.5 - lowest) / (highest - lowest), _BEYOND * wall)
    x[m] = coast_back(davis_b, length, load, air, price, bottom, switch, -0.5)[0]
    y[m] = -0.5
    return m + 1, switch, b
