"""A table: rows below a header of which some columns were recognised, and what stands in their cells."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.formats.syntax.numbers import Marks, is_open, marks_of, read_number
from tgvdp.formats.syntax.reading import listed, shown
from tgvdp.formats.tables.cells import Fault, Number, Row, Sheet, is_missing
from tgvdp.formats.tables.headers import headed
from tgvdp.formats.tables.roles import END, POSITION, RADIUS, Role, is_weak, unit_of, unit_text
from tgvdp.units import KILO, to_si

_INFINITE = ("inf", "infinity", "∞", "-", "straight")
_SHOWN = 8
#: Units that people count by thousands: nobody can tell 1.200 m from 1200 m. In other units it is 1.2, which is said.
_BY_THOUSANDS = ("m", "N", "kN")
#: How positions are written on drawings: kilometres, a plus, and three digits of metres, such as 12+345.6 or K12+345.
_STATIONED = re.compile(r"(?:[A-Z]{1,3} ?)?(\d{1,5})\+(\d{3}(?:[.,]\d+)?)", re.IGNORECASE)
_KM_PLUS_M = "km+m"


class Column(NamedTuple):
    """A column of a table: where it stands, and its unit, which is ``km+m`` where positions are written as 12+345."""

    at: int
    unit: str


@dataclass(frozen=True)
class Table:
    """Rows below a header of which some columns were recognised.

    Attributes
    ----------
    sheet : Sheet
    columns : dict
        Those that were recognised, by what they mean.
    above : tuple of str
        Rows above the header, titles for instance.
    """

    sheet: Sheet
    columns: dict[Role, Column]
    above: tuple[str, ...]

    @cached_property
    def rows(self) -> Sequence[Row]:
        """Rows below the header.

        Raises
        ------
        InputError
            When a row of a CSV goes on where the header has ended: decimal commas between commas shift what follows.
        """
        width = len(self.sheet.header)
        for row in self.sheet.rows[1:] if self.sheet.delimiter else ():
            if any(row.cells[width:]):
                counts = f"{len(row.cells)} cells under a header of {width}"
                raise InputError(f"line {row.number}: holds {counts}: are there commas in numbers that are not quoted?")
        return self.sheet.rows[1:]

    def need(self, role: Role) -> Column:
        """Return the column of a role; an error says which was wanted and which there are."""
        column = self.columns.get(role)
        if column is None:
            raise self.lacks(role)
        return column

    def lacks(self, role: Role) -> InputError:
        """Make the error for a column that is not there."""
        cells = self.sheet.header
        got = ", ".join(map(shown, cells[:_SHOWN])) + (", …" if len(cells) > _SHOWN else "")
        sheet = "" if self.sheet.delimiter else f"sheet {shown(self.sheet.name)}: "
        return InputError(f"{sheet}no column for the {role.name} (such as {role.example}), got {got}")

    def text(self, row: Row, role: Role) -> str:
        """Return a cell as people see it; empty where the table or the row has none, or it says that it is missing."""
        return str(self._cell(row, role))

    def told(self, row: Row, role: Role) -> str:
        """Return a cell with its unit, where that does not stand in it."""
        unit = self.columns[role].unit
        return self.text(row, role) + (f" {unit}" if unit and unit != _KM_PLUS_M else "")

    def number(self, row: Row, role: Role) -> float | None:
        """Return a cell in SI (a gradient in ‰), None where it is blank.

        Raises
        ------
        InputError
            When it is no number of the column's unit, or may mean two things.
        """
        cell = self._cell(row, role)
        if cell == "":
            return None
        if isinstance(cell, str) and role is RADIUS and cell.lower() in _INFINITE:
            return math.inf
        if self.columns[role].unit == _KM_PLUS_M:
            return self._stationed_m(row, role, cell)
        value = self._written(row, role, cell) if isinstance(cell, str) else self._stored(row, role, cell)
        try:
            return to_si(value, self.columns[role].unit, role.quantity)
        except InputError as error:
            raise self.bad(row, role, str(error)) from None

    def bad(self, row: Row, role: Role, message: str) -> InputError:
        """Make the error for a cell."""
        return InputError(f"{self.sheet.place(row, self.columns[role].at)}: {message}")

    def blank(self, row: Row, role: Role) -> InputError:
        """Make the error for a cell that has no value and needs one."""
        at = self.columns[role].at
        written = str(row.cells[at]) if at < len(row.cells) else ""
        return self.bad(row, role, "must not be blank" + (f", got {shown(written)}" if written else ""))

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What was not used, and what was taken for the likelier of two meanings."""
        used = {column.at for column in self.columns.values()}
        width = max(len(row.cells) for row in self.sheet.rows)
        filled = (at for at in range(width) if any(any(row.cells[at : at + 1]) for row in self.rows))
        unused = [self.sheet.heading(at) for at in filled if at not in used]
        above = [f"rows above the header, not used: {listed(list(map(shown, self.above)))}"] if self.above else []
        return (*above, *([f"columns not used: {listed(unused)}"] if unused else []), *self._doubts())

    def _doubts(self) -> Iterator[str]:
        for role, marks in self._marks.items():
            if marks.doubtful and not self._decimal_mark(role):
                written = read_number(marks.doubtful)
                assert written is not None
                means = (
                    f"numbers such as {shown(marks.doubtful)} are read as {written.value:g} {self.columns[role].unit}"
                )
                yield f"column {self.sheet.heading(self.columns[role].at)}: {means}, not as {written.in_thousands:.12g}"

    def _cell(self, row: Row, role: Role) -> str | Number:
        column = self.columns.get(role)
        if column is None or column.at >= len(row.cells):
            return ""
        cell = row.cells[column.at]
        if isinstance(cell, Fault):
            raise self.bad(row, role, cell.reason)
        return "" if isinstance(cell, str) and is_missing(cell) else cell

    def _stored(self, row: Row, role: Role, cell: Number) -> float:
        """Number of a cell of a workbook in the unit of its column."""
        unit = self.columns[role].unit
        if not cell.is_percent:
            return cell.value
        if unit != "%":
            raise self.bad(row, role, f"must be a number in {unit}, got {cell} by its format")
        return cell.percent

    def _stationed_m(self, row: Row, role: Role, cell: str | Number) -> float:
        match = _STATIONED.fullmatch(str(cell))
        if match is None:
            raise self.bad(row, role, f"must be kilometres and metres as in 12+345, got {shown(str(cell))}")
        return KILO * int(match[1]) + float(match[2].replace(",", "."))

    def _written(self, row: Row, role: Role, text: str) -> float:
        """Number of a text in the unit of its column."""
        unit = self.columns[role].unit
        written = read_number(text)
        if written is None:
            raise self.bad(row, role, f"must be a finite number in {unit}, got {shown(text)}")
        if self.sheet.delimiter == ",":
            if "," in text:
                meant = "a comma in a number may mean two things"
                raise self.bad(row, role, f"{meant}, got {shown(text)}: write 1234.5")
            return written.value
        if not written.is_open:
            return written.value
        mark = self._decimal_mark(role)
        if not mark and unit in _BY_THOUSANDS:
            either = f"{written.value:g} or {written.in_thousands:.12g} {unit}"
            raise self.bad(row, role, f"may be {either}, got {shown(text)}: write it without a mark for thousands")
        return written.in_thousands if mark and mark != written.decimal_mark else written.value

    @cached_property
    def _marks(self) -> dict[Role, Marks]:
        """Decimal marks of the texts in each column of numbers, where any leaves a doubt; between commas none does."""
        if self.sheet.delimiter == ",":
            return {}
        numbers = {role: column.at for role, column in self.columns.items() if role.quantity}
        if not any(map(is_open, chain.from_iterable(map(self._texts, numbers.values())))):
            return {}
        return {role: marks_of(self._texts(at)) for role, at in numbers.items()}

    def _texts(self, at: int) -> Iterator[str]:
        """Texts in a column."""
        return (cell for row in self.rows if at < len(row.cells) and isinstance(cell := row.cells[at], str))

    def _decimal_mark(self, role: Role) -> str:
        """Decimal mark of a column, by its own numbers, else by those of the whole table; empty where none tells."""
        every = frozenset[str]().union(*(marks.sure for marks in self._marks.values()))
        return self._marks[role].only or Marks(every, "").only


