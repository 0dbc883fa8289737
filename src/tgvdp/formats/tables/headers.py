"""Headers of tables: the name of a column and its unit in one cell, and the rows that name them, wherever these stand.

People write titles above a header, and units in a row of their own below it.
"""

import re
from collections.abc import Callable

from tgvdp.formats.tables.cells import Cell, Row, Sheet

#: How people write a unit, in small letters → as `tgvdp.units` knows it.
UNITS = {
    **dict.fromkeys(("m", "metre", "metres", "meter", "meters"), "m"),
    **dict.fromkeys(("km", "kilometre", "kilometres", "kilometer", "kilometers"), "km"),
    **dict.fromkeys(("km/h", "kmh", "kph", "kmph", "km h", "km h-1", "km h^-1", "km h⁻¹", "km·h⁻¹"), "km/h"),
    **dict.fromkeys(("m/s", "mps", "m s", "m s-1", "ms-1", "m s^-1", "m s⁻¹", "m·s⁻¹"), "m/s"),
    **dict.fromkeys(("n", "newton"), "N"), **dict.fromkeys(("kn", "kilonewton"), "kN"),
    **dict.fromkeys(("‰", "permil", "permille", "per mil", "per mille", "promille", "promil", "pour mille"), "‰"),
    **dict.fromkeys(("o/oo", "0/00", "per thousand", "mm/m", "m/km"), "‰"),
    **dict.fromkeys(("%", "percent", "per cent", "pct"), "%"),
    **dict.fromkeys(("s", "sec", "second", "seconds"), "s"), **dict.fromkeys(("min", "minute", "minutes"), "min"),
    **dict.fromkeys(("h", "hour", "hours"), "h"),
}  # fmt: skip
#: Units that no quantity is read in: behind a name they are a unit, too, and not another name.
_FOREIGN = ("mi", "mile", "miles", "mph", "ft", "feet", "yd", "yards", "knots", "deg", "degrees", "rad", "lbf", "ms")
_MOST_TITLES = 20
_LONGEST_UNIT = 3  # words
_BRACKETED = re.compile(r"(.*?)[\s/,]*[\[(]\s*(?:in\s+)?(.*?)\s*[\])]\s*")
_HUMP = re.compile(r"(?<=[a-zß-ÿ])(?=[A-ZÀ-Þ])")


def split(header: str) -> tuple[str, str]:
    """Cut a header into a name in small letters, words one blank apart, and the unit, empty where there is none.

    The unit is as `tgvdp.units` knows it where that is known, else as it is written.
    """
    text = re.sub(r"\s+", " ", header.strip())
    match = _BRACKETED.fullmatch(text)
    if match:
        return _name(match[1]), _unit(match[2])
    words = re.split(r"[\s_]+", text)
    for count in range(min(_LONGEST_UNIT, len(words) - 1), 0, -1):
        unit = " ".join(words[-count:]).lower()
        if unit in UNITS or unit in _FOREIGN:
            return _name(re.sub(r"([\s_]+in)?[\s/,]*$", "", " ".join(words[:-count]))), _unit(unit)
    name, slash, unit = text.partition("/")
    if slash and text.lower() not in UNITS and unit.strip().lower() in UNITS:
        return _name(name), _unit(unit)
    return _name(text), ""


def _name(text: str) -> str:
    return re.sub(r"[-_\s]+", " ", _HUMP.sub(" ", text)).strip().lower()


def _unit(text: str) -> str:
    plain = text.strip().replace("_", " ")
    return UNITS.get(plain.lower(), plain)


def headed(sheet: Sheet, is_known: Callable[[str], bool]) -> tuple[Sheet, tuple[str, ...]]:
    """Let a sheet begin with its header, units from a row below it inside; and say what stood above.

    The header is the first row that names two known columns, else the first that names one, else the first.

    Parameters
    ----------
    sheet : Sheet
    is_known : callable
        Whether a header names a column that is looked for.
    """
    counts = [sum(map(is_known, map(str, row.cells))) for row in sheet.rows[:_MOST_TITLES]]
    at = next((at for at, count in enumerate(counts) if count >= min(2, max(counts))), 0)
    above = tuple(" ".join(filter(None, map(str, row.cells))) for row in sheet.rows[:at])
    header, *rows = sheet.rows[at:]
    if rows and any(rows[0].cells) and all(map(_is_unit, rows[0].cells)):
        header = Row(header.number, tuple(map(_joined, header.cells, _padded(rows[0].cells, len(header.cells)))))
        rows = rows[1:]
    return sheet._replace(rows=(header, *rows)), above


def _is_unit(cell: Cell) -> bool:
    """Whether a cell holds a unit, or nothing."""
    return isinstance(cell, str) and (cell in ("", "-") or cell.strip("[]() ").lower() in UNITS)


def _padded(cells: tuple[Cell, ...], width: int) -> tuple[Cell, ...]:
    return cells + ("",) * (width - len(cells))


def _joined(header: Cell, unit: Cell) -> Cell:
    text = str(unit).strip("[]() ")
    return header if text in ("", "-") or split(str(header))[1] else f"{header} [{text}]"
