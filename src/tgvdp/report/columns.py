"""Tables of named columns as CSV, Parquet and Excel; all numbers of a CSV column have the same decimals."""

import io
import math
from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError, MissingExtraError

#: Columns by name, all of one length; None or a number that is not finite is a figure that is not known.
Columns: TypeAlias = Mapping[str, "Sequence[Any] | NDArray[Any]"]

#: Significant digits of the largest number of a column.
DIGITS = 9
_MOST_DECIMALS = 15
#: Rows of a sheet of Excel, the head included.
_MOST_EXCEL_ROWS = 1_048_576


def decimals(values: Iterable[float], digits: int) -> int:
    """Decimals that give the largest of some numbers so many significant digits; 0 where it has more before the point.

    Parameters
    ----------
    values : iterable of float
    digits : int
        At least 1.
    """
    top = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    return 0 if top == 0.0 else min(max(digits - 1 - math.floor(math.log10(top)), 0), _MOST_DECIMALS)


def to_csv(columns: Columns, digits: Mapping[str, int] | None = None) -> bytes:
    """Write columns as CSV: a head, a point for decimals, nothing where a figure is not known.

    Parameters
    ----------
    columns : Columns
    digits : mapping of str to int, optional
        Significant digits of the largest number, for columns that need others than 9.
    """
    texts = [_texts(values, (digits or {}).get(name, DIGITS)) for name, values in columns.items()]
    lines = [",".join(columns), *map(",".join, zip(*texts, strict=True))]
    return ("\n".join(lines) + "\n").encode()


def _texts(values: "Sequence[Any] | NDArray[Any]", digits: int) -> list[str]:
    listed = values.tolist() if isinstance(values, np.ndarray) else list(values)
    numbers = [value for value in listed if isinstance(value, float)]
    if not numbers:
        return ["" if value is None else _quoted(str(value)) for value in listed]
    form = f"%.{decimals(numbers, digits)}f"
    # Adding 0 turns −0 into 0.
    return ["" if value is None or not math.isfinite(value) else form % (value + 0.0) for value in listed]


def _quoted(text: str) -> str:
    """A text as a cell: in quotes where it would be taken for several."""
    return '"' + text.replace('"', '""') + '"' if any(mark in text for mark in ',"\n') else text


def to_parquet(columns: Columns) -> bytes:
    """Write columns as a Parquet table, numbers in full.

    Raises
    ------
    MissingExtraError
        When pyarrow is not installed.
    """
    try:
        arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    except ImportError:
        raise MissingExtraError("tables as Parquet need pyarrow: pip install 'tgvdp[tables]'") from None
    buffer = io.BytesIO()
    parquet.write_table(arrow.table(dict(columns)), buffer)
    return buffer.getvalue()


def to_xlsx(sheets: Mapping[str, Columns]) -> bytes:
    """Write an Excel workbook of one sheet per table, numbers with 15 to 16 digits.

    Raises
    ------
    MissingExtraError
        When openpyxl is not installed.
    InputError
        When a table has more rows than a sheet.
    """
    try:
        openpyxl = import_module("openpyxl")
    except ImportError:
        raise MissingExtraError("tables as Excel need openpyxl: pip install 'tgvdp[tables]'") from None
    book = openpyxl.Workbook(write_only=True)
    for title, columns in sheets.items():
        rows = len(next(iter(columns.values())))
        if rows >= _MOST_EXCEL_ROWS:
            raise InputError(f"Excel: a sheet holds {_MOST_EXCEL_ROWS - 1} rows, {title} has {rows}")
        sheet = book.create_sheet(title)
        sheet.append(list(columns))
        for row in zip(*(_cells(values) for values in columns.values()), strict=True):
            sheet.append(row)
    buffer = io.BytesIO()
    book.save(buffer)
    return buffer.getvalue()


def _cells(values: "Sequence[Any] | NDArray[Any]") -> list[Any]:
    listed = values.tolist() if isinstance(values, np.ndarray) else list(values)
    return [None if isinstance(value, float) and not math.isfinite(value) else value for value in listed]
