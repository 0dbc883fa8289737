"""The line as a trip meets it: what stands below a picture of its runs, and in ``line`` of result.json."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from tgvdp.model.trip import Trip

#: Kinds of features, in the order in which they are shown; ``lowered`` is the pantograph.
FEATURE_KINDS = ("stops", "neutral", "lowered", "tunnels", "curves")


class Feature(NamedTuple):
    """One bar of the strip: stretches of the line, in m on the track."""

    name: str
    from_m: NDArray[np.float64]
    length_m: NDArray[np.float64]


def features_of(trip: "Trip") -> list[Feature]:
    """What the trip passes, by kind; kinds that it does not meet are left out.

    Stops are those between origin and destination, which the run passes; ``lowered`` is the pantograph.
    """
    track = trip.track
    stops = [(stop_m, 0.0) for stop_m in track.stops_m if trip.origin_m < stop_m < trip.destination_m]
    neutral: list[list[tuple[float, float]]] = [[], []]
    for section in track.neutral_sections:
        neutral[section.lowered_pantograph].append((section.position_m, section.length_m))
    ends_m = [*(curve.position_m for curve in track.curves[1:]), track.length_m]
    curves = [
        (curve.position_m, end_m - curve.position_m)
        for curve, end_m in zip(track.curves, ends_m, strict=False)
        if np.isfinite(curve.radius_start_m) or np.isfinite(curve.radius_end_m)
    ]
    tunnels = [(tunnel.position_m, tunnel.length_m) for tunnel in track.tunnels]
    found = zip(FEATURE_KINDS, (stops, *neutral, tunnels, curves), strict=True)
    features = [_within(trip, name, stretches) for name, stretches in found if stretches]
    return [feature for feature in features if feature.from_m.size]


def _within(trip: "Trip", name: str, stretches: Sequence[tuple[float, float]]) -> Feature:
    """Part of stretches within the trip."""
    from_m, length_m = np.array(stretches, dtype=np.float64).T
    to_m = np.minimum(from_m + length_m, trip.destination_m)
    from_m = np.maximum(from_m, trip.origin_m)
    met = to_m >= from_m
    return Feature(name, from_m[met], (to_m - from_m)[met])


def altitude_of(trip: "Trip") -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Positions and altitudes (m) of the trip's breaks of gradient; None where the trip is level."""
    gradients = np.array(trip.track.gradients or ((0.0, 0.0),), dtype=np.float64)
    position_m = np.append(gradients[:, 0], trip.track.length_m)
    climb_m = np.diff(position_m) * gradients[:, 1] / 1000.0
    altitude_m = trip.track.altitude_m + np.concatenate(([0.0], np.cumsum(climb_m)))
    inside = position_m[(position_m > trip.origin_m) & (position_m < trip.destination_m)]
    shown_m = np.concatenate(([trip.origin_m], inside, [trip.destination_m]))
    shown_altitude_m = np.interp(shown_m, position_m, altitude_m)
    return (shown_m, shown_altitude_m) if np.ptp(shown_altitude_m) > 0.0 else None


def speed_limits_of(trip: "Trip") -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Positions on the track (m) from which speed limits (m/s) of line and train hold; the last row ends the trip."""
    limits = np.array(trip.track.speed_limits, dtype=np.float64)
    first = int(np.searchsorted(limits[:, 0], trip.origin_m, side="right")) - 1
    rows = limits[first:][limits[first:, 0] < trip.destination_m]
    position_m = np.append(np.maximum(rows[:, 0], trip.origin_m), trip.destination_m)
    return position_m, np.minimum(np.append(rows[:, 1], rows[-1, 1]), trip.train.max_speed_mps)


def line_object(trip: "Trip") -> dict[str, Any]:
    """Limits, altitude and features between origin and destination, in plain types; positions count on the track."""
    limits = zip(*(column.tolist() for column in speed_limits_of(trip)), strict=True)
    terrain = altitude_of(trip)
    level = [(end_m, trip.track.altitude_m) for end_m in (trip.origin_m, trip.destination_m)]
    heights = level if terrain is None else zip(*(column.tolist() for column in terrain), strict=True)
    return {
        "limits": [{"from_m": from_m, "speed_mps": speed_mps} for from_m, speed_mps in limits],
        "altitude": [{"position_m": position_m, "altitude_m": altitude_m} for position_m, altitude_m in heights],
        "features": {
            feature.name: [
                {"from_m": from_m, "to_m": from_m + length_m}
                for from_m, length_m in zip(feature.from_m.tolist(), feature.length_m.tolist(), strict=True)
            ]
            for feature in features_of(trip)
        },
    }
