"""TTOBench tracks, trains and journeys (JSON, library versions 1.1 to 1.5; Kouzoupis et al., BSD-2-Clause).

Every field names its unit, and every unit is read. Entries of a track hold until the next one; the last stop is the
length of the track. Read but not used yet: ETCS braking data, tunnel resistance, numbers of seats and coaches.
"""

import math
from collections.abc import Callable, Collection, Iterator
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

from msgspec import UNSET, Struct, UnsetType, field

from tgvdp.formats.content import Content, Item, Kind
from tgvdp.formats.reading import Document, bad, errors_named, shown
from tgvdp.formats.ttobench_journey import read_journey
from tgvdp.formats.typed import decode
from tgvdp.model.effort import EffortCurve
from tgvdp.model.journey import Journey
from tgvdp.model.track import Curve, Gradient, SpeedLimit, Track, Tunnel
from tgvdp.model.train import Train
from tgvdp.units import to_si

_STRAIGHT = "infinity"
_FEWEST_STOPS = 2
_MOST_ROTATING_MASS = 0.5  # a locomotive has about 0.3; more is a slip of unit


def _spaced(name: str) -> str:
    return name.replace("_", " ")


class _Metadata(Struct, rename=_spaced):
    """The README requires these two; other keys are free text."""

    id: str
    library_version: str


class _Quantity(Struct, forbid_unknown_fields=True):
    unit: str
    value: float


class _Stops(Struct, forbid_unknown_fields=True):
    unit: str
    values: list[float]


class _LimitUnits(Struct, forbid_unknown_fields=True):
    position: str
    velocity: str


class _Limits(Struct, forbid_unknown_fields=True):
    units: _LimitUnits
    values: list[tuple[float, float]]


class _GradientUnits(Struct, forbid_unknown_fields=True):
    position: str
    slope: str


class _Gradients(Struct, forbid_unknown_fields=True):
    units: _GradientUnits
    values: list[tuple[float, float]]


class _CurveUnits(Struct, forbid_unknown_fields=True, rename=_spaced):
    position: str
    radius_at_start: str
    radius_at_end: str


class _Curves(Struct, forbid_unknown_fields=True):
    units: _CurveUnits
    values: list[tuple[float, float | str, float | str]]


class _TunnelUnits(Struct, forbid_unknown_fields=True, rename=_spaced):
    position: str
    length: str
    cross_section: str


class _Tunnels(Struct, forbid_unknown_fields=True):
    units: _TunnelUnits
    values: list[tuple[float, float, float]]


class _TrackFile(Struct, forbid_unknown_fields=True, rename=_spaced):
    metadata: _Metadata
    stops: _Stops
    speed_limits: _Limits
    altitude: _Quantity | UnsetType = UNSET
    gradients: _Gradients | UnsetType = UNSET
    curvatures: _Curves | UnsetType = UNSET
    tunnels: _Tunnels | UnsetType = UNSET
    etcs_braking_data: Any = field(default=UNSET, name="ETCS braking data")


class _TrainFile(Struct, forbid_unknown_fields=True, rename=_spaced):
    metadata: _Metadata
    mass: _Quantity
    max_traction_power: _Quantity
    max_reg_braking_power: _Quantity
    max_traction_force: _Quantity
    max_reg_braking_force: _Quantity
    max_speed: _Quantity
    rolling_resistance_r0: _Quantity
    rolling_resistance_r1: _Quantity
    rolling_resistance_r2: _Quantity
    length: _Quantity | UnsetType = UNSET
    rho: _Quantity | UnsetType = UNSET
    max_pn_braking_force: _Quantity | UnsetType = UNSET
    max_acceleration: _Quantity | UnsetType = UNSET
    max_deceleration: _Quantity | UnsetType = UNSET
    efficiency_traction: _Quantity | UnsetType = UNSET
    efficiency_reg_brake: _Quantity | UnsetType = UNSET
    num_seats: Any = UNSET
    num_coaches: Any = UNSET
    tunnel_resistance: Any = UNSET
    etcs_braking_data: Any = field(default=UNSET, name="ETCS braking data")


#: Fields by which content is recognised; metadata is common to all three kinds.
_TRACK_FIELDS = frozenset(_TrackFile.__struct_encode_fields__) - {"metadata", "ETCS braking data"}
_TRAIN_FIELDS = frozenset(_TrainFile.__struct_encode_fields__) - {"metadata", "ETCS braking data", "length"}
_JOURNEY_FIELDS = frozenset({"timing points"})
_ENOUGH_FIELDS = 2


