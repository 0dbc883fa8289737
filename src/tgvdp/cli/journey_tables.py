"""Tables of ``tgvdp journey``: its front beside today's practices, splits under delays, margins side by side."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tgvdp.cli.screen import ROWS, aligned, column, duration, spread, wrapped
from tgvdp.units import joule_to_kwh

if TYPE_CHECKING:
    from tgvdp.api import JourneyResult
    from tgvdp.journeys.bound import JourneyBound
    from tgvdp.journeys.delays import Robustness

#: Waiting for windows is told from so many seconds on.
_TOLD_S = 0.5


def front_table(result: "JourneyResult", content: Mapping[str, Any], bound: "JourneyBound | None") -> str:
    """A dozen points at most: time, energy, price, what the practices take more, and the gap where it is known."""
    front = content["front"]
    chosen = spread(len(front), ROWS)
    rows = [front[index] for index in chosen]
    columns = [
        column("margin", "%", 8, [f"{100.0 * (row['time_s'] / result.fastest_time_s - 1.0):.2f}" for row in rows]),
        column("time", "", 9, [duration(row["time_s"]) for row in rows]),
        column("energy", "kWh", 8, aligned([row["energy_kwh"] for row in rows], 5)),
        column("price", "kWh/min", 7, aligned([row["price_kwh_per_min"] for row in rows], 4)),
    ]
    if (result.found.waiting_s > _TOLD_S).any():
        columns.append(column("waiting", "", 9, [duration(row["waiting"]["time_s"]) for row in rows]))
    for name, practice in content["practices"].items():
        more = [practice[index]["energy_kwh"] - front[index]["energy_kwh"] for index in chosen]
        columns.append(column(name.replace("_", " "), "kWh more", 8, aligned(more, 4)))
    if bound is not None:
        gap_pct = bound.gap_pct(result.front.energy_j)
        gaps = [f"{gap_pct[index]:.3f}" if math.isfinite(gap_pct[index]) else "–" for index in chosen]
        columns.append(column("gap", "%", 6, gaps))
    lines = ["  ".join(cells) for cells in zip(*columns, strict=True)]
    return "\n".join([*lines, _sections_line(result)])


def _sections_line(result: "JourneyResult") -> str:
    """How many sections there are, and what running times leave out."""
    sections, dwells = len(result.sections), len(result.sections) - 1
    line = f"{sections} section{'s' if dwells else ''}, fastest {duration(result.fastest_time_s)}"
    if not dwells:
        return line
    return f"{line} without {dwells} dwell{'s' if dwells > 1 else ''} of {result.options['dwell_s']:g} s"


def robustness_table(robustness: "Robustness") -> str:
    """The optimum, today's practices, and the allocation on both fronts."""
    named = [at for at, name in enumerate(robustness.names) if "%" not in name]
    rows = dict.fromkeys([*named, robustness.on_both])
    names = [name.replace("_", " ") for name in robustness.names]
    columns = [
        column("", "with delays", 11, [names[at] for at in rows]),
        column("planned", "kWh", 8, aligned([joule_to_kwh(float(robustness.planned_j[at])) for at in rows], 5)),
        column("expected", "kWh", 8, aligned([joule_to_kwh(float(robustness.energy_j[at])) for at in rows], 5)),
        column("delay", "s", 7, aligned([float(robustness.delay_s[at]) for at in rows], 4)),
        column("punctual", "%", 8, [f"{100.0 * robustness.punctual[at]:.1f}" for at in rows]),
    ]
    lines = ["  ".join(cells) for cells in zip(*columns, strict=True)]
    return "\n".join([*lines, f"cheapest as planned on the second front: {names[robustness.on_both]}"])


def margins_table(content: Mapping[str, Any]) -> str:
    """One supplement, taken in four ways, of an object of schema tgvdp.journey/1."""
    runs = content["runs"]
    columns = [
        column("margin", "", 8, [run["name"] for run in runs]),
        column("time", "", 9, [duration(run["time_s"]) for run in runs]),
        column("energy", "kWh", 8, aligned([run["energy_kwh"] for run in runs], 5)),
        column("above optimum", "%", 8, [f"{run['above_optimum_pct']:.2f}" for run in runs]),
        column("off linear time by", "s at most", 8, aligned([run["deviation_s"] for run in runs], 3)),
    ]
    lines = ["  ".join(cells) for cells in zip(*columns, strict=True)]
    return "\n".join([f"{content['margin']} more time:", *lines])


def journey_advice_lines(content: Mapping[str, Any], train: str) -> str:
    """What the driver of a train does in each section at the middle point."""
    advice = content["advice"]
    lines = [f"how to drive point {advice['point']} of {len(content['front'])} with {train}:"]
    for number, (section, own) in enumerate(zip(content["sections"], advice["sections"], strict=True), start=1):
        named = "from" in section or "to" in section
        ends = f"{section.get('from', '…')} – {section.get('to', '…')}" if named else ""
        lines.append(wrapped(f"{number}{f' {ends}' if ends else ''}: {own['advice']}", "  "))
    return "\n".join(lines)
