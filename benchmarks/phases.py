"""Where the time of a front goes, and how far that is from the least that any program must do."""

import statistics
from pathlib import Path
from typing import Any

import numpy as np

import tgvdp
from benchmarks.inside import mesh_of, phases_of
from benchmarks.instances import SHARED, Instance, reference_instances, synthetic_instance
from benchmarks.output import Report
from benchmarks.timing import median_s
from tgvdp._jit import kernel
from tgvdp.physics.arc import arc
from tgvdp.report import palette, style

#: Bytes of one row of a run as the search keeps it: position and squared speed.
_ROW_BYTES = 16
_COPY_BYTES = 64 * 2**20
_WANTED = ("00_reference", "CH_StGallen_Wil", "CN_Songjiazhuang_Yizhuang 0–2631 m")
_COLORS = (palette.MUTED, palette.SKY, palette.BLUE, palette.VERMILION, palette.ORANGE)


@kernel
def _arcs(train, length, grade, air, w, repeats):
    """Evaluate all arcs of a run again and again: what reading one finished run costs at least."""
    total = 0.0
    for _ in range(repeats):
        for i in range(length.shape[0]):
            total += arc(train, length[i], grade[i], air[i], w[i], w[i + 1])[1]
    return total


def run(shared: Path = SHARED, quick: bool = False) -> Report:
    """Measure a main line, a hilly main line, a metro section and a long synthetic line."""
    repeats = 3 if quick else 15
    instances = [one for one in reference_instances(shared) if one.name in _WANTED] + [synthetic_instance(500e3)]
    if quick:
        instances = [synthetic_instance(30e3)]
    report = Report(
        "phases",
        "Where the time goes",
        options={"points": 60, "max_margin": 0.25, "quick": quick},
        inputs={instance.name: instance.track for instance in instances},
        notes=[
            "`ms` columns: wall time of one search by phase, medians, one core, warm; the phases add up to the total.",
            "Cells: of the mesh that was fine enough; extremals, runs and costates: on all meshes. ns/costate: "
            "backward passes over polyline points carried one cell; µs/run: drives over runs; ns/arc: one evaluation "
            "of the arc function in a tight loop over the same cells.",
            "Floor: evaluate each cell of each point of the front once and write its rows (16 bytes each) at the speed "
            "with which this machine copies 64 MB. It is what a program pays that knows all answers: no extremals, no "
            "search for the running time. `× floor` is the total over it.",
        ],
    )
    bytes_per_s = _copy_speed(3 if quick else 9)
    report.rows = [_measured(instance, repeats, bytes_per_s) for instance in instances]
    report.figures = {
        "copy_gb_per_s": bytes_per_s / 1e9,
        **{str(row["instance"]): {key: row[key] for key in row if key != "instance"} for row in report.rows},
    }
    report.plot = _plot(report.rows)
    return report


def _copy_speed(repeats: int) -> float:
    source, target = np.ones(_COPY_BYTES // 8), np.zeros(_COPY_BYTES // 8)
    copy_s, _ = median_s(lambda: np.copyto(target, source), repeats)
    return _COPY_BYTES / copy_s


def _measured(instance: Instance, repeats: int, bytes_per_s: float) -> dict[str, Any]:
    def search() -> Any:
        return tgvdp.search(**instance.arguments)

    search()
    total_s, result = median_s(search, repeats)
    runs = [phases_of(search) for _ in range(repeats)]
    spent_s = {name: statistics.median(run[name] for run in runs) for name in runs[0]}
    mesh = mesh_of(result)
    cells = len(mesh.cells.length_m)
    rows = sum(len(result.profile(index).time_s) for index in range(len(result.front)))
    arc_s = _arc_s(mesh, 3 if repeats < 5 else 9)
    write_s = rows * _ROW_BYTES / bytes_per_s
    floor_s = len(result.front) * cells * arc_s + write_s
    return {
        "instance": instance.name,
        "total ms": 1e3 * total_s,
        **{f"{name} ms": 1e3 * value for name, value in spent_s.items()},
        "cells": cells,
        "extremals": result.counters["extremals"],
        "runs": result.counters["runs"],
        "costates": result.counters["costates"],
        "ns/costate": 1e9 * spent_s["backward passes"] / max(result.counters["costates"], 1),
        "µs/run": 1e6 * spent_s["drives"] / result.counters["runs"],
        "ns/arc": 1e9 * arc_s,
        "rows": rows,
        "KB to write": rows * _ROW_BYTES / 1e3,
        "floor: arcs ms": 1e3 * (floor_s - write_s),
        "floor: write ms": 1e3 * write_s,
        "× floor": total_s / floor_s,
    }


def _arc_s(mesh: Any, repeats: int) -> float:
    """Time of one arc over the mesh, driven along the fastest run."""
    cells = mesh.cells
    loops = max(1, 200_000 // len(cells.length_m))
    arguments = (mesh.train, cells.length_m, cells.grade_n, cells.air, mesh.fast, loops)
    _arcs(*arguments)
    spent_s, _ = median_s(lambda: _arcs(*arguments), repeats)
    return spent_s / (loops * len(cells.length_m))


def _plot(rows: list[dict[str, Any]]) -> Any:
    figure = style.new_figure(2.4 + 0.5 * len(rows))
    axes = figure.add_subplot()
    names = [name for name in rows[0] if name.endswith(" ms") and not name.startswith(("total", "floor"))]
    sums = [sum(row[name] for name in names) for row in rows]
    left = np.zeros(len(rows))
    for name, color in zip(names, _COLORS, strict=True):
        shares = np.array([100.0 * row[name] / total for row, total in zip(rows, sums, strict=True)])
        axes.barh(range(len(rows)), shares, 0.6, left=left, color=color, label=name[:-3])
        left += shares
    axes.set_yticks(range(len(rows)), [f"{row['instance']}\n{row['total ms']:.3g} ms" for row in rows])
    axes.invert_yaxis()
    style.dress(axes, "share of the time of a front, %")
    style.title(axes, "Where the time goes", "60 points, one core, warm")
    style.legend(figure, "outside lower center", columns=5)
    return figure
