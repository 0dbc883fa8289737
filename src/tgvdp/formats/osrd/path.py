"""A path of OSRD as a line: what its services answer about the path and its speed limits, saved in one JSON file.

Distances in mm from the start of the path; slopes in ‰, + uphill as the train runs; radii in m, signed, 0 is straight;
limits in m/s. A property has n values with the n − 1 boundaries between them, or with the two ends as well.
Source: openapi.yaml of OSRD's editoast; path properties, MRSP and curves in its core (Open Rail Association).
"""

import math
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

from msgspec import Meta, Struct

from tgvdp.formats.content import Content, Item, Kind
from tgvdp.formats.osrd.schedule import TrainSchedule, make_journey
from tgvdp.formats.syntax.reading import Document, bad, shown
from tgvdp.formats.syntax.typed import Finite, NotNegative, Positive, decode, extensions, in_unit
from tgvdp.model.checks import plain_text
from tgvdp.model.track import VERTICAL_PERMIL, Curve, Gradient, NeutralSection, Place, SpeedLimit, Track
from tgvdp.units import KILO, mps_to_kmh

FORMAT = "OSRD path"


#: Fields by which a file of this kind, or an answer that should be part of one, is known.
_KNOWN_BY = ("path_properties", "mrsp", "slopes")
#: Fields by which an infrastructure is known, from which OSRD makes paths.
_INFRASTRUCTURE = {"track_sections", "routes", "switches"}
_SUPPLIES = ("electrification", "neutral_section", "non_electrified")
#: Ends of a path that agree to this are the same: positions are whole millimetres.
_SLACK_MM = 1.0


Millimetre = Annotated[NotNegative, in_unit("mm")]
Length = Annotated[Positive, in_unit("mm")]
Speed = Annotated[Positive, in_unit("m/s")]


class _Slopes(Struct):
    boundaries: list[Millimetre]
    values: list[Annotated[float, Meta(gt=-VERTICAL_PERMIL, lt=VERTICAL_PERMIL), in_unit("‰")]]


class _Radii(Struct):
    boundaries: list[Millimetre]
    values: list[Annotated[Finite, in_unit("m")]]


class _Supply(Struct):
    type: str
    voltage: str | None = None
    lower_pantograph: bool = False


class _Supplies(Struct):
    boundaries: list[Millimetre]
    values: list[_Supply]


class _Speed(Struct):
    speed: Speed
    source: Any = None


class _Speeds(Struct):
    boundaries: list[Millimetre]
    values: list[_Speed | Speed]


class _Point(Struct):
    position: Millimetre
    is_passenger_station: bool = True  # not said by versions before 2026
    # What does not act on a run.
    id: Any = None
    part: Any = None
    extensions: Any = None
    weight: Any = None

    @property
    def name(self) -> str:
        """Its name, where it has one."""
        identifier = self.extensions.get("identifier") if isinstance(self.extensions, dict) else None
        name = identifier.get("name") if isinstance(identifier, dict) else None
        return plain_text(name) if isinstance(name, str) else ""


class _Properties(Struct):
    slopes: _Slopes | None = None
    curves: _Radii | None = None
    electrifications: _Supplies | None = None
    operational_points: list[_Point] | None = None
    geometry: Any = None
    zones: Any = None


class _Report(Struct):
    positions: list[Millimetre] = []


class _Simulation(Struct):
    status: str = "success"
    mrsp: _Speeds | None = None
    final_output: _Report | None = None


class _Pathfinding(Struct):
    status: str = "success"
    length: Length | None = None
    path_item_positions: list[Millimetre] = []


class _File(Struct, forbid_unknown_fields=True):
    path_properties: _Properties
    mrsp: _Speeds | None = None
    simulation: _Simulation | None = None
    pathfinding: _Pathfinding | None = None
    train_schedule: TrainSchedule | None = None
    length: Length | None = None
    name: str | None = None


