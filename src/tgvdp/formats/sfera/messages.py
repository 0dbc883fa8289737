"""Messages of SFERA: journeys, segments and trains of a file, and those that a journey refers to, beside it.

A journey (JourneyProfile) refers to segments (SegmentProfile) and trains (TrainCharacteristics) by identifier, version
and owner. They stand in the same message or in files of the same folder, where they are told by what they hold.
"""

import re
from collections.abc import Iterator
from functools import cached_property
from hashlib import sha256
from html import unescape
from importlib import import_module
from pathlib import Path

from tgvdp.errors import InputError
from tgvdp.formats.syntax.reading import Document, bad, errors_named, read_bytes, require_not_alone, shown
from tgvdp.formats.syntax.xml import Node, parse_xml

JOURNEY, SEGMENT, TRAIN = KINDS = ("JourneyProfile", "SegmentProfile", "TrainCharacteristics")
#: What messages begin with that can hold the others.
_ENVELOPES = ("SFERA_G2B_", "G2B_")
#: So much of a file tells what it is.
_HEAD_BYTES = 4096
_BEGINNING = re.compile(rb"<(?:(?:SegmentProfile|TrainCharacteristics)\b|SFERA_G2B_|G2B_)")
#: An identifier, wherever it stands.
_IDENTIFIER = re.compile(rb"""\b(?:SP|TC)_ID\s*=\s*(?:"([^"]*)"|'([^']*)')""")
#: Identifier and version of what is referred to, and whose it is.
KEYS = {
    SEGMENT: ("SP_ID", "SP_VersionMajor", "SP_VersionMinor"),
    TRAIN: ("TC_ID", "TC_VersionMajor", "TC_VersionMinor"),
}
_OWNERS = {SEGMENT: (("SP_Zone", "IM_ID"),), TRAIN: (("TC_RU_ID",), ("teltsi_KeeperShortNameVKM",))}


def is_message(name: str) -> bool:
    """Whether an element of that name, as the root of a file, is a message that is read here."""
    return name in KINDS or name.startswith(_ENVELOPES)


class Messages:
    """What a file holds, and what it refers to.

    Attributes
    ----------
    path : Path
        The file.
    inputs : dict
        SHA-256 of the files beside it that were used, by their paths; it grows as things are looked up.
    """

    def __init__(self, document: Document) -> None:
        self.path, self._document = document.path, document
        self._root = parse_xml(document.path, document.data)
        self.inputs: dict[str, str] = {}
        self._named: dict[str, dict[str, list[Node]]] = {}
        self._parsed: dict[Path, tuple[Node, str]] = {}

    def each(self, kind: str) -> list[Node]:
        """All messages of a kind that stand in the file."""
        return _each(self._root, kind)

    def find(self, kind: str, reference: Node) -> Node:
        """Return what an element refers to, as if nothing of it had been read yet.

        Raises
        ------
        InputError
            When there is none, or several of that identifier and version that differ.
        """
        key = KEYS[kind][0]
        wanted = reference.required_text(key)
        near = self._by_name(kind).get(wanted, [])
        found = [node for node in near if _is(kind, node, reference)]
        versions = [_version(kind, node) for node in near]
        if not found:
            with errors_named(self.path):
                require_not_alone(self._document, f"{kind} {wanted}")
            for root, digest in self._beside(wanted):
                near = [node for node in _each(root, kind) if node.text(key) == wanted]
                versions += [f"{_version(kind, node)} in {node.path.name}" for node in near]
                own = [node for node in near if _is(kind, node, reference)]
                self.inputs.update({str(node.path): digest for node in own})
                found += own
        if len(found) > 1 and len(set(map(_canonical, found))) > 1:
            places = " and ".join(f"{node.path.name} line {node.line}" for node in found[:2])
            raise reference.bad(f"{len(found)} {kind}s of this version that differ, in {places}: leave one", key)
        if not found:
            held = f"; there is {', '.join(versions)}"[:200] if versions else ", nor beside the file"
            raise reference.bad(f"no {kind} {shown(wanted)} {_version(kind, reference)} in the file{held}", key)
        return found[0].fresh()

    def _by_name(self, kind: str) -> dict[str, list[Node]]:
        """Messages of a kind in the file, by their identifiers."""
        if kind not in self._named:
            known: dict[str, list[Node]] = {}
            for node in self.each(kind):
                known.setdefault(node.required_text(KEYS[kind][0]), []).append(node)
            self._named[kind] = known
        return self._named[kind]

    def _beside(self, identifier: str) -> Iterator[tuple[Node, str]]:
        """Other messages of the folder that name an identifier, with the SHA-256 of their files."""
        for path in self._others.get(identifier, ()):
            if path not in self._parsed:
                data = read_bytes(path)
                self._parsed[path] = parse_xml(path, data), sha256(data).hexdigest()
            yield self._parsed[path]

    @cached_property
    def _others(self) -> dict[str, list[Path]]:
        """Files of the folder that begin as messages do, by the identifiers that they name."""
        named: dict[str, list[Path]] = {}
        for path in sorted(self.path.parent.glob("*.xml")):
            if path != self.path and _begins_so(path):
                found = {unescape((one or other).decode("utf-8", "replace"))
                         for one, other in _IDENTIFIER.findall(read_bytes(path))}  # fmt: skip
                for identifier in found:
                    named.setdefault(identifier, []).append(path)
        return named


