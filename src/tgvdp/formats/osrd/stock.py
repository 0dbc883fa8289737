"""OSRD rolling stock (RailJSON 3.0 to 3.4), SI throughout.

Efforts are linear between points and constant after the last one; braking is exactly −γ, whatever gradient and
resistance, or in old files an effort of γ times the inertia beside both (type MAX); inertia is the mass times the
inertia coefficient, weight the plain mass.
Source: rolling-stock schema and documentation of the running-time calculation of OSRD (Open Rail Association).
"""

from functools import partial
from pathlib import Path
from typing import Annotated, Any

from msgspec import UNSET, Meta, Struct, UnsetType

from tgvdp.constants import GRAVITY_MPS2
from tgvdp.formats.content import Content, Item
from tgvdp.formats.syntax.reading import Document, bad, errors_named, shown
from tgvdp.formats.syntax.typed import NotNegative, Positive, decode, extensions, in_unit
from tgvdp.model.effort import EffortCurve
from tgvdp.model.train import BrakingRate, Train

VERSIONS = ("3.0", "3.1", "3.2", "3.3", "3.4")


#: Resistance was in N and is per kg since mid-2026. No train rolls with less than 1 N in all, or more than 0.2 N/kg
#: (20 daN/t); what lies between is a slip.
_LEAST_N = 1.0
_MOST_N_PER_KG = 0.2
#: Share of the weight that the constant part of resistance has in any train, ‰: wider than what is usual
#: (`tgvdp.formats.review.figures`).
_USUAL_PERMIL = (0.1, 15.0)


Metre = Annotated[NotNegative, in_unit("m")]
Kilogram = Annotated[Positive, in_unit("kg")]
Speed = Annotated[NotNegative, in_unit("m/s")]
TopSpeed = Annotated[Positive, in_unit("m/s")]
Deceleration = Annotated[Positive, in_unit("m/s²")]
Effort = Annotated[NotNegative, in_unit("N")]


class _Gamma(Struct):
    type: str
    value: Deceleration


class _Resistance(Struct):
    A: NotNegative
    B: NotNegative
    C: NotNegative
    type: str = "davis"


class _Curve(Struct):
    speeds: list[Speed]
    max_efforts: list[Effort]


class _Condition(Struct):
    comfort: str | None = None
    electrical_profile_level: str | None = None
    power_restriction_code: str | None = None


class _ConditionalCurve(Struct):
    curve: _Curve
    cond: _Condition | None = None


class _Mode(Struct):
    default_curve: _Curve
    curves: list[_ConditionalCurve] = []
    is_electric: bool = False


class _EffortCurves(Struct):
    modes: Annotated[dict[str, Any], Meta(min_length=1)]  # each is decoded as a _Mode
    default_mode: str


class _File(Struct):
    name: str
    length: Metre
    mass: Kilogram
    max_speed: TopSpeed
    inertia_coefficient: Annotated[float, Meta(ge=1.0)]
    rolling_resistance: _Resistance
    effort_curves: _EffortCurves
    railjson_version: str | UnsetType = UNSET
    gamma: _Gamma | UnsetType = UNSET
    const_gamma: Deceleration | UnsetType = UNSET
    comfort_acceleration: Any = UNSET
    startup_time: Any = UNSET
    startup_acceleration: Any = UNSET
    # What does not act on the train alone.
    id: Any = UNSET
    version: Any = UNSET
    locked: Any = UNSET
    loading_gauge: Any = UNSET
    base_power_class: Any = UNSET
    power_restrictions: Any = UNSET
    energy_sources: Any = UNSET
    supported_signaling_systems: Any = UNSET
    electrical_power_startup_time: Any = UNSET
    raise_pantograph_time: Any = UNSET
    etcs_brake_params: Any = UNSET
    power_class: Any = UNSET
    freight_compatible: Any = UNSET
    primary_category: Any = UNSET
    other_categories: Any = UNSET
    features: Any = UNSET
    metadata: Any = UNSET
    liveries: Any = UNSET


#: Fields that change a run in OSRD and not here.
_NOT_USED = (
    "comfort_acceleration",
    "startup_time",
    "startup_acceleration",
    "electrical_power_startup_time",
    "raise_pantograph_time",
    "power_restrictions",
    "energy_sources",
    "etcs_brake_params",
)


def open_document(document: Document) -> Content | None:
    """Tell what a document holds; None when it is of another format.

    Its items are one train with each traction mode, by the name of the mode.

    Raises
    ------
    InputError
        When a field is missing, mistyped or out of range.
    """
    tree, path = document.tree, document.path
    if "effort_curves" not in tree:
        return None
    field = "railjson_version" if "railjson_version" in tree else "version"  # as it was called until 2023
    if tree.get(field) not in VERSIONS:
        raise bad(path, f"{field}: must be one of {', '.join(VERSIONS)}, got {shown(tree.get(field))}")
    file = decode(path, tree, _File)
    efforts = file.effort_curves
    if efforts.default_mode not in efforts.modes:
        known = ", ".join(map(shown, efforts.modes))
        raise bad(path, f"effort_curves.default_mode: must be one of {known:.200}, got {shown(efforts.default_mode)}")
    modes = {name: decode(path, mode, _Mode, ("effort_curves", "modes", name)) for name, mode in efforts.modes.items()}
    more = {name: extensions(path, mode, _Mode) for name, mode in efforts.modes.items()}
    notes = extensions(path, tree, _File)
    items = tuple(
        Item(name, partial(_train, path, file, name, mode, (*notes, *more[name]))) for name, mode in modes.items()
    )
    return Content(format="OSRD", items={"train": items}, default=efforts.default_mode)


