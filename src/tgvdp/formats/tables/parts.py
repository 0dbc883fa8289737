"""A line whose columns stand in sheets of their own: limits in one, gradients, curves or stops in others.

Their rows are put into one table, by the positions that all of them count alike. Limits tell from where to where the
line goes; gradients, curves and stops hold on, and are level and straight where rows with ends leave a gap.
"""

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.tables.cells import Cell, Number, Row, Sheet
from tgvdp.formats.tables.line import SAME_M, joined_m, starts_m
from tgvdp.formats.tables.roles import END, GRADIENT, POSITION, RADIUS, SPEED, STOP, Role
from tgvdp.formats.tables.table import Column, Table
from tgvdp.units import KILO

_GIVEN = (SPEED, GRADIENT, RADIUS, STOP)
#: What holds in gaps.
_NOTHING = {GRADIENT: 0.0, RADIUS: math.inf}


class _Part(NamedTuple):
    """A table, where its rows start, and where it ends."""

    table: Table
    starts_m: list[float]
    end_m: float


def gives(table: Table) -> bool:
    """Whether a table gives anything of a line."""
    return any(role in table.columns for role in _GIVEN)


def are_parts(tables: Sequence[Table]) -> bool:
    """Whether each of several tables gives something of a line that none of the others does."""
    given = [set(_GIVEN) & table.columns.keys() for table in tables]
    return len(tables) > 1 and all(given) and sum(map(len, given)) == len(set().union(*given))


def join(tables: Sequence[Table], name: str) -> tuple[Table, tuple[str, ...]]:
    """Join tables that are parts of one line, and note what was left out.

    Raises
    ------
    InputError
        When a cell is no number of its unit, positions decrease, or rows overlap.
    """
    parts = [_part(table) for table in tables]
    spans = [part for part in parts if SPEED in part.table.columns] or parts
    start_m = min(part.starts_m[0] for part in spans)
    end_m = max(part.end_m for part in spans)
    rows: dict[float, dict[Role, Cell]] = defaultdict(dict, {start_m: {}, end_m: {}})
    for part in parts:
        for role in part.table.columns.keys() & _GIVEN:
            for at_m, cell in _cells(part, role):
                if at_m <= end_m and (at_m >= start_m or role is not STOP):
                    rows[max(at_m, start_m)][role] = cell
    columns = {POSITION: "m", SPEED: "m/s", GRADIENT: "‰", RADIUS: "m", STOP: ""}
    held = [POSITION, *(role for role in _GIVEN if any(role in part.table.columns for part in parts))]
    header = Row(1, tuple(role.name for role in held))
    body = (
        Row(number, (Number(at_m, False), *(rows[at_m].get(role, "") for role in held[1:])))
        for number, at_m in enumerate(sorted(rows), 2)
    )
    table = Table(
        Sheet(name, "", (header, *body)), {role: Column(at, columns[role]) for at, role in enumerate(held)}, ()
    )
    return table, tuple(_notes(parts, start_m, end_m))


def _part(table: Table) -> _Part:
    starts = starts_m(table)
    if not starts:
        raise InputError(f"sheet {shown(table.sheet.name)}: no rows below the header")
    if END not in table.columns:
        return _Part(table, starts, starts[-1])
    return _Part(table, starts, joined_m(table, starts, may_gap=SPEED not in table.columns))


def _cells(part: _Part, role: Role) -> Iterator[tuple[float, Cell]]:
    """Where values of a column begin, m, and they in SI; so do those that hold in gaps."""
    table, starts, end_m = part
    last_m = last = before = math.nan
    for row, (at_m, next_m) in zip(table.rows, pairwise([*starts, math.inf]), strict=True):
        if role is STOP:
            yield at_m, table.text(row, role)
            continue
        value = table.number(row, role)
        if value is not None:
            if at_m == last_m and value != last and last != before:  # the first one may end a step
                raise table.bad(
                    row, role, f"a second value at one position, got {table.text(row, role)} {table.need(role).unit}"
                )
            if role is SPEED and value <= 0.0 and at_m < end_m:
                unit = table.need(role).unit
                raise table.bad(row, role, f"must be above 0 {unit}, got {table.text(row, role)} {unit}")
            before = before if at_m == last_m else last
            last_m, last = at_m, value
            yield at_m, _cell(value)
        until_m = table.number(row, END) if END in table.columns else None
        if until_m is not None and role in _NOTHING and until_m < next_m - SAME_M:
            yield until_m, _cell(_NOTHING[role])


def _cell(value: float) -> Cell:
    return Number(value, False) if math.isfinite(value) else "straight"


def _notes(parts: Sequence[_Part], start_m: float, end_m: float) -> Iterator[str]:
    yield f"the line is put together of the sheets {', '.join(shown(part.table.sheet.name) for part in parts)}"
    for part in parts:
        place = f"sheet {shown(part.table.sheet.name)}"
        yield from (f"{place}: {note}" for note in part.table.notes)
        if part.starts_m[0] < start_m or part.end_m > end_m:
            spans = f"{part.starts_m[0] / KILO:.9g} to {part.end_m / KILO:.9g} km"
            line = f"{start_m / KILO:.9g} to {end_m / KILO:.9g} km"
            yield f"{place}: goes from {spans}, the line with its limits from {line}"
