"""Value tables of railML rolling stock: effort and resistance over speed."""

from bisect import bisect_right
from itertools import combinations
from typing import NamedTuple

import numpy as np

from tgvdp.errors import InputError
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.effort import EffortCurve
from tgvdp.units import per_kmh_to_per_mps, to_si

#: A table that Davis' formula meets to better than this needs no remark.
_GOOD_FIT = 1e-3
#: Speeds at which caps of effort and power meet count as the same when they differ by rounding.
_SAME = 1e-9
#: The constant of Davis' formula: no train has more than this in N/kN, or less than that in N.
_MOST_SPECIFIC = 30.0
_LEAST_ABSOLUTE = 90.0


class Effort(NamedTuple):
    """Effort of some vehicles: points (m/s, N), and the power that limits it in W, 0 for none."""

    points: list[tuple[float, float]]
    power_w: float
    line: int

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


def effort_of(node: Node, element: str, largest: str) -> Effort | None:
    """Read the effort table below a vehicle or its propulsion, or else a largest effort and a power.

    Parameters
    ----------
    node : Node
    element : str
        Name of the element that holds the table.
    largest : str
        Name of the attribute that holds the largest effort in N; empty where there is none.
    """
    holders = _below_anywhere(node, element)
    tables = [(holder, table) for holder in holders for table in holder.children("valueTable")]
    if len(tables) > 1:
        raise tables[1][1].bad(f"a second {element} table; one is expected")
    if tables:
        table = tables[0][1]
        points = _points(table, "force", "N")
        if points[0][0] > 0.0:  # tables often start at a few km/h
            points.insert(0, (0.0, points[0][1]))
        return Effort(points, 0.0, table.line)
    force_n = node.number(largest, "N", above=0.0) if largest else None
    if force_n is None:
        return None
    return Effort([(0.0, force_n)], node.required_number("power", "W", above=0.0), node.line)


def _below_anywhere(node: Node, name: str) -> list[Node]:
    """Elements of a name at any depth: versions of the schema put tables into different boxes."""
    found, todo = [], [node]
    while todo:
        one = todo.pop()
        for child in one.every_child():
            if child.name == name:
                found.append(child.read())
            else:
                todo.append(child)
    return found


def _points(table: Node, quantity: str, unit: str) -> list[tuple[float, float]]:
    """Rows of a table with one column, speeds in m/s and values in SI (or in N/kN), in the order of the file."""
    x_unit = table.text("xValueUnit") or "km/h"
    y_unit = table.text("yValueUnit") or unit
    for attribute in ("xValueName", "yValueName", "zValueName", "zValueUnit"):
        table.text(attribute)
    points: list[tuple[float, float]] = []
    for line in table.children("valueLine"):
        values = line.children("values")
        if len(values) != 1:
            raise line.bad(f"must hold one element values, got {len(values)}")
        x, y = line.required_number("xValue", x_unit, at_least=0.0), values[0].required_number("yValue", y_unit)
        try:
            speed_mps = to_si(x, x_unit, "speed")
            value = y if y_unit == "N/kN" and quantity == "resistance" else to_si(y, y_unit, "force")
        except InputError as error:
            raise table.bad(str(error)) from None
        if value < 0.0:
            raise values[0].bad(f"must be at least 0 {y_unit}, got {y:g} {y_unit}", "yValue")
        if points and speed_mps < points[-1][0]:
            raise line.bad(f"speeds must not decrease, got {x:g} {x_unit}", "xValue")
        points.append((speed_mps, value))
    if not points:
        raise table.bad("missing element valueLine")
    return points


def total_effort(efforts: list[Effort]) -> EffortCurve:
    """Sum of the efforts of all powered vehicles, linear between the points of all their tables.

    Raises
    ------
    InputError
        When caps of force and power stand beside tables, or caps of different shape beside each other.
    """
    capped = [effort for effort in efforts if effort.power_w]
    if capped:
        break_mps = {effort.power_w / effort.points[0][1] for effort in capped}
        if len(capped) < len(efforts) or max(break_mps) - min(break_mps) > _SAME * max(break_mps):
            raise InputError("vehicles with maxTractEffort and power beside others: give each a tractiveEffort table")
        return EffortCurve.from_caps(sum(e.points[0][1] for e in capped), sum(e.power_w for e in capped))
    points = []
    for speed_mps in sorted({speed_mps for effort in efforts for speed_mps, _ in effort.points}):
        before = sum(_at(effort.points, speed_mps, after=False) for effort in efforts)
        after = sum(_at(effort.points, speed_mps, after=True) for effort in efforts)
        points += [(speed_mps, before), (speed_mps, after)] if before != after else [(speed_mps, after)]
    return EffortCurve.from_points(points)


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


def resistance_of(node: Node, weight_kn: float) -> Resistance:
    """Read Davis' formula, or fit it to a table of resistance over speed.

    Parameters
    ----------
    node : Node
        ``trainResistance`` or ``drivingResistance``.
    weight_kn : float
        Weight that specific resistance in N/kN belongs to.

    Raises
    ------
    InputError
        When there is neither formula nor table, or a value is negative.
    """
    formulas, tables = _below_anywhere(node, "daviesFormula"), _below_anywhere(node, "valueTable")
    if formulas:
        one = formulas[0]
        a = one.required_number("constantFactorA", "N, or N/kN where massDependent", at_least=0.0)
        specific = one.flag("massDependent")
        if specific is None and _MOST_SPECIFIC < a < _LEAST_ABSOLUTE:
            raise one.bad(f"missing attribute: {a:g} may be N or N/kN", "massDependent")
        scale = weight_kn if specific or (specific is None and a <= _MOST_SPECIFIC) else 1.0
        b = one.number("speedDependentFactorB", "N/(km/h)", at_least=0.0) or 0.0
        c = one.number("squareSpeedDependentFactorC", "N/(km/h)²", at_least=0.0) or 0.0
        for table in tables:
            table.dismiss()
        return Resistance(scale * a, scale * per_kmh_to_per_mps(b, 1), scale * per_kmh_to_per_mps(c, 2), one.line)
    if not tables:
        raise node.bad("missing element daviesFormula or valueTable")
    points = _points(tables[0], "resistance", "N/kN")
    scale = weight_kn if (tables[0].text("yValueUnit") or "N/kN") == "N/kN" else 1.0
    return _fitted(tables[0], [(v, scale * r) for v, r in points])


def _fitted(table: Node, points: list[tuple[float, float]]) -> Resistance:
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
    notes = (
        f"resistance is A + B·v + C·v² fitted to a table; it is off by {100 * worst:.2g} % of the largest at worst",
    )
    a, b, c = best.tolist()
    return Resistance(a, b, c, table.line, notes if worst > _GOOD_FIT else ())
