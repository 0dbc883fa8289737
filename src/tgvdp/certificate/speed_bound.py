"""An outer bound of the fastest-run curve: a speed that no run passes, whatever it does.

A curve W(x) that starts at or above every run and rises at least as fast as the largest effort lets any train at that
speed gain w = v² is never crossed from below; the same holds backwards from the end with the largest braking effort.
Between two speeds of a piece of the effort curve the gain G(w) of w per metre is smooth, and the distance from one to
the other is, by the inequality of Cauchy and Schwarz, at least

    ∫ dw/G ≥ (Δw)²/∫ G dw,

whose right side is in closed form, also where G has zeros, which no run passes. Its relative error is the variance of
G between the two speeds, relative to its square. Where W falls (the load exceeds the effort), or a cell of the line
ends within a row, the row takes the largest effort and the least load of all its speeds instead. Between its ends W is
linear, raised by how far a run might be above it there.
"""

import math

from tgvdp._jit import kernel, leaf
from tgvdp.certificate.efforts import largest_effort, merge_comfort, piece_at

#: Change of speed in a row; and the speed of the first one, relative to the largest limit.
_STEP = 5e-4
_FIRST = 1e-3
#: W lies above its exact value by this share, against rounding.
_SPARE = 1e-10


@kernel
def _gain(pieces, n, forward, r0, r1, r2, slow_v, fast_v):
    """Upper bound of ½·dw/dx (backwards: −½·dw/dx) over all speeds from slow_v to fast_v."""
    if forward:
        return largest_effort(pieces, n, slow_v, fast_v) - (r0 + slow_v * (r1 + slow_v * r2))
    return largest_effort(pieces, n, slow_v, fast_v) + (r0 + fast_v * (r1 + fast_v * r2))


@leaf
def _mean_gain(pieces, i, forward, r0, r1, r2, u, v):
    """Mean over w of ½·dw/dx (backwards: −½·dw/dx) from u to v, on piece ``i``."""
    both = u + v
    squares = u * u + v * v
    first = 2.0 / 3.0 * (squares + u * v) / both
    third = 0.4 * (squares * squares + u * v * (squares - u * v)) / both
    effort = pieces[i, 1] * 2.0 / both + pieces[i, 2] + pieces[i, 3] * first
    effort += pieces[i, 4] * 0.5 * squares + pieces[i, 5] * third
    load = r0 + r1 * first + r2 * 0.5 * squares
    return effort - load if forward else effort + load


@kernel
def _next_row(pieces, n, forward, r0, r1, r2, v, top_v, first_v):
    """Speed at the end of the row from v, the largest slope ½·dw/dx on the way there, and the mean one.

    The same speed where it may stay.
    """
    fast_v = max(v * (1.0 + _STEP), first_v)
    here = piece_at(pieces, n, v)
    if here + 1 < n:
        fast_v = min(fast_v, pieces[here + 1, 0])
    fast_v = min(fast_v, top_v)
    if v < top_v:
        gain = _gain(pieces, n, forward, r0, r1, r2, v, fast_v)
        if gain > 0.0:
            mean = _mean_gain(pieces, here, forward, r0, r1, r2, v, fast_v)
            return fast_v, gain, mean if 0.0 < mean < gain else gain
    slow_v = v * (1.0 - _STEP)
    if v <= first_v:
        return v, 0.0, 0.0
    gain = _gain(pieces, n, forward, r0, r1, r2, slow_v, v)
    if gain < 0.0:
        return slow_v, gain, gain
    return v, 0.0, 0.0


