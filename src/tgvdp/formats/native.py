"""The native format: a train, a track, an energy map and run options as TOML tables, or the same structure as JSON.

Each field has one unit, which its name ends in. See docs/formats.md for an example.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from msgspec import UNSET, Meta, Struct, UnsetType, structs

from tgvdp.constants import CONVENTION_NAMES, CURVE_FORMULAS, HEURISTICS, LIMIT_RULES, MASS_MODELS, METHODS
from tgvdp.formats.energy_map import MapSpec, make_map
from tgvdp.formats.reading import Document, bad, errors_named, shown
from tgvdp.formats.targets import parse_targets
from tgvdp.formats.typed import decode, suggestion
from tgvdp.model.adhesion import Adhesion
from tgvdp.model.checks import require_text
from tgvdp.model.effort import EffortCurve, EffortPiece
from tgvdp.model.energy import ENERGY_KINDS, EnergyMap
from tgvdp.model.track import Curve, Gradient, NeutralSection, SpeedLimit, Track, Tunnel
from tgvdp.model.train import BrakingRate, Train, TunnelDrag
from tgvdp.units import KILO, kmh_to_mps, per_kmh_to_per_mps

Positive = Annotated[float, Meta(gt=0.0)]
NotNegative = Annotated[float, Meta(ge=0.0)]
Count = Annotated[int, Meta(ge=1)]
Several = Annotated[int, Meta(ge=2)]

_STRAIGHT = "infinity"

#: Run options that are one of a few names.
_CHOICES = {
    "energy": ENERGY_KINDS,
    "convention": CONVENTION_NAMES,
    "mass_model": MASS_MODELS,
    "limits": LIMIT_RULES,
    "curves": CURVE_FORMULAS,
    "method": METHODS,
    "heuristic": HEURISTICS,
}


class _Point(Struct, forbid_unknown_fields=True):
    speed_kmh: NotNegative
    effort_kn: NotNegative


class _Polynomial(Struct, forbid_unknown_fields=True):
    """Effort in N = Σ coefficient[k] · V**k with V in km/h, from a speed up to the next polynomial's."""

    from_kmh: NotNegative
    coefficients_n_kmh: Annotated[list[float], Meta(min_length=1, max_length=4)]


class _Effort(Struct, forbid_unknown_fields=True):
    """Exactly one of: force (and power), points, polynomials."""

    force_kn: NotNegative | UnsetType = UNSET
    power_kw: Positive | UnsetType = UNSET
    points: list[_Point] | UnsetType = UNSET
    polynomials: list[_Polynomial] | UnsetType = UNSET


class _TunnelDrag(Struct, forbid_unknown_fields=True):
    cross_section_m2: Positive
    davis_c_n_per_kmh2: NotNegative


class _BrakingRate(Struct, forbid_unknown_fields=True):
    from_kmh: NotNegative
    deceleration_mps2: Positive


class _Adhesion(Struct, forbid_unknown_fields=True):
    """Mass on the driven axles; without a coefficient that of dry rail by Curtius and Kniffler."""

    adhesive_mass_t: Positive
    coefficient: Positive | UnsetType = UNSET


class _Train(Struct, forbid_unknown_fields=True):
    mass_t: Positive
    traction: _Effort
    max_speed_kmh: Positive
    davis_a_n: NotNegative
    davis_b_n_per_kmh: NotNegative
    davis_c_n_per_kmh2: NotNegative
    braking: _Effort | UnsetType = UNSET
    adhesion: _Adhesion | UnsetType = UNSET
    friction_brake_kn: NotNegative = 0.0
    rotating_mass_factor: Annotated[float, Meta(ge=1.0)] = 1.0
    length_m: NotNegative = 0.0
    max_acceleration_mps2: Positive | UnsetType = UNSET
    max_deceleration_mps2: Positive | UnsetType = UNSET
    traction_efficiency_pct: Annotated[float, Meta(gt=0.0, le=100.0)] = 100.0
    regeneration_efficiency_pct: Annotated[float, Meta(ge=0.0, le=100.0)] = 0.0
    auxiliary_power_kw: NotNegative = 0.0
    tunnel_drag: list[_TunnelDrag] = []
    braking_rates: list[_BrakingRate] = []
    name: str | UnsetType = UNSET
    notes: list[str] = []


class _Limit(Struct, forbid_unknown_fields=True):
    from_m: NotNegative
    speed_kmh: Positive


class _Gradient(Struct, forbid_unknown_fields=True):
    from_m: NotNegative
    gradient_permil: float


