"""Instances: what one problem of the binary or the demand formulation consists of, and its strict JSON form.

Instances are small JSON files, ``{"id": ..., "params": {"kind": "binary" | "demand", ...}}``. A field that is not
known, is given twice, has the wrong type or is out of range is an `InputError` of one line that names the file.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise
from math import ceil, floor
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

from msgspec import UNSET, Meta, Struct, UnsetType

from tgvdp.errors import InputError
from tgvdp.formats.syntax.reading import bad, read_document, shown
from tgvdp.formats.syntax.typed import decode, suggestion
from tgvdp.model.checks import require_text
from tgvdp.units import kmh_to_mps

Model: TypeAlias = Literal["constant", "kinetic", "efficiency"]
#: Objective models of the binary formulation.
MODELS: tuple[Model, ...] = ("constant", "kinetic", "efficiency")

#: Where the force curves and the cost map of the demand model end (`tgvdp.formulations.problem.alstom`).
CURVES_END_KMH = 220.0
#: A curve of radius ρ resists like a gradient of 800/ρ ‰, as the demand formulation prints it.
CURVE_M = 800.0
#: More steps than any solver here can use; a guard against files that would only exhaust the memory.
MOST_STEPS = 100_000
_MOST_UNITS = 1_000_000

_Positive = Annotated[float, Meta(gt=0.0, le=1e12)]
_NotNegative = Annotated[float, Meta(ge=0.0, le=1e12)]
_Ratio = Annotated[float, Meta(ge=0.0, le=1.0)]
_Steps = Annotated[int, Meta(ge=1, le=MOST_STEPS)]
_Units = Annotated[int, Meta(ge=1, le=_MOST_UNITS)]
#: (from m, value from there on).
_Place = tuple[_NotNegative, Annotated[float, Meta(ge=-1000.0, le=1000.0)]]
_Bend = tuple[_NotNegative, _Positive | None]
_Level = Annotated[float, Meta(ge=-1.0, le=1.0)]


def decimal(value: float) -> Fraction:
    """The number that a decimal in a file means: 0.1 is 1/10 here, not the nearest binary fraction."""
    return Fraction(repr(value))


@dataclass(frozen=True, kw_only=True)
class BinaryInstance:
    """The binary model: in each of N equal time steps accelerate by one step, hold, or brake by one step.

    Speeds are counted in units of Δv, distances in units of Δv·Δt by the trapezoid rule, which equals the true
    distance of piecewise constant acceleration. The train starts and ends at standstill.

    Attributes
    ----------
    id : str
    model : str
        Objective: ``constant``, ``kinetic`` or ``efficiency`` (docs/formulations.md).
    steps : int
        N, number of controls.
    dt_s, dv_mps : float
        Δt in s and Δv in m/s.
    acc_units, dec_units : int
        Change of speed of one step of acceleration and of braking, in Δv.
    cap_units : tuple of int
        Largest speed h_k after step k = 1..N, in Δv. A fractional cap of a file is rounded down: speeds are whole.
    distance_units, tol_units : float
        D and its tolerance, in Δv·Δt.
    alpha : float
        Part of the braking energy that is regenerated; the efficiency model has none and does not use it.
    eta0, deta : float
        η0 and Δη of the efficiency model, η = η0 − Δη·v with v in Δv; 0 for the other models, which do not use them.
    lambda_uniform : float or None
        The weight of all penalties that the instance asks for, in the objective's unit per squared unit of violation.
    notes : tuple of str
        For people: what the instance leaves out, say.
    """

    id: str
    model: Model
    steps: int
    dt_s: float
    dv_mps: float
    acc_units: int
    dec_units: int
    cap_units: tuple[int, ...]
    distance_units: float
    tol_units: float = 0.0
    alpha: float = 0.0
    eta0: float = 0.0
    deta: float = 0.0
    lambda_uniform: float | None = None
    notes: tuple[str, ...] = field(default=(), compare=False)

    @property
    def objective_unit(self) -> str:
        """J/kg where the objective is an energy, that of the kinetic model; (m/s)² where it only ranks plans."""
        return "J/kg" if self.model == "kinetic" else "(m/s)²"

    @property
    def distance_range(self) -> tuple[int, int]:
        """Smallest and largest distance within the tolerance, in Δv·Δt; the first exceeds the second where none is.

        From stop to stop all three distance rules give Σ v_k, a whole number.
        """
        distance, tolerance = decimal(self.distance_units), decimal(self.tol_units)
        return max(0, ceil(distance - tolerance)), floor(distance + tolerance)


class Slope(NamedTuple):
    """A stretch of the line on which gradient and curve together resist like one gradient, from a position on.

    Attributes
    ----------
    from_m : float
    permil : float
        i + 800/ρ, gradient in ‰ and radius in m: the resistance is M·g/1000 times that.
    """

    from_m: float
    permil: float


@dataclass(frozen=True, kw_only=True)
class DemandInstance:
    """The demand model: in each step a fraction d of the available traction (d > 0) or braking force (d < 0).

    Attributes
    ----------
    id : str
    steps : int
        N, number of controls.
    dt_s : float
        Δt in s.
    levels : tuple of float, or None
        Allowed demands in increasing order, 0 among them; None for continuous demand in [−1, 1].
    mass_kg, rotating_factor : float
        M and k: the train's inertia is k·M.
    davis : tuple of three floats
        A (N), B (N/(m/s)), C (N/(m/s)²) of the running resistance.
    vmax_mps : float
        Speed limit, a constraint on v_1..v_N.
    distance_m, tol_m : float
        D and its tolerance.
    end_speed_max_mps : float
        Largest speed after the last step.
    p_max_w : float
        P_max, scale of the cost map.
    cost_ref_mps : float
        V_ref of the cost map, in m/s.
    alpha : float
        Part of the braking cost map that is given back.
    slopes : tuple of Slope
        Gradients and curves, from 0 m on; empty where the line is level and straight.
    notes : tuple of str
        For people: what the instance leaves out, say.
    """

    id: str
    steps: int
    dt_s: float
    levels: tuple[float, ...] | None
    mass_kg: float
    rotating_factor: float
    davis: tuple[float, float, float]
    vmax_mps: float
    distance_m: float
    tol_m: float
    end_speed_max_mps: float
    p_max_w: float
    cost_ref_mps: float
    alpha: float = 0.0
    slopes: tuple[Slope, ...] = ()
    notes: tuple[str, ...] = field(default=(), compare=False)

    @property
    def objective_unit(self) -> str:
        """J, by the cost map."""
        return "J"


Instance: TypeAlias = BinaryInstance | DemandInstance


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
    eta0: float | UnsetType = UNSET
    deta: float | UnsetType = UNSET
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


class _BinaryFile(Struct, forbid_unknown_fields=True):
    id: str
    params: _Binary
    notes: list[str] = []


class _DemandFile(Struct, forbid_unknown_fields=True):
    id: str
    params: _Demand
    notes: list[str] = []


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
    if kind not in ("binary", "demand"):
        raise bad(path, f"params.kind: must be 'binary' or 'demand', got {shown(kind)}")
    if kind == "binary":
        binary = decode(path, tree, _BinaryFile)
        return replace(_binary(path, _id(path, binary.id), binary.params), notes=tuple(binary.notes))
    demand = decode(path, tree, _DemandFile)
    return replace(_demand(path, _id(path, demand.id), demand.params), notes=tuple(demand.notes))


def _id(path: Path, name: str) -> str:
    try:
        return require_text("instance", "id", name)
    except InputError as error:
        raise bad(path, error) from None


def _binary(path: Path, name: str, spec: _Binary) -> BinaryInstance:
    model = next((one for one in MODELS if one == spec.model), None)
    if model is None:
        raise bad(path, f"params.model: unknown model {shown(spec.model)}{suggestion(spec.model, MODELS)}")
    caps = spec.cap_units if isinstance(spec.cap_units, list) else [spec.cap_units] * spec.N
    if len(caps) != spec.N:
        raise bad(path, f"params.cap_units: must be a number or a list of N = {spec.N} values, got {len(caps)} values")
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
        cap_units=tuple(min(floor(cap), spec.N * spec.acc_units) for cap in caps),
        distance_units=spec.D_units,
        tol_units=spec.tol_units,
        alpha=spec.alpha,
        eta0=0.0 if isinstance(spec.eta0, UnsetType) else spec.eta0,
        deta=0.0 if isinstance(spec.deta, UnsetType) else spec.deta,
        lambda_uniform=None if isinstance(spec.lambda_uniform, UnsetType) else spec.lambda_uniform,
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
