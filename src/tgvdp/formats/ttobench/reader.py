"""TTOBench tracks, trains and journeys (JSON, library versions 1.1 to 1.5; Kouzoupis et al., BSD-2-Clause).

Every field names its unit, and every unit is read. Entries of a track hold until the next one; the last stop is the
length of the track. ETCS braking data, numbers of seats and coaches are read, do not act, and are kept for a file that
is written again; ``FILE#A_brake_service`` is the train with the service brake of its ETCS data.
"""

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

from msgspec import UNSET, Struct, UnsetType, field

from tgvdp.formats.content import Content, Item, Kind
from tgvdp.formats.syntax.reading import Document, bad, errors_named, shown
from tgvdp.formats.syntax.typed import decode
from tgvdp.formats.ttobench.fields import (
    BETWEEN_NOTES,
    ETCS,
    Metadata,
    Quantity,
    kept,
    number_si,
    rows_si,
    spaced,
    value_si,
)
from tgvdp.formats.ttobench.journey import read_journey
from tgvdp.formats.ttobench.order import require_slopes, require_steps, require_stretches
from tgvdp.formats.ttobench.train import SERVICE_BRAKE, TrainFile, read_train
from tgvdp.model.checks import plain_text
from tgvdp.model.journey import Journey
from tgvdp.model.track import Curve, Gradient, SpeedLimit, Track, Tunnel
from tgvdp.model.train import Train

_VERSIONS = ("1.1", "1.2", "1.3", "1.4", "1.5")
_VERSION = re.compile(rf"(?:TTOBench )?v?(?:{'|'.join(map(re.escape, _VERSIONS))})")
_STRAIGHT = "infinity"
_FEWEST_STOPS = 2


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


class _CurveUnits(Struct, forbid_unknown_fields=True, rename=spaced):
    position: str
    radius_at_start: str
    radius_at_end: str


class _Curves(Struct, forbid_unknown_fields=True):
    units: _CurveUnits
    values: list[tuple[float, float | str, float | str]]


class _TunnelUnits(Struct, forbid_unknown_fields=True, rename=spaced):
    position: str
    length: str
    cross_section: str


class _Tunnels(Struct, forbid_unknown_fields=True):
    units: _TunnelUnits
    values: list[tuple[float, float, float]]


class _TrackFile(Struct, forbid_unknown_fields=True, rename=spaced):
    metadata: Metadata
    stops: _Stops
    speed_limits: _Limits
    altitude: Quantity | UnsetType = UNSET
    gradients: _Gradients | UnsetType = UNSET
    curvatures: _Curves | UnsetType = UNSET
    tunnels: _Tunnels | UnsetType = UNSET
    etcs_braking_data: Any = field(default=UNSET, name=ETCS)


#: Fields by which content is recognised; metadata is common to all three kinds.
_TRACK_FIELDS = frozenset(_TrackFile.__struct_encode_fields__) - {"metadata", ETCS}
_TRAIN_FIELDS = frozenset(TrainFile.__struct_encode_fields__) - {"metadata", ETCS, "length"}
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
    """Tell what a document holds; None when it is of another format.

    Raises
    ------
    InputError
        When it is of a version of the library that is not known.
    """
    readers: dict[Kind, Callable[[Document], Train | Track | Journey]] = {
        "train": read_train,
        "track": read_track,
        "journey": read_journey,
    }
    kind = kind_of(document.tree)
    if kind is None:
        return None
    _require_version(document)
    words, held = _description(document.tree), kept(document.tree)
    items = [Item(document.path.stem, partial(_described, words, readers[kind], document), kept=held, own=words)]
    if kind == "train" and ETCS in document.tree:
        braked = partial(_described, words, partial(read_train, brake=SERVICE_BRAKE), document)
        items.append(Item(SERVICE_BRAKE, braked, kept=held, own=words))
    return Content(format="TTOBench", items={kind: tuple(items)}, default=items[0].id)


def _description(tree: Mapping[str, Any]) -> tuple[str, ...]:
    """Notes that a file was written with, or what else it says of itself."""
    metadata = tree.get("metadata")
    text = metadata.get("description") if isinstance(metadata, dict) else None
    return tuple(filter(None, map(plain_text, text.split(BETWEEN_NOTES)))) if isinstance(text, str) else ()


