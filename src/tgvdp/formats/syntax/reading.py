"""From a path to a tree of tables, lists, numbers and texts: JSON, TOML or YAML, told apart by content.

Whatever is wrong with a file ends here or later as ONE line of `InputError` that starts with its path.
"""

import json
import math
import os
import re
import stat
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal

from tgvdp.errors import InputError, MissingExtraError
from tgvdp.formats.syntax.yaml import parse_yaml

#: Larger files are refused: the longest published line takes a few hundred kilobytes.
LARGEST_BYTES = 20_000_000

#: Tables and lists in each other; no format has more than ten.
DEEPEST = 100

_LARGEST_INTEGER = 10**300  # beyond float64, or as good as
_LONGEST_VALUE = 60
_MOST_LISTED = 8
_LONGEST_LIST = 300

#: YAML begins with a directive, a document mark or ``key:``; TOML with ``[table]`` or ``key =``.
_YAML_START = re.compile(r"%YAML|---|[^=\[\]{}\"']+:(\s|$)")
_SURROGATE = re.compile("[\ud800-\udfff]")
#: What a workbook begins with: it is a ZIP archive.
_ZIP = b"PK\x03\x04"
_GZIP = b"\x1f\x8b"
#: What workbooks of Excel until 2003 begin with, as other files of that time do.
_OLD_OFFICE = b"\xd0\xcf\x11\xe0"
_TABLE_SUFFIXES = (".csv", ".tsv")
#: A header of columns: cells with commas, semicolons or tabs between, and nothing that other syntaxes begin with.
_TABLE_START = re.compile(r"[^\[{<=][^=]*[;,\t][^=]*")
_BLANK = b"\xef\xbb\xbf\xff\xfe \t\r\n"

Syntax = Literal["JSON", "TOML", "YAML", "XML", "CSV", "XLSX"]


@dataclass(frozen=True)
class Document:
    """A file that has been read.

    Attributes
    ----------
    path : Path
    digest : str
        SHA-256 of its bytes, hexadecimal.
    syntax : str
    tree : dict
        Its values; empty for XML and tables, whose readers parse the bytes themselves.
    data : bytes
        As they are in the file.
    line_speed_mps : float, optional
        Speed limit of a track wherever the file gives none, m/s; not part of the file.
    places : tuple of (float, str)
        Named places of the line that a timetable is for, with their positions, m; not part of the file.
    is_alone : bool
        Whether it came from elsewhere, without the files that it references: these are not looked for.
    """

    path: Path
    digest: str
    syntax: Syntax
    tree: dict[str, Any]
    data: bytes
    line_speed_mps: float | None = None
    places: tuple[tuple[float, str], ...] = ()
    is_alone: bool = False


def bad(path: Path, message: object) -> InputError:
    """Make the error for a file: one printable line that starts with its path."""
    text = f"{path}: {message}"
    return InputError("".join(c if c.isprintable() else ascii(c)[1:-1] for c in text))


class errors_named:
    """Context that puts the file's path, and a place in it, before errors of what happens inside.

    Errors that begin with the path already pass as they are, and so do hints at missing packages.

    Parameters
    ----------
    path : Path
    place : str
        Field that the errors are about, where they do not say so themselves.
    """

    def __init__(self, path: Path, place: str = "") -> None:
        self._path, self._place = path, place

    def __enter__(self) -> None:
        pass

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        if not isinstance(error, InputError) or isinstance(error, MissingExtraError):
            return
        if not str(error).startswith(str(bad(self._path, ""))):
            raise bad(self._path, f"{self._place}: {error}" if self._place else error) from None


def shown(value: object) -> str:
    """Return a value as people may read it in an error: short, quoted when it is text."""
    text = "null" if value is None else repr(value)
    return text if len(text) <= _LONGEST_VALUE else f"{text[:_LONGEST_VALUE]}…"


def listed(names: Sequence[str]) -> str:
    """Names in a note, of many the first ones."""
    more = f" and {len(names) - _MOST_LISTED} more" if len(names) > _MOST_LISTED else ""
    return ", ".join(names[:_MOST_LISTED])[:_LONGEST_LIST] + more


