"""Net elements of railML 3: how long each of them is, and where a measure lies on it.

Files of other tools seldom give ``netElement@length``. It follows from a ``track`` of known length: that of its one net
element, or what the others of its net elements leave; else from the mileage of its two ends, where that is in metres.
Mileage may jump (anchors of a positioning system, ``mileageChange``): no length and no place follows across a jump.
Source: the published documentation of the schema, and files of RaIL-AiD and of railML.org's example.
"""

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from operator import itemgetter
from typing import NamedTuple

from tgvdp.formats.railml.rows import SLACK_M
from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.syntax.xml import Node

PLACE = "associatedNetElement"

#: What an ``associatedNetElement`` that means only a part of a net element has.
_EXTENT = ("posBegin", "posEnd", "intrinsicCoordBegin", "intrinsicCoordEnd")
_TOPOLOGY = ("infrastructure", "topology", "netElements", "netElement")
_TRACKS = ("infrastructure", "functionalInfrastructure", "tracks", "track")
_SYSTEMS = ("common", "positioning", "linearPositioningSystems", "linearPositioningSystem")
_CHANGES = ("infrastructure", "functionalInfrastructure", "mileageChanges", "mileageChange")
_COLLECTIONS = ("elementCollectionOrdered", "elementCollectionUnordered")


class _Covered(NamedTuple):
    """Net elements that a track covers from end to end, and how long it is."""

    refs: list[str]
    length_m: float


class _Jump(NamedTuple):
    """A place where mileage is not distance: in a positioning system, on one net element where it names one."""

    system: str | None
    ref: str | None
    measure: float
    line: int


class NetElements:
    """The net elements of a file by their ids."""

    def __init__(self, root: Node) -> None:
        self._nodes = {node.text("id") or "": node for node in root.below(*_TOPOLOGY)}
        self._metric = set(_metric_systems(root))
        self._lengths_m: dict[str, float] = {}
        self._covered = list(_covered(root))
        self._jumps = [*_anchored_jumps(root), *_changes(root)]
        self._derive()

    def node(self, place: Node, ref: str) -> Node:
        """Return the net element that a place is on."""
        node = self._nodes.get(ref)
        if node is None:
            raise place.bad(f"no net element {shown(ref)} in this file", "netElementRef")
        return node

    def length_m(self, ref: str) -> float | None:
        """Length of a net element, m; None where it does not follow from anything in the file."""
        node = self._nodes[ref]
        own_m = node.number("length", "m", above=0.0)
        return own_m if own_m is not None else self._lengths_m.get(ref) or self._by_mileage_m(node)

    def parts(self, refs: set[str]) -> set[str]:
        """Net elements of a finer level that some are made of, at any depth."""
        return _reached(refs, lambda ref: _parts(self._nodes[ref]) if ref in self._nodes else set())

    def wholes(self, refs: set[str]) -> set[str]:
        """Net elements of a coarser level that some are parts of, at any depth."""
        owners: dict[str, set[str]] = {}
        for ref, node in self._nodes.items():
            for part in _parts(node):
                owners.setdefault(part, set()).add(ref)
        return _reached(refs, lambda ref: owners.get(ref, set()))

    def measured_m(self, coordinate: Node, node: Node, length_m: float) -> float:
        """Position on a net element of a measure in a positioning system, m; linear between its coordinates."""
        system = coordinate.text("positioningSystemRef")
        measure = coordinate.required_number("measure", "m")
        known = _measures(node, system)
        if len({measure_m for _, measure_m in known}) < 2:
            raise coordinate.bad(f"its net element has no two coordinates in the positioning system {shown(system)}")
        if (
            known[0][0] == known[-1][0]
        ):  # a net element of a coarse level has the two ends of its area at one coordinate
            ends_m = [measure_m for _, measure_m in known]
            known = [(0.0, min(ends_m)), (1.0, max(ends_m))]
        spans = [(one, other) for one, other in pairwise(known) if one[1] != other[1]]
        beyond = [max(min(a[1], b[1]) - measure, measure - max(a[1], b[1]), 0.0) for a, b in spans]
        shares = []
        for ((first, first_m), (last, last_m)), off in zip(spans, beyond, strict=True):
            if off > min(beyond):
                continue
            jump = self._jump(node, system, first_m, last_m)
            if jump is not None and first != last:
                where = f"at {jump.measure:.12g} (line {jump.line})"
                raise coordinate.bad(f"mileage of its net element jumps {where}: give pos or intrinsicCoord", "measure")
            shares.append(first + (last - first) * (measure - first_m) / (last_m - first_m))
        if length_m * (max(shares) - min(shares)) > SLACK_M:
            raise coordinate.bad("is the mileage of two places of its net element", "measure")
        return length_m * shares[0]

    def _jump(self, node: Node, system: str | None, one_m: float, other_m: float) -> _Jump | None:
        """Find a jump of mileage between two measures on a net element."""
        low_m, high_m = sorted((one_m, other_m))
        for jump in self._jumps:
            known = jump.ref in (None, node.text("id")) and (system is None or jump.system in (None, system))
            if known and low_m + SLACK_M < jump.measure < high_m - SLACK_M:
                return jump
        return None

    def _derive(self) -> None:
        """Lengths that follow from those of tracks; each may make another one follow."""
        found = True
        while found:
            found = False
            for refs, total_m in self._covered:
                lengths_m = {ref: self.length_m(ref) for ref in refs if ref in self._nodes}
                missing = [ref for ref, length_m in lengths_m.items() if length_m is None]
                rest_m = total_m - sum(length_m or 0.0 for length_m in lengths_m.values())
                if len(missing) == 1 and rest_m > SLACK_M:
                    self._lengths_m[missing[0]] = rest_m
                    found = True

    def _by_mileage_m(self, node: Node) -> float | None:
        for system in sorted(self._metric):
            measures_m = [measure_m for _, measure_m in _measures(node, system, named=True)]
            low_m, high_m = min(measures_m, default=0.0), max(measures_m, default=0.0)
            if high_m - low_m > SLACK_M and _ends(node, system) and not self._jump(node, system, low_m, high_m):
                return high_m - low_m
        return None


