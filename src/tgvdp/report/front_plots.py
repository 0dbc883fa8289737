"""Pictures of the trade-off: delay on x, energy saved on y, top left is better."""

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from tgvdp.errors import InputError
from tgvdp.report import style
from tgvdp.report.tables import saved_pct

if TYPE_CHECKING:
    from tgvdp.api import SearchResult

_LABELS = 6


def plot_front(result: "SearchResult", lower_bound_j: ArrayLike | None = None) -> Figure:
    """Draw the Pareto front of a search.

    Parameters
    ----------
    result : SearchResult
    lower_bound_j : (n,) array_like, optional
        Proven lower bound of the energy at each point of the front, J: drawn as the band within which the true optimum
        lies.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        When there is not one bound per point.
    """
    figure = style.new_figure(right_in=0.85)
    axes = figure.add_subplot()
    delay, saved, scale = delay_and_saving(result, result.front.time_s, result.front.energy_j)
    ceiling = saved if lower_bound_j is None else _draw_band(axes, result, delay, lower_bound_j)
    axes.plot(delay, saved, "-o", color=style.BLUE, linewidth=1.8, markersize=4.5, label="Pareto front", zorder=3)
    _draw_fastest(axes)
    _label_margins(axes, result, delay, saved)
    _dress(axes, result, scale)
    _add_energy_axis(axes, result)
    _set_limits(axes, delay, np.append(saved, ceiling))
    style.title(axes, "Energy saved against delay: top left is better", heading(result))
    style.legend(axes, "lower right")
    return figure


def plot_metric(result: "SearchResult") -> Figure:
    """Draw the seed's metric: every path that reached the terminal, coloured by energy saved per delay.

    Parameters
    ----------
    result : SearchResult

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = style.new_figure()
    axes = figure.add_subplot()
    delay, saved, scale = delay_and_saving(result, result.path_time_s, result.path_energy_j)
    front_delay, front_saved, _ = delay_and_saving(result, result.front.time_s, result.front.energy_j, scale)
    axes.plot(front_delay, front_saved, color=style.MUTED, linewidth=1.0, label="Pareto front", zorder=2)
    rated = (delay > 0.0) & (saved > 0.0)
    axes.scatter(delay[~rated], saved[~rated], s=22, color=style.FAINT, edgecolors=style.MUTED, linewidths=0.5)
    points = axes.scatter(delay[rated], saved[rated], s=30, c=saved[rated] / delay[rated], cmap="viridis", zorder=3)
    if rated.any():
        bar = figure.colorbar(points, ax=axes, pad=0.02)
        bar.set_label(f"energy saved per delay (%/{scale.unit})", fontsize=style.LABEL_PT, fontfamily=style.FONT)
        bar.ax.tick_params(labelsize=style.SMALL_PT, labelfontfamily=style.FONT)
        bar.outline.set_visible(False)
    _draw_fastest(axes)
    best = best_index(result)
    axes.plot(
        front_delay[best], front_saved[best], "o", markersize=13, markerfacecolor="none", zorder=4,
        markeredgecolor=style.VERMILION, markeredgewidth=1.8, linestyle="none", label="path of the speed curve",
    )  # fmt: skip
    _dress(axes, result, scale)
    _set_limits(axes, np.append(delay, front_delay), np.append(saved, front_saved))
    style.title(axes, "One of the metrics tested (top left is better)", f"{heading(result)}, {delay.size} paths")
    style.legend(axes, "lower right")
    return figure


def delay_and_saving(
    result: "SearchResult", time_s: NDArray[np.float64], energy_j: NDArray[np.float64], scale: style.Scale | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64], style.Scale]:
    """Delay in a readable unit and energy saved in percent, both against the fastest run, and that unit."""
    delay_s = np.asarray(time_s) - result.fastest.time_s
    if scale is None:
        scale = style.time_scale(float(delay_s.max(initial=0.0)))
    saved = np.array([saved_pct(energy, result.fastest.energy_j) for energy in np.asarray(energy_j).tolist()])
    return delay_s * scale.factor, saved, scale


def best_index(result: "SearchResult") -> int:
    """Index of the point with the best balance: farthest above the chord between the ends of the front.

    The ratio of saving to delay alone would always choose the smallest delay, since the front is steepest there.
    """
    front = result.front
    if len(front) < 3:
        return len(front) - 1
    delay = (front.time_s - front.time_s[0]) / (front.time_s[-1] - front.time_s[0])
    energy = (front.energy_j - front.energy_j[-1]) / (front.energy_j[0] - front.energy_j[-1])
    return int(np.argmin(delay + energy))


def heading(result: "SearchResult") -> str:
    """Train, line and distance in one line."""
    trip = result.trip
    scale = style.distance_scale(trip.distance_m)
    return f"{trip.train.name} on {trip.track.name}, {trip.distance_m * scale.factor:.4g} {scale.unit}"


def _draw_fastest(axes: Axes) -> None:
    axes.plot(
        [0.0], [0.0], "*", markersize=15, color=style.VERMILION, markeredgecolor="white", linestyle="none",
        label="fastest run", zorder=5,
    )  # fmt: skip


def _draw_band(
    axes: Axes, result: "SearchResult", delay: NDArray[np.float64], lower_bound_j: ArrayLike
) -> NDArray[np.float64]:
    """Draw the room between the front and what is proven; returns its upper edge, where there is one."""
    bound_j = np.asarray(lower_bound_j, dtype=np.float64)
    if bound_j.shape != delay.shape:
        raise InputError(f"front plot: lower_bound_j must have {delay.size} values, got {bound_j.size}")
    _, ceiling, _ = delay_and_saving(result, result.front.time_s, bound_j)
    _, saved, _ = delay_and_saving(result, result.front.time_s, result.front.energy_j)
    axes.fill_between(
        delay, saved, ceiling, color=style.SKY, alpha=0.45, linewidth=0, label="room up to the proven bound", zorder=2
    )
    return ceiling[np.isfinite(ceiling)]


def _label_margins(axes: Axes, result: "SearchResult", delay: NDArray[np.float64], saved: NDArray[np.float64]) -> None:
    """Label the points nearest to a few round margins."""
    margins = 100.0 * (result.front.time_s / result.fastest.time_s - 1.0)
    top = float(margins.max(initial=0.0))
    if top <= 0.0:
        return
    step = _round_step(top / _LABELS)
    wanted = np.arange(step, top + 0.1 * step, step)
    distances = np.abs(margins - wanted[:, None])
    for index in np.unique(distances.argmin(axis=1)[distances.min(axis=1) < 0.25 * step]).tolist():
        # Below the curve there is always room, except past its right end: there the label goes above.
        side, offset = ("left", (6.0, -13.0)) if delay[index] < 0.9 * delay[-1] else ("right", (8.0, 11.0))
        axes.annotate(
            f"+{margins[index]:.{1 if step >= 1.0 else 2}f} % time", (delay[index], saved[index]), offset,
            textcoords="offset points", ha=side, fontsize=style.SMALL_PT, fontfamily=style.FONT, color=style.INK,
        )  # fmt: skip


def _round_step(least: float) -> float:
    """Smallest of 1, 2, 5 times a power of ten that is at least ``least``."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= least * (1.0 - 1e-9))


