"""Recorded runs: tables with two or three of position, speed and time, units in the head; other columns are ignored."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.formats.syntax.clocks import DAY_S, clock_s, is_time_of_day
from tgvdp.formats.syntax.numbers import Marks, marks_of, read_number
from tgvdp.formats.syntax.reading import bad, errors_named, read_document
from tgvdp.formats.tables.cells import Number, Row, Sheet
from tgvdp.formats.tables.headers import headed, split
from tgvdp.formats.tables.sheets import sheets_of
from tgvdp.units import to_si

#: Names of a column, in the languages in which such files come, by quantity; the weak ones where no other is there.
_NAMES = {
    "position": {"position", "pos", "distance", "dist", "s", "x", "chainage", "mileage", "weg", "strecke", "station"},
    "speed": {"speed", "v", "velocity", "geschwindigkeit", "vitesse", "speed over ground", "sog"},
    "time": {"time", "t", "zeit", "temps", "timestamp", "utc", "clock", "uhrzeit"},
}
_WEAK = {
    "position": {"km", "distance travelled", "travelled distance", "distance covered", "zurückgelegter weg"},
    "speed": {"actual speed", "current speed", "train speed", "gps speed", "ground speed", "istgeschwindigkeit"},
    "time": {"elapsed time", "time elapsed", "elapsed", "datetime", "date time", "date/time", "time stamp",
             "datum/uhrzeit", "zeitstempel", "running time", "fahrzeit"},
}  # fmt: skip
#: Names of columns behind which something else than a unit may stand: a zone, or how it is written.
_CLOCKS = {"timestamp", "utc", "clock", "uhrzeit", "zeitstempel", "datetime", "date time", "date/time"}
_QUANTITY = {"position": "length", "speed": "speed", "time": "time"}


class RecordedRun(NamedTuple):
    """Columns of a recorded run, (n,) float64 each; one of the three may be None.

    Attributes
    ----------
    name : str
        Of the file.
    position_m, speed_mps, time_s : float64, optional
        As recorded, in SI.
    """

    name: str
    position_m: NDArray[np.float64] | None
    speed_mps: NDArray[np.float64] | None
    time_s: NDArray[np.float64] | None


def load_run(path: str | os.PathLike[str]) -> RecordedRun:
    """Read a recorded run.

    Raises
    ------
    InputError
        When the file cannot be read, names fewer than two of position, speed and time, a column names no unit, or a
        value is no number.
    """
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"expected the path of a recorded run, got {path!r:.60}")
    place = Path(path)
    sheet = _sheet(place)
    found = _columns(place, sheet.header)
    rows = [row for row in sheet.rows[1:] if any(_text(row, index) for index, _ in found.values())]
    if len(rows) < 2:
        raise bad(place, f"must have at least 2 rows of values, has {len(rows)}")
    marks = {index: marks_of(_text(row, index) for row in rows if _is_text(row, index)) for index, _ in found.values()}
    every = Marks(frozenset[str]().union(*(one.sure for one in marks.values())), "").only
    read = {
        kind: np.array([_possible(place, sheet, row, kind, unit, index, marks[index].only or every) for row in rows])
        for kind, (index, unit) in found.items()
    }
    if "time" in read:
        days = np.zeros(len(rows))
        if all(is_time_of_day(_text(row, found["time"][0])) for row in rows):
            days[1:] = np.cumsum(np.diff(read["time"]) < -0.5 * DAY_S)
        read["time"] += DAY_S * days - read["time"][0]
        _require_forward(place, sheet, rows, read["time"], found["time"][0])
    return RecordedRun(place.name, read.get("position"), read.get("speed"), read.get("time"))


def _require_forward(path: Path, sheet: Sheet, rows: Sequence[Row], time_s: NDArray[np.float64], index: int) -> None:
    """Refuse a table whose time goes back, as where several runs stand in one."""
    back = np.flatnonzero(np.diff(time_s) < 0.0)
    if back.size:
        before, row = rows[back[0]], rows[back[0] + 1]
        times = f"{_text(row, index)!r:.40} after {_text(before, index)!r:.40}"
        raise bad(path, f"{_place(sheet, row)}: time goes back, got {times}: a table of one run is expected")


def _sheet(path: Path) -> Sheet:
    """The table of a file, of a workbook the only sheet that names two of the columns."""
    document = read_document(path)
    if document.syntax not in ("CSV", "XLSX"):
        raise bad(path, f"must be a table, as CSV or Excel, got {document.syntax}")
    with errors_named(path):
        sheets = [headed(sheet, lambda header: _kind_of(header) is not None)[0] for sheet in sheets_of(document)]
    if not sheets:
        raise bad(path, "is empty")
    whole = [sheet for sheet in sheets if len(set(map(_kind_of, sheet.header)) - {None}) > 1] or sheets[:1]
    if len(whole) > 1:
        raise bad(path, f"holds {len(whole)} sheets with a recorded run: leave one")
    return whole[0]


def _kind_of(header: str) -> str | None:
    name = split(header)[0]
    return next((kind for kind, names in _NAMES.items() if name in names | _WEAK[kind]), None)


def _columns(path: Path, head: Sequence[str]) -> dict[str, tuple[int, str]]:
    """Index and unit of each known column; the unit of clock times is empty."""
    found: dict[str, tuple[int, str]] = {}
    for index, title in enumerate(head):
        kind = _kind_of(title)
        if kind is None:
            continue
        name, unit = split(title)
        if kind in found:
            before = head[found[kind][0]]
            if name in _WEAK[kind]:
                continue
            if split(before)[0] not in _WEAK[kind]:
                raise bad(path, f"has two columns of {kind}: {before!r:.40} and {title!r:.40}")
        if not unit and name == "km":
            unit = "km"
        if not unit and kind != "time":
            example = {"position": "position_m or position [km]", "speed": "speed_kmh or speed [m/s]"}[kind]
            raise bad(path, f"column {title!r:.40} names no unit: write {example}")
        try:
            to_si(1.0, unit or "s", _QUANTITY[kind])
        except InputError as error:
            if name not in _CLOCKS:
                raise bad(path, f"column {title!r:.40}: {error}") from None
            unit = ""
        found[kind] = (index, unit)
    if len(found) < 2:
        raise bad(
            path,
            f"needs two of position, speed and time with units, such as position_m,speed_kmh; its columns are"
            f" {', '.join(head)!r:.120}",
        )
    return found


def _is_text(row: Row, index: int) -> bool:
    return index < len(row.cells) and isinstance(row.cells[index], str)


def _text(row: Row, index: int) -> str:
    return str(row.cells[index]) if index < len(row.cells) else ""


def _possible(path: Path, sheet: Sheet, row: Row, kind: str, unit: str, index: int, mark: str) -> float:
    """`_value`, where a train may have it."""
    value = _value(path, sheet, row, kind, unit, index, mark)
    if kind == "speed" and value < 0.0:
        text = _text(row, index)
        raise bad(path, f"{_place(sheet, row)}: speed must not be negative, got {text!r:.40} {unit}")
    return value


def _place(sheet: Sheet, row: Row) -> str:
    return f"line {row.number}" if sheet.delimiter else f"sheet {sheet.name!r:.40}, row {row.number}"


def _value(path: Path, sheet: Sheet, row: Row, kind: str, unit: str, index: int, mark: str) -> float:
    """Value of a cell in SI; ``mark`` is the decimal one where the numbers of the file tell it."""
    text = _text(row, index)
    place = _place(sheet, row)
    if kind == "time" and ":" in text:
        try:
            return clock_s(text, with_hours=unit == "h")
        except InputError as error:
            raise bad(path, f"{place}: time {error}") from None
    written = read_number(text)
    if written is None:
        raise bad(path, f"{place}: {kind} must be a number{f' in {unit}' if unit else ''}, got {text!r:.40}")
    if kind == "time" and not unit:
        raise bad(path, f"{place}: column of {kind} names no unit: write time_s or time [min]")
    cell = row.cells[index]
    value = cell.value if isinstance(cell, Number) else written.value
    is_point_between_commas = sheet.delimiter == "," and written.decimal_mark == "."
    if not isinstance(cell, Number) and written.is_open and not is_point_between_commas:
        if not mark:
            either = f"{value:g} or {written.in_thousands:.12g} {unit}"
            raise bad(path, f"{place}: {kind} may be {either}, got {text!r}: write it with other decimals")
        value = value if mark == written.decimal_mark else written.in_thousands
    with errors_named(path, f"{place}: {kind}"):
        return to_si(value, unit, _QUANTITY[kind])