class _Curve(Struct, forbid_unknown_fields=True):
    from_m: NotNegative
    radius_start_m: float | str
    radius_end_m: float | str


class _Tunnel(Struct, forbid_unknown_fields=True):
    from_m: NotNegative
    length_m: NotNegative
    cross_section_m2: Positive


class _NeutralSection(Struct, forbid_unknown_fields=True):
    from_m: NotNegative
    length_m: NotNegative
    lowered_pantograph: bool = False


class _Track(Struct, forbid_unknown_fields=True):
    length_m: Positive
    speed_limits: list[_Limit]
    gradients: list[_Gradient] = []
    stops_m: list[float] = []
    curves: list[_Curve] = []
    tunnels: list[_Tunnel] = []
    neutral_sections: list[_NeutralSection] = []
    altitude_m: float = 0.0
    name: str | UnsetType = UNSET
    notes: list[str] = []


class _Run(Struct, forbid_unknown_fields=True):
    """Options of ``tgvdp search`` by their names there; what is absent takes the search's own default."""

    from_m: NotNegative | UnsetType = UNSET
    to_m: NotNegative | UnsetType = UNSET
    start_speed_kmh: NotNegative | UnsetType = UNSET
    end_speed_kmh: NotNegative | UnsetType = UNSET
    energy: str | UnsetType = UNSET
    convention: str | UnsetType = UNSET
    mass_model: str | UnsetType = UNSET
    limits: str | UnsetType = UNSET
    curves: str | UnsetType = UNSET
    tunnels: bool | UnsetType = UNSET
    method: str | UnsetType = UNSET
    points: Several | UnsetType = UNSET
    max_margin_pct: Positive | UnsetType = UNSET
    at: str | UnsetType = UNSET
    paths: Count | UnsetType = UNSET
    heuristic: str | UnsetType = UNSET
    segment_m: Positive | UnsetType = UNSET
    speeds: Several | UnsetType = UNSET
    max_labels: Count | UnsetType = UNSET
    time_limit_s: Positive | UnsetType = UNSET
    dominance: bool | UnsetType = UNSET
    bounds: bool | UnsetType = UNSET


class _File(Struct, forbid_unknown_fields=True):
    train: _Train | str | UnsetType = UNSET
    track: _Track | str | UnsetType = UNSET
    map: MapSpec | str | UnsetType = UNSET
    run: _Run | UnsetType = UNSET
    name: str | UnsetType = UNSET


@dataclass(frozen=True)
class NativeFile:
    """What a native file holds: a train, track or map made, a reference to one (text), or none; and run options."""

    name: str
    train: Train | str | None
    track: Track | str | None
    map: EnergyMap | str | None
    options: dict[str, Any]


def read_native(document: Document) -> NativeFile:
    """Make what a native document holds; references stay unresolved.

    Raises
    ------
    InputError
        When a field is missing, unknown, mistyped or out of range.
    """
    path = document.path
    file = decode(path, document.tree, _File)
    name = path.stem if file.name is UNSET else file.name
    with errors_named(path):
        return NativeFile(
            require_text("file", "name", name),
            _train(path, file.train, name) if isinstance(file.train, _Train) else _reference(file.train),
            _track(path, file.track, name) if isinstance(file.track, _Track) else _reference(file.track),
            make_map(file.map, name) if isinstance(file.map, MapSpec) else _reference(file.map),
            _options(path, file.run) if file.run else {},
        )


def _reference(given: str | UnsetType) -> str | None:
    return None if given is UNSET else given


def _train(path: Path, spec: _Train, name: str) -> Train:
    limits: dict[str, Any] = {
        field: value
        for field in ("max_acceleration_mps2", "max_deceleration_mps2")
        if (value := getattr(spec, field)) is not UNSET
    }
    if spec.braking:
        limits["braking"] = _effort(path, "train.braking", spec.braking)
    if spec.adhesion:
        given = spec.adhesion.coefficient
        limits["adhesion"] = Adhesion(spec.adhesion.adhesive_mass_t * KILO, None if given is UNSET else given)
    return Train(
        name=name if spec.name is UNSET else spec.name,
        mass_kg=spec.mass_t * KILO,
        rotating_mass_factor=spec.rotating_mass_factor,
        length_m=spec.length_m,
        traction=_effort(path, "train.traction", spec.traction),
        friction_brake_n=spec.friction_brake_kn * KILO,
        davis_a_n=spec.davis_a_n,
        davis_b_n_per_mps=per_kmh_to_per_mps(spec.davis_b_n_per_kmh, 1),
        davis_c_n_per_mps2=per_kmh_to_per_mps(spec.davis_c_n_per_kmh2, 2),
        max_speed_mps=kmh_to_mps(spec.max_speed_kmh),
        traction_efficiency=spec.traction_efficiency_pct / 100.0,
        regeneration_efficiency=spec.regeneration_efficiency_pct / 100.0,
        auxiliary_power_w=spec.auxiliary_power_kw * KILO,
        tunnel_drag=tuple(
            TunnelDrag(row.cross_section_m2, per_kmh_to_per_mps(row.davis_c_n_per_kmh2, 2)) for row in spec.tunnel_drag
        ),
        braking_rates=tuple(BrakingRate(kmh_to_mps(row.from_kmh), row.deceleration_mps2) for row in spec.braking_rates),
        notes=tuple(spec.notes),
        **limits,
    )


