"""Where driving meets braking inside a uniform cell.

Driving forwards from one end of the cell (full traction or coasting, held at the limit) and braking backwards from
the other end give two curves w(x); a run follows the first to their meeting point, then the second.
"""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.physics.motion import march, net_force

#: Rows shorter than this share of their cell are rounding errors.
_SLIVER = 1e-9
#: ... and so are rows as short as this share in which v² changes by no more than it: at meeting points v² is known to
#: 1e-11 of the limit, which would be an effort beyond its limit there.
_SHORT = 1e-6
#: Difference in w, as a share of the limit, within which a run is on the braking curve.
_ON_CURVE = 1e-8


@kernel
def _at_limit(train, regime, sign, grade, air, w, limit):
    """Whether a train at the limit stays there: driving forwards (sign 1), or backwards (−1), it would pass it."""
    if w < limit:
        return False
    v = math.sqrt(w)
    return sign * net_force(train, regime, grade, air, v, v) >= 0.0


@kernel
def driven_w(train, regime, grade, air, w0, limit, x, xs, ws):
    """Squared speed at x of driving from w0 under a regime, held at the limit; ``xs``, ``ws`` are scratch."""
    if _at_limit(train, regime, 1.0, grade, air, w0, limit):
        return limit
    return min(march(train, regime, 1.0, x, grade, air, w0, limit, xs, ws, 0)[1], limit)


@kernel
def braked_w(train, brakes, grade, air, w1, limit, x, xs, ws):
    """Squared speed at x before the cell's end from which braking leads to w1, held at the limit."""
    if _at_limit(train, brakes, -1.0, grade, air, w1, limit):
        return limit
    return min(march(train, brakes, -1.0, x, grade, air, w1, limit, xs, ws, 0)[1], limit)


@part
def _meeting_point(train, regime, brakes, length, grade, air, limit, w0, w1, xs, ws):
    """Position in the cell where driving from w0 meets braking to w1 (regula falsi, Illinois variant).

    It is never so close to an end of the cell that a row would be lost in rounding.
    """
    hi = length
    # Where braking is held at the limit driving cannot be above it: they meet after that stretch.
    braked_m, braked = march(train, brakes, -1.0, length, grade, air, w1, limit, xs, ws, 0)[:2]
    lo = length - braked_m if braked >= limit else 0.0
    f_lo = driven_w(train, regime, grade, air, w0, limit, lo, xs, ws) - min(braked, limit)
    f_hi = driven_w(train, regime, grade, air, w0, limit, length, xs, ws) - w1
    if f_hi == 0.0 and w0 < limit:
        # The limit itself is reached, but on a steep descent the brakes cannot hold it to the end.
        hi = march(train, regime, 1.0, length, grade, air, w0, limit, xs, ws, 0)[0]
        f_hi = limit - braked_w(train, brakes, grade, air, w1, limit, length - hi, xs, ws)
    if f_lo >= -_ON_CURVE * limit:
        return lo if lo >= _SLIVER * length else 0.0
    if f_hi <= 0.0:
        return length
    side = 0
    x = 0.0
    for _ in range(60):
        x = (lo * f_hi - hi * f_lo) / (f_hi - f_lo)
        if not lo < x < hi:
            x = 0.5 * (lo + hi)
        driven = driven_w(train, regime, grade, air, w0, limit, x, xs, ws)
        f = driven - braked_w(train, brakes, grade, air, w1, limit, length - x, xs, ws)
        if abs(f) <= 1e-11 * limit or hi - lo <= 1e-12 * length:
            break
        if f < 0.0:
            lo = x
            f_lo = f
            if side == -1:
                f_hi *= 0.5
            side = -1
        else:
            hi = x
            f_hi = f
            if side == 1:
                f_lo *= 0.5
            side = 1
    if x < _SLIVER * length:
        return 0.0
    return x if x < (1.0 - _SLIVER) * length else length


@part
def emit_driven(train, regime, start, x, grade, air, w0, limit, xs, ws, n):
    """Append the rows of driving over x metres from w0; positions count from ``start``."""
    if x <= 0.0:
        return n
    reached = 0.0
    if not _at_limit(train, regime, 1.0, grade, air, w0, limit):
        first = n
        reached, _, n = march(train, regime, 1.0, x, grade, air, w0, limit, xs, ws, n)
        for i in range(first, n):
            xs[i] += start
    if reached < x:
        xs[n] = start + x
        ws[n] = limit
        n += 1
    return n


@part
def _emit_braked(train, brakes, end, x, grade, air, w1, limit, bx, bw, xs, ws, n):
    """Append the rows of braking over the last x metres to w1 at position ``end``; ``bx``, ``bw`` are scratch."""
    reached = 0.0
    m = 0
    if not _at_limit(train, brakes, -1.0, grade, air, w1, limit):
        reached, _, m = march(train, brakes, -1.0, x, grade, air, w1, limit, bx, bw, 0)
    if reached >= x:
        m -= 1  # its last row ends where the driven rows ended
    for i in range(m - 1, -1, -1):
        xs[n] = end - bx[i]
        ws[n] = bw[i]
        n += 1
    xs[n] = end
    ws[n] = w1
    return n + 1


@kernel
def drive_then_brake(train, regime, brakes, start, end, length, grade, air, limit, w0, w1, bx, bw, xs, ws, n):
    """Append the rows of a cell: driving from w0, then braking as late as possible to end at w1.

    Parameters
    ----------
    train : KernelTrain
    regime : int
        TRACTION, COASTING or DYNAMIC, held at the limit where it would pass it.
    brakes : int
        BRAKING or DYNAMIC.
    start, end, length, grade, air, limit : float
        The cell: positions in m, grade force in N, coefficient of v² in N/(m/s)², squared speed limit.
    w0, w1 : float
        Squared speeds at its ends.
    bx, bw : (size,) float64
        Scratch.
    xs, ws : (size,) float64, modified in place
        Rows are appended from index ``n`` on: positions, squared speeds.
    n : int

    Returns
    -------
    n : int
        New number of rows; the last one is at ``end``.
    """
    x = _meeting_point(train, regime, brakes, length, grade, air, limit, w0, w1, bx, bw)
    n = emit_driven(train, regime, start, x, grade, air, w0, limit, xs, ws, n)
    if x < length:
        return _emit_braked(train, brakes, end, length - x, grade, air, w1, limit, bx, bw, xs, ws, n)
    xs[n - 1] = end
    ws[n - 1] = w1
    return n


@leaf
def _is_sliver(length, d, w0, w1):
    """Whether a row of length d between two squared speeds is a rounding error in a cell of the given length."""
    return d <= _SLIVER * length or (d <= _SHORT * length and abs(w1 - w0) <= _SHORT * max(w0, w1))


@kernel
def drop_slivers(xs, ws, first, n, length):
    """Drop slivers from the rows ``first`` .. ``n`` of a cell of the given length; returns the new number of rows.

    They come from rounding at meeting points; the end of the cell, the last row, stays.
    """
    kept = first
    for i in range(first, n):
        sliver = _is_sliver(length, xs[i] - xs[kept - 1], ws[kept - 1], ws[i])
        if sliver and i < n - 1:
            continue
        if sliver and kept > first:
            kept -= 1
        xs[kept] = xs[i]
        ws[kept] = ws[i]
        kept += 1
    return kept
