"""Tables as files: which of them are lines or timetables, one sheet of a workbook each, and which are effort curves."""

from functools import partial

from tgvdp.errors import InputError
from tgvdp.formats.content import Content, Item, Kind
from tgvdp.formats.syntax.reading import Document, errors_named, shown
from tgvdp.formats.tables import effort, line, timetable
from tgvdp.formats.tables.cells import Sheet
from tgvdp.formats.tables.parts import are_parts, gives, join
from tgvdp.formats.tables.roles import POSITION, SPEED
from tgvdp.formats.tables.sheets import sheets_of
from tgvdp.formats.tables.table import Table, listed, read_table

_ROLES = (*line.ROLES, *timetable.ROLES)
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
        tables = [table for sheet in sheets if POSITION in (table := read_table(sheet, _ROLES)).columns]
        if not tables:
            raise _no_line(sheets)
        timetables = [table for table in tables if timetable.is_timetable(table)]
        timed = [table.sheet.name for table in timetables]
        lines = [table for table in tables if gives(table) or table.sheet.name not in timed]
        if len(timed) == len(tables):  # without limits they are a line by a line speed only
            has_limits = [table for table in lines if SPEED in table.columns]
            lines = has_limits if document.line_speed_mps is None else lines or tables
        others = [shown(sheet.name) for sheet in sheets if sheet.name not in [table.sheet.name for table in tables]]
        notes = (f"sheets without positions, not used: {listed(others)}",) if others else ()
        default, items, start_m = _lines(document, lines, notes)
    journeys = [
        Item(table.sheet.name, partial(timetable.make_journey, table, table.sheet.name, start_m, notes))
        for table in timetables
    ]
    held: dict[Kind, tuple[Item, ...]] = {"track": tuple(items), "journey": tuple(journeys)}
    kinds = {kind: items for kind, items in held.items() if items}
    return Content(format=form, items=kinds, default=default, takes_line_speed=True)


def _lines(document: Document, tables: list[Table], notes: tuple[str, ...]) -> tuple[str | None, list[Item], float]:
    """The lines of a file, the one that it is as a whole, and where that begins by its positions, m."""
    without = [shown(table.sheet.name) for table in tables if SPEED not in table.columns]
    alone = (f"sheets without limits, not used: {listed(without)}", *notes) if without else notes
    items = [
        Item(table.sheet.name, partial(line.make_track, table, table.sheet.name, document.line_speed_mps, told))
        for table in tables
        for told in [alone if SPEED in table.columns else notes]
    ]
    default = None
    if are_parts(tables):
        default = document.path.stem
        whole, told = join(tables, default)
        make = partial(line.make_track, whole, default, document.line_speed_mps, (*told, *notes))
        items.insert(0, Item(default, make))
        tables = [whole]
    starts = line.starts_m(tables[0]) if len(tables) == 1 else []
    return default, items, starts[0] if starts else 0.0


def _no_line(sheets: list[Sheet]) -> InputError:
    """Say what a file without positions is, or what it lacks."""
    for sheet in sheets:
        if any(read_table(sheet, roles).columns.keys() == set(roles) for roles in effort.ROLES.values()):
            return InputError('holds an effort curve; a native train takes it as traction = { file = "NAME" }')
    if not sheets:
        return InputError("holds no rows")
    return read_table(sheets[0], _ROLES).lacks(POSITION)
