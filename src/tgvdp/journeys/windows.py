"""Windows of time: when a timetable wants the train to arrive, to depart and to pass.

Between two binding windows the sections run at one multiplier, as without windows; at a binding one it changes. Both
follow from the least energy of all that lies before a stop as a function of the time on its clock. It is convex where
fronts are, and told by the multipliers at which later times save energy: a further section merges its own (`Demand`)
in their order, a window cuts off what lies outside, and waiting adds time that saves nothing.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.journeys.multiplier import Demand
from tgvdp.model.journey import Journey, TimingPoint

_Floats = NDArray[np.float64]

#: Misses are told in so many seconds, and what is above a whole number of them by less than this share is rounding.
_TOLD_S, _WHOLE = 0.01, 1e-6
#: Stretches into which a demand is cut between two of its points.
_CUTS = 8


class Windows(NamedTuple):
    """Windows of the departures and arrivals of all parts of a journey, and how long it stands between them.

    Attributes
    ----------
    departures, arrivals : tuple of TimingPoint
    dwells_s : tuple of float or None
        Least standstill between two parts, s; None where the train passes.
    rows : mapping of (float, float) to str
        Where a window stands in a file, by its position, m, and when it closes, s.
    """

    departures: tuple[TimingPoint, ...]
    arrivals: tuple[TimingPoint, ...]
    dwells_s: tuple[float | None, ...]
    rows: Mapping[tuple[float, float], str] = {}

    def told(self, window: TimingPoint) -> str:
        """Name a window, for people."""
        row = self.rows.get((window.position_m, window.latest_s), "")
        return f"the window at {window.position_m:.6g} m" + (row and f" ({row})")

    @property
    def are_open(self) -> bool:
        """Whether any departure and arrival will do, but for that of the journey itself, and any speed."""
        return None not in self.dwells_s and all(map(is_open, (*self.departures[1:], *self.arrivals)))

    def opened_later(self, by_s: float) -> "Windows":
        """Windows of arrivals open later, s: runs are earlier than their times by a tolerance."""
        arrivals = [one._replace(earliest_s=min(one.earliest_s + by_s, one.latest_s)) for one in self.arrivals]
        return self._replace(arrivals=tuple(arrivals))

    def left_by(self, departure_s: _Floats, arrival_s: _Floats, slack_s: float) -> Iterator[str]:
        """Say which window is left most, and by how much, by departures and arrivals, (n, parts), s; else nothing."""
        worst_s, text = slack_s, ""
        for points, clock_s in ((self.departures, departure_s), (self.arrivals, arrival_s)):
            for point, own_s in zip(points, clock_s.T, strict=True):
                early_s, late_s = point.earliest_s - float(own_s.min()), float(own_s.max()) - point.latest_s
                if max(early_s, late_s) > worst_s:
                    worst_s = max(early_s, late_s)
                    side = "earlier than it opens" if early_s > late_s else "later than it closes"
                    text = f"{self.told(point)} is left: the train is there {worst_s:.3g} s {side}"
        if text:
            yield text

    @property
    def at_stops(self) -> "Windows":
        """Those at stops alone: parts are the sections between them."""
        firsts, lasts = zip(*((parts[0], parts[-1]) for parts in self.sections), strict=True)
        return Windows(
            tuple(self.departures[part] for part in firsts),
            tuple(self.arrivals[part] for part in lasts),
            tuple(dwell_s for dwell_s in self.dwells_s if dwell_s is not None),
            self.rows,
        )

    @property
    def start_s(self) -> float:
        """Earliest departure of the journey, s."""
        return self.departures[0].earliest_s if math.isfinite(self.departures[0].earliest_s) else 0.0

    def waiting_s(self, arrival_s: _Floats, time_s: _Floats) -> _Floats:
        """How long a train waits, dwells aside, that ends at some times and runs so long, (n,) each, s."""
        dwells_s = sum(dwell_s or 0.0 for dwell_s in self.dwells_s)
        return np.maximum(arrival_s - self.start_s - dwells_s - time_s, 0.0)

    @property
    def sections(self) -> tuple[tuple[int, ...], ...]:
        """Numbers of the parts of each section between two stops."""
        stops = [0, *(part for part, dwell_s in enumerate(self.dwells_s, start=1) if dwell_s is not None)]
        ends = [*stops[1:], len(self.arrivals)]
        return tuple(tuple(range(first, end)) for first, end in zip(stops, ends, strict=True))


def is_open(point: TimingPoint) -> bool:
    """Whether any time will do."""
    return math.isinf(point.earliest_s) and math.isinf(point.latest_s)


def windows_of(journey: Journey, dwell_s: float) -> Windows:
    """Windows of a timetable: parts lie between its stops and the points whose passing it asks something of."""
    departures = [journey.points[0]]
    arrivals: list[TimingPoint] = []
    dwells_s: list[float | None] = []
    for point in journey.points[1:]:
        if point.is_stop and len(arrivals) == len(departures):  # it was here that it arrived
            departures.append(point)
            dwells_s.append(_dwell_s(arrivals[-1], point, dwell_s))
        elif point.is_stop:
            arrivals.append(point)
        elif not point.is_free:
            arrivals.append(point)
            departures.append(TimingPoint(point.position_m))
            dwells_s.append(None)
    rows = {(point.position_m, point.latest_s): row for point, row in zip(journey.points, journey.rows, strict=False)}
    return Windows(tuple(departures), tuple(arrivals), tuple(dwells_s), rows)


def _dwell_s(arrival: TimingPoint, departure: TimingPoint, dwell_s: float) -> float:
    """Least standstill at a stop: no more than windows leave from the earliest arrival to the latest departure."""
    left_s = departure.latest_s - arrival.earliest_s
    return min(dwell_s, left_s) if left_s >= 0.0 else dwell_s  # where they contradict, that is said elsewhere


class Miss(NamedTuple):
    """A window that is missed: which and why, by how much, s, and what would meet it."""

    which: str
    missed_s: float
    remedy: str

    def __str__(self) -> str:
        # Rounded up, so that who widens the window by it meets it.
        missed_s = math.ceil(self.missed_s / _TOLD_S - _WHOLE) * _TOLD_S
        return f"{self.which}: it is missed by {missed_s:.8g} s, and met when it {self.remedy}"


class WindowMissedError(InfeasibleError):
    """Windows cannot be met: all that are missed when each of them opens or closes no farther away than it has to."""

    def __init__(self, misses: Sequence[Miss]) -> None:
        super().__init__(f"journey: {'; '.join(map(str, misses))}")
        self.missed_s = sum(miss.missed_s for miss in misses)


class TooFastError(WindowMissedError):
    """Windows that close are met, but parts are run faster than others open: all of these."""


class Clock(NamedTuple):
    """When a train can be at a stop: the first time, s, and stretches of later ones, (n,), s, with what each of their
    seconds saves, (n,), J/s, falling.
    """

    first_s: float
    length_s: _Floats
    multiplier_j_per_s: _Floats

    @property
    def last_s(self) -> float:
        """The last time that still saves something, s."""
        return self.first_s + float(self.length_s.sum())

    def miss(self, window: TimingPoint, told: str, slack_s: float) -> Miss | None:
        """How a window, as it is told, is missed that closes too early, if it is by more than a slack."""
        if self.first_s <= window.latest_s + slack_s:
            return None
        return Miss(
            f"{told} closes at {window.latest_s:.6g} s, the first time possible there is {self.first_s:.6g} s",
            self.first_s - window.latest_s,
            "closes so much later",
        )

    def within(self, window: TimingPoint) -> "Clock":
        """Cut off what lies outside a window; where all does, the time at its beginning is left, or the first one."""
        edges_s = self.first_s + np.concatenate(([0.0], np.cumsum(self.length_s)))
        start_s, end_s = edges_s[:-1], edges_s[1:]
        low_s, high_s = max(window.earliest_s, self.first_s), max(window.latest_s, self.first_s)
        length_s = np.maximum(np.minimum(end_s, high_s) - np.maximum(start_s, low_s), 0.0)
        return Clock(low_s, length_s, self.multiplier_j_per_s)

    def worth(self, least_w: float) -> "Clock":
        """Cut off times whose seconds save no more than that, W."""
        kept = self.multiplier_j_per_s > least_w
        return Clock(self.first_s, self.length_s[kept], self.multiplier_j_per_s[kept])

    def after(self, dwell_s: float) -> "Clock":
        """When the train can leave again: as long after the dwell as one likes."""
        if math.isinf(self.last_s):
            return self._replace(first_s=self.first_s + dwell_s)
        length_s, multiplier = np.append(self.length_s, math.inf), np.append(self.multiplier_j_per_s, 0.0)
        return Clock(self.first_s + dwell_s, length_s, multiplier)


class _Run(NamedTuple):
    """The run of a section: when it can arrive, and how much of each stretch is the section's own time, s, (n,)."""

    departure: Clock
    arrival: Clock
    whole: Clock  # before the window of the arrival
    own_s: _Floats


