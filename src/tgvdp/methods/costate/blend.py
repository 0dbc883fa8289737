"""Policies between those of two extremals: switching speeds are quadratic in ln λ, by the extremals beside them."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import entry, leaf
from tgvdp.methods.costate.extremal import Extremal

#: Extremals nearer than this, in distances of the two whose policies are blended, tell no bend.
_APART = 1e-3


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


@entry
def _bend(before_at, before, after_at, after, top, blend):
    """Fill in the bend of a blend by policies beside it, at ``before_at`` < 0 and ``after_at`` > 1; nan where none is.

    The switching speed of the second policy and the one after it tell how far that of the first lies beyond the
    envelope, where it ends at ``top``.
    """
    for k in range(top.shape[0]):
        for i in range(4):
            p1 = blend.second[k, i]
            if after_at == after_at and blend.first[k, i] >= top[k] > p1:
                lifted = p1 + (p1 - after[k, i]) / (after_at - 1.0)
                blend.first[k, i] = max(lifted, blend.first[k, i])
            p0 = blend.first[k, i]
            step = p1 - p0
            bend = 0.0
            count = 0
            if before_at == before_at and before[k, i] < top[k]:
                bend += (before[k, i] - p0 - before_at * step) / (before_at * (before_at - 1.0))
                count += 1
            if after_at == after_at and p0 < top[k]:
                bend += (after[k, i] - p0 - after_at * step) / (after_at * (after_at - 1.0))
                count += 1
            most = abs(step)
            blend.bend[k, i] = min(max(bend / max(count, 1), -most), most)


def blend_of(first: Extremal, second: Extremal, known: Sequence[Extremal], top_w: NDArray[np.float64]) -> Blend:
    """Blend of the policies of two extremals.

    Parameters
    ----------
    first, second : Extremal
        Of falling multipliers.
    known : sequence of Extremal
        Finite multipliers, among them those beside the two, in the order of their running times.
    top_w : (K + 1,) float64
        Envelope at the stations, m²/s², beyond which no switching speed is known.
    """
    blend = Blend(first.switch.copy(), second.switch, np.zeros(first.switch.shape))
    if math.isfinite(first.multiplier):
        span = math.log(second.multiplier / first.multiplier)
        before = after = (math.nan, first.switch)
        for one in known:
            at = math.log(one.multiplier / first.multiplier) / span
            if at < -_APART:
                before = at, one.switch
            elif at > 1.0 + _APART:
                after = at, one.switch
                break
        _bend(*before, *after, top_w, blend)
    return blend
