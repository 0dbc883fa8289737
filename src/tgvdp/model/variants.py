"""Variants of a train and a line: the other direction, temporary speed restrictions, wind.

Wind: the running resistance of a train in still air is A + B·v + C·v², of which C·v² is that of the air. In a head wind
of u the air meets the train at v + u (Wende, Fahrdynamik des Schienenverkehrs, 2003, whose formulas for air resistance
all have (V + ΔV)² with the head wind ΔV; TrainRuns.jl computes them so): A + B·v + C·(v + u)², which is again a Davis
formula, with A' = A + C·u², B' = B + 2·C·u and C' = C.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TypeVar

from tgvdp.errors import InputError
from tgvdp.model.checks import require_number, require_rows
from tgvdp.model.track import Curve, Gradient, NeutralSection, Place, SpeedLimit, SpeedRestriction, Track, Tunnel
from tgvdp.model.train import Train
from tgvdp.units import KILO, mps_to_kmh

_REVERSED = " reversed"

_Row = TypeVar("_Row", SpeedLimit, Gradient, Curve)


def reversed_track(track: Track) -> Track:
    """Return the line as it is met in the other direction: what was its end is at 0 m.

    Gradients change their sign, curves their side, and everything is mirrored. Reversed twice it is the same line, up
    to the rounding of positions.
    """
    length_m = track.length_m
    climb_m = sum(
        (end_m - row.position_m) * row.gradient_permil / KILO for row, end_m in _held(track.gradients, length_m)
    )
    return replace(
        track,
        name=track.name.removesuffix(_REVERSED) if track.name.endswith(_REVERSED) else f"{track.name}{_REVERSED}",
        altitude_m=track.altitude_m + climb_m,
        speed_limits=_mirrored(track.speed_limits, length_m),
        gradients=tuple(
            row._replace(gradient_permil=0.0 - row.gradient_permil) for row in _mirrored(track.gradients, length_m)
        ),
        curves=tuple(
            Curve(row.position_m, _other_side(row.radius_end_m), _other_side(row.radius_start_m))
            for row in _mirrored(track.curves, length_m)
        ),
        stops_m=tuple(dict.fromkeys(length_m - stop_m for stop_m in reversed(track.stops_m))),
        tunnels=tuple(Tunnel(_far_end(row, length_m), *row[1:]) for row in reversed(track.tunnels)),
        places=tuple(
            Place(*row) for row in {max(length_m - at_m, 0.0): name for at_m, name in reversed(track.places)}.items()
        ),
        neutral_sections=tuple(
            NeutralSection(_far_end(row, length_m), *row[1:]) for row in reversed(track.neutral_sections)
        ),
    )


def named_track(track: Track, places: Iterable[Place]) -> Track:
    """Return the line with the names that others have for places of it where it has none."""
    missing = [place for place in places if place.position_m <= track.length_m and not track.name_at(place.position_m)]
    return replace(track, places=tuple(sorted((*track.places, *missing)))) if missing else track


def _held(rows: Sequence[_Row], length_m: float) -> list[tuple[_Row, float]]:
    """Rows that hold until the next one, with where they end, m."""
    return list(zip(rows, [*(row.position_m for row in rows), length_m][1:], strict=True))


def _mirrored(rows: Sequence[_Row], length_m: float) -> tuple[_Row, ...]:
    mirrored: list[_Row] = []
    for row, end_m in reversed(_held(rows, length_m)):
        position_m = length_m - end_m
        if mirrored and position_m <= mirrored[-1].position_m:  # shorter than the last digit of a position
            mirrored.pop()
        if position_m < length_m:
            mirrored.append(row._replace(position_m=position_m))
    return tuple(mirrored)


def _other_side(radius_m: float) -> float:
    return radius_m if math.isinf(radius_m) else -radius_m


def _far_end(row: Tunnel | NeutralSection, length_m: float) -> float:
    return max(length_m - (row.position_m + row.length_m), 0.0)


def restricted_track(track: Track, restrictions: Iterable[SpeedRestriction]) -> Track:
    """Return the line with its speed limit lowered where restrictions hold.

    Raises
    ------
    InputError
        When a restriction does not lie on the line, has no length, or no speed.
    """
    owner = f"track {track.name}"
    rows = require_rows(owner, "speed_restrictions", restrictions, SpeedRestriction)
    for index, row in enumerate(rows):
        label = f"speed_restrictions[{index}]"
        from_m = require_number(owner, f"{label}.from", row.from_m, "m", at_least=0.0)
        to_m = require_number(owner, f"{label}.to", row.to_m, "m", above=from_m)
        require_number(owner, f"{label}.speed", row.speed_mps, "m/s", above=0.0)
        if to_m > track.length_m:
            raise InputError(
                f"{owner}: {label}.to must lie within the line's {track.length_m:.12g} m, got {to_m:.12g} m"
            )
    known_m = {row.position_m for row in track.speed_limits}
    edges_m = {edge_m for row in rows for edge_m in row[:2] if edge_m < track.length_m}
    limits: list[SpeedLimit] = []
    for position_m in sorted(known_m | edges_m):
        held = [row.speed_mps for row in track.speed_limits if row.position_m <= position_m][-1]
        speed_mps = min([held, *(row.speed_mps for row in rows if row.from_m <= position_m < row.to_m)])
        if position_m in known_m or speed_mps != limits[-1].speed_mps:
            limits.append(SpeedLimit(position_m, speed_mps))
    return replace(track, speed_limits=tuple(limits))


def train_in_wind(train: Train, wind_mps: float) -> Train:
    """Return the train in a head wind, or with a negative speed in a tail wind; see the module.

    Exact as long as the air meets the train from ahead. A tail wind −u pushes a train that is slower than it; the
    formula brakes there instead, by at most 2·C·u² too much. Where it would even let the resistance fall with speed
    (B' < 0), Davis coefficients cannot represent it.

    Raises
    ------
    InputError
        When the tail wind is above B/(2·C).
    """
    b_n_per_mps = train.davis_b_n_per_mps + 2.0 * train.davis_c_n_per_mps2 * wind_mps
    if b_n_per_mps < 0.0:
        most_mps = train.davis_b_n_per_mps / (2.0 * train.davis_c_n_per_mps2)
        raise InputError(
            f"train {train.name}: a tail wind of {-mps_to_kmh(wind_mps):.4g} km/h cannot be represented: its Davis "
            f"coefficients allow {mps_to_kmh(most_mps):.4g} km/h at most, B/(2C)"
        )
    return replace(
        train,
        davis_a_n=train.davis_a_n + train.davis_c_n_per_mps2 * wind_mps**2,
        davis_b_n_per_mps=b_n_per_mps,
    )
