"""The front method against IPOPT: the same trips, the same 60 running times, in the same run."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import tgvdp
from benchmarks.accuracy import gaps_pct
from benchmarks.instances import SHARED, Instance, reference_instances, synthetic_instance
from benchmarks.ipopt_nlp import DirectTranscription, Solution
from benchmarks.output import Report
from benchmarks.timing import median_s
from tgvdp.referee.replay import Verdict, replay
from tgvdp.report import palette, style
from tgvdp.runs.profile import profile_of

#: Cells per trip that are tried, coarsest first: the fewer, the faster for IPOPT.
_MESHES = (75, 150, 300, 600)
#: Cells of the mesh that accuracy is measured against.
_FINEST = 1000
#: A mesh this accurate at every point is good enough even where our front is better.
_GOOD_PCT = 0.03


def run(shared: Path = SHARED, quick: bool = False) -> Report | None:
    """Compare on all reference instances, or on synthetic lines where there are none; None without CasADi."""
    try:
        import casadi
    except ImportError:
        return None
    instances = reference_instances(shared) or [synthetic_instance(30e3), synthetic_instance(50e3)]
    points = 60
    if quick:
        instances, points = [synthetic_instance(30e3)], 5
    report = Report(
        "ipopt",
        f"{points}-point fronts: tgvdp against IPOPT",
        options={"points": points, "max_margin": 0.25, "quick": quick, "casadi": casadi.__version__},
        inputs={instance.name: instance.track for instance in instances},
        notes=[
            "The peer is a direct transcription of our own writing (`benchmarks/ipopt_nlp.py`) for CasADi "
            f"{casadi.__version__} and its IPOPT with MUMPS: exact sparse derivatives, scaled unknowns, a good first "
            "start, barrier options tuned. Building its problem (`build s`) is not counted.",
            f"Its mesh is the coarsest of those tried ({', '.join(map(str, _MESHES))} cells and more near stops and "
            f"breaks) whose energy at every point is within {_GOOD_PCT} % of its own mesh of {_FINEST} cells, or as "
            "near as ours is: `error %` is the largest difference over the points, of the peer and of our front.",
            "Columns `equal`: the coarsest mesh that is as accurate as our front, of those and the finest one.",
            "`gap %`: largest absolute difference from the reference optimum at its margins, where there is one.",
            "cold: each point from the slowed fastest run; warm: from the solution before it, multipliers included. "
            "The first point, the fastest run, is a problem of its own.",
            "Replay ok: points whose profile the referee passes. IPOPT's constant effort per cell exceeds the corner "
            "of min(F, P/v) by up to 1 % in one cell, which is its mesh error, not a fault.",
        ],
    )
    for instance in instances:
        report.rows.append(_compared(instance, points, repeats=2 if quick else 5))
    report.figures = _figures(report.rows)
    report.plot = _plot(report.rows)
    return report


def _compared(instance: Instance, points: int, repeats: int) -> dict[str, Any]:
    def ours() -> Any:
        return tgvdp.search(**instance.arguments, points=points)

    ours()
    before_s, result = median_s(ours, repeats)
    targets_s = result.front.time_s[1:]
    peer = _mesh(result, instance, _FINEST)
    finest = _Mesh(peer, _solved(peer, targets_s), 0.0)
    own_error = _error_pct(result.front.energy_j[1:], finest.warm)
    coarse, equal = None, finest
    for cells in _MESHES:
        peer = _mesh(result, instance, cells)
        warm = _solved(peer, targets_s)
        error = _error_pct(np.array([one.energy_j for one in warm]), finest.warm)
        if coarse is None and error <= max(own_error, _GOOD_PCT):
            coarse = _Mesh(peer, warm, error)
        if error <= own_error:
            equal = _Mesh(peer, warm, error)
            break
    peer, warm, error = coarse or finest
    first, cold = peer.fastest(), _cold(peer, targets_s)
    equal_cold = cold if equal.peer is peer else _cold(equal.peer, targets_s)
    equal_first = first if equal.peer is peer else equal.peer.fastest()
    after_s, _ = median_s(ours, repeats)
    ours_s = 0.5 * (before_s + after_s)
    cold_s, warm_s = (_seconds(first, run) for run in (cold, warm))
    equal_cold_s, equal_warm_s = (_seconds(equal_first, run) for run in (equal_cold, equal.warm))
    gaps = [100.0 * (peer.solve(one.time_s).energy_j / one.energy_j - 1.0) for one in instance.references]
    return {
        "instance": instance.name,
        "kind": instance.kind,
        "points": len(result.front),
        "ours ms": 1e3 * ours_s,
        "IPOPT cold ms": 1e3 * cold_s,
        "IPOPT warm ms": 1e3 * warm_s,
        "cold ms/point": 1e3 * cold_s / len(result.front),
        "warm ms/point": 1e3 * warm_s / len(result.front),
        "cold ratio": cold_s / ours_s,
        "warm ratio": warm_s / ours_s,
        "cold ratio, equal": equal_cold_s / ours_s,
        "warm ratio, equal": equal_warm_s / ours_s,
        "cells": len(peer.cells.length_m),
        "cells, equal": len(equal.peer.cells.length_m),
        "build s": peer.build_s,
        "error %, IPOPT": error,
        "error %, ours": own_error,
        "gap %, IPOPT": float(np.abs(gaps).max()) if gaps else float("nan"),
        "gap %, ours": float(np.abs(gaps_pct(result, instance)).max()) if gaps else float("nan"),
        "converged": sum(one.converged for one in (first, *cold, *warm)) / (1 + len(cold) + len(warm)),
        "replay ok, IPOPT": sum(_replayed(peer, one).ok for one in warm) / len(warm),
        "replay ok, ours": sum(verdict.ok for verdict in result.verify()) / len(result.front),
    }


class _Mesh(NamedTuple):
    """A mesh of the peer, its warm-started points, and their largest error in percent."""

    peer: DirectTranscription
    warm: list[Solution]
    error_pct: float


def _cold(peer: DirectTranscription, targets_s: NDArray[np.float64]) -> list[Solution]:
    return [peer.solve(float(time_s)) for time_s in targets_s]


def _seconds(first: Solution, others: list[Solution]) -> float:
    return first.solve_s + sum(one.solve_s for one in others)


def _mesh(result: Any, instance: Instance, cells: int) -> DirectTranscription:
    return DirectTranscription(result.trip, result.fastest.profile, instance.distance_m / cells)


def _solved(peer: DirectTranscription, targets_s: NDArray[np.float64]) -> list[Solution]:
    """All points in turn, each from the solution before it, the first from the slowed fastest run."""
    found: list[Solution] = []
    for time_s in targets_s:
        found.append(peer.solve(float(time_s), found[-1].start if found else None))
    return found


def _error_pct(energy_j: NDArray[np.float64], finest: list[Solution]) -> float:
    """Largest difference from the finest mesh, in percent."""
    return 100.0 * float(np.abs(energy_j / np.array([one.energy_j for one in finest]) - 1.0).max())


def _replayed(peer: DirectTranscription, solution: Solution) -> Verdict:
    return replay(peer.trip, profile_of(peer.trip, peer.cells.station_m, solution.speed_mps**2))


def _figures(rows: list[dict[str, Any]]) -> dict[str, Any]:
    figures: dict[str, Any] = {}
    for kind in ("main line", "metro"):
        members = [row for row in rows if row["kind"] == kind]
        if members:
            figures[kind] = {
                f"{start}{mesh}_{name}": float(call([row[f"{start} ratio{column}"] for row in members]))
                for start in ("cold", "warm")
                for mesh, column in (("", ""), ("_equal", ", equal"))
                for name, call in (("min", min), ("median", np.median), ("max", max))
            } | {
                f"{start}_ms_per_point": float(np.median([row[f"{start} ms/point"] for row in members]))
                for start in ("cold", "warm")
            }
    return figures


def _plot(rows: list[dict[str, Any]]) -> Any:
    figure = style.new_figure(2.2 + 0.4 * len(rows))
    axes = figure.add_subplot()
    place = np.arange(len(rows))
    bars = (("ours ms", palette.VERMILION), ("IPOPT warm ms", palette.SKY), ("IPOPT cold ms", palette.BLUE))
    for shift, (column, color) in enumerate(bars):
        axes.barh(place + 0.26 * (shift - 1), [row[column] for row in rows], 0.24, color=color, label=column[:-3])
    for y, row in zip(place, rows, strict=True):
        axes.annotate(
            f" {row['warm ratio']:.0f} ×", (row["IPOPT cold ms"], y), va="center", fontsize=style.SMALL_PT,
            fontfamily=style.FONT, color=palette.INK,
        )  # fmt: skip
    axes.set_yticks(place, [row["instance"] for row in rows])
    axes.invert_yaxis()
    axes.set_xscale("log")
    style.dress(axes, f"time of a {rows[0]['points']}-point front, ms")
    style.title(axes, "The whole front, against IPOPT", "one core; the ratio is that of the warm-started solver")
    style.legend(figure, "outside lower center", columns=3)
    return figure
