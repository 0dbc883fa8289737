"""Tracks of railML 2.0 to 2.5: changes along a track, each with a direction.

A speed change holds from its position on in its direction, for the trains of its profile and category. Gradients and
radii describe the ground: their signs belong to the direction of the track, whichever way a train runs. Source: the
published documentation of the schema.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterable
from typing import NamedTuple

from tgvdp.formats.railml.rows import (
    NO_LIMIT_KMH,
    SLACK_M,
    Piece,
    Row,
    before,
    filled,
    one_at_each_place,
    other_profiles_note,
    turned,
    uncovered_note,
    unused_notes,
)
from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.checks import plain_text
from tgvdp.model.track import Curve, Place, Tunnel

DIRECTIONS = ("up", "down")
_LAX_DIRECTIONS = (*DIRECTIONS, "both", "none", "unknown")
#: Operational points of a file.
POINTS = ("infrastructure", "operationControlPoints", "ocp")
#: What was written for "end" before 2.3; no train reaches it.
_VIRTUAL_KMH = 999.9
_TRAIN_RELATIONS = ("headOfTrain", "midOfTrain", "endOfTrain")
#: Operational types of places where passengers' or freight trains stop on schedule.
STOPPING_TYPES = ("station", "stoppingPoint")


class _Way(NamedTuple):
    """A track as a train runs over it."""

    begin_m: float
    length_m: float
    forward: bool

    def along_m(self, node: Node, forward: bool) -> float:
        """Distance of an element from where a run in a direction starts, m."""
        along_m = node.required_number("pos", "m") - self.begin_m
        if not -SLACK_M <= along_m <= self.length_m + SLACK_M:
            end_m = self.begin_m + self.length_m
            got = shown(node.text("pos"))
            raise node.bad(f"must lie on the track, {self.begin_m:.12g} to {end_m:.12g} m, got {got}", "pos")
        along_m = min(max(along_m, 0.0), self.length_m)
        return along_m if forward else self.length_m - along_m


def tracks(root: Node) -> list[Node]:
    """All tracks of a file."""
    return root.below("infrastructure", "tracks", "track")


def directions(root: Node, track: Node) -> tuple[str, ...]:
    """Return the directions that a track of a file has speed limits for; up, when it has none."""
    given = {change.choice("dir", _LAX_DIRECTIONS) or "none" for change in _speed_changes(track)}
    found = tuple(name for name in DIRECTIONS if name in given or (name == "up" and given - {*DIRECTIONS}))
    return found or DIRECTIONS[:1]


def profiles(root: Node, track: Node) -> tuple[str, ...]:
    """Return the speed profiles (or train categories) that limits of a track are given for; "" are those for all."""
    named = _named_profiles(root)
    return tuple(sorted({_profile(change, named) for change in _speed_changes(track)})) or ("",)


def read_piece(root: Node, track: Node, direction: str, profile: str) -> Piece:
    """Read a track as a run in one direction meets it.

    Raises
    ------
    InputError
        When an element is incomplete or off the track, or its direction says too little.
    """
    topology = track.required("trackTopology")
    begin, end = topology.required("trackBegin"), topology.required("trackEnd")
    begin_m, end_m = begin.required_number("pos", "m"), end.required_number("pos", "m")
    if not end_m > begin_m:
        raise end.bad(f"must lie after trackBegin at {begin_m:.12g} m, got {end_m:.12g} m", "pos")
    way = _Way(begin_m, end_m - begin_m, direction == "up")
    limits, notes = _limits(root, track, way, profile)
    gradients, level_m = _ground(track.below("trackElements", "gradientChanges", "gradientChange"), way, _slope, 0.0)
    radii, straight_m = _ground(track.below("trackElements", "radiusChanges", "radiusChange"), way, _radius, math.inf)
    if level_m:
        notes += uncovered_note("gradients", level_m, "level")
    if straight_m:
        notes += uncovered_note("radii", straight_m, "straight")
    tunnels, tunnel_notes = _tunnels(track, way)
    stops, others = _places(root, topology, way)
    for attribute in ("type", "mainDir"):
        track.text(attribute)
    joints = _joint(topology, begin), _joint(topology, end)
    for node in (begin, end, *topology.children("connections")):
        node.dismiss()  # what lies beyond the track
    return Piece(
        name=track.text("name") or track.text("id") or "track",
        length_m=way.length_m,
        line=end.line,
        limits_kmh=limits,
        gradients_permil=gradients,
        curves=[(Curve(row.position_m, row.value, row.value), row.line) for row in radii],
        tunnels=tunnels,
        stops=stops,
        others=others,
        joints=joints if way.forward else joints[::-1],
        notes=[*notes, *tunnel_notes, *unused_notes(track.unused())],
    )


def _joint(topology: Node, end: Node) -> frozenset[str]:
    """Ids of connections at an end of a track, its own and those of switches there, and of the place that it is at."""
    end_m = end.required_number("pos", "m")
    switches = topology.below("connections", "switch")
    here = [one for one in switches if abs((one.number("pos", "m") or 0.0) - end_m) <= SLACK_M]
    named = [one.text(name) for node in (end, *here) for one in node.children("connection") for name in ("id", "ref")]
    named += [one.text("ocpRef") for one in end.children("macroscopicNode")]
    return frozenset(name for name in named if name)


def _speed_changes(track: Node) -> list[Node]:
    return track.below("trackElements", "speedChanges", "speedChange")


def _named_profiles(root: Node) -> set[str] | None:
    """Ids of the speed profiles of a file; None where it has none and its references can only be taken as they are."""
    profiles = root.below("infrastructure", "speedProfiles", "speedProfile")
    others = root.below("infrastructure", "infraAttrGroups", "infraAttributes")
    return {one.text("id") or "" for one in profiles} if profiles or others else None


def _profile(change: Node, named: set[str] | None) -> str:
    """Trains that a change is for: its profile and category, joined where it names several; empty means all.

    A reference to something else, such as attributes of the infrastructure, is no profile.
    """
    ref = change.text("profileRef") or ""
    of = [ref if named is None or ref in named else "", change.text("etcsTrainCategory"), change.text("trainCategory")]
    return "/".join(name for name in of if name)


def _limits(root: Node, track: Node, way: _Way, profile: str) -> tuple[list[Row], list[str]]:
    """Limits of one direction and profile, km/h, and what must be said about them."""
    named_profiles = _named_profiles(root)
    rows: list[tuple[Row, Node]] = []
    relations: set[str] = set()
    others: Counter[str] = Counter()
    for change in _speed_changes(track):
        direction, its_profile = change.choice("dir", _LAX_DIRECTIONS), _profile(change, named_profiles)
        strict = direction in DIRECTIONS
        against = strict and (direction == "up") != way.forward
        if its_profile != profile or against:
            others[its_profile or "all trains"] += its_profile != profile and not against
            change.dismiss()
            continue
        if not strict and not way.forward:
            raise change.bad(f"must be up or down for a run against the track, got {shown(direction)}", "dir")
        relations.add(change.choice("trainRelation", _TRAIN_RELATIONS) or "")
        rows.append((Row(way.along_m(change, way.forward), _top_speed_kmh(change), change.line), change))
    # A limit that ends where the next one begins is replaced by it.
    begun_m = {row.position_m for row, _ in rows if row.value < NO_LIMIT_KMH}
    rows = [both for both in rows if both[0].value < NO_LIMIT_KMH or both[0].position_m not in begun_m]
    notes = other_profiles_note("speedChanges", +others)
    if relations - {""}:
        named = ", ".join(sorted(relation or "no trainRelation" for relation in relations))
        notes.append(f"limits count for {named}: choose limits for head or tail of the train accordingly")
    return one_at_each_place(rows), notes


def _top_speed_kmh(change: Node) -> float:
    if change.required_text("vMax") == "end":
        return NO_LIMIT_KMH
    speed_kmh = change.required_number("vMax", "km/h (or end)", above=0.0)
    return speed_kmh if speed_kmh < _VIRTUAL_KMH else NO_LIMIT_KMH


def _ground(nodes: list[Node], way: _Way, value: Callable[[Node], float], default: float) -> tuple[list[Row], float]:
    """Rows of what describes the ground, in the direction of the run, and how many metres had to be made up.

    Changes with ``dir="down"`` hold against the track from their position on, others along it. A run takes those of its
    own direction where there are any, and else turns the others round.
    """
    down = [node for node in nodes if node.choice("dir", _LAX_DIRECTIONS) == "down"]
    up = [node for node in nodes if node.text("dir") != "down"]
    forward = bool(up) and (way.forward or not down)
    chosen, others = (up, down) if forward else (down, up)
    for node in others:
        node.dismiss()
    found = ((Row(way.along_m(node, forward), _signed(value(node), way.forward), node.line), node) for node in chosen)
    rows = before(one_at_each_place(found), way.length_m)
    if not rows:
        return [], 0.0
    missing_m = rows[0].position_m
    rows = filled(rows, default)
    return (rows if forward == way.forward else turned(rows, way.length_m)), missing_m


def _signed(value: float, forward: bool) -> float:
    """Turn a value that is signed by the track's direction into one for the run; straight and level have no sign."""
    return value if forward or value == 0.0 or math.isinf(value) else -value


