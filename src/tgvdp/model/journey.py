"""The journey: where a train stops, and when and how fast it may pass."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import groupby, pairwise
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.model.checks import require_notes, require_number, require_rows, require_text
from tgvdp.model.track import Place, Track

_FEWEST_POINTS = 2


class TimingPoint(NamedTuple):
    """A position with a window of time, counted from the start of the journey, and a window of speed.

    A stop has both speeds 0. A stop on the way is two rows at one position: the arrival, then the departure.
    """

    position_m: float
    earliest_s: float = -math.inf
    latest_s: float = math.inf
    lowest_mps: float = 0.0
    highest_mps: float = math.inf

    @property
    def is_stop(self) -> bool:
        """Whether the train stands here."""
        return self.highest_mps == 0.0

    @property
    def is_free(self) -> bool:
        """Whether nothing is asked of a train that passes."""
        return self[1:] == TimingPoint(self.position_m)[1:]


@dataclass(frozen=True)
class Section:
    """The run from one stop to the next.

    Attributes
    ----------
    number : int
        From 1.
    origin_m, destination_m : float
        Positions of the two stops.
    shortest_s, longest_s : float
        Running times between latest departure and earliest arrival, at least 0, and between earliest departure and
        latest arrival; infinite where a window is open.
    passing : tuple of TimingPoint
        What is asked of the train in between.
    """

    number: int
    origin_m: float
    destination_m: float
    shortest_s: float
    longest_s: float
    passing: tuple[TimingPoint, ...]


@dataclass(frozen=True, kw_only=True)
class Journey:
    """A timetable of one train, checked when it is made.

    Parameters
    ----------
    points : tuple of TimingPoint
        In order of running; the first and the last are stops, each stop in between is two rows at its position.
    track : str, optional
        Name of the line that it belongs to, where that is said.
    name : str
        For people.
    notes : tuple of str
        Sources and doubts.
    rows : tuple of str
        Where each point stands in its file and the position that is written there, for errors: ``times.csv: line 4,
        column 'km': 12.5 km``; or none.
    places : tuple of Place
        What the timetable calls its positions, for people.

    Raises
    ------
    InputError
        When points are unordered, a window is empty, a stop is not two rows, or no train could be in time because a
        later window closes before an earlier one opens; when there are rows, and not one for each point.
    """

    points: tuple[TimingPoint, ...]
    track: str | None = None
    name: str = "journey"
    notes: tuple[str, ...] = field(default=(), compare=False)
    rows: tuple[str, ...] = field(default=(), compare=False, repr=False)
    places: tuple[Place, ...] = field(default=(), compare=False, repr=False)

    def __post_init__(self) -> None:
        owner = f"journey {require_text('journey', 'name', self.name)}"
        if self.track is not None:
            require_text(owner, "track", self.track)
        object.__setattr__(self, "notes", require_notes(owner, self.notes))
        rows = require_rows(owner, "points", self.points, TimingPoint)
        if len(rows) < _FEWEST_POINTS:
            raise InputError(f"{owner}: points must be at least {_FEWEST_POINTS}, got {len(rows)}")
        points = tuple(_checked(f"{owner}: points[{index}]", row) for index, row in enumerate(rows))
        object.__setattr__(self, "points", points)
        if len(self.rows) not in (0, len(points)):
            raise InputError(f"{owner}: rows must be {len(points)}, one for each point, or none, got {len(self.rows)}")
        for index in (0, -1):
            if not points[index].is_stop:
                which = "last" if index else "first"
                raise InputError(f"{self.row(index)}: the {which} of the points must be a stop")
        self._require_order()
        self._require_stops()
        self._require_time_in_order()

    def row(self, index: int) -> str:
        """Where a point stands, for errors."""
        number = index % len(self.points)
        return self.rows[index] if self.rows else f"journey {self.name}: points[{number}] at {self._m(index)}"

    def _m(self, index: int) -> str:
        return f"{self.points[index].position_m:.12g} m"

    def require_on(self, track: Track, until_m: float = math.inf) -> None:
        """Refuse points beyond the end of a line, as far as they are run."""
        for index, point in enumerate(self.points):
            if track.length_m < point.position_m <= until_m:
                end = f"the end of track {track.name}, which is {track.length_m:.12g} m long"
                raise InputError(f"{self.row(index)}: lies beyond {end}")

    @property
    def sections(self) -> tuple[Section, ...]:
        """The runs from stop to stop."""
        return tuple(self._sections())

    def _sections(self) -> Iterator[Section]:
        start, number = 0, 1
        for index, last in enumerate(self.points):
            if index == start or not last.is_stop:
                continue
            first = self.points[start]
            yield Section(
                number=number,
                origin_m=first.position_m,
                destination_m=last.position_m,
                shortest_s=max(last.earliest_s - first.latest_s, 0.0),
                longest_s=last.latest_s - first.earliest_s,
                passing=tuple(point for point in self.points[start + 1 : index] if not point.is_free),
            )
            start, number = index + 1, number + 1

    def _require_order(self) -> None:
        for index, (before, point) in enumerate(pairwise(self.points), start=1):
            if point.position_m < before.position_m:
                raise InputError(f"{self.row(index)}: positions must not decrease, got {self._m(index)} "
                                 f"after {self._m(index - 1)}")  # fmt: skip

    def _require_stops(self) -> None:
        """Stops on the way are two rows at one position, everything else is one."""
        first_m, last_m = self.points[0].position_m, self.points[-1].position_m
        for position_m, group in groupby(range(len(self.points)), lambda index: self.points[index].position_m):
            rows = tuple(group)
            stops = sum(self.points[index].is_stop for index in rows)
            inside = first_m < position_m < last_m
            if (len(rows), stops) not in ([(1, 0), (2, 2)] if inside else [(1, 1)]):
                wanted = "two stops (arrival, departure) or one passing point" if inside else "one stop"
                got = f"{stops} stops and {len(rows) - stops} passing points"
                raise InputError(f"{self.row(rows[0])}: must be {wanted}, got {got}")

    def _require_time_in_order(self) -> None:
        """No window closes before one before it opens."""
        earliest_s = -math.inf
        for index, point in enumerate(self.points):
            if point.latest_s < earliest_s:
                raise InputError(
                    f"{self.row(index)}: latest must not lie before an earlier point's earliest, "
                    f"got {point.latest_s:.12g} s after {earliest_s:.12g} s"
                )
            earliest_s = max(earliest_s, point.earliest_s)


def _checked(label: str, row: TimingPoint) -> TimingPoint:
    """Check one row by itself."""
    point = TimingPoint(
        require_number(label, "position", row.position_m, "m", at_least=0.0),
        require_number(label, "earliest", row.earliest_s, "s", infinite_ok=True),
        require_number(label, "latest", row.latest_s, "s", infinite_ok=True),
        require_number(label, "lowest", row.lowest_mps, "m/s", at_least=0.0),
        require_number(label, "highest", row.highest_mps, "m/s", at_least=0.0, infinite_ok=True),
    )
    for low, high, unit in (
        (point.earliest_s, point.latest_s, "s"),
        (point.lowest_mps, point.highest_mps, "m/s"),
    ):
        if not low <= high or low == math.inf or high == -math.inf:
            raise InputError(f"{label}: the window from {low:.12g} {unit} to {high:.12g} {unit} is empty")
    return point
