"""An effort curve from a table of speed and effort: linear between rows, constant after the last one."""

from tgvdp.errors import InputError
from tgvdp.formats.syntax.reading import Document, bad, errors_named
from tgvdp.formats.tables.columns import EFFORT, SPEED, Table, read_table
from tgvdp.formats.tables.sheets import sheets_of
from tgvdp.model.effort import EffortCurve

#: Columns that an effort curve has.
ROLES = (SPEED, EFFORT)


def read_effort(document: Document, part: str | None = None) -> EffortCurve:
    """Read an effort curve, of a workbook the sheet of a name or its only one with such columns.

    Raises
    ------
    InputError
        When it is no table, a column is missing, or a cell is no number of its unit.
    """
    path = document.path
    if document.syntax not in ("CSV", "XLSX"):
        raise bad(path, f"must be a table of speed and effort, as CSV or Excel, got {document.syntax}")
    with errors_named(path):
        tables = [read_table(sheet, ROLES) for sheet in sheets_of(document) if part in (None, sheet.name)]
        whole = [table for table in tables if table.columns.keys() == set(ROLES)] or tables
        if len(whole) != 1:
            held = (
                f"{len(whole)} sheets with an effort curve, choose one as FILE#SHEET" if whole else f"no sheet {part!r}"
            )
            raise InputError(f"holds {held}")
        return make_effort(whole[0])


def make_effort(table: Table) -> EffortCurve:
    """Make an effort curve of a table."""
    speed, effort = table.need(SPEED), table.need(EFFORT)
    points = []
    for row in table.rows:
        values = table.number(row, SPEED), table.number(row, EFFORT)
        for column, value in zip((speed, effort), values, strict=True):
            if value is None or value < 0.0:
                raise table.bad(row, column, "must not be blank" if value is None else "must be at least 0")
        points.append(values)
    if points and points[0][0]:  # tables often start at a few km/h
        points.insert(0, (0.0, points[0][1]))
    return EffortCurve.from_points([(v, f) for v, f in points if v is not None and f is not None])
