"""Tables as files: which of them are lines, one sheet of a workbook each, and which are effort curves."""

from functools import partial

from tgvdp.errors import InputError
from tgvdp.formats.content import Content, Item
from tgvdp.formats.syntax.reading import Document, errors_named
from tgvdp.formats.tables import effort, line
from tgvdp.formats.tables.columns import POSITION, read_table
from tgvdp.formats.tables.sheets import Sheet, sheets_of

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
    speed_mps = document.line_speed_mps
    made = [(table.sheet.name, partial(line.make_track, table, table.sheet.name, speed_mps)) for table in tables]
    items = tuple(Item(name, make) for name, make in made)
    return Content(format=form, items={"track": items}, takes_line_speed=True)


def _no_line(sheets: list[Sheet]) -> InputError:
    """Say what a file without positions is, or what it lacks."""
    for sheet in sheets:
        if read_table(sheet, effort.ROLES).columns.keys() == set(effort.ROLES):
            return InputError('holds an effort curve; a native train takes it as traction = { file = "NAME" }')
    if not sheets:
        return InputError("holds no rows")
    return read_table(sheets[0], line.ROLES).lacks(POSITION)
