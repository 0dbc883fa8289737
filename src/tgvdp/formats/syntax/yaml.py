"""YAML as a tree of plain values, by the core schema of YAML 1.2: the rules that railtoolkit files declare.

ruamel.yaml parses the text. What scalars mean is decided here: it takes ``1_000`` for a number and ``2024-07-01`` for a
date, which the core schema does not; numbers that mean one thing in YAML 1.1 and another in 1.2 are refused. Neither
nesting nor references can make the work grow: depth and size are bounded, and anchors are refused.
"""

import re
from collections.abc import Iterator
from typing import Any

from tgvdp.errors import InputError, MissingExtraError

LARGEST_YAML_BYTES = 2_000_000
MOST_SEPARATORS = 100_000
DEEPEST = 50

#: Keys of tables and indices of lists, from the top of a file.
KeyPath = tuple[str | int, ...]

_WORDS = {"": None, "~": None, "true": True, "false": False, "null": None}
_INTEGER = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_AMBIGUOUS = re.compile(r"[-+]?0[0-9_]+|[-+]?0[xob][0-9a-fA-F_]+")
#: One stands before every value but the first.
_SEPARATORS = re.compile(r"[\n,:?-]")
#: A tab between tokens is a blank in YAML 1.2, which ruamel.yaml refuses.
_TAB = re.compile(r"(?<=\S) *\t[ \t]*")


def parse_yaml(text: str) -> tuple[Any, dict[KeyPath, int]]:
    """Parse one YAML document.

    Returns
    -------
    tree : dict, list, str, float, int, bool or None
        Keys of tables are text.
    lines : dict
        Line of every key and list element, from 1, by its key path.

    Raises
    ------
    InputError
        When the text is no YAML, too large or too deep, holds anchors, tags, repeated fields, more than one document,
        or numbers whose meaning depends on the version of YAML.
    MissingExtraError
        When ruamel.yaml is not installed.
    """
    try:
        from ruamel.yaml import YAML
        from ruamel.yaml.error import MarkedYAMLError, YAMLError
    except ModuleNotFoundError:
        raise MissingExtraError("reading YAML needs ruamel.yaml: pip install 'tgvdp[formats]'") from None
    if len(text) > LARGEST_YAML_BYTES:
        raise InputError(f"is larger than {LARGEST_YAML_BYTES / 1e6:g} MB of YAML, got {len(text) / 1e6:.1f} MB")
    if len(_SEPARATORS.findall(text)) > MOST_SEPARATORS:
        raise InputError(f"holds too many values: more than {MOST_SEPARATORS} lines, commas, colons and hyphens")
    lines: dict[KeyPath, int] = {}
    try:
        events = YAML(typ="safe", pure=True).parse(_TAB.sub(" ", text))
        starts = (event for event in events if type(event).__name__ == "DocumentStartEvent")
        tree = _value(next(events), events, (), 1, lines) if next(starts, None) else None
        if another := next(starts, None):
            raise _bad("must hold one YAML document, another one starts", another)
    except MarkedYAMLError as error:
        where = f" in line {error.problem_mark.line + 1}" if error.problem_mark else ""
        raise InputError(f"is not valid YAML: {error.problem}{where}") from None
    except (YAMLError, AssertionError) as error:  # the latter at a version such as 1.3
        raise InputError(f"is not valid YAML: {str(error).partition(chr(10))[0]}") from None
    return tree, lines


def _value(event: Any, events: Iterator[Any], at: KeyPath, line: int, lines: dict[KeyPath, int]) -> Any:
    """Value that begins with an event, and takes those that follow up to its end."""
    _require_plain(event)
    if len(at) > DEEPEST:
        raise _bad("is nested too deeply", event)
    lines[at] = line
    kind = type(event).__name__
    if kind == "ScalarEvent":
        return _scalar(event)
    if kind == "SequenceStartEvent":
        rows: list[Any] = []
        while type(one := next(events)).__name__ != "SequenceEndEvent":
            rows.append(_value(one, events, (*at, len(rows)), one.start_mark.line + 1, lines))
        return rows
    table: dict[str, Any] = {}
    while type(key := next(events)).__name__ != "MappingEndEvent":
        _require_plain(key)
        name = getattr(key, "value", None)
        if name is None:
            raise _bad("names of fields must be text", key)
        if name in table:
            raise _bad(f"field {name!r:.60} is given twice", key)
        table[name] = _value(next(events), events, (*at, name), key.start_mark.line + 1, lines)
    return table


def _require_plain(event: Any) -> None:
    if event.anchor is not None:
        raise _bad(f"YAML anchors and aliases are not read, got {event.anchor!r:.40}", event)
    if event.ctag is not None:
        raise _bad(f"YAML tags are not read, got {str(event.ctag)!r:.40}", event)


def _scalar(event: Any) -> Any:
    """Value of a scalar by the core schema of YAML 1.2; quoted text is text."""
    text: str = event.value
    if event.style is not None:
        return text
    if text.lower() in _WORDS and text in (text.lower(), text.title(), text.upper()):
        return _WORDS[text.lower()]
    if _AMBIGUOUS.fullmatch(text):
        raise _bad(f"{text:.40} differs between YAML 1.1 and 1.2: write a plain decimal number", event)
    if _INTEGER.fullmatch(text):
        return int(text)
    if _NOT_FINITE.fullmatch(text):
        return float(text.replace(".", ""))  # refused later, where its field is known
    return float(text) if _FLOAT.fullmatch(text) else text


def _bad(message: str, at: Any) -> InputError:
    return InputError(f"{message} in line {at.start_mark.line + 1}")
