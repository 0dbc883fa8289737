"""From runs to a timetable: sections are sampled as far as windows let them take time, and solved as it is planned."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.journeys.front import ROUNDS, reach
from tgvdp.journeys.multiplier import Demand, demand_of
from tgvdp.journeys.section import SectionRuns
from tgvdp.journeys.slower import slow_down
from tgvdp.journeys.windows import Miss, Schedule, Timetable, TooFastError, Windows

_Floats = NDArray[np.float64]

#: Supplements up to this share of the fastest running time are sampled first, at so many times, closer where steeper.
_FIRST_MARGIN, _SAMPLES = 0.5, 12
#: ... and up to this share at most.
_MOST_MARGIN = 8.0
#: What takes any time, s.
_ANY_TIME = Demand(np.array([0.0, 1e9]), np.array([1.0, 0.0]))
#: A section that takes this share of what is known of its front may take more.
_AT_THE_END = 0.98


class Terms(NamedTuple):
    """What a journey is planned by: its windows, how well times are met, s, and what is drawn in waiting, W.

    Energies of sections are less what would be drawn in waiting for as long as they run.
    """

    windows: Windows
    tolerance_s: float
    waiting_w: float

    def timetable(self, sections: Sequence[SectionRuns]) -> Timetable:
        """The timetable of sections, as far as their runs are known."""
        fastest_s = [section.fastest.duration_s for section in sections]
        demands = [demand_of(section) for section in sections]
        return Timetable(self.windows, fastest_s, demands, self.tolerance_s, self.waiting_w)


def earliest(sections: Sequence[SectionRuns], windows: Windows, slack_s: float) -> Timetable:
    """The timetable of sections that may take any time, which tells when each window is reached at the earliest.

    Raises
    ------
    WindowMissedError
        When a window closes before that.
    """
    fastest_s = [section.fastest.duration_s for section in sections]
    return Timetable(windows, fastest_s, [_ANY_TIME] * len(fastest_s), slack_s)


def planned(sections: Sequence[SectionRuns], terms: Terms, arrival_s: _Floats) -> Schedule:
    """Plan arrivals, s, in rounds: each solves the sections as the last one planned, and knows multipliers better."""
    for _ in range(ROUNDS):
        plan = terms.timetable(sections).at(arrival_s)
        reach(sections, plan.supplement_s, terms.tolerance_s)
        wait(sections, terms, plan.supplement_s)
    return plan


def sample(sections: Sequence[SectionRuns], terms: Terms, arrival_s: _Floats) -> None:
    """Sample the sections' fronts as far as the windows let them take time, where that is not done yet."""
    shares = np.linspace(0.0, 1.0, _SAMPLES) ** 2
    fastest_s = np.array([section.fastest.duration_s for section in sections])
    new = [section for section in sections if not len(section.front)]
    if new:
        reach(new, np.outer(shares, [_FIRST_MARGIN * one.fastest.duration_s for one in new]), terms.tolerance_s)
    while True:
        known_s = np.array([one.supplement_s[-1] for one in sections])
        may_grow = np.array([not one.exhausted and one.complete for one in sections])
        may_grow &= known_s < _MOST_MARGIN * fastest_s
        taken_s = terms.timetable(sections).at(arrival_s).supplement_s.max(axis=0)
        short = np.flatnonzero(may_grow & (taken_s >= _AT_THE_END * known_s)).tolist()
        if not short:
            return
        further_s = 2.0 * np.maximum(known_s, _FIRST_MARGIN * fastest_s)
        reach([sections[at] for at in short], np.outer(shares, further_s[short]), terms.tolerance_s)


def wait(sections: Sequence[SectionRuns], terms: Terms, supplement_s: _Floats) -> None:
    """Find the runs that are slower than the thriftiest ones for planned supplements, (n, sections), s.

    Raises
    ------
    TooFastError
        When sections cannot be that slow.
    """
    tolerance_s, misses = terms.tolerance_s, []
    for section, window, own_s in zip(sections, terms.windows.arrivals, supplement_s.T, strict=True):
        behind_s = own_s[own_s > section.supplement_s[-1] + tolerance_s]
        for slow_s in np.unique(behind_s).tolist():
            if section.complete and not slow_down(section, slow_s, tolerance_s):
                missed_s = slow_s - float(section.supplement_s[-1])
                which = f"{terms.windows.told(window)} opens {missed_s:.6g} s after the slowest run found"
                misses.append(Miss(which, missed_s, "opens so much earlier"))
                break
    if misses:
        raise TooFastError(misses)
