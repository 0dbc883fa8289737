"""How the front method scales: with the length of the line, the number of points, the number of cells, and cores."""

import os
from pathlib import Path
from typing import Any

import numpy as np

import tgvdp
from benchmarks.accuracy import energy_at
from benchmarks.inside import finer_cells
from benchmarks.instances import SHARED, synthetic_instance
from benchmarks.output import Report
from benchmarks.timing import median_s, probe
from tgvdp.report import palette, style

LENGTHS_KM = (30, 60, 125, 250, 500, 1000)
POINTS = (15, 30, 60, 120, 240)
CELLS = (0.5, 1.0, 2.0, 4.0)
BASE_KM, QUICK_KM = 60, 10

_COLUMNS = ("varied", "value", "front ms", "cells", "points", "extremals", "runs", "costates", "energy diff %")
_EMPTY: dict[str, Any] = dict.fromkeys(_COLUMNS)


def run(_shared: Path = SHARED, quick: bool = False) -> Report:
    """Measure synthetic lines of fixed seed."""
    repeats = 2 if quick else 5
    lengths_km = (QUICK_KM,) if quick else LENGTHS_KM
    base_m = 1e3 * (QUICK_KM if quick else BASE_KM)
    report = Report(
        "scaling",
        "Scaling: length, points, cells, cores",
        options={"max_margin": 0.25, "quick": quick},
        inputs={f"{km} km": synthetic_instance(1e3 * km).track for km in lengths_km},
        notes=[
            "Synthetic lines of a fixed seed (`benchmarks/instances.py`) with a synthetic multiple unit; one core, "
            "warm, median; one thing is varied at a time, the rest is 60 points and the cells that the method chooses.",
            f"Points and cells: line of {base_m / 1e3:g} km; cores: {lengths_km[-1]} km. The factor of cells divides "
            "the cell size that the method chooses; `energy diff %` is the largest difference of energies from the "
            "finest mesh at the same running times.",
            "Cores: a fresh process on one and on all; the fronts are asserted to be identical bit by bit.",
        ],
    )
    report.rows += [_length(km, repeats) for km in lengths_km]
    report.rows += [_points(base_m, count, repeats) for count in (POINTS[:2] if quick else POINTS)]
    report.rows += _cells(base_m, CELLS[:2] if quick else CELLS, repeats)
    report.rows += _cores(lengths_km[-1], repeats)
    report.figures = _figures(report.rows)
    report.plot = _plot(report.rows)
    return report


def _row(varied: str, value: float, front_s: float, result: Any) -> dict[str, Any]:
    return _EMPTY | {
        "varied": varied,
        "value": value,
        "front ms": 1e3 * front_s,
        "cells": result.counters["cells"],
        "points": len(result.front),
        **{name: result.counters[name] for name in ("extremals", "runs", "costates")},
    }


def _length(km: float, repeats: int) -> dict[str, Any]:
    arguments = synthetic_instance(1e3 * km).arguments
    tgvdp.search(**arguments)
    front_s, result = median_s(lambda: tgvdp.search(**arguments), repeats)
    return _row("length km", km, front_s, result)


def _points(base_m: float, count: int, repeats: int) -> dict[str, Any]:
    arguments = synthetic_instance(base_m).arguments | {"points": count}
    tgvdp.search(**arguments)
    front_s, result = median_s(lambda: tgvdp.search(**arguments), repeats)
    return _row("points", count, front_s, result)


def _cells(base_m: float, factors: tuple[float, ...], repeats: int) -> list[dict[str, Any]]:
    arguments = synthetic_instance(base_m).arguments
    rows, results = [], []
    for factor in factors:
        with finer_cells(factor):
            front_s, result = median_s(lambda: tgvdp.search(**arguments), repeats)
            rows.append(_row("cells factor", factor, front_s, result))
            results.append(result)
    for row, result in zip(rows, results, strict=True):
        row["energy diff %"] = _difference_pct(result, results[-1])
    return rows


def _difference_pct(result: Any, finest: Any) -> float:
    """Largest difference of energies at the running times of the finest front that both reach."""
    times, energies = finest.front.time_s, finest.front.energy_j
    common = (times > result.fastest.time_s) & (times <= result.front.time_s[-1])
    ours = np.array([energy_at(result, float(time_s)) for time_s in times[common]])
    return 100.0 * float(abs(ours / energies[common] - 1.0).max())


def _cores(km: float, repeats: int) -> list[dict[str, Any]]:
    rows = []
    digests = set()
    for count in sorted({1, os.cpu_count() or 1}):
        found = probe(1e3 * km, 60, repeats, all_cores=count > 1)
        digests.add(found["digest"])
        rows.append(
            _EMPTY | {"varied": "cores", "value": count, "front ms": 1e3 * found["warm_s"], "points": found["points"]}
        )
    if len(digests) != 1:
        raise AssertionError("the front depends on the number of cores")
    return rows


def _figures(rows: list[dict[str, Any]]) -> dict[str, Any]:
    figures: dict[str, Any] = {}
    for row in rows:
        figures.setdefault(row["varied"], {})[f"{row['value']:g}"] = row["front ms"]
    return figures


def _plot(rows: list[dict[str, Any]]) -> Any:
    figure = style.new_figure(3.8)
    labels = {"length km": "length, km", "points": "points", "cells factor": "cells, × default", "cores": "cores"}
    for axes, (varied, label) in zip(figure.subplots(1, 4), labels.items(), strict=True):
        members = [row for row in rows if row["varied"] == varied]
        axes.plot([row["value"] for row in members], [row["front ms"] for row in members], "o-", color=palette.BLUE)
        axes.set_ylim(bottom=0.0)
        if varied == "cores":
            axes.set_xticks([row["value"] for row in members])
        style.dress(axes, label, "front, ms" if varied == "length km" else "")
    figure.suptitle("Time of a front", x=0.01, ha="left", fontsize=style.TITLE_PT, fontweight="bold", color=palette.INK)
    return figure
