"""The line below a picture of runs: its altitude, and as bars its stops, neutral sections, tunnels and curves."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from tgvdp.report import palette, style
from tgvdp.report.line_met import Feature

if TYPE_CHECKING:
    from tgvdp.model.trip import Trip

#: Height of one bar of the strip, and of the altitude, inches.
BAR_IN, TERRAIN_IN = 0.2, 0.85
#: Shortest drawn bar, as a share of the trip: a neutral section of 100 m on a line of 100 km shall be seen.
_LEAST_SHARE = 0.004
_BAR_COLORS = {
    "stops": palette.INK,
    "neutral": palette.PURPLE,
    "lowered": palette.PURPLE,
    "tunnels": palette.MUTED,
    "curves": palette.SKY,
}


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


def draw_terrain(
    axes: Axes, trip: "Trip", terrain: tuple[NDArray[np.float64], NDArray[np.float64]], along: float
) -> None:
    """Draw the altitude."""
    position_m, altitude_m = terrain
    low, high = float(altitude_m.min()), float(altitude_m.max())
    floor = low - 0.25 * (high - low)
    axes.fill_between(position_m * along, floor, altitude_m, color=palette.GROUND, linewidth=0)
    axes.plot(position_m * along, altitude_m, color=palette.MUTED, linewidth=1.2)
    style.dress(axes, "", "Altitude (m)" if trip.track.altitude_m else "Height (m)")
    axes.set_ylim(floor, high + 0.15 * (high - low))
    axes.locator_params(axis="y", nbins=3)
