"""Windows between stops: at points that the train passes a timetable asks something of it.

Sections are solved in one piece (`joined`): as if nothing were asked between stops where that keeps all windows, with
one multiplier for each timing point where it does not. Where no multipliers lead into the windows, and for energies by
a map, sections are parted at their points (`parts`).
"""

from collections.abc import Callable, Collection, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.journeys.front import JourneyFront
from tgvdp.journeys.joined import JoinedSections, Timed
from tgvdp.journeys.parts import PartedSections, Parts
from tgvdp.journeys.passed import PassedRun, PassedRuns
from tgvdp.journeys.section import SectionRuns
from tgvdp.journeys.timetable import Terms
from tgvdp.journeys.waiting import waiting_for_free, waiting_w
from tgvdp.journeys.windows import Windows
from tgvdp.model.trip import Trip
from tgvdp.pareto import ParetoFront

_Floats = NDArray[np.float64]


class TimedJourney:
    """A journey with windows.

    Parameters
    ----------
    sections : sequence of SectionRuns
        Between stops.
    trip : Trip
        The whole journey.
    windows : Windows
    solved, planned : callable
        Make the runs of a trip: as well as they can be, and well enough to choose speeds by, in less time.

    Raises
    ------
    InfeasibleError
        When a point is to be passed faster than is possible.
    """

    def __init__(
        self,
        sections: Sequence[SectionRuns],
        trip: Trip,
        windows: Windows,
        solved: Callable[[Trip], SectionRuns],
        planned: Callable[[Trip], SectionRuns],
    ) -> None:
        self.sections = sections
        self.windows = windows
        self.waiting_w = waiting_w(trip)
        free = waiting_for_free(trip)
        self._known = [Parts(free, windows.at_stops, solved), *(Parts(free, windows, one) for one in (solved, planned))]
        self._joined = JoinedSections(sections, self._known[0](()), windows)
        self._parted = PartedSections(sections, windows, *self._known[1:])

    def earliest_s(self, tolerance_s: float) -> float:
        """When the journey can end at the earliest, on its clock, s, if running times are met to a tolerance, s.

        Raises
        ------
        InfeasibleError
            When a window closes before the fastest runs reach it.
        """
        return self._parted.earliest_s(tolerance_s / len(self.windows.arrivals))

    def front(self, arrival_s: _Floats, tolerance_s: float) -> tuple[tuple[PassedRuns, ...], JourneyFront]:
        """Find the front of the journey.

        Parameters
        ----------
        arrival_s : (n,) float64
            Increasing times on the journey's clock at which it may end, s.
        tolerance_s : float
            How well running times are met, s: no arrival is later.

        Returns
        -------
        sections : tuple of PassedRuns
        front : JourneyFront

        Raises
        ------
        InfeasibleError
            When a window cannot be met.
        """
        own_s = tolerance_s / len(self.windows.arrivals)
        by_arrival = self._solved(Terms(self.windows.opened_later(own_s), own_s, self.waiting_w), arrival_s)
        met = sorted(by_arrival)
        departure_s = np.array([by_arrival[at].departure_s for at in met])
        runs = [by_arrival[at].runs for at in met]
        sections = tuple(
            PassedRuns(section.trip, section.fastest, own, self.waiting_w)
            for section, own in zip(self.sections, zip(*runs, strict=True), strict=True)
        )
        first = [parts[0] for parts in self.windows.sections]
        clocks = [_clock(self.windows, begin_s, own) for begin_s, own in zip(departure_s, runs, strict=True)]
        leaving_s, coming_s = np.array(clocks).swapaxes(0, 1)
        time_s = np.sum([one.time_s for one in sections], axis=0)
        waiting_s = self.windows.waiting_s(coming_s[:, -1], time_s)
        energy_j = np.sum([one.energy_j for one in sections], axis=0) + self.waiting_w * waiting_s
        front = ParetoFront.of(time_s, energy_j)
        # Whatever is asked for behind the thriftiest journey is that journey again, but for how well its time is met.
        is_slower = np.diff(front.time_s, prepend=-np.inf) > tolerance_s
        front = ParetoFront(front.time_s[is_slower], front.energy_j[is_slower], front.source[is_slower])
        kept = front.source
        leaving_s, coming_s = leaving_s[kept], coming_s[kept]
        found = JourneyFront(
            front=front,
            run=np.repeat(kept[:, None], len(sections), axis=1),
            departure_s=leaving_s[:, first],
            multiplier_j_per_s=np.column_stack([one.multiplier_j_per_s[kept] for one in sections]),
            waiting_s=waiting_s[kept],
            waiting_w=self.waiting_w,
            practices={},
            complete=all(
                one.complete for one in (*self.sections, *(part for known in self._known for part in known.known))
            ),
            exhausted=bool(coming_s[-1, -1] < arrival_s[met[-1]] - tolerance_s),
            left=(*_too_early(by_arrival, arrival_s), *self.windows.left_by(leaving_s, coming_s, tolerance_s)),
        )
        return sections, found

    def _solved(self, terms: Terms, arrival_s: _Floats) -> dict[int, Timed]:
        """Journeys by the numbers of their arrivals, s; not where those are too early."""
        found = self._joined.unbound(terms, arrival_s)
        for at, end_s in enumerate(arrival_s.tolist()):
            if at not in found and (bound := self._joined.bound(terms, end_s)) is not None:
                found[at] = bound
        left = np.array([at for at in range(len(arrival_s)) if at not in found], dtype=np.int64)
        if len(left):
            try:
                parted = self._parted.found(terms, arrival_s[left])
            except InfeasibleError:  # they are too early where there are others
                if not found:
                    raise
            else:
                found |= {int(left[at]): one for at, one in parted.items()}
        return found


def _too_early(found: Collection[int], arrival_s: _Floats) -> Iterator[str]:
    """Say which arrivals, s, are not among those that were found."""
    if missing := [time_s for at, time_s in enumerate(arrival_s.tolist()) if at not in found]:
        yield (
            f"no journey was found that keeps all windows and ends by {missing[-1]:.6g} s: missing points:"
            f" {len(missing)}"
        )


def _clock(windows: Windows, departure_s: _Floats, runs: Sequence[PassedRun]) -> tuple[_Floats, _Floats]:
    """Departures and arrivals of all parts, s, of runs that are a little faster than planned.

    The train waits for that at the stop before, as far as the window there lets it: it comes as planned.
    """
    leaving, coming = [], []
    for parts, planned_s, run in zip(windows.sections, departure_s.tolist(), runs, strict=True):
        start_s = max(planned_s, min(planned_s + run.spare_s, windows.departures[parts[0]].latest_s))
        coming.append(start_s + run.ends_s)
        leaving.append(start_s + np.append(0.0, run.ends_s[:-1]))
    return np.concatenate(leaving), np.concatenate(coming)
