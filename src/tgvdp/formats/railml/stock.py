"""Rolling stock of railML 2.x and 3.x: formations, and vehicles that run alone.

m, km/h and t throughout; effort tables are linear between their points and constant beyond the last one, which the
schema leaves open; specific resistance is in N per kN of weight. Source: the published documentation of the schema.
"""

import math

from tgvdp.constants import GRAVITY_MPS2
from tgvdp.errors import InputError
from tgvdp.formats.railml.braking import brakes_of, braking_rates
from tgvdp.formats.railml.drive import Vehicles, drive_of, mass_of, modes_of
from tgvdp.formats.railml.effort import Effort, Resistance, effort_of, resistance_of, total_effort
from tgvdp.formats.railml.family import family_of, whole
from tgvdp.formats.railml.rows import unused_notes
from tgvdp.formats.syntax.reading import shown
from tgvdp.formats.syntax.xml import Node
from tgvdp.model.effort import EffortCurve
from tgvdp.model.train import Train
from tgvdp.units import KILO, kmh_to_mps, mps_to_kmh

_MOST_VEHICLES = 1000
_NO_VEHICLES = ", and no trainOrder names vehicles"
_STOCK = ("rollingstock", "rollingStock")  # 2.x and 3.x


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
    return modes_of(_vehicles(root, train))


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
    node = vehicles[0].node if node.name == "vehicle" else node
    count = _count(node, "formationCount", "formations")
    mass_t, mass_notes = _mass_t(node, vehicles)
    length_m, length_notes = _length_m(node, vehicles)
    top_kmh, speed_notes = _speed_kmh(node, vehicles)
    top_mps = kmh_to_mps(top_kmh)
    drive = drive_of(vehicles, mode, mass_t, top_mps)
    brakes = brakes_of(node)
    traction = drive.traction or _own_effort(node.children("trainEngine"), "tractiveEffort", top_mps)
    braking = drive.braking or _own_effort(node.children("trainBrakes"), "brakeEffort", top_mps)
    if not traction:
        raise node.bad("no vehicle has a tractiveEffort table, nor maxTractEffort and power")
    resistance = _resistance(node, vehicles, mass_t, top_mps)
    rates, rate_notes = braking_rates(node, brakes, top_mps)
    acceleration_mps2 = _acceleration_mps2(node)
    name = _name(node)
    families = {one.node.text("id"): family_of(one.node) for one in vehicles}
    family_notes = [f"vehicle {one} is as {other} in what it does not say" for one, other in families.items() if other]
    notes = [*family_notes, *mass_notes, *length_notes, *speed_notes, *drive.notes, *resistance.notes, *rate_notes]
    notes += _effort_notes(traction, top_mps)
    if count > 1:
        notes.append(f"formationCount {count}: the train is {count} such formations, resistance and all")
    if not rates and not braking:
        notes.append("no brakeEffort table, no meanDeceleration nor maxDeceleration: this train has no brake")
    read = {one.element: one for one in (node, *(one.node for one in vehicles))}.values()
    for designator in (designator for one in read for designator in one.children("designator")):
        designator.dismiss()
    notes += unused_notes([unused for one in read for unused in one.unused()])
    try:
        train = Train(
            name=name,
            mass_kg=count * mass_t * KILO,
            rotating_mass_factor=1.0 + drive.rotating_t / mass_t,
            length_m=count * length_m,
            traction=total_effort([one.times(count) for one in traction], top_mps),
            braking=_braking([one.times(count) for one in braking], top_mps),
            braking_rates=rates,
            davis_a_n=count * resistance.a_n,
            davis_b_n_per_mps=count * resistance.b_n_per_mps,
            davis_c_n_per_mps2=count * resistance.c_n_per_mps2,
            max_speed_mps=top_mps,
            max_acceleration_mps2=acceleration_mps2,
            traction_efficiency=drive.efficiency,
            regeneration_efficiency=drive.regeneration if braking else 0.0,
            auxiliary_power_w=count * drive.auxiliary_w,
            notes=tuple(dict.fromkeys(notes)),
        )
    except InputError as error:
        raise node.bad(str(error)) from None
    lines = dict.fromkeys(("mass_kg", "max_speed_mps", "length_m", "rotating_mass_factor"), node.line)
    lines |= dict.fromkeys(("davis_a_n", "davis_c_n_per_mps2", "resistance"), resistance.line)
    lines |= dict.fromkeys(("traction", "traction_efficiency"), traction[0].line)
    return train, lines | {"braking_rates": brakes[0].line if brakes else node.line}


def _name(node: Node) -> str:
    names = [node.text("name"), *(one.text("name") for one in node.children("name"))]
    names += [one.text("entry") for one in node.children("designator")]
    return next((name for name in names if name), None) or node.text("id") or node.name


def _vehicles(root: Node, train: Node) -> list[Vehicles]:
    """Vehicles of a formation with their numbers, none where it describes itself; a vehicle is its own only one."""
    stock = [node for name in _STOCK for node in root.children(name)]
    known = {one.text("id"): one for node in stock for one in node.below("vehicles", "vehicle")}
    if train.name == "vehicle":
        return [Vehicles(whole(train, known), 1)]
    # A vehicle is named by an element below trainOrder in 2.x, by an attribute of it in 3.x.
    refs = [ref for order in train.children("trainOrder") for ref in order.children("vehicleRef") or [order]]
    found = []
    made: dict[str, Node] = {}
    for ref in refs:
        name = ref.required_text("vehicleRef")
        if name not in known:
            raise ref.bad(f"no vehicle {shown(name)} in this file", "vehicleRef")
        if name not in made:
            made[name] = whole(known[name], known)
        found.append(Vehicles(made[name], _count(ref, "vehicleCount", "vehicles")))
    return found


