"""Better costates for a bound: Newton's rule on all of them at once.

The bound is a sum over cells, each of the costates at its two ends and no others, and concave in all of them. Around
given costates it is like a sum of parabolas along a chain, with steps of their slopes where regimes change and where p
jumps (`slopes`), whose top `chain` finds exactly: a Newton step with the kinks in it. A step that does not raise the
bound is not taken. Where a cell gained less than it promised its parabola is bent more (it is softer than H_vv tells),
which is a damping of its own for each cell. Whatever comes out is as valid as any other costate.
"""

import math
from typing import NamedTuple

from tgvdp._jit import kernel, leaf, part
from tgvdp.certificate.chain import LEVELS, link_gain, own_gain, solve_chain
from tgvdp.certificate.slopes import (
    BRAKES,
    BY_P,
    BY_SLOPE,
    DYNAMIC,
    PULL,
    STIFF,
    TURN,
    VALUE,
    fill_slopes,
    regular_cells,
)

#: Softness of cells at first, share of it that is kept after a step that raised the bound, and the most.
_SOFT, _FORGET, _SOFTEST = 0.03, 0.25, 1e4
#: How far a step may go, and the least size of a costate, in units of what a joule of traction costs.
_REACH, _LEAST_SIZE = 4.0, 0.02
#: Second derivative that is added to all, relative to w over the size of the costate.
_DAMPING = 1e-6
#: Steps that raise the bound too little in a row, after which there are no more.
_MOST_POOR = 12
#: Gains of a cell that are no more than rounding, relative to its bound.
_ROUNDING = 1e-12


@leaf
def _bend(slopes, d, multiplier, k, end):
    """Second derivative of the bound of a cell, −weight·u·uᵀ, by one of its ends; and a usual weight."""
    w = slopes[k, end, BY_SLOPE]
    v = math.sqrt(w)
    turn = slopes[k, end, TURN]
    u0 = (turn if end == 0 else 0.0) - 2.0 * v / d
    u1 = (turn if end == 1 else 0.0) + 2.0 * v / d
    return u0, u1, 0.5 * d / slopes[k, end, STIFF], 0.5 * d * w * v / (3.0 * multiplier)


@part
def _fill_chain(tables, cells, caps, w, multiplier, left, right, slopes, ends, soft, chain):
    """The bound around given costates as a `Chain`."""
    first, last = regular_cells(w)
    chain.level[0] = -0.5 * tables.traction
    chain.level[1] = -0.5 * tables.regeneration
    chain.level[2] = 0.0
    for k in range(first, last + 1):
        d = cells.length_m[k]
        cross = 0.5 * (slopes[k, 0, BY_SLOPE] + slopes[k, 1, BY_SLOPE])
        chain.link[2 * k + 1] = 0.0
        for end in range(2):
            i = 2 * k + end
            p = right[k] if end == 1 else left[k]
            size = max(abs(p), _LEAST_SIZE * tables.traction)
            chain.at[i] = p
            chain.lowest[i] = p - _REACH * max(size, tables.traction)
            chain.highest[i] = p + _REACH * max(size, tables.traction)
            chain.bend[i] = _DAMPING * w[k + end] / size
            chain.drop[i, 0] = d * slopes[k, end, PULL]
            chain.drop[i, 1] = d * slopes[k, end, DYNAMIC]
            chain.drop[i, 2] = d * (slopes[k, end, BRAKES] - slopes[k, end, DYNAMIC])
            chain.slope[i] = 0.5 * d * slopes[k, end, BY_P] + (cross if end == 1 else -cross)
            for j in range(LEVELS):
                if p > chain.level[j]:
                    chain.slope[i] += chain.drop[i, j]
        chain.cap[2 * k] = caps.node[k]
        for end in range(2):
            u0, u1, weight, spare = _bend(slopes, d, multiplier, k, end)
            weight += soft[k] * spare
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


