"""Gaps to the reference optimum, replay and certificate of every reference instance, and the time of its front."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import tgvdp
from benchmarks.instances import Instance, reference_instances
from benchmarks.output import Report
from benchmarks.timing import median_s, on_all_cores
from tgvdp.report import palette, style
from tgvdp.units import JOULE_PER_KWH, SECONDS_PER_MINUTE

MARGINS_PCT = (3.0, 5.0, 10.0, 15.0, 20.0)


def energy_at(result: Any, time_s: float) -> float:
    """Energy of a front at a running time, J: the cubic through the two neighbouring points, whose slopes are −λ.

    The slope at the fastest run is infinite: beside it, the parabola with the slope of the other point.
    """
    times, energies = result.front.time_s, result.front.energy_j
    slopes = -result.price_kwh_per_min * JOULE_PER_KWH / SECONDS_PER_MINUTE
    i = int(np.clip(np.searchsorted(times, time_s) - 1, 0, len(times) - 2))
    step = times[i + 1] - times[i]
    u = (time_s - times[i]) / step
    after = slopes[i + 1]
    before = slopes[i] if np.isfinite(slopes[i]) else 2.0 * (energies[i + 1] - energies[i]) / step - after
    ends = (1.0 + 2.0 * u) * (1.0 - u) ** 2 * energies[i] + u * u * (3.0 - 2.0 * u) * energies[i + 1]
    return float(ends + step * (u * (1.0 - u) ** 2 * before - u * u * (1.0 - u) * after))


def gaps_pct(result: Any, instance: Instance) -> NDArray[np.float64]:
    """Energy above the reference at each reference margin, in percent."""
    return np.array([100.0 * (energy_at(result, one.time_s) / one.energy_j - 1.0) for one in instance.references])


def run(shared: Path, quick: bool) -> Report | None:
    """Measure all reference instances; None where the reference data are absent."""
    instances = reference_instances(shared)
    if not instances:
        return None
    report = Report(
        "accuracy",
        "Accuracy: 60-point fronts against the reference optimum",
        options={"points": 60, "max_margin": 0.25, "quick": quick},
        inputs={"reference": shared / "reference" / "optimum.csv"},
        notes=[
            "Gap: energy above the reference optimum of the continuous problem (itself accurate to 0.03 %) at each "
            "running-time margin, read from the 60-point front between two of its points by the cubic whose slopes "
            "are their prices. Below −0.03 % would be infeasible.",
            "Replay: largest absolute value over the points of the front. Certificate: median and largest gap between "
            "a point's energy and a proven lower bound at its running time.",
            "`front ms` is `tgvdp.search` on one core, warm, median, `front, all cores ms` on all; replay and "
            "certificate are timed apart.",
        ],
    )
    for instance in instances[-3:] if quick else instances:
        report.rows.append(_measured(instance, repeats=2 if quick else 9))
    report.figures = _figures(report.rows)
    report.plot = _plot(report.rows)
    return report


def _measured(instance: Instance, repeats: int) -> dict[str, Any]:
    tgvdp.search(**instance.arguments)
    front_s, result = median_s(lambda: tgvdp.search(**instance.arguments), repeats)
    with on_all_cores():
        tgvdp.search(**instance.arguments)
        all_s, _ = median_s(lambda: tgvdp.search(**instance.arguments), repeats)
    gaps = gaps_pct(result, instance)
    row: dict[str, Any] = {
        "instance": instance.name,
        "kind": instance.kind,
        "T_min error %": 100.0 * (result.fastest.time_s / instance.fastest_s - 1.0),
    }
    row |= {f"gap % at {one.margin_pct:g} %": float(gap) for one, gap in zip(instance.references, gaps, strict=True)}
    worst_j = max((gap / 100.0 * one.energy_j for gap, one in zip(gaps, instance.references, strict=True)))
    row["worst gap kWh"] = float(worst_j / JOULE_PER_KWH)
    result.verify()
    replay_s, verdicts = median_s(result.verify, repeats)
    row |= _certified(result, repeats)
    row |= {
        "replay time %": max(abs(verdict.time_error_pct) for verdict in verdicts),
        "replay energy %": max(abs(verdict.energy_error_pct) for verdict in verdicts),
        "overspeed m/s": max(verdict.overspeed_mps for verdict in verdicts),
        "effort excess %": max(verdict.effort_excess_pct for verdict in verdicts),
        "replay ms": 1e3 * replay_s,
        "points": len(result.front),
        "front ms": 1e3 * front_s,
        "front, all cores ms": 1e3 * all_s,
    }
    return row


def _certified(result: Any, repeats: int) -> dict[str, float]:
    """Certified gaps of a result."""
    result.certify()
    certify_s, certificate = median_s(result.certify, repeats)
    gaps = certificate.gap_pct
    return {
        "certified median %": float(np.median(gaps)),
        "certified max %": float(gaps.max()),
        "certify ms": 1e3 * certify_s,
    }


def _figures(rows: list[dict[str, Any]]) -> dict[str, Any]:
    figures: dict[str, Any] = {}
    for kind in ("main line", "metro"):
        members = [row for row in rows if row["kind"] == kind]
        if not members:
            continue
        gaps = [row[name] for row in members for name in row if name.startswith("gap % at")]
        figures[kind] = {
            "instances": len(members),
            "max_gap_pct": max(gaps),
            "min_gap_pct": min(gaps),
            "max_gap_kwh": max(row["worst gap kWh"] for row in members),
            "front_ms_median": float(np.median([row["front ms"] for row in members])),
            "front_ms_max": max(row["front ms"] for row in members),
            "all_cores_ms_max": max(row["front, all cores ms"] for row in members),
            "certify_ms_max": max(row["certify ms"] for row in members),
            "certified_median_pct": float(np.median([row["certified median %"] for row in members])),
            "certified_max_pct": max(row["certified max %"] for row in members),
        }
    figures["t_min_error_pct"] = max(abs(row["T_min error %"]) for row in rows)
    for name, column in (
        ("replay_time_pct", "replay time %"),
        ("replay_energy_pct", "replay energy %"),
        ("overspeed_mps", "overspeed m/s"),
        ("effort_excess_pct", "effort excess %"),
        ("replay_ms", "replay ms"),
    ):
        figures[name] = max(row[column] for row in rows)
    return figures


def _plot(rows: list[dict[str, Any]]) -> Any:
    figure = style.new_figure(3.0 + 0.28 * len(rows))
    axes = figure.add_subplot()
    colors = (palette.BLUE, palette.SKY, palette.GREEN, palette.ORANGE, palette.VERMILION)
    for margin, color in zip(MARGINS_PCT, colors, strict=True):
        gaps = [row[f"gap % at {margin:g} %"] for row in rows]
        axes.plot(gaps, range(len(rows)), "o", color=color, markersize=5, label=f"{margin:g} % margin")
    axes.axvline(0.0, color=palette.INK, linewidth=0.8)
    axes.axvspan(-0.03, 0.03, color=palette.GROUND, zorder=0)
    axes.set_yticks(range(len(rows)), [row["instance"] for row in rows])
    axes.invert_yaxis()
    style.dress(axes, "energy above the reference optimum, %")
    style.title(axes, "Gap to the continuous optimum", "shaded: accuracy of the reference itself")
    style.legend(figure, "outside lower center", columns=5)
    return figure
