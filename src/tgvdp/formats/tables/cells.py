"""What stands in the cells of a table, whatever its file: text, numbers of a workbook, and what is neither."""

import re
from typing import NamedTuple

from tgvdp.formats.syntax.numbers import read_number
from tgvdp.formats.syntax.reading import shown

#: What spreadsheets of several languages show where a formula fails: #N/A, #REF!, #DIV/0!, #NAME?, #WERT!, #NV.
_ERROR = re.compile(r"#(?:N/[A-Z]!?|NV|[¡¿]?[A-ZÀ-Þ0]+(?:/0)?[!?])")

#: What programs write where a value is missing. As it is written: "Nan" is a town.
_MISSING = frozenset(("NA", "N/A", "n/a", "n.a.", "<NA>", "NaN", "nan", "NULL", "null", "nil", "None"))

#: What people draw where nothing is.
DASHES = frozenset(("-", "--", "---", "–", "—"))

#: Marks that say no, beside numbers that are 0; anything else says yes, names included.
_NO = DASHES | frozenset((
    *("", "n", "no", "none", "no stop", "false"),
    *("nein", "kein", "keine", "keiner", "kein halt", "non", "nej", "nee", "nie", "falsch", "faux"),
    *("pass", "passes", "passing", "through", "non-stop", "durchfahrt"),
))  # fmt: skip

#: Marks that say yes, and are no names.
_YES = frozenset((
    *("x", "1", "1.0", "1,0", "y", "yes", "true", "+", "*", "✓", "stop", "stops", "halt", "hält"),
    *("ja", "j", "oui", "o", "sì", "sí", "si", "wahr", "vrai"),
))  # fmt: skip


class Number(NamedTuple):
    """A number of a workbook, as it is stored, and whether its format shows it as per cent: 0.012 is 1.2 %."""

    value: float
    is_percent: bool

    def __str__(self) -> str:
        """As a spreadsheet shows it."""
        return f"{self.percent:.15g} %" if self.is_percent else f"{self.value:.15g}"

    @property
    def percent(self) -> float:
        """The number of per cent; a hundred times what is stored would end in other digits."""
        return float(f"{100.0 * self.value:.15g}")


class Fault(NamedTuple):
    """A cell that has no value, and why: it must not pass for a blank one."""

    text: str
    reason: str

    def __str__(self) -> str:
        """As a spreadsheet shows it."""
        return self.text


Cell = str | Number | Fault


class Row(NamedTuple):
    """Cells of one line or row of a file, and its number there."""

    number: int
    cells: tuple[Cell, ...]


class Sheet(NamedTuple):
    """A table: its name, how it was cut into cells, and its rows without blank and comment lines, the header first.

    ``delimiter`` is empty for sheets of a workbook.
    """

    name: str
    delimiter: str
    rows: tuple[Row, ...]

    @property
    def header(self) -> tuple[str, ...]:
        """Cells of the header as text."""
        return tuple(map(str, self.rows[0].cells))

    def heading(self, at: int) -> str:
        """Name a column in messages: by its header, or where it has none by its place."""
        header = self.header[at] if at < len(self.header) else ""
        return shown(header) if header else f"{self._letters(at)} (without a header)"

    def place(self, row: Row, at: int) -> str:
        """Name a cell in messages."""
        if self.delimiter:
            return f"line {row.number}, column {self.heading(at)}"
        return f"sheet {shown(self.name)}, cell {self._letters(at)}{row.number}, column {self.heading(at)}"

    def _letters(self, at: int) -> str:
        """Name of a column in a spreadsheet, A to Z, AA, …; in other files its number."""
        if self.delimiter:
            return str(at + 1)
        letters = ""
        number = at + 1
        while number:
            number, rest = divmod(number - 1, 26)
            letters = chr(ord("A") + rest) + letters
        return letters


def text_cell(text: str) -> Cell:
    """Make a cell of a text."""
    plain = text.strip()
    return Fault(plain, f"holds the error {plain}") if plain.startswith("#") and _ERROR.fullmatch(plain) else plain


def is_comment(cells: tuple[Cell, ...]) -> bool:
    """Whether a row is a comment: its first cell begins with ``#``, and is no header ``#`` of row numbers."""
    first = cells[0]
    return isinstance(first, str) and first.startswith("#") and not (first == "#" and any(cells[1:]))


def is_missing(text: str) -> bool:
    """Whether a cell says that it has no value: it is as good as blank."""
    return text in _MISSING


def is_no(text: str) -> bool:
    """Whether a cell of a column of marks says no."""
    if text.casefold() in _NO:
        return True
    written = read_number(text)
    return written is not None and written.value == 0.0


def name_in(text: str) -> str:
    """The name that a cell of a column of marks gives; empty where it is but a mark."""
    return "" if is_no(text) or text.casefold() in _YES else text
