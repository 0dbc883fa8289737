"""Pictures of a journey: its front beside today's practices, its runs, and what each section gets and would give."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.report import palette, style
from tgvdp.report.advice import names_of
from tgvdp.report.front_plots import energy_name, heading
from tgvdp.report.profile_plots import Run, plot_speeds
from tgvdp.report.tables import margin_pct, saved_pct
from tgvdp.units import SECONDS_PER_MINUTE

if TYPE_CHECKING:
    from tgvdp.api import JourneyResult
    from tgvdp.journeys.delays import Robustness

_Floats = NDArray[np.float64]

#: Colours and marks of the practices, in their order.
_LOOKS = ((palette.VERMILION, "s"), (palette.GREEN, "^"), (palette.PURPLE, "v"))
_LINEAR_LOOK = (palette.ORANGE, "D")
_OPTIMUM = "optimum"
_MARKED = 100
#: Heights of the picture of two panels, and of the names of sections, inches.
_TALL_IN, _NAMES_IN = 7.2, 1.0
#: Room for a legend above what is drawn.
_LEGEND_SHARE = 0.22
#: Share of a section's room that its bars take, and bars below which each has its stop's position.
_BARS, _MOST_NAMES = 0.8, 24
#: Sections that are called by the names of their stops, and letters of these, at most.
_MOST_STATIONS, _LONGEST_STATION = 8, 14


def draw(result: "JourneyResult", picture: str, index: int | None = None) -> style.Picture:
    """Draw one picture of a journey.

    Parameters
    ----------
    result : JourneyResult
    picture : str
        One of `PICTURES`.
    index : int, optional
        Point of the front that pictures of one point show; by default the middle one.

    Raises
    ------
    InputError
        When there is no such picture, or no such point.
    """
    if picture not in PICTURES:
        raise InputError(f"plot: there is no picture {picture!r:.40}; there are {', '.join(PICTURES)}")
    return PICTURES[picture](result, result.at(len(result.front) // 2 if index is None else index))


def plot_front(result: "JourneyResult", _: int) -> style.Picture:
    """Draw energy over running time of the front and of today's practices, and below it what these cost more."""
    if not result.found.practices:  # they know no windows
        figure = style.new_figure()
        upper = lowest = figure.add_subplot()
    else:
        figure = style.new_figure(_TALL_IN)
        upper, lowest = figure.subplots(2, 1, sharex=True, height_ratios=(2.0, 1.0))
        _draw_practices(result, upper, lowest)
    front_s, front_j = result.front.time_s, result.front.energy_j
    energy = style.energy_scale(float(np.abs(front_j).max()))
    upper.plot(
        100.0 * (front_s / result.fastest_time_s - 1.0), front_j * energy.factor, color=palette.BLUE, linewidth=2.2,
        marker="o" if len(front_s) <= _MARKED else None, markersize=3.5, label=_OPTIMUM, zorder=3,
    )  # fmt: skip
    style.dress(upper, "", f"{energy_name(result.trip)} ({energy.unit})")
    label = f"Running time supplement (%) over the fastest {style.clock(result.fastest_time_s)}"
    lowest.set_xlabel(label, fontsize=style.LABEL_PT, fontfamily=style.FONT, color=palette.INK)
    style.title(upper, "What does the split of the supplement cost?", f"{_heading(result)}; lower is better")
    low, high = upper.get_ylim()
    upper.set_ylim(low, high + _LEGEND_SHARE * (high - low))
    style.legend(upper, "upper right", columns=3)
    return figure


