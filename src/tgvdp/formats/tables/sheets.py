"""Files as sheets of cells: CSV with commas, semicolons or tabs, and the sheets of an Excel workbook."""

import csv
import io
from pathlib import Path

from tgvdp.formats.syntax.reading import Document, bad
from tgvdp.formats.tables.cells import Row, Sheet, is_comment, text_cell
from tgvdp.formats.tables.workbook import MOST_COLUMNS, MOST_ROWS, read_workbook

DELIMITERS = (";", "\t", ",")
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
#: What spreadsheets of Western Europe write when they are not asked for UTF-8; it has ‰.
_ANSI = "cp1252"
_SEPARATOR = "sep="  # a first line for spreadsheets that names the separator


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
        return list(read_workbook(document))
    text = _decoded(document)
    first, _, rest = text.partition("\n")
    delimiter = ""
    if first.strip().lower().startswith(_SEPARATOR):
        delimiter = first.strip()[len(_SEPARATOR) :]
        text = f"\n{rest}"  # lines keep their numbers
    sheet = _cut(document.path, text, delimiter if len(delimiter) == 1 else delimiter_of(text))
    return [sheet] if sheet.rows else []


def delimiter_of(text: str) -> str:
    """Character that cuts the header into most cells: the first line that any cuts, as titles are of one cell."""

    def cut(line: str, delimiter: str) -> tuple[str, ...]:
        return tuple(cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), []))

    for line in text.splitlines():
        cuts = {delimiter: cut(line, delimiter) for delimiter in DELIMITERS}
        best = max(DELIMITERS, key=lambda delimiter: len(cuts[delimiter]))
        if sum(map(bool, cuts[best])) > 1 and not is_comment(cuts[best]):
            return best
    return DELIMITERS[0]


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
    rows: list[Row] = []
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    try:
        for texts in reader:
            cells = tuple(map(text_cell, texts))
            if any(cells) and not is_comment(cells):
                rows.append(Row(reader.line_num, cells))
            if len(rows) > MOST_ROWS or len(cells) > MOST_COLUMNS:
                raise bad(path, f"holds more than {MOST_ROWS} rows or {MOST_COLUMNS} columns")
    except csv.Error as error:
        raise bad(path, f"line {reader.line_num}: is no CSV: {error}") from None
    return Sheet(path.stem, delimiter, tuple(rows))