def kind_of(fields: Collection[str]) -> Kind | None:
    """Tell by its fields which kind of TTOBench file this is; None when it is none.

    Without metadata one field alone is no proof: other formats have a mass as well.
    """
    if not _JOURNEY_FIELDS.isdisjoint(fields):
        return "journey"
    trains, tracks = len(_TRAIN_FIELDS.intersection(fields)), len(_TRACK_FIELDS.intersection(fields))
    if max(trains, tracks) < (1 if "metadata" in fields else _ENOUGH_FIELDS):
        return None
    return "train" if trains > tracks else "track"


def open_document(document: Document) -> Content | None:
    """Tell what a document holds; None when it is of another format."""
    readers: dict[Kind, Callable[[Document], Train | Track | Journey]] = {
        "train": read_train,
        "track": read_track,
        "journey": read_journey,
    }
    kind = kind_of(document.tree)
    if kind is None:
        return None
    item = Item(document.path.stem, partial(readers[kind], document))
    return Content(format="TTOBench", items={kind: (item,)})


def read_track(document: Document) -> Track:
    """Make a `Track` from a TTOBench track.

    Raises
    ------
    InputError
        When a field is missing, unknown, mistyped or out of range, or has an unknown unit.
    """
    path = document.path
    file = decode(path, document.tree, _TrackFile)
    unit = file.stops.unit
    stops_m = [_si(path, "stops.unit", stop, unit, "length") for stop in file.stops.values]
    if len(stops_m) < _FEWEST_STOPS or stops_m[0] != 0.0:
        raise bad(path, f"stops: must begin at 0 and end at the track's length, got {shown(file.stops.values)}")
    for index, (before, stop) in enumerate(pairwise(file.stops.values), start=1):
        if not stop > before:
            raise bad(path, f"stops.values[{index}]: must increase, got {stop:.12g} {unit} after {before:.12g} {unit}")
    with errors_named(path):
        return Track(
            name=file.metadata.id,
            length_m=stops_m[-1],
            stops_m=tuple(stops_m),
            speed_limits=tuple(_speed_limits(path, file.speed_limits)),
            gradients=tuple(_gradients(path, file.gradients)) if file.gradients else (),
            curves=tuple(_curves(path, file.curvatures)) if file.curvatures else (),
            tunnels=tuple(_tunnels(path, file.tunnels)) if file.tunnels else (),
            altitude_m=_number(path, "altitude", file.altitude, "length", default=0.0),
            notes=_unused(file, ("etcs_braking_data",)),
        )


def _speed_limits(path: Path, table: _Limits) -> Iterator[SpeedLimit]:
    for index, (position, speed) in enumerate(table.values):
        if not speed > 0.0:
            unit = table.units.velocity
            raise bad(path, f"speed limits.values[{index}]: velocity must be above 0 {unit}, got {speed:g} {unit}")
        yield SpeedLimit(
            _si(path, "speed limits.units.position", position, table.units.position, "length"),
            _si(path, "speed limits.units.velocity", speed, table.units.velocity, "speed"),
        )


def _gradients(path: Path, table: _Gradients) -> Iterator[Gradient]:
    for position, slope in table.values:
        yield Gradient(
            _si(path, "gradients.units.position", position, table.units.position, "length"),
            _si(path, "gradients.units.slope", slope, table.units.slope, "gradient"),
        )


def _curves(path: Path, table: _Curves) -> Iterator[Curve]:
    units = (table.units.radius_at_start, table.units.radius_at_end)
    for index, (position, *radii) in enumerate(table.values):
        radii_m = []
        for radius, unit, name in zip(radii, units, ("radius at start", "radius at end"), strict=True):
            if isinstance(radius, str) and radius != _STRAIGHT:
                raise bad(
                    path, f"curvatures.values[{index}]: {name} must be a number or {_STRAIGHT!r}, got {shown(radius)}"
                )
            radii_m.append(_si(path, f"curvatures.units.{name}", float(radius), unit, "length"))
        yield Curve(_si(path, "curvatures.units.position", position, table.units.position, "length"), *radii_m)


