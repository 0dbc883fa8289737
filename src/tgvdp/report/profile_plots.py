"""Pictures of runs: speed over distance, what the driver does in colour, under the speed limits, over the terrain."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from tgvdp.report import style
from tgvdp.report.front_plots import best_index, heading
from tgvdp.report.tables import margin_pct, saved_pct
from tgvdp.runs.profile import REGIMES

if TYPE_CHECKING:
    from tgvdp.api import SearchResult
    from tgvdp.model.trip import Trip
    from tgvdp.runs.profile import Profile

#: Dashes and width, as matplotlib takes them.
_LineStyle: TypeAlias = tuple[Any, float]
#: ... of the fastest, the middle and the thriftiest run.
_STYLES: tuple[_LineStyle, ...] = (((0, (1.2, 1.2)), 1.6), ((0, (5.0, 1.5)), 1.8), ("-", 2.4))
#: A speed curve is drawn straight over at most this part of its top speed.
_FINENESS = 0.01
#: Limits above this multiple of the top speed are cut off.
_LIMIT_SHOWN = 2.0
#: Bottom margin with room for the names of the runs, inches.
_LEGEND_IN = 0.95


def plot_profile(result: "SearchResult") -> Figure:
    """Draw speed over distance for the fastest, a middle and the thriftiest run.

    Parameters
    ----------
    result : SearchResult

    Returns
    -------
    matplotlib.figure.Figure
    """
    runs = [(f"fastest, {style.clock(result.fastest.time_s)}", result.fastest.profile)]
    last = len(result.front) - 1
    for index in sorted({last // 2, last} - {-1}):
        profile = result.profile(index)
        runs.append((_describe(result, profile), profile))
    figure = _plot_runs(result, runs, _STYLES[: len(runs) - 1] + _STYLES[-1:])
    style.title(figure.axes[0], "Speed over distance", heading(result))
    return figure


def plot_speed_curve(result: "SearchResult") -> Figure:
    """Draw the seed's picture: the speed curve of the path with the best balance of delay and energy.

    Parameters
    ----------
    result : SearchResult

    Returns
    -------
    matplotlib.figure.Figure
    """
    best = best_index(result)
    profile = result.profile(best) if best >= 0 else result.fastest.profile
    figure = _plot_runs(result, [(_describe(result, profile), profile)], _STYLES[-1:])
    style.title(figure.axes[0], "Optimized speed curve", heading(result))
    return figure


def _describe(result: "SearchResult", profile: "Profile") -> str:
    margin = margin_pct(profile.duration_s, result.fastest.time_s)
    saved = saved_pct(profile.total_energy_j, result.fastest.energy_j)
    return f"{margin:+.1f} % time, {-saved:+.1f} % energy".replace("-", "−")


def _plot_runs(result: "SearchResult", runs: Sequence[tuple[str, "Profile"]], styles: Sequence[_LineStyle]) -> Figure:
    trip = result.trip
    terrain = altitude_of(trip)
    if terrain is None:
        figure = style.new_figure(bottom_in=_LEGEND_IN)
        speed_axes = lowest_axes = figure.add_subplot()
    else:
        figure = style.new_figure(style.HEIGHT_IN + 1.0, bottom_in=_LEGEND_IN)
        speed_axes, lowest_axes = figure.subplots(2, 1, sharex=True, height_ratios=[4.5, 1.0])
    along = style.distance_scale(trip.distance_m)
    limit_position_m, limit_mps = speed_limits_of(trip)
    top_mps = max(float(profile.speed_mps.max()) for _, profile in runs)
    speed = style.speed_scale(top_mps)
    # A limit far above what the train reaches would flatten the curves.
    ceiling_mps = _LIMIT_SHOWN * top_mps
    if limit_mps.min() <= ceiling_mps:
        ceiling_mps = min(ceiling_mps, float(limit_mps.max()))
        speed_axes.step(
            limit_position_m * along.factor, limit_mps * speed.factor, where="post", color=style.MUTED, linewidth=1.2,
            label="speed limit",
        )  # fmt: skip
    else:
        ceiling_mps = top_mps
    for (_, profile), line_style in zip(runs, styles, strict=True):
        _draw_run(speed_axes, profile, along.factor, speed.factor, line_style)
    style.dress(speed_axes, "", f"Speed ({speed.unit})")
    speed_axes.set_ylim(0.0, 1.06 * speed.factor * ceiling_mps)
    if terrain is not None:
        _draw_terrain(lowest_axes, trip, terrain, along.factor)
        speed_axes.tick_params(labelbottom=False)
    lowest_axes.set_xlabel(f"Position on the line ({along.unit})", fontsize=style.LABEL_PT, fontfamily=style.FONT)
    lowest_axes.set_xlim(trip.origin_m * along.factor, trip.destination_m * along.factor)
    _add_legends(figure, speed_axes, runs, styles)
    return figure


def speed_limits_of(trip: "Trip") -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Positions on the track (m) from which speed limits (m/s) of line and train hold; the last row ends the trip."""
    limits = np.array(trip.track.speed_limits, dtype=np.float64)
    first = int(np.searchsorted(limits[:, 0], trip.origin_m, side="right")) - 1
    rows = limits[first:][limits[first:, 0] < trip.destination_m]
    position_m = np.append(np.maximum(rows[:, 0], trip.origin_m), trip.destination_m)
    return position_m, np.minimum(np.append(rows[:, 1], rows[-1, 1]), trip.train.max_speed_mps)


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