def _train(path: Path, file: _File, name: str, mode: _Mode, notes: tuple[str, ...]) -> Train:
    resistance, unit_note = _resistance(path, file)
    gamma_mps2, is_effort = _gamma(path, file)
    return Train(
        name=file.name,
        mass_kg=file.mass,
        rotating_mass_factor=file.inertia_coefficient,
        length_m=file.length,
        max_speed_mps=file.max_speed,
        traction=_effort(path, f"effort_curves.modes.{name}.default_curve", mode.default_curve),
        braking_rates=() if is_effort else (BrakingRate(0.0, gamma_mps2),),
        friction_brake_n=gamma_mps2 * file.mass * file.inertia_coefficient if is_effort else 0.0,
        davis_a_n=resistance[0],
        davis_b_n_per_mps=resistance[1],
        davis_c_n_per_mps2=resistance[2],
        notes=(unit_note, *_mode_notes(file.effort_curves, name, mode), *_unused_notes(file), *notes),
    )


def _resistance(path: Path, file: _File) -> tuple[tuple[float, float, float], str]:
    """Davis coefficients in N, N/(m/s), N/(m/s)², and which unit the file was taken to have."""
    given = file.rolling_resistance
    if given.type != "davis":
        raise bad(path, f"rolling_resistance.type: must be 'davis', got {shown(given.type)}")
    if given.A == given.B == given.C == 0.0:
        return (0.0, 0.0, 0.0), "the file gives no resistance: A, B and C are 0"
    if given.A > _LEAST_N:
        note = f"resistance is taken to be in N, as A is above 1{_doubt(given.A / file.mass)}"
        return (given.A, given.B, given.C), note
    if not 0.0 < given.A < _MOST_N_PER_KG:
        raise bad(
            path,
            f"rolling_resistance.A: neither above {_LEAST_N:g}, as it is in N, nor between 0 and {_MOST_N_PER_KG:g}, "
            f"as it is in N/kg, got {given.A:g}: give A, B and C in one of the two, or the train as a native file",
        )
    mass = file.mass
    note = f"resistance is taken to be in N/kg, as A is below 0.2{_doubt(given.A)}"
    return (given.A * mass, given.B * mass, given.C * mass), note


def _doubt(specific_n_per_kg: float) -> str:
    """Say how small or large a constant resistance is that no train has; some published files give a thousandth."""
    permil = 1000.0 * specific_n_per_kg / GRAVITY_MPS2
    low, high = _USUAL_PERMIL
    return "" if low <= permil <= high else f"; that is {permil:.2g} ‰ of the weight, not usual"


def _gamma(path: Path, file: _File) -> tuple[float, bool]:
    """Braking, m/s²: ``gamma`` until 3.2, ``const_gamma`` since 3.3; and whether it is an effort over the inertia."""
    if bool(file.gamma) == bool(file.const_gamma):
        held = "both" if file.gamma else "none"
        raise bad(path, f"must hold one of const_gamma (since 3.3) and gamma (3.2), got {held}")
    if not file.gamma:
        assert file.const_gamma is not UNSET
        return file.const_gamma, False
    if file.gamma.type not in ("CONST", "MAX"):
        raise bad(path, f"gamma.type: must be one of CONST, MAX, got {shown(file.gamma.type)}")
    return file.gamma.value, file.gamma.type == "MAX"


def _effort(path: Path, place: str, curve: _Curve) -> EffortCurve:
    if len(curve.speeds) != len(curve.max_efforts):
        counts = f"{len(curve.speeds)} speeds and {len(curve.max_efforts)} efforts"
        raise bad(path, f"{place}: must hold as many efforts as speeds, got {counts}")
    for index, speed_mps in enumerate(curve.speeds):
        if index and speed_mps < curve.speeds[index - 1]:
            speeds = f"{speed_mps:.12g} m/s after {curve.speeds[index - 1]:.12g} m/s"
            raise bad(path, f"{place}.speeds[{index}]: must not decrease, got {speeds}")
    if curve.speeds and curve.speeds[0] > 0.0:
        raise bad(path, f"{place}.speeds[0]: must be 0 m/s, got {curve.speeds[0]:.12g} m/s")
    with errors_named(path, place):
        return EffortCurve.from_points(zip(curve.speeds, curve.max_efforts, strict=True))


def _mode_notes(efforts: _EffortCurves, name: str, mode: _Mode) -> tuple[str, ...]:
    notes = []
    others = ", ".join(shown(other) for other in efforts.modes if other != name)
    if others:
        notes.append(f"traction is that of mode {shown(name)}; FILE#MODE takes another one of {others:.300}")
    count = len(mode.curves)
    if count:
        notes.append(
            f"traction is the mode's default curve; {count} more for comfort, electrical profile or power "
            "restriction are not used"
        )
    return tuple(notes)


def _unused_notes(file: _File) -> tuple[str, ...]:
    given = [name for name in _NOT_USED if getattr(file, name) not in (UNSET, None, [], {})]
    return (f"not used: {', '.join(given)}",) if given else ()
