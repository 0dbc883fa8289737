"""Write the native format: a train, a track, an energy map and run options as TOML, or as JSON alike."""

import json
import math
from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from typing import Any

import tomli_w
from msgspec import convert

from tgvdp.errors import InputError
from tgvdp.formats.native.reader import effort_of
from tgvdp.formats.native.specs import EffortSpec
from tgvdp.formats.scenario import Scenario
from tgvdp.formats.syntax.decimals import decimal, tidy
from tgvdp.model.effort import EffortCurve, EffortPiece
from tgvdp.model.energy import EnergyMap
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.units import KILO, KMH_PER_MPS, kmh_to_mps, per_kmh_to_per_mps

_STRAIGHT = "infinity"
#: Two curves are the same where their efforts differ by no more than this, of the largest.
_SAME_EFFORT = 1e-12
#: Digits of the efforts of points: those that people write, where these read back as they are, else all.
_DIGITS = (12, 17)


def native_tree(scenario: Scenario) -> dict[str, Any]:
    """Tables of the native format that hold a scenario.

    Raises
    ------
    InputError
        When the format has no place for a value that it needs.
    """
    tree: dict[str, Any] = {"name": scenario.name}
    if scenario.train is not None:
        tree["train"] = _named(scenario, scenario.train.name) | _train(scenario.train)
    if scenario.track is not None:
        tree["track"] = _named(scenario, scenario.track.name) | _track(scenario.track)
    if scenario.map is not None:
        tree["map"] = _named(scenario, scenario.map.name) | _map(scenario.map)
    if scenario.options:
        tree["run"] = dict(scenario.options)
    return tidy(tree)  # type: ignore[no-any-return]