def _described(
    words: tuple[str, ...], read: Callable[[Document], Train | Track | Journey], document: Document
) -> Train | Track | Journey:
    """Read something, with what its file says of itself as notes; of what a reader says, too, one stays."""
    made = read(document)
    return replace(made, notes=tuple(dict.fromkeys((*words, *made.notes))))


def _require_version(document: Document) -> None:
    """Refuse other versions; what is no text, or absent, is refused with the other fields."""
    metadata = document.tree.get("metadata")
    version = metadata.get("library version") if isinstance(metadata, dict) else None
    if isinstance(version, str) and not _VERSION.fullmatch(version):
        known = f"TTOBench v{_VERSIONS[0]} to v{_VERSIONS[-1]}"
        raise bad(document.path, f"metadata.library version: must be {known}, got {shown(version)}")


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
    stops_m = [value_si(path, "stops.unit", stop, unit, "length") for stop in file.stops.values]
    if len(stops_m) < _FEWEST_STOPS or stops_m[0] != 0.0:
        raise bad(path, f"stops: must begin at 0 and end at the track's length, got {shown(file.stops.values)}")
    for index, (before, stop) in enumerate(pairwise(file.stops.values), start=1):
        if not stop > before:
            raise bad(path, f"stops.values[{index}]: must increase, got {stop:.12g} {unit} after {before:.12g} {unit}")

    end = Quantity(unit, file.stops.values[-1])
    with errors_named(path):
        return Track(
            name=file.metadata.id,
            length_m=stops_m[-1],
            stops_m=tuple(stops_m),
            speed_limits=_speed_limits(path, file.speed_limits, end),
            gradients=_gradients(path, file.gradients, end) if file.gradients else (),
            curves=_curves(path, file.curvatures, end) if file.curvatures else (),
            tunnels=_tunnels(path, file.tunnels, end) if file.tunnels else (),
            altitude_m=number_si(path, "altitude", file.altitude, "length", default=0.0),
            notes=(f"{ETCS} does not act",) if file.etcs_braking_data is not UNSET else (),
        )


def _speed_limits(path: Path, table: _Limits, end: Quantity) -> tuple[SpeedLimit, ...]:
    if not table.values:
        raise bad(path, "speed limits.values: must not be empty")
    for index, (_, speed) in enumerate(table.values):
        if not speed > 0.0:
            unit = table.units.velocity
            raise bad(path, f"speed limits.values[{index}]: velocity must be above 0 {unit}, got {speed:g} {unit}")
    limits = tuple(SpeedLimit(*row) for row in rows_si(path, "speed limits", table, "length", "speed"))
    require_steps(path, "speed limits", table, end)
    return limits


def _gradients(path: Path, table: _Gradients, end: Quantity) -> tuple[Gradient, ...]:
    gradients = tuple(Gradient(*row) for row in rows_si(path, "gradients", table, "length", "gradient"))
    require_steps(path, "gradients", table, end)
    require_slopes(path, table)
    return gradients


def _tunnels(path: Path, table: _Tunnels, end: Quantity) -> tuple[Tunnel, ...]:
    tunnels = tuple(Tunnel(*row) for row in rows_si(path, "tunnels", table, "length", "length", "area"))
    require_stretches(path, table, end)
    return tunnels


def _curves(path: Path, table: _Curves, end: Quantity) -> tuple[Curve, ...]:
    for index, (_, *radii) in enumerate(table.values):
        for radius, name in zip(radii, ("radius at start", "radius at end"), strict=True):
            where = f"curvatures.values[{index}]: {name}"
            if isinstance(radius, str) and radius != _STRAIGHT:
                raise bad(path, f"{where} must be a number or {_STRAIGHT!r}, got {shown(radius)}")
            if radius == 0.0:
                raise bad(path, f"{where} must not be 0 {getattr(table.units, name.replace(' ', '_'))}")
    curves = tuple(Curve(*row) for row in rows_si(path, "curvatures", table, "length", "length", "length"))
    require_steps(path, "curvatures", table, end)
    return curves
