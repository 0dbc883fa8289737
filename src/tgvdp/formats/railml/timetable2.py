"""Timetables of railML 2.0 to 2.5: trains, and train parts with their times at operational points.

Where an operational point lies, its name or its code tells, as the line has them. Source: the published documentation
of the schema.
"""

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.formats.calls import FEWEST_STOPS, NO_JOURNEY, Call, RunningClock, by_name, journey_of
from tgvdp.formats.content import Outline
from tgvdp.formats.railml.line2 import POINTS, names_of
from tgvdp.formats.syntax.clocks import clock_s
from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.journey import Journey

#: Which times count, the first of them that a place has; those that were run ("actual") are no timetable.
_SCOPES = ("scheduled", "calculated", "published")
_DEFAULT_SCOPE = "scheduled"
_PASS = "pass"
#: The zone behind a time of day.
_ZONE = re.compile(r"(?:Z|[+-]\d{2}:\d{2})$")
#: Types of places, of which one is passed.
_TYPES = ("begin", "stop", _PASS, "end")
_MOST_NAMES = 12


class TimedTrain(NamedTuple):
    """A train with its parts in the order of running; its number and the like are other names of it."""

    id: str
    names: tuple[str, ...]
    parts: tuple[Node, ...]


class _Times(NamedTuple):
    """Times at a place, s, its element, that of the times, and whether the train stops there."""

    node: Node
    times: Node
    arrival_s: float | None
    departure_s: float | None
    stops: bool


def timed_trains(root: Node) -> list[TimedTrain]:
    """All trains of a timetable, and train parts that are of none; several of the same parts are one."""
    parts = {one.text("id") or f"line-{one.line}": one for one in root.below("timetable", "trainParts", "trainPart")}
    parts = {name: part for name, part in parts.items() if _places(part)}
    found: dict[tuple[str, ...], TimedTrain] = {}
    for train in root.below("timetable", "trains", "train"):
        sequence = sorted(train.children("trainPartSequence"), key=lambda one: one.number("sequence", "-") or 0.0)
        # Of parts side by side, as where trains run coupled, the first is the way of all.
        refs = [one.children("trainPartRef")[:1] for one in sequence]
        own = tuple(ref.text("ref") or "" for one in refs for ref in one)
        if own and all(name in parts for name in own):
            of_parts = tuple(parts[name] for name in own)
            known = found.get(own) or TimedTrain(train.text("id") or "-".join(own), (), of_parts)
            names = filter(None, map(train.text, ("id", "trainNumber", "name")))
            found[own] = known._replace(names=tuple(dict.fromkeys((*known.names, *names))))
    taken = {name for own in found for name in own}
    return [
        *found.values(),
        *(TimedTrain(name, (part.text("name") or name,), (part,)) for name, part in parts.items() if name not in taken),
    ]


def make_journey(root: Node, train: TimedTrain, places: Sequence[tuple[float, str]]) -> Journey:
    """Make the journey of a train over a line.

    Parameters
    ----------
    root : Node
    train : TimedTrain
    places : sequence of (float, str)
        Named places of the line, with their positions on it, m.

    Raises
    ------
    InputError
        When a time is none, times or positions decrease, the train stops between two places of the line at one that it
        does not have, or fewer than two of its stops are on the line.
    """
    scopes: dict[str, None] = {}
    stands = [times for part in train.parts for times in _times_of(part, scopes)]
    calls, left_out = _on_line(root, _joined(stands), places)
    notes = []
    if left_out:
        notes.append(f"not on the line, left out of train {train.id}: {', '.join(left_out[:_MOST_NAMES])}"
                     + (", …" if len(left_out) > _MOST_NAMES else ""))  # fmt: skip
    if others := [scope for scope in scopes if scope not in _SCOPES[:1]]:
        notes.append(f"train {train.id} has times of scope {', '.join(others)} as well, which count where it has no"
                     " scheduled ones, and actual ones never")  # fmt: skip
    dwells = sum(bool(place.below("stopDescription", "stopTimes")) for part in train.parts for place in _places(part))
    if dwells:
        notes.append(f"stopTimes of train {train.id} are not used at stops, where --dwell counts: {dwells}")
    stops, on_line = (sum(one.stops for one in some) for some in (stands, calls))
    if stops >= FEWEST_STOPS > on_line:
        raise train.parts[0].bad(f"{on_line} of {stops} stops are places of the line ({_held(places)})")
    try:
        return journey_of(train.id, calls, tuple(notes))
    except InputError as error:
        raise train.parts[0].bad(str(error)) from None


def outlined(root: Node) -> Iterator[Outline]:
    """Each train: its other names, from where to where it runs, and when.

    Raises
    ------
    InputError
        When a time is none, times decrease, or no train has the stops of a journey.
    """
    names = _names_by_id(root)
    trains = timed_trains(root)
    most = 0
    for train in trains:
        stands = _joined([times for part in train.parts for times in _times_of(part, {})])
        refs = [one.node.required_text("ocpRef") for one in stands]
        ends = " to ".join(names.get(ref, (ref,))[0] for ref in (refs[0], refs[-1]))
        clocks = [text for one in stands for text in map(one.times.text, ("arrival", "departure")) if text]
        when = f", {clocks[0]} to {clocks[-1]}" if clocks else ""
        called = ", ".join(name for name in train.names if name != train.id)
        stops = sum(one.stops for one in stands)
        most = max(most, stops)
        lacks = "" if stops >= FEWEST_STOPS else f"; {NO_JOURNEY}, got {stops}"
        text = f"{called}: {ends}, {len(stands)} places{when}{lacks}".removeprefix(": ")
        yield Outline(train.id, "train", text, train.names)
    if trains and most < FEWEST_STOPS:
        raise trains[0].parts[0].bad(f"{NO_JOURNEY}, and no train has them")


