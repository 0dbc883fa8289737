"""Policies between those of two extremals: how switching speeds change in ln λ the extremals beside them tell."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part
from tgvdp.methods.costate.corners import Slopes, bent, beside_of, slopes_of, with_line
from tgvdp.methods.costate.forward_cell import coasted_from
from tgvdp.methods.costate.intervals import matched
from tgvdp.methods.costate.step_held import HELD
from tgvdp.physics.cell import cell_at

#: Switching speeds of a policy at a station, without the two ends of the interval in which a dynamic brake that rises
#: with speed works, too.
LINES = 4
#: A switching speed whose square lies below the envelope's by less than this share of it is on it.
_AT_TOP = 1e-6


class Blend(NamedTuple):
    """Policies between two, (K + 1, 4 or 6) float64 each: first + u·(second − first) − bend·g(u), for a share u.

    Where there is no ``corner`` between them g is u·(1 − u); else it is u up to the corner, and from there on falls
    evenly to 0.
    """

    first: NDArray[np.float64]
    second: NDArray[np.float64]
    bend: NDArray[np.float64]
    corner: NDArray[np.float64]

    def at(self, share: float) -> NDArray[np.float64]:
        """Policy for a share of the second one."""
        has_corner = (self.corner > 0.0) & (self.corner < 1.0)
        corner = np.where(has_corner, self.corner, 0.5)
        straight = np.minimum(share, corner / (1.0 - corner) * (1.0 - share))
        g = np.where(has_corner, straight, share * (1.0 - share))
        return np.asarray(self.first + share * (self.second - self.first) - g * self.bend)


@leaf
def _is_between(corner):
    """Whether a corner lies between the two policies: elsewhere there is none."""
    return 0.0 < corner < 1.0


@leaf
def switch_at(blend, share, k, which):
    """One of the switching speeds of a blend, squared."""
    first = blend.first[k, which]
    corner = blend.corner[k, which]
    g = share * (1.0 - share)
    if _is_between(corner):
        g = min(share, corner / (1.0 - corner) * (1.0 - share))
    return first + share * (blend.second[k, which] - first) - g * blend.bend[k, which]


@leaf
def _is_held(policy):
    """Whether a line of switching has come to a station as a speed that is held, or is the envelope."""
    return policy[0] == policy[1]


@leaf
def _falls(policy):
    """Whether a line of switching falls within a cell more than a run that coasts, by its policy at the end."""
    return policy[1] > policy[0] * (1.0 + HELD)


@leaf
def falls_from_held(blend, share, k):
    """Whether the line of switching of a policy falls within cell k from a speed that is held up to there.

    Of a blend, if that is so of the policy on its side of a corner, or else of one of the two: or running times would
    jump at that one.
    """
    corner = blend.corner[k, 0]
    both = not _is_between(corner)
    held = (_is_held(blend.first[k]) and (both or share <= corner)) or (
        _is_held(blend.second[k]) and (both or share >= corner)
    )
    return held and (_falls(blend.first[k + 1]) or _falls(blend.second[k + 1]))


@part
def _match(blend, k):
    """Match the intervals of the two policies of a blend at a station; where one has none nothing bends."""
    a = blend.first[k]
    z = blend.second[k]
    if (a[4] < a[5]) != (z[4] < z[5]):
        b, e, g = matched(a[2], a[3], a[4], a[5], z[2], z[3], z[4], z[5])
        z[2], z[4], z[5] = matched(z[2], z[3], z[4], z[5], a[2], a[3], a[4], a[5])
        a[2], a[4], a[5] = b, e, g
        for i in (2, 4, 5):
            blend.bend[k, i] = 0.0


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
    policies : (E, K + 1, 4 or 6) float64
    second : int
    top : (K + 1,) float64
        Envelope at the stations, m²/s², beyond which no switching speed is known.
    blend : Blend, modified in place
    """
    first = max(second - 1, 0)
    beside = beside_of(known, first, second)
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
        for i in range(policies.shape[2]):
            which = 0 if is_held and i == 1 else i
            p0 = policies[first, k, which]
            p1 = policies[second, k, which]
            line = 0 if i == 1 else which  # a line that ends below the envelope may begin beyond it
            slopes = slopes_of(policies, beside, k, which, line, top_w)
            is_told = policies[first, k, line] < top_w
            if not is_told and policies[second, k, line] < top_w:
                told = begins if i == 0 else begins + falls if i == 1 else math.nan
                is_told = told > p0
                if is_told:
                    p0 = told
                elif not math.isnan(slopes.after):
                    p0 = max(p1 - slopes.after, p0)
            if not is_told:
                slopes = Slopes(slopes.farther_before, slopes.before, math.nan, math.nan)
            bend, corner = bent(p1 - p0, beside, slopes)
            if i == 1 and _is_between(blend.corner[k, 0]):
                bend, corner = with_line(
                    blend.corner[k, 0], policies[first, k], policies[second, k], p1 - p0, slopes.before, bend, corner
                )
            blend.first[k, i] = p0
            blend.second[k, i] = p1
            blend.bend[k, i] = bend
            blend.corner[k, i] = corner
        if policies.shape[2] > LINES:
            _match(blend, k)
