"""The strict JSON form of instances.

Instances are small JSON files, ``{"id": ..., "params": {"kind": "binary" | "demand" | "substation", ...}}``. A field
that is not known, is given twice, has the wrong type or is out of range is an `InputError` of one line that names the
file.
"""

import os
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from math import floor
from pathlib import Path
from typing import Annotated, Any

from msgspec import UNSET, Meta, Struct, UnsetType

from tgvdp.errors import InputError
from tgvdp.formats.syntax.reading import bad, read_document, shown
from tgvdp.formats.syntax.typed import decode, suggestion
from tgvdp.formulations.problem.instances import (
    CURVE_M,
    CURVES_END_KMH,
    KINDS,
    MODELS,
    MOST_STEPS,
    BinaryInstance,
    DemandInstance,
    Instance,
    SharedTrip,
    Slope,
    SubstationInstance,
    decimal,
)
from tgvdp.model.checks import require_text
from tgvdp.units import kmh_to_mps

_MOST_UNITS = 1_000_000
MOST_TRAINS = 100
#: Energies of a substation are whole multiples of 1/q, α = p/q: larger q leave too few digits for their sums.
_LARGEST_Q = 1_000_000

_Positive = Annotated[float, Meta(gt=0.0, le=1e12)]
_NotNegative = Annotated[float, Meta(ge=0.0, le=1e12)]
_Finite = Annotated[float, Meta(ge=-1e12, le=1e12)]
_Ratio = Annotated[float, Meta(ge=0.0, le=1.0)]
_Steps = Annotated[int, Meta(ge=1, le=MOST_STEPS)]
_Units = Annotated[int, Meta(ge=1, le=_MOST_UNITS)]
#: (from m, value from there on).
_Place = tuple[_NotNegative, Annotated[float, Meta(ge=-1000.0, le=1000.0)]]
_Bend = tuple[_NotNegative, _Positive | None]
_Level = Annotated[float, Meta(ge=-1.0, le=1.0)]


class _Binary(Struct, forbid_unknown_fields=True):
    kind: str
    model: str
    N: _Steps
    dt_s: _Positive
    dv_mps: _Positive
    acc_units: _Units
    dec_units: _Units
    cap_units: _NotNegative | list[_NotNegative]
    D_units: _NotNegative
    alpha: _Ratio = 0.0
    eta0: _Finite | UnsetType = UNSET
    deta: _Finite | UnsetType = UNSET
    tol_units: _NotNegative = 0.0
    lambda_uniform: _Positive | UnsetType = UNSET


class _Demand(Struct, forbid_unknown_fields=True):
    kind: str
    N: _Steps
    dt_s: _Positive
    notches: Annotated[int, Meta(ge=1, le=1000)] | list[_Level] | None
    mass_kg: _Positive
    rot: Annotated[float, Meta(ge=1.0, le=10.0)]
    davis_SI: Annotated[list[_NotNegative], Meta(min_length=3, max_length=3)]
    vmax_kmh: _Positive
    D_m: _NotNegative
    tol_m: _NotNegative
    v_end_max_mps: _NotNegative
    P_max_W: _Positive
    cost_ref_kmh: _Positive
    alpha: _Ratio = 0.0
    gradients_permil: list[_Place] = []
    curves_m: list[_Bend] = []


class _SharedTrip(Struct, forbid_unknown_fields=True):
    N: _Steps
    cap_units: _NotNegative | list[_NotNegative]
    D_units: _Units
    start: Annotated[int, Meta(ge=0, le=MOST_STEPS)] = 0
    mass_units: Annotated[int, Meta(ge=1, le=1000)] = 1


class _Substation(Struct, forbid_unknown_fields=True):
    kind: str
    dt_s: _Positive
    dv_mps: _Positive
    power_units: _Units
    trains: Annotated[list[_SharedTrip], Meta(min_length=1, max_length=MOST_TRAINS)]
    alpha: _Ratio = 0.0


class _BinaryFile(Struct, forbid_unknown_fields=True):
    id: str
    params: _Binary
    notes: list[str] = []


class _DemandFile(Struct, forbid_unknown_fields=True):
    id: str
    params: _Demand
    notes: list[str] = []


class _SubstationFile(Struct, forbid_unknown_fields=True):
    id: str
    params: _Substation


def read_instance(path: str | os.PathLike[str]) -> Instance:
    """Read one instance from its JSON file.

    Raises
    ------
    InputError
        When the file cannot be read, or a field is unknown, missing, repeated, mistyped, not finite or out of range.
    """
    document = read_document(Path(path))
    return parse_instance(document.path, document.tree)


def parse_instance(path: Path, tree: dict[str, Any]) -> Instance:
    """Make an instance of a tree of JSON values; ``path`` names the source in errors."""
    params = tree.get("params")
    kind = params.get("kind", "binary") if isinstance(params, dict) else "binary"  # what is absent, the struct reports
    if kind == "binary":
        binary = decode(path, tree, _BinaryFile)
        return replace(_binary(path, _id(path, binary.id), binary.params), notes=tuple(binary.notes))
    if kind == "demand":
        demand = decode(path, tree, _DemandFile)
        return replace(_demand(path, _id(path, demand.id), demand.params), notes=tuple(demand.notes))
    if kind == "substation":
        shared = decode(path, tree, _SubstationFile)
        return _substation(path, _id(path, shared.id), shared.params)
    raise bad(path, f"params.kind: must be one of {', '.join(map(repr, KINDS))}, got {shown(kind)}")


