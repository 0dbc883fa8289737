"""A line from a table: each row holds from its position to the next one, and the last row marks the end.

Where rows say in a column of their own where they end, the last one holds until there, and they must join.
A blank cell means that nothing changes there. Positions count from the first row.
"""

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.formats.tables.cells import Row, is_no, name_in
from tgvdp.formats.tables.roles import END, GRADIENT, POSITION, RADIUS, SPEED, STOP, Role
from tgvdp.formats.tables.table import Table
from tgvdp.model.checks import plain_text
from tgvdp.model.track import Curve, Gradient, Place, SpeedLimit, Track
from tgvdp.units import KILO, mps_to_kmh

#: Columns that a line can have.
ROLES = (POSITION, END, SPEED, GRADIENT, RADIUS, STOP)

#: Positions that differ by less are the same: km and m are rounded differently.
SAME_M = 1e-6
#: How a line whose mileage falls is written.
_AGAINST_MILEAGE = "against the mileage write how far each row lies from the first one, + uphill in that order"


class _Placed(NamedTuple):
    """Rows with their positions from the first one, m, and where the line ends."""

    rows: list[tuple[float, Row]]
    length_m: float


def make_track(table: Table, name: str, line_speed_mps: float | None, notes: tuple[str, ...] = ()) -> Track:
    """Make a track of a table.

    Parameters
    ----------
    table : Table
    name : str
    line_speed_mps : float, optional
        Limit where the table gives none.
    notes : tuple of str
        On the file that the table stands in.

    Raises
    ------
    InputError
        When a column is missing, a cell is no number of its unit, positions decrease, or rows do not join.
    """
    placed = _placed(table)
    rows, length_m = placed
    limits, remarks = _limits(table, placed, line_speed_mps)
    gradients = _values(table, placed, GRADIENT, 0.0)
    radii = [(at_m, radius_m or math.inf) for at_m, radius_m in _values(table, placed, RADIUS, math.inf)]
    stops_m = {at_m for at_m, row in rows if not is_no(table.text(row, STOP))}
    if STOP in table.columns:
        stops_m |= {0.0, length_m}
    names = {at_m: text for at_m, row in rows if (text := plain_text(name_in(table.text(row, STOP))))}
    start_m = table.number(rows[0][1], POSITION) or 0.0
    if start_m:
        remarks.append(f"positions count from the first row, which is at {start_m / KILO:.9g} km")
    return Track(
        name=name,
        length_m=length_m,
        speed_limits=tuple(SpeedLimit(*row) for row in limits),
        gradients=tuple(Gradient(*row) for row in gradients),
        curves=tuple(Curve(at_m, radius_m, radius_m) for at_m, radius_m in radii),
        stops_m=tuple(sorted(stops_m)),
        places=tuple(Place(*place) for place in sorted(names.items())),
        notes=(*remarks, *_idle(table, placed), *table.notes, *notes),
    )


def _placed(table: Table) -> _Placed:
    starts = starts_m(table)
    end_m = joined_m(table, starts) if END in table.columns else starts[-1] if starts else 0.0
    if not starts or not end_m > starts[0]:
        raise InputError(
            f"column {table.sheet.heading(table.need(POSITION).at)}: "
            "needs two rows at different positions, the last one at the end"
        )
    rows = [(at_m - starts[0], row) for at_m, row in zip(starts, table.rows, strict=True)]
    return _Placed(rows, end_m - starts[0])


def starts_m(table: Table) -> list[float]:
    """Positions of the rows as they stand there, which must not decrease."""
    table.need(POSITION)
    starts = [_needed_m(table, row, POSITION) for row in table.rows]
    for (before_m, here_m), row in zip(pairwise(starts), table.rows[1:], strict=True):
        if here_m < before_m:
            message = f"positions must not decrease, got {here_m:.12g} m after {before_m:.12g} m"
            if all(after_m <= one_m for one_m, after_m in pairwise(starts)):  # nor is it said which way gradients rise
                message = f"{message}: {_AGAINST_MILEAGE}"
            raise table.bad(row, POSITION, message)
    return starts


def _needed_m(table: Table, row: Row, role: Role) -> float:
    value_m = table.number(row, role)
    if value_m is None:
        raise table.blank(row, role)
    return value_m


def joined_m(table: Table, starts: list[float], *, may_gap: bool = False) -> float:
    """Where the last of some rows ends, each of which begins where the one before it ends, or behind that."""
    end_m = starts[0] if starts else 0.0
    for row, start_m in zip(table.rows, starts, strict=True):
        if start_m < end_m - SAME_M or (start_m > end_m + SAME_M and not may_gap):
            what = "a gap" if start_m > end_m else "an overlap"
            message = f"{what}: begins at {start_m:.12g} m, the row before ends at {end_m:.12g} m"
            raise table.bad(row, POSITION, message)
        end_m = _needed_m(table, row, END)
        if end_m < start_m:
            raise table.bad(row, END, f"must not lie before {start_m:.12g} m, where the row begins, got {end_m:.12g} m")
    return end_m


def _idle(table: Table, placed: _Placed) -> Iterator[str]:
    """Say which values of rows at the end hold nowhere."""
    behind = [row for at_m, row in placed.rows if at_m >= placed.length_m]
    before = [row for at_m, row in placed.rows if at_m < placed.length_m]
    for role in (SPEED, GRADIENT, RADIUS) if behind else ():
        values = [value for row in behind if (value := table.number(row, role))]
        held = next((value for row in reversed(before) if (value := table.number(row, role)) is not None), None)
        if any(value not in (held, math.inf) for value in values):
            yield f"the last row marks the end: its {role.name} holds nowhere"


def _limits(table: Table, placed: _Placed, line_speed_mps: float | None) -> tuple[list[tuple[float, float]], list[str]]:
    if SPEED not in table.columns and line_speed_mps is None:
        table.need(SPEED)
    given = _values(table, placed, SPEED, None)
    if given and given[0][0] == 0.0:
        return given, []
    until_m = given[0][0] if given else placed.length_m
    if line_speed_mps is None:
        message = "no speed limit from here on; --line-speed KMH gives one where there is none"
        raise table.bad(placed.rows[0][1], SPEED, message)
    note = f"no limit before {until_m:.12g} m: limit is the line speed asked for, {mps_to_kmh(line_speed_mps):g} km/h"
    return [(0.0, line_speed_mps), *given], [note]


def _values(table: Table, placed: _Placed, role: Role, before: float | None) -> list[tuple[float, float]]:
    """Where values of a column begin, m; with a value for what lies before the first one, if that is known.

    Of two values at one position the first may end a step, by repeating what holds before it.
    """
    values: list[tuple[float, float]] = []
    last_m, last = math.nan, math.nan
    for at_m, row in placed.rows:
        value = table.number(row, role)
        if value is None:
            continue
        if at_m == last_m and value != last and not (values and values[-1][0] < at_m):
            raise table.bad(
                row, role, f"a second value at one position, got {table.text(row, role)} {table.need(role).unit}"
            )
        last_m, last = at_m, value
        if role is SPEED and value <= 0.0 and at_m < placed.length_m:
            unit = table.need(role).unit
            raise table.bad(row, role, f"must be above 0 {unit}, got {table.text(row, role)} {unit}")
        if at_m < placed.length_m and (not values or values[-1][1] != value):
            values.append((at_m, value))
    if values and values[0][0] > 0.0 and before is not None:
        values.insert(0, (0.0, before))
    return values
