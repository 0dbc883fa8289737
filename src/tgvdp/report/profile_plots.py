"""Pictures of runs over the line and over time: what the driver does in colour, the run by its dashes."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from tgvdp.report import palette, style
from tgvdp.report.front_plots import heading
from tgvdp.report.line_met import altitude_of, features_of, speed_limits_of
from tgvdp.report.line_strip import BAR_IN, TERRAIN_IN, draw_features, draw_terrain
from tgvdp.report.tables import margin_pct, saved_pct
from tgvdp.runs.profile import REGIMES

if TYPE_CHECKING:
    from tgvdp.api import SearchResult
    from tgvdp.model.trip import Trip
    from tgvdp.runs.profile import Profile

Floats: TypeAlias = NDArray[np.float64]
#: Dashes and width, as matplotlib takes them, of the fastest, the middle and the thriftiest run.
_STYLES: tuple[tuple[Any, float], ...] = (((0, (1.2, 1.2)), 1.6), ((0, (5.0, 1.5)), 1.8), ("-", 2.4))
#: A speed curve is drawn straight over at most this part of its top speed.
_FINENESS = 0.01
#: Limits above this multiple of the top speed are cut off.
_LIMIT_SHOWN = 2.0
#: Runs whose effort jumps more often, by this share of the largest, are drawn as means over so many stretches.
_MOST_SWITCHES, _JUMP, _STRETCHES = 100, 0.1, 120
#: Margins with room for the names of the runs, inches.
_LEGEND_IN, _TOP_IN = 0.95, 0.66


class Run(NamedTuple):
    """A run to be drawn: its name, and how its line looks."""

    label: str
    profile: "Profile"
    dashes: Any
    width: float


def runs_shown(result: "SearchResult") -> list[Run]:
    """The fastest, a middle and the thriftiest run, as far as there are so many."""
    count = len(result.front)
    chosen = [(f"fastest, {style.clock(result.fastest.time_s)}", result.fastest.profile)]
    if count:
        chosen += [_described(result, result.profile(index)) for index in sorted({count // 2, count - 1})]
    looks = [*_STYLES[: len(chosen) - 1], _STYLES[-1]]
    return [Run(*run, *look) for run, look in zip(chosen, looks, strict=True)]


def run_of(result: "SearchResult", index: int) -> list[Run]:
    """One point of the front."""
    return [Run(*_described(result, result.profile(index)), *_STYLES[-1])]


def _described(result: "SearchResult", profile: "Profile") -> tuple[str, "Profile"]:
    margin = margin_pct(profile.duration_s, result.fastest.time_s)
    saved = saved_pct(profile.total_energy_j, result.fastest.energy_j)
    return f"{margin:+.1f} % time, {-saved:+.1f} % energy".replace("-", "−"), profile


def plot_profile(result: "SearchResult", runs: Sequence[Run] | None = None) -> style.Picture:
    """Draw speed over distance, under the speed limits and over the line.

    Parameters
    ----------
    result : SearchResult
    runs : sequence of Run, optional
        By default the fastest, a middle and the thriftiest run.

    Returns
    -------
    matplotlib.figure.Figure
    """
    return plot_speeds(result.trip, runs_shown(result) if runs is None else runs)


def plot_speeds(trip: "Trip", runs: Sequence[Run]) -> style.Picture:
    """Draw speed over distance of some runs, under the speed limits and over the line."""
    figure, (axes,), along = _over_the_line(trip, 1)
    limit = _draw_speed(axes, trip, runs, along)
    style.title(axes, "How to drive?", f"Speed over distance, {heading(trip)}")
    _add_legends(figure, axes, runs, limit)
    return figure


def plot_speed_time(result: "SearchResult") -> style.Picture:
    """Draw speed over time of the fastest, a middle and the thriftiest run."""
    runs = runs_shown(result)
    figure = style.new_figure(bottom_in=_LEGEND_IN)
    axes = figure.add_subplot()
    scale = style.time_scale(max(run.profile.duration_s for run in runs))
    top_mps = max(float(run.profile.speed_mps.max()) for run in runs)
    speed = style.speed_scale(top_mps)
    for run in runs:
        # Between rows the acceleration is constant: speed is linear in time.
        draw_run(axes, run, run.profile.time_s * scale.factor, run.profile.speed_mps * speed.factor, run.profile.regime)
    style.dress(axes, f"Time since departure ({scale.unit})", f"Speed ({speed.unit})")
    axes.set_xlim(0.0, 1.01 * scale.factor * max(run.profile.duration_s for run in runs))
    axes.set_ylim(0.0, 1.06 * speed.factor * top_mps)
    style.title(axes, "Where do the extra minutes go?", f"Speed over time, {heading(result.trip)}")
    _add_legends(figure, axes, runs, [])
    return figure


def plot_effort(result: "SearchResult") -> style.Picture:
    """Draw effort and power at the wheel over distance, the mean of each row.

    A run that switches more often than a picture can show gets means over equal stretches.
    """
    runs = runs_shown(result)
    figure, (upper, lower), along = _over_the_line(result.trip, 2)
    steps = [_effort_steps(run.profile) for run in runs]
    for axes, name, values, scale_of in (
        (upper, "Effort", [one.force_n for one in steps], style.force_scale),
        (lower, "Power", [one.power_w for one in steps], style.power_scale),
    ):
        low, high = (float(end([end(one) for one in values])) for end in (np.min, np.max))
        scale = scale_of(max(abs(low), abs(high)))
        for run, step, of_steps in zip(runs, steps, values, strict=True):
            x = np.repeat(step.edge_m, 2)[1:-1]
            draw_run(axes, run, x * along, np.repeat(of_steps, 2) * scale.factor, np.repeat(step.regime, 2))
        style.dress(axes, "", f"{name} ({scale.unit})")
        pad = 0.06 * (max(high, 0.0) - min(low, 0.0)) or 1.0
        axes.set_ylim(scale.factor * (min(low, 0.0) - pad), scale.factor * (max(high, 0.0) + pad))
        axes.axhline(0.0, color=palette.MUTED, linewidth=0.8)
    averaged = "; pulses are shown as their means" if any(step.averaged for step in steps) else ""
    style.title(upper, "What does it take at the wheel?", f"Effort and power, {heading(result.trip)}{averaged}")
    _add_legends(figure, upper, runs, [])
    return figure


class _Steps(NamedTuple):
    """Efforts as steps: n + 1 edges, n means and regimes; averaged where they are not the rows of the profile."""

    edge_m: Floats
    force_n: Floats
    power_w: Floats
    regime: NDArray[np.int8]
    averaged: bool


def _effort_steps(profile: "Profile") -> _Steps:
    x, t, force_n, regime = profile.position_m, profile.time_s, profile.force_n[:-1], profile.regime[:-1]
    jumps = np.abs(np.diff(force_n)) > _JUMP * float(np.abs(force_n).max())
    averaged = int(np.count_nonzero(jumps)) > _MOST_SWITCHES
    if averaged:
        work_j = np.concatenate(([0.0], np.cumsum(force_n * np.diff(x))))
        edges = np.linspace(x[0], x[-1], _STRETCHES + 1)
        t, work_j = np.interp(edges, x, t), np.interp(edges, x, work_j)
        row = np.searchsorted(x, 0.5 * (edges[:-1] + edges[1:]), side="right") - 1
        x, force_n = edges, np.diff(work_j) / np.diff(edges)
        # Pulses of traction with coasting between them are traction.
        pulses = (regime[row] == REGIMES.index("coasting")) & (force_n > 0.01 * force_n.max())
        regime = np.where(pulses, REGIMES.index("traction"), regime[row]).astype(np.int8)
    return _Steps(x, force_n, force_n * np.diff(x) / np.diff(t), regime, averaged)


def _over_the_line(trip: "Trip", panels: int) -> tuple[style.Picture, list[Axes], float]:
    """Panels over distance, and below them the line; also the factor of their common axis."""
    terrain, features = altitude_of(trip), features_of(trip)
    # Heights in inches: the panels share what a picture has, and what the line needs comes on top.
    panel_in = (style.HEIGHT_IN - _LEGEND_IN - _TOP_IN + (panels - 1) * 1.4) / panels
    heights = [panel_in] * panels
    heights += [BAR_IN * len(features) + 0.06] * bool(features) + [TERRAIN_IN] * (terrain is not None)
    figure = style.new_figure(sum(heights) + 0.12 * (len(heights) - 1) + _LEGEND_IN + _TOP_IN, bottom_in=_LEGEND_IN)
    stack = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0].tolist()
    along = style.distance_scale(trip.distance_m)
    if features:
        draw_features(stack[panels], trip, features, along.factor)
        for section in (one for one in features if one.name in ("neutral", "lowered")):
            for axes in stack[:panels]:
                spans = np.column_stack((section.from_m, section.length_m)) * along.factor
                axes.broken_barh(
                    spans.tolist(), (0.0, 1.0), transform=axes.get_xaxis_transform(), facecolor=palette.PURPLE,
                    alpha=0.25, linewidth=0,
                )  # fmt: skip
    if terrain is not None:
        draw_terrain(stack[-1], trip, terrain, along.factor)
    for axes in stack[:-1]:
        axes.tick_params(labelbottom=False)
    stack[-1].set_xlabel(f"Position on the line ({along.unit})", fontsize=style.LABEL_PT, fontfamily=style.FONT)
    stack[-1].set_xlim(trip.origin_m * along.factor, trip.destination_m * along.factor)
    return figure, stack[:panels], along.factor


def _draw_speed(axes: Axes, trip: "Trip", runs: Sequence[Run], along: float) -> list[Line2D]:
    """Draw speeds and their limit; returns the line of the limit, if it is shown."""
    limit_position_m, limit_mps = speed_limits_of(trip)
    top_mps = max(float(run.profile.speed_mps.max()) for run in runs)
    speed = style.speed_scale(top_mps)
    # A limit far above what the train reaches would flatten the curves.
    ceiling_mps, shown = _LIMIT_SHOWN * top_mps, []
    if limit_mps.min() <= ceiling_mps:
        ceiling_mps = min(ceiling_mps, float(limit_mps.max()))
        shown = axes.step(
            limit_position_m * along, limit_mps * speed.factor, where="post", color=palette.MUTED, linewidth=1.2,
            label="speed limit",
        )  # fmt: skip
    else:
        ceiling_mps = top_mps
    for run in runs:
        position_m, speed_mps, row = speed_curve(run.profile)
        draw_run(axes, run, position_m * along, speed_mps * speed.factor, run.profile.regime[row])
    style.dress(axes, "", f"Speed ({speed.unit})")
    axes.set_ylim(0.0, 1.06 * speed.factor * ceiling_mps)
    return shown


def draw_run(axes: Axes, run: Run, x: Floats, y: Floats, regime: NDArray[np.int8]) -> None:
    """Draw one line whose pieces have the colour of the regime that begins at each of its points."""
    points = np.column_stack((x, y))
    starts = np.concatenate(([0], np.flatnonzero(np.diff(regime)) + 1))
    ends = np.append(starts[1:], regime.size - 1)
    pieces = [points[start : end + 1] for start, end in zip(starts, ends, strict=True)]
    colors = [palette.REGIME_COLORS[REGIMES[regime[start]]] for start in starts]
    axes.add_collection(
        LineCollection(pieces, colors=colors, linewidths=run.width, linestyles=[run.dashes], capstyle="butt", zorder=3)
    )


def _add_legends(figure: style.Picture, axes: Axes, runs: Sequence[Run], limit: Sequence[Line2D]) -> None:
    """Name the runs below the picture; regimes and speed limit above it."""
    used = {int(code) for run in runs for code in np.unique(run.profile.regime)}
    names = [name for code, name in enumerate(REGIMES) if code in used]
    entries = [
        Line2D([], [], color=palette.INK, linestyle=run.dashes, linewidth=run.width, label=run.label) for run in runs
    ]
    style.legend(figure, "lower center", entries, len(entries))
    regimes = [Line2D([], [], color=palette.REGIME_COLORS[name], linewidth=3.0, label=name) for name in names]
    style.legend(axes, "above right", [*regimes, *limit], len(regimes) + len(limit))


def speed_curve(profile: "Profile") -> tuple[Floats, Floats, NDArray[np.int64]]:
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
