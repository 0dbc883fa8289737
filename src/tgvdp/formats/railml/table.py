"""Curves over speed of railML rolling stock: tables of points (``valueTable``) and of polynomials (``segmentTable``).

A unit that the schema does not list is written ``other:kN``; an acceleration is in ``m/s/s``. Source: the published
documentation of the schema.
"""

import math
from functools import partial
from itertools import pairwise
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.formats.syntax.xml import Node
from tgvdp.units import from_si, to_si

TABLES = ("valueTable", "segmentTable")
SPECIFIC = "N/kN"
ACCELERATION = "m/s²"

#: Chords that stand for a polynomial are this close to it, as a share of its largest value; no more than so many.
_CHORD_ERROR = 1e-4
_MOST_CHORDS = 256


class Table(NamedTuple):
    """Points of a curve: speeds in m/s that do not decrease, and values in SI, or in N/kN where ``specific``."""

    points: list[tuple[float, float]]
    specific: bool
    line: int
    notes: tuple[str, ...]


class _Units:
    """Units of the two columns of a table; one that is missing is said."""

    def __init__(self, table: Node, speed: str, value: str, default: str) -> None:
        self._table = table
        self._may_be_specific = default == SPECIFIC
        self._quantity = "acceleration" if default == ACCELERATION else "force"
        self.notes: list[str] = []
        self.speed = self._unit(speed, "km/h")
        self.value = self._unit(value, default)

    def _unit(self, attribute: str, default: str) -> str:
        given = self._table.text(attribute)
        if not given:
            self.notes.append(f"{self._table.name} in line {self._table.line} has no {attribute}: read as {default}")
        return (given or default).removeprefix("other:").replace("m/s/s", ACCELERATION)

    @property
    def specific(self) -> bool:
        """Whether values are per weight."""
        return self._may_be_specific and self.value == SPECIFIC

    def point(self, place: Node, attribute: str, x: float, y: float) -> tuple[float, float]:
        """Speed and value in SI; a value in N/kN stays as it is."""
        try:
            speed_mps = to_si(x, self.speed, "speed")
            value = y if self.specific else to_si(y, self.value, self._quantity)
        except InputError as error:
            raise self._table.bad(str(error)) from None
        if not 0.0 <= value < math.inf:
            limit = f"at least 0 {self.value}" if value < 0.0 else "finite"
            raise place.bad(f"must be {limit}, got {y:g} {self.value} at {x:g} {self.speed}", attribute)
        return speed_mps, value


def read_table(table: Node, default_unit: str, top_mps: float) -> Table:
    """Read a table of force or acceleration over speed.

    Parameters
    ----------
    table : Node
        One of `TABLES`.
    default_unit : str
        Of the values, where the table names none.
    top_mps : float
        Speed up to which the last polynomial counts.

    Raises
    ------
    InputError
        When rows are missing, incomplete or out of order, a unit is unknown, or a value is negative.
    """
    if table.name == "segmentTable":
        units = _Units(table, "segmentStartValueUnit", "functionValueUnit", default_unit)
        points = _chords(table, units, top_mps)
    else:
        units = _Units(table, "xValueUnit", "yValueUnit", default_unit)
        points = _listed(table, units)
    for attribute in ("xValueName", "yValueName", "zValueName", "zValueUnit", "segmentStartValueName"):
        table.text(attribute)
    table.text("functionValueName")
    return Table(points, units.specific, table.line, tuple(units.notes))


def _listed(table: Node, units: _Units) -> list[tuple[float, float]]:
    """Rows of a table with one column, in the order of the file."""
    points: list[tuple[float, float]] = []
    for line in table.children("valueLine"):
        values = line.children("values", "value")  # 2.x and 3.x
        if len(values) != 1:
            raise line.bad(f"must hold one element values or value, got {len(values)}")
        x = line.required_number("xValue", units.speed, at_least=0.0)
        y = values[0].required_number("yValue", units.value)
        points.append(units.point(values[0], "yValue", x, y))
        if len(points) > 1 and points[-1][0] < points[-2][0]:
            raise line.bad(f"speeds must not decrease, got {x:g} {units.speed}", "xValue")
    if not points:
        raise table.bad("missing element valueLine")
    return points


def _chords(table: Node, units: _Units, top_mps: float) -> list[tuple[float, float]]:
    """Chords of polynomials, each of which counts from its start to the next one's, the last to the top speed."""
    units.point(table, "", 0.0, 0.0)  # what is wrong with the units is said first
    exponents = [one.required_number("exponentValue", "-") for one in table.children("polynomialHeader")]
    lines = table.children("segmentStartLine")
    if not exponents or not lines:
        raise table.bad(f"missing element {'segmentStartLine' if exponents else 'polynomialHeader'}")
    starts = [line.required_number("segmentStartValue", units.speed, at_least=0.0) for line in lines]
    points: list[tuple[float, float]] = []
    for line, (start, end) in zip(lines, pairwise([*starts, from_si(top_mps, units.speed, "speed")]), strict=True):
        if end <= start and line is not lines[-1]:
            raise line.bad("the next segmentStartLine must start above it", "segmentStartValue")
        values = [one.required_number("coefficientValue", units.value) for one in line.children("constantValue")]
        if len(values) != len(exponents):
            raise line.bad(f"must hold {len(exponents)} constantValue, as there are exponents, got {len(values)}")
        terms = list(zip(values, exponents, strict=True))
        points += [units.point(line, "", x, _sum(terms, x)) for x in stations(terms, start, max(start, end))]
    return points


def _sum(terms: list[tuple[float, float]], x: float) -> float:
    """Value of a polynomial; infinite where it has none, such as that of constant power at a standstill."""
    try:
        return math.fsum(value * x**exponent for value, exponent in terms if value)
    except (ZeroDivisionError, OverflowError, ValueError):
        return math.inf


def stations(terms: list[tuple[float, float]], start: float, end: float) -> list[float]:
    """Places between which chords are close enough to a polynomial of terms (coefficient, exponent)."""
    function = partial(_sum, terms)
    count = 1
    while True:
        ends = [start + (end - start) * index / count for index in range(count + 1)]
        values = [function(x) for x in ends]
        middles = [function(0.5 * (a + b)) for a, b in pairwise(ends)]
        misses = [abs(y - 0.5 * (a + b)) for y, (a, b) in zip(middles, pairwise(values), strict=True)]
        if count >= _MOST_CHORDS or not max(misses) > _CHORD_ERROR * max(map(abs, values)):
            return ends
        count *= 2
