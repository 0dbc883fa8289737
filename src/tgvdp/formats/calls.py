"""From places with times to a journey, as timetables of several formats give them.

A train arrives no later than its time, and departs no earlier; its clock starts with the first departure. Where a stop
has but a departure, as in timetables for passengers, it leaves at that time; where it has none, any will do. What has a
time and no stop is passed no later.
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.formats.syntax.clocks import DAY_S
from tgvdp.formats.syntax.reading import listed, shown
from tgvdp.model.journey import Journey, TimingPoint
from tgvdp.model.track import Place
from tgvdp.units import KILO

#: Stops without which nothing runs, and what is said then.
FEWEST_STOPS = 2
NO_JOURNEY = "a timetable needs two stops with times"
#: Longest note, so that it stays one line that can be read.
_LONGEST = 400


class Call(NamedTuple):
    """A place with times.

    Attributes
    ----------
    position_m : float
    stops : bool
        Whether the train stops there.
    arrival_s, departure_s : float or None
        When it arrives, or passes, at the latest, and departs at the earliest, s.
    window_s : float
        By how much it may arrive or pass earlier than that, s.
    row : str
        As of `Journey.rows`.
    name : str
        Of the place, where the timetable has one.
    """

    position_m: float
    stops: bool
    arrival_s: float | None
    departure_s: float | None
    window_s: float = math.inf
    row: str = ""
    name: str = ""


class RunningClock:
    """Times of one train in the order of running, on a clock that goes on past midnight."""

    def __init__(self) -> None:
        self._last_s = -math.inf
        self._day_s = 0.0

    def after(self, time_s: float, *, is_time_of_day: bool, day: int = 0) -> float | None:
        """The next time, s, of a later day where it is said to be, or lies far back; None when it is earlier."""
        if day > 0:
            self._day_s = DAY_S * day
        elif is_time_of_day and time_s + self._day_s < self._last_s - 0.5 * DAY_S:
            self._day_s += DAY_S
        time_s += self._day_s
        if time_s < self._last_s:
            return None
        self._last_s = time_s
        return time_s


def by_name(places: Sequence[tuple[float, str]]) -> dict[str, list[float]]:
    """Positions of named places, m, by their names, whatever the case."""
    known: dict[str, list[float]] = {}
    for at_m, name in places:
        known.setdefault(name.casefold(), []).append(at_m)
    return known


def position_of(name: str, places: Sequence[tuple[float, str]]) -> float:
    """Position of the one place of a name, m, whatever the case.

    Raises
    ------
    InputError
        When the line names no such place, or several.
    """
    found = by_name(places).get(name.casefold(), [])
    if len(found) == 1:
        return found[0]
    why = f"{len(found)} places" if found else "no place"
    has = f"it has {listed([shown(one) for _, one in places])}" if places else "it names none"
    raise InputError(f"the line has {why} of that name, got {shown(name)} ({has})")


def journey_of(name: str, calls: Sequence[Call], notes: tuple[str, ...], track: str | None = None) -> Journey:
    """Make a journey from the first stop to the last one.

    Parameters
    ----------
    name : str
    calls : sequence of Call
        In the order of running. The first stop has a time, and so has what is passed.
    notes : tuple of str
    track : str, optional
        Name of the line that it belongs to.

    Raises
    ------
    InputError
        When fewer than two are stops, the first of them has no time, or positions decrease.
    """
    stops = [at for at, call in enumerate(calls) if call.stops]
    if len(stops) < FEWEST_STOPS:
        raise InputError(NO_JOURNEY)
    first, *between, last = calls[stops[0] : stops[-1] + 1]
    beyond = [f"{call.position_m / KILO:.9g}" for call in (*calls[: stops[0]], *calls[stops[-1] + 1 :])]
    if beyond:
        notes += (
            f"passed before the first stop or behind the last one, and not run, at km {', '.join(beyond)}"[:_LONGEST],
        )
    start_s = first.departure_s if first.departure_s is not None else first.arrival_s
    if start_s is None:
        raise InputError("the first stop must have a time")
    points = (
        (TimingPoint(first.position_m, 0.0, math.inf, 0.0, 0.0), first.row),
        *((point, call.row) for call in between for point in _points(call, start_s)),
        (TimingPoint(last.position_m, *_arrival(last, start_s), 0.0, 0.0), last.row),
    )
    rows = tuple(row for _, row in points if row)
    names = {call.position_m: call.name for call in (first, *between, last) if call.name}
    return Journey(
        name=name,
        track=track,
        points=tuple(point for point, _ in points),
        notes=notes,
        rows=rows,
        places=tuple(Place(*place) for place in names.items()),
    )


def _points(call: Call, start_s: float) -> Iterator[TimingPoint]:
    earliest_s, latest_s = _arrival(call, start_s)
    if not call.stops:
        yield TimingPoint(call.position_m, earliest_s, latest_s)
        return
    departs_s = -math.inf if call.departure_s is None else call.departure_s - start_s
    leaves_at_it = call.arrival_s is None and call.departure_s is not None
    yield TimingPoint(call.position_m, earliest_s, latest_s, 0.0, 0.0)
    yield TimingPoint(call.position_m, departs_s, departs_s if leaves_at_it else math.inf, 0.0, 0.0)


def _arrival(call: Call, start_s: float) -> tuple[float, float]:
    """Window of arrival or passing, s; what has but a departure is passed, or reached, no later than that."""
    time_s = call.arrival_s if call.arrival_s is not None else call.departure_s
    if time_s is None:
        return -math.inf, math.inf
    return time_s - start_s - call.window_s, time_s - start_s
