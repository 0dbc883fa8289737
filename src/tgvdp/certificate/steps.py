"""What a step of an ascent moves, and the bound around given costates as a `Chain` of it.

One kind of step moves the costates p at both ends of all cells. Where the potential is curved (`certificate.curved`)
every other step moves r, which is continuous, around the run that the costates come from: its slope q = p + r·v stays
as it is at the speed v̂ of the run, so that regimes do, and what grows with r, (2/3)·v³ − v̂·v², is least there:
faster and slower runs become dearer alike.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part
from tgvdp.certificate.cell_bounds import curve_of, share_of
from tgvdp.certificate.chain import LEVELS
from tgvdp.certificate.slopes import BRAKES, BY_P, BY_SLOPE, DYNAMIC, PULL, SPEED, STIFF, TURN, regular_cells

#: How far a step may go, and the least size of a costate, in units of what a joule of traction costs.
_REACH, _LEAST_SIZE = 4.0, 0.02
#: Second derivative that all have at least, relative to w over the size of the costate.
_LEAST_BEND = 1e-6


class Way(NamedTuple):
    """What a step of an ascent moves: all costates, or all r, around the speeds of the run that they come from.

    Attributes
    ----------
    curving : bool
        Whether it is r, which is the same on both sides of a node. Then q = p + r·v stays as it is at the speed
        ``pivot``: p moves by −pivot times as much.
    pivot : (K + 1,) float64
        Speeds at the nodes, m/s.
    bow : (K + 1,) float64
        r at the nodes.
    """

    curving: bool
    pivot: NDArray[np.float64]
    bow: NDArray[np.float64]


@leaf
def _turned(way, node, v):
    """How q at speed v changes with what is moved at a node."""
    return v - way.pivot[node] if way.curving else 1.0


@leaf
def _lifted(slopes, way, k, at, node):
    """How the potential changes with what is moved at a node, at the speed of the least value at an end of a cell."""
    if not way.curving:
        return slopes[k, at, BY_SLOPE]
    v = slopes[k, at, SPEED]
    return v * v * (2.0 / 3.0 * v - way.pivot[node])


@leaf
def by_end(reach_w, way, node):
    """How the potential changes with what is moved at an end of the trip."""
    return curve_of(reach_w) - way.pivot[node] * reach_w if way.curving else reach_w


@leaf
def _bend(slopes, way, d, multiplier, k, end):
    """Second derivative of the bound of a cell, −weight·u·uᵀ, by one of its ends; and the weight that λ/v has alone."""
    v = slopes[k, end, SPEED]
    turn = slopes[k, end, TURN] * _turned(way, k + end, v)
    if way.curving:
        turn += slopes[k, end, BY_P]
    u0 = (turn if end == 0 else 0.0) - 2.0 * v * _turned(way, k, v) / d
    u1 = (turn if end == 1 else 0.0) + 2.0 * v * _turned(way, k + 1, v) / d
    return u0, u1, 0.5 * d / slopes[k, end, STIFF], 0.5 * d * v * v * v / (3.0 * multiplier)


@leaf
def slope_below(slopes, way, level, d, k, end, p):
    """Slope of the bound of a cell by what is moved at one of its ends, without the drops of levels below costate p."""
    v = slopes[k, end, SPEED]
    cross = 0.5 * (_lifted(slopes, way, k, 0, k + end) + _lifted(slopes, way, k, 1, k + end))
    slope = 0.5 * d * slopes[k, end, BY_P] * _turned(way, k + end, v) + (cross if end == 1 else -cross)
    if not way.curving:
        q = p + way.bow[k + end] * v
        if q > level[0]:
            slope += d * slopes[k, end, PULL]
        if q > level[1]:
            slope += d * slopes[k, end, DYNAMIC]
        if q > level[2]:
            slope += d * (slopes[k, end, BRAKES] - slopes[k, end, DYNAMIC])
    return slope


@part
def _fill_costate(tables, level, w, p, slopes, way, d, k, end, chain):
    """The terms of a costate at one end of a cell that are its own."""
    i = 2 * k + end
    size = max(abs(p), _LEAST_SIZE * tables.traction)
    most = _REACH * max(size, tables.traction)
    chain.at[i], chain.lowest[i], chain.highest[i] = p, p - most, p + most
    chain.bend[i] = _LEAST_BEND * w / size
    chain.drop[i, 0] = d * slopes[k, end, PULL]
    chain.drop[i, 1] = d * slopes[k, end, DYNAMIC]
    chain.drop[i, 2] = d * (slopes[k, end, BRAKES] - slopes[k, end, DYNAMIC])
    for j in range(LEVELS):  # q passes them
        chain.level[i, j] = level[j] - way.bow[k + end] * slopes[k, end, SPEED]


@part
def _fill_curve(tables, stands, cap, way, node, i, chain):
    """The terms of r at one end of a cell that are its own; it stays as it is next to a cell of a standstill.

    Levels are left to what cells learn: q does not pass them at the speeds of the run.
    """
    v = way.pivot[node]
    r = way.bow[node]
    size = max(abs(r), _LEAST_SIZE * tables.traction / math.sqrt(cap))
    most = 0.0 if stands else _REACH * max(size, tables.traction / math.sqrt(cap))
    chain.at[i], chain.lowest[i], chain.highest[i] = r, r - most, r + most
    chain.bend[i] = _LEAST_BEND * v * v * v / size
    chain.drop[i, :] = 0.0
    chain.level[i, :] = r


@part
def fill_chain(tables, level, cells, caps, w, multiplier, side, left, right, way, slopes, ends, bent, damping, chain):
    """The bound around given costates as a `Chain`."""
    first, last = regular_cells(w)
    for k in range(first, last + 1):
        d = cells.length_m[k]
        chain.link[2 * k + 1] = bent[k, 1]
        for end in range(2):
            i = 2 * k + end
            node = k + end
            p = right[k] if end == 1 else left[k]
            if way.curving:
                stands = (node == first and first > 0) or (node == last + 1 and last < left.shape[0] - 1)
                _fill_curve(tables, stands, caps.node[node], way, node, i, chain)
            else:
                _fill_costate(tables, level, w[node], p, slopes, way, d, k, end, chain)
            chain.bend[i] += bent[k, 2 * end]
            chain.slope[i] = slope_below(slopes, way, level, d, k, end, p)
        chain.cap[2 * k] = math.inf if way.curving else share_of(side, caps.node[k])
        for end in range(2):
            u0, u1, weight, usual = _bend(slopes, way, d, multiplier, k, end)
            weight += damping * usual
            chain.bend[2 * k] += weight * u0 * u0
            chain.bend[2 * k + 1] += weight * u1 * u1
            chain.link[2 * k + 1] += weight * u0 * u1
    chain.slope[2 * first] += by_end(ends[0], way, first)
    if first > 0:
        chain.drop[2 * first, 0] += 0.0 if way.curving else ends[0]
    if last == left.shape[0] - 1:
        chain.slope[2 * last + 1] -= by_end(ends[1], way, last + 1)
    else:
        chain.drop[2 * last + 1, 1] += 0.0 if way.curving else ends[1]


@leaf
def gain_of_start(reach_w, way, level, first, stands, chain):
    """What a step gains in the terms of the origin."""
    i = 2 * first
    if not stands:
        return by_end(reach_w, way, first) * (chain.best[i] - chain.at[i])
    if way.curving:
        return 0.0
    return reach_w * (min(chain.best[i], level[0]) - min(chain.at[i], level[0]))


@leaf
def gain_of_end(reach_w, way, level, last, stands, chain):
    """What a step gains in the terms of the destination."""
    i = 2 * last + 1
    if not stands:
        return by_end(reach_w, way, last + 1) * (chain.at[i] - chain.best[i])
    if way.curving:
        return 0.0
    return reach_w * (max(chain.at[i], level[1]) - max(chain.best[i], level[1]))
