"""Rolling stock of railML 2.2 to 2.5 and 3.1 to 3.2: formations, and vehicles that run alone.

m, km/h and t throughout; effort tables are linear between their points and constant beyond the last one, which the
schema leaves open; specific resistance is in N per kN of weight. Source: the published documentation of the schema.
"""

import math
from itertools import chain
from typing import NamedTuple

from tgvdp.constants import GRAVITY_MPS2
from tgvdp.errors import InputError
from tgvdp.formats.railml.effort import Effort, Resistance, effort_of, resistance_of, total_effort
from tgvdp.formats.railml.rows import unused_notes
from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.effort import EffortCurve
from tgvdp.model.train import BrakingRate, Train
from tgvdp.units import KILO, kmh_to_mps, mps_to_kmh

_MOST_VEHICLES = 1000
_STOCK = ("rollingstock", "rollingStock")  # 2.x and 3.x


class _Vehicles(NamedTuple):
    """Vehicles of one kind in a train."""

    node: Node
    number: int


def trains(root: Node) -> list[Node]:
    """Formations of a file, and vehicles that can run alone: those with an engine and a resistance of their own.

    Where there is neither, vehicles with an engine: what they miss is then said when one is read.
    """
    stock = [node for name in _STOCK for node in root.children(name)]
    formations = [one for node in stock for one in node.below("formations", "formation")]
    powered = [one for node in stock for one in node.below("vehicles", "vehicle") if one.children("engine")]
    return [*formations, *(one for one in powered if one.children("drivingResistance"))] or powered


def modes(root: Node, train: Node) -> tuple[str, ...]:
    """Names of the propulsions among which a train can choose: those of its one powered kind of vehicle."""
    vehicles = [one.node for one in _vehicles(root, train)]
    powered = {vehicle.line: vehicle for vehicle in vehicles if _propulsions(vehicle)}
    named = [name for vehicle in powered.values() for name, _ in _propulsions(vehicle)] if len(powered) == 1 else []
    return tuple(named) if len(named) > 1 else ()


def read_train(root: Node, node: Node, mode: str) -> tuple[Train, dict[str, int]]:
    """Make a train of a formation or a vehicle.

    Parameters
    ----------
    root, node : Node
    mode : str
        One of `modes`, or empty where there is none to choose.

    Returns
    -------
    train : Train
    lines : dict of str to int
        Line of the file by field of the train.

    Raises
    ------
    InputError
        When a mass, a speed, an effort table or the resistance is missing, or a value is out of range.
    """
    vehicles = _vehicles(root, node)
    mass_t = _mass_t(node, vehicles)
    length_m = _length_m(node, vehicles)
    top_mps = kmh_to_mps(_speed_kmh(node, vehicles))
    traction, braking, extra_t, (efficiency, notes) = _propulsion(vehicles, mode, mass_t)
    if not traction:
        raise node.bad("no vehicle has a tractiveEffort table, nor maxTractEffort and power")
    resistance = _resistance(node, vehicles, mass_t)
    rates, rate_notes = _braking_rates(node)
    acceleration_mps2 = _first(node, ("trainEngine",), "maxAcceleration", "m/s²")
    name = _name(node)
    notes += [*resistance.notes, *rate_notes, *_effort_notes(traction, top_mps)]
    if not extra_t:
        notes.append("no rotationMassFactor nor rotationMass: taken as 1")
    if not rates and not braking:
        notes.append("no brakeEffort table, no meanDeceleration nor maxDeceleration: this train has no brake")
    read = [node, *(one.node for one in vehicles if one.node is not node)]
    notes += unused_notes([unused for one in read for unused in one.unused()])
    try:
        train = Train(
            name=name,
            mass_kg=mass_t * KILO,
            rotating_mass_factor=1.0 + extra_t / mass_t,
            length_m=length_m,
            traction=total_effort(traction),
            braking=total_effort(braking) if braking else EffortCurve.from_caps(0.0),
            braking_rates=rates,
            davis_a_n=resistance.a_n,
            davis_b_n_per_mps=resistance.b_n_per_mps,
            davis_c_n_per_mps2=resistance.c_n_per_mps2,
            max_speed_mps=top_mps,
            max_acceleration_mps2=math.inf if acceleration_mps2 is None else acceleration_mps2,
            traction_efficiency=efficiency,
            notes=tuple(dict.fromkeys(notes)),
        )
    except InputError as error:
        raise node.bad(str(error)) from None
    brakes = node.children("trainBrakes", "brakes")
    lines = dict.fromkeys(("mass_kg", "max_speed_mps", "length_m", "rotating_mass_factor"), node.line)
    lines |= dict.fromkeys(("davis_a_n", "davis_c_n_per_mps2", "resistance"), resistance.line)
    lines |= dict.fromkeys(("traction", "traction_efficiency"), traction[0].line)
    return train, lines | {"braking_rates": brakes[0].line if brakes else node.line}


