"""Where driving meets braking inside a uniform cell.

Driving forwards from one end of the cell (full traction or coasting, held at the limit) and braking backwards from
the other end give two curves w(x); a run follows the first to their meeting point, then the second.
"""

import math
from typing import NamedTuple

from tgvdp._jit import kernel, leaf, part
from tgvdp.line.walk import count_below
from tgvdp.physics.cell import Rows, append
from tgvdp.physics.march import march
from tgvdp.physics.motion import land, net_force_at
from tgvdp.physics.roots import Bracket, narrowed, secant

#: Rows shorter than this share of their cell are rounding errors.
_SLIVER = 1e-9
#: ... and so are rows as short as this share in which v² changes by no more than it: at meeting points v² is known to
#: 1e-11 of the limit, which would be an effort beyond its limit there.
_SHORT = 1e-6
#: A longer row is one, too, whose speeds are nearer to each other than some jump may be to them (`effort_jumps`).
_LESS_SHORT, _SAME_W = 1e-5, 1e-7
#: Difference in w, as a share of the limit, within which a run is on the braking curve.
_ON_CURVE = 1e-8


class Curve(NamedTuple):
    """Braking backwards through a cell, from the speed at its end.

    Attributes
    ----------
    held : bool
        Whether it is at the limit from there on.
    limited_m : float
        How far before the end it comes to the limit, m; the cell's length where it never does.
    start_w : float
        Squared speed at the start of the cell, held at the limit, m²/s².
    n : int
        Rows, the first ones of some room: ends of rows from the end of the cell on, m; −1 without room for them.
    """

    held: bool
    limited_m: float
    start_w: float
    n: int


@kernel
def _at_limit(train, regime, sign, cell, w):
    """Whether a train at the limit stays there: driving forwards (sign 1), or backwards (−1), it would pass it."""
    if w < cell.limit_w:
        return False
    v = math.sqrt(w)
    return sign * net_force_at(train, regime, cell, v) >= 0.0


@kernel
def driven_w(train, regime, cell, w0, x, scratch):
    """Squared speed at x of driving from w0 under a regime, held at the limit."""
    if _at_limit(train, regime, 1.0, cell, w0):
        return cell.limit_w
    return min(march(train, regime, 1.0, cell, x, w0, cell.limit_w, scratch, 0)[1], cell.limit_w)


@part
def braking_curve(train, brakes, cell, w1, rows):
    """The curve of braking to w1 at the end of a cell; its rows are the first ones of ``rows``."""
    limit = cell.limit_w
    reached_m, start_w, n = march(train, brakes, -1.0, cell, cell.length_m, w1, limit, rows, 0)
    if _at_limit(train, brakes, -1.0, cell, w1):
        return Curve(True, reached_m, limit, n)
    return Curve(False, reached_m if start_w >= limit else cell.length_m, min(start_w, limit), n)


@kernel
def braked_w(train, brakes, cell, w1, x, scratch):
    """Squared speed at x before the cell's end from which braking leads to w1, held at the limit."""
    if _at_limit(train, brakes, -1.0, cell, w1):
        return cell.limit_w
    return min(march(train, brakes, -1.0, cell, x, w1, cell.limit_w, scratch, 0)[1], cell.limit_w)


@part
def braked_along(train, brakes, cell, w1, x, curve, rows):
    """`braked_w` by the rows of a curve through the whole cell.

    They do not depend on where braking begins, but the last one, which is shorter.
    """
    if curve.held:
        return cell.limit_w
    i = count_below(rows.x, curve.n, x)
    if i >= curve.n:  # it ended there; without a row nothing counts
        return min(rows.w[max(curve.n - 1, 0)], cell.limit_w)
    from_x = 0.0
    from_w = w1
    if i > 0:
        from_x = rows.x[i - 1]
        from_w = rows.w[i - 1]
    landed = land(train, brakes, -1.0, cell, x - from_x, from_w)
    return min(min(landed, rows.w[i]) if rows.w[i] > from_w else max(landed, rows.w[i]), cell.limit_w)


