"""XML from strangers: bytes to a tree without entities, external references or surprises in size.

`Node` reads elements and attributes with errors that name the line and the element, and remembers what was read, so
that a reader can list what it did not use.
"""

import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from tgvdp.errors import InputError, MissingExtraError
from tgvdp.formats.syntax.reading import LARGEST_BYTES, bad, shown
from tgvdp.units import LARGEST_WRITTEN, SMALLEST_WRITTEN

#: A file of a few megabytes can hold millions of elements, each of which costs a hundred times its text.
MOST_ELEMENTS = 500_000
#: ... and attributes.
MOST_ATTRIBUTES = 1_000_000
#: railML nests some ten levels deep, extensions a few more.
DEEPEST = 64

_ENCODINGS = {"utf-8", "us-ascii", "ascii", "iso-8859-1", "iso-8859-15", "windows-1252", "utf-16"}
_DECLARED = re.compile(rb"""^\s*<\?xml[^>]{0,200}?encoding\s*=\s*["']([A-Za-z0-9._-]{1,40})["']""")
#: What stands before the root, taken once, whatever follows, and the name of the root.
_ROOT = re.compile(r"(?>\s+|<\?.*?\?>|<!--.*?-->)*+<(?:[\w.-]+:)?([\w.-]+)", re.DOTALL)
_NUMBER = re.compile(r"\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\s*")
_LONGEST_NUMBER = 400
#: Attributes that identify or describe, wherever they stand: nobody misses them.
_ADMINISTRATIVE = {"id", "name", "code", "description", "version", "{http://www.w3.org/XML/1998/namespace}lang"}


def parse_xml(path: Path, data: bytes) -> "Node":
    """Parse a file and return its root.

    Raises
    ------
    MissingExtraError
        When lxml is not installed.
    InputError
        When the file is too large or too deep, not well formed, in an unknown encoding, or declares a document type.
    """
    try:
        etree = import_module("lxml.etree")
    except ImportError:
        raise MissingExtraError(f"{path}: reading XML needs lxml: pip install 'tgvdp[formats]'") from None
    text = _decoded(path, data)
    # Anywhere, even in a comment: what was looked at here is what the parser gets, whatever it makes of it.
    for forbidden in ("<!DOCTYPE", "<!ENTITY"):
        if forbidden in text:
            line = text.count("\n", 0, text.index(forbidden)) + 1
            raise bad(path, f"line {line}: declares a document type or an entity ({forbidden}), which is refused")
    if text.count("</") + text.count("/>") > MOST_ELEMENTS:
        raise bad(path, f"holds more than {MOST_ELEMENTS} elements")
    if text.count("=") > MOST_ATTRIBUTES:
        raise bad(path, f"holds more than {MOST_ATTRIBUTES} attributes")
    parser = etree.XMLParser(
        encoding="utf-8", resolve_entities=False, no_network=True, load_dtd=False, dtd_validation=False,
        attribute_defaults=False, huge_tree=False, remove_comments=True, remove_pis=True,
    )  # fmt: skip
    try:
        root = etree.fromstring(text.encode("utf-8"), parser)
    except etree.XMLSyntaxError as error:
        raise bad(path, f"line {error.lineno}: is not well-formed XML: {error.msg or 'no element'}") from None
    if root.xpath("boolean(" + "/*" * (DEEPEST + 1) + ")"):
        raise bad(path, f"is nested too deeply: more than {DEEPEST} elements in each other")
    return Node(path, root, {root: set()})


def root_name(path: Path, data: bytes) -> str:
    """Name of the root of a file, without its namespace, from its beginning; empty where it does not begin as XML.

    Raises
    ------
    InputError
        As of `parse_xml`, when it is too large or in an unknown encoding.
    """
    match = _ROOT.match(_decoded(path, data))
    return match[1] if match else ""


