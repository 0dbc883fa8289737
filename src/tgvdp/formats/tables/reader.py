"""Tables as files: which of them are lines or timetables, one sheet of a workbook each, and which are effort curves."""

from functools import partial

from tgvdp.errors import InputError
from tgvdp.formats.content import Content, Item, Kind, Outline
from tgvdp.formats.syntax.reading import Document, errors_named, listed, shown
from tgvdp.formats.tables import effort, line, timetable
from tgvdp.formats.tables.cells import Sheet
from tgvdp.formats.tables.parts import are_parts, gives, join
from tgvdp.formats.tables.roles import POSITION, SPEED, STOP
from tgvdp.formats.tables.sheets import sheets_of
from tgvdp.formats.tables.table import Table, read_table

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
        tables = [table for sheet in sheets if _is_placed(table := _table(sheet))]
        if not tables:
            raise _no_line(sheets)
        timetables = [table for table in tables if timetable.is_timetable(table)]
        if not document.places and not any(POSITION in table.columns for table in tables):
            return _outline(form, timetables)
        used = [table.sheet.name for table in tables]
        others = [shown(sheet.name) for sheet in sheets if sheet.name not in used]
        notes = (f"sheets without positions, not used: {listed(others)}",) if others else ()
        default, items, start_m = _lines(document, _lines_among(document, tables, timetables), notes)
    journeys = [
        Item(name, partial(timetable.make_journey, document.path, table, name, start_m, document.places, notes))
        for table in timetables
        for name in [table.sheet.name]
    ]
    held: dict[Kind, tuple[Item, ...]] = {"track": tuple(items), "journey": tuple(journeys)}
    kinds = {kind: items for kind, items in held.items() if items}
    return Content(format=form, items=kinds, default=default, takes_line_speed=True)


def _outline(form: str, timetables: list[Table]) -> Content:
    """Timetables that name places alone, where no line is given that has any."""
    lacking: dict[Kind, str] = {
        "journey": "its timetable names places alone, and no line is given that has names (or it lacks a column for the"
        f" {POSITION.name}, such as {POSITION.example})"
    }
    outline = tuple(Outline(table.sheet.name, "timetable", timetable.outlined(table)) for table in timetables)
    return Content(format=form, items={}, lacking=lacking, outline=outline)


def _table(sheet: Sheet) -> Table:
    """Read a sheet; columns that are those of a timetable by name alone are not used, which its notes say."""
    table = read_table(sheet, _ROLES)
    return table if timetable.is_timetable(table) else read_table(sheet, line.ROLES)


def _is_placed(table: Table) -> bool:
    """Whether rows of a table have a place: a position, or for times a name."""
    return POSITION in table.columns or (STOP in table.columns and timetable.is_timetable(table))


def _lines_among(document: Document, tables: list[Table], timetables: list[Table]) -> list[Table]:
    """Tables that are lines, or parts of one."""
    timed = [table.sheet.name for table in timetables]
    placed = [table for table in tables if POSITION in table.columns]
    lines = [table for table in placed if gives(table) or table.sheet.name not in timed]
    if len(timed) < len(tables):
        return lines
    if document.line_speed_mps is None:  # stops and times are a line by a line speed only
        return [table for table in lines if SPEED in table.columns]
    return lines or placed


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
