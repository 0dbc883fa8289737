"""Files as sheets of text cells: CSV with commas, semicolons or tabs, and the sheets of an Excel workbook."""

import csv
import io
import zipfile
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from tgvdp.errors import MissingExtraError
from tgvdp.formats.syntax.reading import LARGEST_BYTES, Document, bad

DELIMITERS = (";", "\t", ",")
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
#: What spreadsheets of Western Europe write when they are not asked for UTF-8; it has ‰.
_ANSI = "cp1252"
_SEPARATOR = "sep="  # a first line for spreadsheets that names the separator
_MOST_ROWS = 200_000
_MOST_COLUMNS = 200


class Row(NamedTuple):
    """Cells of one line or row of a file, and its number there."""

    number: int
    cells: tuple[str, ...]


class Sheet(NamedTuple):
    """A table: its name, how it was cut into cells, and its rows without blank and comment lines, the header first.

    ``delimiter`` is empty for sheets of a workbook.
    """

    name: str
    delimiter: str
    rows: tuple[Row, ...]


def sheets_of(document: Document) -> list[Sheet]:
    """Sheets of a file that hold anything; a CSV file is one.

    Raises
    ------
    InputError
        When it is no workbook, no text, or too large.
    MissingExtraError
        When it is a workbook and openpyxl is not installed.
    """
    if document.syntax == "XLSX":
        return list(_workbook(document))
    text = _decoded(document)
    first, _, rest = text.partition("\n")
    delimiter = ""
    if first.strip().lower().startswith(_SEPARATOR):
        delimiter = first.strip()[len(_SEPARATOR) :]
        text = f"\n{rest}"  # lines keep their numbers
    sheet = _cut(document.path, text, delimiter if len(delimiter) == 1 else _delimiter_of(text))
    return [sheet] if sheet.rows else []


def _delimiter_of(text: str) -> str:
    """Character that cuts the header into most cells."""
    header = next((line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")), "")
    return max(DELIMITERS, key=lambda delimiter: len(next(csv.reader([header], delimiter=delimiter), [])))


def _decoded(document: Document) -> str:
    encoding = "utf-16" if document.data.startswith(_UTF_16) else "utf-8-sig"
    try:
        return document.data.decode(encoding)
    except UnicodeDecodeError:
        pass
    try:
        return document.data.decode(_ANSI)
    except UnicodeDecodeError as error:
        raise bad(document.path, f"is neither UTF-8, UTF-16 nor Windows-1252 text (byte {error.start})") from None


def _cut(path: Path, text: str, delimiter: str) -> Sheet:
    rows = []
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    try:
        for cells in reader:
            stripped = tuple(cell.strip() for cell in cells)
            if any(stripped) and not stripped[0].startswith("#"):
                rows.append(Row(reader.line_num, stripped))
            if len(rows) > _MOST_ROWS or len(stripped) > _MOST_COLUMNS:
                raise bad(path, f"holds more than {_MOST_ROWS} rows or {_MOST_COLUMNS} columns")
    except csv.Error as error:
        raise bad(path, f"line {reader.line_num}: is no CSV: {error}") from None
    return Sheet(path.stem, delimiter, tuple(rows))


def _workbook(document: Document) -> Iterator[Sheet]:
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
        content = [(sheet.title, list(_filled(sheet))) for sheet in book.worksheets]
    except Exception as error:  # whatever openpyxl makes of a broken workbook
        raise bad(path, f"is no Excel workbook (.xlsx) that can be read ({type(error).__name__})") from None
    for title, rows in content:
        if len(rows) > _MOST_ROWS:
            raise bad(path, f"sheet {title!r} holds more than {_MOST_ROWS} rows")
        if rows:
            yield Sheet(title, "", tuple(rows))


def _filled(sheet: Any) -> Iterator[Row]:
    """Rows of a sheet that hold anything, up to one more than the most."""
    for number, values in enumerate(
        sheet.iter_rows(values_only=True, max_row=_MOST_ROWS + 1, max_col=_MOST_COLUMNS), 1
    ):
        cells = tuple(_text(value) for value in values)
        if any(cells) and not cells[0].startswith("#"):
            yield Row(number, cells)


def _text(value: Any) -> str:
    """A cell as text; numbers so that they read back exactly."""
    if value is None:
        return ""
    return repr(value) if isinstance(value, float) else str(value).strip()