def _decoded(path: Path, data: bytes) -> str:
    if len(data) > LARGEST_BYTES:
        raise bad(path, f"is larger than {LARGEST_BYTES / 1e6:g} MB, got {len(data) / 1e6:.1f} MB")
    declared = _DECLARED.match(data.removeprefix(b"\xef\xbb\xbf"))
    encoding = declared[1].decode("ascii").lower() if declared else "utf-8"
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        encoding = "utf-16"
    if encoding not in _ENCODINGS:
        raise bad(path, f"line 1: unknown encoding {shown(encoding)}; known: {', '.join(sorted(_ENCODINGS))}")
    try:
        return data.decode("utf-8-sig" if encoding == "utf-8" else encoding)
    except UnicodeDecodeError as error:
        raise bad(path, f"is not {encoding} text (byte {error.start})") from None


@dataclass(frozen=True)
class Node:
    """An element, and all that has been read of its document so far.

    Attributes
    ----------
    path : Path
        The file.
    element : lxml element
    seen : dict
        Elements that were read, with the names of the attributes that were.
    """

    path: Path
    element: Any
    seen: dict[Any, set[str]] = field(repr=False)

    @property
    def name(self) -> str:
        """Name of the element without its namespace."""
        return _local(self.element)

    @property
    def namespace(self) -> str:
        """Namespace of the element, empty without one."""
        return str(self.element.tag).rpartition("}")[0].removeprefix("{")

    @property
    def line(self) -> int:
        """Line of the file in which the start tag of the element ends."""
        return int(self.element.sourceline or 0)

    @property
    def place(self) -> str:
        """Line and path of the element: ``line 12, railml/infrastructure/tracks/track[2]``."""
        steps = []
        element = self.element
        while element is not None:
            before = sum(1 for _ in element.itersiblings(element.tag, preceding=True))
            alone = before == 0 and next(element.itersiblings(element.tag), None) is None
            steps.append(_local(element) if alone else f"{_local(element)}[{before + 1}]")
            element = element.getparent()
        return f"line {self.line}, {'/'.join(reversed(steps))}"

    def bad(self, message: str, attribute: str = "") -> InputError:
        """Make the error for this element or for an attribute of it."""
        return bad(self.path, f"{self.place}{f'@{attribute}' if attribute else ''}: {message}")

    def children(self, *names: str) -> list["Node"]:
        """Children of the given names that belong to the format (its namespace), in the order of the file."""
        space = self.element.tag.rpartition("}")[0]
        wanted = {f"{space}}}{name}" if space else name for name in names}
        return [self._read(child) for child in self.element if child.tag in wanted]

    def child(self, *names: str) -> "Node | None":
        """Return the one child of the given names; None when absent, an error when repeated."""
        found = self.children(*names)
        if len(found) > 1:
            raise found[1].bad(f"is given twice, first in line {found[0].line}")
        return found[0] if found else None

    def required(self, *names: str) -> "Node":
        """Return the one child of the given names; an error when absent."""
        found = self.child(*names)
        if found is None:
            raise self.bad(f"missing element {' or '.join(names)}")
        return found

    def fresh(self) -> "Node":
        """Return this element as if nothing had been read yet."""
        return Node(self.path, self.element, {self.element: set()})

    def every_child(self) -> list["Node"]:
        """All children that belong to the format, whatever their names, without counting them as read."""
        space = self.element.tag.rpartition("}")[0]
        return [Node(self.path, child, self.seen) for child in self.element if child.tag.rpartition("}")[0] == space]

    def read(self) -> "Node":
        """Count this element and those around it as read."""
        element = self.element
        while element is not None and element not in self.seen:
            self.seen[element] = set()
            element = element.getparent()
        return self

    def below(self, *path: str) -> list["Node"]:
        """All elements at a path of names below this one; every step may be there several times."""
        nodes = [self]
        for name in path:
            nodes = [child for node in nodes for child in node.children(name)]
        return nodes

    @property
    def content(self) -> str:
        """Text between the tags of the element."""
        return str(self.element.text or "").strip()

    def text(self, attribute: str) -> str | None:
        """Return an attribute as it stands there, None when absent."""
        self.seen[self.element].add(attribute)
        value = self.element.get(attribute)
        return None if value is None else str(value).strip()

    def has(self, attribute: str) -> bool:
        """Whether an attribute is there, without counting it as read."""
        return attribute in self.element.attrib

    def required_text(self, attribute: str) -> str:
        """Return an attribute; an error when it is absent or empty."""
        value = self.text(attribute)
        if not value:
            raise self.bad("missing attribute" if value is None else "must not be empty", attribute)
        return value

    def choice(self, attribute: str, known: tuple[str, ...]) -> str | None:
        """Return an attribute of few possible values, None when absent."""
        value = self.text(attribute)
        if value is not None and value not in known:
            raise self.bad(f"must be one of {', '.join(known)}, got {shown(value)}", attribute)
        return value

    def number(
        self,
        attribute: str,
        unit: str,
        *,
        at_least: float = -math.inf,
        above: float = -math.inf,
        at_most: float = math.inf,
    ) -> float | None:
        """Return an attribute as a finite number of a unit, which is "-" where it has none; None when absent."""
        text = self.text(attribute)
        if text is None:
            return None
        if len(text) > _LONGEST_NUMBER or not _NUMBER.fullmatch(text):
            wild = text.lower().lstrip("+-") in ("nan", "inf", "infinity")
            of = "" if unit == "-" else f" of {unit}"
            raise self.bad(f"must be {'finite' if wild else f'a number{of}'}, got {shown(text)}", attribute)
        value = float(text)
        if not math.isfinite(value):
            raise self.bad(f"must be finite, got {shown(text)}", attribute)
        wanted = (
            (abs(value) <= LARGEST_WRITTEN, f"within ±{LARGEST_WRITTEN:g}"),
            (value > above, f"above {above:g}"),
            (above != 0.0 or value >= SMALLEST_WRITTEN, f"at least {SMALLEST_WRITTEN:g}"),
            (value >= at_least, f"at least {at_least:g}"),
            (value <= at_most, f"at most {at_most:g}"),
        )
        for is_met, bound in wanted:
            if not is_met:
                told = bound if unit == "-" else f"{bound} {unit}"
                raise self.bad(f"must be {told}, got {shown(text)}", attribute)
        return value

    def required_number(
        self,
        attribute: str,
        unit: str,
        *,
        at_least: float = -math.inf,
        above: float = -math.inf,
        at_most: float = math.inf,
    ) -> float:
        """Return an attribute as a finite number of a unit; an error when absent."""
        value = self.number(attribute, unit, at_least=at_least, above=above, at_most=at_most)
        if value is None:
            raise self.bad("missing attribute", attribute)
        return value

    def flag(self, attribute: str) -> bool | None:
        """Return an attribute as true or false, None when absent."""
        value = self.choice(attribute, ("true", "false", "1", "0"))
        return None if value is None else value in ("true", "1")

    def dismiss(self) -> None:
        """Count all of this element as read: it was considered, and is not meant."""
        for element in self.element.iter():
            self.seen.setdefault(element, set()).update(element.attrib)

    def unused(self) -> list[str]:
        """Names of elements and attributes at or below this one that nobody has read, with their numbers."""
        return counted(self.unused_counts())

    def unused_counts(self) -> "Counter[str]":
        """How many elements and attributes of a name at or below this one nobody has read."""
        counts: Counter[str] = Counter()
        for element in self._seen_below(counts):
            for attribute in element.attrib:
                if attribute not in self.seen[element] and attribute not in _ADMINISTRATIVE:
                    counts[f"{_local(element)}@{attribute.rpartition('}')[2]}"] += 1
        return counts

    def _seen_below(self, counts: "Counter[str]") -> Iterator[Any]:
        """Walk over what was read; what was not is counted by its name, as a whole."""
        todo = [self.element]
        while todo:
            element = todo.pop()
            yield element
            for child in element:
                if child in self.seen:
                    todo.append(child)
                else:
                    counts[_local(child)] += 1

    def _read(self, element: Any) -> "Node":
        self.seen.setdefault(element, set())
        return Node(self.path, element, self.seen)


def counted(counts: "Counter[str]") -> list[str]:
    """Names with their numbers, where these are above 1, in the order of the alphabet."""
    return [name if count == 1 else f"{name} ({count})" for name, count in sorted(counts.items())]


def _local(element: Any) -> str:
    return str(element.tag).rpartition("}")[2]