def track_length_m(track: Node) -> float | None:
    """Physical length of a track, m."""
    lengths = [one for one in track.children("length") if one.text("type") in (None, "physical")]
    return lengths[0].number("value", "m", above=0.0) if lengths else None


def is_whole(place: Node) -> bool:
    """Whether a place on a net element is all of it."""
    ends = place.children("linearCoordinateBegin", "linearCoordinateEnd")
    return not ends and not any(place.text(name) for name in _EXTENT)


def _parts(node: Node) -> set[str]:
    """Net elements that one is made of."""
    return {part.text("ref") or "" for one in node.children(*_COLLECTIONS) for part in one.children("elementPart")}


def _reached(refs: set[str], after: Callable[[str], set[str]]) -> set[str]:
    """All that is reached from some, step by step, but for these."""
    found, todo = set(refs), list(refs)
    while todo:
        new = after(todo.pop()) - found
        found |= new
        todo += new
    return found - refs


def _covered(root: Node) -> Iterator[_Covered]:
    for track in root.below(*_TRACKS):
        # Further locations describe the same on another level of the network.
        places = [place for one in track.children("linearLocation")[:1] for place in one.children(PLACE)]
        length_m = track_length_m(track)
        if places and length_m is not None and all(map(is_whole, places)):
            yield _Covered([place.text("netElementRef") or "" for place in places], length_m)


def _metric_systems(root: Node) -> Iterator[str]:
    """Ids of the mileages that are in metres; files of RaIL-AiD say Km where they mean either."""
    for system in root.below(*_SYSTEMS):
        if system.text("units") == "m":
            yield system.text("id") or ""


def _anchored_jumps(root: Node) -> Iterator[_Jump]:
    """Anchors of positioning systems from which it is not as far to the next one as their measures differ."""
    for system in root.below(*_SYSTEMS):
        for anchor, following in pairwise(system.children("anchor")):
            distance = anchor.number("measureToNext", "m")
            ends = [one.number("measure", "m") for one in (anchor, following)]
            if distance is None or None in ends:
                continue
            first, last = (end or 0.0 for end in ends)
            if not math.isclose(abs(last - first), abs(distance), rel_tol=0.0, abs_tol=SLACK_M):
                yield _Jump(system.text("id"), None, 0.5 * (first + last), anchor.line)


def _changes(root: Node) -> Iterator[_Jump]:
    """Mileage changes that say where they are, in the mileage before and behind them."""
    for change in root.below(*_CHANGES):
        for spot in change.children("spotLocation"):
            for coordinate in spot.children("linearCoordinate"):
                measure = coordinate.number("measure", "m")
                if measure is not None:
                    system = coordinate.text("positioningSystemRef")
                    yield _Jump(system, spot.text("netElementRef"), measure, change.line)


def _measures(node: Node, system: str | None, *, named: bool = False) -> list[tuple[float, float]]:
    """Intrinsic coordinates of a net element and their measures in a positioning system, in order.

    Two measures of one coordinate, where mileage jumps, stay in the order of the file.
    """
    known = []
    for intrinsic in node.below("associatedPositioningSystem", "intrinsicCoordinate"):
        for linear in intrinsic.children("linearCoordinate"):
            given = linear.text("positioningSystemRef")
            if system is None or given == system or (given is None and not named):
                share = intrinsic.required_number("intrinsicCoord", "-", at_least=0.0, at_most=1.0)
                known.append((share, linear.required_number("measure", "m")))
    return sorted(known, key=itemgetter(0))


def _ends(node: Node, system: str) -> bool:
    """Whether the measures are those of the two ends: at 0 and 1, or both at one coordinate of an area."""
    shares = [share for share, _ in _measures(node, system, named=True)]
    return (shares[0], shares[-1]) == (0.0, 1.0) or shares[0] == shares[-1]