def _slope(change: Node) -> float:
    return change.required_number("slope", "‰")


def _radius(change: Node) -> float:
    """Radius, signed; 0 stands for a straight track."""
    return change.required_number("radius", "m") or math.inf


def _tunnels(track: Node, way: _Way) -> tuple[list[tuple[Tunnel, int]], list[str]]:
    made, notes = [], []
    for tunnel in track.below("trackElements", "tunnels", "tunnel"):
        start_m = way.along_m(tunnel, True)
        length_m = tunnel.required_number("length", "m", at_least=0.0)
        area_m2 = tunnel.number("crossSection", "m²", above=0.0)
        if area_m2 is None:
            notes.append(f"a tunnel of {length_m:.6g} m in line {tunnel.line} has no crossSection: not used")
            continue
        if start_m + length_m > way.length_m + SLACK_M:
            raise tunnel.bad(f"must end on the track, ends at {way.begin_m + start_m + length_m:.12g} m", "length")
        length_m = min(length_m, way.length_m - start_m)
        first_m = start_m if way.forward else way.length_m - start_m - length_m
        made.append((Tunnel(first_m, length_m, area_m2), tunnel.line))
    return sorted(made), notes


def _places(root: Node, topology: Node, way: _Way) -> tuple[list[Place], list[Place]]:
    """The operational points of a track where trains stop, and others, by the names or codes that they have."""
    passing = set(_passed(root))
    names = {point.text("id"): (*names_of(point), "")[0] for point in root.below(*POINTS)}
    stops: list[Place] = []
    others: list[Place] = []
    for place in topology.below("crossSections", "crossSection"):
        ref = place.text("ocpRef")
        if ref:
            at = Place(way.along_m(place, way.forward), names.get(ref, ""))
            (others if ref in passing else stops).append(at)
        place.dismiss()
    for at_m, end in ((0.0, "trackBegin"), (way.length_m, "trackEnd")):
        refs = [one.text("ocpRef") for one in topology.below(end, "macroscopicNode")]
        others += [Place(at_m if way.forward else way.length_m - at_m, names.get(ref, "")) for ref in refs if ref]
    return stops, others


def names_of(point: Node) -> tuple[str, ...]:
    """Name, code and entries in registers of an operational point, as far as it has them."""
    entries = [one.text("entry") for one in point.children("designator")]
    found = [plain_text(text) for text in (point.text("name"), point.text("code"), *entries) if text]
    return tuple(name for name in found if name)


def _passed(root: Node) -> Iterable[str]:
    """Ids of operational points that are said to be of a kind where no train stops."""
    for point in root.below(*POINTS):
        kinds = [kind.text("operationalType") for kind in point.children("propOperational")]
        if any(kind and kind not in STOPPING_TYPES for kind in kinds):
            yield point.text("id") or ""
