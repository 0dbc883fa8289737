"""The one look of all pictures: sizes, fonts, and the unit in which each axis reads best; `palette` has the colours.

Figures are made without pyplot and without touching matplotlib's global settings, so that a program that embeds tgvdp
keeps its own.
"""

import io
from collections.abc import Sequence
from typing import Any, NamedTuple

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tgvdp.report.palette import FAINT, INK, MUTED
from tgvdp.units import JOULE_PER_KWH, KMH_PER_MPS, SECONDS_PER_MINUTE

WIDTH_IN, HEIGHT_IN, DPI = 9.0, 5.4, 120
_NOTEBOOK_DPI = 80
_LEFT_IN, _TOP_IN = 0.85, 0.66
FONT = "DejaVu Sans"  # comes with matplotlib, so that every machine draws the same
TITLE_PT, LABEL_PT, SMALL_PT = 13.0, 10.5, 9.0


class Picture(Figure):
    """A figure that notebooks show without pyplot."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=_NOTEBOOK_DPI)
        return buffer.getvalue()


class Scale(NamedTuple):
    """Unit of an axis: shown value = SI value · factor."""

    unit: str
    factor: float


def distance_scale(span_m: float) -> Scale:
    """Kilometres for lines, metres for toys."""
    return Scale("km", 1e-3) if span_m >= 1e3 else Scale("m", 1.0)


def speed_scale(top_mps: float) -> Scale:
    """Kilometres per hour for trains, metres per second for toys."""
    return Scale("km/h", KMH_PER_MPS) if top_mps >= 5.0 else Scale("m/s", 1.0)


def time_scale(span_s: float) -> Scale:
    """Minutes from ten minutes on, seconds below."""
    return Scale("min", 1.0 / SECONDS_PER_MINUTE) if span_s >= 10.0 * SECONDS_PER_MINUTE else Scale("s", 1.0)


def energy_scale(top_j: float) -> Scale:
    """Kilowatt-hours for trains, joules for toys."""
    return Scale("kWh", 1.0 / JOULE_PER_KWH) if top_j >= 0.01 * JOULE_PER_KWH else Scale("J", 1.0)


def power_scale(top_w: float) -> Scale:
    """Megawatts or kilowatts for trains, watts for toys."""
    return Scale("MW", 1e-6) if top_w >= 1e6 else Scale("kW", 1e-3) if top_w >= 1e3 else Scale("W", 1.0)


def force_scale(top_n: float) -> Scale:
    """Kilonewtons for trains, newtons for toys."""
    return Scale("kN", 1e-3) if top_n >= 1e3 else Scale("N", 1.0)


def new_figure(height_in: float = HEIGHT_IN, *, right_in: float = 0.3, bottom_in: float = 0.62) -> Picture:
    """Make an empty figure of the common width, with room for the labels around its axes.

    Margins are fixed: to measure every label first, as matplotlib's own layouts do, takes longer than to draw it all.
    """
    figure = Picture(figsize=(WIDTH_IN, height_in), dpi=DPI, facecolor="white")
    figure.subplots_adjust(
        left=_LEFT_IN / WIDTH_IN,
        right=1.0 - right_in / WIDTH_IN,
        bottom=bottom_in / height_in,
        top=1.0 - _TOP_IN / height_in,
        hspace=0.1,
    )
    return figure


def dress(axes: Axes, x_label: str = "", y_label: str = "") -> None:
    """Give axes their labels, a faint grid and a light frame."""
    axes.set_facecolor("white")
    # Panels over a common axis get its label from whoever stacked them.
    if x_label:
        axes.set_xlabel(x_label, fontsize=LABEL_PT, fontfamily=FONT, color=INK)
    axes.set_ylabel(y_label, fontsize=LABEL_PT, fontfamily=FONT, color=INK)
    axes.grid(True, color=FAINT, linewidth=0.6, linestyle="-")
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=SMALL_PT, colors=INK, labelfontfamily=FONT)
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color(MUTED)


def title(axes: Axes, text: str, detail: str = "") -> None:
    """Set a bold title over the left edge, with a line of detail below it, in which any character may stand."""
    # A given y: otherwise matplotlib measures everything around the axes to find a free one.
    axes.set_title(text, loc="left", y=1.0, pad=24.0, fontsize=TITLE_PT, fontfamily=FONT, fontweight="bold", color=INK)
    axes.annotate(
        detail, (0.0, 1.0), (0.0, 8.0), xycoords="axes fraction", textcoords="offset points",
        fontsize=SMALL_PT, fontfamily=FONT, color=MUTED, parse_math=False,
    )  # fmt: skip


def clock(duration_s: float) -> str:
    """Write a running time as people say it: 1:02:03 h, 4:05 min, or 1.234 s for toys."""
    if duration_s < SECONDS_PER_MINUTE:
        return f"{duration_s:.4g} s"
    minutes, seconds = divmod(round(duration_s), int(SECONDS_PER_MINUTE))
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d} h" if hours else f"{minutes}:{seconds:02d} min"


def legend(home: Axes | Figure, place: str, handles: Sequence[Artist] | None = None, columns: int = 1) -> None:
    """Add a frameless legend to axes or, outside of them, to a figure; "above right" is beside the title."""
    options: dict[str, Any] = {"loc": place, "ncols": columns}
    if place == "above right":
        options |= {"loc": "lower right", "bbox_to_anchor": (1.02, 1.0), "borderaxespad": 2.2, "columnspacing": 1.4}
    if handles is not None:
        options["handles"] = handles
    home.legend(frameon=False, prop={"family": FONT, "size": SMALL_PT}, **options).set_zorder(6)
