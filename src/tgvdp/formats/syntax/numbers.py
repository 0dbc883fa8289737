"""Numbers as people write them: decimal points or commas, and digits in groups of three.

One number may mean two things: ``1.200`` is 1.2, or 1200 with a mark for thousands. The others beside it tell which.
"""

import math
import re
from collections.abc import Iterable
from typing import NamedTuple

MARKS = ".,"
_SPACES = "' \u2019\u00a0\u2009\u202f"  # what stands between groups of digits besides the two marks
_PLAIN = str.maketrans("\u2212\u2013", "--")
_LONGEST = 400

#: What nearly all numbers are: tables have a million of them. Three decimals may be a group, and are looked at twice.
_USUAL = re.compile(r"[+-]?\d{1,200}(?:([.,])(?!\d{3}$)\d{1,200})?")
_EXPONENT = r"(e[+-]?\d+)?"
#: Digits with at most one mark, which is a decimal one; groups between spaces before it.
_WHOLE = rf"(\d+|\d{{1,3}}(?:[{_SPACES}]\d{{3}})+|(?=[.,]\d))"
_DECIMAL = re.compile(rf"([+-]?) ?{_WHOLE}(?:([.,])(\d*))?{_EXPONENT}", re.IGNORECASE)
#: Groups of three between marks, at most one other mark after them.
_GROUPED = re.compile(r"([+-]?) ?([1-9]\d{0,2})((?:\.\d{3})+|(?:,\d{3})+)(?:([.,])(\d*))?")


class Written(NamedTuple):
    """A number as it is written.

    Attributes
    ----------
    value : float
        Where its mark may be either, as if it were a decimal one.
    decimal_mark : {"", ".", ","}
        What stands, or must stand, between its whole part and its decimals; empty where it does not tell.
    is_open : bool
        Whether its mark may as well be one for thousands.
    """

    value: float
    decimal_mark: str
    is_open: bool = False

    @property
    def in_thousands(self) -> float:
        """What an open number means where its mark is one for thousands."""
        return float(round(1000.0 * self.value))


def read_number(text: str) -> Written | None:
    """Read a finite number; None where it is none."""
    usual = _USUAL.fullmatch(text)
    if usual is not None:
        return Written(float(text.replace(",", ".")), usual[1] or "")
    plain = text.translate(_PLAIN)
    if len(plain) > _LONGEST:
        return None
    grouped = _GROUPED.fullmatch(plain)
    if grouped is not None:
        return _grouped(*grouped.groups())
    match = _DECIMAL.fullmatch(plain)
    if match is None:
        return None
    sign, whole, mark, decimals, exponent = match.groups()
    value = float(f"{sign}{re.sub(rf'[{_SPACES}]', '', whole)}.{decimals or 0}{exponent or ''}")
    return Written(value, mark or "") if math.isfinite(value) else None


def _grouped(sign: str, first: str, groups: str, mark: str | None, decimals: str | None) -> Written | None:
    separator = groups[0]
    if mark == separator:
        return None
    if mark is None and groups.count(separator) == 1:
        return Written(float(f"{sign}{first}.{groups[1:]}"), separator, is_open=True)
    value = float(f"{sign}{first}{groups.replace(separator, '')}.{decimals or 0}")
    other = MARKS.replace(separator, "")
    return Written(value, other) if math.isfinite(value) else None


def is_open(text: str) -> bool:
    """Whether a text is a number whose mark may be a decimal one, or one for thousands."""
    if text[-4:-3] not in (".", ","):
        return False
    written = read_number(text)
    return written is not None and written.is_open


class Marks(NamedTuple):
    """Decimal marks of some numbers: those that leave no doubt, and the first number that does, empty without one."""

    sure: frozenset[str]
    doubtful: str

    @property
    def only(self) -> str:
        """The one decimal mark that all sure numbers have; empty where there is none, or both."""
        return next(iter(self.sure)) if len(self.sure) == 1 else ""


def marks_of(texts: Iterable[str]) -> Marks:
    """Tell the decimal marks of numbers; what is none tells nothing."""
    sure: set[str] = set()
    doubtful = ""
    for text in texts:
        if "." in text or "," in text:
            written = read_number(text)
            if written is not None and written.is_open:
                doubtful = doubtful or text
            elif written is not None:
                sure.add(written.decimal_mark)
    return Marks(frozenset(sure), doubtful)