def open_document(document: Document) -> Content | None:
    """Tell what a document holds; None when it is of another format.

    Raises
    ------
    InputError
        When a field is missing, mistyped or out of range.
    """
    tree, path = document.tree, document.path
    if tree.keys() >= _INFRASTRUCTURE:
        raise bad(path, "is an OSRD infrastructure, of which no line is read: ask OSRD for the properties of a path")
    if not any(field in tree for field in _KNOWN_BY):
        return None
    if "path_properties" not in tree:
        raise bad(
            path, "missing field 'path_properties': a line takes OSRD's path_properties, mrsp and length together"
        )
    file = decode(path, tree, _File)
    told = _told(path, tree, "path_properties")
    name = file.name or path.stem
    items: dict[Kind, tuple[Item, ...]] = {
        "track": (Item(name, partial(_track, path, file, document.line_speed_mps, told)),)
    }
    if file.train_schedule is not None:
        positions_mm = [] if file.pathfinding is None else file.pathfinding.path_item_positions
        more = _told(path, tree, "train_schedule")
        items["journey"] = (Item(name, partial(make_journey, path, name, file.train_schedule, positions_mm, more)),)
    return Content(format=FORMAT, items=items, takes_line_speed=True)


def _told(path: Path, tree: dict[str, Any], field: str) -> tuple[str, ...]:
    """What is to be said of the fields below one of the file that are not part of the format."""
    return extensions(path, {field: tree[field]}, _File)


def _track(path: Path, file: _File, line_speed_mps: float | None, told: tuple[str, ...]) -> Track:
    for place, answer in (("simulation", file.simulation), ("pathfinding", file.pathfinding)):
        if answer is not None and answer.status != "success":
            raise bad(path, f"{place}.status: must be 'success', got {shown(answer.status)}")
    length_mm = _length_mm(path, file)
    properties = file.path_properties
    limits, notes = _limits(path, file, length_mm, line_speed_mps)
    slopes = _rows(path, "path_properties.slopes", properties.slopes, length_mm)
    curves = _rows(path, "path_properties.curves", properties.curves, length_mm)
    supplies = _rows(path, "path_properties.electrifications", properties.electrifications, length_mm)
    for _, supply in supplies:
        if supply.type not in _SUPPLIES:
            known = ", ".join(_SUPPLIES)
            place = "path_properties.electrifications: type"
            raise bad(path, f"{place} must be one of {known}, got {shown(supply.type)}")
    stops_m = set(_stops_m(path, properties, length_mm))
    return Track(
        name=file.name or path.stem,
        length_m=length_mm / KILO,
        speed_limits=limits,
        gradients=tuple(Gradient(from_m, permil) for from_m, permil in slopes),
        curves=_curves(curves),
        stops_m=tuple(sorted(stops_m | {0.0, length_mm / KILO})),
        places=tuple(Place(*place) for place in sorted(_names(properties, length_mm).items())),
        neutral_sections=tuple(_neutral_sections(supplies, length_mm / KILO)),
        notes=(*notes, *_notes(properties, [supply for _, supply in supplies]), *told),
    )


def _stops_m(path: Path, properties: _Properties, length_mm: float) -> Iterator[float]:
    for index, point in enumerate(properties.operational_points or []):
        if point.is_passenger_station and point.position > length_mm:
            place = f"path_properties.operational_points[{index}].position"
            end = f"the path's end, {length_mm:.12g} mm"
            raise bad(path, f"{place} must not lie behind {end}, got {point.position:.12g} mm")
        if point.is_passenger_station:
            yield point.position / KILO


def _names(properties: _Properties, length_mm: float) -> dict[float, str]:
    """Names of operational points by their positions, m."""
    points = [point for point in properties.operational_points or [] if 0.0 <= point.position <= length_mm]
    return {point.position / KILO: point.name for point in points if point.name}


def _length_mm(path: Path, file: _File) -> float:
    """Length of the path: said, or that of the pathfinding, or where the simulation ends; these must agree."""
    report = None if file.simulation is None else file.simulation.final_output
    end_mm = report.positions[-1] if report is not None and report.positions else 0.0
    found = {
        "length": file.length,
        "pathfinding.length": None if file.pathfinding is None else file.pathfinding.length,
        "the end of simulation.final_output.positions": end_mm or None,
    }
    given = [(name, length_mm) for name, length_mm in found.items() if length_mm is not None]
    if not given:
        raise bad(path, "missing field 'length' (mm), and neither pathfinding nor simulation gives it")
    for name, length_mm in given[1:]:
        if abs(length_mm - given[0][1]) > _SLACK_MM:
            one = f"{given[0][0]} is {given[0][1]:.12g} mm"
            raise bad(path, f"{one}, and {name} {length_mm:.12g} mm: answers about different paths?")
    return given[0][1]


