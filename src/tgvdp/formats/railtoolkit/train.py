"""A railtoolkit formation of vehicles as one train, as TrainRuns.jl makes it, which is the format's reference.

The resistance is a share of the weight, in ‰, g = 9.80665 m/s², V in km/h (Wende, Fahrdynamik des Schienenverkehrs,
2003, pp. 151 and 153; TrainRuns.jl, src/constructors.jl and src/formulary.jl):

    traction unit, multiple unit  base·m_driven + roll·m_carrying + air·m·((V + 15)/100)²     empty mass
    cars of a passenger train     m·(base + roll·V/100 + air·((V + 15)/100)²)                 loaded mass
    cars of a freight train       m·(base + air·(V/100)²)                                     loaded mass

where 15 km/h is the wind, and the coefficients of the cars are the mean over all cars, light or heavy. Expanded in v
these are the train's Davis coefficients, exactly. What accelerates and climbs is the loaded mass; its factor of
rotating mass is the mean over empty masses. The first powered vehicle alone drives and brakes the train.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import fmean
from typing import Annotated, Any

from msgspec import UNSET, Meta, Struct, UnsetType

from tgvdp.constants import STANDARD_GRAVITY_MPS2
from tgvdp.formats.syntax.reading import bad, errors_named, shown
from tgvdp.formats.syntax.typed import NotNegative, Positive, suggestion
from tgvdp.model.effort import EffortCurve
from tgvdp.model.train import BrakingRate, Train
from tgvdp.units import KILO, kmh_to_mps, mps_to_kmh, per_kmh_to_per_mps

POWERED = ("traction unit", "multiple unit")
PASSENGER = ("passenger", "passenger car")
FREIGHT = ("freight", "freight car")

#: What TrainRuns.jl takes where a file says nothing: decelerations, m/s²; factors of rotating mass; the coefficient of
#: friction that limits the effort of the driven mass; top speed, m/s.
PASSENGER_BRAKING_MPS2 = 0.375
FREIGHT_BRAKING_MPS2 = 0.225
POWERED_ROTATION = 1.09
CAR_ROTATION = 1.06
FRICTION = 0.2
TOP_SPEED_MPS = 140.0

_WIND_KMH = 15.0
_REFERENCE_KMH = 100.0


class Vehicle(Struct):
    """One vehicle: masses in t, lengths in m, speeds in km/h, resistances in ‰, effort in N over km/h."""

    id: str | int
    vehicle_type: str
    length: NotNegative
    mass: Positive
    base_resistance: NotNegative = 0.0
    air_resistance: NotNegative = 0.0
    rolling_resistance: NotNegative = 0.0
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
    def is_powered(self) -> bool:
        """Whether it can drive a train."""
        return self.vehicle_type in POWERED

    @property
    def rotation(self) -> float:
        """Factor of rotating mass."""
        return self.rotation_mass or (POWERED_ROTATION if self.is_powered else CAR_ROTATION)

    @property
    def driven_t(self) -> float:
        """Mass on driven axles; without `mass_traction` all axles of a powered vehicle are driven."""
        return self.mass if self.mass_traction is UNSET else self.mass_traction


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
        When a vehicle is unknown, of an unknown type, or holds what its type cannot have, or when none is powered.
    """
    given = stock.trains[index]
    place = f"trains[{index}]"
    vehicles = list(_vehicles(path, place, stock, given))
    powered = [one for one in vehicles if one.is_powered]
    if not powered:
        raise bad(path, f"{place}.formation: holds no vehicle of type {' or '.join(POWERED)}")
    leading = powered[0]
    freight = all(one.vehicle_type not in (*PASSENGER, "multiple unit") for one in vehicles)
    usual_mps2 = FREIGHT_BRAKING_MPS2 if freight else PASSENGER_BRAKING_MPS2
    braking_mps2 = usual_mps2 if leading.a_braking is UNSET else -leading.a_braking
    limits_mps = [kmh_to_mps(one.speed_limit) for one in vehicles if one.speed_limit is not UNSET]
    empty_t = sum(one.mass for one in vehicles)
    parts = [*map(_powered_davis, powered), _cars_davis([one for one in vehicles if not one.is_powered], freight)]
    a_n, b_n_per_kmh, c_n_per_kmh2 = (sum(terms) for terms in zip(*parts, strict=True))
    return Train(
        name=str(given.id),
        mass_kg=(empty_t + sum(one.load_limit for one in vehicles)) * KILO,
        rotating_mass_factor=sum(one.rotation * one.mass for one in vehicles) / empty_t,
        length_m=sum(one.length for one in vehicles),
        max_speed_mps=min([TOP_SPEED_MPS, *limits_mps]),
        traction=_traction(leading),
        braking_rates=(BrakingRate(0.0, braking_mps2),),
        davis_a_n=a_n,
        davis_b_n_per_mps=per_kmh_to_per_mps(b_n_per_kmh, 1),
        davis_c_n_per_mps2=per_kmh_to_per_mps(c_n_per_kmh2, 2),
        notes=(*_notes(given, vehicles, leading, usual_mps2), *notes),
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
    for name in ("tractive_effort", "mass_traction"):
        if not vehicle.is_powered and getattr(vehicle, name) is not UNSET:
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


def _powered_davis(vehicle: Vehicle) -> tuple[float, float, float]:
    """Resistance of a powered vehicle as N, N/(km/h), N/(km/h)²."""
    axles = vehicle.base_resistance * vehicle.driven_t + vehicle.rolling_resistance * (vehicle.mass - vehicle.driven_t)
    return _davis(vehicle.mass, axles / vehicle.mass, 0.0, vehicle.air_resistance, _WIND_KMH)


def _cars_davis(cars: Sequence[Vehicle], freight: bool) -> tuple[float, float, float]:
    """Resistance of all cars together as N, N/(km/h), N/(km/h)²."""
    if not cars:
        return 0.0, 0.0, 0.0
    base, roll, air = (fmean(getattr(one, f"{name}_resistance") for one in cars) for name in ("base", "rolling", "air"))
    loaded_t = sum(one.mass + one.load_limit for one in cars)
    return _davis(loaded_t, base, 0.0 if freight else roll, air, 0.0 if freight else _WIND_KMH)


def _davis(mass_t: float, base: float, roll: float, air: float, wind_kmh: float) -> tuple[float, float, float]:
    """Expand ``m·g·(base + roll·V/100 + air·((V + wind)/100)²)``, coefficients in ‰: N, N/(km/h), N/(km/h)²."""
    per_permil_n = mass_t * STANDARD_GRAVITY_MPS2
    by_square = air / _REFERENCE_KMH**2
    return (
        per_permil_n * (base + by_square * wind_kmh**2),
        per_permil_n * (roll / _REFERENCE_KMH + by_square * 2.0 * wind_kmh),
        per_permil_n * by_square,
    )


def _traction(vehicle: Vehicle) -> EffortCurve:
    if vehicle.tractive_effort is UNSET:
        return EffortCurve.from_caps(FRICTION * STANDARD_GRAVITY_MPS2 * vehicle.driven_t * KILO)
    return EffortCurve.from_points([(kmh_to_mps(kmh), effort_n) for kmh, effort_n in vehicle.tractive_effort])


def _notes(given: Formation, vehicles: Sequence[Vehicle], leading: Vehicle, usual_mps2: float) -> Iterator[str]:
    title = "" if given.name is UNSET else f"{given.name}: "
    yield title + _counted(vehicles)
    load_t = sum(one.load_limit for one in vehicles)
    if load_t:
        yield f"mass is with the full load of {load_t:.6g} t"
    hauled = [one for one in vehicles if one.is_powered]
    hauled.remove(leading)
    if hauled:
        yield f"driven by one {leading.id} alone, as TrainRuns.jl does; hauled without traction: {_counted(hauled)}"
    powered = [one for one in vehicles if one.is_powered]
    absent = (
        ("rotation_mass", vehicles, f"{POWERED_ROTATION:g} of powered vehicles, {CAR_ROTATION:g} of cars"),
        ("mass_traction", powered, "the whole mass"),
        ("tractive_effort", [leading], f"{FRICTION:g} of the weight on driven axles"),
        ("a_braking", [leading], f"{-usual_mps2:g} m/s²"),
    )
    for field, owners, meaning in absent:
        lacking = [one for one in owners if getattr(one, field) is UNSET]
        if lacking:
            yield f"{field} is absent, taken as {meaning}: {', '.join(dict.fromkeys(str(one.id) for one in lacking))}"
    if any(not one.base_resistance for one in vehicles):
        yield f"base_resistance is 0 ‰: {_counted([one for one in vehicles if not one.base_resistance])}"
    if all(one.speed_limit is UNSET for one in vehicles):
        yield f"speed_limit is absent, taken as {mps_to_kmh(TOP_SPEED_MPS):g} km/h"


def _counted(vehicles: Sequence[Vehicle]) -> str:
    return ", ".join(f"{count} × {name}" for name, count in Counter(str(one.id) for one in vehicles).items())
