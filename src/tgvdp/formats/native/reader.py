"""The native format: a train, a track, an energy map and run options as TOML tables, or the same structure as JSON.

Each field has one unit, which its name ends in. See docs/formats.md for an example.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from msgspec import UNSET, UnsetType, structs

from tgvdp.errors import InputError
from tgvdp.formats.native.energy_map import MapSpec, make_map
from tgvdp.formats.native.order import require_at_most, require_rising
from tgvdp.formats.native.specs import CurveSpec, EffortSpec, FileSpec, PolynomialSpec, RunSpec, TrackSpec, TrainSpec
from tgvdp.formats.sources import label, locate
from tgvdp.formats.syntax.reading import Document, bad, errors_named, read_document, require_not_alone, shown
from tgvdp.formats.syntax.typed import decode, suggestion
from tgvdp.formats.tables.effort import read_effort
from tgvdp.model.adhesion import Adhesion
from tgvdp.model.checks import require_text
from tgvdp.model.effort import EffortCurve, EffortPiece
from tgvdp.model.energy import EnergyMap
from tgvdp.model.track import Curve, Gradient, NeutralSection, Place, SpeedLimit, Track, Tunnel
from tgvdp.model.train import BrakingRate, Train, TunnelDrag
from tgvdp.options.option import Option
from tgvdp.options.search import BY_FIELD, excluded_by
from tgvdp.units import KILO, kmh_to_mps, per_kmh_to_per_mps

_STRAIGHT = "infinity"


@dataclass(frozen=True)
class NativeFile:
    """What a native file holds: a train, track or map made, a reference to one (text), or none; and run options.

    ``inputs`` are the SHA-256 of tables that were read for it, by their paths, and ``remarks`` what their reader noted.
    """

    name: str
    train: Train | str | None
    track: Track | str | None
    map: EnergyMap | str | None
    options: dict[str, Any]
    inputs: dict[str, str]
    remarks: tuple[str, ...]


def read_native(document: Document) -> NativeFile:
    """Make what a native document holds; references stay unresolved.

    Raises
    ------
    InputError
        When a field is missing, unknown, mistyped or out of range.
    """
    path = document.path
    file = decode(path, document.tree, FileSpec)
    name = path.stem if file.name is UNSET else file.name
    tables = dict(_effort_tables(document, file.train)) if isinstance(file.train, TrainSpec) else {}
    with errors_named(path):
        return NativeFile(
            require_text("file", "name", name),
            _train(path, file.train, name, tables) if isinstance(file.train, TrainSpec) else _reference(file.train),
            _track(path, file.track, name) if isinstance(file.track, TrackSpec) else _reference(file.track),
            make_map(file.map, name) if isinstance(file.map, MapSpec) else _reference(file.map),
            {} if file.run is UNSET else run_options(path, file.run),
            {label(table.path): table.digest for table in tables.values()},
            tuple(_remarks(tables)),
        )


def _reference(given: str | UnsetType) -> str | None:
    return None if given is UNSET else given


class _EffortTable(NamedTuple):
    """An effort curve from a file of its own, and what its reader noted."""

    path: Path
    digest: str
    curve: EffortCurve
    notes: tuple[str, ...]


def _effort_tables(document: Document, spec: TrainSpec) -> Iterator[tuple[str, _EffortTable]]:
    """Effort of a train that is read from files, by its field."""
    path = document.path
    for field in ("traction", "braking"):
        effort: EffortSpec | UnsetType = getattr(spec, field)
        if effort is not UNSET and effort.file is not UNSET:
            with errors_named(path, f"train.{field}.file"):
                require_not_alone(document, effort.file)
                target = locate(effort.file, folder=path.parent)
                table = read_document(target.path)
            with errors_named(path, f"train.{field}"):
                yield field, _EffortTable(target.path, table.digest, *read_effort(table, field, target.part))


def _remarks(tables: Mapping[str, _EffortTable]) -> Iterator[str]:
    for table in tables.values():
        yield from (f"{table.path.name}: {note}" for note in table.notes)


def _train(path: Path, spec: TrainSpec, name: str, tables: Mapping[str, _EffortTable]) -> Train:
    limits: dict[str, Any] = {
        field: value
        for field in ("max_acceleration_mps2", "max_deceleration_mps2")
        if (value := getattr(spec, field)) is not UNSET
    }
    if spec.braking:
        limits["braking"] = _effort(path, "train.braking", spec.braking, tables.get("braking"))
    if spec.adhesion:
        given = spec.adhesion.coefficient
        adhesive_t = require_at_most("train.adhesion.adhesive_mass_t", spec.adhesion.adhesive_mass_t, spec.mass_t)
        limits["adhesion"] = Adhesion(adhesive_t * KILO, None if given is UNSET else given)
    require_rising("train.braking_rates", "from_kmh", [row.from_kmh for row in spec.braking_rates])
    return Train(
        name=name if spec.name is UNSET else spec.name,
        mass_kg=spec.mass_t * KILO,
        rotating_mass_factor=spec.rotating_mass_factor,
        length_m=spec.length_m,
        traction=_effort(path, "train.traction", spec.traction, tables.get("traction")),
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
        notes=(*spec.notes, *_remarks(tables)),
        **limits,
    )


def _effort(path: Path, place: str, spec: EffortSpec, table: _EffortTable | None) -> EffortCurve:
    with errors_named(path, place):
        return effort_of(spec, table)


def effort_of(spec: EffortSpec, table: _EffortTable | None = None) -> EffortCurve:
    """Make the curve of an effort table, of its ``file`` from what that holds; raises `InputError`."""
    given = [field for field in ("force_kn", "points", "polynomials", "file") if getattr(spec, field) is not UNSET]
    if len(given) != 1 or (spec.power_kw and given != ["force_kn"]):
        got = [field for field in spec.__struct_fields__ if getattr(spec, field) is not UNSET]
        raise InputError(
            f"must hold exactly one of force_kn (with power_kw or without), points, polynomials, file, "
            f"got {', '.join(got) or 'none'}"
        )
    if table is not None:
        return table.curve
    if spec.points is not UNSET:
        require_rising("points", "speed_kmh", [point.speed_kmh for point in spec.points], most=2)
        return EffortCurve.from_points([(kmh_to_mps(p.speed_kmh), p.effort_kn * KILO) for p in spec.points])
    if spec.polynomials is not UNSET:
        require_rising("polynomials", "from_kmh", [one.from_kmh for one in spec.polynomials])
        return EffortCurve(tuple(_pieces(spec.polynomials)))
    assert spec.force_kn is not UNSET
    power = {"power_w": spec.power_kw * KILO} if spec.power_kw else {}
    return EffortCurve.from_caps(spec.force_kn * KILO, **power)


def _pieces(polynomials: list[PolynomialSpec]) -> Iterator[EffortPiece]:
    for one in polynomials:
        si = (per_kmh_to_per_mps(value, power) for power, value in enumerate(one.coefficients_n_kmh))
        yield EffortPiece(kmh_to_mps(one.from_kmh), 0.0, *si)


def _track(path: Path, spec: TrackSpec, name: str) -> Track:
    return Track(
        name=name if spec.name is UNSET else spec.name,
        length_m=spec.length_m,
        speed_limits=tuple(SpeedLimit(row.from_m, kmh_to_mps(row.speed_kmh)) for row in spec.speed_limits),
        gradients=tuple(Gradient(row.from_m, row.gradient_permil) for row in spec.gradients),
        stops_m=tuple(spec.stops_m),
        curves=tuple(_curves(path, spec.curves)),
        tunnels=tuple(Tunnel(*structs.astuple(row)) for row in spec.tunnels),
        neutral_sections=tuple(NeutralSection(*structs.astuple(row)) for row in spec.neutral_sections),
        places=tuple(Place(*structs.astuple(row)) for row in spec.places),
        altitude_m=spec.altitude_m,
        notes=tuple(spec.notes),
    )


def _curves(path: Path, rows: list[CurveSpec]) -> Iterator[Curve]:
    for index, row in enumerate(rows):
        for field in ("radius_start_m", "radius_end_m"):
            radius = getattr(row, field)
            if isinstance(radius, str) and radius != _STRAIGHT:
                place = f"track.curves[{index}].{field}"
                raise bad(path, f"{place}: must be a number or {_STRAIGHT!r}, got {shown(radius)}")
        yield Curve(row.from_m, float(row.radius_start_m), float(row.radius_end_m))


def run_options(path: Path, run: dict[str, Any], table: str = "run") -> dict[str, Any]:
    """Options of a search from a table of a file, by their names there, checked; the table's name is for errors.

    Raises
    ------
    InputError
        When a field is unknown, mistyped, out of range, or without effect beside another one.
    """
    fields = structs.asdict(decode(path, run, RunSpec, (table,)))
    options = {field: value for field, value in fields.items() if value is not UNSET}
    for field, value in options.items():
        _check_option(path, f"{table}.{field}", BY_FIELD[field], value, options)
    if "from_m" in options and "to_m" in options and not options["from_m"] < options["to_m"]:
        from_m, to_m = options["from_m"], options["to_m"]
        raise bad(path, f"{table}.to_m: must lie after {table}.from_m, got {to_m:g} m after {from_m:g} m")
    return options


def _check_option(path: Path, place: str, one: Option, value: Any, options: Mapping[str, Any]) -> None:
    """Refuse what types let pass: unknown names, texts that cannot be read, options without effect."""
    if one.choices and value not in one.choices:
        raise bad(path, f"{place}: unknown {one.field} {shown(value)}{suggestion(value, one.choices)}")
    idle = [other.field for other in excluded_by(one) if other.field in options]
    if idle:
        raise bad(path, f"{place}: cannot stand beside {' and '.join(idle)}")
    if one.read is not None:
        with errors_named(path, place):
            one.read(value)
