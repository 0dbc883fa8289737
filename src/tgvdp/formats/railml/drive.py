"""What drives and brakes the vehicles of a railML train: propulsions, their tables, rotating masses, efficiency.

A vehicle has one propulsion for each supply system (2.x), or power modes (3.x). The effort table of an engine stands
below one of these, or beside them where it is that of all.
"""

from collections.abc import Iterator
from typing import NamedTuple

from tgvdp.formats.railml.effort import Effort, effort_of, has_caps, holds
from tgvdp.formats.syntax.xml import Node

_TRACTION_EFFICIENCY = "totalTractEfficiency"


class Vehicles(NamedTuple):
    """Vehicles of one kind in a train."""

    node: Node
    number: int


class Mass(NamedTuple):
    """Mass of a train or vehicle, and whether it is that of an empty one."""

    mass_t: float
    empty: bool


class Drive(NamedTuple):
    """Efforts of traction and dynamic brake, rotating mass as additional t, what is drawn, and what to say of it.

    The efficiency of the brake, from the wheel to the pantograph, is 0 where it is not given.
    """

    traction: list[Effort]
    braking: list[Effort]
    rotating_t: float
    efficiency: float
    regeneration: float
    auxiliary_w: float
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
    notes: list[str] = []
    kinds = [_kind(one, mode, mass_t if len(vehicles) == one.number == 1 else None, top_mps) for one in vehicles]
    for kind in kinds:
        notes += (f"propulsion {name} is not used" for name in kind.not_chosen)
    traction = [effort for kind in kinds for effort in kind.traction]
    braking = [kind.braking for kind in kinds if kind.braking is not None]
    efficiency, efficiency_notes = _efficiency(vehicles, _TRACTION_EFFICIENCY, [one.shares for one in kinds])
    regeneration, brake_notes = _efficiency(vehicles, "totalBrakeEfficiency", [one.brake_shares for one in kinds])
    notes += [*efficiency_notes, *brake_notes]
    powerless = [kind.name for kind in kinds if kind.has_engine and not kind.traction]
    if powerless and traction:
        notes.append(f"engines of {', '.join(dict.fromkeys(powerless))} give no effort: they drive nothing")
    without = [kind.name for kind in kinds if kind.rotating_t is None]
    if without:
        notes.append(f"no rotating mass is given for {', '.join(dict.fromkeys(without))}: taken as none")
    notes += (note for effort in (*traction, *braking) for note in effort.notes)
    return Drive(
        traction=traction,
        braking=braking,
        rotating_t=sum(kind.rotating_t or 0.0 for kind in kinds),
        efficiency=1.0 if efficiency is None else efficiency,
        regeneration=regeneration or 0.0,
        auxiliary_w=sum(kind.auxiliary_w for kind in kinds),
        notes=notes,
    )


class _Kind(NamedTuple):
    """What all vehicles of one kind in a train give together; no rotating mass where they say nothing of it."""

    name: str
    has_engine: bool
    not_chosen: list[str]
    traction: list[Effort]
    braking: Effort | None
    rotating_t: float | None
    auxiliary_w: float
    shares: list[float | None]
    brake_shares: list[float | None]


def _kind(one: Vehicles, mode: str, mass_t: float | None, top_mps: float) -> _Kind:
    """Read the vehicles of one kind; the mass is that of the train where there are no others."""
    propulsions = _propulsions(one.node)
    chosen = [other for other in propulsions if other.name == mode or len(propulsions) == 1]
    others = [other for other in propulsions if other not in chosen]
    if propulsions and not chosen:
        raise one.node.bad(f"has several propulsions, choose one: {', '.join(other.name for other in propulsions)}")
    for other in others:
        other.node.dismiss()
    nodes = [node for _, node in chosen]
    efforts = [effort_of(node, "tractiveEffort", top_mps) for node in nodes]
    braking = _brake(one.node, propulsions, chosen, top_mps)
    rotating_t = _rotating_t(one.node, nodes, mass_t)
    return _Kind(
        name=one.node.text("id") or one.node.name,
        has_engine=bool(one.node.children("engine")),
        not_chosen=[other.name for other in others],
        traction=[effort.times(one.number) for effort in efforts if effort is not None],
        braking=None if braking is None else braking.times(one.number),
        rotating_t=None if rotating_t is None else one.number * rotating_t,
        auxiliary_w=one.number * _auxiliary_w(one.node, nodes),
        shares=[node.number(_TRACTION_EFFICIENCY, "-", above=0.0) for node in nodes],
        brake_shares=[node.number("totalBrakeEfficiency", "-", at_least=0.0) for node in nodes],
    )


def _auxiliary_w(vehicle: Node, propulsions: list[Node]) -> float:
    """Power that the auxiliaries of a vehicle draw at any time, W: of its drive, and of its body."""
    drives = [
        supply.number("power", "W", at_least=0.0) for one in propulsions for supply in one.children("auxiliarySupply")
    ]
    bodies = [one.number("auxiliaryPowerConsumption", "W", at_least=0.0) for one in vehicle.children("wagon")]
    return sum(power_w or 0.0 for power_w in (*drives, *bodies))


def _efficiency(
    vehicles: list[Vehicles], name: str, shares_of_kinds: list[list[float | None]]
) -> tuple[float | None, list[str]]:
    """Efficiency of all propulsions of a train, None where none is given, and what must be said of it."""
    shares = [share for shares in shares_of_kinds for share in shares]
    known = {share for share in shares if share is not None}
    if len(known) > 1 and name == _TRACTION_EFFICIENCY:
        raise vehicles[0].node.bad(f"vehicles of different {name} cannot be one train")
    if not known:
        return None, []
    share = min(known)  # what is given back by several brakes is at least that
    notes = [f"{name} {share:g} is the least of {len(known)}"] if len(known) > 1 else []
    notes += [f"{name} {share:g} is read as {share:g} %"] if share > 1.0 else []
    if share != 1.0 and None in shares:
        notes.append(f"{name} {share:g} counts for all vehicles, some of which give none")
    return share / 100.0 if share > 1.0 else share, notes


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
        own = [one for one in several if one.name == "propulsion" or has_caps(one, "tractiveEffort") or _has_table(one)]
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


def _rotating_t(vehicle: Node, propulsions: list[Node], mass_t: float | None) -> float | None:
    """Rotating masses of a vehicle as additional mass, t; None where it gives none.

    Each part of it gives a mass or a factor of the vehicle's mass, which are two ways to say the same.
    """
    found_t = []
    for node in [vehicle, *vehicle.children("wagon"), *propulsions]:
        masses_t = [node.number(name, "t", at_least=0.0) for name in ("additionalRotationMass", "rotationMass")]
        given_t = next((given_t for given_t in masses_t if given_t is not None), None)
        factor = None if given_t else _factor(node)
        if factor is not None:
            own = mass_of(vehicle)
            own_t = mass_t if mass_t is not None or own is None else own.mass_t
            if own_t is None:
                raise vehicle.bad("missing attribute (t), to which its factor of rotating mass belongs", "bruttoWeight")
            given_t = (factor - 1.0) * own_t
        found_t += [] if given_t is None else [given_t]
    return sum(found_t) if found_t else None


def _factor(node: Node) -> float | None:
    """Inertia over mass, which has another name since 3.3."""
    factors = [node.number(name, "-", at_least=1.0) for name in ("rotationMassFactor", "rotatingMassFactor")]
    return next((factor for factor in factors if factor is not None), None)
