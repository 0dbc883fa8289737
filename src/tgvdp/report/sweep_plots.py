"""Pictures of a sweep: how savings are spread, on what they depend, and a map over two axes."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path
from numpy.typing import NDArray

from tgvdp.report import palette, style

_BINS = 40
_BAR_IN, _HEAD_IN = 0.42, 1.7
#: Cells of a map that hold their figures.
_WRITTEN = 150
#: Characters of a name that labels of a map show.
_LONGEST = 24
#: Of a tornado: its sides as shares of the figure, what is free around the value beside a bar, points, and the share of
#: the width that bars keep.
_LEFT, _RIGHT, _FREE_PT, _BARS = 0.24, 0.93, 14.0, 0.15
#: Characters of names that stand side by side below a map.
_BESIDE = 50


class Effect(NamedTuple):
    """How far a saving moves with one axis: lowest and highest, in percent, and the values that have them."""

    axis: str
    low_pct: float
    high_pct: float
    low_value: Any
    high_value: Any


def plot_distribution(saved_pct: NDArray[np.float64], margin_pct: float, detail: str) -> style.Picture:
    """Draw how many scenarios save how much, with the median and where nine tenths of them lie."""
    figure = style.new_figure()
    axes = figure.subplots()
    axes.hist(
        saved_pct, bins=min(_BINS, max(len(saved_pct) // 4, 5)), color=palette.SKY, edgecolor="white", linewidth=0.5
    )
    low, middle, high = np.percentile(saved_pct, (5, 50, 95))
    for value, text, weight in ((low, "5 %", 1.0), (middle, "median", 2.0), (high, "95 %", 1.0)):
        axes.axvline(value, color=palette.INK, linewidth=weight, linestyle="-" if weight > 1.0 else "--")
        axes.annotate(
            f"{text}: {value:.1f}", (value, 1.0), (3.0, -10.0), xycoords=("data", "axes fraction"),
            textcoords="offset points", fontsize=style.SMALL_PT, fontfamily=style.FONT, color=palette.INK,
        )  # fmt: skip
    style.dress(axes, "Energy saved (% of the fastest run's)", "Scenarios")
    style.title(axes, f"What {margin_pct:g} % more running time saves", detail)
    return figure


def plot_tornado(effects: Sequence[Effect], mean_pct: float, margin_pct: float, detail: str) -> style.Picture:
    """Draw on what the saving depends: a bar per axis, the widest on top."""
    height_in = _HEAD_IN + _BAR_IN * len(effects)
    figure = style.new_figure(height_in)
    figure.subplots_adjust(left=_LEFT, right=_RIGHT, bottom=0.62 / height_in)
    axes = figure.subplots()
    for row, one in enumerate(reversed(effects)):
        axes.barh(row, one.low_pct - mean_pct, left=mean_pct, color=palette.ORANGE, height=0.6)
        axes.barh(row, one.high_pct - mean_pct, left=mean_pct, color=palette.BLUE, height=0.6)
        for value, pct, side in ((one.low_value, one.low_pct, "right"), (one.high_value, one.high_pct, "left")):
            axes.annotate(
                _short(value), (pct, row), (-4.0 if side == "right" else 4.0, 0.0), textcoords="offset points",
                ha=side, va="center", fontsize=style.SMALL_PT, fontfamily=style.FONT, color=palette.INK,
                parse_math=False,
            )  # fmt: skip
    axes.axvline(mean_pct, color=palette.INK, linewidth=1.0)
    axes.set_xlim(*_room_beside(effects, mean_pct))
    style.dress(axes, "Energy saved (% of the fastest runs')")
    axes.set_yticks(range(len(effects)), [_short(one.axis) for one in reversed(effects)], parse_math=False)
    style.title(axes, f"On what the saving at {margin_pct:g} % depends", detail)
    return figure


def _room_beside(effects: Sequence[Effect], mean_pct: float) -> tuple[float, float]:
    """Ends of the axis of a tornado, in percent, between which each bar and the values beside it lie.

    A value takes a share of the axis, whatever its scale, so that the span is the least at which all of them fit.
    """
    low = [(mean_pct - one.low_pct, _share(one.low_value)) for one in effects]
    high = [(one.high_pct - mean_pct, _share(one.high_value)) for one in effects]
    span = max((own + other) / max(1.0 - room - across, _BARS) for own, room in low for other, across in high)
    span = span or 1.0  # nothing that varies matters
    left, right = (max(length + room * span for length, room in side) for side in (low, high))
    return mean_pct - left, mean_pct + right


def _share(value: Any) -> float:
    """Share of a tornado's width that a value beside a bar takes."""
    font = FontProperties(family=style.FONT, size=style.SMALL_PT)
    width_pt, _, _ = text_to_path.get_text_width_height_descent(_short(value), font, False)
    return float((width_pt + _FREE_PT) / (72.0 * style.WIDTH_IN * (_RIGHT - _LEFT)))


def plot_map(
    saved_pct: NDArray[np.float64],
    rows: tuple[str, Sequence[Any]],
    columns: tuple[str, Sequence[Any]],
    margin_pct: float,
) -> style.Picture:
    """Draw the saving over two axes, (rows, columns), each a name and its values; cells without figures stay empty."""
    figure = style.new_figure()
    figure.subplots_adjust(left=0.24, right=0.98, bottom=0.2)
    axes = figure.subplots()
    image = axes.imshow(saved_pct, aspect="auto", cmap="viridis")
    bar = figure.colorbar(image, ax=axes)
    bar.set_label("Energy saved (%)", fontsize=style.LABEL_PT, fontfamily=style.FONT, color=palette.INK)
    style.dress(axes, columns[0], rows[0])
    axes.grid(False)
    for set_ticks, values in ((axes.set_xticks, columns[1]), (axes.set_yticks, rows[1])):
        step = max(1, len(values) // 20)
        set_ticks(range(0, len(values), step), [_short(value) for value in values[::step]], parse_math=False)
    if sum(len(_short(value)) for value in columns[1]) > _BESIDE:  # names would run into each other
        axes.tick_params(axis="x", rotation=40)
        figure.subplots_adjust(bottom=0.36)
    if saved_pct.size <= _WRITTEN:
        middle = 0.5 * (np.nanmin(saved_pct) + np.nanmax(saved_pct))
        for (row, column), value in np.ndenumerate(saved_pct):
            if np.isfinite(value):
                color = "white" if value < middle else palette.INK
                axes.text(column, row, f"{value:.1f}", ha="center", va="center", fontsize=8, color=color)
    style.title(axes, f"What {margin_pct:g} % more running time saves", f"by {rows[0]} and {columns[0]}")
    return figure


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"
