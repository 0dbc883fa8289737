"""Tables of the native format, as msgspec decodes them: names, units and ranges of all fields."""

from typing import Annotated, Any

from msgspec import UNSET, Meta, Struct, UnsetType, defstruct

from tgvdp.formats.native.energy_map import MapSpec
from tgvdp.formats.syntax.typed import Finite, NotNegative, Positive
from tgvdp.options.option import Option
from tgvdp.options.search import BY_FIELD
from tgvdp.units import LARGEST_WRITTEN

#: What may be infinite: then there is none.
Limit = Annotated[float, Meta(gt=0.0)]


class PointSpec(Struct, forbid_unknown_fields=True):
    """One point of an effort table."""

    speed_kmh: NotNegative
    effort_kn: NotNegative


class PolynomialSpec(Struct, forbid_unknown_fields=True):
    """Effort in N = Σ coefficient[k] · V**k with V in km/h, from a speed up to the next polynomial's."""

    from_kmh: NotNegative
    coefficients_n_kmh: Annotated[list[Finite], Meta(min_length=1, max_length=4)]


class EffortSpec(Struct, forbid_unknown_fields=True):
    """Exactly one of: force (and power), points, polynomials, a file with a table of speed and effort."""

    force_kn: NotNegative | UnsetType = UNSET
    power_kw: Positive | UnsetType = UNSET
    points: list[PointSpec] | UnsetType = UNSET
    polynomials: list[PolynomialSpec] | UnsetType = UNSET
    file: str | UnsetType = UNSET


class TunnelDragSpec(Struct, forbid_unknown_fields=True):
    """Additional drag in tunnels of one cross section."""

    cross_section_m2: Positive
    davis_c_n_per_kmh2: NotNegative


class BrakingRateSpec(Struct, forbid_unknown_fields=True):
    """Deceleration of full braking from a speed up to the next row's."""

    from_kmh: NotNegative
    deceleration_mps2: Positive


class AdhesionSpec(Struct, forbid_unknown_fields=True):
    """Mass on the driven axles; without a coefficient that of dry rail by Curtius and Kniffler."""

    adhesive_mass_t: Positive
    coefficient: Positive | UnsetType = UNSET


class TrainSpec(Struct, forbid_unknown_fields=True):
    """A train."""

    mass_t: Positive
    traction: EffortSpec
    max_speed_kmh: Limit
    davis_a_n: NotNegative
    davis_b_n_per_kmh: NotNegative
    davis_c_n_per_kmh2: NotNegative
    braking: EffortSpec | UnsetType = UNSET
    adhesion: AdhesionSpec | UnsetType = UNSET
    friction_brake_kn: NotNegative = 0.0
    rotating_mass_factor: Annotated[float, Meta(ge=1.0)] = 1.0
    length_m: NotNegative = 0.0
    max_acceleration_mps2: Limit | UnsetType = UNSET
    max_deceleration_mps2: Limit | UnsetType = UNSET
    traction_efficiency_pct: Annotated[float, Meta(gt=0.0, le=100.0)] = 100.0
    regeneration_efficiency_pct: Annotated[float, Meta(ge=0.0, le=100.0)] = 0.0
    auxiliary_power_kw: NotNegative = 0.0
    tunnel_drag: list[TunnelDragSpec] = []
    braking_rates: list[BrakingRateSpec] = []
    name: str | UnsetType = UNSET
    notes: list[str] = []


class LimitSpec(Struct, forbid_unknown_fields=True):
    """A speed limit that holds until the next row."""

    from_m: NotNegative
    speed_kmh: Positive


class GradientSpec(Struct, forbid_unknown_fields=True):
    """A gradient that holds until the next row."""

    from_m: NotNegative
    gradient_permil: float


class CurveSpec(Struct, forbid_unknown_fields=True):
    """A curve up to the next row; a radius may be "infinity"."""

    from_m: NotNegative
    radius_start_m: float | str
    radius_end_m: float | str


class TunnelSpec(Struct, forbid_unknown_fields=True):
    """A tunnel."""

    from_m: NotNegative
    length_m: NotNegative
    cross_section_m2: Positive


class NeutralSectionSpec(Struct, forbid_unknown_fields=True):
    """A stretch without current."""

    from_m: NotNegative
    length_m: NotNegative
    lowered_pantograph: bool = False


class PlaceSpec(Struct, forbid_unknown_fields=True):
    """A place that has a name."""

    at_m: float
    name: str


class TrackSpec(Struct, forbid_unknown_fields=True):
    """A line."""

    length_m: Positive
    speed_limits: list[LimitSpec]
    gradients: list[GradientSpec] = []
    stops_m: list[float] = []
    curves: list[CurveSpec] = []
    tunnels: list[TunnelSpec] = []
    neutral_sections: list[NeutralSectionSpec] = []
    places: list[PlaceSpec] = []
    altitude_m: float = 0.0
    name: str | UnsetType = UNSET
    notes: list[str] = []


def _run_field(one: Option) -> tuple[str, Any, Any]:
    """One field of the table ``run``, as its option is declared."""
    if one.read is not None:
        return one.field, (list[str] if one.repeatable else str) | UnsetType, UNSET
    if one.kind in (bool, str):
        return one.field, one.kind | UnsetType, UNSET
    most = LARGEST_WRITTEN if one.at_most is None and one.unit else one.at_most
    meta = Meta(gt=one.above, le=most) if one.at_least is None else Meta(ge=one.at_least, le=most)
    return one.field, Annotated[one.kind, meta] | UnsetType, UNSET


#: Options of ``tgvdp search`` by their names there; what is absent takes the search's own default.
RunSpec = defstruct("RunSpec", [_run_field(one) for one in BY_FIELD.values()], forbid_unknown_fields=True)


class FileSpec(Struct, forbid_unknown_fields=True):
    """The tables of a file; text in place of one refers to another file or to the catalog."""

    train: TrainSpec | str | UnsetType = UNSET
    track: TrackSpec | str | UnsetType = UNSET
    map: MapSpec | str | UnsetType = UNSET
    run: dict[str, Any] | UnsetType = UNSET  # a RunSpec, which the reader makes
    name: str | UnsetType = UNSET