def _limits(
    path: Path, file: _File, length_mm: float, line_speed_mps: float | None
) -> tuple[tuple[SpeedLimit, ...], tuple[str, ...]]:
    inner = None if file.simulation is None else file.simulation.mrsp
    place, speeds = ("mrsp", file.mrsp) if inner is None else ("simulation.mrsp", inner)
    if inner is not None and file.mrsp is not None and inner != file.mrsp:
        raise bad(path, "mrsp and simulation.mrsp differ: keep one of the two")
    if speeds is not None:
        rows = _rows(path, place, speeds, length_mm)
        note = "limits are OSRD's most restrictive speed profile: the simulated train's top speed and length are in it"
        return tuple(SpeedLimit(at, one.speed if isinstance(one, _Speed) else one) for at, one in rows), (note,)
    if line_speed_mps is None:
        raise bad(path, "no speed limits: missing field 'mrsp'; --line-speed KMH gives a limit where the file has none")
    note = f"no mrsp: limit is the line speed asked for, {mps_to_kmh(line_speed_mps):g} km/h"
    return (SpeedLimit(0.0, line_speed_mps),), (note,)


def _rows(
    path: Path, place: str, ranges: _Slopes | _Radii | _Supplies | _Speeds | None, length_mm: float
) -> list[tuple[float, Any]]:
    """Values and where each begins, m; equal neighbours are one."""
    if ranges is None or not (ranges.values or ranges.boundaries):
        return []
    starts_mm = [0.0, *_inner_mm(path, place, ranges.boundaries, len(ranges.values), length_mm)]
    rows: list[tuple[float, Any]] = []
    for index, (from_mm, value) in enumerate(zip(starts_mm, ranges.values, strict=True)):
        if index and not from_mm > starts_mm[index - 1]:
            raise bad(
                path, f"{place}.boundaries must increase, got {from_mm:.12g} mm after {starts_mm[index - 1]:.12g} mm"
            )
        if not from_mm < length_mm:
            raise bad(
                path, f"{place}.boundaries must lie before the path's end, {length_mm:.12g} mm, got {from_mm:.12g} mm"
            )
        if not rows or rows[-1][1] != value:
            rows.append((from_mm / KILO, value))
    return rows


def _inner_mm(path: Path, place: str, boundaries: Sequence[float], count: int, length_mm: float) -> Sequence[float]:
    """Boundaries between values, from these alone or from these and the two ends."""
    if len(boundaries) == count - 1:
        return boundaries
    if len(boundaries) != count + 1:
        raise bad(path, f"{place}: must hold one value more than boundaries, got {count} and {len(boundaries)}")
    for at_mm, end_mm in ((boundaries[0], 0.0), (boundaries[-1], length_mm)):
        if abs(at_mm - end_mm) > _SLACK_MM:
            raise bad(path, f"{place}.boundaries: must reach from 0 to {length_mm:.12g} mm, got {at_mm:.12g} mm")
    return boundaries[1:-1]


def _curves(rows: list[tuple[float, float]]) -> tuple[Curve, ...]:
    radii = [(from_m, radius_m or math.inf) for from_m, radius_m in rows]
    if all(math.isinf(radius_m) for _, radius_m in radii):
        return ()
    return tuple(Curve(from_m, radius_m, radius_m) for from_m, radius_m in radii)


def _neutral_sections(supplies: list[tuple[float, _Supply]], length_m: float) -> Iterator[NeutralSection]:
    for (from_m, supply), (end_m, _) in pairwise([*supplies, (length_m, None)]):
        if supply is not None and supply.type == "neutral_section":
            yield NeutralSection(from_m, end_m - from_m, supply.lower_pantograph)


def _notes(properties: _Properties, supplies: list[_Supply]) -> Iterator[str]:
    voltages = sorted({supply.voltage for supply in supplies if supply.voltage})
    if voltages:
        yield f"electrified with {', '.join(voltages)[:100]}: the train's mode is not chosen by it"
    if any(supply.type == "non_electrified" for supply in supplies):
        yield "part of the path has no catenary, which does not stop an electric train here"
    absent = [name for name in ("slopes", "curves", "electrifications") if getattr(properties, name) is None]
    if absent:
        yield f"not in the file: {', '.join(absent)}"
