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


class Blend(NamedTuple):
    """Policies between two, (K + 1, 4) float64 each: first + u·(second − first) + u·(u − 1)·bend, for a share u."""

    first: NDArray[np.float64]
    second: NDArray[np.float64]
    bend: NDArray[np.float64]

    def at(self, share: float) -> NDArray[np.float64]:
        """Policy for a share of the second one."""
        return np.asarray(self.first + share * (self.second - self.first + (share - 1.0) * self.bend))


@leaf
def switch_at(blend, share, k, which):
    """One of the four switching speeds of a blend, squared."""
    first = blend.first[k, which]
    return first + share * (blend.second[k, which] - first + (share - 1.0) * blend.bend[k, which])


@part
def _beside(known, first, second):
    """The nearest extremals before the first and after the second, and where they lie in ln λ from 0 to 1 of these."""
    before = first
    after = second
    before_at = 0.0
    after_at = 1.0
    if known[first, 2] < math.inf:
        span = math.log(known[second, 2] / known[first, 2])
        while before > 0 and before_at >= -_APART and known[before - 1, 2] < math.inf:
            before -= 1
            before_at = math.log(known[before, 2] / known[first, 2]) / span
        while after < known.shape[0] - 1 and after_at <= 1.0 + _APART:
            after += 1
            after_at = math.log(known[after, 2] / known[first, 2]) / span
    return before, before_at, after, after_at


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
    before, before_at, after, after_at = _beside(known, first, second)
    bent_before = before_at < -_APART
    bent_after = after_at > 1.0 + _APART
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
            p2 = policies[after, k, which]
            is_told = p0 < top_w
            if p0 >= top_w > p1:
                told = begins if i == 0 else begins + falls if i == 1 else math.nan
                is_told = told > p0
                if is_told:
                    p0 = told
                elif bent_after:
                    p0 = max(p1 + (p1 - p2) / (after_at - 1.0), p0)
            step = p1 - p0
            bend = 0.0
            count = 0
            if bent_before and policies[before, k, which] < top_w:
                bend += (policies[before, k, which] - p0 - before_at * step) / (before_at * (before_at - 1.0))
                count += 1
            if bent_after and is_told:
                bend += (p2 - p0 - after_at * step) / (after_at * (after_at - 1.0))
                count += 1
            most = abs(step)
            blend.first[k, i] = p0
            blend.second[k, i] = p1
            blend.bend[k, i] = min(max(bend / max(count, 1), -most), most)
