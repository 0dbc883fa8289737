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

from typing import NamedTuple

from tgvdp._jit import kernel, leaf, part
from tgvdp.certificate.cell_bounds import share_of
from tgvdp.certificate.chain import link_gain, own_gain, solve_chain
from tgvdp.certificate.slopes import (
    BRAKES,
    BY_P,
    BY_SLOPE,
    DYNAMIC,
    PULL,
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


@leaf
def _bend(slopes, d, multiplier, k, end):
    """Second derivative of the bound of a cell, −weight·u·uᵀ, by one of its ends; and the weight that λ/v has alone."""
    v = slopes[k, end, SPEED]
    turn = slopes[k, end, TURN]
    u0 = (turn if end == 0 else 0.0) - 2.0 * v / d
    u1 = (turn if end == 1 else 0.0) + 2.0 * v / d
    return u0, u1, 0.5 * d / slopes[k, end, STIFF], 0.5 * d * v * v * v / (3.0 * multiplier)


@leaf
def _slope_below(slopes, chain, d, k, end, p):
    """Slope of the bound of a cell by the costate p at one of its ends, without the drops of levels below it."""
    cross = 0.5 * (slopes[k, 0, BY_SLOPE] + slopes[k, 1, BY_SLOPE])
    slope = 0.5 * d * slopes[k, end, BY_P] + (cross if end == 1 else -cross)
    if p > chain.level[0]:
        slope += d * slopes[k, end, PULL]
    if p > chain.level[1]:
        slope += d * slopes[k, end, DYNAMIC]
    if p > chain.level[2]:
        slope += d * (slopes[k, end, BRAKES] - slopes[k, end, DYNAMIC])
    return slope


@part
def _fill_chain(tables, cells, caps, w, multiplier, side, left, right, slopes, ends, bent, damping, chain):
    """The bound around given costates as a `Chain`."""
    first, last = regular_cells(w)
    chain.level[0] = -0.5 * tables.traction
    chain.level[1] = -0.5 * tables.regeneration
    chain.level[2] = 0.0
    for k in range(first, last + 1):
        d = cells.length_m[k]
        chain.link[2 * k + 1] = bent[k, 1]
        for end in range(2):
            i = 2 * k + end
            p = right[k] if end == 1 else left[k]
            size = max(abs(p), _LEAST_SIZE * tables.traction)
            chain.at[i] = p
            chain.lowest[i] = p - _REACH * max(size, tables.traction)
            chain.highest[i] = p + _REACH * max(size, tables.traction)
            chain.bend[i] = _LEAST_BEND * w[k + end] / size + bent[k, 2 * end]
            chain.drop[i, 0] = d * slopes[k, end, PULL]
            chain.drop[i, 1] = d * slopes[k, end, DYNAMIC]
            chain.drop[i, 2] = d * (slopes[k, end, BRAKES] - slopes[k, end, DYNAMIC])
            chain.slope[i] = _slope_below(slopes, chain, d, k, end, p)
        chain.cap[2 * k] = share_of(side, caps.node[k])
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


@part
def _bend_more(slopes, reached, chain, d, k, missed, bent):
    """Bend a cell more that gained ``missed`` less than it promised; ``bent`` (3,) in place.

    Along the step the bound is at most two straight lines: the slopes at both its ends tell the share of the step up to
    the kink between them. The slope turns by their difference on that share.
    """
    i = 2 * k
    step0 = chain.best[i] - chain.at[i]
    step1 = chain.best[i + 1] - chain.at[i + 1]
    turn0 = _slope_below(reached, chain, d, k, 0, chain.best[i]) - _slope_below(slopes, chain, d, k, 0, chain.at[i])
    turn1 = _slope_below(reached, chain, d, k, 1, chain.best[i + 1])
    turn1 -= _slope_below(slopes, chain, d, k, 1, chain.at[i + 1])
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
def _learn(cells, w, slopes, reached, ends, chain, accepted, bent):
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
        if k > first:
            total -= max(chain.best[2 * k - 1] - chain.best[2 * k], 0.0) * chain.cap[2 * k]
            total += max(chain.at[2 * k - 1] - chain.at[2 * k], 0.0) * chain.cap[2 * k]
        if k == first:
            promise -= _gain_of_start(ends[0], first > 0, chain, 2 * k)
        if k == last:
            promise -= _gain_of_end(ends[1], last < cells.length_m.shape[0] - 1, chain, 2 * k + 1)
        missed = promise - (reached[k, 0, VALUE] - slopes[k, 0, VALUE])
        if accepted:
            step0 = chain.best[2 * k] - chain.at[2 * k]
            step1 = chain.best[2 * k + 1] - chain.at[2 * k + 1]
            by_bend = 0.5 * (bent[k, 0] * step0 * step0 + bent[k, 2] * step1 * step1) + bent[k, 1] * step0 * step1
            missed += (1.0 - _KEPT) * by_bend
            for j in range(3):
                bent[k, j] *= _KEPT
        if missed > _ROUNDING * abs(reached[k, 0, VALUE]):
            _bend_more(slopes, reached, chain, cells.length_m[k], k, missed, bent[k])
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
    damping : float
        How much all cells are bent more, relative to the bend of λ/v.
    steps, poor : int
        Steps that were made, and how many of the last ones raised the bound too little.
    ended : bool
        Whether no step promises to gain enough.
    """

    total: float
    now: int
    damping: float
    steps: int
    poor: int
    ended: bool


@kernel
def climb(
    train, tables, cells, caps, w, multiplier, side, other, left, right, top_v, pieces, gain, most, before, slopes,
    ends, chain, tried, bent,
):  # fmt: skip
    """Raise the bound by better costates.

    Parameters
    ----------
    train, tables, cells, caps, w, multiplier, side, other, top_v, pieces
        As `slopes.fill_slopes` has them.
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
    bent : (K, 3) float64
        Scratch: how much more than its parabola each cell is bent, −∂² by both starts, start and end, both ends.

    Returns
    -------
    Progress
    """
    first, last = regular_cells(w)
    total, now, damping, steps, poor, ended = before
    if steps == 0:
        bent[:] = 0.0
        damping = _DAMPED
        total = fill_slopes(
            train, tables, cells, caps, w, multiplier, side, other, left, right, top_v, pieces, slopes[0], ends
        )  # fmt: skip
    last_step = steps + most
    while steps < last_step and not ended:
        steps += 1
        _fill_chain(tables, cells, caps, w, multiplier, side, left, right, slopes[now], ends, bent, damping, chain)
        solve_chain(2 * first, 2 * last + 1, gain / (last - first + 1), chain)
        _carry(w, chain, tried)
        reached = fill_slopes(
            train, tables, cells, caps, w, multiplier, side, other, tried[0], tried[1], top_v, pieces,
            slopes[1 - now], ends,
        )  # fmt: skip
        gained = reached - total
        promise = _learn(cells, w, slopes[now], slopes[1 - now], ends, chain, gained > 0.0, bent)
        if gained > 0.0:
            total = reached
            now = 1 - now
            for k in range(left.shape[0]):
                left[k] = tried[0, k]
                right[k] = tried[1, k]
        damping *= _KEPT if gained > 0.0 else 1.0 / _KEPT
        poor = poor + 1 if gained <= gain else 0
        ended = promise <= gain or poor == _MOST_POOR
    return Progress(total, now, damping, steps, poor, ended)
