"""Write TTOBench JSON: one train, one track or one journey in a file (library version 1.5)."""

import math
import re
from collections.abc import Sequence
from typing import Any

from tgvdp import __version__
from tgvdp.errors import InputError
from tgvdp.formats.syntax.decimals import in_unit, tidy
from tgvdp.formats.ttobench.fields import BETWEEN_NOTES
from tgvdp.model.effort import EffortCurve
from tgvdp.model.journey import Journey
from tgvdp.model.track import Track
from tgvdp.model.train import Train

_LIBRARY = "TTOBench v1.5"
_STRAIGHT = "infinity"
_MOST_ROTATING_MASS = 1.5
_SPEED = ("km/h", "m/s")
_SQUARED = ("kN/(km/h)^2", "N/(km/h)^2", "N/(m/s)^2")

#: Fields of a train: attribute, name in the file, quantity, and units in the order of preference.
_TRAIN = (
    ("length_m", "length", "length", ("m",)),
    ("mass_kg", "mass", "mass", ("kg",)),
    ("friction_brake_n", "max pn braking force", "force", ("kN", "N")),
    ("max_acceleration_mps2", "max acceleration", "acceleration", ("m/s^2",)),
    ("max_deceleration_mps2", "max deceleration", "acceleration", ("m/s^2",)),
    ("max_speed_mps", "max speed", "speed", _SPEED),
    ("davis_a_n", "rolling resistance r0", "force", ("kN", "N")),
    ("davis_b_n_per_mps", "rolling resistance r1", "force per speed", ("kN/(km/h)", "N/(km/h)", "N/(m/s)")),
    ("davis_c_n_per_mps2", "rolling resistance r2", "force per squared speed", _SQUARED),
    ("traction_efficiency", "efficiency traction", "ratio", ("%", "-")),
    ("regeneration_efficiency", "efficiency reg brake", "ratio", ("%", "-")),
)  # fmt: skip


def ttobench_tree(part: Train | Track | Journey) -> dict[str, Any]:
    """Fields of the file that holds a train, a track or a journey.

    Raises
    ------
    InputError
        When the format has no place for a value that matters: effort that is no force and power limit, no top speed.
    """
    if isinstance(part, Train):
        return tidy(_train(part))  # type: ignore[no-any-return]
    return tidy(_track(part) if isinstance(part, Track) else _journey(part))  # type: ignore[no-any-return]


def identifier(name: str) -> str:
    """Name as the format wants it: letters, numbers and underscores only."""
    return re.sub(r"[^0-9A-Za-z]+", "_", name).strip("_") or "unnamed"


def _metadata(part: Train | Track | Journey, name: str) -> dict[str, str]:
    about = {"id": name, "created by": f"tgvdp {__version__}", "library version": _LIBRARY}
    return about | ({"description": BETWEEN_NOTES.join(part.notes)} if part.notes else {})


def _quantity(value: float, quantity: str, units: Sequence[str]) -> dict[str, Any]:
    unit, (number,) = in_unit([value], quantity, units)
    return {"unit": unit, "value": number}


def _train(train: Train) -> dict[str, Any]:
    owner = f"train {train.name}"
    if not math.isfinite(train.max_speed_mps):
        raise InputError(f"{owner}: TTOBench needs a top speed, got {train.max_speed_mps} m/s")
    if train.rotating_mass_factor > _MOST_ROTATING_MASS:
        raise InputError(
            f"{owner}: TTOBench holds rotating mass factors of 1 to 1.5, got {train.rotating_mass_factor:.6g}"
        )
    tree: dict[str, Any] = {"metadata": _metadata(train, identifier(train.name))}
    for attribute, name, quantity, units in _TRAIN:
        value = getattr(train, attribute)
        if math.isfinite(value):
            tree[name] = _quantity(value, quantity, units)
    tree["rho"] = _rho(train.rotating_mass_factor)
    if train.tunnel_drag:
        areas_m2, drags = zip(*train.tunnel_drag, strict=True)
        unit, coefficients = in_unit(drags, "force per squared speed", _SQUARED)
        tree["tunnel resistance"] = {
            "units": {"cross section": "m^2", "coefficient": unit},
            "values": list(zip(areas_m2, coefficients, strict=True)),
        }
    for name, curve in (("traction", train.traction), ("reg braking", train.braking)):
        force_n, power_w = _caps(f"{owner}: {name}", curve, train.max_speed_mps)
        tree[f"max {name} force"] = _quantity(force_n, "force", ("kN", "N"))
        tree[f"max {name} power"] = _quantity(power_w, "power", ("kW", "W"))
    return tree


