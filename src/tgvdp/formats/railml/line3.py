"""Tracks and lines of railML 3.1 and 3.2: stretches on net elements, seen from a path over those.

Where several speed sections cover a place, the least limit holds. Source: the published documentation of the schema.
"""

import math
from collections.abc import Iterator
from itertools import pairwise

from tgvdp.errors import InputError
from tgvdp.formats.railml.line2 import STOPPING_TYPES
from tgvdp.formats.railml.path import DIRECTIONS, NetPath, Stretch
from tgvdp.formats.railml.rows import LINE_SPEED_HINT, SLACK_M, Piece, Row, uncovered_note, unused_notes
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.track import Curve
from tgvdp.units import KILO

_FUNCTIONAL = ("infrastructure", "functionalInfrastructure")
_SECTIONS = (*_FUNCTIONAL, "speeds", "speedSection")
_GRADIENTS = ("infrastructure", "geometry", "gradientCurves", "gradientCurve")
_CURVES = ("infrastructure", "geometry", "horizontalCurves", "horizontalCurve")
_CURVE_TYPES = ("straight", "arc", "clothoid", "cubicParabola", "doucine", "mixed", "wienerBogen")


def tracks(root: Node) -> list[Node]:
    """All tracks and lines of a file that say which net elements they run over."""
    found = [*root.below(*_FUNCTIONAL, "tracks", "track"), *root.below(*_FUNCTIONAL, "lines", "line")]
    return [node for node in found if node.children("linearLocation")]


def directions(root: Node, track: Node) -> tuple[str, ...]:
    """Return the directions in which limits cover the whole way, else those with any, else normal.

    Normal alone, when both have the same limits. What is wrong with a track is said when it is read.
    """
    try:
        ways = {direction: _limits(NetPath(root, track, direction), root) for direction in DIRECTIONS}
    except InputError:
        return DIRECTIONS[:1]
    (forth, missing_m, length_m), (back, other_m, _) = ways.values()
    ends = [*(row.position_m for row in forth[1:]), length_m]
    turned = [(length_m - end, row.value) for row, end in zip(forth[::-1], ends[::-1], strict=True)]
    if _close(turned, [(row.position_m, row.value) for row in back]):
        return DIRECTIONS[:1]
    least_m = min(missing_m, other_m)
    enough_m = SLACK_M if least_m <= SLACK_M else length_m - SLACK_M
    return tuple(direction for direction, way in ways.items() if way[1] <= enough_m) or DIRECTIONS[:1]


def _close(one: list[tuple[float, float]], other: list[tuple[float, float]]) -> bool:
    return len(one) == len(other) and all(
        a[1] == b[1] and abs(a[0] - b[0]) <= SLACK_M for a, b in zip(one, other, strict=True)
    )


def read_piece(root: Node, track: Node, direction: str, line_speed_kmh: float | None = None) -> Piece:
    """Read a track or line as a run in one direction meets it.

    Parameters
    ----------
    root, track : Node
    direction : str
        One of `DIRECTIONS`.
    line_speed_kmh : float, optional
        Limit where no section and no ``linePerformance`` gives one.

    Raises
    ------
    InputError
        When an element is incomplete or off its net element, or two describe the same place; when a limit is missing.
    """
    path = NetPath(root, track, direction)
    limits, missing_m, _ = _limits(path, root)
    notes = [*_temporary_notes(path, root), *_inner_notes(path, root)]
    if missing_m > SLACK_M:
        own_kmh = _own_limit_kmh(track)
        default_kmh = line_speed_kmh if own_kmh is None else own_kmh
        if default_kmh is None:
            lack = f"speed sections leave {missing_m:.12g} m of {path.length_m:.12g} m without a limit"
            raise track.bad(f"{lack}: {LINE_SPEED_HINT}")
        limits = [row._replace(value=min(row.value, default_kmh)) if math.isinf(row.value) else row for row in limits]
        source = "the line speed asked for" if own_kmh is None else "linePerformance@maxSpeed"
        notes.append(f"no speed section on {missing_m:.12g} m: limit is {source}, {default_kmh:g} km/h")
    gradients, level_m = _gradients(path, root)
    curves, straight_m = _curves(path, root)
    notes += uncovered_note("gradientCurves", level_m, "level") if gradients and level_m > SLACK_M else []
    notes += uncovered_note("horizontalCurves", straight_m, "straight") if curves and straight_m > SLACK_M else []
    notes += _tunnel_notes(path, root)
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
        stops_m=list(_stops(path, root)),
        notes=notes + unused_notes([unused for part in read for unused in part.unused()]),
    )


def _name(node: Node) -> str:
    names = [one.text("name") for one in node.children("name")]
    return next((name for name in names if name), None) or node.text("id") or node.name


def _own_limit_kmh(line: Node) -> float | None:
    """Largest speed on a line as a whole, km/h."""
    speeds = [one.number("maxSpeed", "km/h", above=0.0) for one in line.children("linePerformance")]
    return next((speed for speed in speeds if speed is not None), None)


def _limits(path: NetPath, root: Node) -> tuple[list[Row], float, float]:
    """Least limit of all sections at each place, km/h, infinite without any; the length without any, and of all, m."""
    stretches = path.stretches(root.below(*_SECTIONS))
    speeds = {id(one.node): one.node.required_number("maxSpeed", "km/h", above=0.0) for one in stretches}
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


def _temporary_notes(path: NetPath, root: Node) -> list[str]:
    """Temporary limits hold on days that a run does not name."""
    sections = {id(one.node.element): one.node for one in path.stretches(root.below(*_SECTIONS))}
    count = sum(node.flag("isTemporary") is True for node in sections.values())
    return [f"temporary limits ({count}) count as any other"] if count else []