def _name(node: Node) -> str:
    names = [one.text("name") for one in node.children("name")]
    return node.text("name") or next((name for name in names if name), None) or node.text("id") or node.name


def _vehicles(root: Node, train: Node) -> list[_Vehicles]:
    """Vehicles of a formation with their numbers; a vehicle is its own only one."""
    if train.name == "vehicle":
        return [_Vehicles(train, 1)]
    stock = [node for name in _STOCK for node in root.children(name)]
    known = {one.text("id"): one for node in stock for one in node.below("vehicles", "vehicle")}
    orders = train.children("trainOrder")
    refs = [*chain.from_iterable(order.children("vehicleRef") for order in orders)] or orders
    found = []
    for ref in refs:
        name = ref.required_text("vehicleRef")
        count = ref.number("vehicleCount", "vehicles", at_least=1.0) or 1.0
        if count != int(count) or count > _MOST_VEHICLES:
            raise ref.bad(f"must be a whole number of 1 to {_MOST_VEHICLES} vehicles, got {count:g}", "vehicleCount")
        if name not in known:
            raise ref.bad(f"no vehicle {shown(name)} in this file", "vehicleRef")
        found.append(_Vehicles(known[name], int(count)))
    if not found:
        raise train.bad("missing element trainOrder with a vehicleRef")
    return found


def _mass_t(train: Node, vehicles: list[_Vehicles]) -> float:
    """Gross mass, of the train or else the sum of its vehicles; a tare mass where there is no gross mass, t."""
    own_t = _own_mass_t(train)
    if own_t is not None:
        return own_t
    total_t = 0.0
    for one in vehicles:
        mass_t = _own_mass_t(one.node)
        if mass_t is None:
            raise one.node.bad("missing attribute (t), and so is tareWeight", "bruttoWeight")
        total_t += one.number * mass_t
    return total_t


def _own_mass_t(node: Node) -> float | None:
    gross_t = node.number("bruttoWeight", "t", above=0.0)
    return node.number("tareWeight", "t", above=0.0) if gross_t is None else gross_t


def _length_m(train: Node, vehicles: list[_Vehicles]) -> float:
    own_m = train.number("length", "m", at_least=0.0)
    if own_m is not None:
        return own_m
    return sum(one.number * one.node.required_number("length", "m", at_least=0.0) for one in vehicles)


def _speed_kmh(train: Node, vehicles: list[_Vehicles]) -> float:
    """Top speed of the train, or else of its slowest vehicle, km/h."""
    own_kmh = train.number("speed", "km/h", above=0.0)
    if own_kmh is not None:
        return own_kmh
    return min(one.node.required_number("speed", "km/h", above=0.0) for one in vehicles)


def _propulsions(vehicle: Node) -> list[tuple[str, Node]]:
    """Propulsions (2.x) or power modes (3.x) of a vehicle by their id or number."""
    nodes = [*vehicle.below("engine", "propulsion"), *vehicle.below("engine", "powerMode")]
    return [(node.text("id") or node.text("mode") or str(index + 1), node) for index, node in enumerate(nodes)]


