"""A recorded run against the front, as an object and as a picture."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from tgvdp.report import palette, style
from tgvdp.report.front_plots import energy_name
from tgvdp.report.line_met import speed_limits_of
from tgvdp.report.plain import plain
from tgvdp.report.profile_plots import Run, draw_run, speed_curve
from tgvdp.report.tables import BALANCE_FIELDS, margin_pct, saved_pct
from tgvdp.runs.profile import REGIMES
from tgvdp.units import joule_to_kwh

if TYPE_CHECKING:
    from tgvdp.api import Score
    from tgvdp.runs.profile import Profile

SCHEMA = "tgvdp.score/1"
#: Parts of the trip that are told apart.
_PARTS = 10


def score_object(score: "Score") -> dict[str, Any]:
    """Build the object of schema tgvdp.score/1; docs/results.md says what each field means."""
    trip, fastest = score.result.trip, score.result.fastest
    recorded, optimum, earlier_s = score.recorded, score.optimum, score.time_for_energy_s
    content = {
        "schema": SCHEMA,
        "record": score.name,
        "train": trip.train.name,
        "track": trip.track.name,
        "origin_m": trip.origin_m,
        "destination_m": trip.destination_m,
        "energy": trip.energy.kind,
        "fastest_time_s": fastest.time_s,
        "recorded": {"time_s": score.time_s, "margin_pct": margin_pct(score.time_s, fastest.time_s), **_run(recorded)},
        "optimum": {
            "time_s": optimum.duration_s,
            "margin_pct": margin_pct(optimum.duration_s, fastest.time_s),
            **_run(optimum),
        },
        "saving_kwh": joule_to_kwh(score.saving_j),
        "saving_pct": saved_pct(optimum.total_energy_j, recorded.total_energy_j),
        "saving_in_brakes_kwh": joule_to_kwh(score.saving_in_brakes_j),
        "saving_in_resistance_kwh": joule_to_kwh(score.saving_in_resistance_j),
        "time_for_energy_s": earlier_s,
        "earlier_s": None if earlier_s is None else score.time_s - earlier_s,
        "parts": _parts(score),
    }
    if score.warnings:
        content["warning"] = "; ".join(score.warnings)
    plain_content: dict[str, Any] = plain(content)
    return plain_content


def _run(profile: "Profile") -> dict[str, Any]:
    """Energy, its balance, and the share of the distance in each regime."""
    step_m = np.diff(profile.position_m)
    share = np.bincount(profile.regime[:-1], weights=step_m, minlength=len(REGIMES)) / step_m.sum()
    kwh = (joule_to_kwh(float(value)) for value in profile.balance)
    return {
        "energy_kwh": joule_to_kwh(profile.total_energy_j),
        "balance": dict(zip(BALANCE_FIELDS, kwh, strict=True)),
        "distance_pct": {name: 100.0 * float(part) for name, part in zip(REGIMES, share, strict=True)},
    }


def _parts(score: "Score") -> list[dict[str, float]]:
    """Energy and time of both runs on equal parts of the trip; linear within a row."""
    trip = score.result.trip
    ends_m = np.linspace(trip.origin_m, trip.destination_m, _PARTS + 1)
    runs = {"recorded": score.recorded, "optimum": score.optimum}
    energy = {name: np.diff(np.interp(ends_m, run.position_m, run.energy_j)) for name, run in runs.items()}
    time_s = {name: np.diff(np.interp(ends_m, run.position_m, run.time_s)) for name, run in runs.items()}
    return [
        {
            "from_m": float(ends_m[part]),
            "to_m": float(ends_m[part + 1]),
            **{f"{name}_kwh": joule_to_kwh(float(values[part])) for name, values in energy.items()},
            **{f"{name}_s": float(values[part]) for name, values in time_s.items()},
        }
        for part in range(_PARTS)
    ]


def plot_score(score: "Score") -> style.Picture:
    """Draw a recorded run and the optimum of the same time: speeds, energy along the line, and both at the front.

    Parameters
    ----------
    score : Score

    Returns
    -------
    matplotlib.figure.Figure
    """
    height_in = 10.4
    figure = style.new_figure(height_in, bottom_in=0.62)
    left, right = figure.subplotpars.left, figure.subplotpars.right
    speed_axes, energy_axes, front_axes = (
        figure.add_axes((left, bottom / height_in, right - left, tall / height_in))
        for bottom, tall in ((5.95, 3.75), (3.95, 1.8), (0.62, 2.4))
    )
    trip = score.result.trip
    along = style.distance_scale(trip.distance_m)
    _draw_speeds(speed_axes, score, along.factor)
    _draw_energies(energy_axes, score, along.factor)
    for axes in (speed_axes, energy_axes):
        axes.set_xlim(trip.origin_m * along.factor, trip.destination_m * along.factor)
    speed_axes.tick_params(labelbottom=False)
    energy_axes.set_xlabel(f"Position on the line ({along.unit})", fontsize=style.LABEL_PT, fontfamily=style.FONT)
    _draw_front(front_axes, score)
    where = f"{score.name}, {trip.train.name} on {trip.track.name}, {trip.distance_m * along.factor:.4g} {along.unit}"
    style.title(speed_axes, "What could this run have saved?", where)
    regimes = [
        Line2D([], [], color=palette.REGIME_COLORS[REGIMES[code]], linewidth=3.0, label=REGIMES[code])
        for code in np.unique(score.optimum.regime).tolist()
    ]
    style.legend(speed_axes, "above right", regimes, len(regimes))
    return figure


def _draw_speeds(axes: Axes, score: "Score", along: float) -> None:
    top_mps = max(float(run.speed_mps.max()) for run in (score.recorded, score.optimum))
    speed = style.speed_scale(top_mps)
    position_m, limit_mps = speed_limits_of(score.result.trip)
    axes.step(
        position_m * along,
        limit_mps * speed.factor,
        where="post",
        color=palette.MUTED,
        linewidth=1.2,
        label="speed limit",
    )
    x, v, _ = speed_curve(score.recorded)
    axes.plot(x * along, v * speed.factor, color=palette.INK, linewidth=1.3, linestyle=(0, (4.0, 1.5)))
    x, v, row = speed_curve(score.optimum)
    draw_run(axes, Run("optimum", score.optimum, "-", 2.4), x * along, v * speed.factor, score.optimum.regime[row])
    style.dress(axes, "", f"Speed ({speed.unit})")
    axes.set_ylim(0.0, 1.06 * speed.factor * min(float(limit_mps.max()), 2.0 * top_mps))


def _draw_energies(axes: Axes, score: "Score", along: float) -> None:
    top_j = max(float(np.abs(run.energy_j).max()) for run in (score.recorded, score.optimum))
    energy = style.energy_scale(top_j)
    x = np.union1d(score.recorded.position_m, score.optimum.position_m)
    used, needed = (
        np.interp(x, run.position_m, run.energy_j) * energy.factor for run in (score.recorded, score.optimum)
    )
    axes.fill_between(x * along, needed, used, color=palette.SKY, alpha=0.35, linewidth=0)
    axes.plot(x * along, used, color=palette.INK, linewidth=1.3, linestyle=(0, (4.0, 1.5)), label="recorded")
    axes.plot(x * along, needed, color=palette.INK, linewidth=2.0, label="optimum of that time")
    style.dress(axes, "", f"Energy so far ({energy.unit})")
    style.legend(axes, "upper left")


def _draw_front(axes: Axes, score: "Score") -> None:
    """Draw the front, the record beside it, and the two ways from it to the front."""
    front, recorded_j = score.result.front, score.recorded.total_energy_j
    scale, energy = style.time_scale(score.time_s), style.energy_scale(recorded_j)
    here = (score.time_s * scale.factor, recorded_j * energy.factor)
    axes.plot(
        front.time_s * scale.factor, front.energy_j * energy.factor, color=palette.BLUE, linewidth=1.8,
        label="Pareto front", zorder=3,
    )  # fmt: skip
    axes.plot(*here, "X", color=palette.VERMILION, markersize=11, label="recorded", linestyle="none", zorder=5)
    arrows = [
        ((here[0], score.optimum.total_energy_j * energy.factor), f"{score.saving_j * energy.factor:.4g} {energy.unit}")
    ]
    if (earlier_s := score.time_for_energy_s) is not None:
        arrows.append(((earlier_s * scale.factor, here[1]), f"{score.time_s - earlier_s:.4g} s"))
    for end, text in arrows:
        axes.annotate(
            "", end, here, arrowprops={"arrowstyle": "->", "color": palette.INK, "shrinkA": 6.0, "shrinkB": 0.0}
        )
        upright = end[0] == here[0]
        axes.annotate(
            text, (0.5 * (here[0] + end[0]), 0.5 * (here[1] + end[1])), (8.0, 0.0) if upright else (0.0, 5.0),
            textcoords="offset points", ha="left" if upright else "center", va="center" if upright else "bottom",
            fontsize=style.SMALL_PT, fontfamily=style.FONT, color=palette.INK,
        )  # fmt: skip
    style.dress(axes, f"Running time ({scale.unit})", f"{energy_name(score.result.trip)} ({energy.unit})")
    axes.yaxis.label.set_fontsize(style.SMALL_PT)
    axes.margins(0.08, 0.14)
    style.legend(axes, "upper right")