def _names_by_id(root: Node) -> dict[str, tuple[str, ...]]:
    """Names of operational points that have any, by identifier."""
    return {point.text("id") or "": names for point in root.below(*POINTS) if (names := names_of(point))}


def _held(places: Sequence[tuple[float, str]]) -> str:
    """What places a line has, the first ones of many."""
    return f"it has {', '.join(shown(name) for _, name in places[:_MOST_NAMES])}"


def _places(part: Node) -> list[Node]:
    return part.below("ocpsTT", "ocpTT")


def _times_of(part: Node, scopes: dict[str, None]) -> Iterator[_Times]:
    """Times of a train part at its places, as they stand there; adds to the scopes that were seen."""
    for place in _places(part):
        given: dict[str, Node] = {}
        for times in place.children("times"):
            scope = times.text("scope") or _DEFAULT_SCOPE
            if scope in given:
                raise times.bad(f"a second time of scope {shown(scope)} at one place: leave one")
            given[scope] = times
        scopes |= dict.fromkeys(given)
        own = next((given[scope] for scope in _SCOPES if scope in given), None)
        arrival_s, departure_s = (None, None) if own is None else (_time_s(own, "arrival"), _time_s(own, "departure"))
        kind = place.choice("ocpType", _TYPES)
        waits = bool(place.children("stopDescription")) or arrival_s != departure_s
        yield _Times(place, own or place, arrival_s, departure_s, kind != _PASS if kind else waits)


def _time_s(times: Node, attribute: str) -> float | None:
    """A time of day, s, in whatever zone; None where there is none."""
    text = times.text(attribute)
    if not text:
        return None
    try:
        return clock_s(_ZONE.sub("", text), with_hours=True)
    except InputError as error:
        raise times.bad(str(error), attribute) from None


def _joined(stands: Sequence[_Times]) -> list[_Times]:
    """Places with times that go on, where a part ends and the next one begins as one: it arrives and departs there."""
    clock = RunningClock()
    found: list[_Times] = []
    for one in stands:
        times: list[float | None] = []
        for attribute, time_s in (("arrival", one.arrival_s), ("departure", one.departure_s)):
            day = int(one.times.number(f"{attribute}Day", "days") or 0.0)
            on_s = None if time_s is None else clock.after(time_s, is_time_of_day=True, day=day)
            if time_s is not None and on_s is None:
                got = f"got {one.times.text(attribute)} after a later one"
                raise one.times.bad(f"times must not decrease, {got}", attribute)
            times.append(on_s)
        on = one._replace(arrival_s=times[0], departure_s=times[1])
        if found and found[-1].node.text("ocpRef") == on.node.text("ocpRef"):
            before = found.pop()
            arrival_s = before.arrival_s if before.arrival_s is not None else on.arrival_s
            departure_s = on.departure_s if on.departure_s is not None else before.departure_s
            on = on._replace(arrival_s=arrival_s, departure_s=departure_s, stops=before.stops or on.stops)
        found.append(on)
    return found


def _on_line(root: Node, stands: Sequence[_Times], places: Sequence[tuple[float, str]]) -> tuple[list[Call], list[str]]:
    """Calls at places of the line, and names of those that it does not have."""
    names, known = _names_by_id(root), by_name(places)
    placed = [(one, *_place(one, names, known)) for one in stands]
    on_line = [at for at, (_, _, position_m) in enumerate(placed) if position_m is not None]
    calls: list[Call] = []
    left_out: list[str] = []
    for at, (one, name, position_m) in enumerate(placed):
        if position_m is None:
            if one.stops and on_line and on_line[0] < at < on_line[-1]:
                message = f"the line has no place of that name, got {shown(name)} ({_held(places)})"
                raise one.node.bad(message, "ocpRef")
            left_out.append(name)
            continue
        if calls and position_m < calls[-1].position_m:
            message = f"{shown(name)} lies before the place above it: is the line to be reversed?"
            raise one.node.bad(message, "ocpRef")
        if one.stops or one.arrival_s is not None or one.departure_s is not None:
            departure_s = one.arrival_s if one.departure_s is None else one.departure_s
            calls.append(Call(position_m, one.stops, one.arrival_s, departure_s))
    return calls, left_out


def _place(one: _Times, names: dict[str, tuple[str, ...]], known: dict[str, list[float]]) -> tuple[str, float | None]:
    """Name of a place, and where on the line it lies, m; None where the line has none of its names."""
    ref = one.node.required_text("ocpRef")
    own = names.get(ref, (ref,))
    found = next((known[name.casefold()] for name in own if name.casefold() in known), [])
    if len(found) > 1:
        raise one.node.bad(f"the line has {len(found)} places of that name, got {shown(own[0])}", "ocpRef")
    return own[0], found[0] if found else None
