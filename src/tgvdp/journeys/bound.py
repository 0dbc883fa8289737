"""A certificate for journeys: the sections' bounds added up at one multiplier each.

Each line E ≥ c − μT of a section's certificate holds for all of its runs, and so do mixtures of two lines; as no run is
faster than the fastest one, F, it stays true with a larger multiplier: E ≥ c + (λ − μ)·F − λT. Of all these c(λ) is the
best for a multiplier λ. Added over the sections, E ≥ Σ c_i(λ) − λT bounds every split of a journey's time T.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.certificate.front import Certificate
from tgvdp.journeys.multiplier import on_hull

_Floats = NDArray[np.float64]

#: Sums of a few hundred roundings, relative to the largest of their terms.
_ROUNDING = 1e-13
#: Running times that are nearer to the fastest one, relative to it, are that one.
_SAME_TIME = 1e-9


class JourneyBound(NamedTuple):
    """Lower bounds of the least energy of a journey at given running times, J, and whether they were worked out whole.

    The bound is NaN where nothing is known.
    """

    lower_bound_j: _Floats
    complete: bool

    def gap_pct(self, energy_j: _Floats) -> _Floats:
        """How far energies are above their bounds, in percent of them."""
        return np.asarray(100.0 * (energy_j - self.lower_bound_j) / np.abs(energy_j))


def journey_bound(certificates: Sequence[Certificate], time_s: _Floats) -> JourneyBound:
    """Bound the least energy of all sections together.

    Parameters
    ----------
    certificates : sequence of Certificate
        Of the sections.
    time_s : (n,) float64
        Running times of the journey without dwell, s.
    """
    complete = all(one.complete for one in certificates)
    if any(len(one.line_j) == 0 for one in certificates):
        return JourneyBound(np.full(len(time_s), math.nan), complete)
    multiplier = np.unique(np.concatenate([one.multiplier_j_per_s for one in certificates]))
    parts_j = [_best_lines(one, multiplier) for one in certificates]
    line_j = np.sum(parts_j, axis=0)
    cost_j = multiplier[:, None] * time_s
    rounding_j = _ROUNDING * (np.sum(np.abs(parts_j), axis=0)[:, None] + cost_j)
    lower_j = np.max(line_j[:, None] - cost_j - rounding_j, axis=0)
    lower_j[np.isneginf(lower_j)] = math.nan
    # No section is faster than its fastest run, and none is as fast.
    fastest_s = sum(one.fastest_s for one in certificates)
    lower_j[time_s <= fastest_s * (1.0 + _SAME_TIME)] = sum(one.fastest_j for one in certificates)
    return JourneyBound(lower_j, complete)


def _best_lines(certificate: Certificate, multiplier: _Floats) -> _Floats:
    """c(λ) of a section for increasing multipliers, J; −∞ below its least one."""
    order = np.lexsort((-certificate.line_j, certificate.multiplier_j_per_s))
    own, line_j = certificate.multiplier_j_per_s[order], certificate.line_j[order]
    first = np.concatenate(([True], np.diff(own) > 0.0))
    own, line_j = own[first], line_j[first]
    hull = on_hull(own, -line_j)
    mixed_j = np.interp(multiplier, own[hull], line_j[hull], left=-math.inf, right=-math.inf)
    rays_j = line_j[hull] + (multiplier[:, None] - own[hull]) * certificate.fastest_s
    rays_j[multiplier[:, None] < own[hull]] = -math.inf
    return np.asarray(np.maximum(mixed_j, rays_j.max(axis=1)))
