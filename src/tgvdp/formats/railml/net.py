"""Net elements of railML 3: how long each of them is, and where a measure lies on it.

Files of other tools seldom give ``netElement@length``. It follows from a ``track`` of known length: that of its one net
element, or what the others of its net elements leave; else from the mileage of its two ends, where that is in metres.
Source: the published documentation of the schema, and files of RaIL-AiD and of railML.org's example.
"""

from collections.abc import Iterator
from typing import NamedTuple

from tgvdp.formats.railml.rows import SLACK_M
from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.syntax.xml import Node

PLACE = "associatedNetElement"

#: What an ``associatedNetElement`` that means only a part of a net element has.
_EXTENT = ("posBegin", "posEnd", "intrinsicCoordBegin", "intrinsicCoordEnd")
_TOPOLOGY = ("infrastructure", "topology", "netElements", "netElement")
_TRACKS = ("infrastructure", "functionalInfrastructure", "tracks", "track")
_COLLECTIONS = ("elementCollectionOrdered", "elementCollectionUnordered")


class _Covered(NamedTuple):
    """Net elements that a track covers from end to end, and how long it is."""

    refs: list[str]
    length_m: float


class NetElements:
    """The net elements of a file by their ids."""

    def __init__(self, root: Node) -> None:
        self._nodes = {node.text("id") or "": node for node in root.below(*_TOPOLOGY)}
        self._metric = set(_metric_systems(root))
        self._lengths_m: dict[str, float] = {}
        self._covered = list(_covered(root))
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
        found: set[str] = set()
        todo = list(refs)
        while todo:
            node = self._nodes.get(todo.pop())
            collections = [] if node is None else node.children(*_COLLECTIONS)
            inner = {part.text("ref") or "" for one in collections for part in one.children("elementPart")} - found
            found |= inner
            todo += inner
        return found - refs

    def measured_m(self, coordinate: Node, node: Node, length_m: float) -> float:
        """Position on a net element of a measure in one of its positioning systems, m; linear between its two ends."""
        system = coordinate.text("positioningSystemRef")
        measure = coordinate.required_number("measure", "m")
        known = _measures(node, system)
        if not known or known[-1][1] == known[0][1]:
            raise coordinate.bad(f"its net element has no two coordinates in the positioning system {shown(system)}")
        (first, first_m), (last, last_m) = known[0], known[-1]
        if first == last:  # a net element of a coarse level has the two ends of its area at one coordinate
            first, last = 0.0, 1.0
        return length_m * (first + (last - first) * (measure - first_m) / (last_m - first_m))

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
            if measures_m and max(measures_m) - min(measures_m) > SLACK_M and _ends(node, system):
                return max(measures_m) - min(measures_m)
        return None


def track_length_m(track: Node) -> float | None:
    """Physical length of a track, m."""
    lengths = [one for one in track.children("length") if one.text("type") in (None, "physical")]
    return lengths[0].number("value", "m", above=0.0) if lengths else None


def is_whole(place: Node) -> bool:
    """Whether a place on a net element is all of it."""
    ends = place.children("linearCoordinateBegin", "linearCoordinateEnd")
    return not ends and not any(place.text(name) for name in _EXTENT)


def _covered(root: Node) -> Iterator[_Covered]:
    for track in root.below(*_TRACKS):
        # Further locations describe the same on another level of the network.
        places = [place for one in track.children("linearLocation")[:1] for place in one.children(PLACE)]
        length_m = track_length_m(track)
        if places and length_m is not None and all(map(is_whole, places)):
            yield _Covered([place.text("netElementRef") or "" for place in places], length_m)


def _metric_systems(root: Node) -> Iterator[str]:
    """Ids of the mileages that are in metres; files of RaIL-AiD say Km where they mean either."""
    for system in root.below("common", "positioning", "linearPositioningSystems", "linearPositioningSystem"):
        if system.text("units") == "m":
            yield system.text("id") or ""


def _measures(node: Node, system: str | None, *, named: bool = False) -> list[tuple[float, float]]:
    """Intrinsic coordinates of a net element and their measures in a positioning system, in order."""
    known = []
    for intrinsic in node.below("associatedPositioningSystem", "intrinsicCoordinate"):
        for linear in intrinsic.children("linearCoordinate"):
            given = linear.text("positioningSystemRef")
            if system is None or given == system or (given is None and not named):
                share = intrinsic.required_number("intrinsicCoord", "-", at_least=0.0)
                known.append((share, linear.required_number("measure", "m")))
    return sorted(known)


def _ends(node: Node, system: str) -> bool:
    """Whether the measures are those of the two ends: at 0 and 1, or both at one coordinate of an area."""
    shares = [share for share, _ in _measures(node, system, named=True)]
    return (shares[0], shares[-1]) == (0.0, 1.0) or shares[0] == shares[-1]
