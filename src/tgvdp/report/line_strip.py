"""The line below a picture of runs: its altitude, and as bars its stops, neutral sections, tunnels and curves."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from tgvdp.report import style

if TYPE_CHECKING:
    from tgvdp.model.trip import Trip

#: Height of one bar of the strip, and of the altitude, inches.
BAR_IN, TERRAIN_IN = 0.2, 0.85
#: Shortest drawn bar, as a share of the trip: a neutral section of 100 m on a line of 100 km shall be seen.
_LEAST_SHARE = 0.004
_BAR_COLORS = {
    "stops": style.INK,
    "neutral": style.PURPLE,
    "lowered": style.PURPLE,
    "tunnels": style.MUTED,
    "curves": style.SKY,
}


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
    found = zip(_BAR_COLORS, (stops, *neutral, tunnels, curves), strict=True)
    features = [_within(trip, name, stretches) for name, stretches in found if stretches]
    return [feature for feature in features if feature.from_m.size]


def _within(trip: "Trip", name: str, stretches: Sequence[tuple[float, float]]) -> Feature:
    """Part of stretches within the trip."""
    from_m, length_m = np.array(stretches, dtype=np.float64).T
    to_m = np.minimum(from_m + length_m, trip.destination_m)
    from_m = np.maximum(from_m, trip.origin_m)
    met = to_m >= from_m
    return Feature(name, from_m[met], (to_m - from_m)[met])


def draw_features(axes: Axes, trip: "Trip", features: Sequence[Feature], along: float) -> None:
    """Draw one row of bars per kind, the first on top."""
    least_m = _LEAST_SHARE * trip.distance_m
    for row, feature in enumerate(features):
        width_m = np.maximum(feature.length_m, least_m)
        left_m = feature.from_m + 0.5 * (feature.length_m - width_m)
        bars = np.column_stack((left_m, width_m)) * along
        axes.broken_barh(bars.tolist(), (row - 0.32, 0.64), facecolor=_BAR_COLORS[feature.name], linewidth=0)
    style.dress(axes)
    axes.grid(False)
    axes.set_ylim(len(features) - 0.4, -0.6)
    axes.set_yticks(range(len(features)), [feature.name for feature in features])
    axes.tick_params(axis="y", length=0, labelsize=style.SMALL_PT - 1.5)
    axes.spines["left"].set_visible(False)


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


def draw_terrain(
    axes: Axes, trip: "Trip", terrain: tuple[NDArray[np.float64], NDArray[np.float64]], along: float
) -> None:
    """Draw the altitude."""
    position_m, altitude_m = terrain
    low, high = float(altitude_m.min()), float(altitude_m.max())
    floor = low - 0.25 * (high - low)
    axes.fill_between(position_m * along, floor, altitude_m, color=style.GROUND, linewidth=0)
    axes.plot(position_m * along, altitude_m, color=style.MUTED, linewidth=1.2)
    style.dress(axes, "", "Altitude (m)" if trip.track.altitude_m else "Height (m)")
    axes.set_ylim(floor, high + 0.15 * (high - low))
    axes.locator_params(axis="y", nbins=3)
