"""Figures for papers, of a result that was written: journal widths, small type, no title, fonts embedded."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from tgvdp.report import palette, style
from tgvdp.units import JOULE_PER_KWH

#: Widths of one column and of two, mm, as most journals of the field have them (Elsevier: 90 and 190).
WIDTHS_MM = {"single": 90.0, "double": 190.0}
_MM_PER_INCH = 25.4
_TYPE_PT, _SMALL_PT = 8.0, 7.0
_DPI = 300
_LIMIT_SHOWN = 2.0
_REGIMES = tuple(palette.REGIME_COLORS)


def plot_paper_front(content: Mapping[str, Any], width_mm: float = WIDTHS_MM["single"]) -> style.Picture:
    """Draw energy saved over delay.

    Parameters
    ----------
    content : mapping
        Of schema tgvdp.search/1.
    width_mm : float

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, (axes,) = _figure(width_mm, [0.62])
    front, whole_kwh = content["front"], content["fastest"]["energy_kwh"]
    delay_s = np.array([point["delay_s"] for point in front])
    scale = style.time_scale(float(delay_s.max(initial=0.0)))
    saved = np.array([point["saved_pct"] for point in front])
    bound_kwh = np.array([np.nan if (one := point["lower_bound_kwh"]) is None else one for point in front])
    ceiling = 100.0 * (whole_kwh - bound_kwh) / abs(whole_kwh)
    if np.isfinite(ceiling).any():
        axes.fill_between(
            delay_s * scale.factor, saved, ceiling, color=palette.SKY, alpha=0.5, linewidth=0, label="up to the bound"
        )
    axes.plot(delay_s * scale.factor, saved, color=palette.BLUE, linewidth=1.2, label="Pareto front")
    axes.plot([0.0], [0.0], "*", color=palette.VERMILION, markersize=7, linestyle="none", label="fastest run")
    _dress(axes, f"Delay ({scale.unit})", "Energy saved (%)")
    _legend(axes)
    return figure