def _count(node: Node, attribute: str, what: str) -> int:
    """How many there are of something, one where nothing is said."""
    count = node.number(attribute, what, at_least=1.0) or 1.0
    if count != int(count) or count > _MOST_VEHICLES:
        raise node.bad(f"must be a whole number of 1 to {_MOST_VEHICLES} {what}, got {count:g}", attribute)
    return int(count)


def _mass_t(train: Node, vehicles: list[Vehicles]) -> tuple[float, list[str]]:
    """Gross mass, of the train or else the sum of its vehicles, t; an empty one where there is no other, and a note."""
    own = mass_of(train)
    if own is None and not vehicles:
        raise train.bad(f"missing attribute (t), and so is tareWeight{_NO_VEHICLES}", "bruttoWeight")
    masses = [] if own is None else [own]
    for one in vehicles if own is None else ():
        mass = mass_of(one.node)
        if mass is None:
            raise one.node.bad("missing attribute (t), and so is tareWeight", "bruttoWeight")
        masses.append(mass._replace(mass_t=one.number * mass.mass_t))
    empty = any(mass.empty for mass in masses)
    note = "tareWeight counts where there is no bruttoWeight: the train, or a part of it, is without load"
    return sum(mass.mass_t for mass in masses), [note] if empty else []


def _length_m(train: Node, vehicles: list[Vehicles]) -> tuple[float, list[str]]:
    """Length of the train, or else of its vehicles, m; a note where there are none of these either."""
    own_m = train.number("length", "m", at_least=0.0)
    if own_m is not None:
        return own_m, []
    length_m = sum(one.number * one.node.required_number("length", "m", at_least=0.0) for one in vehicles)
    return length_m, [] if vehicles else [f"no length{_NO_VEHICLES}: taken as 0 m"]


def _speed_kmh(train: Node, vehicles: list[Vehicles]) -> tuple[float, list[str]]:
    """Top speed of the train, or else of its slowest vehicle, km/h; a note where it is above the latter."""
    own_kmh = train.number("speed", "km/h", above=0.0)
    if own_kmh is None and not vehicles:
        raise train.bad(f"missing attribute (km/h){_NO_VEHICLES}", "speed")
    if own_kmh is None:
        return min(one.node.required_number("speed", "km/h", above=0.0) for one in vehicles), []
    given_kmh = [one.node.number("speed", "km/h", above=0.0) for one in vehicles]
    slowest_kmh = min((speed_kmh for speed_kmh in given_kmh if speed_kmh is not None), default=own_kmh)
    note = f"speed of the formation, {own_kmh:g} km/h, is above that of a vehicle, {slowest_kmh:g} km/h"
    return own_kmh, [note] if slowest_kmh < own_kmh else []


def _resistance(train: Node, vehicles: list[Vehicles], mass_t: float, top_mps: float) -> Resistance:
    """Resistance of the train, or else the sum of its vehicles'."""
    own = train.child("trainResistance", "drivingResistance")
    if own is not None:
        return resistance_of(own, mass_t * GRAVITY_MPS2, top_mps)
    if not vehicles:
        raise train.bad(f"missing element trainResistance{_NO_VEHICLES}")
    parts = []
    for one in vehicles:
        given = one.node.child("drivingResistance")
        if given is None:
            raise train.bad("missing element trainResistance, and not every vehicle has a drivingResistance")
        mass = mass_of(one.node)
        part = resistance_of(given, None if mass is None else mass.mass_t * GRAVITY_MPS2, top_mps)
        parts.append(part.times(one.number))
    return Resistance(
        a_n=sum(one.a_n for one in parts),
        b_n_per_mps=sum(one.b_n_per_mps for one in parts),
        c_n_per_mps2=sum(one.c_n_per_mps2 for one in parts),
        line=parts[0].line,
        notes=tuple(dict.fromkeys(note for one in parts for note in one.notes)),
    )


def _braking(efforts: list[Effort], top_mps: float) -> EffortCurve:
    return total_effort(efforts, top_mps) if efforts else EffortCurve.from_caps(0.0)


def _own_effort(boxes: list[Node], element: str, top_mps: float) -> list[Effort]:
    """Effort of a formation as a whole, which counts where its vehicles have none."""
    holders = [one for box in boxes for one in box.children("tractionMode") or [box]]
    found = [effort for one in holders for effort in [effort_of(one, element, top_mps)] if effort is not None]
    if len(found) > 1:
        raise boxes[-1].bad(f"a second {element} table; one is expected")
    return found


def _acceleration_mps2(train: Node) -> float:
    """Largest acceleration (``train…`` in 2.x); the least of several, without limit where there is none."""
    names = ("maxAcceleration", "trainMaxAcceleration")
    engines = train.children("trainEngine")
    given_mps2 = [one.number(name, "m/s²", above=0.0) for one in engines for name in names]
    return min((value_mps2 for value_mps2 in given_mps2 if value_mps2 is not None), default=math.inf)


def _effort_notes(efforts: list[Effort], top_mps: float) -> list[str]:
    ends_mps = [effort.points[-1][0] for effort in efforts if not effort.power_w]
    if any(end_mps < top_mps for end_mps in ends_mps):
        return [f"effort tables end at {mps_to_kmh(min(ends_mps)):.6g} km/h: constant from there to the top speed"]
    return []
