"""The timetable of a journey: where it stops and passes, and when it has to be there.

A train arrives, or passes, no later than ``TP_latestArrivalTime``, and earlier by no more than ``arrivalWindow``; it
departs no earlier than ``departureTime``. Planned times are for people (they are not to be used for calculations). The
clock of the journey starts with the first departure; what the date is does not matter.
"""

import math
import re
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.formats.calls import Call, journey_of
from tgvdp.formats.sfera.messages import Messages, journey_name
from tgvdp.formats.sfera.segments import Segment, segments_of
from tgvdp.formats.syntax.clocks import clock_s
from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.checks import plain_text
from tgvdp.model.journey import Journey

_MOMENT = re.compile(r"\d{4}-\d{2}-\d{2}T\d{2}:\d{2}:\d{2}Z")
_DURATION = re.compile(r"P(?:(\d{1,6})D)?(?:T(?:(\d{1,6})H)?(?:(\d{1,6})M)?(?:(\d{1,6}(?:\.\d{1,6})?)S)?)?")
_STOPS = ("Stopping_Point", "Skipped_Stopping_Point", "Passing_Point")
DEPARTURE = "StoppingPointDepartureDetails"


class NamedCall(NamedTuple):
    """A place of a timetable, its name and the element that says it; the others as of `Call`, times since 1970."""

    position_m: float
    name: str
    stops: bool
    arrival_s: float | None
    departure_s: float | None
    window_s: float
    node: Node

    @property
    def timed(self) -> Call:
        """The place and its times alone."""
        row = str(self.node.bad(f"{shown(self.name)} at {self.position_m:.12g} m of the journey"))
        return Call(self.position_m, self.stops, self.arrival_s, self.departure_s, self.window_s, row, self.name)


def has_times(journey: Node) -> bool:
    """Whether a journey has any time to keep."""
    points = journey.below("SegmentProfileReference", "TimingPointConstraints")
    return any(point.has("TP_latestArrivalTime") or point.below(DEPARTURE) for point in points)


def calls_of(segments: Sequence[Segment]) -> list[NamedCall]:
    """Places where a journey stops or passes, in the order of the run, one at each position.

    Raises
    ------
    InputError
        When a point is not in its segment, points are not in the order of the run, or a time is wrong.
    """
    return [_one(list(group)) for _, group in groupby(calls_in(segments), lambda call: call.position_m)]


def calls_in(segments: Sequence[Segment]) -> Iterator[NamedCall]:
    """Each TimingPointConstraints of a journey, in order; see `calls_of`."""
    last_m = 0.0
    for segment in segments:
        places = _Places(segment)
        for node in segment.reference.children("TimingPointConstraints"):
            call = _call(places, node)
            if call.position_m < last_m:
                got = f"got {call.position_m:.12g} m after {last_m:.12g} m of the journey"
                raise node.bad(f"{shown(call.name)} lies before the point above it, {got}")
            last_m = call.position_m
            yield call


def read_journey(messages: Messages, journey: Node) -> Journey:
    """Make the timetable of a journey.

    Raises
    ------
    InputError
        When there are not two stops, the first one has no departure, or times decrease.
    """
    journey = journey.fresh()
    calls = calls_of(segments_of(messages, journey))
    stops = [at for at, call in enumerate(calls) if call.stops]
    if len(stops) < 2:
        raise journey.bad("a timetable needs two TimingPointConstraints that are a Stopping_Point")
    first, run = calls[stops[0]], calls[stops[0] : stops[-1] + 1]
    if first.departure_s is None:
        raise first.node.bad(f"the first stop has no {DEPARTURE}@departureTime, with which the clock starts")
    _require_order(run)
    dwells = [call for call in run for node in call.node.children(DEPARTURE) if node.has("minimumDwellTime")]
    notes = (f"minimumDwellTime is not used at stops, where --dwell counts: {len(dwells)}",) if dwells else ()
    try:
        return journey_of(journey_name(journey), [call.timed for call in calls], notes, track=journey_name(journey))
    except InputError as error:
        raise journey.bad(str(error)) from None


def _require_order(calls: Sequence[NamedCall]) -> None:
    last_s = -math.inf
    for call in calls:
        for name, time_s in (("TP_latestArrivalTime", call.arrival_s), ("departureTime", call.departure_s)):
            if time_s is not None:
                if time_s < last_s:
                    got = f"got {last_s - time_s:g} s less than before"
                    raise call.node.bad(f"{shown(call.name)}: times must not decrease, {got}", name)
                last_s = time_s


