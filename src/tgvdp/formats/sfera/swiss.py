"""Swiss line and curve speeds, which stand in network-specific parameters (NSP), by train and brake series.

``newLineSpeed`` at a place: the speed from there on. ``curvePoint``: the speed between a begin and an end. What does
not say for itself how far it holds (``stationSpeed``, speeds such as 95/85) is not read.
"""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.formats.sfera.category import Category
from tgvdp.formats.sfera.segments import Cap, Segment
from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.syntax.xml import Node, counted, parse_xml

#: SBB Infrastructure, by its code of UIC.
_COMPANY = "0085"
_LINE, _CURVE, _STATION = GROUPS = ("newLineSpeed", "curvePoint", "stationSpeed")
#: A speed that says all by itself, if it is one.
_NUMBER = re.compile(r"[+-]?\d+(?:\.\d+)?", re.ASCII)


class SwissSpeeds(NamedTuple):
    """Line speeds and curve speeds, km/h, and what there is to say of them."""

    line: list[Cap]
    curves: list[Cap]
    notes: list[str]


class _Point(NamedTuple):
    """A group of parameters: its position on the run, the element, and the parameters by their names."""

    at_m: float
    node: Node
    parameters: dict[str, Node]


def swiss_speeds(segments: Sequence[Segment], category: Category) -> SwissSpeeds:
    """Read the line and curve speeds of a train.

    Parameters
    ----------
    segments : sequence of Segment
    category : Category
        Its code is the train series, its braked weight percentage the brake series.

    Raises
    ------
    InputError
        When a parameter holds no XML, or a speed is not above 0.
    """
    left: Counter[str] = Counter()
    line = list(_line(segments, category, left))
    curves = list(_curves(segments, category, left))
    left += Counter({_STATION: sum(len(list(_points(segment, _STATION))) for segment in segments)})
    notes = []
    if line or curves:
        notes.append(f"Swiss line and curve speeds are those for {category}, as {category.name} says")
    if left:
        text = f"speeds that are not read, as they do not say for {category} how high they are and how far they hold"
        notes.append(f"{text}: {', '.join(counted(left))}")
    return SwissSpeeds(line, curves, notes)


def _line(segments: Sequence[Segment], category: Category, left: Counter[str]) -> Iterator[Cap]:
    """Speeds from their places on; from one that is not read on, and where they are for the other direction, none."""
    rows: list[tuple[float, float | None]] = []
    for segment in segments:
        points = sorted(_points(segment, _LINE), key=lambda point: point.at_m)
        if points and not segment.forward:
            rows.append((segment.offset_m, None))
        for point in points:
            kmh = _kmh(point, "xmlNewLineSpeed", category) if segment.forward else None
            left[_LINE] += kmh is None
            rows.append((point.at_m, kmh))
    for (from_m, kmh), (to_m, _) in pairwise([*rows, (segments[-1].end_m, None)]):
        if kmh is not None:
            yield Cap(from_m, to_m, kmh)


def _curves(segments: Sequence[Segment], category: Category, left: Counter[str]) -> Iterator[Cap]:
    """Speeds between a begin and the end of the same identifier in the same segment."""
    for segment in segments:
        begun: dict[str, _Point] = {}
        for point in sorted(_points(segment, _CURVE), key=lambda point: point.at_m):
            identifier = point.node.text("identifier") or ""
            kind = point.parameters.get("curvePointType")
            is_begin = kind is not None and kind.text("value") == "begin"
            before = begun.pop(identifier, None)
            if is_begin and segment.forward:
                left[_CURVE] += before is not None
                begun[identifier] = point
                continue
            kmh = None if before is None else _kmh(before, "xmlCurveSpeed", category)
            left[_CURVE] += kmh is None
            if before is not None and kmh is not None:
                yield Cap(before.at_m, point.at_m, kmh)
        left[_CURVE] += len(begun)


def _points(segment: Segment, group: str) -> Iterator[_Point]:
    """Groups of parameters of a name: at network-specific points, and at the beginning of places."""
    for node in segment.profile.below("SP_Points", "NetworkSpecificPoint"):
        if _is_group(node, group):
            yield _Point(segment.at_m(node), node, _parameters(node))
    for place in segment.profile.below("SP_Areas", "TAF_TAP_Location"):
        for node in place.children("TAF_TAP_Location_NSP"):
            if _is_group(node, group):
                yield _Point(segment.stretch(place).from_m, node, _parameters(node))


def _is_group(node: Node, group: str) -> bool:
    company, name = node.child("teltsi_Company"), node.child("NSP_GroupName")
    return company is not None and name is not None and (company.content, name.content) == (_COMPANY, group)


def _parameters(node: Node) -> dict[str, Node]:
    return {parameter.required_text("name"): parameter for parameter in node.children("NetworkSpecificParameter")}


def _kmh(point: _Point, name: str, category: Category) -> float | None:
    """Speed for a train; None where there is none for its series, or several, or no plain number."""
    parameter = point.parameters.get(name)
    if parameter is None or not category.code:
        return None
    text = parameter.required_text("value")
    try:
        root = parse_xml(parameter.path, text.encode())
        rows = [*root.below("v"), *root.below("speeds", "v")]
        texts = {row.required_text("speed") for row in rows if _is_for(row, category)}
    except InputError as error:
        inner = str(error).removeprefix(f"{parameter.path}: ")
        raise parameter.bad(f"{name}: {inner}", "value") from None
    if len(texts) != 1:
        return None
    written = texts.pop()
    if not _NUMBER.fullmatch(written):
        return None
    kmh = float(written)
    if not kmh > 0.0:
        raise parameter.bad(f"{name}: speed must be above 0 km/h, got {shown(written)}", "value")
    return kmh


def _is_for(row: Node, category: Category) -> bool:
    """Whether a speed is for a train series, and for its brake series where it names one."""
    braked_pct = row.number("brakeSeries", "%")
    return row.text("trainSeries") == category.code and braked_pct in (None, category.braked_pct)
