"""Recorded runs: CSV with two or three of position, speed and time, units in the head, decimal points or commas.

The head is the first line that is no comment; other columns are ignored. Between columns stand ``,``, ``;`` or tabs.
"""

import csv
import datetime
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.formats.syntax.numbers import Marks, marks_of, read_number
from tgvdp.formats.syntax.reading import bad, read_bytes
from tgvdp.formats.tables.cells import Cell, Row, is_comment, text_cell
from tgvdp.formats.tables.sheets import delimiter_of
from tgvdp.units import to_si

#: Names of a column, in the languages in which such files come, by quantity.
_NAMES = {
    "position": {"position", "pos", "distance", "dist", "s", "x", "chainage", "mileage", "weg", "strecke", "station"},
    "speed": {"speed", "v", "velocity", "geschwindigkeit", "vitesse", "speed over ground", "sog"},
    "time": {"time", "t", "zeit", "temps", "timestamp", "utc", "clock", "uhrzeit"},
}
_QUANTITY = {"position": "length", "speed": "speed", "time": "time"}
#: Spellings of units besides those of `tgvdp.units`.
_UNITS = {
    "mps": "m/s", "m s-1": "m/s", "ms-1": "m/s", "kmh": "km/h", "kph": "km/h", "km h-1": "km/h", "kmph": "km/h",
    "sec": "s", "seconds": "s", "minutes": "min", "hours": "h", "metre": "m", "metres": "m", "meter": "m",
}  # fmt: skip
_HEAD = re.compile(r"(?P<name>.*?)\s*(?:\[(?P<square>.*)\]|\((?P<round>.*)\)|\bin\s+(?P<word>\S+)|_(?P<tail>[^_]+))$")
_CLOCK = re.compile(r"(?:(\d+):)?(\d{1,2}):(\d{1,2}(?:\.\d*)?)")
#: Seconds of a day, after which times of day begin anew; who goes back by more than half of it is past midnight.
_DAY_S = 86_400.0


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
    place = Path(path)
    try:
        text = read_bytes(place).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise bad(place, "is not UTF-8 text") from None
    separator = delimiter_of(text)
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
    table = [Row(number, _cells(line, separator)) for number, line in lines]
    table = [row for row in table if not is_comment(row.cells)]
    if not table:
        raise bad(place, "is empty")
    found = _columns(place, list(map(str, table[0].cells)))
    rows = [row for row in table[1:] if _has_values(row.cells, found)]
    if len(rows) < 2:
        raise bad(place, f"must have at least 2 rows of values, has {len(rows)}")
    marks = {index: marks_of(_text(row, index) for row in rows) for index, _ in found.values()}
    every = Marks(frozenset[str]().union(*(one.sure for one in marks.values())), "").only
    read = {
        kind: np.array([_value(place, row, kind, unit, index, separator, marks[index].only or every) for row in rows])
        for kind, (index, unit) in found.items()
    }
    if "time" in read:
        days = np.zeros(len(rows))
        if all(_CLOCK.fullmatch(_text(row, found["time"][0]).replace(",", ".")) for row in rows):
            days[1:] = np.cumsum(np.diff(read["time"]) < -0.5 * _DAY_S)
        read["time"] += _DAY_S * days - read["time"][0]
    return RecordedRun(place.name, read.get("position"), read.get("speed"), read.get("time"))


def _columns(path: Path, head: Sequence[str]) -> dict[str, tuple[int, str]]:
    """Index and unit of each known column; the unit of clock times is empty."""
    found: dict[str, tuple[int, str]] = {}
    for index, title in enumerate(head):
        match = _HEAD.fullmatch(title.strip())
        name = (match["name"] if match else title).strip().strip("_").replace("_", " ").lower()
        unit = next((text for text in match.groups()[1:] if text is not None), "").strip() if match else ""
        kind = next((kind for kind, names in _NAMES.items() if name in names), None)
        if kind is None:
            continue
        if kind in found:
            raise bad(
                path, f"has two columns of {kind}: {head[found[kind][0]].strip()!r:.40} and {title.strip()!r:.40}"
            )
        unit = _UNITS.get(unit.lower(), unit)
        if not unit and kind != "time":
            example = {"position": "position_m or position [km]", "speed": "speed_kmh or speed [m/s]"}[kind]
            raise bad(path, f"column {title.strip()!r:.40} names no unit: write {example}")
        if unit and not (kind == "time" and name in ("timestamp", "utc", "clock", "uhrzeit")):
            try:
                to_si(1.0, unit, _QUANTITY[kind])
            except InputError as error:
                raise bad(path, f"column {title.strip()!r:.40}: {error}") from None
        found[kind] = (index, unit)
    if len(found) < 2:
        raise bad(
            path,
            f"needs two of position, speed and time with units, such as position_m,speed_kmh; its columns are"
            f" {', '.join(title.strip() for title in head)!r:.120}",
        )
    return found


def _cells(line: str, separator: str) -> tuple[Cell, ...]:
    return tuple(map(text_cell, next(csv.reader([line], delimiter=separator))))


def _has_values(cells: Sequence[Cell], found: dict[str, tuple[int, str]]) -> bool:
    """Whether any of the known columns is filled: receivers write empty rows where they see no satellite."""
    return any(index < len(cells) and cells[index] for index, _ in found.values())


def _text(row: Row, index: int) -> str:
    return str(row.cells[index]) if index < len(row.cells) else ""


def _value(path: Path, row: Row, kind: str, unit: str, index: int, separator: str, mark: str) -> float:
    """Value of a cell in SI; ``mark`` is the decimal one where the numbers of the file tell it."""
    text = _text(row, index)
    if kind == "time" and ":" in text:
        return _clock_s(path, row.number, text, unit)
    written = read_number(text)
    if written is None:
        raise bad(path, f"line {row.number}: {kind} must be a number{f' in {unit}' if unit else ''}, got {text!r:.40}")
    if kind == "time" and not unit:
        raise bad(path, f"line {row.number}: column of {kind} names no unit: write time_s or time [min]")
    value = written.value
    is_point_between_commas = separator == "," and written.decimal_mark == "."
    if written.is_open and not is_point_between_commas:
        if not mark:
            either = f"{value:g} or {written.in_thousands:.12g} {unit}"
            raise bad(path, f"line {row.number}: {kind} may be {either}, got {text!r}: write it with other decimals")
        value = value if mark == written.decimal_mark else written.in_thousands
    return to_si(value, unit, _QUANTITY[kind])


def _clock_s(path: Path, line: int, text: str, unit: str) -> float:
    """Seconds of a time of day, h:min:s or min:s (h:min where hours are the unit), or of a date with a time."""
    if match := _CLOCK.fullmatch(text.replace(",", ".")):
        hours, minutes, seconds = match.groups()
        if hours is None and unit == "h":
            hours, minutes, seconds = minutes, seconds, "0"
        return 3600.0 * float(hours or 0) + 60.0 * float(minutes) + float(seconds)
    try:
        return datetime.datetime.fromisoformat(text).timestamp()
    except ValueError:
        raise bad(path, f"line {line}: time must be seconds, h:min:s or a date with a time, got {text!r:.40}") from None