def _effort(path: Path, place: str, spec: _Effort) -> EffortCurve:
    given = [field for field in ("force_kn", "points", "polynomials") if getattr(spec, field) is not UNSET]
    if len(given) != 1 or (spec.power_kw and given != ["force_kn"]):
        got = [field for field in spec.__struct_fields__ if getattr(spec, field) is not UNSET]
        raise bad(
            path,
            f"{place}: must hold exactly one of force_kn (with power_kw or without), points, polynomials, "
            f"got {', '.join(got) or 'none'}",
        )
    with errors_named(path, place):
        if spec.points is not UNSET:
            return EffortCurve.from_points([(kmh_to_mps(p.speed_kmh), p.effort_kn * KILO) for p in spec.points])
        if spec.polynomials is not UNSET:
            return EffortCurve(tuple(_pieces(spec.polynomials)))
        assert spec.force_kn is not UNSET
        power = {"power_w": spec.power_kw * KILO} if spec.power_kw else {}
        return EffortCurve.from_caps(spec.force_kn * KILO, **power)


def _pieces(polynomials: list[_Polynomial]) -> Iterator[EffortPiece]:
    for one in polynomials:
        si = (per_kmh_to_per_mps(value, power) for power, value in enumerate(one.coefficients_n_kmh))
        yield EffortPiece(kmh_to_mps(one.from_kmh), 0.0, *si)


def _track(path: Path, spec: _Track, name: str) -> Track:
    return Track(
        name=name if spec.name is UNSET else spec.name,
        length_m=spec.length_m,
        speed_limits=tuple(SpeedLimit(row.from_m, kmh_to_mps(row.speed_kmh)) for row in spec.speed_limits),
        gradients=tuple(Gradient(row.from_m, row.gradient_permil) for row in spec.gradients),
        stops_m=tuple(spec.stops_m),
        curves=tuple(_curves(path, spec.curves)),
        tunnels=tuple(Tunnel(*structs.astuple(row)) for row in spec.tunnels),
        neutral_sections=tuple(NeutralSection(*structs.astuple(row)) for row in spec.neutral_sections),
        altitude_m=spec.altitude_m,
        notes=tuple(spec.notes),
    )


def _curves(path: Path, rows: list[_Curve]) -> Iterator[Curve]:
    for index, row in enumerate(rows):
        for field in ("radius_start_m", "radius_end_m"):
            radius = getattr(row, field)
            if isinstance(radius, str) and radius != _STRAIGHT:
                place = f"track.curves[{index}].{field}"
                raise bad(path, f"{place}: must be a number or {_STRAIGHT!r}, got {shown(radius)}")
        yield Curve(row.from_m, float(row.radius_start_m), float(row.radius_end_m))


def _options(path: Path, run: _Run) -> dict[str, Any]:
    options = {field: value for field, value in structs.asdict(run).items() if value is not UNSET}
    for field, known in _CHOICES.items():
        name = options.get(field, known[0])
        if name not in known:
            raise bad(path, f"run.{field}: unknown {field} {shown(name)}{suggestion(name, known)}")
    if run.at is not UNSET:
        even = [field for field in ("points", "max_margin_pct") if field in options]
        if even:
            raise bad(path, f"run.at: cannot stand beside {' and '.join(even)}")
        with errors_named(path, "run"):
            parse_targets(run.at)
    if run.from_m is not UNSET and run.to_m is not UNSET and not run.from_m < run.to_m:
        raise bad(path, f"run.to_m: must lie after run.from_m, got {run.to_m:g} m after {run.from_m:g} m")
    return options