def _draw_run(axes: Axes, profile: "Profile", along: float, speed: float, line_style: _LineStyle) -> None:
    """Draw one line whose pieces have the colour of their regime."""
    position_m, speed_mps, row = speed_curve(profile)
    points = np.column_stack((position_m * along, speed_mps * speed))
    codes = profile.regime[row]
    starts = np.concatenate(([0], np.flatnonzero(np.diff(codes)) + 1))
    ends = np.append(starts[1:], codes.size - 1)
    pieces = [points[start : end + 1] for start, end in zip(starts, ends, strict=True)]
    colors = [style.REGIME_COLORS[REGIMES[codes[start]]] for start in starts]
    dashes, width = line_style
    axes.add_collection(
        LineCollection(pieces, colors=colors, linewidths=width, linestyles=[dashes], capstyle="butt", zorder=3)
    )


def _draw_terrain(
    axes: Axes, trip: "Trip", terrain: tuple[NDArray[np.float64], NDArray[np.float64]], along: float
) -> None:
    position_m, altitude_m = terrain
    low, high = float(altitude_m.min()), float(altitude_m.max())
    floor = low - 0.25 * (high - low)
    axes.fill_between(position_m * along, floor, altitude_m, color=style.GROUND, linewidth=0)
    axes.plot(position_m * along, altitude_m, color=style.MUTED, linewidth=1.2)
    style.dress(axes, "", "Altitude (m)" if trip.track.altitude_m else "Height (m)")
    axes.set_ylim(floor, high + 0.15 * (high - low))
    axes.locator_params(axis="y", nbins=3)


def _add_legends(
    figure: Figure, axes: Axes, runs: Sequence[tuple[str, "Profile"]], styles: Sequence[_LineStyle]
) -> None:
    """Name the runs below the picture; regimes and speed limit above it."""
    used = {int(code) for _, profile in runs for code in np.unique(profile.regime)}
    names = [name for code, name in enumerate(REGIMES) if code in used]
    entries = [
        Line2D([], [], color=style.INK, linestyle=dashes, linewidth=width, label=label)
        for (label, _), (dashes, width) in zip(runs, styles, strict=True)
    ]
    style.legend(figure, "lower center", entries, len(entries))
    regimes = [Line2D([], [], color=style.REGIME_COLORS[name], linewidth=3.0, label=name) for name in names]
    limit = axes.get_legend_handles_labels()[0]
    style.legend(axes, "above right", [*regimes, *limit], len(regimes) + len(limit))


def speed_curve(profile: "Profile") -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """Points of a smooth speed curve.

    Returns
    -------
    position_m, speed_mps : (m,) float64
        v² is linear in position between rows, so rows are cut where the speed changes much.
    row : (m,) int64
        The row of the profile that each point lies in.
    """
    speed = profile.speed_mps
    steps = np.ceil(np.abs(np.diff(speed)) / (_FINENESS * max(float(speed.max()), np.finfo(float).tiny)))
    count = np.append(np.clip(steps, 1, 1.0 / _FINENESS), 1).astype(np.int64)
    row = np.repeat(np.arange(speed.size), count)
    part = (np.arange(row.size) - np.repeat(np.cumsum(count) - count, count)) / np.repeat(count, count)
    after = np.minimum(row + 1, speed.size - 1)
    w = speed * speed
    position = profile.position_m[row] + part * (profile.position_m[after] - profile.position_m[row])
    return position, np.sqrt(w[row] + part * (w[after] - w[row])), row