def as_json(tree: Mapping[str, Any]) -> str:
    """Text of a tree as JSON."""
    return json.dumps(tree, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _named(scenario: Scenario, name: str) -> dict[str, Any]:
    """Name of a part, where it is not that of the file."""
    return {} if name == scenario.name else {"name": name}


def _kilo(value: float) -> float:
    return decimal(value, KILO, lambda number: number * KILO)


def _percent(value: float) -> float:
    return decimal(value, 0.01, lambda number: number / 100.0)


def _kmh(speed_mps: float) -> float:
    return decimal(speed_mps, 1.0 / KMH_PER_MPS, kmh_to_mps)


def _per_kmh(value: float, power: int) -> float:
    return decimal(value, per_kmh_to_per_mps(1.0, power), lambda number: per_kmh_to_per_mps(number, power))


def _train(train: Train) -> dict[str, Any]:
    if not math.isfinite(train.max_speed_mps):
        raise InputError(f"train {train.name}: the native format needs a top speed, got {train.max_speed_mps} m/s")
    tree: dict[str, Any] = {
        "mass_t": _kilo(train.mass_kg),
        "rotating_mass_factor": train.rotating_mass_factor,
        "length_m": train.length_m,
        "max_speed_kmh": _kmh(train.max_speed_mps),
        "davis_a_n": train.davis_a_n,
        "davis_b_n_per_kmh": _per_kmh(train.davis_b_n_per_mps, 1),
        "davis_c_n_per_kmh2": _per_kmh(train.davis_c_n_per_mps2, 2),
        "friction_brake_kn": _kilo(train.friction_brake_n),
    }
    for field in ("max_acceleration_mps2", "max_deceleration_mps2"):
        if math.isfinite(getattr(train, field)):
            tree[field] = getattr(train, field)
    tree["traction_efficiency_pct"] = _percent(train.traction_efficiency)
    tree["regeneration_efficiency_pct"] = _percent(train.regeneration_efficiency)
    tree["auxiliary_power_kw"] = _kilo(train.auxiliary_power_w)
    tree |= _optional(train)
    if train.notes:
        tree["notes"] = list(train.notes)
    top_mps = train.max_speed_mps
    tree["traction"] = _effort(f"train {train.name}: traction", train.traction, top_mps)
    if train.braking != EffortCurve.from_caps(0.0):
        tree["braking"] = _effort(f"train {train.name}: braking", train.braking, top_mps)
    return tree


def _optional(train: Train) -> dict[str, Any]:
    """Tables that most trains do without."""
    tree: dict[str, Any] = {
        "tunnel_drag": [
            {"cross_section_m2": row.cross_section_m2, "davis_c_n_per_kmh2": _per_kmh(row.davis_c_n_per_mps2, 2)}
            for row in train.tunnel_drag
        ],
        "braking_rates": [
            {"from_kmh": _kmh(row.from_mps), "deceleration_mps2": row.deceleration_mps2} for row in train.braking_rates
        ],
    }
    if train.adhesion is not None:
        mass_kg, coefficient = train.adhesion
        held = {} if coefficient is None else {"coefficient": coefficient}
        tree["adhesion"] = {"adhesive_mass_t": _kilo(mass_kg), **held}
    return {field: value for field, value in tree.items() if value != []}


def _effort(owner: str, curve: EffortCurve, top_mps: float) -> dict[str, Any]:
    """Write a curve in the simplest of the three forms that reads back as it is, else as the same but for rounding."""
    short, exact = ([(tree, effort_of(convert(tree, EffortSpec))) for tree in _forms(curve, n)] for n in _DIGITS)
    for tree, again in (*short, *exact):
        if again == curve:
            return tree
    for tree, again in exact:
        if same_effort(curve, again, top_mps):
            return tree
    raise InputError(f"{owner}: none of force and power, points and polynomials holds its {len(curve.pieces)} pieces")


def _forms(curve: EffortCurve, digits: int) -> Iterator[dict[str, Any]]:
    """All forms that the pieces of a curve suggest, efforts of points with so many digits."""
    first, *others = curve.pieces
    if not any(first[3:]) and not first.power_w and first.c0_n >= 0.0:
        if not others:
            yield {"force_kn": _kilo(first.c0_n)}
        elif len(others) == 1 and others[0].power_w > 0.0 and not any(others[0][2:]):
            yield {"force_kn": _kilo(first.c0_n), "power_kw": _kilo(others[0].power_w)}
    if any(piece.power_w for piece in curve.pieces):
        return
    if all(not any(piece[4:]) for piece in curve.pieces) and not curve.pieces[-1].c1:
        yield {"points": list(_points(curve.pieces, digits))}
    yield {"polynomials": [_polynomial(piece) for piece in curve.pieces]}


def _points(pieces: tuple[EffortPiece, ...], digits: int) -> Iterator[dict[str, float]]:
    """Ends of linear pieces; where two meet in one point, that point once."""

    def point(speed_mps: float, effort_n: float) -> dict[str, float]:
        short_kn = float(f"{max(effort_n, 0.0) / KILO:.{digits}g}")
        return {"speed_kmh": _kmh(speed_mps), "effort_kn": short_kn}

    yield point(pieces[0].from_mps, pieces[0].effort_n(pieces[0].from_mps))
    for piece, after in pairwise(pieces):
        end, start = (point(after.from_mps, one.effort_n(after.from_mps)) for one in (piece, after))
        yield end
        if abs(start["effort_kn"] - end["effort_kn"]) > _SAME_EFFORT * max(start["effort_kn"], end["effort_kn"]):
            yield start


def _polynomial(piece: EffortPiece) -> dict[str, Any]:
    coefficients = [_per_kmh(value, power) for power, value in enumerate(piece[2:])]
    while len(coefficients) > 1 and coefficients[-1] == 0.0:
        coefficients.pop()
    return {"from_kmh": _kmh(piece.from_mps), "coefficients_n_kmh": coefficients}


def same_effort(one: EffortCurve, other: EffortCurve, top_mps: float) -> bool:
    """Whether two curves give the same effort up to a speed, but for rounding, between all their breaks."""
    breaks_mps = sorted({piece.from_mps for curve in (one, other) for piece in curve.pieces} | {top_mps})
    scale_n = one.largest_n(top_mps)
    for low_mps, high_mps in pairwise(breaks_mps):
        # Breaks may differ by rounding: the ends themselves are not looked at.
        for share in (0.01, 0.3, 0.7, 0.99):
            speed_mps = low_mps + share * (high_mps - low_mps)
            close = abs(one.effort_n(speed_mps) - other.effort_n(speed_mps)) <= _SAME_EFFORT * scale_n
            if not close and high_mps - low_mps > _SAME_EFFORT * top_mps and speed_mps <= top_mps:
                return False
    return True


def _track(track: Track) -> dict[str, Any]:
    def radius(radius_m: float) -> float | str:
        return _STRAIGHT if math.isinf(radius_m) else radius_m

    tree: dict[str, Any] = {
        "length_m": track.length_m,
        "altitude_m": track.altitude_m,
        "stops_m": list(track.stops_m),
        "speed_limits": [{"from_m": row.position_m, "speed_kmh": _kmh(row.speed_mps)} for row in track.speed_limits],
        "gradients": [{"from_m": row.position_m, "gradient_permil": row.gradient_permil} for row in track.gradients],
        "curves": [
            {
                "from_m": row.position_m,
                "radius_start_m": radius(row.radius_start_m),
                "radius_end_m": radius(row.radius_end_m),
            }
            for row in track.curves
        ],
        "tunnels": [
            {"from_m": row.position_m, "length_m": row.length_m, "cross_section_m2": row.cross_section_m2}
            for row in track.tunnels
        ],
        "neutral_sections": [
            {"from_m": row.position_m, "length_m": row.length_m, "lowered_pantograph": row.lowered_pantograph}
            for row in track.neutral_sections
        ],
        "places": [{"at_m": row.position_m, "name": row.name} for row in track.places],
        "notes": list(track.notes),
    }
    return {field: value for field, value in tree.items() if value != []}


def _map(energy_map: EnergyMap) -> dict[str, Any]:
    tree: dict[str, Any] = {
        "speed_kmh": [_kmh(speed_mps) for speed_mps in energy_map.speed_mps],
        "demand": list(energy_map.demand),
        "power_kw": [[_kilo(power_w) for power_w in row] for row in energy_map.power_w],
    }
    return tree | ({"notes": list(energy_map.notes)} if energy_map.notes else {})


#: Text by syntax.
SYNTAXES: dict[str, Callable[[Mapping[str, Any]], str]] = {"toml": tomli_w.dumps, "json": as_json}
