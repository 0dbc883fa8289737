"""Effort and resistance over speed of railML rolling stock, from tables, caps or Davis' formula."""

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from tgvdp.formats.railml.table import SPECIFIC, TABLES, Table, read_table, stations
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.effort import EffortCurve
from tgvdp.units import per_kmh_to_per_mps

#: A table that Davis' formula meets to better than this needs no remark.
_GOOD_FIT = 1e-3
#: Speeds at which caps of effort and power meet count as the same when they differ by rounding.
_SAME = 1e-9
#: The constant of Davis' formula: no train has more than this in N/kN, or less than that in N.
_MOST_SPECIFIC = 30.0
_LEAST_ABSOLUTE = 90.0
#: By effort: attributes of the largest one (N) and of the power that limits it (W), in 2.x and in ``info`` of 3.x.
_CAPS = {
    "tractiveEffort": (("maxTractEffort", "power"), ("maxTractiveEffort", "tractivePower")),
    "brakeEffort": (("maxBrakeEffort", "maxBrakePower"),),
}
#: Elements that hold Davis' formula, until 3.2 and since 3.3.
_FORMULAS = ("daviesFormula", "daviesFormulaFactors")


class Effort(NamedTuple):
    """Effort of some vehicles: points (m/s, N), and the power that limits it in W, 0 for none."""

    points: list[tuple[float, float]]
    power_w: float
    line: int
    notes: tuple[str, ...] = ()

    def times(self, count: int) -> "Effort":
        """Return the effort of several such vehicles."""
        return self._replace(points=[(v, count * f) for v, f in self.points], power_w=count * self.power_w)


class Resistance(NamedTuple):
    """Davis' formula in SI, where it comes from, and what must be said about it."""

    a_n: float
    b_n_per_mps: float
    c_n_per_mps2: float
    line: int
    notes: tuple[str, ...] = ()

    def times(self, count: int) -> "Resistance":
        """Return the resistance of several such vehicles."""
        return self._replace(
            a_n=count * self.a_n, b_n_per_mps=count * self.b_n_per_mps, c_n_per_mps2=count * self.c_n_per_mps2
        )


def effort_of(node: Node, element: str, top_mps: float, *, outside: Sequence[Node] = ()) -> Effort | None:
    """Read the effort table below a vehicle or its propulsion, or else a largest effort and a power.

    Parameters
    ----------
    node : Node
    element : str
        Name of the element that holds the table.
    top_mps : float
        Speed up to which the last polynomial of a table counts.
    outside : sequence of Node, optional
        Elements below which nothing is looked for.
    """
    holders = _below_anywhere(node, (element,), outside)
    tables = [table for one in holders for table in one.children("valueTable") or one.children("segmentTable")]
    if len(tables) > 1:
        raise tables[1].bad(f"a second {element} table; one is expected")
    if tables:
        points, _, line, notes = read_table(tables[0], "N", top_mps)
        if points[0][0] > 0.0:  # tables often start at a few km/h
            points.insert(0, (0.0, points[0][1]))
        return Effort(points, 0.0, line, notes)
    return _caps(node, element)


def has_caps(node: Node, element: str) -> bool:
    """Whether a vehicle or its propulsion gives a largest effort."""
    return any(one.has(force) for one in _capped(node) for force, _ in _CAPS[element])


def _caps(node: Node, element: str) -> Effort | None:
    """Read a largest effort and the power that limits it; a brake without the latter is told as not used."""
    for one in _capped(node):
        for force, power in _CAPS[element]:
            if one.has(force) and (one.has(power) or element == "tractiveEffort"):
                force_n = one.required_number(force, "N", above=0.0)
                return Effort([(0.0, force_n)], one.required_number(power, "W", above=0.0), one.line)
    return None


def _capped(node: Node) -> list[Node]:
    return [node, *node.below("tractionData", "info")]


def holds(node: Node, name: str) -> bool:
    """Whether an element of a name is below another one."""
    return any(one.name == name for one in _walk(node, (name,), ()))


def _below_anywhere(node: Node, names: tuple[str, ...], outside: Sequence[Node] = ()) -> list[Node]:
    """Elements of some names at any depth: versions of the schema put tables into different boxes."""
    return [one.read() for one in _walk(node, names, outside) if one.name in names]


def _walk(node: Node, names: tuple[str, ...], outside: Sequence[Node]) -> Iterator[Node]:
    """All elements below one, in the order of the file, but none below those of some names or those left out."""
    closed = {one.element for one in outside}
    todo = node.every_child()[::-1]
    while todo:
        one = todo.pop()
        if one.element not in closed:
            yield one
            if one.name not in names:
                todo += one.every_child()[::-1]


def total_effort(efforts: list[Effort], top_mps: float) -> EffortCurve:
    """Sum of the efforts of all powered vehicles, linear between the points of all their tables.

    Caps of force and power are summed as they are where all have one shape, else as chords up to the top speed.
    """
    capped = [effort for effort in efforts if effort.power_w]
    if len(capped) == len(efforts):
        break_mps = {effort.power_w / effort.points[0][1] for effort in capped}
        if max(break_mps) - min(break_mps) <= _SAME * max(break_mps):
            return EffortCurve.from_caps(sum(e.points[0][1] for e in capped), sum(e.power_w for e in capped))
    curves = [_chords(effort, top_mps) if effort.power_w else effort.points for effort in efforts]
    points = []
    for speed_mps in sorted({speed_mps for curve in curves for speed_mps, _ in curve}):
        before = sum(_at(curve, speed_mps, after=False) for curve in curves)
        after = sum(_at(curve, speed_mps, after=True) for curve in curves)
        points += [(speed_mps, before), (speed_mps, after)] if before != after else [(speed_mps, after)]
    return EffortCurve.from_points(points)


