"""Energy models: what a run is charged for.

``wheel`` counts traction work at the wheel. ``pantograph`` counts what is drawn from the line: traction work over the
train's traction efficiency, less what the dynamic brake returns, plus auxiliary power times running time. ``map`` looks
the power drawn up in a table over speed and demand, plus auxiliary power times running time.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.constants import ENERGY_KINDS
from tgvdp.errors import InputError
from tgvdp.model.checks import require_notes, require_number, require_text
from tgvdp.model.train import Train

#: Name in the catalog of the map that is meant where none is named.
BUILT_IN_MAP = "alstom-map"

#: Each node is looked up by bisection; more than these are no table of an engineer.
_MOST_NODES = 10_000

#: Share of the power at the wheel by which a map may fall short of it in rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True, kw_only=True)
class EnergyMap:
    """Power drawn from the line over speed and demand, bilinear between nodes and constant beyond them.

    Parameters
    ----------
    speed_mps : tuple of float
        Nodes, increasing, at least two, from 0 on.
    demand : tuple of float
        Nodes, increasing, at least two, within −1..1: effort as a share of the effort limit; negative when braking,
        where the limit is that of the dynamic brake.
    power_w : tuple of tuple of float
        Power drawn at the nodes, a row for each speed; negative when it is returned.
    name : str
        For people.
    notes : tuple of str
        Sources and doubts.

    Raises
    ------
    InputError
        When a node is missing, unordered or not finite.
    """

    speed_mps: tuple[float, ...]
    demand: tuple[float, ...]
    power_w: tuple[tuple[float, ...], ...]
    name: str = "map"
    notes: tuple[str, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        owner = f"energy map {require_text('energy map', 'name', self.name)}"
        object.__setattr__(self, "notes", require_notes(owner, self.notes))
        speeds = _nodes(owner, "speed_mps", self.speed_mps, "m/s")
        demands = _nodes(owner, "demand", self.demand, "of the effort limit")
        if speeds[0] < 0.0:
            raise InputError(f"{owner}: speed_mps must be at least 0 m/s, got {speeds[0]:.12g} m/s")
        if demands[0] < -1.0 or demands[-1] > 1.0:
            raise InputError(f"{owner}: demand must be within -1..1, got {demands[0]:.12g} to {demands[-1]:.12g}")
        rows = tuple(tuple(row) for row in self.power_w)
        if len(rows) != len(speeds) or any(len(row) != len(demands) for row in rows):
            raise InputError(f"{owner}: power_w must have {len(speeds)} rows of {len(demands)} values")
        power = tuple(
            tuple(require_number(owner, f"power_w[{i}][{j}]", value, "W") for j, value in enumerate(row))
            for i, row in enumerate(rows)
        )
        for name, value in (("speed_mps", speeds), ("demand", demands), ("power_w", power)):
            object.__setattr__(self, name, value)

    @cached_property
    def tables(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Speeds (n,), demands (m,) and powers (n, m), float64, for the kernels."""
        return np.array(self.speed_mps), np.array(self.demand), np.array(self.power_w)


def _nodes(owner: str, name: str, given: Any, unit: str) -> tuple[float, ...]:
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise InputError(f"{owner}: {name} must be a list of numbers, got {given!r:.60}")
    nodes = tuple(require_number(owner, f"{name}[{i}]", value, unit) for i, value in enumerate(given))
    if not 2 <= len(nodes) <= _MOST_NODES:
        raise InputError(f"{owner}: {name} must have 2 to {_MOST_NODES} nodes, got {len(nodes)}")
    for before, after in pairwise(nodes):
        if not after > before:
            raise InputError(f"{owner}: {name} must increase, got {after:.12g} after {before:.12g}")
    return nodes


@dataclass(frozen=True)
class EnergyModel:
    """Which energy a search minimises.

    Parameters
    ----------
    kind : {"wheel", "pantograph", "map"}
    map : EnergyMap, optional
        The table; for the kind ``map`` alone.

    Raises
    ------
    InputError
        When the kind is unknown, or the map missing or too much.
    """

    kind: str = "wheel"
    map: EnergyMap | None = None

    def __post_init__(self) -> None:
        if self.kind not in ENERGY_KINDS:
            raise InputError(f"energy must be one of {', '.join(ENERGY_KINDS)}, got {self.kind!r:.60}")
        if (self.kind == "map") != isinstance(self.map, EnergyMap):
            raise InputError(f"energy: a map belongs to the kind map, got kind {self.kind} and {self.map!r:.40}")

    def auxiliary_w(self, train: Train) -> float:
        """Power of a train's auxiliaries that counts, W: none at the wheel."""
        return 0.0 if self.kind == "wheel" else float(train.auxiliary_power_w)


class Violation(NamedTuple):
    """A node at which a map breaks the conservation of energy for a train.

    ``power_w`` is what the map draws there, ``bound_w`` what it must draw at least: the power at the wheel, which is
    negative when braking, for no more can be returned.
    """

    speed_mps: float
    demand: float
    power_w: float
    bound_w: float


def violations(train: Train, map: EnergyMap) -> list[Violation]:
    """Nodes up to the train's top speed where a map draws less than the power at the wheel, worst first.

    A map that returns more than the dynamic brake takes is the same fault with the sign of braking.
    """
    found = []
    for i, speed_mps in enumerate(map.speed_mps):
        for j, demand in enumerate(map.demand):
            if speed_mps > train.max_speed_mps:
                continue
            curve = train.traction_limit if demand >= 0.0 else train.dynamic_brake_limit
            bound_w = demand * curve.effort_n(speed_mps) * speed_mps if speed_mps > 0.0 else 0.0
            if map.power_w[i][j] < bound_w - _ROUNDING * abs(bound_w):
                found.append(Violation(speed_mps, demand, map.power_w[i][j], bound_w))
    return sorted(found, key=lambda one: one.power_w - one.bound_w)


WHEEL = EnergyModel()
PANTOGRAPH = EnergyModel("pantograph")