def plot_paper_profile(
    content: Mapping[str, Any], profiles: Mapping[str, Mapping[str, Any]], width_mm: float = WIDTHS_MM["single"]
) -> style.Picture:
    """Draw speed over distance of the fastest and the thriftiest run, over the line.

    Parameters
    ----------
    content : mapping
        Of schema tgvdp.search/1.
    profiles : mapping
        Columns by the id of the run: ``position_m``, ``speed_mps`` and ``regime``, an index.
    width_mm : float

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, (upper, lower) = _figure(width_mm, [0.5, 0.17])
    line, trip = content["line"], content["trip"]
    along = style.distance_scale(trip["destination_m"] - trip["origin_m"])
    shown: list[tuple[str, Literal[":", "-"]]] = [("fastest", ":"), (str(content["front"][-1]["id"]), "-")]
    top_mps = max(float(np.max(profiles[name]["speed_mps"])) for name, _ in shown)
    speed = style.speed_scale(top_mps)
    limits = [row for row in line["limits"] if row["speed_mps"] is not None]
    ceiling_mps = max([top_mps, *(row["speed_mps"] for row in limits if row["speed_mps"] <= _LIMIT_SHOWN * top_mps)])
    at = [row["from_m"] * along.factor for row in limits]
    upper.step(
        at, [row["speed_mps"] * speed.factor for row in limits], where="post", color=palette.MUTED, linewidth=0.8
    )
    for name, dashes in shown:
        _draw_run(upper, profiles[name], along.factor, speed.factor, dashes)
    upper.set_ylim(0.0, 1.06 * ceiling_mps * speed.factor)
    _dress(upper, "", f"Speed ({speed.unit})")
    _dress(lower, f"Position on the line ({along.unit})", "Altitude (m)")
    height_m = [row["altitude_m"] for row in line["altitude"]]
    lower.fill_between(
        [row["position_m"] * along.factor for row in line["altitude"]], min(height_m) - 1.0, height_m,
        color=palette.GROUND, linewidth=0,
    )  # fmt: skip
    lower.locator_params(axis="y", nbins=2)
    for axes in (upper, lower):
        axes.set_xlim(trip["origin_m"] * along.factor, trip["destination_m"] * along.factor)
    upper.tick_params(labelbottom=False)
    last = content["front"][-1]
    energy_kwh = content["fastest"]["energy_kwh"]
    energy = style.energy_scale(abs(energy_kwh) * JOULE_PER_KWH)
    names = [
        f"fastest, {_figure_text(energy_kwh, energy)}",
        f"+{last['margin_pct']:.0f} % time, {_figure_text(last['energy_kwh'], energy)}",
    ]
    handles = [Line2D([], [], color=color, label=name) for name, color in palette.REGIME_COLORS.items()]
    handles += [
        Line2D([], [], color=palette.INK, linestyle=look, label=name)
        for name, (_, look) in zip(names, shown, strict=True)
    ]
    figure.legend(
        handles=handles, loc="upper center", ncols=3, frameon=False, borderaxespad=0.1,
        prop={"family": style.FONT, "size": _SMALL_PT},
    )  # fmt: skip
    return figure


def _figure_text(energy_kwh: float, scale: style.Scale) -> str:
    return f"{energy_kwh * JOULE_PER_KWH * scale.factor:.4g} {scale.unit}"


def _figure(width_mm: float, heights: Sequence[float]) -> tuple[style.Picture, list[Axes]]:
    """Panels of some heights, as shares of one column's width, which two columns keep."""
    width_in = width_mm / _MM_PER_INCH
    height_in = sum(heights) * WIDTHS_MM["single"] / _MM_PER_INCH
    bottom_in, top_in = 0.42, 0.1 if len(heights) == 1 else 0.42
    figure = style.Picture(figsize=(width_in, height_in + bottom_in + top_in), dpi=_DPI, facecolor="white")
    whole_in = height_in + bottom_in + top_in
    figure.subplots_adjust(
        left=0.52 / width_in, right=1.0 - 0.16 / width_in, bottom=bottom_in / whole_in, top=1.0 - top_in / whole_in,
        hspace=0.12,
    )  # fmt: skip
    return figure, list(figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0])


def _dress(axes: Axes, x_label: str, y_label: str) -> None:
    style.dress(axes, x_label, y_label)
    axes.tick_params(labelsize=_SMALL_PT, width=0.5, length=2.0)
    for label in (axes.xaxis.label, axes.yaxis.label):
        label.set_fontsize(_TYPE_PT)
    for spine in axes.spines.values():
        spine.set_linewidth(0.5)


def _legend(axes: Axes) -> None:
    axes.legend(loc="lower right", frameon=False, prop={"family": style.FONT, "size": _SMALL_PT})


def _draw_run(axes: Axes, rows: Mapping[str, Any], along: float, speed: float, dashes: str) -> None:
    """Draw a run in the colours of its regimes; v² is linear in position between rows."""
    x, w = np.asarray(rows["position_m"]), np.asarray(rows["speed_mps"]) ** 2
    fine_x = np.union1d(x, np.linspace(x[0], x[-1], 800))
    points = np.column_stack((fine_x * along, np.sqrt(np.interp(fine_x, x, w)) * speed))
    row = np.searchsorted(x, fine_x, side="right") - 1
    regime = np.asarray(rows["regime"])[row]
    starts = np.concatenate(([0], np.flatnonzero(np.diff(regime)) + 1))
    ends = np.append(starts[1:], len(regime) - 1)
    pieces = [points[start : end + 1] for start, end in zip(starts, ends, strict=True)]
    colors = [palette.REGIME_COLORS[_REGIMES[regime[start]]] for start in starts]
    axes.add_collection(LineCollection(pieces, colors=colors, linewidths=1.2, linestyles=dashes))
