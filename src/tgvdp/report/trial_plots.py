"""Pictures of the benchmark of formulations: success and time to solution, sizes, energy landscapes, fronts."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from numpy.typing import NDArray

from tgvdp.report import style

_COLORS = (style.BLUE, style.VERMILION, style.GREEN, style.ORANGE, style.PURPLE, style.SKY, style.BLACK)
_MARKERS = "osDPX^v"
#: Solvers and sizes keep their colours from picture to picture; the others take what is left.
_OF_SOLVERS = {
    "dp": style.BLACK, "milp": style.MUTED, "sa": style.BLUE, "tabu": style.GREEN, "qaoa": style.VERMILION,
    "random": style.PURPLE, "coin tosses": style.PURPLE,
    "variables": style.BLACK, "qubits on pegasus": style.BLUE, "qubits on zephyr": style.VERMILION,
}  # fmt: skip
_LEGEND_COLUMNS, _ROW_IN = 3, 0.22
#: Characters of a name of which three fit side by side.
_LONG_NAME = 34


class Series(NamedTuple):
    """One line of a picture: (n,) abscissae and values, their intervals where there are any, and how it is drawn.

    ``only_bound`` marks values that are no more than the end of their interval, because nothing was found.
    """

    name: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    low: NDArray[np.float64] | None = None
    high: NDArray[np.float64] | None = None
    only_bound: NDArray[np.bool_] | None = None
    dashed: bool = False


def plot_success(success: Sequence[Series], tts_s: Sequence[Series], detail: str) -> Figure:
    """Draw the success of an attempt, where any attempt is drawn, and TTS99 against N; hollow marks are bounds."""
    names = [one.name for one in (*success, *tts_s)]
    figure, axes = _panels(2 if success else 1, names)
    looks = _looks(names)
    for one in success:
        _draw(axes[0], one, looks[one.name], "v")
    for one in tts_s:
        _draw(axes[-1], one, looks[one.name], "^")
    if success:
        # Coin tosses soon fall below everything that could be measured: of them only the best need be seen.
        axes[0].set_ylim(0.5 * _least(one.y.max(keepdims=True) if one.dashed else one.y for one in success), 1.4)
        style.dress(axes[0], "", "Success of one attempt")
    _scale(axes, [*success, *tts_s])
    style.dress(axes[-1], "Steps N", "TTS99 (s)")
    style.title(axes[0], "Success and time to solution" if success else "Time to solution", detail)
    _legend(figure, axes)
    return figure


def plot_sizes(variables: Sequence[Series], couplers: Sequence[Series], detail: str) -> Figure:
    """Draw bits and qubits, and couplers, against N."""
    figure, axes = _panels(2, [one.name for one in (*variables, *couplers)])
    looks = _looks([one.name for one in (*variables, *couplers)])
    for axis, series in zip(axes, (variables, couplers), strict=True):
        for one in series:
            _draw(axis, one, looks[one.name], "o")
    _scale(axes, [*variables, *couplers])
    style.dress(axes[0], "", "Bits, qubits")
    style.dress(axes[1], "Steps N", "Couplers")
    style.title(axes[0], "Size of the formulations", detail)
    _legend(figure, axes)
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
        axes.fill_between(x, least, most, color=style.SKY, alpha=0.25, linewidth=0, label="all strings")
        axes.fill_between(x, tenth, ninth, color=style.BLUE, alpha=0.3, linewidth=0, label="eight in ten of them")
        axes.plot(x, middle, color=style.BLUE, linewidth=2.0, label="median")
        axes.plot(
            one.feasible_distance, one.feasible_energy, "o", color=style.VERMILION, markersize=5.0, clip_on=False,
            label="feasible schedules",
        )  # fmt: skip
        positive = one.quantiles[one.quantiles > 0.0]
        threshold = float(positive.min()) if positive.size else 1.0
        axes.set_yscale("symlog", linthresh=threshold, linscale=0.5)
        axes.set_ylim(bottom=0.0)
        top = float(positive.max(initial=threshold))
        powers = range(math.ceil(math.log10(threshold)), math.floor(math.log10(top)) + 1)
        axes.set_yticks([0.0, *(10.0**power for power in powers)])
        style.dress(axes, "Bits to flip to the nearest optimum", "" if index else "Energy above the optimum ((m/s)²)")
        style.title(axes, one.title, one.detail)
    style.legend(figure, "lower center", panels[0].get_legend_handles_labels()[0], 4)
    return figure


def plot_comparison(front: Series, points: Sequence[Series], unit: str, detail: str) -> Figure:
    """Draw the points that formulations reach over the true front of the same trip; energies in a given unit."""
    figure = style.new_figure(bottom_in=0.72 + _ROW_IN * math.ceil((len(points) + 1) / _LEGEND_COLUMNS))
    axes = figure.add_subplot()
    axes.plot(front.x, front.y, "-", color=style.INK, linewidth=2.2, label=front.name, zorder=2)
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


def median_series(
    name: str,
    rows: Sequence[Mapping[str, Any]],
    x: str,
    y: str,
    low: str | None = None,
    high: str | None = None,
    *,
    dashed: bool = False,
) -> Series | None:
    """Medians of a column over rows of the same abscissa; rows without a value are left out, None where none has one.

    With ``low`` and ``high`` a value of 0 or infinity is replaced by the end of its interval, and marked as a bound.
    """  # fmt: skip
    found: dict[float, list[Mapping[str, Any]]] = {}
    for row in rows:
        if row[y] is not None:
            found.setdefault(float(row[x]), []).append(row)
    if not found:
        return None
    xs = np.array(sorted(found))

    def middle(column: str) -> NDArray[np.float64]:
        return np.array([float(np.median([row[column] for row in found[value]])) for value in xs.tolist()])

    ys = middle(y)
    if low is None or high is None:
        return Series(name, xs, ys, dashed=dashed)
    lows, highs = middle(low), middle(high)
    nothing = (ys <= 0.0) | ~np.isfinite(ys)
    bound = np.where(ys <= 0.0, highs, lows)
    return Series(name, xs, np.where(nothing, bound, ys), lows, highs, nothing, dashed)


_Look = tuple[str, str, str]


def _looks(names: Sequence[str]) -> dict[str, _Look]:
    """Colour by solver, mark by its variants, dashes for the encoding in bits: the same in both panels."""
    families: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        families.setdefault(re.split("[:,]", name)[0], []).append(name)
    free = iter(color for color in (*_COLORS, *_COLORS) if color not in _OF_SOLVERS.values())
    looks = {}
    for family, members in families.items():
        color = _OF_SOLVERS.get(family) or next(free, style.INK)
        for index, name in enumerate(members):
            dashes = "--" if re.search(r"[:, ]bits", name) else "-"
            looks[name] = (color, _MARKERS[index % len(_MARKERS)], dashes)
    return looks


def _draw(axes: Axes, one: Series, look: _Look, bound_marker: str) -> None:
    """Draw a line with its intervals; bounds are hollow triangles that the line does not pass through."""
    color, marker, dashes = look
    if one.dashed:
        cross = "x" if one.x.size == 1 else None  # a line through one point is none
        axes.plot(
            one.x, one.y, ":" if dashes == "-" else "-.", color=color, linewidth=1.6, marker=cross, label=one.name
        )
        return
    bound = np.zeros(one.x.size, dtype=np.bool_) if one.only_bound is None else one.only_bound
    known = ~bound & np.isfinite(one.y)
    axes.plot(
        one.x[known], one.y[known], dashes, marker=marker, color=color, markersize=5.0, linewidth=1.6, label=one.name
    )
    if one.low is not None and one.high is not None:
        high = np.where(np.isfinite(one.high), one.high, one.y)
        axes.vlines(one.x[known], np.maximum(one.low, 1e-300)[known], high[known], color=color, linewidth=1.0)
    shown = bound & np.isfinite(one.y)
    axes.plot(one.x[shown], one.y[shown], bound_marker, color=color, markersize=6.0, markerfacecolor="none")


def _least(values: Iterable[NDArray[np.float64]]) -> float:
    """Least positive value."""
    every = np.concatenate([np.ones(1), *values])
    return float(every[every > 0.0].min())


def _panels(count: int, names: Sequence[str]) -> tuple[Figure, Sequence[Axes]]:
    different = dict.fromkeys(names)
    rows = math.ceil(len(different) / _columns(different))
    figure = style.new_figure(2.0 + 2.6 * count + _ROW_IN * rows, bottom_in=0.72 + _ROW_IN * rows)
    axes = list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0])
    return figure, axes


def _scale(axes: Sequence[Axes], series: Sequence[Series]) -> None:
    """Whole numbers of steps, and logarithmic ordinates with short labels: 1, 2, 5 where decades would be too few."""
    steps = sorted({x for one in series for x in one.x.tolist()})
    axes[-1].xaxis.set_major_locator(FixedLocator(steps) if len(steps) == 1 else MaxNLocator(integer=True))
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
    return _LEGEND_COLUMNS if max(map(len, names), default=0) <= _LONG_NAME else _LEGEND_COLUMNS - 1
