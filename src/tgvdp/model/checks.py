"""Checks that the self-validating model classes share; errors name the owner, the field, the value and its unit."""

import math
import operator
from collections.abc import Iterable, Sequence
from numbers import Real
from typing import Any, NamedTuple, SupportsIndex, TypeVar

from tgvdp.errors import ArgumentError, InputError

#: Products of a few quantities must stay far from overflow and underflow; no train or toy comes near these.
LARGEST = 1e18
SMALLEST = 1e-18

#: Rounding slack where two published decimals must add up, such as a tunnel's end and the line's.
SUM_RTOL = 1e-9

_LONGEST_TEXT = 500

Row = TypeVar("Row", bound=NamedTuple)


def require_number(
    owner: str,
    field: str,
    value: Any,
    unit: str,
    *,
    above: float | None = None,
    at_least: float | None = None,
    infinite_ok: bool = False,
) -> float:
    """Return ``value`` as a float.

    Raises
    ------
    InputError
        Unless it is a real number within the given bounds, and its magnitude one that arithmetic survives.
    """
    of = f" {unit}" if unit else ""
    if isinstance(value, bool) or not isinstance(value, (float, Real)):  # Real alone is asked slowly, of 100,000 rows
        raise ArgumentError(owner, field, f"must be a number{f' in {unit}' if unit else ''}, got {value!r:.60}")
    try:
        number = float(value)
    except OverflowError:
        raise ArgumentError(owner, field, f"must be within ±{LARGEST:g}{of}, got more than 1e308") from None
    if math.isnan(number) or (math.isinf(number) and not infinite_ok):
        raise ArgumentError(owner, field, f"must be finite, got {number}{of}")
    if above is not None and not number > above:
        raise ArgumentError(owner, field, f"must be above {above:.12g}{of}, got {number:.12g}{of}")
    if at_least is not None and not number >= at_least:
        raise ArgumentError(owner, field, f"must be at least {at_least:.12g}{of}, got {number:.12g}{of}")
    if math.isfinite(number) and abs(number) > LARGEST:
        raise ArgumentError(owner, field, f"must be within ±{LARGEST:g}{of}, got {number:.12g}{of}")
    if above == 0.0 and number < SMALLEST:
        raise ArgumentError(owner, field, f"must be at least {SMALLEST:g}{of}, got {number:.12g}{of}")
    return number


def require_index(owner: str, field: str, value: Any, count: int) -> int:
    """Return an index of one of ``count`` things, from 0 on; negative ones count from the end, as in Python.

    Raises
    ------
    ArgumentError
        When it is no whole number, or there is none of that index.
    """
    wanted = f"must be a whole number from {-count} to {count - 1}" if count else "has nothing to choose from"
    if isinstance(value, bool) or not isinstance(value, SupportsIndex):
        raise ArgumentError(owner, field, f"{wanted}, got {value!r:.60}")
    index = operator.index(value)
    if not -count <= index < count:
        raise ArgumentError(owner, field, f"{wanted}, got {index!r:.60}")
    return index % count


def require_text(owner: str, field: str, value: Any) -> str:
    """Return ``value``; raise `InputError` unless it is one line of printable text."""
    if not isinstance(value, str) or not value.strip() or not value.isprintable() or len(value) > _LONGEST_TEXT:
        raise InputError(
            f"{owner}: {field} must be one line of printable text (at most {_LONGEST_TEXT} characters), "
            f"got {value!r:.60}"
        )
    return value


def plain_text(text: str) -> str:
    """Return a text on one line, as `require_text` takes it; empty where it cannot be one."""
    line = " ".join(text.split())
    return line if line.isprintable() and len(line) <= _LONGEST_TEXT else ""


def require_notes(owner: str, notes: Any) -> tuple[str, ...]:
    """Return notes as a tuple of single lines; raise `InputError` for anything else."""
    if isinstance(notes, str) or not isinstance(notes, Iterable):
        raise InputError(f"{owner}: notes must be a list of texts, got {notes!r:.60}")
    return tuple(require_text(owner, f"notes[{index}]", note) for index, note in enumerate(notes))


def require_rows(owner: str, field: str, rows: Any, row_type: type[Row]) -> tuple[Row, ...]:
    """Return rows as named tuples; raise `InputError` where one has the wrong number of columns."""
    columns = ", ".join(row_type._fields)
    if isinstance(rows, str) or not isinstance(rows, Iterable):
        raise ArgumentError(owner, field, f"must be a list of ({columns}), got {rows!r:.60}")
    made = []
    for index, row in enumerate(rows):
        if isinstance(row, str) or not isinstance(row, (tuple, Iterable)):  # Iterable alone is asked slowly
            raise ArgumentError(owner, f"{field}[{index}]", f"must be ({columns}), got {row!r:.60}")
        values = tuple(row)
        if len(values) != len(row_type._fields):
            raise ArgumentError(owner, f"{field}[{index}]", f"must be ({columns}), got {len(values)} values")
        made.append(row_type(*values))
    return tuple(made)


def require_increasing(owner: str, field: str, positions_m: Sequence[float], length_m: float) -> None:
    """Raise `InputError` unless positions start at 0, increase strictly and stay below the line's length."""
    for index, position_m in enumerate(positions_m):
        require_number(owner, f"{field}[{index}].position", position_m, "m", at_least=0.0)
        if index == 0 and position_m != 0.0:
            raise InputError(f"{owner}: {field} must start at 0 m, got {position_m:.12g} m")
        if index > 0 and not position_m > positions_m[index - 1]:
            raise InputError(
                f"{owner}: {field}[{index}].position must increase, "
                f"got {position_m:.12g} m after {positions_m[index - 1]:.12g} m"
            )
        if position_m >= length_m:
            raise InputError(
                f"{owner}: {field}[{index}].position must be below the line's length {length_m:.12g} m, "
                f"got {position_m:.12g} m"
            )
