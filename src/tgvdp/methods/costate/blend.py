"""Policies between those of two extremals: switching speeds are quadratic in ln λ, by the extremals beside them."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part
from tgvdp.methods.costate.forward_cell import coasted_from
from tgvdp.methods.costate.step_held import HELD
from tgvdp.physics.cell import cell_at

#: Extremals nearer than this, in distances of the two whose policies are blended, tell no bend.
_APART = 1e-3
#: A switching speed whose square lies below the envelope's by less than this share of it is on it.
_AT_TOP = 1e-6
#: Two straight lines have a corner where they meet, if they bend so many times as much between two extremals as beside
#: these: where a limit ahead begins to bind, say.
_CORNER = 3.0
#: ... or if it changes by less than this share of its step on one side: where nothing but the line decides, it is one.
_FLAT = 1e-2
#: What bends so many times as much on one side as on the other has a corner there: the other side tells.
_UNEVEN = 3.0


class Blend(NamedTuple):
    """Policies between two, (K + 1, 4) float64 each: first + u·(second − first) − bend·g(u), for a share u.

    Where there is no ``corner`` (0) between them g is u·(1 − u); else it is u up to the corner, and from there on falls
    evenly to 0.
    """

    first: NDArray[np.float64]
    second: NDArray[np.float64]
    bend: NDArray[np.float64]
    corner: NDArray[np.float64]

    def at(self, share: float) -> NDArray[np.float64]:
        """Policy for a share of the second one."""
        corner = np.where(self.corner > 0.0, self.corner, 0.5)
        straight = np.minimum(share, corner / (1.0 - corner) * (1.0 - share))
        g = np.where(self.corner > 0.0, straight, share * (1.0 - share))
        return np.asarray(self.first + share * (self.second - self.first) - g * self.bend)


@leaf
def switch_at(blend, share, k, which):
    """One of the four switching speeds of a blend, squared."""
    first = blend.first[k, which]
    corner = blend.corner[k, which]
    g = share * (1.0 - share)
    if 0.0 < corner < 1.0:
        g = min(share, corner / (1.0 - corner) * (1.0 - share))
    return first + share * (blend.second[k, which] - first) - g * blend.bend[k, which]


class _Beside(NamedTuple):
    """Extremals before two, and after them, up to two each, and where they lie in ln λ from 0 to 1 of the two.

    Where there is none it is the one that lies nearer to the two, in the same place.
    """

    before: int
    before_at: float
    farther_before: int
    farther_before_at: float
    after: int
    after_at: float
    farther_after: int
    farther_after_at: float


@part
def _next(known, first, span, i, at, step):
    """The next extremal of a finite multiplier that is apart from another, in one direction, and where it lies."""
    j = i + step
    while 0 <= j < known.shape[0] and known[j, 2] < math.inf:
        place = math.log(known[j, 2] / known[first, 2]) / span
        if abs(place - at) > _APART:
            return j, place
        j += step
    return i, at


@part
def _beside(known, first, second):
    """The extremals beside two neighbouring ones."""
    if known[first, 2] == math.inf:
        return _Beside(first, 0.0, first, 0.0, second, 1.0, second, 1.0)
    span = math.log(known[second, 2] / known[first, 2])
    before, before_at = _next(known, first, span, first, 0.0, -1)
    farther_before, farther_before_at = _next(known, first, span, before, before_at, -1)
    after, after_at = _next(known, first, span, second, 1.0, 1)
    farther_after, farther_after_at = _next(known, first, span, after, after_at, 1)
    return _Beside(
        before, before_at, farther_before, farther_before_at, after, after_at, farther_after, farther_after_at
    )


@leaf
def _bend_of(slope0, slope1, length):
    """Half the second derivative by two slopes, over the way from the start of the one to the end of the other."""
    return (slope1 - slope0) / length


@leaf
def _bent(step, beside, before, farther_before, after, farther_after):
    """Bend and corner of a switching speed that changes by a step, by its slopes beside that; NaN is not known."""
    left = _bend_of(before, step, 1.0 - beside.before_at)
    right = _bend_of(step, after, beside.after_at)
    if math.isnan(left) or math.isnan(right):
        bend = 0.0 if math.isnan(left) and math.isnan(right) else right if math.isnan(left) else left
        return min(max(bend, -abs(step)), abs(step)), 0.0
    outer = 0.0
    is_known = False
    for one in (
        _bend_of(farther_before, before, -beside.farther_before_at),
        _bend_of(after, farther_after, beside.farther_after_at - 1.0),
    ):
        if not math.isnan(one):
            outer += abs(one)
            is_known = True
    flat = min(abs(before), abs(after)) <= _FLAT * abs(step)
    sharp = is_known and abs(left) + abs(right) > _CORNER * outer
    if left * right > 0.0 and (flat or sharp):
        rises = step - before
        return rises, (after - step) / (rises + after - step)
    bend = 0.5 * (left + right)
    if max(abs(left), abs(right)) > _UNEVEN * min(abs(left), abs(right)):
        bend = left if abs(left) < abs(right) else right
    return min(max(bend, -abs(step)), abs(step)), 0.0


@leaf
def _is_held(policy):
    """Whether a line of switching has come to a station as a speed that is held, or is the envelope."""
    return policy[0] == policy[1]


@leaf
def _falls(policy):
    """Whether a line of switching falls within a cell more than a run that coasts, by its policy at the end."""
    return policy[1] > policy[0] * (1.0 + HELD)


@leaf
def falls_from_held(blend, k):
    """Whether the line of switching of a policy falls within cell k from a speed that is held up to there.

    Of a blend, if that is so of one of its policies: or running times would jump at that one.
    """
    held = _is_held(blend.first[k]) or _is_held(blend.second[k])
    return held and (_falls(blend.first[k + 1]) or _falls(blend.second[k + 1]))


@leaf
def _with_line(place, first, second, step, before, after, bend, corner):
    """Bend and corner of the start of a line whose end has a corner at a place; as given if that says nothing.

    A line may fall as a run that coasts up to there, and more than that from there on.
    """
    falls0 = first[1] - first[0]
    falls1 = second[1] - second[0]
    if 0.0 < falls0 < _FLAT * falls1 and not math.isnan(before):
        return step - before, place
    return bend, corner


@leaf
def _slope(policies, k, which, first, first_at, second, second_at):
    """Slope of a switching speed between two extremals; NaN where these are one."""
    if first_at == second_at:
        return math.nan
    return (policies[second, k, which] - policies[first, k, which]) / (second_at - first_at)


@part
def fill_blend(train, cells, known, policies, second, top, blend):
    """Fill in the blend of the policies of an extremal and the one before it, bent by the extremals beside them.

    How far a switching speed of the first policy lies beyond the envelope, where it ends, tells the speed at the end of
    a run that coasts from there; or the second policy and the one after it.

    Parameters
    ----------
    train : KernelTrain
    cells : Cells
    known : (E, 3) float64
        Running times, energies and multipliers of extremals, in order; the first multiplier may be infinite.
    policies : (E, K + 1, 4) float64
    second : int
    top : (K + 1,) float64
        Envelope at the stations, m²/s², beyond which no switching speed is known.
    blend : Blend, modified in place
    """
    first = max(second - 1, 0)
    beside = _beside(known, first, second)
    last = cells.length_m.shape[0]
    begins = math.nan  # the first line of switching, beyond the envelope, at the station behind
    falls = 0.0  # by how much more it falls within a cell than a run that coasts
    for k in range(last, -1, -1):
        if k < last:
            coasts = policies[first, k + 1, 1]
            if _falls(policies[first, k + 1]):
                falls = coasts - policies[first, k + 1, 0]
            else:
                coasts = begins + falls if _falls(policies[second, k + 1]) else math.nan
            begins = coasted_from(train, cell_at(cells, k), coasts)
        top_w = top[k] * (1.0 - _AT_TOP)
        is_held = _is_held(policies[first, k]) and _is_held(policies[second, k])
        if is_held:  # from there lines fall later on
            begins = math.nan
        for i in range(4):
            which = 0 if is_held and i == 1 else i
            p0 = policies[first, k, which]
            p1 = policies[second, k, which]
            line = 0 if i == 1 else which  # a line that ends below the envelope may begin beyond it
            after_slope = _slope(policies, k, which, second, 1.0, beside.after, beside.after_at)
            is_told = policies[first, k, line] < top_w
            if not is_told and policies[second, k, line] < top_w:
                told = begins if i == 0 else begins + falls if i == 1 else math.nan
                is_told = told > p0
                if is_told:
                    p0 = told
                elif not math.isnan(after_slope):
                    p0 = max(p1 - after_slope, p0)
            blend.first[k, i] = p0
            blend.second[k, i] = p1
            before_slope = farther_before_slope = math.nan
            if policies[beside.before, k, line] < top_w:
                before_slope = _slope(policies, k, which, beside.before, beside.before_at, first, 0.0)
            if policies[beside.farther_before, k, line] < top_w:
                farther_before_slope = _slope(
                    policies, k, which, beside.farther_before, beside.farther_before_at, beside.before,
                    beside.before_at,
                )  # fmt: skip
            farther_after_slope = _slope(
                policies, k, which, beside.after, beside.after_at, beside.farther_after, beside.farther_after_at
            )
            bend, corner = _bent(
                p1 - p0, beside, before_slope, farther_before_slope, after_slope if is_told else math.nan,
                farther_after_slope,
            )  # fmt: skip
            if i == 1 and blend.corner[k, 0] > 0.0:
                bend, corner = _with_line(
                    blend.corner[k, 0], policies[first, k], policies[second, k], p1 - p0, before_slope, after_slope,
                    bend, corner,
                )  # fmt: skip
            blend.bend[k, i] = bend
            blend.corner[k, i] = corner
