"""TTOBench trains; see `ttobench.reader`."""

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

from msgspec import UNSET, Meta, Struct, UnsetType, field

from tgvdp.formats.syntax.reading import Document, bad, errors_named
from tgvdp.formats.syntax.typed import NotNegative, Positive, decode
from tgvdp.formats.ttobench.fields import ETCS, Metadata, Quantity, number_si, rows_si, spaced
from tgvdp.model.effort import EffortCurve
from tgvdp.model.train import BrakingRate, Train, TunnelDrag
from tgvdp.units import SMALLEST_WRITTEN

_MOST_ROTATING_MASS = 0.5  # a locomotive has about 0.3; more is a slip of unit

#: Table of ETCS braking data, which a train brakes by where ``FILE#A_brake_service`` asks for it.
SERVICE_BRAKE = "A_brake_service"


class _TunnelUnits(Struct, forbid_unknown_fields=True, rename=spaced):
    cross_section: str
    coefficient: str


class _TunnelResistance(Struct, forbid_unknown_fields=True):
    units: _TunnelUnits
    values: list[tuple[float, float]]


class _BrakeUnits(Struct, forbid_unknown_fields=True):
    velocity: str
    deceleration: str


class _Brake(Struct, forbid_unknown_fields=True):
    """Deceleration by speed, each up to the next row's."""

    units: _BrakeUnits
    values: Annotated[list[tuple[NotNegative, Positive]], Meta(min_length=1)]


class _EtcsData(Struct, forbid_unknown_fields=True):
    """Two braking curves; correction factors, times and an uncertainty that nothing here uses."""

    A_brake_emergency: _Brake
    A_brake_service: _Brake
    K_dry_rst: Quantity
    K_wet_rst: Quantity
    T_traction: Quantity
    T_be: Quantity
    v_uncertainty: Quantity
    T_bs: Quantity | UnsetType = UNSET


class TrainFile(Struct, forbid_unknown_fields=True, rename=spaced):
    """Fields of a train."""

    metadata: Metadata
    mass: Quantity
    max_traction_power: Quantity
    max_reg_braking_power: Quantity
    max_traction_force: Quantity
    max_reg_braking_force: Quantity
    max_speed: Quantity
    rolling_resistance_r0: Quantity
    rolling_resistance_r1: Quantity
    rolling_resistance_r2: Quantity
    length: Quantity | UnsetType = UNSET
    rho: Quantity | UnsetType = UNSET
    max_pn_braking_force: Quantity | UnsetType = UNSET
    max_acceleration: Quantity | UnsetType = UNSET
    max_deceleration: Quantity | UnsetType = UNSET
    efficiency_traction: Quantity | UnsetType = UNSET
    efficiency_reg_brake: Quantity | UnsetType = UNSET
    num_seats: Any = UNSET
    num_coaches: Any = UNSET
    tunnel_resistance: _TunnelResistance | UnsetType = UNSET
    etcs_braking_data: _EtcsData | UnsetType = field(default=UNSET, name=ETCS)


def read_train(document: Document, brake: str = "") -> Train:
    """Make a `Train` from a TTOBench train, as published: known slips of the data are not repaired.

    Parameters
    ----------
    document : Document
    brake : {"", "A_brake_service"}
        Whether full braking is by the forces of the train or by that table of its ETCS data.

    Raises
    ------
    InputError
        When a field is missing, unknown, mistyped or out of range, or has an unknown unit.
    """
    path = document.path
    file = decode(path, document.tree, TrainFile)

    def number(name: str, quantity: str, default: float = math.nan, *, zero_ok: bool = True) -> float:
        given: Quantity | UnsetType = getattr(file, name)
        if given and (given.value < 0.0 or (given.value == 0.0 and not zero_ok)):
            bound = "at least" if zero_ok else "above"
            raise bad(path, f"{spaced(name)}: must be {bound} 0 {given.unit}, got {given.value:g} {given.unit}")
        if given and not zero_ok and given.value < SMALLEST_WRITTEN:
            least = f"{SMALLEST_WRITTEN:g} {given.unit}"
            raise bad(path, f"{spaced(name)}: must be at least {least}, got {given.value:g} {given.unit}")
        value = number_si(path, spaced(name), given, quantity, default=default)
        if given and quantity == "ratio" and value > 1.0:
            most = f"{100 if given.unit == '%' else 1} {given.unit}"
            raise bad(path, f"{spaced(name)}: must be at most {most}, got {given.value:g} {given.unit}")
        return value

    tunnels = file.tunnel_resistance
    drags = rows_si(path, "tunnel resistance", tunnels, "area", "force per squared speed") if tunnels else ()
    etcs = _braking_curves(path, file.etcs_braking_data) if file.etcs_braking_data else {}
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
            tunnel_drag=tuple(TunnelDrag(*row) for row in drags),
            braking_rates=etcs[brake] if brake else (),
            notes=(*_etcs_notes(etcs, brake), *_odd_efficiencies(file)),
        )


def _rotating_mass_factor(path: Path, rho: Quantity | UnsetType) -> float:
    """Read rho, of which three spellings occur: 6 %, 0.06 and 1.06 all mean a factor of 1.06."""
    if not rho:
        return 1.0
    extra = number_si(path, "rho", rho, "ratio")
    if rho.unit == "-" and extra >= 1.0:
        extra -= 1.0
    if not 0.0 <= extra <= _MOST_ROTATING_MASS:
        raise bad(path, f"rho: must be 0..50 %, or 0..0.5 or 1..1.5 without unit, got {rho.value:g} {rho.unit}")
    return 1.0 + extra


def _braking_curves(path: Path, data: _EtcsData) -> dict[str, tuple[BrakingRate, ...]]:
    """Both tables of ETCS braking data; that its other fields have known units is checked, and no more."""
    curves = {}
    for name in ("A_brake_emergency", SERVICE_BRAKE):
        table, place = getattr(data, name), f"{ETCS}.{name}"
        unit = table.units.velocity
        for index, ((before, _), (speed, _)) in enumerate(pairwise(table.values), start=1):
            if not speed > before:
                raise bad(
                    path,
                    f"{place}.values[{index}]: velocity must increase, got {speed:g} {unit} after {before:g} {unit}",
                )
        curves[name] = tuple(BrakingRate(*row) for row in rows_si(path, place, table, "speed", "acceleration"))
    for name in ("K_dry_rst", "K_wet_rst", "v_uncertainty"):
        number_si(path, f"{ETCS}.{name}", getattr(data, name), "ratio")
    for name in ("T_traction", "T_be", "T_bs"):
        number_si(path, f"{ETCS}.{name}", getattr(data, name), "time")
    return curves


def _etcs_notes(curves: dict[str, tuple[BrakingRate, ...]], brake: str) -> Iterator[str]:
    if brake:
        yield f"brakes by {brake} of {ETCS}, whatever gradient; the rest of it does not act"
    elif curves:
        yield f"{ETCS} does not act; FILE#{SERVICE_BRAKE} brakes by its service brake"


def _odd_efficiencies(file: TrainFile) -> Iterator[str]:
    for name, given in (("traction", file.efficiency_traction), ("reg brake", file.efficiency_reg_brake)):
        if given and given.unit == "%" and 0.0 < given.value <= 1.0:
            yield f"efficiency {name} is {given.value:g} %, read as published: was {100 * given.value:g} % meant?"
