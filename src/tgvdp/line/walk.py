"""Looking up functions of the position while walking along a line."""

from tgvdp._jit import leaf


@leaf
def piece_from(knots, i, x):
    """Index of the piece that holds x, from that of a piece before it."""
    while i + 2 < knots.shape[0] and knots[i + 1] <= x:
        i += 1
    return i


@leaf
def count_below(knots, count, x):
    """How many of the first knots are below x: numpy's `searchsorted` takes numba a dozen functions, and a second."""
    first = 0
    end = count
    while first < end:
        middle = (first + end) // 2
        if knots[middle] < x:
            first = middle + 1
        else:
            end = middle
    return first


@leaf
def sum_to(function, i, x):
    """Integral of a `Piecewise` function up to x, in piece i."""
    u = x - function.knot_m[i]
    c = function.coefficient
    return function.integral[i] + u * (c[i, 0] + u * (c[i, 1] / 2.0 + u * c[i, 2] / 3.0))