@part
def _meeting_point(train, regime, brakes, cell, w0, w1, curve, scratch):
    """Position in the cell where driving from w0 meets the curve of braking to w1 (regula falsi, Illinois variant).

    It is never so close to an end of the cell that a row would be lost in rounding. The rows of the curve are the first
    ones of ``scratch``.
    """
    length = cell.length_m
    limit = cell.limit_w
    hi = length
    n = max(curve.n, 0)  # without room for its rows nothing counts
    free = Rows(scratch.x[n:], scratch.w[n:])
    # Where braking is held at the limit driving cannot be above it: they meet after that stretch.
    lo = length - curve.limited_m
    f_lo = driven_w(train, regime, cell, w0, lo, free) - curve.start_w
    f_hi = driven_w(train, regime, cell, w0, length, free) - w1
    if f_hi == 0.0 and w0 < limit:
        # The limit itself is reached, but on a steep descent the brakes cannot hold it to the end.
        hi = march(train, regime, 1.0, cell, length, w0, limit, free, 0)[0]
        f_hi = limit - braked_along(train, brakes, cell, w1, length - hi, curve, scratch)
    if f_lo >= -_ON_CURVE * limit:
        return lo if lo >= _SLIVER * length else 0.0
    if f_hi <= 0.0:
        return length
    bracket = Bracket(lo, hi, f_lo, f_hi, 0)
    x = 0.0
    for _ in range(60):
        x = secant(bracket)
        if not bracket.lo < x < bracket.hi:
            x = 0.5 * (bracket.lo + bracket.hi)
        braked = braked_along(train, brakes, cell, w1, length - x, curve, scratch)
        f = driven_w(train, regime, cell, w0, x, free) - braked
        if abs(f) <= 1e-11 * limit or bracket.hi - bracket.lo <= 1e-12 * length:
            break
        bracket = narrowed(bracket, x, f)
    if x < _SLIVER * length:
        return 0.0
    return x if x < (1.0 - _SLIVER) * length else length


@part
def emit_driven(train, regime, cell, x, w0, rows, n):
    """Append the rows of driving over the first x metres of a cell from w0; −1 where there is no room for them."""
    if x <= 0.0:
        return n
    reached = 0.0
    if not _at_limit(train, regime, 1.0, cell, w0):
        first = n
        reached, _, n = march(train, regime, 1.0, cell, x, w0, cell.limit_w, rows, n)
        for i in range(first, n):
            rows.x[i] += cell.start_m
    if n < 0 or reached >= x:
        return n
    return append(cell.start_m + x, cell.limit_w, rows, n)


@part
def _emit_braked(cell, x, w1, curve, scratch, rows, n):
    """Append the rows of a curve of braking over the last x metres of a cell to w1; −1 where there is no room for them.

    The one that begins where the driven rows end comes with its end alone.
    """
    m = 0 if curve.held else count_below(scratch.x, curve.n, x * (1.0 - _SLIVER))
    if n < 0 or curve.n < 0 or n + m >= rows.x.shape[0]:
        return -1
    for i in range(m - 1, -1, -1):
        rows.x[n] = cell.end_m - scratch.x[i]
        rows.w[n] = scratch.w[i]
        n += 1
    rows.x[n] = cell.end_m
    rows.w[n] = w1
    return n + 1


@kernel
def drive_then_brake(train, regime, brakes, cell, w0, w1, scratch, rows, n):
    """Append the rows of a cell: driving from w0, then braking as late as possible to end at w1.

    Parameters
    ----------
    train : KernelTrain
    regime : int
        TRACTION, COASTING or DYNAMIC, held at the limit where it would pass it.
    brakes : int
        BRAKING or DYNAMIC; or COASTING, downhill.
    cell : Cell
        Whose limit is finite.
    w0, w1 : float
        Squared speeds at its ends.
    scratch : Rows
    rows : Rows, modified in place
        Rows are appended from index ``n`` on.
    n : int

    Returns
    -------
    n : int
        New number of rows; the last one is at the end of the cell. −1 where there is no room for them.
    """
    curve = braking_curve(train, brakes, cell, w1, scratch)
    return drive_onto(train, regime, brakes, cell, w0, w1, curve, scratch, rows, n)


@part
def drive_onto(train, regime, brakes, cell, w0, w1, curve, scratch, rows, n):
    """`drive_then_brake` where the curve of braking is known; its rows are the first ones of ``scratch``."""
    x = _meeting_point(train, regime, brakes, cell, w0, w1, curve, scratch)
    n = emit_driven(train, regime, cell, x, w0, rows, n)
    if x < cell.length_m:
        return _emit_braked(cell, cell.length_m - x, w1, curve, scratch, rows, n)
    if n < 0:
        return n
    rows.x[n - 1] = cell.end_m
    rows.w[n - 1] = w1
    return n


@leaf
def _is_sliver(length, d, w0, w1):
    """Whether a row of length d between two squared speeds is a rounding error in a cell of the given length."""
    change = abs(w1 - w0)
    largest = max(w0, w1)
    return (
        d <= _SLIVER * length
        or (d <= _SHORT * length and change <= _SHORT * largest)
        or (d <= _LESS_SHORT * length and change <= _SAME_W * largest)
    )


@kernel
def drop_slivers(rows, first, n, length):
    """Drop slivers from the rows ``first`` .. ``n`` of a cell of the given length; returns the new number of rows.

    They come from rounding at meeting points; the end of the cell, the last row, stays.
    """
    kept = first
    for i in range(first, n):
        sliver = _is_sliver(length, rows.x[i] - rows.x[kept - 1], rows.w[kept - 1], rows.w[i])
        if sliver and i < n - 1:
            continue
        if sliver and kept > first:
            kept -= 1
        rows.x[kept] = rows.x[i]
        rows.w[kept] = rows.w[i]
        kept += 1
    return kept
