"""From a path to a tree of tables, lists, numbers and texts: JSON or TOML, told apart by content.

Whatever is wrong with a file ends here or later as ONE line of `InputError` that starts with its path.
"""

import json
import math
import os
import stat
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from tgvdp.errors import InputError

#: Larger files are refused: the longest published line takes a few hundred kilobytes.
LARGEST_BYTES = 20_000_000

_LARGEST_INTEGER = 10**300  # beyond float64, or as good as
_LONGEST_VALUE = 60


@dataclass(frozen=True)
class Document:
    """A file that has been read: its path, the SHA-256 of its bytes, and its tree of values."""

    path: Path
    digest: str
    tree: dict[str, Any]


def bad(path: Path, message: object) -> InputError:
    """Make the error for a file: one printable line that starts with its path."""
    text = f"{path}: {message}"
    return InputError("".join(c if c.isprintable() else ascii(c)[1:-1] for c in text))


def with_path(path: Path, error: InputError) -> InputError:
    """Put the file's path before an error of the model, unless it stands there already."""
    return error if str(error).startswith(str(bad(path, ""))) else bad(path, error)


def shown(value: object) -> str:
    """Return a value as people may read it in an error: short, quoted when it is text."""
    text = "null" if value is None else repr(value)
    return text if len(text) <= _LONGEST_VALUE else f"{text[:_LONGEST_VALUE]}…"


def read_bytes(path: Path) -> bytes:
    """Read a whole regular file; raise `InputError` where that cannot be done."""
    try:
        status = path.stat()
        refusal = _refusal(status)
        if refusal is None:
            return path.read_bytes()
    except FileNotFoundError:
        refusal = "no such file"
    except (OSError, ValueError) as error:  # a null byte in a path is a ValueError
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        refusal = f"cannot be read: {reason}"
    raise bad(path, refusal)


def _refusal(status: os.stat_result) -> str | None:
    if stat.S_ISDIR(status.st_mode):
        return "is a folder, not a file"
    if not stat.S_ISREG(status.st_mode):
        return "is not a regular file"
    if status.st_size > LARGEST_BYTES:
        return f"is larger than {LARGEST_BYTES / 1e6:g} MB, got {status.st_size / 1e6:.1f} MB"
    return None


def read_document(path: Path) -> Document:
    """Read a JSON or TOML file.

    Raises
    ------
    InputError
        When the file cannot be read, is too large, is neither JSON nor TOML, repeats a field, or holds a number that
        is not finite.
    """
    data = read_bytes(path)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise bad(path, f"is not UTF-8 text (byte {error.start})") from None
    start = text.lstrip()[:1]
    if not start:
        raise bad(path, "is empty")
    if start == "<":
        raise bad(path, "holds XML, which is not supported yet; expected JSON or TOML")
    try:
        tree = _parse_json(text) if start == "{" or path.suffix.lower() == ".json" else tomllib.loads(text)
    except RecursionError:
        raise bad(path, "is nested too deeply") from None
    except json.JSONDecodeError as error:
        raise bad(path, f"is not valid JSON: {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise bad(path, f"is neither JSON nor valid TOML: {error}") from None
    except ValueError as error:  # a repeated field, or an integer too long for Python to convert
        raise bad(path, str(error).partition(";")[0]) from None
    if not isinstance(tree, dict):
        raise bad(path, f"must hold one JSON object or TOML tables, got {shown(tree)}")
    _reject_wild_numbers(path, tree)
    return Document(path, sha256(data).hexdigest(), tree)


def _parse_json(text: str) -> Any:
    return json.loads(text, object_pairs_hook=_once_each)


def _once_each(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                raise ValueError(f"field {shown(key)} is given twice")
            seen.add(key)
    return table


def _reject_wild_numbers(path: Path, tree: dict[str, Any]) -> None:
    """Refuse NaN, infinities and integers beyond float64, wherever they are; no recursion, so any depth."""
    todo: list[tuple[Any, tuple[str | int, ...]]] = [(tree, ())]
    while todo:
        value, at = todo.pop()
        if isinstance(value, dict):
            todo.extend((child, (*at, key)) for key, child in value.items())
        elif isinstance(value, list):
            todo.extend((child, (*at, index)) for index, child in enumerate(value))
        elif isinstance(value, float) and not math.isfinite(value):
            raise bad(path, f"{field_text(at)} must be finite, got {value}")
        elif isinstance(value, int) and abs(value) > _LARGEST_INTEGER:
            raise bad(path, f"{field_text(at)} must be finite, got an integer of {len(str(value))} digits")


def field_text(at: Iterable[str | int]) -> str:
    """Write the place of a value in a tree: ``speed limits.values[3][1]``."""
    text = ""
    for step in at:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else step
    return text
