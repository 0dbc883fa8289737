"""An effort curve from a table of speed and effort: linear between rows, constant after the last one."""

from tgvdp.errors import InputError
from tgvdp.formats.syntax.reading import Document, bad, errors_named
from tgvdp.formats.tables.cells import Row
from tgvdp.formats.tables.roles import EFFORT, SPEED, Role
from tgvdp.formats.tables.sheets import sheets_of
from tgvdp.formats.tables.table import Table, read_table
from tgvdp.model.effort import EffortCurve
from tgvdp.units import mps_to_kmh

#: Columns that an effort curve has, of traction or braking.
ROLES = {field: (SPEED, effort) for field, effort in EFFORT.items()}


def read_effort(document: Document, field: str, part: str | None = None) -> tuple[EffortCurve, tuple[str, ...]]:
    """Read an effort curve, of a workbook the sheet of a name or its only one with such columns; and notes on it.

    Parameters
    ----------
    document : Document
    field : {"traction", "braking"}
        What it is the effort of: where a table has both, the column of that is read.
    part : str, optional
        Name of a sheet.

    Raises
    ------
    InputError
        When it is no table, a column is missing, or a cell is no number of its unit.
    """
    path = document.path
    if document.syntax not in ("CSV", "XLSX"):
        raise bad(path, f"must be a table of speed and effort, as CSV or Excel, got {document.syntax}")
    with errors_named(path):
        roles = ROLES[field]
        tables = [read_table(sheet, roles) for sheet in sheets_of(document) if part in (None, sheet.name)]
        whole = [table for table in tables if table.columns.keys() == set(roles)] or tables
        if len(whole) != 1:
            if whole:
                raise InputError(f"holds {len(whole)} sheets with an effort curve, choose one as FILE#SHEET")
            raise InputError("holds no rows" if part is None else f"holds no sheet {part!r}")
        return make_effort(whole[0], roles)


def make_effort(table: Table, roles: tuple[Role, Role]) -> tuple[EffortCurve, tuple[str, ...]]:
    """Make an effort curve of a table, and notes on what was not used or assumed."""
    for role in roles:
        table.need(role)
    if not table.rows:
        raise InputError("holds no rows below the header")
    points: list[tuple[float, float]] = []
    for row in table.rows:
        speed_mps, effort_n = (_not_negative(table, row, role) for role in roles)
        _require_next(table, row, [speed for speed, _ in points[-2:]], speed_mps)
        points.append((speed_mps, effort_n))
    notes = table.notes
    if points and points[0][0]:  # tables often start at a few km/h
        notes = (*notes, f"effort below {mps_to_kmh(points[0][0]):.6g} km/h is taken to be as large as there")
        points.insert(0, (0.0, points[0][1]))
    return EffortCurve.from_points(points), notes


def _require_next(table: Table, row: Row, before_mps: list[float], speed_mps: float) -> None:
    """Refuse a speed that is lower than the one before it, or the third of its kind: two are a jump."""
    if not before_mps:
        return
    text = f"{mps_to_kmh(speed_mps):.6g} km/h"
    if speed_mps < before_mps[-1]:
        after = f"{mps_to_kmh(before_mps[-1]):.6g} km/h"
        raise table.bad(row, SPEED, f"speeds must not decrease, got {text} after {after}")
    if before_mps == [speed_mps, speed_mps]:
        raise table.bad(row, SPEED, f"a speed is given twice at most, where the effort jumps, got {text} a third time")


def _not_negative(table: Table, row: Row, role: Role) -> float:
    value = table.number(row, role)
    if value is None:
        raise table.blank(row, role)
    if value < 0.0:
        unit = table.need(role).unit
        raise table.bad(row, role, f"must be at least 0 {unit}, got {table.text(row, role)} {unit}")
    return value
