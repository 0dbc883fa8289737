"""Characteristics of the costate: points (w, p) carried back over one cell along the flow of their regime.

Everything here is per unit of inertia: the train's forces are accelerations. A point moves by the explicit midpoint
rule w0 = φ(w1), and its costate by the derivative of the cost of the arc along that map (docs/front-method.md),

    p0 = (∂E/∂w1 + λ·∂T/∂w1 + p1) / φ'(w1),     ∂T/∂w1 = −d/(v0+v1)²·(φ'/v0 + 1/v1).
"""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.physics.forces import effort_and_slope
from tgvdp.physics.motion import DYNAMIC, TRACTION

#: Neighbouring images are no further apart than this factor of w, below this share of the envelope.
_SPREAD = 2.0
_SLOW_SHARE = 0.1
#: An image below this share of the floor has no costate: it is taken to be there.
_LOST = 0.25


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
def braking_costate(train, length, returned, price, w0, w1):
    """Costate at w0 of braking with all brakes towards a fixed w1: the dynamic brake's part of the work is paid for."""
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    s = v0 + v1
    paid = 0.0
    if returned > 0.0:
        v = math.sqrt(0.5 * (w0 + w1))
        paid = 0.25 * effort_and_slope(train.braking, v)[1] / v
    return -length * (returned * paid + price / (s * s * v0))


@leaf
def _costate_before(length, price, lost, v1, w0, image_w, work_w, p1):
    """Costate at the image w0 of v1², whose derivative is ``image_w``; ``work_w`` is that of the effort's work."""
    v0 = math.sqrt(w0 if w0 > lost else lost)
    s = v0 + v1
    span = s * s * v0 * v1
    return ((length * work_w + p1) * span - price * length * (image_w * v1 + v0)) / (span * image_w)


@leaf
def _coast_back(davis_b, length, load, air, price, floor, w1, p1):
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
def _saturated_back(train, regime, effort_price, length, load, air, price, floor, w1, p1):
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
    """Images under full traction of the points up to ``last`` that lie above ``bottom``.

    They are made from the last one down. Of those lost below ``bottom`` one remains, at ``bottom``: p is so low there
    that the regime is clear.
    """
    first = last + 1
    for i in range(last, -1, -1):
        w0, p0 = _saturated_back(train, TRACTION, 1.0, length, load, air, price, bottom, w[i], p[i])
        if w0 < bottom:
            if first <= last:
                share = (bottom - w0) / (x[first] - w0)
                edge_w = w[i] + share * (w[first] - w[i])
                edge_p = p[i] + share * (p[first] - p[i])
                edge_w, edge_p = _saturated_back(train, TRACTION, 1.0, length, load, air, price, bottom, edge_w, edge_p)
                if edge_w > _LOST * bottom and edge_p <= y[first]:
                    first -= 1
                    x[first] = bottom
                    y[first] = edge_p
            break
        first = i
        x[i] = w0
        y[i] = p0
    for i in range(first, last + 1):
        x[i - first] = x[i]
        y[i - first] = y[i]
    return last + 1 - first


@kernel
def _coast_all(davis_b, length, load, air, price, floor, w, p, x, y):
    """Images (x, y) under coasting of all points (w, p): indices from 0, so that the loop becomes one of vectors."""
    for i in range(w.shape[0]):
        x[i], y[i] = _coast_back(davis_b, length, load, air, price, floor, w[i], p[i])


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
        w0, p0 = _coast_back(davis_b, length, load, air, price, bottom, w[i], p[i])
        if w0 < bottom:
            lost = True
        else:
            target = bottom if lost else _SPREAD * image
            while i > first and target < min(w0, slow) and m + last + 8 < x.shape[0]:
                share = (target - image) / (w0 - image)
                fill_w = w[i - 1] + share * (w[i] - w[i - 1])
                fill_p = p[i - 1] + share * (p[i] - p[i - 1])
                fill_w, fill_p = _coast_back(davis_b, length, load, air, price, bottom, fill_w, fill_p)
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
def _hold(davis_b, length, air, effort_price, price, top, speed, below, above, m, x, y):
    """Between the images ``below`` and ``above`` of a crossing, insert holding if its speed lies there."""
    if x[below] < speed and (above == m or speed < x[above]):
        x[below + 1] = min(speed, top)
        y[below + 1] = holding_costate(davis_b, length, air, effort_price, price, x[below + 1], speed)
    else:
        x[below + 1] = x[below]
        y[below + 1] = y[below]


@part
def _brake_region(train, length, load, air, returned, price, bottom, top, w, p, first, last, x, y, m):
    """Append holding by partial regeneration, and the images under full dynamic braking of ``first`` .. ``last``."""
    hold = m
    m += 1
    for i in range(first, last + 1):
        w0, p0 = _saturated_back(train, DYNAMIC, returned, length, load, air, price, bottom, w[i], p[i])
        if w0 >= bottom:
            x[m] = w0
            y[m] = p0
            m += 1
            if w0 > top:
                break
    _hold(train.davis_b, length, air, returned, price, top, w[first], hold - 1, hold + 1, m, x, y)
    return m


@kernel
def transport(train, returned, length, load, air, price, bottom, top, wall, w, p, n, drives, coasts, x, y):
    """Images (x, y) of the polyline one cell back.

    Parameters
    ----------
    train : KernelTrain
        Per unit of inertia, as are ``load`` (resistance A and grade force) and ``air``.
    returned : float
        Energy that the dynamic brake returns per joule of its work.
    length, load, air, price : float
        The cell, and the multiplier.
    bottom, top, wall : float
        Squared speeds: the slowest and fastest of the images, and the fastest before the cell.
    w, p : (size,) float64
        The polyline, of ``n`` points, the crossings of its levels among them.
    n, drives, coasts : int
        Points up to the crossing ``drives`` drive, from there up to ``coasts`` they coast, the others brake. Between
        the two images of a crossing its speed is held.
    x, y : (size,) float64, modified in place

    Returns
    -------
    int
        Number of images, in the order of the points, not necessarily monotone.
    """
    b = train.davis_b
    m = _drive_region(train, length, load, air, price, bottom, w, p, drives, x, y)
    while m > 1 and x[m - 2] > top:
        m -= 1
    if m > 0 and x[m - 1] > top:
        return m
    below = m
    if m == 0:
        x[0] = bottom
        y[0] = holding_costate(b, length, air, 1.0, price, bottom, w[drives])
        m = 1
    m += 1  # room for holding, if it lies between the images
    after = _coast_region(b, length, load, air, price, bottom, top, w, p, drives, coasts, x, y, m)
    if after > m and below == 0 and x[m] <= bottom:  # coasting alone covers everything
        x[0] = x[m]
        y[0] = y[m]
    _hold(b, length, air, 1.0, price, top, w[drives], m - 2, m, after, x, y)
    m = after
    if returned > 0.0 and x[m - 1] < top:
        m = _brake_region(train, length, load, air, returned, price, bottom, top, w, p, coasts, n - 1, x, y, m)
    if x[m - 1] < top:  # braking to the wall
        x[m] = x[m - 1]
        y[m] = braking_costate(train, length, returned, price, x[m], wall)
        x[m + 1] = top
        y[m + 1] = braking_costate(train, length, returned, price, top, wall)
        m += 2
    return m