def _id(path: Path, name: str) -> str:
    try:
        return require_text("instance", "id", name)
    except InputError as error:
        raise bad(path, error) from None


def _binary(path: Path, name: str, spec: _Binary) -> BinaryInstance:
    model = next((one for one in MODELS if one == spec.model), None)
    if model is None:
        raise bad(path, f"params.model: unknown model {shown(spec.model)}{suggestion(spec.model, MODELS)}")
    if model == "efficiency":
        for field_name in ("eta0", "deta"):
            if getattr(spec, field_name) is UNSET:
                raise bad(path, f"params: missing field {field_name!r}, which the efficiency model needs")
    return BinaryInstance(
        id=name,
        model=model,
        steps=spec.N,
        dt_s=spec.dt_s,
        dv_mps=spec.dv_mps,
        acc_units=spec.acc_units,
        dec_units=spec.dec_units,
        cap_units=_caps(path, "params", spec.N, spec.cap_units, spec.acc_units),
        distance_units=spec.D_units,
        tol_units=spec.tol_units,
        alpha=spec.alpha,
        eta0=0.0 if isinstance(spec.eta0, UnsetType) else spec.eta0,
        deta=0.0 if isinstance(spec.deta, UnsetType) else spec.deta,
        lambda_uniform=None if isinstance(spec.lambda_uniform, UnsetType) else spec.lambda_uniform,
    )


def _caps(path: Path, place: str, steps: int, given: float | list[float], acc_units: int) -> tuple[int, ...]:
    """Largest whole speed after each step."""
    caps = given if isinstance(given, list) else [given] * steps
    if len(caps) != steps:
        raise bad(path, f"{place}.cap_units: must be a number or a list of N = {steps} values, got {len(caps)} values")
    return tuple(min(floor(cap), steps * acc_units) for cap in caps)


def _substation(path: Path, name: str, spec: _Substation) -> SubstationInstance:
    if decimal(spec.alpha).denominator > _LARGEST_Q:
        raise bad(path, f"params.alpha: has too many digits to add up energies exactly, round it: got {spec.alpha!r}")
    trains = tuple(
        SharedTrip(
            start=train.start,
            mass_units=train.mass_units,
            trip=BinaryInstance(
                id=f"{name}, train {number}",
                model="kinetic",
                steps=train.N,
                dt_s=spec.dt_s,
                dv_mps=spec.dv_mps,
                acc_units=1,
                dec_units=1,
                cap_units=_caps(path, f"params.trains[{number - 1}]", train.N, train.cap_units, 1),
                distance_units=train.D_units,
            ),
        )
        for number, train in enumerate(spec.trains, start=1)
    )
    return SubstationInstance(
        id=name, dt_s=spec.dt_s, dv_mps=spec.dv_mps, power_units=spec.power_units, alpha=spec.alpha, trains=trains
    )


def _demand(path: Path, name: str, spec: _Demand) -> DemandInstance:
    if spec.vmax_kmh > CURVES_END_KMH:
        raise bad(path, f"params.vmax_kmh: the force curves end at {CURVES_END_KMH:g} km/h, got {spec.vmax_kmh:g} km/h")
    return DemandInstance(
        id=name,
        steps=spec.N,
        dt_s=spec.dt_s,
        levels=_levels(path, spec.notches),
        mass_kg=spec.mass_kg,
        rotating_factor=spec.rot,
        davis=(spec.davis_SI[0], spec.davis_SI[1], spec.davis_SI[2]),
        vmax_mps=kmh_to_mps(spec.vmax_kmh),
        distance_m=spec.D_m,
        tol_m=spec.tol_m,
        end_speed_max_mps=spec.v_end_max_mps,
        p_max_w=spec.P_max_W,
        cost_ref_mps=kmh_to_mps(spec.cost_ref_kmh),
        alpha=spec.alpha,
        slopes=_slopes(path, spec),
    )


def _slopes(path: Path, spec: _Demand) -> tuple[Slope, ...]:
    """Gradients and curves as one: a curve of radius ρ resists like a gradient of 800/ρ ‰."""
    gradients = _places(path, "gradients_permil", spec.gradients_permil)
    bends = [(start, 0.0 if radius_m is None else CURVE_M / radius_m) for start, radius_m in spec.curves_m]
    curves = _places(path, "curves_m", bends)
    starts = sorted({*gradients, *curves})
    return tuple(
        Slope(start, sum(found[max(at for at in found if at <= start)] for found in (gradients, curves) if found))
        for start in starts
    )


def _places(path: Path, field: str, rows: Sequence[tuple[float, float]]) -> dict[float, float]:
    starts = [start for start, _ in rows]
    if starts and (starts[0] != 0.0 or any(after <= before for before, after in pairwise(starts))):
        raise bad(path, f"params.{field}: positions must start at 0 m and increase, got {shown(starts)}")
    return dict(rows)


def _levels(path: Path, notches: int | list[float] | None) -> tuple[float, ...] | None:
    """``notches: n`` means d = j/n for j = −n..n; a list gives the demands themselves; null means continuous."""
    if notches is None:
        return None
    if isinstance(notches, int):
        return tuple(j / notches for j in range(-notches, notches + 1))
    if len(set(notches)) < len(notches) or 0.0 not in notches:
        raise bad(path, "params.notches: a list of demands must hold 0 and no value twice")
    return tuple(sorted(notches))
