"""Pictures of the benchmark of formulations: success and time to solution, sizes, energy landscapes, fronts."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from numpy.typing import NDArray

from tgvdp.report import palette, style

_COLORS = (palette.BLUE, palette.VERMILION, palette.GREEN, palette.ORANGE, palette.PURPLE, palette.SKY, palette.BLACK)
_MARKERS = "osDPX^v"
#: Solvers keep their colours from picture to picture; the others take what is left.
_OF_SOLVERS = {
    "dp": palette.BLACK, "milp": palette.MUTED, "sa": palette.BLUE, "tabu": palette.GREEN, "qaoa": palette.VERMILION,
    "pt": palette.ORANGE, "scip": palette.SKY, "greedy": palette.PURPLE,
}  # fmt: skip
_LEGEND_COLUMNS, _ROW_IN = 3, 0.22
#: Intervals between numbers of steps of three digits that a quarter of the width has room for.
_MOST_STEPS = 6
#: Characters of names that fit side by side.
_LEGEND_CHARACTERS = 102


class Series(NamedTuple):
    """One line of a picture: (n,) abscissae and values, and their intervals where there are any."""

    name: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    low: NDArray[np.float64] | None = None
    high: NDArray[np.float64] | None = None


class FamilyPanel(NamedTuple):
    """Success of an attempt and TTS99 in s of some solvers on one family, against N."""

    family: str
    success: Sequence[Series]
    tts_s: Sequence[Series]


class SizePanel(NamedTuple):
    """Sizes of the formulations of one family against N: by quantity, a line of each encoding."""

    family: str
    lines: Mapping[str, Sequence[Series]]


def plot_success(panels: Sequence[FamilyPanel], detail: str) -> Figure:
    """Draw success over TTS99, one column per family."""
    names = list(dict.fromkeys(one.name for panel in panels for one in panel.tts_s))
    rows = math.ceil(len(names) / _columns(names))
    figure = style.new_figure(6.2 + _ROW_IN * rows, bottom_in=0.72 + _ROW_IN * rows)
    axes = figure.subplots(2, len(panels), sharex="col", sharey="row", squeeze=False)
    figure.subplots_adjust(wspace=0.08)
    looks = _looks(names)
    for column, panel in zip(axes.T, panels, strict=True):
        for axis, lines in zip(column, (panel.success, panel.tts_s), strict=True):
            for one in lines:
                _draw(axis, one, looks[one.name])
        style.dress(column[0])
        style.dress(column[1], f"Steps N, {panel.family}")
        column[0].set_ylim(-0.04, 1.04)
        _scale(column[1:], panel.tts_s)
    axes[0, 0].set_ylabel("Success of one attempt")
    axes[1, 0].set_ylabel("TTS99 (s)")
    style.title(axes[0, 0], "Success and time to solution", detail)
    _legend(figure, list(axes.flat))
    return figure


def plot_sizes(panels: Sequence[SizePanel], detail: str) -> Figure:
    """Draw sizes against N by encoding, one row per quantity and one column per family."""
    quantities = list(panels[0].lines)
    names = list(dict.fromkeys(one.name for panel in panels for lines in panel.lines.values() for one in lines))
    legend_in = _ROW_IN * math.ceil(len(names) / _columns(names))
    figure = style.new_figure(2.0 + 2.0 * len(quantities) + legend_in, bottom_in=0.72 + legend_in)
    axes = figure.subplots(len(quantities), len(panels), sharex="col", sharey="row", squeeze=False)
    figure.subplots_adjust(wspace=0.08)
    looks = {name: (color, marker, "-") for name, color, marker in zip(names, cycle(_COLORS), cycle(_MARKERS))}
    for column, panel in zip(axes.T, panels, strict=True):
        for axis, lines in zip(column, panel.lines.values(), strict=True):
            for one in lines:
                _draw(axis, one, looks[one.name])
            style.dress(axis)
        style.dress(column[-1], f"Steps N, {panel.family}")
        _scale(column, [one for lines in panel.lines.values() for one in lines])
    for axis, quantity in zip(axes[:, 0], quantities, strict=True):
        axis.set_ylabel(quantity)
    style.title(axes[0, 0], "Size of the formulations", detail)
    _legend(figure, list(axes.flat))
    return figure


class Depths(NamedTuple):
    """A landscape to draw: its title, detail, quantiles (5, n + 1) and the feasible strings (f,), (f,)."""

    title: str
    detail: str
    quantiles: NDArray[np.float64]
    feasible_distance: NDArray[np.int64]
    feasible_energy: NDArray[np.float64]


def plot_landscape(landscapes: Sequence[Depths]) -> Figure:
    """Draw the energies of all strings by their Hamming distance from the nearest optimum, one panel per encoding."""
    figure = style.new_figure(style.HEIGHT_IN, bottom_in=0.95)
    panels = figure.subplots(1, len(landscapes), squeeze=False, sharey=True)[0]
    figure.subplots_adjust(wspace=0.08)
    for index, (axes, one) in enumerate(zip(panels, landscapes, strict=True)):
        x = np.arange(one.quantiles.shape[1])
        least, tenth, middle, ninth, most = one.quantiles
        axes.fill_between(x, least, most, color=palette.SKY, alpha=0.25, linewidth=0, label="all strings")
        axes.fill_between(x, tenth, ninth, color=palette.BLUE, alpha=0.3, linewidth=0, label="eight in ten of them")
        axes.plot(x, middle, color=palette.BLUE, linewidth=2.0, label="median")
        axes.plot(
            one.feasible_distance, one.feasible_energy, "o", color=palette.VERMILION, markersize=5.0, clip_on=False,
            label="feasible schedules",
        )  # fmt: skip
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        style.dress(axes, "Bits to flip to the nearest optimum", "" if index else "Energy above the optimum ((m/s)²)")
        style.title(axes, one.title, one.detail)
    _scale_energy(panels[0], np.concatenate([one.quantiles.ravel() for one in landscapes]))
    style.legend(figure, "lower center", panels[0].get_legend_handles_labels()[0], 4)
    return figure


def _scale_energy(axes: Axes, energies: NDArray[np.float64]) -> None:
    """Powers of ten above the least positive energy, and linear below it, for all panels."""
    positive = energies[energies > 0.0]
    threshold, top = (float(positive.min()), float(positive.max())) if positive.size else (1.0, 1.0)
    axes.set_yscale("symlog", linthresh=threshold, linscale=0.5)
    axes.set_ylim(bottom=0.0)
    powers = range(math.ceil(math.log10(threshold)), math.floor(math.log10(top)) + 1)
    axes.set_yticks([0.0, *(10.0**power for power in powers)])
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def plot_comparison(front: Series, points: Sequence[Series], unit: str, detail: str) -> Figure:
    """Draw the points that formulations reach over the true front of the same trip; energies in a given unit."""
    figure = style.new_figure(bottom_in=0.72 + _ROW_IN * math.ceil((len(points) + 1) / _LEGEND_COLUMNS))
    axes = figure.add_subplot()
    axes.plot(front.x, front.y, "-", color=palette.INK, linewidth=2.2, label=front.name, zorder=2)
    for index, one in enumerate(points):
        axes.plot(
            one.x, one.y, _MARKERS[index % len(_MARKERS)], color=_COLORS[index % len(_COLORS)], label=one.name,
            markersize=8.0 - 1.2 * index, markerfacecolor="none" if index % 2 else None, zorder=3 + index,
        )  # fmt: skip
    axes.set_ylim(0.0, 1.06 * max(float(one.y.max()) for one in (front, *points) if one.y.size))
    style.dress(axes, "Running time (s)", f"Energy of traction ({unit})")
    style.title(axes, "What formulations reach, and the true front", detail)
    _legend(figure, [axes])
    return figure


def median_series(name: str, rows: Sequence[Mapping[str, Any]], x: str, y: str) -> Series | None:
    """Medians of a column over rows of the same abscissa that have a value; None where none has one."""
    found: dict[float, list[float]] = {}
    for row in rows:
        if row[y] is not None:
            found.setdefault(float(row[x]), []).append(row[y])
    if not found:
        return None
    xs = np.array(sorted(found))
    return Series(name, xs, np.array([float(np.median(found[value])) for value in xs.tolist()]))


_Look = tuple[str, str, str]


def _looks(names: Sequence[str]) -> dict[str, _Look]:
    """Colour by solver, mark by its variants, dashes for the encoding in bits: the same in both panels."""
    families: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        families.setdefault(re.split("[:,]", name)[0], []).append(name)
    taken = {_OF_SOLVERS[family] for family in families if family in _OF_SOLVERS}
    free = iter(color for color in _COLORS if color not in taken)
    looks = {}
    for family, members in families.items():
        color = _OF_SOLVERS.get(family) or next(free, palette.INK)
        for index, name in enumerate(members):
            dashes = "--" if re.search(r"[:, ]bits", name) else "-"
            looks[name] = (color, _MARKERS[index % len(_MARKERS)], dashes)
    return looks


def _draw(axes: Axes, one: Series, look: _Look) -> None:
    """Draw a line with its intervals; what is infinite is left out."""
    color, marker, dashes = look
    known = np.isfinite(one.y)
    axes.plot(
        one.x[known], one.y[known], dashes, marker=marker, color=color, markersize=5.0, linewidth=1.6, label=one.name
    )
    if one.low is not None and one.high is not None:
        high = np.where(np.isfinite(one.high), one.high, one.y)
        axes.vlines(one.x[known], one.low[known], high[known], color=color, linewidth=1.0)


def _scale(axes: Sequence[Axes], series: Sequence[Series]) -> None:
    """Whole numbers of steps, and logarithmic ordinates with short labels: 1, 2, 5 where decades would be too few."""
    steps = sorted({x for one in series for x in one.x.tolist()})
    axes[-1].xaxis.set_major_locator(FixedLocator(steps) if len(steps) == 1 else MaxNLocator(_MOST_STEPS, integer=True))
    for axis in axes:
        axis.set_yscale("log")
        bottom, top = axis.get_ylim()
        axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if top < 40.0 * bottom else (1.0,)))
        axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.yaxis.set_minor_formatter(NullFormatter())


def _legend(figure: Figure, axes: Sequence[Axes]) -> None:
    named: dict[str, Any] = {}
    for one in axes:
        for handle, name in zip(*one.get_legend_handles_labels(), strict=True):
            named.setdefault(name, handle)
    style.legend(figure, "lower center", list(named.values()), _columns(named))


def _columns(names: Iterable[str]) -> int:
    """Columns of a legend: fewer where names are long."""
    longest = max(map(len, names), default=1)
    return min(_LEGEND_COLUMNS, max(1, _LEGEND_CHARACTERS // longest))