def _chords(effort: Effort, top_mps: float) -> list[tuple[float, float]]:
    """Points of an effort that a power limits, up to the top speed."""
    ((_, force_n),) = effort.points
    break_mps = effort.power_w / force_n
    if break_mps >= top_mps:
        return effort.points
    return [(0.0, force_n), *((v, effort.power_w / v) for v in stations([(effort.power_w, -1.0)], break_mps, top_mps))]


def _at(points: list[tuple[float, float]], speed_mps: float, *, after: bool) -> float:
    """Value of a table at a speed, before or after a jump there; constant beyond its ends."""
    speeds = [v for v, _ in points]
    right = bisect_right(speeds, speed_mps)
    here = [f for v, f in points if v == speed_mps]
    if here:
        return here[-1] if after else here[0]
    if right == 0 or right == len(points):
        return points[0 if right == 0 else -1][1]
    (v0, f0), (v1, f1) = points[right - 1], points[right]
    return f0 + (f1 - f0) * (speed_mps - v0) / (v1 - v0)


def resistance_of(node: Node, weight_kn: float | None, top_mps: float) -> Resistance:
    """Read Davis' formula, or fit it to a table of resistance over speed.

    The formula is an element of its own, or attributes of the resistance, as in the schema of 2.4.

    Parameters
    ----------
    node : Node
        ``trainResistance`` or ``drivingResistance``.
    weight_kn : float or None
        Weight that specific resistance in N/kN belongs to, where it is known.
    top_mps : float
        Speed up to which the last polynomial of a table counts.

    Raises
    ------
    InputError
        When there is neither formula nor table, a value is negative, or specific resistance has no weight.
    """
    formulas, tables = _below_anywhere(node, _FORMULAS), _below_anywhere(node, TABLES)
    if formulas:
        names = ("constantFactorA", "speedDependentFactorB", "squareSpeedDependentFactorC", "massDependent")
        return _davis(formulas[0], names, weight_kn)
    if node.text("daviesFactorA") is not None:
        return _davis(node, ("daviesFactorA", "daviesFactorB", "daviesFactorC", "daviesMassDependent"), weight_kn)
    if not tables:
        raise node.bad("missing element daviesFormula, valueTable or segmentTable")
    table = read_table(tables[0], SPECIFIC, top_mps)
    scale = _scale(tables[0], table.specific, weight_kn)
    return _fitted(table, [(v, scale * r) for v, r in table.points])


def _davis(node: Node, names: tuple[str, str, str, str], weight_kn: float | None) -> Resistance:
    """Davis' formula of four attributes: three coefficients, and whether they are per weight."""
    a = node.required_number(names[0], "N, or N/kN where massDependent", at_least=0.0)
    b = node.number(names[1], "N/(km/h)", at_least=0.0) or 0.0
    c = node.number(names[2], "N/(km/h)²", at_least=0.0) or 0.0
    specific = node.flag(names[3])
    if specific is None and _MOST_SPECIFIC < a < _LEAST_ABSOLUTE:
        raise node.bad(f"missing attribute: {a:g} may be N or N/kN", names[3])
    scale = _scale(node, specific or (specific is None and a <= _MOST_SPECIFIC), weight_kn)
    return Resistance(scale * a, scale * per_kmh_to_per_mps(b, 1), scale * per_kmh_to_per_mps(c, 2), node.line)


def _scale(node: Node, specific: bool, weight_kn: float | None) -> float:
    if specific and weight_kn is None:
        raise node.bad("is in N/kN, and its vehicle has neither bruttoWeight nor tareWeight (t)")
    return weight_kn if specific and weight_kn is not None else 1.0


def _fitted(table: Table, points: list[tuple[float, float]]) -> Resistance:
    """Least squares of A + B·v + C·v² with no negative coefficient."""
    v, r = (np.array(column) for column in zip(*points, strict=True))
    powers = np.stack([np.ones_like(v), v, v * v], axis=1)
    scale = np.maximum(np.abs(powers).max(axis=0), np.finfo(float).tiny)
    best, best_error = np.zeros(3), float(np.sum(r * r))
    for size in (1, 2, 3):
        for columns in map(list, combinations(range(3), size)):
            found = np.linalg.lstsq(powers[:, columns] / scale[columns], r, rcond=None)[0] / scale[columns]
            error = float(np.sum((powers[:, columns] @ found - r) ** 2))
            if np.all(found >= 0.0) and error < best_error:
                best, best_error = np.zeros(3), error
                best[columns] = found
    worst = float(np.max(np.abs(powers @ best - r))) / max(float(r.max()), np.finfo(float).tiny)
    note = f"resistance is A + B·v + C·v² fitted to a table; it is off by {100 * worst:.2g} % of the largest at worst"
    a, b, c = best.tolist()
    return Resistance(a, b, c, table.line, (*table.notes, note) if worst > _GOOD_FIT else table.notes)
