"""The front of a journey with windows at its stops: least energy for each arrival at its end."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.journeys.front import ROUNDS, JourneyFront, Search, reach
from tgvdp.journeys.multiplier import Demand, demand_of
from tgvdp.journeys.section import SectionRuns
from tgvdp.journeys.windows import Schedule, Timetable, Windows
from tgvdp.pareto import ParetoFront

_Floats = NDArray[np.float64]

#: Supplements up to this share of the fastest running time are sampled first, at so many times, closer where steeper.
_FIRST_MARGIN, _SAMPLES = 0.5, 32
#: ... and up to this share at most.
_MOST_MARGIN = 8.0
#: A section that takes this share of what is known of its front may take more.
_AT_THE_END = 0.98
#: What takes any time, s: for whether windows can be met at all before a section is solved.
_ANY_TIME = Demand(np.array([0.0, 1e9]), np.array([1.0, 0.0]))


def earliest_arrival_s(sections: Sequence[SectionRuns], windows: Windows) -> float:
    """When the journey can end at the earliest, on its clock, s.

    Raises
    ------
    InfeasibleError
        When a window closes before the fastest runs reach it.
    """
    fastest_s = [section.fastest.duration_s for section in sections]
    return Timetable(windows, fastest_s, [_ANY_TIME] * len(sections), 0.0).arrival.first_s


def timetable_front(
    sections: Sequence[SectionRuns], windows: Windows, arrival_s: _Floats, tolerance_s: float
) -> JourneyFront:
    """Find the front of a journey with windows.

    Parameters
    ----------
    sections : sequence of SectionRuns
        New ones: their runs are found here.
    windows : Windows
    arrival_s : (n,) float64
        Increasing times on the journey's clock at which it may end, s.
    tolerance_s : float
        How well running times are met, s: no arrival is later.

    Raises
    ------
    InfeasibleError
        When a window cannot be met.
    """
    own_s = tolerance_s / len(sections)
    # Runs are earlier than their times by the tolerance at most.
    windows = windows._replace(
        arrivals=tuple(one._replace(earliest_s=min(one.earliest_s + own_s, one.latest_s)) for one in windows.arrivals)
    )
    _sample(sections, windows, arrival_s, own_s)
    for _ in range(ROUNDS):
        schedule = _schedule(sections, windows, arrival_s, own_s)
        reach(sections, schedule.supplement_s, own_s)
    found = Search(sections, schedule.supplement_s.sum(axis=1), own_s).allocations(schedule.supplement_s)
    front = ParetoFront.of(found.time_s, found.energy_j)
    kept = front.source
    return JourneyFront(
        front=front,
        run=found.run[kept],
        departure_s=schedule.departure_s[kept],
        multiplier_j_per_s=schedule.multiplier_j_per_s[kept],
        practices={},
        complete=all(section.complete for section in sections),
        exhausted=False,
    )


def _schedule(sections: Sequence[SectionRuns], windows: Windows, arrival_s: _Floats, slack_s: float) -> Schedule:
    fastest_s = [section.fastest.duration_s for section in sections]
    return Timetable(windows, fastest_s, [demand_of(section) for section in sections], slack_s).at(arrival_s)


def _sample(sections: Sequence[SectionRuns], windows: Windows, arrival_s: _Floats, tolerance_s: float) -> None:
    """Sample the sections' fronts as far as the windows let them take time."""
    fastest_s = np.array([section.fastest.duration_s for section in sections])
    margin = np.full(len(sections), _FIRST_MARGIN)
    while True:
        reach(sections, np.outer(np.linspace(0.0, 1.0, _SAMPLES) ** 2, margin * fastest_s), tolerance_s)
        may_grow = np.array([not one.exhausted and one.complete for one in sections]) & (margin < _MOST_MARGIN)
        try:
            taken_s = _schedule(sections, windows, arrival_s, tolerance_s).supplement_s.max(axis=0)
        except InfeasibleError:  # a window opens later than any run known arrives
            if not may_grow.any():
                raise
            taken_s = np.full(len(sections), np.inf)
        short = may_grow & (taken_s >= _AT_THE_END * np.array([one.supplement_s[-1] for one in sections]))
        if not short.any():
            return
        margin[short] *= 2.0
