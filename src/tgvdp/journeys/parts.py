"""Sections parted at their timing points, where the parts share the speeds at which the train passes.

For given speeds, which are sought on a grid (`speeds`), the parts are the parts of a `Timetable` like any other. Each
section is then solved in one piece as that planned it, and its parts stand where no multipliers lead into the windows,
and for energies by a map.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.journeys.front import reach
from tgvdp.journeys.joined import Timed, in_one_piece, points_since
from tgvdp.journeys.passed import PassedRun, run_of_parts
from tgvdp.journeys.section import SectionRuns
from tgvdp.journeys.speeds import Point, Speeds, SpeedSearch
from tgvdp.journeys.timetable import Terms, earliest, planned, wait
from tgvdp.journeys.windows import Schedule, Windows
from tgvdp.model.journey import TimingPoint
from tgvdp.model.trip import Trip
from tgvdp.runs.fastest import fastest_run
from tgvdp.units import mps_to_kmh

_Floats = NDArray[np.float64]

#: Parts share a speed that is lower than that of the fastest run by this share: it has to be possible on both sides.
_ROUNDING = 1e-6


class Parts:
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


class PartedSections:
    """The parts of a journey with windows, by the speeds at which it passes.

    Parameters
    ----------
    sections : sequence of SectionRuns
        Between stops.
    windows : Windows
    solved, planned : Parts
        As well as they can be, and well enough to choose the speeds by, in less time.

    Raises
    ------
    InfeasibleError
        When a point is to be passed faster than is possible.
    """

    def __init__(self, sections: Sequence[SectionRuns], windows: Windows, solved: Parts, planned: Parts) -> None:
        self.sections = sections
        self.windows = windows
        self.parts = solved
        self._planned_parts = planned
        self._points = [
            list(_passed(section.trip, [windows.arrivals[part] for part in parts[:-1]]))
            for section, parts in zip(sections, windows.sections, strict=True)
        ]

    def earliest_s(self, slack_s: float) -> float:
        """When the journey can end at the earliest, on its clock, s, if windows may be missed by a slack, s.

        Raises
        ------
        InfeasibleError
            When a window closes before the fastest runs reach it.
        """
        highest_mps = tuple(point.highest_mps for own in self._points for point in own)
        first_s = earliest(self._planned_parts(highest_mps), self.windows, slack_s).arrival.first_s
        return min(first_s, self.windows.arrivals[-1].latest_s)

    def found(self, terms: Terms, arrival_s: _Floats) -> dict[int, Timed]:
        """Journeys by the numbers of their arrivals, s; not where those are too early.

        Raises
        ------
        InfeasibleError
            When a window cannot be met.
        """
        search = SpeedSearch(self._points, self._planned_parts, terms, arrival_s)
        search.on_grid()
        found, are_whole = self._solved_at(search)
        if not are_whole:  # the speeds of the grid are those of the runs
            search.around()
            found, _ = self._solved_at(search)
        return found

    def _solved_at(self, search: SpeedSearch) -> tuple[dict[int, Timed], bool]:
        """Solve the arrivals for which speeds were found.

        And whether all sections with points were solved in one piece, wherever the speeds of their parts are.
        """
        first = [parts[0] for parts in self.windows.sections]
        last = len(self.sections) - 1
        found, are_whole = {}, True
        for chosen in set(search.found.values()):
            numbers = [at for at, own in search.found.items() if own == chosen]
            arrival_s = search.arrival_s[np.sort(numbers)]
            # The fronts by which speeds were chosen tell who gets the time, too: what is solved well is what that asks.
            plan = planned(self._planned_parts(chosen), search.terms, arrival_s)
            parts = self.parts(chosen)
            reach(parts, np.concatenate((np.zeros((1, len(parts))), plan.supplement_s)), search.terms.tolerance_s)
            wait(parts, search.terms, plan.supplement_s)
            for at, end_s, row in zip(sorted(numbers), arrival_s.tolist(), map(Schedule, *plan), strict=True):
                runs = [
                    self._run(number, parts, row, end_s if number == last else None, search.terms)
                    for number in range(len(self.sections))
                ]
                found[at] = Timed(row.departure_s[first], [run for run, _ in runs])
                are_whole &= all(is_whole for _, is_whole in runs)
        return found, are_whole

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
        points = points_since(self.windows, number, departure_s)
        left_s = None if until_s is None else until_s - departure_s
        whole = in_one_piece(section, points, time_s, left_s, run.multiplier_j_per_s, terms)
        if whole is None:
            return run, False
        if whole.is_met and whole.run.cost_j(whole.spared_w) < run.cost_j(whole.spared_w):
            return whole.run, True
        return run._replace(multiplier_j_per_s=whole.run.multiplier_j_per_s), whole.is_met


def _passed(trip: Trip, points: Sequence[TimingPoint]) -> Iterator[Point]:
    """Points between two stops: no run passes them faster than the fastest one that keeps what is asked for at all."""
    # By so much faster that their shared speeds are those that are asked for.
    fastest = fastest_run(trip, [(point.position_m, point.highest_mps / (1.0 - _ROUNDING)) for point in points])
    for point in points:
        fastest_mps = float(np.interp(point.position_m, fastest.position_m, fastest.speed_mps))
        if fastest_mps < point.lowest_mps:
            raise InfeasibleError(
                f"journey: {point.position_m:.6g} m is to be passed at {mps_to_kmh(point.lowest_mps):.4g} km/h at"
                f" least, the fastest run has {mps_to_kmh(fastest_mps):.4g} km/h there"
            )
        highest_mps = min(fastest_mps * (1.0 - _ROUNDING), point.highest_mps)
        yield Point(point.position_m, min(point.lowest_mps, highest_mps), highest_mps)