@part
def _learn(cells, w, multiplier, slopes, reached, ends, chain, accepted, soft):
    """Soften cells that gained less than they promised, so that the parabola meets the gain; stiffen the others.

    Returns what all cells, and the jumps between them, promised together.
    """
    first, last = regular_cells(w)
    total = 0.0
    for k in range(first, last + 1):
        promise = link_gain(chain, 2 * k + 1)
        for end in range(2):
            promise += own_gain(chain, 2 * k + end, chain.best[2 * k + end])
        total += promise
        if k > first:
            total -= max(chain.best[2 * k - 1] - chain.best[2 * k], 0.0) * chain.cap[2 * k]
            total += max(chain.at[2 * k - 1] - chain.at[2 * k], 0.0) * chain.cap[2 * k]
        if k == first:
            promise -= _gain_of_start(ends[0], first > 0, chain, 2 * k)
        if k == last:
            promise -= _gain_of_end(ends[1], last < cells.length_m.shape[0] - 1, chain, 2 * k + 1)
        usual = 0.0
        for end in range(2):
            u0, u1, _, spare = _bend(slopes, cells.length_m[k], multiplier, k, end)
            along = u0 * (chain.best[2 * k] - chain.at[2 * k]) + u1 * (chain.best[2 * k + 1] - chain.at[2 * k + 1])
            usual += 0.5 * spare * along * along
        missed = promise + soft[k] * usual - (reached[k, 0, VALUE] - slopes[k, 0, VALUE])
        kept = _FORGET * soft[k] if accepted else soft[k]
        known = missed > _ROUNDING * abs(reached[k, 0, VALUE])
        soft[k] = min(max(missed / usual, kept), _SOFTEST) if known and usual > 0.0 else kept
    return total


@leaf
def _gain_of_start(reach_w, stands, chain, i):
    """What a step gains in the terms of the origin."""
    if not stands:
        return reach_w * (chain.best[i] - chain.at[i])
    return reach_w * (min(chain.best[i], chain.level[0]) - min(chain.at[i], chain.level[0]))


@leaf
def _gain_of_end(reach_w, stands, chain, i):
    """What a step gains in the terms of the destination."""
    if not stands:
        return reach_w * (chain.at[i] - chain.best[i])
    return reach_w * (max(chain.at[i], chain.level[1]) - max(chain.best[i], chain.level[1]))


@part
def _carry(w, chain, tried):
    """Costates of the solution of a chain, into ``tried`` (2, K)."""
    first, last = regular_cells(w)
    for k in range(first, last + 1):
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


@kernel
def climb(
    train, tables, cells, caps, w, multiplier, left, right, top_v, pieces, gain, most, before, slopes, ends, chain,
    tried, soft,
):  # fmt: skip
    """Raise the bound by better costates.

    Parameters
    ----------
    train, tables, cells, caps, w, multiplier, top_v, pieces
        As `cell_bounds.bound_kernel` has them.
    left, right : (K,) float64, modified in place
        Costate at the two ends of each cell.
    gain : float
        What a step must promise, per unit of inertia.
    most : int
        Steps at most until it returns.
    before : Progress
        What it returned before, to go on; none, with no steps, to begin.
    slopes : (2, K, 2, SLOPES) float64
    ends : (2,) float64
    chain : Chain
        Of 2·K unknowns.
    tried : (2, K) float64
    soft : (K,) float64
        Scratch.

    Returns
    -------
    Progress
    """
    first, last = regular_cells(w)
    total, now, steps, poor, ended = before
    if steps == 0:
        for k in range(left.shape[0]):
            soft[k] = _SOFT
        total = fill_slopes(train, tables, cells, caps, w, multiplier, left, right, top_v, pieces, slopes[0], ends)
    last_step = steps + most
    while steps < last_step and not ended:
        steps += 1
        _fill_chain(tables, cells, caps, w, multiplier, left, right, slopes[now], ends, soft, chain)
        solve_chain(2 * first, 2 * last + 1, gain / (last - first + 1), chain)
        _carry(w, chain, tried)
        reached = fill_slopes(
            train, tables, cells, caps, w, multiplier, tried[0], tried[1], top_v, pieces, slopes[1 - now], ends
        )  # fmt: skip
        gained = reached - total
        promise = _learn(cells, w, multiplier, slopes[now], slopes[1 - now], ends, chain, gained > 0.0, soft)
        if gained > 0.0:
            total = reached
            now = 1 - now
            for k in range(left.shape[0]):
                left[k] = tried[0, k]
                right[k] = tried[1, k]
        poor = poor + 1 if gained <= gain else 0
        ended = promise <= gain or poor == _MOST_POOR
    return Progress(total, now, steps, poor, ended)
