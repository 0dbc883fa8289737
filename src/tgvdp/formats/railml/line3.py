"""Tracks and lines of railML 3.1 to 3.3: stretches on net elements, seen from a path over those.

Where several speed sections cover a place that apply to a train, the least limit holds. Source: the published
documentation of the schema.
"""

import math
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise

from tgvdp.errors import InputError
from tgvdp.formats.railml.geometry3 import CURVES, GRADIENTS, curves_of, gradients_of, tunnels_of
from tgvdp.formats.railml.line2 import STOPPING_TYPES
from tgvdp.formats.railml.net import PLACE
from tgvdp.formats.railml.path import DIRECTIONS, NetPath, Stretch
from tgvdp.formats.railml.rows import (
    LINE_SPEED_HINT,
    SLACK_M,
    Piece,
    Row,
    other_profiles_note,
    uncovered_note,
    unused_notes,
)
from tgvdp.formats.railml.supply3 import ELECTRIFIED, is_neutral, neutral_sections
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.checks import plain_text
from tgvdp.model.track import Place

_FUNCTIONAL = ("infrastructure", "functionalInfrastructure")
_SECTIONS = (*_FUNCTIONAL, "speeds", "speedSection")
_POINTS = (*_FUNCTIONAL, "operationalPoints", "operationalPoint")
#: Of the electrification only neutral sections are of use to a run.
_UNREAD = (ELECTRIFIED, (*_FUNCTIONAL, "restrictionAreas", "restrictionArea"))


def tracks(root: Node) -> list[Node]:
    """All tracks and lines of a file that say which net elements they run over."""
    found = [*root.below(*_FUNCTIONAL, "tracks", "track"), *root.below(*_FUNCTIONAL, "lines", "line")]
    return [node for node in found if node.children("linearLocation")]


def profiles(root: Node, track: Node) -> tuple[str, ...]:
    """Return the speed profiles that sections on a track are valid for; "" are those for all trains.

    Where these leave a part of the way without a limit, and there is one profile alone, it is that of all.
    """
    try:
        paths = [NetPath(root, track, direction) for direction in DIRECTIONS]
        here = [node for node in root.below(*_SECTIONS) if paths[0].passes(node)]
        names = {name for node in here for name in _valid_for(node) or {""}}
        if len(names) == 2 and "" in names and any(_limits(path, root, "")[1] > SLACK_M for path in paths):
            names.remove("")
    except InputError:
        return ("",)
    return tuple(sorted(names)) or ("",)


def directions(root: Node, track: Node) -> tuple[str, ...]:
    """Return the directions in which limits of some profile cover the whole way, else those with any, else normal.

    Normal alone, when both have the same limits. What is wrong with a track is said when it is read.
    """
    try:
        paths = [NetPath(root, track, direction) for direction in DIRECTIONS]
        names = profiles(root, track)
        found = {one for name in names for one in _covered([_limits(path, root, name) for path in paths])}
    except InputError:
        found = set()
    return tuple(direction for direction in DIRECTIONS if direction in found) or DIRECTIONS[:1]


def _covered(ways: list[tuple[list[Row], float, float]]) -> Iterator[str]:
    """Directions that limits cover as well as they cover any, and normal alone where both are the same."""
    (forth, missing_m, length_m), (back, other_m, _) = ways
    ends = [*(row.position_m for row in forth[1:]), length_m]
    turned = [(length_m - end, row.value) for row, end in zip(forth[::-1], ends[::-1], strict=True)]
    if _close(turned, [(row.position_m, row.value) for row in back]):
        yield DIRECTIONS[0]
        return
    enough_m = SLACK_M if min(missing_m, other_m) <= SLACK_M else length_m - SLACK_M
    for direction, uncovered_m in zip(DIRECTIONS, (missing_m, other_m), strict=True):
        if uncovered_m <= enough_m:
            yield direction


def _close(one: list[tuple[float, float]], other: list[tuple[float, float]]) -> bool:
    return len(one) == len(other) and all(
        a[1] == b[1] and abs(a[0] - b[0]) <= SLACK_M for a, b in zip(one, other, strict=True)
    )