def _begins_so(path: Path) -> bool:
    try:
        if not path.is_file():  # a pipe would be waited for
            return False
        with path.open("rb") as file:
            return _BEGINNING.search(file.read(_HEAD_BYTES)) is not None
    except OSError:
        return False


def _each(root: Node, kind: str) -> list[Node]:
    if root.name == kind:
        return [root]
    payloads = [child.read() for child in root.every_child() if child.name.endswith("Payload")] or [root]
    return [node for payload in payloads for node in payload.children(kind)]


def _canonical(node: Node) -> bytes:
    """Text of an element that is the same however its attributes are ordered and quoted."""
    return bytes(import_module("lxml.etree").tostring(node.element, method="c14n", with_tail=False))


def _owner(kind: str, node: Node) -> str:
    """Whose a segment or train is, by the code that the element or one below it holds."""
    for path in _OWNERS[kind]:
        found = node.below(*path)
        if found:
            return found[0].content
    raise node.bad(f"missing element {' or '.join('/'.join(path) for path in _OWNERS[kind])}")


def _is(kind: str, node: Node, reference: Node) -> bool:
    """Whether a message is what an element refers to: without a minor version any one will do."""
    name, major, minor = KEYS[kind]
    return (
        node.text(name) == reference.required_text(name)
        and node.text(major) == reference.required_text(major)
        and reference.text(minor) in (None, node.text(minor))
        and _owner(kind, node) == _owner(kind, reference)
    )


def _version(kind: str, node: Node) -> str:
    _, major, minor = KEYS[kind]
    parts = [text for text in (node.text(major), node.text(minor)) if text is not None]
    return f"{'.'.join(parts)} of {_owner(kind, node)}"


def journey_version(journey: Node) -> int:
    """Version of a journey, 0 where it says none.

    Raises
    ------
    InputError
        When it is no whole number.
    """
    version = journey.number("JP_Version", "-", at_least=0.0) or 0.0
    if not version.is_integer():
        raise journey.bad(f"must be a whole number, got {shown(journey.text('JP_Version'))}", "JP_Version")
    return int(version)


def journey_name(journey: Node) -> str:
    """Number of the train that a journey is of.

    Raises
    ------
    InputError
        When it has none.
    """
    for path in (("OTN_ID", "teltsi_OperationalTrainNumber"), ("TAF_TAP_ID", "teltsi_Core")):
        found = journey.below("TrainIdentification", *path)
        if found and found[0].content:
            return found[0].content
    raise journey.bad("missing element TrainIdentification/OTN_ID/teltsi_OperationalTrainNumber")


def nothing_to_run(messages: Messages) -> InputError:
    """Make the error for a file of which neither a line nor a train can be read."""
    if messages.each(SEGMENT):
        return bad(messages.path, "holds segments alone: a JourneyProfile tells in which order they are run")
    return bad(messages.path, f"holds no {JOURNEY} and no {TRAIN}: of SFERA messages these are read")
