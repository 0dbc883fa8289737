"""A run over the net elements of railML 3: where stretches and spots on them lie on it.

Positions on a net element are read from ``pos`` (m from its start), else from ``intrinsicCoord`` (share of its length),
else from ``linearCoordinate`` by the net element's own positioning system. Source: the published documentation of the
schema.
"""

from bisect import bisect_right
from collections.abc import Iterator
from operator import attrgetter
from typing import NamedTuple

from tgvdp.formats.railml.net import PLACE, NetElements, is_whole, track_length_m
from tgvdp.formats.railml.rows import SLACK_M
from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.syntax.xml import Node

DIRECTIONS = ("normal", "reverse")
_APPLICATIONS = (*DIRECTIONS, "both")


class _Part(NamedTuple):
    """A net element of a path: the stretch of it that the run uses, and where on the run that starts."""

    from_m: float
    to_m: float
    forward: bool
    offset_m: float


class Stretch(NamedTuple):
    """A part of the run that an element describes; ``forward`` when the element looks the way that the train runs."""

    from_m: float
    to_m: float
    node: Node
    forward: bool


class NetPath:
    """Net elements one after the other, as a run meets them."""

    def __init__(self, root: Node, owner: Node, direction: str) -> None:
        self._net = NetElements(root)
        self.parts: dict[str, _Part] = {}
        self.length_m = 0.0
        places = sorted(_associated(_location(owner)), key=lambda place: place.number("sequence", "-") or 0.0)
        self._merged, merged_m = self._together(owner, places)
        run_forward = direction == DIRECTIONS[0]
        for place in places if run_forward else places[::-1]:
            ref = place.required_text("netElementRef")
            if ref in self.parts:
                raise place.bad(f"net element {shown(ref)} is passed twice", "netElementRef")
            from_m, to_m = (0.0, merged_m) if ref in self._merged else self.extent(place)[1:]
            if ref in self._merged:
                merged_m = 0.0  # all of it stands with the first of them
            along = place.flag("keepsOrientation") is not False
            self.parts[ref] = _Part(min(from_m, to_m), max(from_m, to_m), along == run_forward, self.length_m)
            self.length_m += abs(to_m - from_m)
        if not self.length_m > 0.0:
            raise owner.bad("has no length: its linearLocation covers nothing")

    def _together(self, owner: Node, places: list[Node]) -> tuple[frozenset[str], float]:
        """Net elements of a track of which only the length of all together is known, and that length, m."""
        lengths_m = {}
        for place in places:
            ref = place.required_text("netElementRef")
            self._net.node(place, ref)
            lengths_m[ref] = self._net.length_m(ref)
        missing = frozenset(ref for ref, length_m in lengths_m.items() if length_m is None)
        total_m = track_length_m(owner)
        if len(missing) < 2 or total_m is None or not all(map(is_whole, places)):
            return frozenset(), 0.0
        rest_m = total_m - sum(length_m or 0.0 for length_m in lengths_m.values())
        return (missing, rest_m) if rest_m > SLACK_M else (frozenset(), 0.0)

    @property
    def related(self) -> set[str]:
        """Net elements of finer levels that those of the run are made of, and of coarser ones that are made of them."""
        own = set(self.parts)
        return self._net.parts(own) | self._net.wholes(own)

    def extent(self, place: Node) -> tuple[str, float, float]:
        """Net element and the two positions on it, m, of an ``associatedNetElement``."""
        ref = place.required_text("netElementRef")
        element, length_m = self._element(place, ref)
        ends = []
        for side, default in (("Begin", 0.0), ("End", length_m)):
            coordinate = place.child(f"linearCoordinate{side}")
            at_m = self._position_m(place, element, length_m, (f"pos{side}", f"intrinsicCoord{side}"), coordinate)
            ends.append(default if at_m is None else at_m)
        return ref, ends[0], ends[1]

    def passes(self, node: Node, *locations: str) -> bool:
        """Whether an element lies on a net element of the run, by its linear locations or others."""
        return not self.parts.keys().isdisjoint(self.refs(node, *locations))

    def refs(self, node: Node, *locations: str) -> list[str]:
        """Net elements that an element lies on, by its linear locations or others."""
        boxes = node.children(*(locations or ("linearLocation",)))
        places = [place for box in boxes for place in (*box.children(PLACE), box)]
        return [ref for place in places for ref in [place.text("netElementRef")] if ref]

    def spot(self, place: Node) -> float | None:
        """Distance on the run of a ``spotLocation``, m; None when it lies elsewhere."""
        ref = place.required_text("netElementRef")
        part = self.parts.get(ref)
        if part is None:
            return None
        element, length_m = self._element(place, ref)
        at_m = self._position_m(place, element, length_m, ("pos", "intrinsicCoord"), place.child("linearCoordinate"))
        if at_m is None:
            raise place.bad("missing pos, intrinsicCoord or linearCoordinate")
        inside = part.from_m - SLACK_M <= at_m <= part.to_m + SLACK_M
        return _on_run(part, min(max(at_m, part.from_m), part.to_m)) if inside else None

    def stretches(self, nodes: list[Node]) -> list[Stretch]:
        """Parts of the run on which elements apply in its direction, in the order of the run."""
        found: list[Stretch] = []
        for node in nodes:
            here = [one for one, applies in self._stretches(node) if applies]
            if not here:
                node.dismiss()
            found += here
        return sorted(found, key=_order)

    def ground(self, nodes: list[Node]) -> list[Stretch]:
        """Parts of the run that elements describe, in the order of the run, whichever direction they apply to.

        Ground is there in both directions. Where each has a description of its own, that of the run's counts.
        """
        found = [both for node in nodes for both in self._stretches(node)]
        own = sorted((one for one, applies in found if applies), key=_order)
        rest = [part for one, applies in found if not applies for part in _outside(one, own)]
        used = {part.node.element for part in (*own, *rest)}
        for node in nodes:
            if node.element not in used:
                node.dismiss()
        return sorted([*own, *rest], key=_order)

    def _stretches(self, node: Node) -> Iterator[tuple[Stretch, bool]]:
        """Parts of the run that an element lies on, and whether it applies in the run's direction there."""
        for location in node.children("linearLocation"):
            application = location.choice("applicationDirection", _APPLICATIONS) or "both"
            for place in _associated(location):
                part = self.parts.get(place.required_text("netElementRef"))
                if part is None:
                    continue
                _, first_m, last_m = self.extent(place)
                # A location looks along its net element, or against it; where its two ends are swapped as well.
                forward = (place.flag("keepsOrientation") is not False) == part.forward
                applies = application == "both" or (application == DIRECTIONS[0]) == forward
                low_m, high_m = max(min(first_m, last_m), part.from_m), min(max(first_m, last_m), part.to_m)
                if high_m - low_m > SLACK_M:
                    one_m, other_m = _on_run(part, low_m), _on_run(part, high_m)
                    yield Stretch(min(one_m, other_m), max(one_m, other_m), node, forward), applies

    def _element(self, place: Node, ref: str) -> tuple[Node, float]:
        element = self._net.node(place, ref)
        if ref in self._merged:
            raise place.bad(f"net element {shown(ref)} has no length, only all of its track has one", "netElementRef")
        length_m = self._net.length_m(ref)
        if length_m is None:
            raise element.bad("missing attribute (m), nor has a track on it alone a length", "length")
        return element, length_m

    def _position_m(
        self, place: Node, element: Node, length_m: float, names: tuple[str, str], coordinate: Node | None
    ) -> float | None:
        pos, intrinsic = names
        at_m, name = place.number(pos, "m"), pos
        share = place.number(intrinsic, "-", at_least=0.0)
        if at_m is None and share is not None:
            at_m, name = share * length_m, intrinsic
        if at_m is None and coordinate is not None:
            at_m, place, name = self._net.measured_m(coordinate, element, length_m), coordinate, "measure"
        if at_m is not None and not -SLACK_M <= at_m <= length_m + SLACK_M:
            raise place.bad(f"must lie on the net element of {length_m:.12g} m, got {at_m:.12g} m", name)
        return None if at_m is None else min(max(at_m, 0.0), length_m)


def _order(one: Stretch) -> tuple[float, float]:
    return one.from_m, one.to_m


def _outside(one: Stretch, others: list[Stretch]) -> Iterator[Stretch]:
    """Parts of a stretch that none of others, which do not overlap, covers."""
    at_m = one.from_m
    for other in others[bisect_right(others, one.from_m, key=attrgetter("to_m")) :]:
        if other.from_m - at_m > SLACK_M:
            yield one._replace(from_m=at_m, to_m=min(other.from_m, one.to_m))
        at_m = max(at_m, other.to_m)
        if one.to_m - at_m <= SLACK_M:
            return
    yield one._replace(from_m=at_m)


def _on_run(part: _Part, at_m: float) -> float:
    return part.offset_m + (at_m - part.from_m if part.forward else part.to_m - at_m)


def _location(owner: Node) -> Node:
    """Return the first linear location; others describe the same on another level of the network."""
    locations = owner.children("linearLocation")
    if not locations:
        raise owner.bad("missing element linearLocation")
    return locations[0]


def _associated(location: Node) -> list[Node]:
    places = location.children(PLACE)
    if not places:
        raise location.bad("missing element associatedNetElement")
    for place in places:
        place.text("sequence")  # of use where the order matters
    return places
