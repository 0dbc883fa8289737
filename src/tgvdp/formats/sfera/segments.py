"""Segments of a journey one after the other: where their locations lie on the run, and what holds from where to where.

Locations are in m from the beginning of a segment, whichever way it is run. Of areas ``startEndQualifier`` says whether
they start and end in the segment; what goes on in the next one stands there as well.
"""

from collections.abc import Iterable, Iterator
from heapq import heappop, heappush
from itertools import pairwise
from typing import NamedTuple

from tgvdp.formats.sfera.messages import SEGMENT, Messages
from tgvdp.formats.syntax.xml import Node

#: Positions are told in whole metres, or parts of them.
SLACK_M = 1e-3


class Stretch(NamedTuple):
    """A part of the run, and the element that says what holds there."""

    from_m: float
    to_m: float
    node: Node


class Cap(NamedTuple):
    """A value that is not passed on a part of the run."""

    from_m: float
    to_m: float
    value: float


class Segment(NamedTuple):
    """A segment as a journey runs it.

    Attributes
    ----------
    reference, profile : Node
        The reference in the journey, and what it refers to.
    offset_m, length_m : float
        Where on the run it begins, and its length, m.
    forward : bool
        Whether it is run from its beginning to its end.
    """

    reference: Node
    profile: Node
    offset_m: float
    length_m: float
    forward: bool

    @property
    def end_m(self) -> float:
        """Where on the run it ends, m."""
        return self.offset_m + self.length_m

    def at_m(self, node: Node, attribute: str = "location") -> float:
        """Position on the run of a location, m.

        Raises
        ------
        InputError
            When it is missing or not within the segment.
        """
        at_m = node.required_number(attribute, "m", at_least=0.0)
        if at_m > self.length_m + SLACK_M:
            length = f"SP_Length, {self.length_m:.12g} m of {self.profile.path.name}"
            raise node.bad(f"must be within {length}, got {at_m:.12g} m", attribute)
        at_m = min(at_m, self.length_m)
        return self.offset_m + (at_m if self.forward else self.length_m - at_m)

    def stretch(self, node: Node) -> Stretch:
        """Part of the run that an area takes; constraints of a journey start and end as it is run."""
        qualifier = node.choice("startEndQualifier", ("Starts", "Ends", "StartsEnds", "WholeSP"))
        if qualifier is None:
            raise node.bad("missing attribute", "startEndQualifier")
        along = self.forward or node.name == "TemporaryConstraints"
        ends_m = (self.offset_m, self.end_m) if along else (self.end_m, self.offset_m)
        start_m = self.at_m(node, "startLocation") if qualifier.startswith("Starts") else ends_m[0]
        end_m = self.at_m(node, "endLocation") if qualifier.endswith("Ends") else ends_m[1]
        if self.forward and end_m < start_m:
            got = f"{end_m - self.offset_m:.12g} m after {start_m - self.offset_m:.12g} m"
            raise node.bad(f"must not lie before startLocation, got {got}", "endLocation")
        return Stretch(min(start_m, end_m), max(start_m, end_m), node)

    def areas(self, name: str) -> list[Stretch]:
        """Areas of the segment of a name."""
        return [self.stretch(node) for node in self.profile.below("SP_Areas", name)]

    def changes(self, owner: Node) -> list[Stretch]:
        """What starts with a segment (``…Start``) and changes in it (``…Change``), in the order of the run.

        Raises
        ------
        InputError
            When the start is missing or locations do not increase.
        """
        name = owner.name.removesuffix("s")
        rows = [(0.0, owner.required(f"{name}Start"))]
        for node in owner.children(f"{name}Change"):
            at_m = abs(self.at_m(node) - (self.offset_m if self.forward else self.end_m))
            if at_m < rows[-1][0]:
                raise node.bad(f"must not decrease, got {at_m:.12g} m after {rows[-1][0]:.12g} m", "location")
            rows.append((at_m, node))
        made = []
        for (from_m, node), (to_m, _) in pairwise([*rows, (self.length_m, owner)]):
            ends_m = (from_m, to_m) if self.forward else (self.length_m - to_m, self.length_m - from_m)
            if to_m - from_m > SLACK_M:
                made.append(Stretch(self.offset_m + ends_m[0], self.offset_m + ends_m[1], node))
        return made if self.forward else made[::-1]


def segments_of(messages: Messages, journey: Node) -> list[Segment]:
    """Segments of a journey in the order of the run.

    Raises
    ------
    InputError
        When there is none, one is not at hand or not valid, or a length is missing or not above 0.
    """
    made: list[Segment] = []
    for reference in journey.children("SegmentProfileReference"):
        profile = messages.find(SEGMENT, reference)
        if profile.choice("SP_Status", ("Valid", "Invalid")) == "Invalid":
            raise profile.bad("must be Valid, got 'Invalid'", "SP_Status")
        length_m = profile.required_number("SP_Length", "m", above=SLACK_M)
        forward = reference.choice("SP_Direction", ("Nominal", "Reverse")) != "Reverse"
        made.append(Segment(reference, profile, made[-1].end_m if made else 0.0, length_m, forward))
    if not made:
        raise journey.bad("missing element SegmentProfileReference: a journey without segments is no line")
    return made


def lowest(caps: Iterable[Cap], length_m: float) -> list[tuple[float, float | None]]:
    """Lowest value at each place of a run and where each begins, m; None where nothing holds, equal ones are one."""
    waiting = sorted((cap for cap in caps if cap.to_m - cap.from_m > SLACK_M), key=lambda cap: cap.from_m)
    edges_m = sorted({0.0, *(edge_m for cap in waiting for edge_m in cap[:2] if edge_m < length_m - SLACK_M)})
    rows: list[tuple[float, float | None]] = []
    holding: list[tuple[float, float]] = []  # value and end
    taken = 0
    for edge_m in edges_m:
        while taken < len(waiting) and waiting[taken].from_m <= edge_m:
            heappush(holding, (waiting[taken].value, waiting[taken].to_m))
            taken += 1
        while holding and holding[0][1] <= edge_m:
            heappop(holding)
        value = holding[0][0] if holding else None
        if not rows or rows[-1][1] != value:
            rows.append((edge_m, value))
    return rows


def joined(stretches: Iterable[tuple[float, float, float]]) -> Iterator[tuple[float, float, float]]:
    """Stretches with their values, those that touch or overlap and have one value as one; in order of their starts."""
    last: tuple[float, float, float] | None = None
    for from_m, to_m, value in stretches:
        if last is not None and value == last[2] and from_m - last[1] <= SLACK_M:
            last = (last[0], max(last[1], to_m), value)
            continue
        if last is not None:
            yield last
        last = (from_m, to_m, value)
    if last is not None:
        yield last
