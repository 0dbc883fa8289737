"""A line from a table: each row holds from its position to the next one, and the last row marks the end.

A blank cell means that nothing changes there. Positions count from the first row.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from tgvdp.errors import InputError
from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.tables.columns import GRADIENT, POSITION, RADIUS, SPEED, STOP, Role, Table, is_no
from tgvdp.formats.tables.sheets import Row
from tgvdp.model.track import Curve, Gradient, SpeedLimit, Track
from tgvdp.units import KILO, mps_to_kmh

#: Columns that a line can have.
ROLES = (POSITION, SPEED, GRADIENT, RADIUS, STOP)

_LONGEST_NOTE = 200


def make_track(table: Table, name: str, line_speed_mps: float | None) -> Track:
    """Make a track of a table.

    Parameters
    ----------
    table : Table
    name : str
    line_speed_mps : float, optional
        Limit where the table gives none.

    Raises
    ------
    InputError
        When a column is missing, a cell is no number of its unit, or positions decrease.
    """
    rows = list(_placed(table))
    length_m = rows[-1][0]
    limits, notes = _limits(table, rows, line_speed_mps)
    gradients = _values(table, rows, GRADIENT, 0.0)
    radii = [(at_m, radius_m or math.inf) for at_m, radius_m in _values(table, rows, RADIUS, math.inf)]
    stops_m = {at_m for at_m, row in rows if STOP in table.columns and not is_no(table.text(row, STOP))}
    if STOP in table.columns:
        stops_m |= {0.0, length_m}
    start_m = table.number(rows[0][1], POSITION) or 0.0
    if start_m:
        notes.append(f"positions count from the first row, which is at {start_m / KILO:.9g} km")
    if table.unknown:
        notes.append(f"columns not used: {', '.join(map(shown, table.unknown))}"[:_LONGEST_NOTE])
    return Track(
        name=name,
        length_m=length_m,
        speed_limits=tuple(SpeedLimit(*row) for row in limits),
        gradients=tuple(Gradient(*row) for row in gradients),
        curves=tuple(Curve(at_m, radius_m, radius_m) for at_m, radius_m in radii),
        stops_m=tuple(sorted(stops_m)),
        notes=tuple(notes),
    )


def _placed(table: Table) -> Iterator[tuple[float, Row]]:
    """Rows with their positions from the first one, m."""
    column = table.need(POSITION)
    at_m = []
    for row in table.rows:
        value_m = table.number(row, POSITION)
        if value_m is None:
            raise table.bad(row, column, "must not be blank")
        at_m.append(value_m)
    for (before_m, here_m), row in zip(pairwise(at_m), table.rows[1:], strict=True):
        if here_m < before_m:
            raise table.bad(row, column, f"positions must not decrease, got {here_m:.12g} m after {before_m:.12g} m")
    if not at_m or not at_m[-1] > at_m[0]:
        raise InputError(
            f"column {shown(column.header)}: needs two rows at different positions, the last one at the end"
        )
    yield from ((value_m - at_m[0], row) for value_m, row in zip(at_m, table.rows, strict=True))


def _limits(
    table: Table, rows: Sequence[tuple[float, Row]], line_speed_mps: float | None
) -> tuple[list[tuple[float, float]], list[str]]:
    if SPEED not in table.columns and line_speed_mps is None:
        table.need(SPEED)
    given = _values(table, rows, SPEED, None)
    if given and given[0][0] == 0.0:
        return given, []
    until_m = given[0][0] if given else rows[-1][0]
    if line_speed_mps is None:
        column = table.need(SPEED)
        raise table.bad(
            rows[0][1], column, "no speed limit from here on; --line-speed KMH gives one where there is none"
        )
    note = f"no limit before {until_m:.12g} m: limit is the line speed asked for, {mps_to_kmh(line_speed_mps):g} km/h"
    return [(0.0, line_speed_mps), *given], [note]


def _values(
    table: Table, rows: Sequence[tuple[float, Row]], role: Role, before: float | None
) -> list[tuple[float, float]]:
    """Where values of a column begin, m; with a value for what lies before the first one, if that is known."""
    values: list[tuple[float, float]] = []
    last_m, last = math.nan, math.nan
    for at_m, row in rows:
        value = table.number(row, role)
        if value is None:
            continue
        if at_m == last_m and value != last:
            raise table.bad(row, table.columns[role], "a second value at one position")
        last_m, last = at_m, value
        if at_m < rows[-1][0] and (not values or values[-1][1] != value):
            values.append((at_m, value))
    if values and values[0][0] > 0.0 and before is not None:
        values.insert(0, (0.0, before))
    return values
