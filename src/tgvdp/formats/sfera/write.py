"""A journey with the advice of a run in it, for a driver advisory system: the message that it was read from, amended.

Advice is a temporary constraint of type AdvisedSpeed for each step and segment: what the driver does, and the speed at
its end, or the one that is held. Partial effort by which a train gains speed is acceleration to the speed at its end;
for partial effort by which it loses speed the protocol has no word: told to coast a train would lose it too soon, told
a constant speed it would brake to it or not come down to it. There is no advice there. Times are those of the run. All
else stands as it was; advice that stood there before is gone.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from datetime import UTC, datetime, timedelta
from importlib import import_module
from typing import Any

from tgvdp.formats.sfera.messages import JOURNEY, Messages, journey_name, journey_version
from tgvdp.formats.sfera.segments import SLACK_M, Segment, segments_of
from tgvdp.formats.sfera.timetable import DEPARTURE, NamedCall, calls_in
from tgvdp.formats.sources import Target
from tgvdp.formats.syntax.reading import read_document
from tgvdp.formats.syntax.xml import Node
from tgvdp.units import mps_to_kmh

#: What a driver does, as the protocol calls it.
_ADVICE = {
    "power": "AccelerationAdvice",
    "hold": "ConstantspeedAdvice",
    "coast": "CoastingAdvice",
    "brake": "OperationalBrakingAdvice",
}
_CONSTRAINT, _TYPE = "TemporaryConstraints", "AdvisedSpeed"
#: What stands before constraints in the reference to a segment.
_BEFORE = ("SP_Zone", "TimingPointConstraints", _CONSTRAINT)
#: What stands before the departure in a constraint of a timing point.
_BEFORE_DEPARTURE = ("TimingPointReference", "StoppingPointInformation")
#: Times are whole seconds; what is above one by less is rounding.
_ROUNDING_S = 0.01
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)

#: Arrival and departure of the run at a position, s on the clock of the journey.
Passing = Callable[[float], tuple[float, float]]


class AdvisableJourney:
    """A journey as it was read, into which the advice of a run can be put.

    Parameters
    ----------
    source : Target
        File, and which of its journeys.

    Raises
    ------
    InputError
        As of reading its line and its timetable.
    """

    def __init__(self, source: Target) -> None:
        messages = Messages(read_document(source.path))
        named = {journey_name(one): one for one in messages.each(JOURNEY)}
        chosen = named[source.part] if source.part is not None else next(iter(named.values()))
        self._journey = Node(source.path, deepcopy(chosen.element), {}).fresh()
        self._segments = segments_of(messages, self._journey)
        self._calls = list(calls_in(self._segments))

    def advised(self, stops_m: Sequence[float], steps: Sequence[Mapping[str, Any]], passing: Passing) -> bytes | None:
        """Put the steps and times of a run into the journey, once.

        Parameters
        ----------
        stops_m : sequence of float
            Where the run stops, m on its line, its two ends included.
        steps : sequence of mapping
            As of `tgvdp.report.advice.step_object`, in order.
        passing : callable

        Returns
        -------
        bytes or None
            None where the run has other stops than the journey: it would be advice for another one.
        """
        if not _are_same(sorted({call.position_m for call in self._calls if call.stops}), stops_m):
            return None
        for segment in self._segments:
            _advise(segment, steps)
        start_s = next(call.departure_s for call in self._calls if call.stops)
        for call in self._calls:
            if start_s is not None and stops_m[0] <= call.position_m <= stops_m[-1]:
                _plan(call, start_s, passing, (stops_m[0], stops_m[-1]))
        element = self._journey.element
        element.set("JP_Version", f"{journey_version(self._journey) + 1}")
        element.tail = None
        etree = import_module("lxml.etree")
        etree.indent(element)
        return bytes(etree.tostring(element, xml_declaration=True, encoding="UTF-8", pretty_print=True))


def _are_same(one: Sequence[float], other: Sequence[float]) -> bool:
    return len(one) == len(other) and all(abs(a - b) <= SLACK_M for a, b in zip(one, other, strict=True))


def _advise(segment: Segment, steps: Sequence[Mapping[str, Any]]) -> None:
    """Replace the advice of a segment by the steps that lie in it."""
    element = segment.reference.element
    for node in segment.reference.children(_CONSTRAINT):
        if node.text("temporaryConstraintType") == _TYPE:
            element.remove(node.element)
    at = sum(len(segment.reference.children(name)) for name in _BEFORE)
    for number, made in enumerate(_constraints(segment, steps)):
        element.insert(at + number, made)


def _constraints(segment: Segment, steps: Sequence[Mapping[str, Any]]) -> Iterator[Any]:
    etree = import_module("lxml.etree")
    for step in steps:
        advice = _advice_of(step)
        if advice is None:
            continue
        starts = step["from_m"] >= segment.offset_m - SLACK_M
        ends = step["to_m"] <= segment.end_m + SLACK_M
        from_m, to_m = max(step["from_m"], segment.offset_m), min(step["to_m"], segment.end_m)
        if to_m - from_m <= SLACK_M:
            continue
        places = {"startLocation": _location(segment, from_m)} if starts else {}
        places |= {"endLocation": _location(segment, to_m)} if ends else {}
        qualifier = f"{'Starts' if starts else ''}{'Ends' if ends else ''}" or "WholeSP"
        made = etree.Element(
            _tag(segment.reference, _CONSTRAINT), startEndQualifier=qualifier, temporaryConstraintType=_TYPE, **places
        )
        etree.SubElement(
            made,
            _tag(segment.reference, _TYPE),
            adviceType=advice,
            optimalSpeed=_decimal(_optimal_kmh(step), 1),
            reasonCode="energyOptimisation",
        )
        yield made


def _advice_of(step: Mapping[str, Any]) -> str | None:
    """Type of the advice for a step; None where the protocol has none."""
    if step["action"] == "partial":
        return _ADVICE["power"] if step["to_kmh"] > step["from_kmh"] else None
    return _ADVICE[step["action"]]


def _optimal_kmh(step: Mapping[str, Any]) -> float:
    """Speed at the end of a step, km/h; of one that holds its speed the mean, by which it takes its time."""
    if step["action"] == "hold":
        return mps_to_kmh((step["to_m"] - step["from_m"]) / (step["to_s"] - step["from_s"]))
    return float(step["to_kmh"])


def _location(segment: Segment, position_m: float) -> str:
    at_m = position_m - segment.offset_m if segment.forward else segment.end_m - position_m
    return _decimal(at_m, 3)


def _plan(call: NamedCall, start_s: float, passing: Passing, ends_m: tuple[float, float]) -> None:
    """Put the times of the run into a timing point: an arrival but at the first stop, a departure but at the last."""
    arrival_s, departure_s = passing(call.position_m)
    arrives_s = math.ceil(start_s + arrival_s - _ROUNDING_S)
    if call.position_m > ends_m[0]:
        call.node.element.set("TP_latestArrivalTime", _moment(call.node, arrives_s))
    details = call.node.child(DEPARTURE)
    if call.position_m == ends_m[1] or (details is None and not call.stops):
        return
    if details is None:
        at = sum(len(call.node.children(name)) for name in _BEFORE_DEPARTURE)
        element = call.node.element.makeelement(_tag(call.node, DEPARTURE))
        call.node.element.insert(at, element)
    else:
        element = details.element
    departs_s = math.floor(start_s + departure_s + _ROUNDING_S)
    element.set("departureTime", _moment(call.node, max(departs_s, arrives_s)))


def _tag(node: Node, name: str) -> str:
    return f"{{{node.namespace}}}{name}" if node.namespace else name


def _decimal(value: float, digits: int) -> str:
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _moment(node: Node, time_s: int) -> str:
    try:
        return (_EPOCH + timedelta(seconds=time_s)).strftime("%Y-%m-%dT%H:%M:%SZ")
    except OverflowError:
        raise node.bad("the run goes on beyond the year 9999") from None