def require_not_alone(document: Document, reference: str) -> None:
    """Refuse to look for a file that a document references which came from elsewhere, without it.

    Raises
    ------
    InputError
        When it did.
    """
    if document.is_alone:
        raise InputError(f"references another file, which is not at hand: put it inside, got {shown(reference)}")


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
    """Read a JSON, TOML or YAML file; of XML and tables only the bytes.

    Raises
    ------
    InputError
        When the file cannot be read, is too large, is none of these, repeats a field, or holds a number that is not
        finite.
    MissingExtraError
        When it holds YAML and ruamel.yaml is not installed.
    """
    return parse_document(path, read_bytes(path))


def parse_document(path: Path, data: bytes) -> Document:
    """Parse the bytes of a file; see `read_document`."""
    digest = sha256(data).hexdigest()
    if data[:64].replace(b"\0", b"").lstrip(_BLANK).startswith(b"<"):  # in any encoding
        return Document(path, digest, "XML", {}, data)
    if data.startswith(_ZIP):
        return Document(path, digest, "XLSX", {}, data)
    if data.startswith(_GZIP):
        raise bad(path, "is compressed by gzip, which is not read: unpack it")
    if data.startswith(_OLD_OFFICE):
        raise bad(path, "is a workbook of old Excel (.xls), which is not read: save it as .xlsx")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if path.suffix.lower() in _TABLE_SUFFIXES:
            return Document(path, digest, "CSV", {}, data)
        raise bad(path, f"is not UTF-8 text (byte {error.start})") from None
    if not text.strip():
        raise bad(path, "is empty")
    syntax = _syntax_of(text, path.suffix.lower())
    if syntax == "CSV":
        return Document(path, digest, syntax, {}, data)
    with errors_named(path):
        tree = _parse(text, syntax)
    if not isinstance(tree, dict):
        raise bad(path, f"must hold one table of named fields, got {shown(tree)}")
    _reject_wild_values(path, tree)
    return Document(path, digest, syntax, tree, data)


def _parse(text: str, syntax: Syntax) -> Any:
    try:
        if syntax == "YAML":
            return parse_yaml(text)[0]
        return tomllib.loads(text) if syntax == "TOML" else _parse_json(text)
    except RecursionError:
        raise InputError("is nested too deeply") from None
    except json.JSONDecodeError as error:
        raise InputError(f"is not valid JSON: {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"is not valid TOML, and neither JSON, YAML nor XML: {error}") from None
    except InputError:
        raise
    except ValueError as error:  # an integer too long for Python to convert
        raise InputError(str(error).partition(";")[0]) from None


def _syntax_of(text: str, suffix: str) -> Syntax:
    """Tell by its first line that is no comment in which syntax a text is written."""
    if text.lstrip().startswith("{") or suffix == ".json":
        return "JSON"
    if suffix in _TABLE_SUFFIXES:
        return "CSV"
    for line in text.splitlines():
        if line.strip() and not line.lstrip().startswith("#"):
            if _YAML_START.match(line.strip()):
                return "YAML"
            return "CSV" if _TABLE_START.fullmatch(line.strip()) else "TOML"
    return "TOML"


def _parse_json(text: str) -> Any:
    return json.loads(text, object_pairs_hook=_once_each)


def _once_each(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                raise InputError(f"field {shown(key)} is given twice")
            seen.add(key)
    return table


def _reject_wild_values(path: Path, tree: dict[str, Any]) -> None:
    """Refuse NaN, infinities, integers beyond float64, halves of characters, and too many levels."""
    todo: list[tuple[Any, tuple[str | int, ...]]] = [(tree, ())]
    while todo:
        parent, at = todo.pop()
        if len(at) > DEEPEST:
            raise bad(path, "is nested too deeply")
        for step, value in parent.items() if isinstance(parent, dict) else enumerate(parent):
            for text in (step, value):
                if isinstance(text, str) and _SURROGATE.search(text):
                    raise bad(path, f"{field_text((*at, step))}: holds half of a character, got {shown(text)}")
            if isinstance(value, dict | list):
                todo.append((value, (*at, step)))
            elif isinstance(value, float) and not math.isfinite(value):
                raise bad(path, f"{field_text((*at, step))} must be finite, got {value}")
            elif isinstance(value, int) and abs(value) > _LARGEST_INTEGER:
                raise bad(path, f"{field_text((*at, step))} must be finite, got an integer of {len(str(value))} digits")


def field_text(at: Iterable[str | int]) -> str:
    """Write the place of a value in a tree: ``speed limits.values[3][1]``."""
    text = ""
    for step in at:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else step
    return text