class _Places:
    """Timing points of a segment, and the names of places that they are attached to."""

    def __init__(self, segment: Segment) -> None:
        self.segment = segment
        self._points: dict[str, list[Node]] = {}
        for point in segment.profile.below("SP_Points", "TimingPoint"):
            self._points.setdefault(point.required_text("TP_ID"), []).append(point)
        places = segment.profile.below("SP_Areas", "TAF_TAP_Location", "TAF_TAP_LocationIdent")
        self._names = {_code(place): _primary(place) for place in reversed(places)}

    def point(self, node: Node) -> Node:
        """Timing point of a constraint."""
        reference = node.required("TimingPointReference")
        identifier = reference.child("TP_ID_Reference")
        if identifier is None:
            raise reference.bad("must name a TimingPoint by TP_ID_Reference: zones leave open which one is meant")
        wanted = identifier.required_text("TP_ID")
        found = self._points.get(wanted, [])
        if len(found) != 1:
            count = f"{len(found)} times" if found else "not"
            where = f"segment {shown(self.segment.profile.text('SP_ID'))} of {self.segment.profile.path.name}"
            raise identifier.bad(f"TimingPoint {shown(wanted)} is {count} in {where}", "TP_ID")
        return found[0]

    def name(self, point: Node) -> str:
        """Name for people: its own, that of the place that it is attached to, or its identifier."""
        names = [name.text("name") or "" for name in point.children("TP_Name")]
        names += [self._names.get(_code(place), "") for place in point.children("TAF_TAP_LocationReference")]
        return next((text for name in (*names, point.text("TP_ID") or "") if (text := plain_text(name))), "")


def _code(place: Node) -> tuple[str, ...]:
    """Country and code of a place."""
    return tuple(child.content for child in place.children("teltsi_CountryCodeISO", "teltsi_LocationPrimaryCode"))


def _primary(place: Node) -> str:
    return next((child.content for child in place.children("teltsi_PrimaryLocationName")), "")


def _call(places: _Places, node: Node) -> NamedCall:
    point = places.point(node)
    kind = node.choice("TP_StopSkipPass", _STOPS)
    if kind is None:
        raise node.bad("missing attribute", "TP_StopSkipPass")
    for aside in ("TP_PlannedLatestArrivalTime", "TP_Information"):
        node.text(aside)
    departure_s = None
    details = node.child(DEPARTURE)
    if details is not None:
        details.text("plannedDepartureTime")
        departure_s = _moment_s(details, "departureTime")
    window_s = _duration_s(node, "arrivalWindow")
    return NamedCall(
        places.segment.at_m(point), places.name(point), kind == _STOPS[0], _moment_s(node, "TP_latestArrivalTime"),
        departure_s, math.inf if window_s is None else window_s, node,
    )  # fmt: skip


def _one(calls: Sequence[NamedCall]) -> NamedCall:
    """Calls at one position as one: at the end of a segment and the beginning of the next one."""
    arrivals = [call.arrival_s for call in calls if call.arrival_s is not None]
    departures = [call.departure_s for call in calls if call.departure_s is not None]
    return calls[0]._replace(
        stops=any(call.stops for call in calls),
        arrival_s=arrivals[0] if arrivals else None,
        departure_s=departures[-1] if departures else None,
        window_s=min(call.window_s for call in calls),
    )


def _moment_s(node: Node, attribute: str) -> float | None:
    text = node.text(attribute)
    if text is None:
        return None
    if not _MOMENT.fullmatch(text):
        raise node.bad(f"must be a time in UTC such as 2026-01-02T10:05:30Z, got {shown(text)}", attribute)
    try:
        return clock_s(text)
    except InputError as error:
        raise node.bad(str(error), attribute) from None


def _duration_s(node: Node, attribute: str) -> float | None:
    text = node.text(attribute)
    if text is None:
        return None
    match = _DURATION.fullmatch(text)
    if match is None or not any(match.groups()):
        raise node.bad(f"must be a duration such as PT1M30S, got {shown(text)}", attribute)
    days, hours, minutes, seconds = (float(group or 0) for group in match.groups())
    return 86_400.0 * days + 3_600.0 * hours + 60.0 * minutes + seconds
