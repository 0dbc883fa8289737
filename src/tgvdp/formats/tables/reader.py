"""Tables as files: which of them are lines, one sheet of a workbook each, and which are effort curves."""

from functools import partial

from tgvdp.errors import InputError
from tgvdp.formats.content import Content, Item
from tgvdp.formats.syntax.reading import Document, errors_named, shown
from tgvdp.formats.tables import effort, line
from tgvdp.formats.tables.cells import Sheet
from tgvdp.formats.tables.roles import POSITION
from tgvdp.formats.tables.sheets import sheets_of
from tgvdp.formats.tables.table import listed, read_table

_FORMATS = {"CSV": "CSV table", "XLSX": "Excel table"}


def open_document(document: Document) -> Content | None:
    """Tell what a table holds; None when the document is none.

    Raises
    ------
    InputError
        When no sheet has a position, or a column has no unit.
    """
    form = _FORMATS.get(document.syntax)
    if form is None:
        return None
    with errors_named(document.path):
        sheets = sheets_of(document)
        tables = [table for sheet in sheets if POSITION in (table := read_table(sheet, line.ROLES)).columns]
        if not tables:
            raise _no_line(sheets)
    lines = [table.sheet.name for table in tables]
    others = [shown(sheet.name) for sheet in sheets if sheet.name not in lines]
    notes = (f"sheets without positions, not used: {listed(others)}",) if others else ()
    items = tuple(
        Item(name, partial(line.make_track, table, name, document.line_speed_mps, notes))
        for name, table in zip(lines, tables, strict=True)
    )
    return Content(format=form, items={"track": items}, takes_line_speed=True)


def _no_line(sheets: list[Sheet]) -> InputError:
    """Say what a file without positions is, or what it lacks."""
    for sheet in sheets:
        if any(read_table(sheet, roles).columns.keys() == set(roles) for roles in effort.ROLES.values()):
            return InputError('holds an effort curve; a native train takes it as traction = { file = "NAME" }')
    if not sheets:
        return InputError("holds no rows")
    return read_table(sheets[0], line.ROLES).lacks(POSITION)