def _draw_practices(result: "JourneyResult", upper: Axes, lower: Axes) -> None:
    """Draw the energies of the practices, and how much dearer than the front they are."""
    energy = style.energy_scale(float(np.abs(result.front.energy_j).max()))
    marks = max(len(result.front) // 12, 1)
    drawn = {name: (practice.time_s, practice.energy_j) for name, practice in result.found.practices.items()}
    drawn["linear_margin"] = (result.front.time_s, result.linear_margin_j)
    shown = []
    for (name, (time_s, energy_j)), (color, mark) in zip(drawn.items(), (*_LOOKS, _LINEAR_LOOK), strict=True):
        look: dict[str, Any] = {
            "color": color, "linewidth": 1.3, "marker": mark, "markersize": 4.0, "markevery": marks,
        }  # fmt: skip
        margin = 100.0 * (time_s / result.fastest_time_s - 1.0)
        upper.plot(margin, energy_j * energy.factor, **look, label=name.replace("_", " "))
        pairs = zip(energy_j, result.front.energy_j, strict=True)
        above = -np.array([saved_pct(own_j, best_j) for own_j, best_j in pairs])
        lower.plot(margin, above, **look)
        shown.append(float(above.max()))
    style.dress(lower, "", "Dearer by (%)")
    # What is far dearer than the rest would flatten it.
    lower.set_ylim(0.0, 1.3 * sorted(shown)[1] or 1.0)


def plot_time_distance(result: "JourneyResult", index: int) -> style.Picture:
    """Draw time over distance of the fastest journey, the chosen one and the thriftiest one, with stops and windows."""
    figure = style.new_figure()
    axes = figure.add_subplot()
    along = style.distance_scale(result.trip.distance_m)
    runs = _runs(result, index)
    begin_s = result.found.departure_s[_shown(result, index), 0]
    last_s = max(run.profile.duration_s + first_s for run, first_s in zip(runs, begin_s, strict=True))
    scale = style.time_scale(last_s)
    colors = (palette.VERMILION, palette.ORANGE, palette.BLUE)[-len(runs) :]
    for run, first_s, color in zip(runs, begin_s, colors, strict=True):
        time_s = run.profile.time_s + first_s
        axes.plot(
            run.profile.position_m * along.factor, time_s * scale.factor, color=color, linewidth=1.8, label=run.label
        )
    for section in result.sections[1:]:
        axes.axvline(section.trip.origin_m * along.factor, color=palette.MUTED, linewidth=0.7, linestyle=":")
    windows = [one for one in (*result.windows.departures, *result.windows.arrivals) if np.isfinite(one[1:3]).any()]
    for number, window in enumerate(windows):
        ends = np.clip((window.earliest_s, window.latest_s), 0.0, 1.1 * last_s) * scale.factor
        axes.plot(
            [window.position_m * along.factor] * 2, ends, color=palette.PURPLE, linewidth=5.0, alpha=0.5,
            solid_capstyle="butt", label="" if number else "window",
        )  # fmt: skip
    style.dress(axes, f"Position on the line ({along.unit})", f"Time on the journey's clock ({scale.unit})")
    axes.set_xlim(result.trip.origin_m * along.factor, result.trip.destination_m * along.factor)
    axes.set_ylim(0.0, 1.05 * last_s * scale.factor)
    style.title(axes, "When is the train where?", f"Time over distance, {_heading(result)}; dotted lines are stops")
    style.legend(axes, "upper left")
    return figure


def plot_speed(result: "JourneyResult", index: int) -> style.Picture:
    """Draw speed over distance of the whole journey."""
    return plot_speeds(result.trip, _runs(result, index))


def plot_allocation(result: "JourneyResult", index: int) -> style.Picture:
    """Draw the supplement of each section at one point of the front, beside what today's practices give it."""
    figure = style.new_figure(bottom_in=_NAMES_IN)
    axes = figure.add_subplot()
    fastest_s = np.array([section.fastest.duration_s for section in result.sections])
    rows = {_OPTIMUM: (palette.BLUE, result.section_time_s[index] - fastest_s)}
    for (name, practice), (color, _) in zip(result.found.practices.items(), _LOOKS, strict=False):
        time_s = [one.time_s[run] for one, run in zip(result.sections, practice.run[index], strict=True)]
        rows[name.replace("_", " ")] = (color, np.array(time_s) - fastest_s)
    width = _BARS / len(rows)
    place = np.arange(len(fastest_s))
    # What keeps all for the end would flatten the rest.
    highest_s = max(float(supplement_s[:-1].max(initial=0.0)) for _, supplement_s in rows.values())
    top_s = 1.25 * max(highest_s, float(rows[_OPTIMUM][1].max())) or 1.0
    for number, (name, (color, supplement_s)) in enumerate(rows.items()):
        offset = (number - 0.5 * (len(rows) - 1)) * width
        axes.bar(place + offset, supplement_s, width, color=color, label=name, linewidth=0)
        for at in np.flatnonzero(supplement_s > top_s):
            axes.annotate(
                f"↑ {supplement_s[at]:.0f} s ", (place[at] + offset - 0.5 * width, 0.97 * top_s), ha="right", va="top",
                color=palette.INK, fontsize=style.SMALL_PT, fontfamily=style.FONT,
            )  # fmt: skip
    axes.set_ylim(0.0, top_s)
    _name_sections(axes, result)
    style.dress(axes, axes.get_xlabel(), "Supplement (s)")
    style.title(axes, "Who gets the time?", f"{_heading(result)}, {_named(result, index)}")
    style.legend(axes, "upper left", columns=2)
    return figure


def plot_price(result: "JourneyResult", index: int) -> style.Picture:
    """Draw what one more minute saves in each section: the same everywhere where the split is best."""
    figure = style.new_figure(bottom_in=_NAMES_IN)
    axes = figure.add_subplot()
    energy = style.energy_scale(float(np.abs(result.front.energy_j).max()))
    per_minute = SECONDS_PER_MINUTE * energy.factor
    runs = {_OPTIMUM: (palette.BLUE, "o", result.found.run[index])}
    for (name, practice), (color, mark) in zip(result.found.practices.items(), _LOOKS, strict=False):
        runs[name.replace("_", " ")] = (color, mark, practice.run[index])
    place = np.arange(len(result.sections))
    top = bottom = 0.0
    for name, (color, mark, run) in runs.items():
        price = per_minute * np.array(
            [section.multiplier_j_per_s[own] for section, own in zip(result.sections, run, strict=True)]
        )
        price[~np.isfinite(price)] = np.nan
        axes.plot(place, price, mark, color=color, markersize=7.0, linestyle="none", label=name)
        top, bottom = max(top, float(np.nanmax(price, initial=0.0))), min(bottom, float(np.nanmin(price, initial=0.0)))
    multiplier = result.found.multiplier_j_per_s[index]
    axes.step(
        place, np.where(np.isfinite(multiplier), multiplier, np.nan) * per_minute, where="mid", color=palette.BLUE
    )
    _name_sections(axes, result)
    style.dress(axes, axes.get_xlabel(), f"Energy saved per minute ({energy.unit}/min)")
    axes.set_ylim(1.1 * bottom, 1.3 * top or 1.0)
    style.title(axes, "Where would one more minute save most?", f"{_heading(result)}, {_named(result, index)}")
    style.legend(axes, "upper left", columns=2)
    return figure


def plot_robustness(result: "JourneyResult", robustness: "Robustness") -> style.Picture:
    """Draw expected energy over expected delay of the allocations of one journey time, and their second front."""
    figure = style.new_figure()
    axes = figure.add_subplot()
    energy = style.energy_scale(float(np.abs(robustness.energy_j).max()))
    energies = robustness.energy_j * energy.factor
    axes.plot(
        robustness.delay_s, energies, "o", color=palette.FAINT, markeredgecolor=palette.MUTED, markersize=4.0,
        label="mixtures", linestyle="none",
    )  # fmt: skip
    front = robustness.front
    axes.plot(front.time_s, front.energy_j * energy.factor, color=palette.INK, linewidth=1.2, label="second front")
    looks = {_OPTIMUM: (palette.BLUE, "o"), **dict(zip(result.found.practices, _LOOKS, strict=True))}
    # What keeps all for the end would flatten the rest.
    is_shown = ["all_at_the_end" not in name for name in robustness.names]
    for name, (color, mark) in looks.items():
        at = robustness.names.index(name)
        where = "" if is_shown[at] else f" (beyond: {robustness.delay_s[at]:.3g} s, {energies[at]:.4g} {energy.unit})"
        axes.plot(
            robustness.delay_s[at], energies[at], mark, color=color, markersize=9.0, linestyle="none",
            label=f"{name.replace('_', ' ')}{where}",
        )  # fmt: skip
    both = robustness.on_both
    axes.plot(robustness.delay_s[both], energies[both], "*", color=palette.ORANGE, markersize=15.0, linestyle="none",
              label=f"on both: {robustness.names[both].replace('_', ' ')}")  # fmt: skip
    for setter, values in ((axes.set_xlim, robustness.delay_s[is_shown]), (axes.set_ylim, energies[is_shown])):
        pad = 0.15 * float(np.ptp(values)) or 1.0
        setter(float(values.min()) - pad, float(values.max()) + pad)
    style.dress(axes, "Expected delay at stops (s)", f"Expected energy ({energy.unit})")
    style.title(axes, "What does the split do when trains are late?", f"{_heading(result)}; lower left is better")
    style.legend(axes, "upper left")
    return figure


#: All pictures by name.
PICTURES: dict[str, Callable[["JourneyResult", int], style.Picture]] = {
    "front": plot_front,
    "time_distance": plot_time_distance,
    "profile": plot_speed,
    "allocation": plot_allocation,
    "price": plot_price,
}


def _runs(result: "JourneyResult", index: int) -> list[Run]:
    """The fastest, the chosen and the thriftiest journey, as far as there are so many."""
    looks = (((0, (1.2, 1.2)), 1.2), ((0, (5.0, 1.5)), 1.4), ("-", 1.8))
    chosen = _shown(result, index)
    return [
        Run(_named(result, at), result.profile(at), *look)
        for at, look in zip(chosen, looks[-len(chosen) :], strict=True)
    ]


def _shown(result: "JourneyResult", index: int) -> list[int]:
    """The first point, the chosen and the last one, each once."""
    return sorted({0, index, len(result.front) - 1})


def _named(result: "JourneyResult", index: int) -> str:
    """Time and energy of a point against the fastest journey."""
    if np.isinf(result.found.multiplier_j_per_s[index]).all():
        return f"fastest, {style.clock(result.fastest_time_s)}"
    margin = margin_pct(float(result.front.time_s[index]), result.fastest_time_s)
    saved = saved_pct(float(result.front.energy_j[index]), result.fastest_energy_j)
    return f"{margin:+.1f} % time, {-saved:+.1f} % energy".replace("-", "−")


def _heading(result: "JourneyResult") -> str:
    count = len(result.sections)
    return f"{heading(result.trip)}, {count} section{'' if count == 1 else 's'}"


def _name_sections(axes: Axes, result: "JourneyResult") -> None:
    """Write where each section begins and ends, as far as there is room."""
    along = style.distance_scale(result.trip.distance_m)
    ends = [(one.trip.origin_m * along.factor, one.trip.destination_m * along.factor) for one in result.sections]
    every = -(-len(ends) // _MOST_NAMES)
    names = [f"{first:.3g}–{last:.3g}" for first, last in ends[::every]]
    axes.set_xticks(range(0, len(ends), every), names, rotation=45 if len(names) > 8 else 0, ha="center")
    axes.set_xlabel(f"Section, from and to ({along.unit})")
    stops = [names_of(one.trip) for one in result.sections[::every]]
    if all(len(stop) == 2 for stop in stops) and len(stops) <= _MOST_STATIONS:
        names = [f"{_short(stop['from'])} –\n{_short(stop['to'])}" for stop in stops]
        axes.set_xticks(axes.get_xticks(), names, rotation=0, parse_math=False)
        axes.set_xlabel("Section")


def _short(name: str) -> str:
    return name if len(name) <= _LONGEST_STATION else f"{name[: _LONGEST_STATION - 1]}…"
