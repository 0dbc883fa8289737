"""The sheets of an Excel workbook as cells: values as they are stored, and what their formats make of them."""

import io
import re
import zipfile
from collections.abc import Iterator
from decimal import Decimal
from functools import lru_cache
from importlib import import_module
from typing import Any, NamedTuple

from tgvdp.errors import MissingExtraError
from tgvdp.formats.syntax.reading import LARGEST_BYTES, Document, bad
from tgvdp.formats.tables.cells import Cell, Fault, Number, Row, Sheet, is_comment, text_cell

MOST_ROWS = 200_000
MOST_COLUMNS = 200

#: A formula in the XML of a sheet.
_FORMULA = re.compile(rb"<(\w+:)?f[ />]")
#: Texts, colours and single characters in the format of a number, which say nothing about its size.
_LITERAL = re.compile(r'"[^"]*"|\[[^\]]*\]|[\\_*].')
#: Commas behind the last digit of a format: each shows a thousandth of the number.
_SCALED = re.compile(r"[0#?],+(?![0#?,])")
#: What surrounds characters that a format shows as they are.
_QUOTES = re.compile(r"[\"\\]|\[[^\]]*\]|[_*].")
#: Formats that draw a position as kilometres, a plus and three digits of metres: it is stored in metres.
_STATIONED = re.compile(r"[0#?]\+000(?:\.[0#?]+)?(?![0#?+])")
#: A mark drawn between the digits of a number, which makes another one of it for those who see it.
_DRAWN = re.compile(r'[0#?](?:\\[.,+]|"[.,+]"|\+)[0#?]')
_NO_VALUE = "is a formula without a stored value: open the workbook in a spreadsheet and save it"


def read_workbook(document: Document) -> Iterator[Sheet]:
    """Sheets of a workbook that hold anything.

    Raises
    ------
    InputError
        When it is no workbook, or too large.
    MissingExtraError
        When openpyxl is not installed.
    """
    path = document.path
    try:
        openpyxl = import_module("openpyxl")
    except ImportError:
        raise MissingExtraError(f"{path}: reading Excel needs openpyxl: pip install 'tgvdp[formats]'") from None
    try:
        with zipfile.ZipFile(io.BytesIO(document.data)) as archive:
            unpacked = sum(entry.file_size for entry in archive.infolist())
    except zipfile.BadZipFile:
        raise bad(path, "is no Excel workbook (.xlsx)") from None
    if unpacked > LARGEST_BYTES:
        raise bad(path, f"unpacks to more than {LARGEST_BYTES / 1e6:g} MB, got {unpacked / 1e6:.1f} MB")
    try:
        book = openpyxl.load_workbook(io.BytesIO(document.data), read_only=True, data_only=True)
        formulas = _formulas(openpyxl, document.data)
        content = [(sheet.title, list(_filled(sheet, formulas.get(sheet.title, set())))) for sheet in book.worksheets]
    except Exception as error:  # whatever openpyxl makes of a broken workbook
        raise bad(path, f"is no Excel workbook (.xlsx) that can be read ({type(error).__name__})") from None
    for title, rows in content:
        if len(rows) > MOST_ROWS:
            raise bad(path, f"sheet {title!r} holds more than {MOST_ROWS} rows")
        if rows:
            yield Sheet(title, "", tuple(rows))


def _formulas(openpyxl: Any, data: bytes) -> dict[str, set[tuple[int, int]]]:
    """Row and column of each formula by sheet; openpyxl gives either formulas or their values."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        if not any(_FORMULA.search(archive.read(name)) for name in archive.namelist() if name.endswith(".xml")):
            return {}
    book = openpyxl.load_workbook(io.BytesIO(data), read_only=True)
    return {
        sheet.title: {(cell.row, cell.column) for row in _rows(sheet) for cell in row if cell.data_type == "f"}
        for sheet in book.worksheets
    }


def _rows(sheet: Any) -> Iterator[Any]:
    """Rows of a sheet, up to one more than the most, each as far as it goes: sheets may be wrong about their size."""
    sheet.reset_dimensions()
    return (row[:MOST_COLUMNS] for row in sheet.iter_rows(max_row=MOST_ROWS + 1))


def _filled(sheet: Any, formulas: set[tuple[int, int]]) -> Iterator[Row]:
    """Rows of a sheet that hold anything."""
    for number, given in enumerate(_rows(sheet), 1):
        cells = tuple(
            Fault("", _NO_VALUE) if _lacks_value(cell) and (number, at) in formulas else _cell(cell)
            for at, cell in enumerate(given, 1)
        )
        if any(cells) and not is_comment(cells):
            yield Row(number, cells)


def _lacks_value(cell: Any) -> bool:
    """Whether a cell has no stored value; where that is an empty text, its type says so."""
    return cell.value is None and cell.data_type == "n"


def _cell(cell: Any) -> Cell:
    value = cell.value
    if value is None:
        return ""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return text_cell(str(value))
    drawn = _drawn(cell.number_format or "")
    if drawn.is_stationed:
        return _stationed(value)
    if drawn.misleads:
        return Fault(str(value), f"is shown {drawn.misleads} by its format, got {value}: give it as it is")
    try:
        return Number(float(value), drawn.is_percent)
    except OverflowError:
        return str(value)


class _Drawn(NamedTuple):
    """What the format of a number makes of it: how it shows another number than the one that is stored, if it does."""

    is_percent: bool
    is_stationed: bool
    misleads: str


@lru_cache(maxsize=64)
def _drawn(number_format: str) -> _Drawn:
    plain = _LITERAL.sub("", number_format)
    is_stationed = _STATIONED.search(_QUOTES.sub("", number_format)) is not None
    scaled = "in thousands" if _SCALED.search(plain) else ""
    marked = f"as {number_format}" if _DRAWN.search(number_format) else ""
    return _Drawn("%" in plain, is_stationed, scaled or marked)


def _stationed(value: float) -> str:
    """Text of a position in metres as its cell shows it, with all of its digits: 12+345."""
    km, m = divmod(abs(Decimal(repr(value))), 1000)
    whole, point, decimals = f"{m:f}".partition(".")
    return f"{'-' if value < 0 else ''}{km:f}+{whole:0>3}{point}{decimals}"
