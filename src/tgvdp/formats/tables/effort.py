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
            held = (
                f"{len(whole)} sheets with an effort curve, choose one as FILE#SHEET" if whole else f"no sheet {part!r}"
            )
            raise InputError(f"holds {held}")
        return make_effort(whole[0], roles)


def make_effort(table: Table, roles: tuple[Role, Role]) -> tuple[EffortCurve, tuple[str, ...]]:
    """Make an effort curve of a table, and notes on what was not used or assumed."""
    for role in roles:
        table.need(role)
    points: list[tuple[float, float]] = []
    for row in table.rows:
        speed_mps, effort_n = (_not_negative(table, row, role) for role in roles)
        if points and speed_mps < points[-1][0]:
            speeds_kmh = f"{mps_to_kmh(speed_mps):.6g} km/h after {mps_to_kmh(points[-1][0]):.6g} km/h"
            raise table.bad(row, SPEED, f"speeds must not decrease, got {speeds_kmh}")
        points.append((speed_mps, effort_n))
    notes = table.notes
    if points and points[0][0]:  # tables often start at a few km/h
        notes = (*notes, f"effort below {mps_to_kmh(points[0][0]):.6g} km/h is taken to be as large as there")
        points.insert(0, (0.0, points[0][1]))
    return EffortCurve.from_points(points), notes


def _not_negative(table: Table, row: Row, role: Role) -> float:
    value = table.number(row, role)
    if value is None:
        raise table.bad(row, role, "must not be blank")
    if value < 0.0:
        unit = table.need(role).unit
        raise table.bad(row, role, f"must be at least 0 {unit}, got {table.text(row, role)} {unit}")
    return value