class Schedule(NamedTuple):
    """Times on the clock of the journey, s, and multipliers, J/s, (n, sections)."""

    departure_s: _Floats
    supplement_s: _Floats
    multiplier_j_per_s: _Floats


class Timetable:
    """The least energy of a journey for each arrival, with windows at its stops.

    Parameters
    ----------
    windows : Windows
    fastest_s : sequence of float
        Fastest running times of the parts, s.
    demands : sequence of Demand
        What each takes, of energies less what is drawn in waiting as long.
    slack_s : float
        By how much a window may be missed, s.
    waiting_w : float
        What is drawn in waiting, W.

    Raises
    ------
    WindowMissedError
        When the windows cannot be met.
    """

    def __init__(
        self,
        windows: Windows,
        fastest_s: Sequence[float],
        demands: Sequence[Demand],
        slack_s: float,
        waiting_w: float = 0.0,
    ) -> None:
        self.windows = windows
        first = windows.departures[0]
        free_s = max(first.latest_s - windows.start_s, 0.0) if math.isfinite(first.earliest_s) else 0.0
        departure = Clock(windows.start_s, np.array([free_s]), np.zeros(1))
        self._fastest_s = fastest_s
        self._runs: list[_Run] = []
        misses: list[Miss | None] = []
        for number, (own_s, demand) in enumerate(zip(fastest_s, demands, strict=True)):
            if number:
                departure = self._runs[-1].arrival
                if (dwell_s := windows.dwells_s[number - 1]) is not None:
                    departure = departure.after(dwell_s)
                    leaving = windows.departures[number]
                    misses.append(departure.miss(leaving, windows.told(leaving), slack_s))
                    departure = departure.within(leaving)
            reached = windows.arrivals[number]
            run = _run(departure, own_s, demand, reached)
            misses.append(run.whole.miss(reached, windows.told(reached), slack_s))
            self._runs.append(run)
        if missed := [miss for miss in misses if miss is not None]:
            raise WindowMissedError(missed)
        # To end a second later takes what waiting for it takes.
        self._runs[-1] = self._runs[-1]._replace(arrival=self._runs[-1].arrival.worth(waiting_w))

    @property
    def arrival(self) -> Clock:
        """When the journey can end."""
        return self._runs[-1].arrival

    def at(self, arrival_s: _Floats) -> Schedule:
        """Schedules of least energy that arrive at given times, s, (n,), within `arrival`."""
        columns = []
        before_s = [0.0, *(dwell_s or 0.0 for dwell_s in self.windows.dwells_s)]
        for run, fastest_s, dwell_s in zip(self._runs[::-1], self._fastest_s[::-1], before_s[::-1], strict=True):
            arrival_s = np.clip(arrival_s, run.arrival.first_s, run.arrival.last_s)
            filled_s = arrival_s - run.whole.first_s
            edges_s = np.concatenate(([0.0], np.cumsum(run.whole.length_s)))
            own_s = np.interp(filled_s, edges_s, np.concatenate(([0.0], np.cumsum(run.own_s))))
            own_s += np.maximum(filled_s - edges_s[-1], 0.0)  # the window opens later than any run that saves arrives
            at = np.minimum(np.searchsorted(edges_s[1:], filled_s), len(run.own_s) - 1)
            departure_s = arrival_s - fastest_s - own_s
            columns.append((departure_s, own_s, np.where(own_s > 0.0, run.whole.multiplier_j_per_s[at], np.inf)))
            arrival_s = departure_s - dwell_s
        return Schedule(*map(np.column_stack, zip(*columns[::-1], strict=True)))


def _run(departure: Clock, fastest_s: float, demand: Demand, window: TimingPoint) -> _Run:
    """Let a section follow a departure."""
    parts = np.linspace(0.0, 1.0, 2 * _CUTS + 1)[1::2]
    steps_s, falls = np.diff(demand.supplement_s), np.diff(demand.log_multiplier)
    own_s = np.repeat(steps_s / _CUTS, _CUTS)
    own = np.exp((demand.log_multiplier[:-1, None] + parts * falls[:, None]).ravel())
    length_s = np.concatenate((departure.length_s, own_s))
    multiplier = np.concatenate((departure.multiplier_j_per_s, own))
    order = np.argsort(-multiplier, kind="stable")
    whole = Clock(departure.first_s + fastest_s, length_s[order], multiplier[order])
    is_own = np.concatenate((np.zeros(len(departure.length_s)), own_s))
    return _Run(departure, whole.within(window), whole, is_own[order])
