"""One multiplier for all sections: what each of them gets of a common supplement.

Where the fronts are convex the best split gives every section the same multiplier λ, the energy that one more second
saves: otherwise a second would save more elsewhere (Everett, 1963, Operations Research 11:399–417). A front's lower
convex hull and the multipliers of its runs tell what the section takes at each λ.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.journeys.section import SectionRuns

_Floats = NDArray[np.float64]

#: Between the fastest run and the next one λ falls from infinity by a power law; steps of a factor 4 along it.
_GRADED = 4.0 ** -np.arange(8, 0, -1)
#: Its exponent is kept off the two ends, where λ or the energy would not be finite.
_LEAST_EXPONENT, _MOST_EXPONENT = 0.05, 0.95
#: Multipliers of two neighbours differ at least by this share: each has one supplement.
_APART = 1e-9
#: Multipliers below this share of the largest finite one are none.
_NONE = 1e-9


class Demand(NamedTuple):
    """What a section takes: supplements, s, increasing, and ln λ at each, decreasing; linear in between."""

    supplement_s: _Floats
    log_multiplier: _Floats

    def at(self, log_multiplier: _Floats) -> _Floats:
        """Supplement at given ln λ, s."""
        return np.interp(-log_multiplier, -self.log_multiplier, self.supplement_s)


def on_hull(time_s: _Floats, energy_j: _Floats) -> NDArray[np.int64]:
    """Indices of the points of a front that are vertices of its lower convex hull."""
    kept: list[int] = []
    times, energies = time_s.tolist(), energy_j.tolist()
    for index, (time, energy) in enumerate(zip(times, energies, strict=True)):
        while len(kept) > 1:
            first, last = kept[-2:]
            rise = (energies[last] - energies[first]) * (time - times[first])
            if rise < (energy - energies[first]) * (times[last] - times[first]):
                break
            kept.pop()
        kept.append(index)
    return np.array(kept, dtype=np.int64)


def demand_of(section: SectionRuns) -> Demand:
    """What a section takes at each multiplier, as far as its runs are known."""
    hull = on_hull(section.front.time_s, section.front.energy_j)
    supplement_s, energy_j = section.supplement_s[hull], section.front.energy_j[hull]
    if len(hull) == 1:
        return Demand(np.zeros(2), np.array([1.0, 0.0]))
    # A multiplier lies between the slopes on both sides of its run.
    slope = -np.diff(energy_j) / np.diff(supplement_s)
    multiplier = np.clip(section.multiplier_j_per_s[section.front.source[hull]][1:], np.append(slope[1:], 0.0), slope)
    multiplier = np.maximum(multiplier, _NONE * slope[0])
    exponent = 1.0 - multiplier[0] / slope[0]
    exponent = min(max(exponent, _LEAST_EXPONENT), _MOST_EXPONENT)
    first_s = supplement_s[1] * _GRADED
    supplement_s, multiplier = _with_bends(supplement_s[1:], multiplier, slope[1:])
    log = np.concatenate((math.log(multiplier[0]) - exponent * np.log(_GRADED), np.log(multiplier)))
    supplement_s = np.concatenate((first_s, supplement_s))
    apart = _APART * np.arange(len(log))
    log = np.minimum.accumulate(log + apart) - apart
    return Demand(np.concatenate(([0.0], supplement_s)), np.concatenate(([log[0] + 1.0], log)))


def _with_bends(supplement_s: _Floats, multiplier: _Floats, slope: _Floats) -> tuple[_Floats, _Floats]:
    """Between two runs, where their tangents meet, the multiplier is the slope of their chord.

    So the multipliers between them save what lies between their energies, and know a front that bends next to one of
    them: evenly falling ones led to its other end round by round.
    """
    fall = -np.diff(multiplier)
    share = np.divide(slope - multiplier[1:], fall, out=np.full(len(fall), 0.5), where=fall > 0.0).clip(0.0, 1.0)
    met_s = supplement_s[:-1] + share * np.diff(supplement_s)
    between = np.arange(1, len(supplement_s))
    return np.insert(supplement_s, between, met_s), np.insert(multiplier, between, np.maximum(slope, multiplier[1:]))


class Split(NamedTuple):
    """Supplements of each section, s, (n, sections), and the multiplier of each split, J/s, (n,)."""

    supplement_s: _Floats
    multiplier_j_per_s: _Floats


def split(demands: Sequence[Demand], total_s: _Floats) -> Split:
    """Split total supplements, s, so that all sections run at one multiplier; more than all can take is not given."""
    log = np.unique(np.concatenate([demand.log_multiplier for demand in demands]))[::-1]
    taken_s = np.sum([demand.at(log) for demand in demands], axis=0)
    at = np.interp(total_s, taken_s, log)
    multiplier = np.where(total_s > 0.0, np.exp(at), np.inf)
    return Split(np.column_stack([demand.at(at) for demand in demands]), multiplier)
