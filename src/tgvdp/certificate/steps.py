"""The bound around given costates as a `Chain` of them: what a step of an ascent moves."""

from tgvdp._jit import leaf, part
from tgvdp.certificate.chain import LEVELS
from tgvdp.certificate.slopes import BRAKES, BY_P, BY_SLOPE, DYNAMIC, PULL, SPEED, STIFF, TURN, regular_cells

#: How far a step may go, and the least size of a costate, in units of what a joule of traction costs.
_REACH, _LEAST_SIZE = 4.0, 0.02
#: Second derivative that all have at least, relative to w over the size of the costate.
_LEAST_BEND = 1e-6


@leaf
def _bend(slopes, d, multiplier, k, end):
    """Second derivative of the bound of a cell, −weight·u·uᵀ, by one of its ends; and the weight that λ/v has alone."""
    v = slopes[k, end, SPEED]
    turn = slopes[k, end, TURN]
    u0 = (turn if end == 0 else 0.0) - 2.0 * v / d
    u1 = (turn if end == 1 else 0.0) + 2.0 * v / d
    return u0, u1, 0.5 * d / slopes[k, end, STIFF], 0.5 * d * v * v * v / (3.0 * multiplier)


@leaf
def slope_below(slopes, level, d, k, end, p):
    """Slope of the bound of a cell by the costate p at one of its ends, without the drops of levels below that."""
    cross = 0.5 * (slopes[k, 0, BY_SLOPE] + slopes[k, 1, BY_SLOPE])
    slope = 0.5 * d * slopes[k, end, BY_P] + (cross if end == 1 else -cross)
    if p > level[0]:
        slope += d * slopes[k, end, PULL]
    if p > level[1]:
        slope += d * slopes[k, end, DYNAMIC]
    if p > level[2]:
        slope += d * (slopes[k, end, BRAKES] - slopes[k, end, DYNAMIC])
    return slope


@part
def _fill_costate(tables, level, w, p, slopes, d, k, end, chain):
    """The terms of a costate at one end of a cell that are its own."""
    i = 2 * k + end
    size = max(abs(p), _LEAST_SIZE * tables.traction)
    most = _REACH * max(size, tables.traction)
    chain.at[i], chain.lowest[i], chain.highest[i] = p, p - most, p + most
    chain.bend[i] = _LEAST_BEND * w / size
    chain.drop[i, 0] = d * slopes[k, end, PULL]
    chain.drop[i, 1] = d * slopes[k, end, DYNAMIC]
    chain.drop[i, 2] = d * (slopes[k, end, BRAKES] - slopes[k, end, DYNAMIC])
    for j in range(LEVELS):
        chain.level[i, j] = level[j]


@part
def fill_chain(tables, level, cells, caps, w, multiplier, left, right, slopes, ends, bent, damping, chain):
    """The bound around given costates as a `Chain`."""
    first, last = regular_cells(w)
    for k in range(first, last + 1):
        d = cells.length_m[k]
        chain.link[2 * k + 1] = bent[k, 1]
        for end in range(2):
            i = 2 * k + end
            p = right[k] if end == 1 else left[k]
            _fill_costate(tables, level, w[k + end], p, slopes, d, k, end, chain)
            chain.bend[i] += bent[k, 2 * end]
            chain.slope[i] = slope_below(slopes, level, d, k, end, p)
        chain.cap[2 * k] = caps.node[k]
        for end in range(2):
            u0, u1, weight, usual = _bend(slopes, d, multiplier, k, end)
            weight += damping * usual
            chain.bend[2 * k] += weight * u0 * u0
            chain.bend[2 * k + 1] += weight * u1 * u1
            chain.link[2 * k + 1] += weight * u0 * u1
    chain.slope[2 * first] += ends[0]
    if first > 0:
        chain.drop[2 * first, 0] += ends[0]
    if last == left.shape[0] - 1:
        chain.slope[2 * last + 1] -= ends[1]
    else:
        chain.drop[2 * last + 1, 1] += ends[1]


@leaf
def gain_of_start(reach_w, level, first, stands, chain):
    """What a step gains in the terms of the origin."""
    i = 2 * first
    if not stands:
        return reach_w * (chain.best[i] - chain.at[i])
    return reach_w * (min(chain.best[i], level[0]) - min(chain.at[i], level[0]))


@leaf
def gain_of_end(reach_w, level, last, stands, chain):
    """What a step gains in the terms of the destination."""
    i = 2 * last + 1
    if not stands:
        return reach_w * (chain.at[i] - chain.best[i])
    return reach_w * (max(chain.at[i], level[1]) - max(chain.best[i], level[1]))