def _dress(axes: Axes, result: "SearchResult", scale: style.Scale) -> None:
    reference = style.clock(float(result.fastest.time_s))
    style.dress(axes, f"Delay ({scale.unit}) over the fastest run of {reference}", "Energy saved (%)")


def _add_energy_axis(axes: Axes, result: "SearchResult") -> None:
    """Show the energy itself on the right."""
    fastest_j = float(result.fastest.energy_j)
    if not fastest_j > 0.0:
        return
    scale = style.energy_scale(fastest_j)
    whole = fastest_j * scale.factor
    right = axes.secondary_yaxis(
        "right",
        functions=(
            lambda saved: whole * (1.0 - np.asarray(saved) / 100.0),
            lambda energy: 100.0 * (1.0 - np.asarray(energy) / whole),
        ),
    )
    right.set_ylabel(f"Energy at the wheel ({scale.unit})", fontsize=style.LABEL_PT, fontfamily=style.FONT)
    right.tick_params(labelsize=style.SMALL_PT, colors=style.INK, labelfontfamily=style.FONT)
    right.spines["right"].set_color(style.MUTED)


def _set_limits(axes: Axes, delay: NDArray[np.float64], saved: NDArray[np.float64]) -> None:
    """Frame the points and the fastest run, also when there is only one of them."""
    for setter, values in ((axes.set_xlim, delay), (axes.set_ylim, saved)):
        low, high = min(0.0, float(values.min(initial=0.0))), max(0.0, float(values.max(initial=0.0)))
        pad = 0.06 * (high - low) or 1.0
        setter(low - pad, high + pad * 1.5)