@kernel
def ceiling(train, forward, length, grade, air, limit, end_w, pieces, xs, ws):
    """Rows of the outer bound over the cells of the line.

    Parameters
    ----------
    train : KernelTrain
    forward : bool
        From the origin on, by traction; else from the destination back, by braking.
    length, grade, air, limit : (K,) float64
        Cells of the line, as in `tgvdp.line.cells.Cells`.
    end_w : float
        Squared speed at the origin (destination), m²/s².
    pieces : (2n, 6) float64
        Scratch.
    xs, ws : (size,) float64, modified in place
        Positions from the origin (from the destination), increasing, and W.

    Returns
    -------
    int
        Number of rows; −1 when there are too many.
    """
    count = length.shape[0]
    mass = train.inertia_kg
    top = 0.0
    for k in range(count):
        top = max(top, limit[k])
    top = math.sqrt(top)
    start = 0.0
    w = end_w
    n = 0
    for j in range(count):
        k = j if forward else count - 1 - j
        r0 = (train.davis_a_n + grade[k]) / mass
        r1 = train.davis_b / mass
        r2 = air[k] / mass
        if forward:
            comfort = train.max_acceleration
            m = merge_comfort(train.traction, 0.0, mass, comfort, train.rates[:0], r0, r1, r2, top, pieces)
        else:
            comfort = train.max_deceleration
            m = merge_comfort(train.braking, train.friction_n, mass, comfort, train.rates, -r0, -r1, -r2, top, pieces)
        w = min(w, limit[k])
        x = 0.0
        above = 0.0  # how far a run may be above a line through the ends of the row before
        while True:
            if n >= xs.shape[0]:
                return -1
            xs[n] = start + x
            ws[n] = w * (1.0 + _SPARE) + above
            n += 1
            if x >= length[k]:
                break
            v = math.sqrt(w)
            next_v, gain, mean = _next_row(pieces, m, forward, r0, r1, r2, v, math.sqrt(limit[k]), _FIRST * top)
            step = length[k] - x
            if next_v != v:
                step = min(step, (next_v * next_v - w) / (2.0 * mean))
            last = step >= length[k] - x
            before = w
            w = max(w + 2.0 * gain * step, 0.0) if last else next_v * next_v
            w = min(w, max(before, next_v * next_v))
            w = min(w, limit[k])
            rise = max(w - before, 0.0)
            above = rise * (1.0 - rise / (2.0 * gain * step)) if rise > 0.0 else 0.0
            ws[n - 1] = max(ws[n - 1], before * (1.0 + _SPARE) + above)
            x = length[k] if last else x + step
        start += length[k]
    return n


@kernel
def _lower_to(distance, node, xs, ws, forward, cap, node_cap):
    """Lower the caps of cells and of their ends to one ceiling; in place."""
    n = xs.shape[0]
    count = cap.shape[0]
    i = 0
    before = ws[0]
    for j in range(count + 1):
        k = j if forward else count - j
        x = node[k] if forward else distance - node[k]
        most = -math.inf
        while i + 1 < n and xs[i + 1] <= x:
            i += 1
            most = max(most, ws[i])
        here = ws[i]
        if i + 1 < n and xs[i + 1] > xs[i]:
            here += (ws[i + 1] - ws[i]) * max(0.0, x - xs[i]) / (xs[i + 1] - xs[i])
        if j > 0:
            cell = k - 1 if forward else k
            cap[cell] = min(cap[cell], max(most, here, before))
        node_cap[k] = min(node_cap[k], here)
        before = here


@kernel
def _fill_rise(node, xs, ws, rise):
    """Fill ``rise`` of `lower_caps`."""
    n = xs.shape[0]
    i = 0
    before = ws[0]
    for k in range(rise.shape[0]):
        first = i
        while i + 1 < n and xs[i + 1] <= node[k + 1]:
            i += 1
        here = ws[i]
        if i + 1 < n and xs[i + 1] > xs[i]:
            here += (ws[i + 1] - ws[i]) * max(0.0, node[k + 1] - xs[i]) / (xs[i + 1] - xs[i])
        slope = (here - before) / (node[k + 1] - node[k])
        above = 0.0
        for j in range(first + 1, i + 1):
            above = max(above, ws[j] - before - slope * (xs[j] - node[k]))
        rise[k, 0] = before + above
        rise[k, 1] = here + above
        before = here


@kernel
def lower_caps(distance, node, ahead_x, ahead_w, back_x, back_w, cap, node_cap, rise):
    """Lower caps of the squared speed to the ceilings.

    Parameters
    ----------
    distance : float
        Length of the trip, m.
    node : (K + 1,) float64
        Ends of the cells, m from the origin.
    ahead_x, ahead_w, back_x, back_w : (n,), (m,) float64
        Rows of the ceilings from the origin and from the destination (`ceiling`).
    cap, node_cap : (K,), (K + 1,) float64, modified in place
        Largest squared speed anywhere in each cell, and at the ends of the cells, m²/s².
    rise : (K, 2) float64, modified in place
        Squared speeds at the two ends of each cell between which a linear one is at or above the ceiling from the
        origin, m²/s².
    """
    _lower_to(distance, node, ahead_x, ahead_w, True, cap, node_cap)
    _lower_to(distance, node, back_x, back_w, False, cap, node_cap)
    _fill_rise(node, ahead_x, ahead_w, rise)