def _propulsion(
    vehicles: list[_Vehicles], mode: str, mass_t: float
) -> tuple[list[Effort], list[Effort], float, tuple[float, list[str]]]:
    """Tables of traction and of the dynamic brake, rotating mass as additional t, efficiency and what to say of it."""
    traction: list[Effort] = []
    braking: list[Effort] = []
    extra_t = 0.0
    shares: set[float] = set()
    for one in vehicles:
        propulsions = _propulsions(one.node)
        chosen = [node for name, node in propulsions if name == mode or len(propulsions) == 1]
        for other in (node for _, node in propulsions if node not in chosen):
            other.dismiss()
        if propulsions and not chosen:
            raise one.node.bad(f"has several propulsions, choose one: {', '.join(name for name, _ in propulsions)}")
        for node in chosen:
            traction += _scaled(effort_of(node, "tractiveEffort", "maxTractEffort"), one.number)
            shares |= {share for share in [node.number("totalTractEfficiency", "-", above=0.0)] if share}
        braking += _scaled(effort_of(one.node, "brakeEffort", ""), one.number)
        extra_t += one.number * _rotating_t(one.node, chosen, mass_t if len(vehicles) == one.number == 1 else None)
    if len(shares) > 1:
        raise vehicles[0].node.bad("vehicles of different totalTractEfficiency cannot be one train")
    share = shares.pop() if shares else 1.0
    notes = [f"totalTractEfficiency {share:g} is read as {share:g} %"] if share > 1.0 else []
    return traction, braking, extra_t, (share / 100.0 if share > 1.0 else share, notes)


def _scaled(effort: Effort | None, count: int) -> list[Effort]:
    return [] if effort is None else [effort.times(count)]


def _rotating_t(vehicle: Node, propulsions: list[Node], mass_t: float | None) -> float:
    """Rotating masses of a vehicle as additional mass, t, from a factor of its mass or from a mass."""
    extra_t = 0.0
    for node in [vehicle, *vehicle.children("wagon"), *propulsions]:
        factor = node.number("rotationMassFactor", "-", at_least=1.0)
        if factor is not None:
            own_t = mass_t if mass_t is not None else _own_mass_t(vehicle)
            if own_t is None:
                raise vehicle.bad("missing attribute (t), to which rotationMassFactor belongs", "bruttoWeight")
            extra_t += (factor - 1.0) * own_t
        extra_t += node.number("rotationMass", "t", at_least=0.0) or 0.0
    return extra_t


def _resistance(train: Node, vehicles: list[_Vehicles], mass_t: float) -> Resistance:
    """Resistance of the train, or else the sum of its vehicles'."""
    weight_kn = mass_t * GRAVITY_MPS2
    own = train.child("trainResistance", "drivingResistance")
    if own is not None:
        return resistance_of(own, weight_kn)
    parts = []
    for one in vehicles:
        given = one.node.child("drivingResistance")
        if given is None:
            raise train.bad("missing element trainResistance, and not every vehicle has a drivingResistance")
        own_t = _own_mass_t(one.node)
        part = resistance_of(given, weight_kn if own_t is None else own_t * GRAVITY_MPS2)
        parts.append(part.times(one.number))
    return Resistance(
        a_n=sum(one.a_n for one in parts),
        b_n_per_mps=sum(one.b_n_per_mps for one in parts),
        c_n_per_mps2=sum(one.c_n_per_mps2 for one in parts),
        line=parts[0].line,
        notes=tuple(dict.fromkeys(note for one in parts for note in one.notes)),
    )


def _first(node: Node, names: tuple[str, ...], attribute: str, unit: str) -> float | None:
    """Return an attribute, above 0, of the first child of given names that has it."""
    values = [child.number(attribute, unit, above=0.0) for child in node.children(*names)]
    return next((value for value in values if value is not None), None)


def _braking_rates(train: Node) -> tuple[tuple[BrakingRate, ...], list[str]]:
    """Deceleration of full braking: the mean one, or else the largest."""
    for attribute in ("meanDeceleration", "maxDeceleration"):
        rate_mps2 = _first(train, ("trainBrakes", "brakes"), attribute, "m/s²")
        if rate_mps2 is not None:
            return (BrakingRate(0.0, rate_mps2),), [f"full braking is trainBrakes@{attribute}, {rate_mps2:g} m/s²"]
    return (), []


def _effort_notes(efforts: list[Effort], top_mps: float) -> list[str]:
    ends_mps = [effort.points[-1][0] for effort in efforts if not effort.power_w]
    if any(end_mps < top_mps for end_mps in ends_mps):
        return [f"effort tables end at {mps_to_kmh(min(ends_mps)):.6g} km/h: constant from there to the top speed"]
    return []
