"""What drives and brakes the vehicles of a railML train: propulsions, their tables, rotating masses, efficiency.

A vehicle has one propulsion for each supply system (2.x), or power modes (3.x). The effort table of an engine stands
below one of these, or beside them where it is that of all.
"""

from collections.abc import Iterator
from typing import NamedTuple

from tgvdp.formats.railml.effort import Effort, effort_of, holds
from tgvdp.formats.syntax.xml import Node


class Vehicles(NamedTuple):
    """Vehicles of one kind in a train."""

    node: Node
    number: int


class Mass(NamedTuple):
    """Mass of a train or vehicle, and whether it is that of an empty one."""

    mass_t: float
    empty: bool


class Drive(NamedTuple):
    """Tables of traction and of the dynamic brake, rotating mass as additional t, efficiency and what to say of it."""

    traction: list[Effort]
    braking: list[Effort]
    rotating_t: float
    efficiency: float
    notes: list[str]


class _Propulsion(NamedTuple):
    name: str
    node: Node


def mass_of(node: Node) -> Mass | None:
    """Gross mass of a vehicle or a formation (``totalWeight`` in 3.x), else that without load."""
    for attribute in ("bruttoWeight", "totalWeight", "tareWeight"):
        mass_t = node.number(attribute, "t", above=0.0)
        if mass_t is not None:
            return Mass(mass_t, attribute == "tareWeight")
    return None


def modes_of(vehicles: list[Vehicles]) -> tuple[str, ...]:
    """Names of the propulsions among which vehicles can choose: those of the one powered kind of them."""
    kinds = {one.node.element: _propulsions(one.node) for one in vehicles}
    powered = [propulsions for propulsions in kinds.values() if propulsions]
    named = [one.name for one in powered[0]] if len(powered) == 1 else []
    return tuple(named) if len(named) > 1 else ()


def drive_of(vehicles: list[Vehicles], mode: str, mass_t: float, top_mps: float) -> Drive:
    """Read what drives and brakes the vehicles of a train, with the propulsion of a name where they have several.

    Raises
    ------
    InputError
        When no propulsion has that name, a table is incomplete, or the vehicles' efficiencies differ.
    """
    traction: list[Effort] = []
    braking: list[Effort] = []
    rotating_t = 0.0
    shares: list[float | None] = []
    notes: list[str] = []
    without: list[str] = []
    for one in vehicles:
        propulsions = _propulsions(one.node)
        chosen = [other for other in propulsions if other.name == mode or len(propulsions) == 1]
        if propulsions and not chosen:
            raise one.node.bad(f"has several propulsions, choose one: {', '.join(other.name for other in propulsions)}")
        for other in propulsions:
            if other not in chosen:
                other.node.dismiss()
                notes.append(f"propulsion {other.name} is not used")
        for _, node in chosen:
            traction += _scaled(effort_of(node, "tractiveEffort", top_mps, largest="maxTractEffort"), one.number)
            shares.append(node.number("totalTractEfficiency", "-", above=0.0))
        braking += _scaled(_brake(one.node, propulsions, chosen, top_mps), one.number)
        alone = len(vehicles) == one.number == 1
        own_t = _rotating_t(one.node, [node for _, node in chosen], mass_t if alone else None)
        rotating_t += one.number * (own_t or 0.0)
        without += [] if own_t is not None else [one.node.text("id") or one.node.name]
    known = {share for share in shares if share is not None}
    if len(known) > 1:
        raise vehicles[0].node.bad("vehicles of different totalTractEfficiency cannot be one train")
    share = known.pop() if known else 1.0
    if share > 1.0:
        notes.append(f"totalTractEfficiency {share:g} is read as {share:g} %")
    if share != 1.0 and None in shares:
        notes.append(f"totalTractEfficiency {share:g} counts for all vehicles, some of which give none")
    if without:
        notes.append(f"no rotating mass is given for {', '.join(dict.fromkeys(without))}: taken as none")
    notes += (note for effort in (*traction, *braking) for note in effort.notes)
    return Drive(traction, braking, rotating_t, share / 100.0 if share > 1.0 else share, notes)


def _propulsions(vehicle: Node) -> list[_Propulsion]:
    """Propulsions or power modes of a vehicle by their id, mode or number."""
    nodes = list(_sources(vehicle))
    names = [node.text("id") or _mode(node) or str(index + 1) for index, node in enumerate(nodes)]
    if len(set(names)) < len(names):
        names = [str(index + 1) for index in range(len(nodes))]
    return [_Propulsion(*both) for both in zip(names, nodes, strict=True)]


def _mode(node: Node) -> str | None:
    return next((mode.text("mode") for mode in (node, *node.children("powerMode")) if mode.text("mode")), None)


def _sources(vehicle: Node) -> Iterator[Node]:
    """Elements that hold the efforts to choose among; power modes that hold none are no choice."""
    for engine in vehicle.children("engine"):
        several = engine.children("propulsion", "powerMode")
        own = [one for one in several if one.name == "propulsion" or one.text("maxTractEffort") or _has_table(one)]
        yield from own or ([engine] if _has_table(engine) else [])


def _has_table(node: Node) -> bool:
    return holds(node, "tractiveEffort")


def _brake(vehicle: Node, propulsions: list[_Propulsion], chosen: list[_Propulsion], top_mps: float) -> Effort | None:
    """Dynamic brake of the chosen propulsion, or else that of the vehicle; never one of another propulsion."""
    for _, node in chosen:
        effort = effort_of(node, "brakeEffort", top_mps)
        if effort is not None:
            return effort
    return effort_of(vehicle, "brakeEffort", top_mps, outside=[node for _, node in propulsions])


def _scaled(effort: Effort | None, count: int) -> list[Effort]:
    return [] if effort is None else [effort.times(count)]


def _rotating_t(vehicle: Node, propulsions: list[Node], mass_t: float | None) -> float | None:
    """Rotating masses of a vehicle as additional mass, t; None where it gives none.

    Each part of it gives a mass or a factor of the vehicle's mass, which are two ways to say the same.
    """
    found_t = []
    for node in [vehicle, *vehicle.children("wagon"), *propulsions]:
        masses_t = [node.number(name, "t", at_least=0.0) for name in ("additionalRotationMass", "rotationMass")]
        given_t = next((given_t for given_t in masses_t if given_t is not None), None)
        factor = None if given_t else node.number("rotationMassFactor", "-", at_least=1.0)
        if factor is not None:
            own = mass_of(vehicle)
            own_t = mass_t if mass_t is not None or own is None else own.mass_t
            if own_t is None:
                raise vehicle.bad("missing attribute (t), to which rotationMassFactor belongs", "bruttoWeight")
            given_t = (factor - 1.0) * own_t
        found_t += [] if given_t is None else [given_t]
    return sum(found_t) if found_t else None
