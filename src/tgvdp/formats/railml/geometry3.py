"""Ground of railML 3.1 to 3.3 under a run: gradients, curves and tunnels, which are there in both directions.

Source: the published documentation of the schema.
"""

import math
from collections.abc import Iterator

from tgvdp.formats.railml.path import NetPath, Stretch
from tgvdp.formats.railml.rows import SLACK_M, Row
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.track import Curve, Tunnel
from tgvdp.units import KILO

GRADIENTS = ("infrastructure", "geometry", "gradientCurves", "gradientCurve")
CURVES = ("infrastructure", "geometry", "horizontalCurves", "horizontalCurve")
_CROSSINGS = ("infrastructure", "functionalInfrastructure", "overCrossings", "overCrossing")
_TRANSITIONS = ("clothoide", "cosinusoide", "cubicParabola", "curveBloss", "curveWiener", "doucine", "sinusoide")
#: The last ones are not of the schema, but written.
_CURVE_TYPES = ("straight", "arc", *_TRANSITIONS, "clothoid", "mixed", "wienerBogen")


def _apart(stretches: list[Stretch]) -> Iterator[tuple[Stretch, float]]:
    """Stretches with the gap before each; two that describe the same place are an error."""
    end_m = 0.0
    for one in stretches:
        if one.from_m < end_m - SLACK_M:
            raise one.node.bad(f"overlaps the {one.node.name} before it by {end_m - one.from_m:.6g} m of the run")
        yield one, one.from_m - end_m
        end_m = one.to_m


def gradients_of(path: NetPath, root: Node) -> tuple[list[Row], float]:
    """Rows of gradient, ‰, and the length without any, which is taken as level."""
    rows: list[Row] = []
    gaps_m, end_m = 0.0, 0.0
    for one, gap_m, permil in _sloped(list(_apart(path.ground(root.below(*GRADIENTS))))):
        if gap_m > SLACK_M:
            rows.append(Row(end_m, 0.0, one.node.line))
            gaps_m += gap_m
        rows.append(Row(end_m if gap_m <= SLACK_M else one.from_m, permil, one.node.line))
        end_m = one.to_m
    if rows and path.length_m - end_m > SLACK_M:
        rows.append(Row(end_m, 0.0, rows[-1].line))
        gaps_m += path.length_m - end_m
    return rows, gaps_m


def _sloped(stretches: list[tuple[Stretch, float]]) -> Iterator[tuple[Stretch, float, float]]:
    """Stretches with their mean gradients: on a vertical curve it changes evenly, so that the mean keeps the height."""
    ends = [_ends_permil(one) for one, _ in stretches]
    for index, (one, gap_m) in enumerate(stretches):
        first_last = ends[index]
        if first_last is None:
            before = ends[index - 1] if index and gap_m <= SLACK_M else None
            following = index + 1 < len(stretches) and stretches[index + 1][1] <= SLACK_M
            after = ends[index + 1] if following else None
            first_last = ends[index] = _between(one, before and before[1], after and after[0])
        yield one, gap_m, 0.5 * (first_last[0] + first_last[1])


def _ends_permil(one: Stretch) -> tuple[float, float] | None:
    """Gradients at the start and at the end of a stretch as the run meets it; None where the file leaves it open."""
    one.node.text("curveType")
    permil = one.node.number("gradient", "‰")
    if permil is None:
        return None
    last = permil + (one.node.number("deltaGradient", "‰") or 0.0)
    return (permil, last) if one.forward else (0.0 - last, 0.0 - permil)


def _between(one: Stretch, first: float | None, last: float | None) -> tuple[float, float]:
    """Gradients at the ends of a vertical curve without one of its own, from those that it links."""
    if first is not None and last is not None:
        return first, last
    delta = one.node.number("deltaGradient", "‰")
    radius_m = one.node.number("radius", "m")
    if delta is None and radius_m:  # of a hill positive
        delta = -KILO * (one.to_m - one.from_m) / radius_m
    if delta is None or (first is None and last is None):
        raise one.node.bad(
            "missing attribute (‰), and it does not follow from the gradientCurves next to it", "gradient"
        )
    return (first, first + delta) if first is not None else ((last or 0.0) - delta, last or 0.0)


def curves_of(path: NetPath, root: Node) -> tuple[list[tuple[Curve, int]], float]:
    """Rows of curvature; a transition takes its ends from its neighbours. And the length without any: straight."""
    nodes = root.below(*CURVES)
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
    if kind not in (None, "arc", "straight"):
        return None  # a radius of its own, were there one, would be told as not used
    radius_m = one.node.number("radius", "m")
    if kind == "straight" or (kind is None and radius_m == 0.0):
        return math.inf
    if not radius_m:
        raise one.node.bad("missing attribute" if radius_m is None else "must not be 0 m", "radius")
    return radius_m if one.forward else -radius_m


def tunnels_of(path: NetPath, root: Node) -> tuple[list[tuple[Tunnel, int]], list[str]]:
    """Tunnels on the run, and a note on those without a cross section, with which a train's drag is not known.

    They have one in 3.3 at the earliest.
    """
    crossings = root.below(*_CROSSINGS)
    made: list[tuple[Tunnel, int]] = []
    bare_m: list[float] = []
    for one in path.ground([one for one in crossings if one.text("constructionType") == "tunnel"]):
        length_m = one.to_m - one.from_m
        areas_m2 = [box.number("crossSection", "m²", above=0.0) for box in one.node.children("tunnelResistance")]
        area_m2 = next((area_m2 for area_m2 in areas_m2 if area_m2 is not None), None)
        if area_m2 is None:
            bare_m.append(length_m)
        else:
            made.append((Tunnel(one.from_m, length_m, area_m2), one.node.line))
    note = f"tunnels ({len(bare_m)}, {sum(bare_m) / KILO:.4g} km) have no cross section: not used"
    return made, [note] if bare_m else []
