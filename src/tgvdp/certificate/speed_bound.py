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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.certificate.efforts import Load, largest_effort, load_at, load_in, merge_comfort, piece_at, train_in

#: Change of speed in a row; and the speed of the first one, relative to the largest limit.
_STEP = 5e-4
_FIRST = 1e-3
#: W lies above its exact value by this share, against rounding.
_SPARE = 1e-10


@kernel
def _gain(pieces, n, forward, load, slow_v, fast_v):
    """Upper bound of ½·dw/dx (backwards: −½·dw/dx) over all speeds from slow_v to fast_v."""
    if forward:
        return largest_effort(pieces, n, slow_v, fast_v) - load_at(load, slow_v)
    return largest_effort(pieces, n, slow_v, fast_v) + load_at(load, fast_v)


@leaf
def _mean_gain(pieces, i, forward, load, u, v):
    """Mean over w of ½·dw/dx (backwards: −½·dw/dx) from u to v, on piece ``i``."""
    both = u + v
    squares = u * u + v * v
    first = 2.0 / 3.0 * (squares + u * v) / both
    third = 0.4 * (squares * squares + u * v * (squares - u * v)) / both
    effort = pieces[i, 1] * 2.0 / both + pieces[i, 2] + pieces[i, 3] * first
    effort += pieces[i, 4] * 0.5 * squares + pieces[i, 5] * third
    mean = load.r0 + load.r1 * first + load.r2 * 0.5 * squares
    return effort - mean if forward else effort + mean


@kernel
def _next_row(pieces, n, forward, load, v, top_v, first_v):
    """Speed at the end of the row from v, the largest slope ½·dw/dx on the way there, and the mean one.

    The same speed where it may stay.
    """
    fast_v = max(v * (1.0 + _STEP), first_v)
    here = piece_at(pieces, n, v)
    if here + 1 < n:
        fast_v = min(fast_v, pieces[here + 1, 0])
    fast_v = min(fast_v, top_v)
    if v < top_v:
        gain = _gain(pieces, n, forward, load, v, fast_v)
        if gain > 0.0:
            mean = _mean_gain(pieces, here, forward, load, v, fast_v)
            return fast_v, gain, mean if 0.0 < mean < gain else gain
    slow_v = v * (1.0 - _STEP)
    if v <= first_v:
        return v, 0.0, 0.0
    gain = _gain(pieces, n, forward, load, slow_v, v)
    if gain < 0.0:
        return slow_v, gain, gain
    return v, 0.0, 0.0


@kernel
def speed_bound(train, forward, cells, end_w, pieces, rows):
    """Rows of the outer bound over the cells of the line.

    Parameters
    ----------
    train : KernelTrain
    forward : bool
        From the origin on, by traction; else from the destination back, by braking.
    cells : Cells
    end_w : float
        Squared speed at the origin (destination), m²/s².
    pieces : (3n, 6) float64
        Scratch.
    rows : Rows, modified in place
        Positions from the origin (from the destination), increasing, and W.

    Returns
    -------
    int
        Number of rows; −1 when there are too many.
    """
    count = cells.length_m.shape[0]
    mass = train.inertia_kg
    xs, ws = rows
    limit = cells.limit_w
    top = 0.0
    for k in range(count):
        top = max(top, limit[k])
    top = math.sqrt(top)
    start = 0.0
    w = end_w
    n = 0
    for j in range(count):
        k = j if forward else count - 1 - j
        load = load_in(train, cells, k)
        here = train_in(train, cells, k)
        length = cells.length_m[k]
        if forward:
            comfort = train.max_acceleration
            m = merge_comfort(here.traction, 0.0, mass, comfort, train.rates[:0], load, top, pieces)
        else:
            comfort = train.max_deceleration
            helps = Load(-load.r0, -load.r1, -load.r2)
            m = merge_comfort(here.braking, train.friction_n, mass, comfort, train.rates, helps, top, pieces)
        w = min(w, limit[k])
        x = 0.0
        above = 0.0  # how far a run may be above a line through the ends of the row before
        while True:
            if n >= xs.shape[0]:
                return -1
            xs[n] = start + x
            ws[n] = w * (1.0 + _SPARE) + above
            n += 1
            if x >= length:
                break
            v = math.sqrt(w)
            next_v, gain, mean = _next_row(pieces, m, forward, load, v, math.sqrt(limit[k]), _FIRST * top)
            step = length - x
            if next_v != v:
                step = min(step, (next_v * next_v - w) / (2.0 * mean))
            last = step >= length - x
            before = w
            w = max(w + 2.0 * gain * step, 0.0) if last else next_v * next_v
            w = min(w, max(before, next_v * next_v))
            w = min(w, limit[k])
            rise = max(w - before, 0.0)
            above = rise * (1.0 - rise / (2.0 * gain * step)) if rise > 0.0 else 0.0
            ws[n - 1] = max(ws[n - 1], before * (1.0 + _SPARE) + above)
            x = length if last else x + step
        start += length
    return n


class Caps(NamedTuple):
    """Squared speeds that no run passes, m²/s²: in each cell, (K,), and at the ends of the cells, (K + 1,).

    ``rise`` (K, 2) are those at the two ends of each cell between which no run passes a linear one.
    """

    cell: NDArray[np.float64]
    node: NDArray[np.float64]
    rise: NDArray[np.float64]


@kernel
def _lower_to(distance, node, rows, forward, caps):
    """Lower the caps of cells and of their ends to one speed bound; in place."""
    xs, ws = rows
    cap, node_cap, _ = caps
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
def _fill_rise(node, rows, rise):
    """Fill ``rise`` of `lower_caps`."""
    xs, ws = rows
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
def lower_caps(distance, node, ahead, back, caps):
    """Lower caps of the squared speed to the speed bounds.

    Parameters
    ----------
    distance : float
        Length of the trip, m.
    node : (K + 1,) float64
        Ends of the cells, m from the origin.
    ahead, back : Rows
        The speed bounds from the origin and from the destination.
    caps : Caps, modified in place
        ``rise`` is that of the bound from the origin.
    """
    _lower_to(distance, node, ahead, True, caps)
    _lower_to(distance, node, back, False, caps)
    _fill_rise(node, ahead, caps.rise)