def read_piece(root: Node, track: Node, direction: str, profile: str, line_speed_kmh: float | None = None) -> Piece:
    """Read a track or line as a run in one direction meets it.

    Parameters
    ----------
    root, track : Node
    direction : str
        One of `DIRECTIONS`.
    profile : str
        One of `profiles`: limits for its trains, and those for all.
    line_speed_kmh : float, optional
        Limit where no section and no ``linePerformance`` gives one.

    Raises
    ------
    InputError
        When an element is incomplete or off its net element, or two describe the same place; when a limit is missing.
    """
    path = NetPath(root, track, direction)
    limits, missing_m, _ = _limits(path, root, profile)
    notes = [*_section_notes(path, root, profile), *_unplaced_notes(path, root)]
    if missing_m > SLACK_M:
        own_kmh = _own_limit_kmh(track)
        default_kmh = line_speed_kmh if own_kmh is None else own_kmh
        if default_kmh is None:
            lack = f"speed sections leave {missing_m:.12g} m of {path.length_m:.12g} m without a limit"
            named = [name for name in profiles(root, track) if name not in ("", profile)]
            hint = f", or choose a speed profile: {', '.join(named)}" if named else ""
            raise track.bad(f"{lack}: {LINE_SPEED_HINT}{hint}")
        limits = [row._replace(value=min(row.value, default_kmh)) if math.isinf(row.value) else row for row in limits]
        source = "the line speed asked for" if own_kmh is None else "linePerformance@maxSpeed"
        notes.append(f"no speed section on {missing_m:.12g} m: limit is {source}, {default_kmh:g} km/h")
    gradients, level_m = gradients_of(path, root)
    curves, straight_m = curves_of(path, root)
    notes += uncovered_note("gradientCurves", level_m, "level") if gradients and level_m > SLACK_M else []
    notes += uncovered_note("horizontalCurves", straight_m, "straight") if curves and straight_m > SLACK_M else []
    tunnels, tunnel_notes = tunnels_of(path, root)
    notes += tunnel_notes
    stops, others = _places(path, root)
    name = _name(track)
    track.text("type")
    read = [track, *root.below("infrastructure", "geometry"), *root.below(*_FUNCTIONAL, "speeds")]
    return Piece(
        name=name,
        length_m=path.length_m,
        line=track.line,
        limits_kmh=limits,
        gradients_permil=gradients,
        curves=curves,
        tunnels=tunnels,
        neutral_sections=neutral_sections(path, root),
        stops=stops,
        others=others,
        notes=notes + unused_notes([unused for part in read for unused in part.unused()]),
    )


def _name(node: Node) -> str:
    return _own_name(node) or node.text("id") or node.name


def _own_name(node: Node) -> str:
    names = [one.text("name") for one in node.children("name")]
    return next((name for name in names if name), "")


def _own_limit_kmh(line: Node) -> float | None:
    """Largest speed on a line as a whole, km/h."""
    speeds = [one.number("maxSpeed", "km/h", above=0.0) for one in line.children("linePerformance")]
    return next((speed for speed in speeds if speed is not None), None)


def _valid_for(section: Node) -> set[str]:
    """Speed profiles that a section is valid for, none where it is for all trains."""
    return {one.text("ref") or "" for one in section.children("validForSpeedProfile")} - {""}


def _sections(root: Node, profile: str) -> list[Node]:
    """Sections that are valid for the trains of a profile: those that name it, and those that name none."""
    known = [(node, _valid_for(node)) for node in root.below(*_SECTIONS)]
    return [node for node, valid_for in known if not valid_for or profile in valid_for]


def _limits(path: NetPath, root: Node, profile: str) -> tuple[list[Row], float, float]:
    """Least limit of all sections at each place, km/h, infinite without any; the length without any, and of all, m."""
    stretches = path.stretches(_sections(root, profile))
    speeds = {id(one.node): _speed_kmh(one.node) for one in stretches}
    rows: list[Row] = []
    missing_m = 0.0
    active: list[Stretch] = []
    waiting = stretches[::-1]
    for from_m, to_m in pairwise(_breaks(path, stretches)):
        middle_m = 0.5 * (from_m + to_m)
        while waiting and waiting[-1].from_m <= middle_m:
            active.append(waiting.pop())
        active = [one for one in active if one.to_m > middle_m]
        least = min(active, key=lambda one: speeds[id(one.node)], default=None)
        speed_kmh, line = (math.inf, 0) if least is None else (speeds[id(least.node)], least.node.line)
        if least is None:
            missing_m += to_m - from_m
        if not rows or rows[-1].value != speed_kmh:
            rows.append(Row(from_m, speed_kmh, line))
    return rows, missing_m, path.length_m


