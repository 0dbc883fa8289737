"""Picture of margins side by side."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tgvdp.report import palette, style
from tgvdp.report.front_plots import energy_name
from tgvdp.report.tables import margin_pct

if TYPE_CHECKING:
    from tgvdp.api.margins import Margins

#: Colours and marks by name.
_LOOKS = {
    "linear": (palette.ORANGE, "D"),
    "economy": (palette.VERMILION, "s"),
    "uniform": (palette.GREEN, "^"),
    "optimum": (palette.BLUE, "o"),
}
_TALL_IN = 7.2
#: Room for a legend above what is drawn, and between the panels.
_LEGEND_SHARE, _BETWEEN = 0.3, 0.3
#: Supplements are drawn over twice this range at least, %.
_HALF_PCT = 1.0


def plot_margins(margins: Sequence["Margins"]) -> style.Picture:
    """Draw how far each margin is from the linear time along the line, of the first supplement, and what all take."""
    rising = sorted(margins, key=lambda one: one.time_s["linear"])
    figure = style.new_figure(_TALL_IN)
    upper, lower = figure.subplots(2, 1)
    figure.subplots_adjust(hspace=_BETWEEN)
    first = margins[0]
    trips = first.trips
    along = style.distance_scale(trips[-1].destination_m - trips[0].origin_m)
    energy = style.energy_scale(max(max(map(abs, one.energy_j.values())) for one in margins))
    for name, (color, mark) in _LOOKS.items():
        position_m, late_s = first.deviations(name)
        label = f"{name}: {first.energy_j[name] * energy.factor:.4g} {energy.unit}, {first.deviation_s[name]:.3g} s off"
        upper.plot(position_m * along.factor, late_s, color=color, linewidth=1.8, label=label)
        look: dict[str, Any] = {"color": color, "marker": mark, "markersize": 6.0, "linewidth": 1.3}
        shares = [margin_pct(one.time_s[name], one.fastest_s) for one in rising]
        lower.plot(shares, [one.energy_j[name] * energy.factor for one in rising], **look)
    style.dress(upper, f"Position on the line ({along.unit})", "Later than linear (s)")
    low, high = upper.get_ylim()
    upper.set_ylim(low, high + _LEGEND_SHARE * (high - low))
    upper.set_xlim(trips[0].origin_m * along.factor, trips[-1].destination_m * along.factor)
    heading = (
        f"{trips[0].train.name} on {trips[0].track.name}, {margin_pct(first.time_s['linear'], first.fastest_s):.3g}"
    )
    style.title(upper, "How is a margin taken?", f"{heading} % more time than the fastest")
    style.legend(upper, "upper left", columns=2)
    style.dress(lower, "Running time supplement (%)", f"{energy_name(trips[0])} ({energy.unit})")
    # The runs of one supplement alone differ in time by less than can be told.
    first_pct, last_pct = lower.get_xlim()
    widened_pct = max(_HALF_PCT - 0.5 * (last_pct - first_pct), 0.0)
    lower.set_xlim(first_pct - widened_pct, last_pct + widened_pct)
    return figure
