"""What stretches of a section from one timing point to the next take of its time, at each multiplier.

Told by the runs that know no windows, and moved to where a run that knows them has been found.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tgvdp.journeys.multiplier import Demand, demand_of
from tgvdp.journeys.passed import passing
from tgvdp.journeys.section import SectionRuns

_Floats = NDArray[np.float64]

#: By so much ln λ of a demand is moved at most; what is left of the way are seconds.
_MOST_MOVED = math.log(2.0)
#: Stretches of a chord, and how far apart multipliers are at least.
_CUTS, _APART = 8, 1e-9


class Stretches:
    """Stretches of one section.

    Attributes
    ----------
    section : SectionRuns
        Without windows.
    fastest_s : (parts,) float64
        Times of the stretches in the fastest run, s.
    """

    def __init__(self, section: SectionRuns, ends_m: Sequence[float]) -> None:
        self.section = section
        self._ends_m = np.array(ends_m)
        self.fastest_s = np.diff(passing(section.fastest, self._ends_m)[0], prepend=0.0)
        self._known: dict[float, _Floats] = {}

    def demands(self) -> list[Demand]:
        """What each stretch takes, of what the whole section does, as far as its runs are known."""
        whole, front = demand_of(self.section), self.section.front
        if len(self._ends_m) == 1:
            return [whole]
        own_s = np.array(
            [self._times(time_s, run) for time_s, run in zip(front.time_s.tolist(), front.source.tolist(), strict=True)]
        )
        # No stretch gives time back where the whole section takes more.
        growth_s = np.maximum(np.diff(own_s, axis=0), 0.0)
        growth_s *= (np.diff(front.time_s) / growth_s.sum(axis=1))[:, None]
        taken_s = np.concatenate((np.zeros((1, len(self._ends_m))), np.cumsum(growth_s, axis=0)))
        at_s = self.section.supplement_s
        return [Demand(np.interp(whole.supplement_s, at_s, column_s), whole.log_multiplier) for column_s in taken_s.T]

    def _times(self, time_s: float, run: int) -> _Floats:
        if time_s not in self._known:
            self._known[time_s] = np.diff(passing(self.section.profile(run), self._ends_m)[0], prepend=0.0)
        return self._known[time_s]


def through(demand: Demand, seen: Sequence[tuple[float, float]]) -> Demand:
    """A demand through supplements, s, at multipliers, J/s, that were found for it, the last ones first of all.

    Between two of them it is their chord, which ends the search for one multiplier that lies there.
    """
    kept: list[tuple[float, float]] = []
    for supplement_s, own_w in reversed(seen):
        if all((supplement_s - other_s) * (own_w - other_w) < 0.0 for other_s, other_w in kept):
            kept.append((max(supplement_s, 0.0), own_w))
    if not kept:
        return demand
    kept.sort()
    before, after = _moved(demand, *kept[0]), _moved(demand, *kept[-1])
    at_s, own = np.array(kept).T
    cut = np.linspace(0.0, len(kept) - 1.0, _CUTS * (len(kept) - 1) + 1)
    chord_s, chord = (np.interp(cut, np.arange(len(kept)), column) for column in (at_s, own))
    is_before, is_after = before.supplement_s < at_s[0], after.supplement_s > at_s[-1]
    log = np.concatenate((before.log_multiplier[is_before], np.log(chord), after.log_multiplier[is_after]))
    apart = _APART * np.arange(len(log))
    return Demand(
        np.concatenate((before.supplement_s[is_before], chord_s, after.supplement_s[is_after])),
        np.minimum.accumulate(log + apart) - apart,
    )


def _moved(demand: Demand, supplement_s: float, multiplier_j_per_s: float) -> Demand:
    """A demand through one supplement, s, at a multiplier, J/s."""
    log = math.log(multiplier_j_per_s)
    told = float(np.interp(supplement_s, demand.supplement_s, demand.log_multiplier))
    shifted = demand.log_multiplier + min(max(log - told, -_MOST_MOVED), _MOST_MOVED)
    later_s = supplement_s - float(np.interp(-log, -shifted, demand.supplement_s))
    moved_s = np.maximum(demand.supplement_s + later_s, 0.0)
    moved_s[0] = 0.0
    return Demand(moved_s, shifted)
