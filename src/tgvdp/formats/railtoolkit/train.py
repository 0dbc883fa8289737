"""A railtoolkit formation of vehicles as one train.

Each vehicle resists with a share of its weight, in ‰, g = 9.80665 m/s², V in km/h (Wende, Fahrdynamik des
Schienenverkehrs, 2003, p. 151; TrainRuns.jl):

    traction unit, multiple unit  base·m_driven + roll·m_carrying + air·m·((V + 15)/100)²     empty masses
    passenger car                 m·(base + roll·V/100 + air·((V + 15)/100)²)                 loaded mass
    freight car                   m·(base + air·(V/100)²)                                     loaded mass

where 15 km/h is the wind. Expanded in v these are the train's Davis coefficients, exactly. What accelerates and climbs
is the loaded mass; each loaded mass carries its own share of rotating mass.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

from msgspec import UNSET, Meta, Struct, UnsetType

from tgvdp.constants import STANDARD_GRAVITY_MPS2
from tgvdp.formats.syntax.reading import bad, errors_named, shown
from tgvdp.formats.syntax.typed import suggestion
from tgvdp.model.effort import EffortCurve, EffortPiece
from tgvdp.model.train import BrakingRate, Train
from tgvdp.units import KILO, kmh_to_mps, per_kmh_to_per_mps

POWERED = ("traction unit", "multiple unit")
PASSENGER = ("passenger", "passenger car")
FREIGHT = ("freight", "freight car")

#: Decelerations where no vehicle gives one, m/s² (TrainRuns.jl).
PASSENGER_BRAKING_MPS2 = 0.375
FREIGHT_BRAKING_MPS2 = 0.225

_WIND_KMH = 15.0
_REFERENCE_KMH = 100.0

Positive = Annotated[float, Meta(gt=0.0)]
NotNegative = Annotated[float, Meta(ge=0.0)]


class Vehicle(Struct):
    """One vehicle: masses in t, lengths in m, speeds in km/h, resistances in ‰, effort in N over km/h."""

    id: str | int
    vehicle_type: str
    length: NotNegative
    mass: Positive
    base_resistance: NotNegative
    air_resistance: NotNegative
    rolling_resistance: NotNegative | UnsetType = UNSET
    rotation_mass: Annotated[float, Meta(ge=1.0)] | UnsetType = UNSET
    load_limit: NotNegative = 0.0
    mass_traction: NotNegative | UnsetType = UNSET
    speed_limit: Positive | UnsetType = UNSET
    a_braking: Annotated[float, Meta(lt=0.0)] | UnsetType = UNSET
    tractive_effort: Annotated[list[tuple[NotNegative, NotNegative]], Meta(min_length=1)] | UnsetType = UNSET
    name: Any = UNSET
    UUID: Any = UNSET
    picture: Any = UNSET
    power_type: Any = UNSET

    @property
    def loaded_kg(self) -> float:
        """Mass with its load."""
        return (self.mass + self.load_limit) * KILO


class Formation(Struct):
    """A train: the identifiers of its vehicles, in order, each as often as it runs in it."""

    id: str | int
    formation: Annotated[list[str | int], Meta(min_length=1)]
    name: str | int | UnsetType = UNSET
    UUID: Any = UNSET


class RollingStock(Struct):
    """A rolling-stock file."""

    trains: Annotated[list[Formation], Meta(min_length=1)]
    vehicles: list[Vehicle]
    schema: str = ""
    schema_version: str | float = "2022.05"


def train_of(path: Path, stock: RollingStock, index: int, notes: tuple[str, ...]) -> Train:
    """Make one train of a rolling-stock file.

    Raises
    ------
    InputError
        When a vehicle is unknown, of an unknown type, or lacks what its type needs, or when no vehicle has traction.
    """
    given = stock.trains[index]
    place = f"trains[{index}]"
    vehicles = list(_vehicles(path, place, stock, given))
    limits_kmh = [one.speed_limit for one in vehicles if one.speed_limit is not UNSET]
    if not limits_kmh:
        raise bad(path, f"{place}: no vehicle of its formation has a speed_limit")
    mass_kg = sum(one.loaded_kg for one in vehicles)
    rotating_kg = sum(one.loaded_kg * (one.rotation_mass or 1.0) for one in vehicles)
    a_n, b_n_per_kmh, c_n_per_kmh2 = (sum(terms) for terms in zip(*map(_davis, vehicles), strict=True))
    braking_mps2, braking_note = _braking(vehicles)
    return Train(
        name=str(given.id),
        mass_kg=mass_kg,
        rotating_mass_factor=rotating_kg / mass_kg,
        length_m=sum(one.length for one in vehicles),
        max_speed_mps=kmh_to_mps(min(limits_kmh)),
        traction=_traction(path, place, vehicles),
        braking_rates=(BrakingRate(0.0, braking_mps2),),
        davis_a_n=a_n,
        davis_b_n_per_mps=per_kmh_to_per_mps(b_n_per_kmh, 1),
        davis_c_n_per_mps2=per_kmh_to_per_mps(c_n_per_kmh2, 2),
        notes=(*_notes(given, vehicles), *braking_note, *notes),
    )


def _vehicles(path: Path, place: str, stock: RollingStock, given: Formation) -> Iterator[Vehicle]:
    """The vehicles of a formation, checked."""
    by_id: dict[str, Vehicle] = {}
    for index, vehicle in enumerate(stock.vehicles):
        if str(vehicle.id) in by_id:
            raise bad(path, f"vehicles[{index}].id: {shown(vehicle.id)} is given twice")
        _check(path, f"vehicles[{index}]", vehicle)
        by_id[str(vehicle.id)] = vehicle
    for index, name in enumerate(given.formation):
        if str(name) not in by_id:
            hint = suggestion(str(name), list(by_id))
            raise bad(path, f"{place}.formation[{index}]: unknown vehicle {shown(name)}{hint:.200}")
        yield by_id[str(name)]


def _check(path: Path, place: str, vehicle: Vehicle) -> None:
    """Check what depends on the type of the vehicle."""
    known = (*POWERED, *PASSENGER, *FREIGHT)
    if vehicle.vehicle_type not in known:
        hint = suggestion(vehicle.vehicle_type, known)
        raise bad(path, f"{place}.vehicle_type: unknown type {shown(vehicle.vehicle_type)}{hint}")
    powered = vehicle.vehicle_type in POWERED
    needed = {
        "rolling_resistance": vehicle.vehicle_type not in FREIGHT,
        "tractive_effort": powered,
    }
    for name, is_needed in needed.items():
        if is_needed and getattr(vehicle, name) is UNSET:
            raise bad(path, f"{place}: missing field {name!r}, which a {vehicle.vehicle_type} needs")
    for name in ("tractive_effort", "mass_traction"):
        if not powered and getattr(vehicle, name) is not UNSET:
            raise bad(path, f"{place}.{name}: a {vehicle.vehicle_type} vehicle has no traction")
    if vehicle.tractive_effort is not UNSET:
        with errors_named(path, f"{place}.tractive_effort"):
            EffortCurve.from_points(vehicle.tractive_effort)
    if vehicle.mass_traction is not UNSET and vehicle.mass_traction > vehicle.mass:
        raise bad(
            path,
            f"{place}.mass_traction: must be at most the mass, {vehicle.mass:.12g} t, "
            f"got {vehicle.mass_traction:.12g} t",
        )


def _davis(vehicle: Vehicle) -> tuple[float, float, float]:
    """Resistance of a vehicle as N, N/(km/h), N/(km/h)²."""
    roll = vehicle.rolling_resistance or 0.0
    base, air = vehicle.base_resistance, vehicle.air_resistance
    wind_kmh = 0.0 if vehicle.vehicle_type in FREIGHT else _WIND_KMH
    if vehicle.vehicle_type in POWERED:
        mass_kg = vehicle.mass * KILO
        driven = 1.0 if vehicle.mass_traction is UNSET else vehicle.mass_traction / vehicle.mass
        still, by_speed = base * driven + roll * (1.0 - driven), 0.0
    else:
        mass_kg = vehicle.loaded_kg
        still, by_speed = base, 0.0 if vehicle.vehicle_type in FREIGHT else roll / _REFERENCE_KMH
    per_permil_n = mass_kg * STANDARD_GRAVITY_MPS2 / KILO
    by_square = air / _REFERENCE_KMH**2
    return (
        per_permil_n * (still + by_square * wind_kmh**2),
        per_permil_n * (by_speed + by_square * 2.0 * wind_kmh),
        per_permil_n * by_square,
    )


def _traction(path: Path, place: str, vehicles: Sequence[Vehicle]) -> EffortCurve:
    """Sum of the effort curves of all vehicles: piece by piece, so that jumps stay jumps."""
    curves = [
        EffortCurve.from_points([(kmh_to_mps(kmh), effort_n) for kmh, effort_n in vehicle.tractive_effort])
        for vehicle in vehicles
        if vehicle.tractive_effort is not UNSET
    ]
    if not curves:
        raise bad(path, f"{place}.formation: holds no vehicle with tractive_effort")
    starts_mps = sorted({piece.from_mps for curve in curves for piece in curve.pieces})
    return EffortCurve(tuple(_sum_at(curves, from_mps) for from_mps in starts_mps))


def _sum_at(curves: Sequence[EffortCurve], from_mps: float) -> EffortPiece:
    active = [max(piece for piece in curve.pieces if piece.from_mps <= from_mps) for curve in curves]
    return EffortPiece(from_mps, c0_n=sum(piece.c0_n for piece in active), c1=sum(piece.c1 for piece in active))


def _braking(vehicles: Sequence[Vehicle]) -> tuple[float, tuple[str, ...]]:
    """Deceleration of full braking: the least of the vehicles', or the usual one, and a note on that."""
    given_mps2 = [-one.a_braking for one in vehicles if one.a_braking is not UNSET]
    if given_mps2:
        return min(given_mps2), ()
    freight = any(one.vehicle_type in FREIGHT for one in vehicles)
    usual_mps2 = FREIGHT_BRAKING_MPS2 if freight else PASSENGER_BRAKING_MPS2
    kind = "freight" if freight else "passenger"
    return usual_mps2, (f"a_braking is absent, taken as {-usual_mps2:g} m/s², as of a {kind} train",)


def _notes(given: Formation, vehicles: Sequence[Vehicle]) -> Iterator[str]:
    names = dict.fromkeys(str(one.id) for one in vehicles)
    counts = [f"{sum(str(one.id) == name for one in vehicles)} × {name}" for name in names]
    title = "" if given.name is UNSET else f"{given.name}: "
    yield f"{title}{', '.join(counts)}"
    load_t = sum(one.load_limit for one in vehicles)
    if load_t:
        yield f"mass is with the full load of {load_t:.6g} t"
    for field, meaning in (("rotation_mass", "1"), ("mass_traction", "the whole mass")):
        lacking = dict.fromkeys(
            str(one.id)
            for one in vehicles
            if getattr(one, field) is UNSET and (field != "mass_traction" or one.vehicle_type in POWERED)
        )
        if lacking:
            yield f"{field} is absent, taken as {meaning}: {', '.join(lacking)}"
