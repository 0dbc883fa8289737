"""Pictures of the formulations: schedules over time, and force and cost curves beside their fits."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tgvdp.report import palette, style
from tgvdp.units import KMH_PER_MPS

_COLORS = (palette.BLUE, palette.VERMILION, palette.GREEN, palette.ORANGE, palette.PURPLE)


class Curve(NamedTuple):
    """A labelled curve: (n,) abscissae and ordinates in the units of the axes, drawn dashed or not."""

    label: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    dashed: bool = False


def plot_curves(
    curves: Sequence[Curve], x_label: str, y_label: str, heading: str, detail: str = "", marks: Sequence[float] = ()
) -> Figure:
    """Draw curves, and vertical lines at marks on the abscissa."""
    figure = style.new_figure(bottom_in=0.95)
    axes = figure.add_subplot()
    for index, curve in enumerate(curves):
        color = _COLORS[index % len(_COLORS)]
        axes.plot(curve.x, curve.y, "--" if curve.dashed else "-", color=color, linewidth=2.0, label=curve.label)
    for mark in marks:
        axes.axvline(mark, color=palette.MUTED, linewidth=1.0, linestyle=":")
    style.dress(axes, x_label, y_label)
    style.title(axes, heading, detail)
    handles = axes.get_legend_handles_labels()[0]
    style.legend(figure, "lower center", handles, min(4, len(curves)))
    return figure


def schedule_curve(label: str, speeds_mps: Sequence[float], dt_s: float, *, dashed: bool = False) -> Curve:
    """Speeds at the ends of time steps, as km/h over minutes."""
    time_min = np.arange(len(speeds_mps)) * dt_s / 60.0
    speed_kmh = np.asarray(speeds_mps, dtype=np.float64) * KMH_PER_MPS
    return Curve(label, np.asarray(time_min, dtype=np.float64), speed_kmh, dashed)
