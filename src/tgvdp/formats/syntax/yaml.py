"""YAML as a tree of plain values, by the core schema of YAML 1.2: the rules that railtoolkit files declare.

PyYAML's own loaders follow YAML 1.1, where ``no`` is False, ``010`` is 8, ``1e3`` is text and ``1:30`` is 90, and where
repeated fields pass silently. Only its parser is used here; what scalars mean is decided below, and numbers that mean
one thing in 1.1 and another in 1.2 are refused. Neither nesting nor references can make the work grow: the tree is
built without recursion, from a bounded number of values, and anchors are refused.
"""

import re
from typing import Any

from tgvdp.errors import InputError, MissingExtraError

LARGEST_YAML_BYTES = 2_000_000
MOST_VALUES = 200_000
DEEPEST = 50

_WORDS = {"": None, "~": None, "true": True, "false": False, "null": None}
_INTEGER = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_AMBIGUOUS = re.compile(r"[-+]?0[0-9_]+|[-+]?0[xob][0-9a-fA-F_]+")


def parse_yaml(text: str) -> Any:
    """Parse one YAML document.

    Returns
    -------
    dict, list, str, float, int, bool or None
        Keys of tables are text.

    Raises
    ------
    InputError
        When the text is no YAML, too large or too deep, holds anchors, tags, repeated fields, more than one document,
        or numbers whose meaning depends on the version of YAML.
    MissingExtraError
        When PyYAML is not installed.
    """
    try:
        import yaml
    except ModuleNotFoundError:
        raise MissingExtraError("reading YAML needs PyYAML: pip install 'tgvdp[formats]'") from None
    if len(text) > LARGEST_YAML_BYTES:
        raise InputError(f"is larger than {LARGEST_YAML_BYTES / 1e6:g} MB of YAML, got {len(text) / 1e6:.1f} MB")
    builder = _Builder()
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        for event in yaml.parse(text, Loader=loader):
            builder.take(type(event).__name__, event)
    except yaml.MarkedYAMLError as error:
        where = f" in line {error.problem_mark.line + 1}" if error.problem_mark else ""
        raise InputError(f"is not valid YAML: {error.problem}{where}") from None
    except yaml.YAMLError as error:
        raise InputError(f"is not valid YAML: {str(error).splitlines()[0]}") from None
    return builder.root


class _Builder:
    """Turns the parser's events into a tree; ``open`` holds the lists and tables that are not closed yet."""

    def __init__(self) -> None:
        self.root: Any = None
        self.open: list[tuple[list[Any] | dict[str, Any], str | None]] = []
        self.documents = self.values = 0

    def take(self, kind: str, event: Any) -> None:
        """Take one event of the parser."""
        if kind == "DocumentStartEvent":
            self.documents += 1
            if self.documents > 1:
                raise InputError(f"must hold one YAML document, another one starts{_line(event)}")
        elif kind in ("SequenceEndEvent", "MappingEndEvent"):
            self.open.pop()
        elif kind == "AliasEvent" or getattr(event, "anchor", None) is not None:
            raise InputError(f"YAML anchors and aliases are not read, got {event.anchor!r:.40}{_line(event)}")
        elif kind in ("ScalarEvent", "SequenceStartEvent", "MappingStartEvent"):
            self._count(event)
            made = {"SequenceStartEvent": list, "MappingStartEvent": dict}.get(kind)
            value = _scalar(event) if made is None else made()
            self._place(value, event)
            if made is not None:
                self.open.append((value, None))

    def _count(self, event: Any) -> None:
        self.values += 1
        if self.values > MOST_VALUES:
            raise InputError(f"holds more than {MOST_VALUES} values")
        if len(self.open) >= DEEPEST:
            raise InputError(f"is nested too deeply{_line(event)}")
        if event.tag is not None:
            raise InputError(f"YAML tags are not read, got {event.tag!r:.40}{_line(event)}")

    def _place(self, value: Any, event: Any) -> None:
        """Put a value into the innermost open list or table, or take it as the name of the next field."""
        if not self.open:
            self.root = value
            return
        parent, key = self.open[-1]
        if isinstance(parent, list):
            parent.append(value)
        elif key is not None:
            parent[key] = value
            self.open[-1] = (parent, None)
        else:
            name = getattr(event, "value", None)
            if not isinstance(name, str):
                raise InputError(f"names of fields must be text{_line(event)}")
            if name in parent:
                raise InputError(f"field {name!r:.60} is given twice{_line(event)}")
            self.open[-1] = (parent, name)


def _scalar(event: Any) -> Any:
    """Value of a scalar by the core schema of YAML 1.2; quoted text is text."""
    text: str = event.value
    if not event.implicit[0]:
        return text
    if text.lower() in _WORDS and text in (text.lower(), text.title(), text.upper()):
        return _WORDS[text.lower()]
    if _AMBIGUOUS.fullmatch(text):
        raise InputError(f"{text:.40} differs between YAML 1.1 and 1.2: write a plain decimal number{_line(event)}")
    if _INTEGER.fullmatch(text):
        return int(text)
    if _NOT_FINITE.fullmatch(text):
        return float(text.replace(".", ""))  # refused later, where its field is known
    return float(text) if _FLOAT.fullmatch(text) else text


def _line(event: Any) -> str:
    return f" in line {event.start_mark.line + 1}"