def _inner_notes(path: NetPath, root: Node) -> list[str]:
    """Limits and gradients that stand on the parts of a coarse net element cannot be put in order along it."""
    inner = path.inner
    counts = []
    for steps in (_SECTIONS, _GRADIENTS, _CURVES):
        count = sum(not inner.isdisjoint(path.refs(node)) for node in root.below(*steps))
        counts += [f"{steps[-1]} ({count})"] if count else []
    return [f"not used, as they lie on parts of the net elements: {', '.join(counts)}"] if counts else []


def _breaks(path: NetPath, stretches: list[Stretch]) -> list[float]:
    """Ends of the run and of all stretches, in order, at least a millimetre apart."""
    breaks_m = [0.0]
    for at_m in sorted(end_m for one in stretches for end_m in (one.from_m, one.to_m)):
        if at_m - breaks_m[-1] > SLACK_M and path.length_m - at_m > SLACK_M:
            breaks_m.append(at_m)
    return [*breaks_m, path.length_m]


def _apart(stretches: list[Stretch]) -> Iterator[tuple[Stretch, float]]:
    """Stretches with the gap before each; two that describe the same place are an error."""
    end_m = 0.0
    for one in stretches:
        if one.from_m < end_m - SLACK_M:
            raise one.node.bad(f"overlaps the {one.node.name} before it by {end_m - one.from_m:.6g} m of the run")
        yield one, one.from_m - end_m
        end_m = one.to_m


def _gradients(path: NetPath, root: Node) -> tuple[list[Row], float]:
    """Rows of gradient, ‰, and the length without any, which is taken as level."""
    rows: list[Row] = []
    gaps_m, end_m = 0.0, 0.0
    nodes = root.below(*_GRADIENTS)
    for one, gap_m in _apart(path.ground(nodes)):
        if gap_m > SLACK_M:
            rows.append(Row(end_m, 0.0, one.node.line))
            gaps_m += gap_m
        # On a vertical curve the gradient changes along it: its mean keeps the height.
        one.node.text("curveType")
        permil = one.node.required_number("gradient", "‰") + 0.5 * (one.node.number("deltaGradient", "‰") or 0.0)
        from_m = end_m if gap_m <= SLACK_M else one.from_m
        rows.append(Row(from_m, permil if one.forward else 0.0 - permil, one.node.line))
        end_m = one.to_m
    if rows and path.length_m - end_m > SLACK_M:
        rows.append(Row(end_m, 0.0, rows[-1].line))
        gaps_m += path.length_m - end_m
    return rows, gaps_m


def _curves(path: NetPath, root: Node) -> tuple[list[tuple[Curve, int]], float]:
    """Rows of curvature; a transition takes its ends from its neighbours. And the length without any: straight."""
    nodes = root.below(*_CURVES)
    arcs: list[tuple[float, float | None, int]] = []
    gaps_m, end_m = 0.0, 0.0
    for one, gap_m in _apart(path.ground(nodes)):
        if gap_m > SLACK_M:
            arcs.append((end_m, math.inf, one.node.line))
            gaps_m += gap_m
        arcs.append((end_m if gap_m <= SLACK_M else one.from_m, _radius_m(one), one.node.line))
        end_m = one.to_m
    if arcs and path.length_m - end_m > SLACK_M:
        arcs.append((end_m, math.inf, arcs[-1][2]))
        gaps_m += path.length_m - end_m
    radii = [math.inf, *(radius_m for _, radius_m, _ in arcs), math.inf]
    curves = []
    for index, (from_m, radius_m, line) in enumerate(arcs):
        if radius_m is None:
            ends_m = [math.inf if near is None else near for near in (radii[index], radii[index + 2])]
            curves.append((Curve(from_m, *ends_m), line))
        else:
            curves.append((Curve(from_m, radius_m, radius_m), line))
    return curves, gaps_m


def _radius_m(one: Stretch) -> float | None:
    """Signed radius of a curve as the run meets it; infinite when straight, None for a transition."""
    kind = one.node.choice("curveType", _CURVE_TYPES)
    radius_m = one.node.number("radius", "m")
    if kind == "straight":
        return math.inf
    if kind in (None, "arc"):
        if not radius_m:
            raise one.node.bad("missing attribute" if radius_m is None else "must not be 0 m", "radius")
        return radius_m if one.forward else -radius_m
    return None


def _stops(path: NetPath, root: Node) -> Iterator[float]:
    for point in root.below(*_FUNCTIONAL, "operationalPoints", "operationalPoint"):
        kinds = [kind.text("operationalType") for kind in point.below("opOperations", "opOperation")]
        named = [kind for kind in kinds if kind]
        if named and not set(named) & set(STOPPING_TYPES):
            continue
        for place in point.children("spotLocation"):
            at_m = path.spot(place)
            if at_m is not None:
                yield at_m


def _tunnel_notes(path: NetPath, root: Node) -> list[str]:
    """Tunnels have no cross section in railML 3, without which a train's drag in them is not known."""
    crossings = root.below(*_FUNCTIONAL, "overCrossings", "overCrossing")
    tunnels = path.ground([one for one in crossings if one.text("constructionType") == "tunnel"])
    if not tunnels:
        return []
    total_m = sum(one.to_m - one.from_m for one in tunnels)
    return [f"tunnels ({len(tunnels)}, {total_m / KILO:.4g} km) have no cross section in railML 3: not used"]
