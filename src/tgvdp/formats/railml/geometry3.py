"""Ground of railML 3.1 and 3.2 under a run: gradients, curves and tunnels, which are there in both directions.

Source: the published documentation of the schema.
"""

import math
from collections.abc import Iterator

from tgvdp.formats.railml.path import NetPath, Stretch
from tgvdp.formats.railml.rows import SLACK_M, Row
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.track import Curve
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
    nodes = root.below(*GRADIENTS)
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


def tunnel_notes(path: NetPath, root: Node) -> list[str]:
    """Tunnels have no cross section in railML 3, without which a train's drag in them is not known."""
    crossings = root.below(*_CROSSINGS)
    tunnels = path.ground([one for one in crossings if one.text("constructionType") == "tunnel"])
    if not tunnels:
        return []
    total_m = sum(one.to_m - one.from_m for one in tunnels)
    return [f"tunnels ({len(tunnels)}, {total_m / KILO:.4g} km) have no cross section in railML 3: not used"]