def _rho(factor: float) -> dict[str, Any]:
    """Additional inertia, in percent where that reads back exactly; the factor less 1 always does."""
    for digits in (12, 15):
        percent = float(f"{100.0 * (factor - 1.0):.{digits}g}")
        if 1.0 + percent / 100.0 == factor:
            return {"unit": "%", "value": percent}
    return {"unit": "-", "value": factor - 1.0}


def _caps(owner: str, curve: EffortCurve, top_mps: float) -> tuple[float, float]:
    """Force and power limits of a curve, N and W."""
    first, *others = curve.pieces
    if not any(first[3:]) and not others:
        return first.c0_n, first.c0_n * top_mps  # a power that limits nothing up to the top speed
    if not any(first[3:]) and len(others) == 1 and others[0].power_w and not any(others[0][2:]):
        force_n, power_w = first.c0_n, others[0].power_w
        if EffortCurve.from_caps(force_n, power_w) == curve:
            return force_n, power_w
    raise InputError(
        f"{owner}: TTOBench holds a force and a power limit, not a curve of {len(curve.pieces)} pieces; "
        "the native format does"
    )


def _track(track: Track) -> dict[str, Any]:
    inner_m = [stop_m for stop_m in track.stops_m if 0.0 < stop_m < track.length_m]
    unit, speeds = in_unit([row.speed_mps for row in track.speed_limits], "speed", _SPEED)
    tree: dict[str, Any] = {
        "metadata": _metadata(track, identifier(track.name)),
        "altitude": {"unit": "m", "value": track.altitude_m},
        "stops": {"unit": "m", "values": [0.0, *inner_m, track.length_m]},
        "speed limits": {
            "units": {"position": "m", "velocity": unit},
            "values": [[row.position_m, speed] for row, speed in zip(track.speed_limits, speeds, strict=True)],
        },
    }
    if track.gradients:
        units = {"position": "m", "slope": "permil"}
        tree["gradients"] = {"units": units, "values": [list(row) for row in track.gradients]}
    if track.curves:
        units = {"position": "m", "radius at start": "m", "radius at end": "m"}
        rows = [[_STRAIGHT if math.isinf(value) else value for value in row] for row in track.curves]
        tree["curvatures"] = {"units": units, "values": rows}
    if track.tunnels:
        units = {"position": "m", "length": "m", "cross section": "m^2"}
        tree["tunnels"] = {"units": units, "values": [list(row) for row in track.tunnels]}
    return tree


def journey_identifier(journey: Journey) -> str:
    """Identifier of a journey: it begins with that of its track."""
    prefix = f"{_track_of(journey)}_"
    name = identifier(journey.name)
    return name if name.startswith(prefix) else prefix + name


def _track_of(journey: Journey) -> str:
    """Identifier of the track of a journey, of one that names none of any."""
    return identifier(journey.track or "track")


def _journey(journey: Journey) -> dict[str, Any]:
    finite = [speed for row in journey.points for speed in row[3:] if 0.0 < speed < math.inf]
    unit, numbers = in_unit(finite, "speed", _SPEED) if finite else (_SPEED[0], [])
    by_speed = dict(zip(finite, numbers, strict=True))

    def row(point: Sequence[float], *, is_stop: bool) -> list[float | None]:
        position_m, *times_s = point[:3]
        windows = [value if math.isfinite(value) else None for value in times_s]
        return [position_m, *windows, *([0.0, 0.0] if is_stop else [by_speed.get(speed) for speed in point[3:]])]

    names = ("lower time constraint", "upper time constraint", "lower speed constraint", "upper speed constraint")
    units = {"position": "m", **dict(zip(names, ("s", "s", unit, unit), strict=True))}
    about = _metadata(journey, journey_identifier(journey)) | {"associated track": _track_of(journey)}
    values = [row(point, is_stop=point.is_stop) for point in journey.points]
    return {"metadata": about, "timing points": {"units": units, "values": values}}
