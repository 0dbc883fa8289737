"""Which column of a table means what, in which unit, and what stands in it."""

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.tables.sheets import Row, Sheet
from tgvdp.units import to_si


class Role(NamedTuple):
    """What a column can mean: its quantity, words that name it, and how a header is written."""

    name: str
    quantity: str
    words: frozenset[str]
    example: str


def _role(name: str, quantity: str, words: str, example: str) -> Role:
    return Role(name, quantity, frozenset(words.split(", ")), example)


POSITION = _role(
    "position", "length", "position, pos, chainage, stationing, kilometrage, mileage, distance, km, kp, pk, s, from",
    "position_m or Position [km]",
)  # fmt: skip
SPEED = _role(
    "speed", "speed", "speed limit, limit, speed, max speed, maximum speed, line speed, vmax, v max, v",
    "speed_kmh or Speed limit [km/h]",
)  # fmt: skip
GRADIENT = _role("gradient", "gradient", "gradient, slope, grade, inclination", "gradient_permil or Gradient [‰]")
RADIUS = _role("radius", "length", "radius, curve radius, r", "radius_m or Radius [m]")
STOP = _role("stop", "", "stop, stops, station, halt, stop name", "stop")
EFFORT = _role(
    "effort", "force", "effort, tractive effort, braking effort, force, tractive force, braking force, traction, f, z",
    "effort_kn or Effort [kN]",
)  # fmt: skip

#: How people write a unit in a header, in small letters → as `tgvdp.units` knows it.
_UNITS = {
    "m": "m", "km": "km", "km/h": "km/h", "kmh": "km/h", "kph": "km/h", "kmph": "km/h", "m/s": "m/s", "mps": "m/s",
    "n": "N", "kn": "kN", "permil": "‰", "‰": "‰", "per mille": "‰", "o/oo": "‰", "promille": "‰", "percent": "%",
    "%": "%", "pct": "%",
}  # fmt: skip
_BRACKETED = re.compile(r"(.*?)\s*[\[(]\s*(?:in\s+)?(.*?)\s*[\])]\s*")
_SEPARATED = re.compile(r"(.*?)[\s_]+(?:in[\s_]+)?(per mille|[^\s_]+)")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
_LONGEST_NUMBER = 400
_INFINITE = ("inf", "infinity", "∞", "-", "straight")
_NO = ("", "0", "no", "n", "false", "-")
_DASHES = str.maketrans("\u2212\u2013", "--", "\u00a0\u202f\u2009' ")
_SHOWN = 8


class Column(NamedTuple):
    """A column of a table: where it stands, its header as it is there, and its unit."""

    at: int
    header: str
    unit: str


class Table(NamedTuple):
    """Rows below a header of which some columns were recognised."""

    sheet: Sheet
    columns: dict[Role, Column]
    unknown: tuple[str, ...]

    @property
    def rows(self) -> Sequence[Row]:
        """Rows below the header."""
        return self.sheet.rows[1:]

    def need(self, role: Role) -> Column:
        """Return the column of a role; an error says which was wanted and which there are."""
        column = self.columns.get(role)
        if column is None:
            raise self.lacks(role)
        return column

    def lacks(self, role: Role) -> InputError:
        """Make the error for a column that is not there."""
        cells = self.sheet.rows[0].cells
        got = ", ".join(map(shown, cells[:_SHOWN])) + (", …" if len(cells) > _SHOWN else "")
        return InputError(f"no column for the {role.name} (such as {role.example}), got {got}")

    def text(self, row: Row, role: Role) -> str:
        """Return a cell as it stands there; empty where the table or the row has none."""
        column = self.columns.get(role)
        return row.cells[column.at] if column is not None and column.at < len(row.cells) else ""

    def number(self, row: Row, role: Role) -> float | None:
        """Return a cell in SI (a gradient in ‰), None where it is blank.

        Raises
        ------
        InputError
            When it is no number of the column's unit.
        """
        text = self.text(row, role)
        if not text:
            return None
        column = self.columns[role]
        value = math.inf if role is RADIUS and text.lower() in _INFINITE else self._number(row, column, text)
        return to_si(value, column.unit, role.quantity)

    def _number(self, row: Row, column: Column, text: str) -> float:
        plain = text.translate(_DASHES)
        comma = "," in plain
        if comma and ("." in plain or plain.count(",") > 1 or self.sheet.delimiter == ","):
            raise self.bad(row, column, f"a comma in a number may mean two things, got {shown(text)}: write 1234.5")
        plain = plain.replace(",", ".")
        if len(plain) > _LONGEST_NUMBER or not _NUMBER.fullmatch(plain) or not math.isfinite(float(plain)):
            raise self.bad(row, column, f"must be a finite number in {column.unit}, got {shown(text)}")
        return float(plain)

    def bad(self, row: Row, column: Column, message: str) -> InputError:
        """Make the error for a cell."""
        return InputError(f"line {row.number}, column {shown(column.header)}: {message}")


def is_no(text: str) -> bool:
    """Whether a cell of a column of marks says no."""
    return text.lower() in _NO


def read_table(sheet: Sheet, roles: Sequence[Role]) -> Table:
    """Recognise the columns of a sheet.

    Raises
    ------
    InputError
        When two columns mean the same, or a unit is missing or does not fit.
    """
    columns: dict[Role, Column] = {}
    unknown = []
    for at, header in enumerate(sheet.rows[0].cells):
        role = next((role for role in roles if _named(header, role) is not None), None)
        if role is None:
            unknown += [header] if header else []
            continue
        if role in columns:
            raise InputError(f"columns {shown(columns[role].header)} and {shown(header)} both give the {role.name}")
        columns[role] = Column(at, header, _unit(header, role))
    return Table(sheet, columns, tuple(unknown))


def _named(header: str, role: Role) -> str | None:
    """Unit text of a header that names a role, empty without one; None when it names another thing."""
    text = re.sub(r"\s+", " ", header.strip().lower()).replace("km_h", "km/h").replace("m_s", "m/s")
    name, unit = text, "km" if text == "km" else ""
    for pattern in (_BRACKETED, _SEPARATED):
        match = pattern.fullmatch(text)
        if match and role.quantity and (pattern is _BRACKETED or match[2] in _UNITS):
            name, unit = match[1], match[2]
            break
    return unit if re.sub(r"[-_ ]+", " ", name).strip() in role.words else None


def _unit(header: str, role: Role) -> str:
    """Unit of a column as its header gives it."""
    text = _named(header, role) or ""
    if not role.quantity:
        return ""
    if not text:
        raise InputError(f"column {shown(header)}: give its unit in the header, such as {role.example}")
    unit = _UNITS.get(text, text)
    try:
        to_si(1.0, unit, role.quantity)
    except InputError as error:
        raise InputError(f"column {shown(header)}: {error}") from None
    return unit
