"""Pictures of the trade-off: delay on x, energy saved on y, top left is better."""

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axes._secondary_axes import SecondaryAxis
from numpy.typing import ArrayLike, NDArray

from tgvdp.errors import InputError
from tgvdp.report import palette, style
from tgvdp.report.tables import saved_pct
from tgvdp.units import JOULE_PER_KWH

if TYPE_CHECKING:
    from tgvdp.api import SearchResult
    from tgvdp.model.trip import Trip

_LABELS = 6
#: Points of a front that are marked one by one; more would be a band.
_MARKED = 100
#: Prices above this multiple of their median are cut off.
_PRICE_SHOWN = 5.0


def plot_front(result: "SearchResult", lower_bound_j: ArrayLike | None = None) -> style.Picture:
    """Draw the Pareto front of a search, and the paths that were found beside it.

    Parameters
    ----------
    result : SearchResult
    lower_bound_j : (n,) array_like, optional
        Proven lower bound of the energy at each point of the front, J: drawn as the band within which the true optimum
        lies, where there is a bound.

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
    shown = [saved, _draw_dominated(axes, result, scale)]
    if lower_bound_j is not None:
        shown.append(_draw_band(axes, result, delay, lower_bound_j))
    mark = "o" if delay.size <= _MARKED else None
    axes.plot(
        delay, saved, marker=mark, color=palette.BLUE, linewidth=1.8, markersize=4.5, label="Pareto front", zorder=3
    )
    _draw_fastest(axes)
    _label_margins(axes, result, delay, saved)
    reference = style.clock(float(result.fastest.time_s))
    style.dress(axes, f"Delay ({scale.unit}) over the fastest run of {reference}", "Energy saved (%)")
    _add_energy_axis(axes, result)
    _set_limits(axes, delay, np.concatenate(shown))
    style.title(axes, "How much energy does a later arrival save?", f"{heading(result.trip)}; top left is better")
    style.legend(axes, "lower right")
    return figure


def plot_price(result: "SearchResult", price_per_kwh: float | None = None) -> style.Picture:
    """Draw what one more minute saves at each point of the front, of a search by method ``front``.

    Parameters
    ----------
    result : SearchResult
    price_per_kwh : float, optional
        €/kWh: adds an axis in €/min, where the energy is that at the pantograph.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        When the method knows no prices.
    """
    if result.price_kwh_per_min is None:
        raise InputError(f"price plot: method {result.method} knows no prices; method front does")
    # Money is paid for the energy that is drawn.
    in_money = bool(price_per_kwh) and result.trip.energy.kind != "wheel"
    figure = style.new_figure(right_in=0.85 if in_money else 0.3)
    axes = figure.add_subplot()
    energy = style.energy_scale(float(np.abs(result.front.energy_j).max()))
    price = np.where(np.isfinite(result.price_kwh_per_min), result.price_kwh_per_min, np.nan)
    shown = price * (JOULE_PER_KWH * energy.factor)
    margin = 100.0 * (result.front.time_s / result.fastest.time_s - 1.0)
    axes.plot(
        margin, shown, marker="o" if margin.size <= _MARKED else None, color=palette.BLUE, linewidth=1.8, markersize=4.5
    )
    style.dress(axes, "Running time supplement (%)", f"Energy saved per minute ({energy.unit}/min)")
    highest = float(np.nanmax(shown, initial=0.0))
    if highest > 0.0:
        top = _shown_price(shown)
        axes.set_ylim(0.0, top)
        if highest > top:
            axes.annotate(
                f"↑ up to {highest:.4g} {energy.unit}/min", (float(margin[np.nanargmax(shown)]), top), (14.0, -4.0),
                textcoords="offset points", va="top", fontsize=style.SMALL_PT, fontfamily=style.FONT, color=palette.INK,
            )  # fmt: skip
    axes.set_xlim(left=0.0)
    if price_per_kwh and in_money:
        money = price_per_kwh / (JOULE_PER_KWH * energy.factor)
        right = axes.secondary_yaxis(
            "right", functions=(lambda value: money * np.asarray(value), lambda value: np.asarray(value) / money)
        )
        _dress_right(right, "Money saved per minute (€/min)")
    style.title(axes, "What does one more minute save?", f"{energy_name(result.trip)}, {heading(result.trip)}")
    return figure


def _shown_price(price: NDArray[np.float64]) -> float:
    """Top of the axis: next to the fastest run prices grow without bound and would flatten the rest."""
    known = price[np.isfinite(price)]
    return 1.1 * min(float(known.max()), _PRICE_SHOWN * float(np.median(known)) or 1.0)


def energy_name(trip: "Trip") -> str:
    """Name of the energy that all figures of a result count."""
    model = trip.energy
    return f"Energy by {model.map.name}" if model.map is not None else f"Energy at the {model.kind}"


def delay_and_saving(
    result: "SearchResult", time_s: NDArray[np.float64], energy_j: NDArray[np.float64], scale: style.Scale | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64], style.Scale]:
    """Delay in a readable unit and energy saved in percent, both against the fastest run, and that unit."""
    delay_s = np.asarray(time_s) - result.fastest.time_s
    if scale is None:
        scale = style.time_scale(float(delay_s.max(initial=0.0)))
    saved = np.array([saved_pct(energy, result.fastest.energy_j) for energy in np.asarray(energy_j).tolist()])
    return delay_s * scale.factor, saved, scale


def heading(trip: "Trip") -> str:
    """Train, line and distance in one line."""
    scale = style.distance_scale(trip.distance_m)
    return f"{trip.train.name} on {trip.track.name}, {trip.distance_m * scale.factor:.4g} {scale.unit}"


def _draw_fastest(axes: Axes) -> None:
    axes.plot(
        [0.0], [0.0], "*", markersize=15, color=palette.VERMILION, markeredgecolor="white", linestyle="none",
        label="fastest run", zorder=5,
    )  # fmt: skip


def _draw_dominated(axes: Axes, result: "SearchResult", scale: style.Scale) -> NDArray[np.float64]:
    """Draw the paths that were found and lie below the front; returns their savings."""
    below = np.ones(result.path_time_s.size, dtype=bool)
    below[result.front.source] = False
    delay, saved, _ = delay_and_saving(result, result.path_time_s[below], result.path_energy_j[below], scale)
    if result.method != "front" and delay.size:
        axes.plot(
            delay, saved, "o", color=palette.FAINT, markeredgecolor=palette.MUTED, markeredgewidth=0.5, markersize=4.0,
            label="other paths found", zorder=2,
        )  # fmt: skip
        return saved
    return saved[:0]


def _draw_band(
    axes: Axes, result: "SearchResult", delay: NDArray[np.float64], lower_bound_j: ArrayLike
) -> NDArray[np.float64]:
    """Draw the room between the front and what is proven; returns its upper edge, where there is one."""
    bound_j = np.asarray(lower_bound_j, dtype=np.float64)
    if bound_j.shape != delay.shape:
        raise InputError(f"front plot: lower_bound_j must have {delay.size} values, got {bound_j.size}")
    _, ceiling, _ = delay_and_saving(result, result.front.time_s, bound_j)
    _, saved, _ = delay_and_saving(result, result.front.time_s, result.front.energy_j)
    known = np.isfinite(ceiling)
    if not known.any():
        return ceiling[known]
    # In kWh: per cent of the fastest run's energy, as on this axis, are not the per cent of the table's gaps.
    most_kwh = max(float((result.front.energy_j - bound_j)[known].max()), 0.0) / JOULE_PER_KWH
    axes.fill_between(
        delay, saved, np.where(known, ceiling, np.nan), color=palette.SKY, alpha=0.45, linewidth=0, zorder=2,
        label=f"room up to the proven bound, at most {most_kwh:.3g} kWh",
    )  # fmt: skip
    return ceiling[known]


def _label_margins(axes: Axes, result: "SearchResult", delay: NDArray[np.float64], saved: NDArray[np.float64]) -> None:
    """Mark round margins on the front, and say what they save."""
    margins = 100.0 * (result.front.time_s / result.fastest.time_s - 1.0)
    top = float(margins.max(initial=0.0))
    if top <= 0.0:
        return
    step = _round_step(top / _LABELS)
    # A point may stand a hundredth of a second before the round margin that was asked for.
    wanted = np.arange(step, top + 1e-3 * step + 1e-2, step)
    wanted = wanted[wanted >= margins[0]]
    at, height = np.interp(wanted, margins, delay), np.interp(wanted, margins, saved)
    axes.plot(at, height, "D", color=palette.INK, markersize=6.0, zorder=4)
    for margin, x, y in zip(wanted.tolist(), at.tolist(), height.tolist(), strict=True):
        # Below the curve there is always room, except past its right end: there the label goes above.
        side, offset = ("left", (6.0, -13.0)) if x < 0.9 * delay[-1] else ("right", (8.0, 11.0))
        axes.annotate(
            f"+{margin:g} %: {y:.1f} % saved", (x, y), offset,
            textcoords="offset points", ha=side, fontsize=style.SMALL_PT, fontfamily=style.FONT, color=palette.INK,
        )  # fmt: skip


def _round_step(least: float) -> float:
    """Smallest of 1, 2, 5 times a power of ten that is at least ``least``."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= least * (1.0 - 1e-9))


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
    _dress_right(right, f"{energy_name(result.trip)} ({scale.unit})")


def _dress_right(right: SecondaryAxis, label: str) -> None:
    right.set_ylabel(label, fontsize=style.LABEL_PT, fontfamily=style.FONT, color=palette.INK)
    right.tick_params(labelsize=style.SMALL_PT, colors=palette.INK, labelfontfamily=style.FONT)
    right.spines["right"].set_color(palette.MUTED)


def _set_limits(axes: Axes, delay: NDArray[np.float64], saved: NDArray[np.float64]) -> None:
    """Frame the points and the fastest run, also when there is only one of them."""
    for setter, values in ((axes.set_xlim, delay), (axes.set_ylim, saved)):
        low, high = min(0.0, float(values.min(initial=0.0))), max(0.0, float(values.max(initial=0.0)))
        pad = 0.06 * (high - low) or 1.0
        setter(low - pad, high + pad * 1.5)
