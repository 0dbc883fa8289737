"""Values as JSON can hold them, JSON as files hold it, and rows of values as CSV and as Markdown."""

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
import numpy as np


def plain(value: Any) -> Any:
    """Copy of a value in plain types; numbers that JSON cannot write (inf, NaN) become None, the rest text."""
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, str):  # names of files may hold bytes that are no character
        return value.encode(errors="backslashreplace").decode()
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, Mapping):
        return {plain(str(key)): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return str(value)


def to_json(content: Mapping[str, Any]) -> bytes:
    """JSON as files hold it; the line breaks are msgspec's, whose numbers Python would write in another way."""
    compact = json.dumps(content, ensure_ascii=False, allow_nan=False).encode()
    return msgspec.json.format(compact, indent=2) + b"\n"


def csv_text(rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Rows of the same keys as CSV; what is None stays empty."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode()


def markdown_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows of the same keys as a Markdown table; words to the left, numbers to the right."""
    if not rows:
        return ""
    columns = list(rows[0])
    aligned = ["---" if any(isinstance(row[name], str) for row in rows) else "---:" for name in columns]
    lines = [columns, aligned, *([shown(row[name]) for name in columns] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def shown(value: Any) -> str:
    """One cell of a table: four significant digits."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "–"
    if isinstance(value, float):
        return f"{value:.0f}" if abs(value) >= 1e4 else f"{value:.4g}"
    return str(value)


def rounded(value: float, digits: int = 2) -> str:
    """A number of so many significant digits, without a power of ten where it can be read without."""
    return "∞" if math.isinf(value) else f"{float(f'{value:.{digits}g}'):.12g}"
