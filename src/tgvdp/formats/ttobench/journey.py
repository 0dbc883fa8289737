"""TTOBench journeys: rows of position, earliest and latest time, lowest and highest speed; null means free."""

import math
from collections.abc import Sequence
from pathlib import Path

from msgspec import Struct

from tgvdp.formats.syntax.reading import Document, bad, errors_named
from tgvdp.formats.syntax.typed import decode
from tgvdp.formats.ttobench.fields import Metadata, spaced, value_si
from tgvdp.model.journey import Journey, TimingPoint
from tgvdp.units import to_si


class _Metadata(Metadata, rename=spaced):
    """A journey names its track, too."""

    associated_track: str


class _Units(Struct, forbid_unknown_fields=True, rename=spaced):
    position: str
    lower_time_constraint: str
    upper_time_constraint: str
    lower_speed_constraint: str
    upper_speed_constraint: str


_Row = tuple[float, float | None, float | None, float | None, float | None]


class _TimingPoints(Struct, forbid_unknown_fields=True):
    units: _Units
    values: list[_Row]


class _File(Struct, forbid_unknown_fields=True, rename=spaced):
    metadata: _Metadata
    timing_points: _TimingPoints


#: Quantity and value of an open window, by column.
_COLUMNS = (
    ("position", "length", math.nan),
    ("lower time constraint", "time", -math.inf),
    ("upper time constraint", "time", math.inf),
    ("lower speed constraint", "speed", 0.0),
    ("upper speed constraint", "speed", math.inf),
)


def read_journey(document: Document) -> Journey:
    """Make a `Journey` from a TTOBench journey.

    Raises
    ------
    InputError
        When a field is missing, unknown, mistyped or out of range, has an unknown unit, or a rule of the format's
        README is broken.
    """
    path = document.path
    file = decode(path, document.tree, _File)
    about = file.metadata
    if not about.id.startswith(f"{about.associated_track}_"):
        raise bad(path, f"metadata.id: must start with '{about.associated_track}_', got {about.id!r:.60}")
    units, rows = file.timing_points.units, file.timing_points.values
    for name, quantity, _ in _COLUMNS:
        value_si(path, f"timing points.units.{name}", 0.0, _unit_of(units, name), quantity)
    points = tuple(_point(path, index, row, units) for index, row in enumerate(rows))
    _require_order(path, rows, points, units)
    told = (f"timing points.values[{index}]: position {row[0]:.12g} {units.position}" for index, row in enumerate(rows))
    named = tuple(str(bad(path, row)) for row in told)
    with errors_named(path):
        return Journey(name=about.id, track=about.associated_track, points=points, rows=named)


def _point(path: Path, index: int, row: _Row, units: _Units) -> TimingPoint:
    lowest, highest = row[3:]
    stop = lowest == 0.0 and highest == 0.0
    place = f"timing points.values[{index}]"
    if not stop and 0.0 in (lowest, highest):
        raise bad(path, f"{place}: both speeds must be 0 at a stop, and above 0 or null elsewhere, "
                        f"got {_text(lowest)} and {_text(highest)}")  # fmt: skip
    values = []
    for (name, quantity, free), value in zip(_COLUMNS, row, strict=True):
        with errors_named(path, f"{place}: {name}"):
            values.append(free if value is None else to_si(value, _unit_of(units, name), quantity))
    return TimingPoint(*values)


def _unit_of(units: _Units, name: str) -> str:
    """Unit of a column."""
    return str(getattr(units, name.replace(" ", "_")))


def _require_order(path: Path, rows: Sequence[_Row], points: Sequence[TimingPoint], units: _Units) -> None:
    """Refuse in the units of the file what a journey refuses in SI: empty windows, and rows that go back."""
    before, opens_s, opened = 0.0, -math.inf, ""
    for index, (row, point) in enumerate(zip(rows, points, strict=True)):
        where = f"timing points.values[{index}]"
        if row[0] < before:
            bound = "not decrease" if index else f"be at least 0 {units.position}"
            after = f" after {before:.12g} {units.position}" if index else ""
            raise bad(path, f"{where}: position must {bound}, got {row[0]:.12g} {units.position}{after}")
        low, high = f"{_text(row[1])} {units.lower_time_constraint}", f"{_text(row[2])} {units.upper_time_constraint}"
        if point.earliest_s > point.latest_s:
            raise bad(path, f"{where}: the window from {low} to {high} is empty")
        if point.lowest_mps > point.highest_mps:
            slow = f"{_text(row[3])} {units.lower_speed_constraint}"
            fast = f"{_text(row[4])} {units.upper_speed_constraint}"
            raise bad(path, f"{where}: the window from {slow} to {fast} is empty")
        if point.latest_s < opens_s:
            early = f"must not lie before the lower one of an earlier row, {opened}"
            raise bad(path, f"{where}: upper time constraint {early}, got {high}")
        before = row[0]
        if point.earliest_s > opens_s:
            opens_s, opened = point.earliest_s, low


def _text(value: float | None) -> str:
    return "null" if value is None else f"{value:g}"