def _tunnels(path: Path, table: _Tunnels) -> Iterator[Tunnel]:
    for position, length, cross_section in table.values:
        yield Tunnel(
            _si(path, "tunnels.units.position", position, table.units.position, "length"),
            _si(path, "tunnels.units.length", length, table.units.length, "length"),
            _si(path, "tunnels.units.cross section", cross_section, table.units.cross_section, "area"),
        )


def read_train(document: Document) -> Train:
    """Make a `Train` from a TTOBench train, as published: known slips of the data are not repaired.

    Raises
    ------
    InputError
        When a field is missing, unknown, mistyped or out of range, or has an unknown unit.
    """
    path = document.path
    file = decode(path, document.tree, _TrainFile)

    def number(name: str, quantity: str, default: float = math.nan, *, zero_ok: bool = True) -> float:
        given: _Quantity | UnsetType = getattr(file, name)
        if given and (given.value < 0.0 or (given.value == 0.0 and not zero_ok)):
            bound = "at least" if zero_ok else "above"
            raise bad(path, f"{_spaced(name)}: must be {bound} 0 {given.unit}, got {given.value:g} {given.unit}")
        return _number(path, _spaced(name), given, quantity, default=default)

    braking_power_w = number("max_reg_braking_power", "power")
    braking_force_n = number("max_reg_braking_force", "force")
    with errors_named(path):
        return Train(
            name=file.metadata.id,
            mass_kg=number("mass", "mass", zero_ok=False),
            rotating_mass_factor=_rotating_mass_factor(path, file.rho),
            length_m=number("length", "length", 0.0),
            traction=EffortCurve.from_caps(
                number("max_traction_force", "force", zero_ok=False),
                number("max_traction_power", "power", zero_ok=False),
            ),
            # Without power the electric brake has no effort at any speed, whatever its force.
            braking=EffortCurve.from_caps(braking_force_n if braking_power_w else 0.0, braking_power_w),
            friction_brake_n=number("max_pn_braking_force", "force", 0.0),
            max_acceleration_mps2=number("max_acceleration", "acceleration", math.inf, zero_ok=False),
            max_deceleration_mps2=number("max_deceleration", "acceleration", math.inf, zero_ok=False),
            max_speed_mps=number("max_speed", "speed", zero_ok=False),
            davis_a_n=number("rolling_resistance_r0", "force"),
            davis_b_n_per_mps=number("rolling_resistance_r1", "force per speed"),
            davis_c_n_per_mps2=number("rolling_resistance_r2", "force per squared speed"),
            traction_efficiency=number("efficiency_traction", "ratio", 1.0, zero_ok=False),
            regeneration_efficiency=number("efficiency_reg_brake", "ratio", 0.0),
            notes=(*_unused(file, ("tunnel_resistance", "etcs_braking_data")), *_odd_efficiencies(file)),
        )


def _rotating_mass_factor(path: Path, rho: _Quantity | UnsetType) -> float:
    """Read rho, of which three spellings occur: 6 %, 0.06 and 1.06 all mean a factor of 1.06."""
    if not rho:
        return 1.0
    extra = _number(path, "rho", rho, "ratio")
    if rho.unit == "-" and extra >= 1.0:
        extra -= 1.0
    if not 0.0 <= extra <= _MOST_ROTATING_MASS:
        raise bad(path, f"rho: must be 0..50 %, or 0..0.5 or 1..1.5 without unit, got {rho.value:g} {rho.unit}")
    return 1.0 + extra


def _odd_efficiencies(file: _TrainFile) -> Iterator[str]:
    for name, given in (("traction", file.efficiency_traction), ("reg brake", file.efficiency_reg_brake)):
        if given and given.unit == "%" and 0.0 < given.value <= 1.0:
            yield f"efficiency {name} is {given.value:g} %, read as published: was {100 * given.value:g} % meant?"


def _unused(file: Struct, names: tuple[str, ...]) -> tuple[str, ...]:
    labels = dict(zip(file.__struct_fields__, file.__struct_encode_fields__, strict=True))
    return tuple(f"{labels[name]} is not used yet" for name in names if getattr(file, name) is not UNSET)


def _number(path: Path, name: str, given: _Quantity | UnsetType, quantity: str, *, default: float = math.nan) -> float:
    """Return a quantity in SI, or the default where an optional field is absent."""
    return _si(path, name, given.value, given.unit, quantity) if given else default


def _si(path: Path, place: str, value: float, unit: str, quantity: str) -> float:
    with errors_named(path, place):
        return to_si(value, unit, quantity)