def _speed_kmh(section: Node) -> float:
    """Limit of a section, km/h; drafts of 3.1, such as railML.org's first example, call it as 2.x does."""
    early_kmh = section.number("vMax", "km/h", above=0.0)
    return early_kmh if early_kmh is not None else section.required_number("maxSpeed", "km/h", above=0.0)


def _section_notes(path: NetPath, root: Node, profile: str) -> list[str]:
    """Temporary limits hold on days that a run does not name, those of other profiles for other trains."""
    mine = _sections(root, profile)
    known = {node.element for node in mine}
    others: Counter[str] = Counter()
    for node in root.below(*_SECTIONS):
        if node.element not in known and path.passes(node):
            others.update(_valid_for(node))
            node.dismiss()
    sections = {id(one.node.element): one.node for one in path.stretches(mine)}
    count = sum(node.flag("isTemporary") is True for node in sections.values())
    notes = [f"temporary limits ({count}) count as any other"] if count else []
    if profile:
        of_profile = sum(profile in _valid_for(node) for node in mine if path.passes(node))
        notes.append(f"speedSections for the trains of {profile} ({of_profile}) count, beside those for all")
    delays = {one.text("endPointValidity") or "" for one in sections.values()}
    if delays - {""}:
        named = ", ".join(sorted(delay or "no endPointValidity" for delay in delays))
        notes.append(f"limits end with {named}: choose limits for head or tail of the train accordingly")
    unclear = sum(path.passes(node) and _is_unclear(node) for node in mine)
    if unclear:
        kept = "taken along their location, which does not keep the orientation of its net element"
        notes.append(f"applicationDirection of speedSections ({unclear}) is {kept}")
    return notes + other_profiles_note("speedSections", others)


def _is_unclear(section: Node) -> bool:
    """Whether it matters for a section if a direction is that of the location or of the net element: both are read."""
    return any(
        location.text("applicationDirection") in DIRECTIONS
        and any(place.flag("keepsOrientation") is False for place in location.children(PLACE))
        for location in section.children("linearLocation")
    )


def _unplaced_notes(path: NetPath, root: Node) -> list[str]:
    """What lies on the run, or may do, and cannot be put in order along it, or is of no use to a run."""
    related = path.related
    notes = []
    on_related, elsewhere = Counter[str](), Counter[str]()
    for steps in (_SECTIONS, GRADIENTS, CURVES):
        for node in root.below(*steps):
            if path.passes(node):
                continue
            on_related[steps[-1]] += not related.isdisjoint(path.refs(node))
            elsewhere[steps[-1]] += path.passes(node, "areaLocation", "spotLocation")
    for point in filter(_is_stopping, root.below(*_POINTS)):
        elsewhere[_POINTS[-1]] += not point.children("spotLocation") and path.passes(
            point, "areaLocation", "linearLocation"
        )
    unread = Counter(
        node.name for steps in _UNREAD for node in root.below(*steps) if path.passes(node) and not is_neutral(node)
    )
    for counts, why in (
        (on_related, "not used, as they lie on parts of the net elements, or on what these are parts of"),
        (elsewhere, "not used, as they have no location of a kind that places them"),
        (unread, "not used, so that traction current is taken to be everywhere"),
    ):
        named = [f"{name} ({count})" for name, count in (+counts).items()]
        notes += [f"{why}: {', '.join(named)}"] if named else []
    return notes


def _breaks(path: NetPath, stretches: list[Stretch]) -> list[float]:
    """Ends of the run and of all stretches, in order, at least a millimetre apart."""
    breaks_m = [0.0]
    for at_m in sorted(end_m for one in stretches for end_m in (one.from_m, one.to_m)):
        if at_m - breaks_m[-1] > SLACK_M and path.length_m - at_m > SLACK_M:
            breaks_m.append(at_m)
    return [*breaks_m, path.length_m]


def _is_stopping(point: Node) -> bool:
    """Whether trains stop at an operational point, as far as that is said."""
    kinds = [kind.text("operationalType") for kind in point.below("opOperations", "opOperation")]
    named = [kind for kind in kinds if kind]
    return not named or bool(set(named) & set(STOPPING_TYPES))


def _places(path: NetPath, root: Node) -> tuple[list[Place], list[Place]]:
    """Operational points on the run where trains stop, and others."""
    stops: list[Place] = []
    others: list[Place] = []
    for point in root.below(*_POINTS):
        found = [path.spot(place) for place in point.children("spotLocation")]
        made = [Place(at_m, plain_text(_own_name(point))) for at_m in found if at_m is not None]
        (stops if _is_stopping(point) else others).extend(made)
    return stops, others
