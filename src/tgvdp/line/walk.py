"""Looking up functions of the position while walking along a line."""

from tgvdp._jit import leaf


@leaf
def piece_from(knots, i, x):
    """Index of the piece that holds x, from that of a piece before it."""
    while i + 2 < knots.shape[0] and knots[i + 1] <= x:
        i += 1
    return i


@leaf
def sum_to(function, i, x):
    """Integral of a `Piecewise` function up to x, in piece i."""
    u = x - function.knot_m[i]
    c = function.coefficient
    return function.integral[i] + u * (c[i, 0] + u * (c[i, 1] / 2.0 + u * c[i, 2] / 3.0))
