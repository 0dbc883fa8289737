"""The sheets of an Excel workbook as cells: values as they are stored, and what their formats make of them."""

import io
import re
import zipfile
from collections.abc import Iterator
from functools import lru_cache
from importlib import import_module
from typing import Any

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
    plain = _LITERAL.sub("", cell.number_format or "")
    if _is_scaled(plain):
        return Fault(str(value), f"is shown in thousands by its format, got {value}: give it as it is")
    try:
        return Number(float(value), "%" in plain)
    except OverflowError:
        return str(value)


@lru_cache(maxsize=64)
def _is_scaled(plain: str) -> bool:
    return _SCALED.search(plain) is not None
