"""Better costates for a bound: Newton's rule on all of them at once.

The bound is a sum over cells, each of the costates at its two ends and no others, and concave in all of them. Around
given costates it is like a sum of parabolas along a chain, with steps of their slopes where regimes change and where p
jumps (`slopes`, `steps`), whose top `chain` finds exactly: a Newton step with the kinks in it. A step that does not
raise the bound is not taken. Where a cell gained less than it promised, a kink stood in the way: the speed of its least
value jumped from one to another, say. Its slopes on both sides tell where: the cell is bent more along their
difference, so that the next step ends about there, and then goes along the kink (a secant rule, as in quasi-Newton
methods, for each cell alone). All cells are damped the more, the more steps were in vain (Levenberg 1944). Whatever
comes out is as valid as any other costate.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, part
from tgvdp.certificate.chain import Chain, chain_of, link_gain, own_gain, solve_chain
from tgvdp.certificate.slopes import SLOPES, VALUE, fill_slopes, regular_cells
from tgvdp.certificate.steps import fill_chain, gain_of_end, gain_of_start, slope_below

#: Damping at first, relative to the bend of λ/v; and the share of it, and of what cells are bent more, that is kept
#: after a step that raised the bound. One in vain divides the damping by it.
_DAMPED, _KEPT = 0.03, 0.25
#: Least distance to a kink, relative to the step that crossed it.
_NEAREST = 1e-6
#: Steps that raise the bound too little in a row, after which there are no more.
_MOST_POOR = 20
#: Gains of a cell that are no more than rounding, relative to its bound.
_ROUNDING = 1e-12


@part
def _bend_more(slopes, reached, level, chain, d, k, missed, bent):
    """Bend a cell more that gained ``missed`` less than it promised; ``bent`` (3,) in place.

    Along the step the bound is at most two straight lines: the slopes at both its ends tell the share of the step up to
    the kink between them. The slope turns by their difference on that share.
    """
    i = 2 * k
    step0 = chain.best[i] - chain.at[i]
    step1 = chain.best[i + 1] - chain.at[i + 1]
    turn0 = slope_below(reached, level, d, k, 0, chain.best[i])
    turn0 -= slope_below(slopes, level, d, k, 0, chain.at[i])
    turn1 = slope_below(reached, level, d, k, 1, chain.best[i + 1])
    turn1 -= slope_below(slopes, level, d, k, 1, chain.at[i + 1])
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
def _learn(cells, w, slopes, reached, level, ends, chain, accepted, bent):
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
            promise -= gain_of_start(ends[0], level, first, first > 0, chain)
        if k == last:
            promise -= gain_of_end(ends[1], level, last, last < cells.length_m.shape[0] - 1, chain)
        missed = promise - (reached[k, 0, VALUE] - slopes[k, 0, VALUE])
        if accepted:
            step0 = chain.best[2 * k] - chain.at[2 * k]
            step1 = chain.best[2 * k + 1] - chain.at[2 * k + 1]
            by_bend = 0.5 * (bent[k, 0] * step0 * step0 + bent[k, 2] * step1 * step1) + bent[k, 1] * step0 * step1
            missed += (1.0 - _KEPT) * by_bend
            for j in range(3):
                bent[k, j] *= _KEPT
        if missed > _ROUNDING * abs(reached[k, 0, VALUE]):
            _bend_more(slopes, reached, level, chain, cells.length_m[k], k, missed, bent[k])
    return total


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
        Whether no step promises to gain enough, or none need be made.
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
    bent : (K, 3)
        How much more than its parabola each cell is bent, −∂² by both starts, start and end, both ends.
    damping : (1,)
        How much all cells are bent more, relative to the bend of λ/v.
    """

    slopes: NDArray[np.float64]
    ends: NDArray[np.float64]
    chain: Chain
    tried: NDArray[np.float64]
    bent: NDArray[np.float64]
    damping: NDArray[np.float64]


def room_for(count: int) -> Room:
    """Room for an ascent with so many cells."""
    return Room(
        np.empty((2, count, 2, SLOPES)),
        np.empty(2),
        chain_of(2 * count),
        np.empty((2, count)),
        np.zeros((count, 3)),
        np.full(1, _DAMPED),
    )


@kernel
def climb(
    train, tables, cells, caps, w, multiplier, left, right, top_v, pieces, gain, enough, most, before, room
):  # fmt: skip
    """Raise the bound by better costates.

    Parameters
    ----------
    train, tables, cells, caps, w, multiplier, top_v, pieces
        As `slopes.fill_slopes` has them.
    left, right : (K,) float64, modified in place
        Costate at the two ends of each cell.
    gain : float
        What a step must promise, per unit of inertia.
    enough : float
        A bound that needs no further step, likewise.
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
    slopes, ends, chain, tried, bent, damping = room.slopes, room.ends, room.chain, room.tried, room.bent, room.damping
    total, now, steps, poor, ended = before
    if steps == 0:
        total = fill_slopes(
            train, tables, cells, caps, w, multiplier, left, right, top_v, pieces, slopes[0], ends
        )  # fmt: skip
    last_step = steps + most
    while steps < last_step and not ended:
        steps += 1
        fill_chain(
            tables, level, cells, caps, w, multiplier, left, right, slopes[now], ends, bent, damping[0], chain
        )  # fmt: skip
        solve_chain(2 * first, 2 * last + 1, gain / (last - first + 1), chain)
        _carry(w, chain, tried)
        reached = fill_slopes(
            train, tables, cells, caps, w, multiplier, tried[0], tried[1], top_v, pieces, slopes[1 - now], ends
        )  # fmt: skip
        gained = reached - total
        promise = _learn(cells, w, slopes[now], slopes[1 - now], level, ends, chain, gained > 0.0, bent)
        if gained > 0.0:
            total = reached
            now = 1 - now
            for k in range(left.shape[0]):
                left[k] = tried[0, k]
                right[k] = tried[1, k]
        damping[0] *= _KEPT if gained > 0.0 else 1.0 / _KEPT
        poor = poor + 1 if gained <= gain else 0
        ended = promise <= gain or poor == _MOST_POOR or total >= enough
    return Progress(total, now, steps, poor, ended)
