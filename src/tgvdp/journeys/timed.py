"""Windows between stops: the speeds at which a train passes the points that a timetable asks something of.

At such a point a section is parted in two, which share its speed there. For given speeds, which are sought on a grid
(`speeds`), the parts are the parts of a `Timetable` like any other: that plans when each section leaves and arrives.
Each section is then solved in one piece, one multiplier for each timing point (`whole`); its parts stand where no
multipliers lead into the windows, and for energies by a map.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.journeys.front import JourneyFront
from tgvdp.journeys.passed import PassedRun, PassedRuns, run_of_parts
from tgvdp.journeys.section import SectionRuns
from tgvdp.journeys.speeds import Point, Speeds, SpeedSearch
from tgvdp.journeys.timetable import Terms, earliest, planned, sample
from tgvdp.journeys.waiting import waiting_for_free, waiting_w
from tgvdp.journeys.whole import whole_run
from tgvdp.journeys.windows import Schedule, Windows
from tgvdp.model.journey import TimingPoint
from tgvdp.model.trip import Trip
from tgvdp.pareto import ParetoFront
from tgvdp.runs.fastest import fastest_run
from tgvdp.units import mps_to_kmh

_Floats = NDArray[np.float64]

#: Parts share a speed that is lower than that of the fastest run by this share: it has to be possible on both sides.
_ROUNDING = 1e-6


class _Parts:
    """The parts of a journey by the speeds at which it passes, solved when they are first asked for.

    Attributes
    ----------
    known : collection of SectionRuns
        All that were asked for.
    """

    def __init__(self, trip: Trip, windows: Windows, solved: Callable[[Trip], SectionRuns]) -> None:
        self._trip = trip
        self._windows = windows
        self._solved = solved
        self._known: dict[tuple[float, ...], SectionRuns] = {}
        self.known = self._known.values()

    def __call__(self, speeds_mps: Speeds) -> list[SectionRuns]:
        """Parts that share given speeds where the train passes.

        Raises
        ------
        InfeasibleError
            When a part cannot have its speeds.
        """
        speeds = iter(speeds_mps)
        ends = [(self._windows.departures[0].position_m, 0.0)]
        for point, dwell_s in zip(self._windows.arrivals, (*self._windows.dwells_s, 0.0), strict=True):
            ends.append((point.position_m, next(speeds) if dwell_s is None else 0.0))
        return [self._part(*first, *last) for first, last in pairwise(ends)]

    def _part(self, from_m: float, from_mps: float, to_m: float, to_mps: float) -> SectionRuns:
        key = (from_m, from_mps, to_m, to_mps)
        if key not in self._known:
            trip = replace(
                self._trip, origin_m=from_m, destination_m=to_m, start_speed_mps=from_mps, end_speed_mps=to_mps
            )
            self._known[key] = self._solved(trip)
        return self._known[key]


class TimedJourney:
    """A journey with windows: its parts by the speeds at which it passes, solved when they are first asked for.

    Parameters
    ----------
    sections : sequence of SectionRuns
        Between stops.
    trip : Trip
        The whole journey.
    windows : Windows
    solved, planned : callable
        Make the runs of a trip: as well as they can be, and well enough to choose the speeds by, in less time.

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
        self.parts = _Parts(free, windows, solved)
        self._planned_parts = _Parts(free, windows, planned)
        self._points = [
            point
            for section, parts in zip(sections, windows.sections, strict=True)
            for point in _passed(section.trip, [windows.arrivals[part] for part in parts[:-1]])
        ]

    @property
    def earliest_s(self) -> float:
        """When the journey can end at the earliest, on its clock, s.

        Raises
        ------
        InfeasibleError
            When a window closes before the fastest runs reach it.
        """
        highest_mps = tuple(point.highest_mps for point in self._points)
        return earliest(self._planned_parts(highest_mps), self.windows, 0.0).arrival.first_s

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
        terms = Terms(self.windows.opened_later(own_s), own_s, self.waiting_w)
        search = SpeedSearch(self._points, self._planned_parts, terms, arrival_s)
        search.on_grid()
        departure_s, runs, are_whole = self._solved_at(search)
        if not are_whole:  # the speeds of the grid are those of the runs
            search.around()
            departure_s, runs, _ = self._solved_at(search)
        met = sorted(search.found)
        sections = tuple(
            PassedRuns(section.trip, section.fastest, own, self.waiting_w)
            for section, own in zip(self.sections, zip(*runs, strict=True), strict=True)
        )
        first = [parts[0] for parts in self.windows.sections]
        clocks = [_clock(self.windows, begin_s, own) for begin_s, own in zip(departure_s[:, first], runs, strict=True)]
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
            complete=all(part.complete for part in (*self._planned_parts.known, *self.parts.known, *self.sections)),
            exhausted=bool(coming_s[-1, -1] < arrival_s[met[-1]] - tolerance_s),
            left=(*search.too_early(), *self.windows.left_by(leaving_s, coming_s, tolerance_s)),
        )
        return sections, found

    def _solved_at(self, search: SpeedSearch) -> tuple[_Floats, list[list[PassedRun]], bool]:
        """Solve the arrivals for which speeds were found.

        Returns
        -------
        departure_s : (n, parts) float64
            As planned, s.
        runs : list of list of PassedRun
            For each arrival those of all sections.
        are_whole : bool
            Whether all sections with points were solved in one piece, wherever the speeds of their parts are.
        """
        met = sorted(search.found)
        plan = Schedule(*np.empty((3, len(met), len(self.windows.arrivals))))
        for chosen in set(search.found.values()):
            rows = [row for row, at in enumerate(met) if search.found[at] == chosen]
            parts, arrival_s = self.parts(chosen), search.arrival_s[met][rows]
            sample(parts, search.terms, arrival_s)
            own = planned(parts, search.terms, arrival_s)
            for column, own_column in zip(plan, own, strict=True):
                column[rows] = own_column
        runs, are_whole = [], True
        last = len(self.sections) - 1
        for row, at in enumerate(met):
            parts, own_plan = self.parts(search.found[at]), Schedule(*(column[row] for column in plan))
            found = [
                self._run(number, parts, own_plan, search.arrival_s[at] if number == last else None, search.terms)
                for number in range(len(self.sections))
            ]
            runs.append([run for run, _ in found])
            are_whole &= all(is_whole for _, is_whole in found)
        return plan.departure_s, runs, are_whole

    def _run(
        self, number: int, parts: Sequence[SectionRuns], plan: Schedule, until_s: float | None, terms: Terms
    ) -> tuple[PassedRun, bool]:
        """Run of one section as planned: by parts that share speeds, or in one piece where that is cheaper.

        And whether it has been solved in one piece, if it has points at all. The last one may take until a time, s,
        when parts of these speeds save nothing any more.
        """
        section, numbers = self.sections[number], self.windows.sections[number]
        own = slice(numbers[0], numbers[-1] + 1)
        run = run_of_parts(section.trip, parts[own], plan.supplement_s[own], plan.multiplier_j_per_s[own])
        if len(numbers) == 1:
            return run, True
        if section.trip.energy.map is not None:
            return run, False
        departure_s = float(plan.departure_s[own.start])
        time_s = sum(part.fastest.duration_s for part in parts[own]) + float(plan.supplement_s[own].sum())
        points = [_since(self.windows.arrivals[at], departure_s) for at in numbers]
        ways = [(waiting_for_free(section.trip), terms.waiting_w, time_s)]
        if until_s is not None:  # who is there has not to wait, unless the last window opens later
            ways.insert(0, (section.trip, 0.0, until_s - departure_s))
        for trip, spared_w, own_s in ways:
            whole = whole_run(section, trip, points, own_s, run.multiplier_j_per_s, terms.tolerance_s)
            if whole is None:
                break
            one, is_met = whole
            multiplier = one.multiplier_j_per_s + (terms.waiting_w - spared_w)
            if is_met and one.cost_j(spared_w) < run.cost_j(spared_w):
                return one._replace(multiplier_j_per_s=multiplier), True
            run = run._replace(multiplier_j_per_s=multiplier)
            if is_met or one.ends_s[-1] >= points[-1].earliest_s - terms.tolerance_s:
                return run, is_met
        return run, False


def _since(point: TimingPoint, departure_s: float) -> TimingPoint:
    """A point with its window counted from a departure, s."""
    return point._replace(earliest_s=point.earliest_s - departure_s, latest_s=point.latest_s - departure_s)


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


def _passed(trip: Trip, points: Sequence[TimingPoint]) -> Iterator[Point]:
    """Points between two stops: no run passes them faster than the fastest one, or than is asked for."""
    # Credits of nothing make them rows of the fastest run, whose speeds are true at its rows only.
    fastest = fastest_run(replace(trip, credits=tuple((point.position_m, 0.0) for point in points)))
    for point in points:
        fastest_mps = float(np.interp(point.position_m, fastest.position_m, fastest.speed_mps))
        if fastest_mps < point.lowest_mps:
            raise InfeasibleError(
                f"journey: {point.position_m:.6g} m is to be passed at {mps_to_kmh(point.lowest_mps):.4g} km/h at"
                f" least, the fastest run has {mps_to_kmh(fastest_mps):.4g} km/h there"
            )
        highest_mps = min(fastest_mps * (1.0 - _ROUNDING), point.highest_mps)
        yield Point(point.position_m, min(point.lowest_mps, highest_mps), highest_mps)