def read_table(sheet: Sheet, roles: Sequence[Role]) -> Table:
    """Recognise the columns of a sheet.

    Raises
    ------
    InputError
        When two columns mean the same, or a unit is missing or does not fit.
    """
    sheet, above = headed(sheet, lambda header: _role_of(header, roles) is not None)
    columns: dict[Role, Column] = {}
    for at, header in enumerate(sheet.header):
        role = _role_of(header, roles)
        if role is None:
            continue
        if role in columns:
            before = sheet.header[columns[role].at]
            if is_weak(header, role) and not is_weak(before, role):
                continue
            if is_weak(header, role) or not is_weak(before, role):
                raise InputError(f"columns {shown(before)} and {shown(header)} both give the {role.name}")
        try:
            columns[role] = Column(at, _KM_PLUS_M if _is_stationed(sheet, at, role) else unit_of(header, role))
        except InputError as error:
            place = "" if sheet.delimiter else f"sheet {shown(sheet.name)}, "
            raise InputError(f"{place}column {sheet.heading(at)}: {error}") from None
    return Table(sheet, columns, above)


def _is_stationed(sheet: Sheet, at: int, role: Role) -> bool:
    cells = (row.cells[at] for row in sheet.rows[1:] if at < len(row.cells))
    return role in (POSITION, END) and any(isinstance(cell, str) and _STATIONED.fullmatch(cell) for cell in cells)


def _role_of(header: str, roles: Sequence[Role]) -> Role | None:
    return next((role for role in roles if unit_text(header, role) is not None), None)
