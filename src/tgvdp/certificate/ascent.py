"""Better costates for a bound: Newton's rule on all of them at once.

The bound is a sum over cells, each of the costates at its two ends and no others, and concave in all of them. Around
given costates it is like a sum of parabolas along a chain, with steps of their slopes where regimes change and where p
jumps (`slopes`), whose top `chain` finds exactly: a Newton step with the kinks in it. A step that does not raise the
bound is not taken. Where a cell gained less than it promised, a kink stood in the way: the speed of its least value
jumped from one to another, say. Its slopes on both sides tell where: the cell is bent more along their difference, so
that the next step ends about there, and then goes along the kink (a secant rule, as in quasi-Newton methods, for each
cell alone). All cells are damped the more, the more steps were in vain (Levenberg 1944). Whatever comes out is as valid
as any other costate.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf, part
from tgvdp.certificate.cell_bounds import curve_of, share_of
from tgvdp.certificate.chain import LEVELS, Chain, chain_of, link_gain, own_gain, solve_chain
from tgvdp.certificate.slopes import (
    BRAKES,
    BY_P,
    BY_SLOPE,
    DYNAMIC,
    PULL,
    SLOPES,
    SPEED,
    STIFF,
    TURN,
    VALUE,
    fill_slopes,
    regular_cells,
)

#: Damping at first, relative to the bend of λ/v; and the share of it, and of what cells are bent more, that is kept
#: after a step that raised the bound. One in vain divides the damping by it.
_DAMPED, _KEPT = 0.03, 0.25
#: Least distance to a kink, relative to the step that crossed it.
_NEAREST = 1e-6
#: How far a step may go, and the least size of a costate, in units of what a joule of traction costs.
_REACH, _LEAST_SIZE = 4.0, 0.02
#: Second derivative that all have at least, relative to w over the size of the costate.
_LEAST_BEND = 1e-6
#: Steps that raise the bound too little in a row, after which there are no more.
_MOST_POOR = 20
#: Gains of a cell that are no more than rounding, relative to its bound.
_ROUNDING = 1e-12


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
def _by_end(reach_w, way, node):
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
def _slope_below(slopes, way, level, d, k, end, p):
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
def _fill_chain(tables, level, cells, caps, w, multiplier, side, left, right, way, slopes, ends, bent, damping, chain):
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
            chain.slope[i] = _slope_below(slopes, way, level, d, k, end, p)
        chain.cap[2 * k] = math.inf if way.curving else share_of(side, caps.node[k])
        for end in range(2):
            u0, u1, weight, usual = _bend(slopes, way, d, multiplier, k, end)
            weight += damping * usual
            chain.bend[2 * k] += weight * u0 * u0
            chain.bend[2 * k + 1] += weight * u1 * u1
            chain.link[2 * k + 1] += weight * u0 * u1
    chain.slope[2 * first] += _by_end(ends[0], way, first)
    if first > 0:
        chain.drop[2 * first, 0] += 0.0 if way.curving else ends[0]
    if last == left.shape[0] - 1:
        chain.slope[2 * last + 1] -= _by_end(ends[1], way, last + 1)
    else:
        chain.drop[2 * last + 1, 1] += 0.0 if way.curving else ends[1]


@part
def _bend_more(slopes, reached, way, level, chain, d, k, missed, bent):
    """Bend a cell more that gained ``missed`` less than it promised; ``bent`` (3,) in place.

    Along the step the bound is at most two straight lines: the slopes at both its ends tell the share of the step up to
    the kink between them. The slope turns by their difference on that share.
    """
    i = 2 * k
    step0 = chain.best[i] - chain.at[i]
    step1 = chain.best[i + 1] - chain.at[i + 1]
    turn0 = _slope_below(reached, way, level, d, k, 0, chain.best[i])
    turn0 -= _slope_below(slopes, way, level, d, k, 0, chain.at[i])
    turn1 = _slope_below(reached, way, level, d, k, 1, chain.best[i + 1])
    turn1 -= _slope_below(slopes, way, level, d, k, 1, chain.at[i + 1])
    turned = -(turn0 * step0 + turn1 * step1)
    if turned < missed:  # the bend of a speed bound hides the kink: as if it stood half way
        turned = 2.0 * missed
        share = -turned / (step0 * step0 + step1 * step1)
        turn0 = share * step0
        turn1 = share * step1
    weight = 1.0 / max(turned - missed, _NEAREST * turned)
    bent[0] += weight * turn0 * turn0
    bent[1] += weight * turn0 * turn1
    bent[2] += weight * turn1 * turn1


@part
def _learn(cells, w, slopes, reached, way, level, ends, chain, accepted, bent):
    """Bend cells more that gained less than they promised; the others keep less of it after a step that was taken.

    Returns what all cells, and the jumps between them, promised together.
    """
    first, last = regular_cells(w)
    total = 0.0
    for k in range(first, last + 1):
        promise = link_gain(chain, 2 * k + 1)
        for end in range(2):
            promise += own_gain(chain, 2 * k + end, chain.best[2 * k + end])
        total += promise
        if k > first and not way.curving:
            total -= max(chain.best[2 * k - 1] - chain.best[2 * k], 0.0) * chain.cap[2 * k]
            total += max(chain.at[2 * k - 1] - chain.at[2 * k], 0.0) * chain.cap[2 * k]
        if k == first:
            promise -= _gain_of_start(ends[0], way, level, first, first > 0, chain)
        if k == last:
            promise -= _gain_of_end(ends[1], way, level, last, last < cells.length_m.shape[0] - 1, chain)
        missed = promise - (reached[k, 0, VALUE] - slopes[k, 0, VALUE])
        if accepted:
            step0 = chain.best[2 * k] - chain.at[2 * k]
            step1 = chain.best[2 * k + 1] - chain.at[2 * k + 1]
            by_bend = 0.5 * (bent[k, 0] * step0 * step0 + bent[k, 2] * step1 * step1) + bent[k, 1] * step0 * step1
            missed += (1.0 - _KEPT) * by_bend
            for j in range(3):
                bent[k, j] *= _KEPT
        if missed > _ROUNDING * abs(reached[k, 0, VALUE]):
            _bend_more(slopes, reached, way, level, chain, cells.length_m[k], k, missed, bent[k])
    return total


@leaf
def _gain_of_start(reach_w, way, level, first, stands, chain):
    """What a step gains in the terms of the origin."""
    i = 2 * first
    if not stands:
        return _by_end(reach_w, way, first) * (chain.best[i] - chain.at[i])
    if way.curving:
        return 0.0
    return reach_w * (min(chain.best[i], level[0]) - min(chain.at[i], level[0]))


@leaf
def _gain_of_end(reach_w, way, level, last, stands, chain):
    """What a step gains in the terms of the destination."""
    i = 2 * last + 1
    if not stands:
        return _by_end(reach_w, way, last + 1) * (chain.at[i] - chain.best[i])
    if way.curving:
        return 0.0
    return reach_w * (max(chain.at[i], level[1]) - max(chain.best[i], level[1]))


@part
def _carry(w, left, right, way, chain, tried, tried_bow):
    """Costates and r of the solution of a chain, into ``tried`` (2, K) and ``tried_bow`` (K + 1,)."""
    first, last = regular_cells(w)
    for node in range(w.shape[0]):
        tried_bow[node] = way.bow[node]
    for k in range(first, last + 1):
        if way.curving:
            for end in range(2):
                node = k + end
                step = chain.best[2 * k + end] - chain.at[2 * k + end]
                tried_bow[node] = way.bow[node] + step
                tried[end, k] = (right[k] if end == 1 else left[k]) - way.pivot[node] * step
        else:
            tried[0, k] = chain.best[2 * k]
            tried[1, k] = chain.best[2 * k + 1]
    if first > 0:
        tried[0, 0] = tried[1, 0] = tried[0, first]
    if last < tried.shape[1] - 1:
        tried[0, last + 1] = tried[1, last + 1] = tried[1, last]


class Progress(NamedTuple):
    """How far an ascent is.

    Attributes
    ----------
    total : float
        The bound, per unit of inertia.
    now : int
        Which of the two arrays of slopes is that of the costates.
    steps, poor : int
        Steps that were made, and how many of the last ones raised the bound too little.
    ended : bool
        Whether no step promises to gain enough.
    """

    total: float
    now: int
    steps: int
    poor: int
    ended: bool


class Room(NamedTuple):
    """What an ascent works in; float64.

    Attributes
    ----------
    slopes : (2, K, 2, SLOPES)
    ends : (2,)
    chain : Chain
        Of 2·K unknowns.
    tried : (2, K)
    tried_bow : (K + 1,)
    bent : (2, K, 3)
        How much more than its parabola each cell is bent, −∂² by both starts, start and end, both ends; in steps of the
        costates, and of r.
    damping, promise : (2,)
        How much all cells are bent more, relative to the bend of λ/v, and what the last step promised; likewise.
    """

    slopes: NDArray[np.float64]
    ends: NDArray[np.float64]
    chain: Chain
    tried: NDArray[np.float64]
    tried_bow: NDArray[np.float64]
    bent: NDArray[np.float64]
    damping: NDArray[np.float64]
    promise: NDArray[np.float64]


def room_for(count: int) -> Room:
    """Room for an ascent with so many cells."""
    return Room(
        np.empty((2, count, 2, SLOPES)),
        np.empty(2),
        chain_of(2 * count),
        np.empty((2, count)),
        np.empty(count + 1),
        np.zeros((2, count, 3)),
        np.full(2, _DAMPED),
        np.zeros(2),
    )


@kernel
def climb(
    train, tables, cells, caps, w, multiplier, side, other, left, right, bow, pivot, curved, top_v, pieces, gain, most,
    before, room,
):  # fmt: skip
    """Raise the bound by better costates.

    Parameters
    ----------
    train, tables, cells, caps, w, multiplier, side, other, top_v, pieces
        As `slopes.fill_slopes` has them.
    left, right : (K,) float64, modified in place
        Costate at the two ends of each cell.
    bow : (K + 1,) float64, modified in place
        r at the nodes.
    pivot : (K + 1,) float64
        Speeds at the nodes, m/s.
    curved : bool
        Whether every other step moves r.
    gain : float
        What a step must promise, per unit of inertia.
    most : int
        Steps at most until it returns.
    before : Progress
        What it returned before, to go on; none, with no steps, to begin.
    room : Room
        As it was left before.

    Returns
    -------
    Progress
    """
    first, last = regular_cells(w)
    level = (-0.5 * tables.traction, -0.5 * tables.regeneration, 0.0)
    slopes, ends, chain, tried, tried_bow = room.slopes, room.ends, room.chain, room.tried, room.tried_bow
    total, now, steps, poor, ended = before
    if steps == 0:
        total = fill_slopes(
            train, tables, cells, caps, w, multiplier, side, other, left, right, bow, top_v, pieces, slopes[0], ends
        )  # fmt: skip
        room.promise[1] = math.inf if curved else 0.0
    last_step = steps + most
    while steps < last_step and not ended:
        steps += 1
        way = Way(curved and steps % 2 == 1, pivot, bow)
        kind = 1 if way.curving else 0
        bent = room.bent[kind]
        _fill_chain(
            tables, level, cells, caps, w, multiplier, side, left, right, way, slopes[now], ends, bent,
            room.damping[kind], chain,
        )  # fmt: skip
        solve_chain(2 * first, 2 * last + 1, gain / (last - first + 1), chain)
        _carry(w, left, right, way, chain, tried, tried_bow)
        reached = fill_slopes(
            train, tables, cells, caps, w, multiplier, side, other, tried[0], tried[1], tried_bow, top_v, pieces,
            slopes[1 - now], ends,
        )  # fmt: skip
        gained = reached - total
        room.promise[kind] = _learn(
            cells, w, slopes[now], slopes[1 - now], way, level, ends, chain, gained > 0.0, bent
        )  # fmt: skip
        if gained > 0.0:
            total = reached
            now = 1 - now
            for k in range(left.shape[0]):
                left[k] = tried[0, k]
                right[k] = tried[1, k]
            for node in range(bow.shape[0]):
                bow[node] = tried_bow[node]
        room.damping[kind] *= _KEPT if gained > 0.0 else 1.0 / _KEPT
        poor = poor + 1 if gained <= gain else 0
        ended = max(room.promise[0], room.promise[1]) <= gain or poor == _MOST_POOR
    return Progress(total, now, steps, poor, ended)
