"""Windows between stops: the speeds at which a train passes the points that a timetable asks something of.

At such a point a section is parted in two, which share its speed there. For given speeds the parts are the parts of a
`Timetable` like any other, one multiplier between two binding windows; the speeds themselves are sought one after the
other on grids that become finer, for each arrival of its own.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.journeys.front import JourneyFront
from tgvdp.journeys.multiplier import Demand
from tgvdp.journeys.section import SectionRuns
from tgvdp.journeys.timetable import planned, sample, timetable_of
from tgvdp.journeys.windows import Timetable, WindowMissedError, Windows
from tgvdp.model.journey import TimingPoint
from tgvdp.model.trip import Trip
from tgvdp.pareto import ParetoFront
from tgvdp.runs.profile import Profile, profile_of
from tgvdp.units import mps_to_kmh

_Floats = NDArray[np.float64]
Speeds = tuple[float, ...]

#: Speeds tried for each point, then around the best of them at a finer distance, so often.
_SPEEDS, _FINER, _LEVELS = 8, 4, 2
#: Lowest speed tried, as a share of the highest possible.
_LOWEST = 0.25
#: What takes any time, s: for whether windows can be met at all before anything is solved.
_ANY_TIME = Demand(np.array([0.0, 1e9]), np.array([1.0, 0.0]))


class PassedRuns:
    """Runs of one section that is parted where it passes, one for each arrival.

    Attributes
    ----------
    trip, fastest
        As of `SectionRuns`.
    time_s, energy_j, multiplier_j_per_s : (n,) float64
        Running times, s, energies, J, and the multiplier of the last part, J/s.
    """

    def __init__(self, trip: Trip, fastest: Profile, runs: Sequence[Sequence[tuple[SectionRuns, int]]]) -> None:
        self.trip = trip
        self.fastest = fastest
        self._runs = runs
        self.time_s = np.array([sum(part.time_s[run] for part, run in parts) for parts in runs])
        self.energy_j = np.array([sum(part.energy_j[run] for part, run in parts) for parts in runs])
        self.multiplier_j_per_s = np.array([parts[-1][0].multiplier_j_per_s[parts[-1][1]] for parts in runs])

    def profile(self, index: int) -> Profile:
        """Speed profile of one run."""
        columns: list[tuple[_Floats, _Floats, NDArray[np.int8]]] = []
        for part, run in self._runs[index]:
            x_m, w, regime = part.rows(run)
            first = 1 if columns else 0  # where a part begins the one before it ends
            columns.append((x_m[first:] + (part.trip.origin_m - self.trip.origin_m), w[first:], regime))
        return profile_of(self.trip, *map(np.concatenate, zip(*columns, strict=True)))


class TimedJourney:
    """A journey with windows: its parts by the speeds at which it passes, solved when they are first asked for.

    Parameters
    ----------
    sections : sequence of SectionRuns
        Between stops.
    trip : Trip
        The whole journey.
    windows : Windows
    solved : callable
        Makes the runs of a trip.

    Raises
    ------
    InfeasibleError
        When a point is to be passed faster than is possible.
    """

    def __init__(
        self, sections: Sequence[SectionRuns], trip: Trip, windows: Windows, solved: Callable[[Trip], SectionRuns]
    ) -> None:
        self.sections = sections
        self.windows = windows
        self._trip = trip
        self._solved = solved
        self._known: dict[tuple[float, ...], SectionRuns] = {}
        self._passed = [
            (windows.arrivals[part], section)
            for section, parts in zip(sections, windows.sections, strict=True)
            for part in parts[:-1]
        ]
        self.highest_mps = tuple(_highest_mps(point, section) for point, section in self._passed)

    def parts(self, speeds_mps: Speeds) -> list[SectionRuns]:
        """Parts that share given speeds where the train passes.

        Raises
        ------
        InfeasibleError
            When a part cannot have its speeds.
        """
        speeds = iter(speeds_mps)
        ends = [(self.windows.departures[0].position_m, 0.0)]
        for point, dwell_s in zip(self.windows.arrivals, (*self.windows.dwells_s, 0.0), strict=True):
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

    @property
    def earliest_s(self) -> float:
        """When the journey can end at the earliest, on its clock, s.

        Raises
        ------
        InfeasibleError
            When a window closes before the fastest runs reach it.
        """
        fastest_s = [part.fastest.duration_s for part in self.parts(self.highest_mps)]
        return Timetable(self.windows, fastest_s, [_ANY_TIME] * len(fastest_s), 0.0).arrival.first_s

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
        windows = self.windows.opened_later(own_s)
        speeds = self._best(windows, arrival_s, own_s)
        met = sorted(speeds)
        shape = len(arrival_s), len(windows.arrivals)
        departure_s, supplement_s, multiplier = np.empty((3, *shape))
        for chosen in set(speeds.values()):
            rows = [at for at in met if speeds[at] == chosen]
            plan = planned(self.parts(chosen), windows, arrival_s[rows], own_s)
            departure_s[rows], supplement_s[rows], multiplier[rows] = plan
        # Only now, as groups of speeds share parts, whose runs are numbered anew when more are found.
        runs = [
            [
                (part, int(part.slowest_within(taken_s)))
                for part, taken_s in zip(self.parts(speeds[at]), supplement_s[at], strict=True)
            ]
            for at in met
        ]
        sections = [
            PassedRuns(section.trip, section.fastest, [[own[part] for part in parts] for own in runs])
            for section, parts in zip(self.sections, windows.sections, strict=True)
        ]
        front = ParetoFront.of(
            np.sum([one.time_s for one in sections], axis=0), np.sum([one.energy_j for one in sections], axis=0)
        )
        kept = front.source
        driven = [self._driven(departure_s[met[at]], supplement_s[met[at]], runs[at]) for at in kept.tolist()]
        leaving_s, coming_s = np.array(driven).swapaxes(0, 1)
        found = JourneyFront(
            front=front,
            run=np.repeat(kept[:, None], len(sections), axis=1),
            departure_s=leaving_s[:, [parts[0] for parts in windows.sections]],
            multiplier_j_per_s=multiplier[met][kept][:, [parts[-1] for parts in windows.sections]],
            practices={},
            complete=all(part.complete for part in self._known.values()),
            exhausted=False,
            left=self.windows.left_by(leaving_s, coming_s, tolerance_s),
        )
        return tuple(sections), found

    def _driven(
        self, departure_s: _Floats, supplement_s: _Floats, runs: Sequence[tuple[SectionRuns, int]]
    ) -> tuple[_Floats, _Floats]:
        """Departures and arrivals of all parts, s, of runs that are a little faster than planned.

        The train waits for that at the stop before, as far as the window there lets it: it comes as planned.
        """
        planned_s = supplement_s + [part.fastest.duration_s for part, _ in runs]
        own_s = np.array([part.time_s[run] for part, run in runs])
        departure_s = departure_s.copy()
        for parts in self.windows.sections:
            first = parts[0]
            waited_s = departure_s[first] + planned_s[first] - own_s[first]
            departure_s[first] = max(departure_s[first], min(waited_s, self.windows.departures[first].latest_s))
            for part in parts[1:]:
                departure_s[part] = departure_s[part - 1] + own_s[part - 1]
        return departure_s, departure_s + own_s

    def _best(self, windows: Windows, arrival_s: _Floats, tolerance_s: float) -> dict[int, Speeds]:
        """The speeds of least energy by the number of the arrival, s; not where those that were tried are too slow."""
        found: dict[int, Speeds] = {}
        least_j = np.full(len(arrival_s), np.inf)
        refusals: list[InfeasibleError] = []

        def attempt(speeds: Speeds) -> None:
            try:
                energy_j = self._energy_j(speeds, windows, arrival_s, tolerance_s)
            except InfeasibleError as error:
                refusals.append(error)
                return
            for at in np.flatnonzero(energy_j < least_j).tolist():
                found[at], least_j[at] = speeds, energy_j[at]

        attempt(self.highest_mps)
        for level in range(_LEVELS):
            for place, (point, _) in enumerate(self._passed):
                high = self.highest_mps[place]
                low = min(max(point.lowest_mps, _LOWEST * high), high)
                step = (high - low) / (_SPEEDS - 1) / _FINER**level
                steps = np.arange(-_SPEEDS, _SPEEDS + 1) if level == 0 else np.arange(1 - _FINER, _FINER)
                for speeds in set(found.values()) or {self.highest_mps}:
                    for speed in np.unique(np.clip(speeds[place] + step * steps, low, high)).tolist():
                        attempt((*speeds[:place], speed, *speeds[place + 1 :]))
        if not found:
            raise min(refusals, key=lambda one: one.missed_s if isinstance(one, WindowMissedError) else np.inf)
        return found

    def _energy_j(self, speeds: Speeds, windows: Windows, arrival_s: _Floats, tolerance_s: float) -> _Floats:
        """Energy of the journey for each arrival, as far as the parts' fronts are sampled, J; infinite if too early."""
        parts = self.parts(speeds)
        sample(parts, windows, arrival_s, tolerance_s)
        timetable = timetable_of(parts, windows, tolerance_s)
        taken_s = timetable.at(arrival_s).supplement_s
        energy_j = np.sum(
            [
                np.interp(own_s, one.supplement_s, one.front.energy_j)
                for one, own_s in zip(parts, taken_s.T, strict=True)
            ],
            axis=0,
        )
        return np.where(arrival_s >= timetable.arrival.first_s - tolerance_s, energy_j, np.inf)


def _highest_mps(point: TimingPoint, section: SectionRuns) -> float:
    """Highest speed at which a point can be passed, m/s: that of the fastest run, or what is asked for."""
    fastest = section.fastest
    w = float(np.interp(point.position_m, fastest.position_m, fastest.speed_mps**2))
    if np.sqrt(w) < point.lowest_mps:
        raise InfeasibleError(
            f"journey: {point.position_m:.6g} m is to be passed at {mps_to_kmh(point.lowest_mps):.4g} km/h at least,"
            f" the fastest run has {mps_to_kmh(float(np.sqrt(w))):.4g} km/h there"
        )
    return min(float(np.sqrt(w)), point.highest_mps)
