"""Tables as files: which of them are lines, one sheet of a workbook each, and which are effort curves."""

from functools import partial

from tgvdp.errors import InputError
from tgvdp.formats.content import Content, Item
from tgvdp.formats.syntax.reading import Document, errors_named, shown
from tgvdp.formats.tables import effort, line
from tgvdp.formats.tables.cells import Sheet
from tgvdp.formats.tables.parts import are_parts, join
from tgvdp.formats.tables.roles import POSITION, SPEED
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
    without = [shown(table.sheet.name) for table in tables if SPEED not in table.columns]
    alone = (f"sheets without limits, not used: {listed(without)}", *notes) if without else notes
    items = [
        Item(name, partial(line.make_track, table, name, document.line_speed_mps, told))
        for name, table in zip(lines, tables, strict=True)
        for told in [alone if SPEED in table.columns else notes]
    ]
    default = None
    if are_parts(tables):
        default = document.path.stem
        with errors_named(document.path):
            whole, told = join(tables, default)
        make = partial(line.make_track, whole, default, document.line_speed_mps, (*told, *notes))
        items.insert(0, Item(default, make))
    return Content(format=form, items={"track": tuple(items)}, default=default, takes_line_speed=True)


def _no_line(sheets: list[Sheet]) -> InputError:
    """Say what a file without positions is, or what it lacks."""
    for sheet in sheets:
        if any(read_table(sheet, roles).columns.keys() == set(roles) for roles in effort.ROLES.values()):
            return InputError('holds an effort curve; a native train takes it as traction = { file = "NAME" }')
    if not sheets:
        return InputError("holds no rows")
    return read_table(sheets[0], line.ROLES).lacks(POSITION)
