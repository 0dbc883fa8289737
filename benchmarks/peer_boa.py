"""Exact label search against BOA* and NAMOA*dr in C on the same explicit graph; identical fronts are asserted."""

import ctypes
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.instances import SHARED, Instance, reference_instances, synthetic_instance
from benchmarks.output import Report
from benchmarks.timing import median_s
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.grid.exact import exact_paths
from tgvdp.methods.grid.grid import build_grid
from tgvdp.methods.grid.layered import LayeredGraph, layered_graph
from tgvdp.model.trip import Trip
from tgvdp.report import palette, style
from tgvdp.runs.fastest import fastest_run

SOURCE = Path(__file__).with_name("peer_boa.c")
FLAGS = ("-std=c99", "-O3", "-march=native", "-shared", "-fPIC")
#: Costs become whole multiples of these, so that no sum is rounded and fronts can be compared bit by bit.
TIME_QUANTUM_S = 2.0**-30
ENERGY_QUANTUM_J = 2.0**-8
PEERS = ("BOA*", "NAMOA*dr")
MARGIN = 0.25
#: A peer that takes longer is not asked again: its time varies by much less than it lags behind.
_MOST_S = 2.0


class Peer:
    """The compiled C search."""

    def __init__(self, compiler: str) -> None:
        with tempfile.TemporaryDirectory() as folder:
            library = Path(folder) / "peer_boa.so"
            subprocess.run([compiler, *FLAGS, str(SOURCE), "-o", str(library), "-lm"], check=True)
            self._search = ctypes.CDLL(str(library)).bi_objective_search
        doubles = np.ctypeslib.ndpointer(np.float64, flags="C")
        longs = np.ctypeslib.ndpointer(np.int64, flags="C")
        ints = np.ctypeslib.ndpointer(np.int32, flags="C")
        self._search.restype = ctypes.c_int64
        self._search.argtypes = [
            ctypes.c_int64, longs, ints, doubles, doubles, ctypes.c_double, ctypes.c_int, ctypes.c_int64,
            doubles, doubles, longs,
        ]  # fmt: skip

    def search(
        self, graph: LayeredGraph, limit_s: float, name: str, room: int = 1_000_000
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], dict[str, int]]:
        """Front (times, energies) of a graph within a time limit, and counters of work done."""
        front_s, front_j = np.empty(room), np.empty(room)
        counters = np.zeros(4, dtype=np.int64)
        count = self._search(
            graph.n_nodes, graph.arc_ptr, graph.arc_to, graph.duration_s, graph.energy_j, limit_s,
            PEERS.index(name), room, front_s, front_j, counters,
        )  # fmt: skip
        if count < 0:
            raise RuntimeError(f"the peer {name} ended with status {count}")
        names = ("labels", "expanded", "most_open", "bytes")
        return front_s[:count].copy(), front_j[:count].copy(), dict(zip(names, counters.tolist(), strict=True))


def compiler() -> str | None:
    """The system's C compiler, if any."""
    return shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")


def exact_graph(graph: LayeredGraph) -> LayeredGraph:
    """The same graph with costs rounded so that all sums along paths are exact."""
    return graph._replace(
        duration_s=np.round(graph.duration_s / TIME_QUANTUM_S) * TIME_QUANTUM_S,
        energy_j=np.round(graph.energy_j / ENERGY_QUANTUM_J) * ENERGY_QUANTUM_J,
    )


def random_graph(layers: int, width: int, seed: int) -> LayeredGraph:
    """Full layers joined by all arcs, with uniform costs: no structure that a search could use."""
    random = np.random.default_rng(seed)
    sizes = np.array([1, *[width] * (layers - 2), 1])
    first = np.concatenate(([0], np.cumsum(sizes)))
    spans = [np.arange(first[k], first[k + 1]) for k in range(layers)]
    pairs = [np.stack(np.meshgrid(spans[k], spans[k + 1]), -1).reshape(-1, 2) for k in range(layers - 1)]
    source, target = np.concatenate(pairs).T
    duration_s, energy_j = random.uniform(1.0, 10.0, (2, len(source)))
    return layered_graph(sizes, source, target, duration_s, energy_j)


def grid_graph(instance: Instance, segments: int, speeds: int) -> tuple[LayeredGraph, float]:
    """Grid of an instance and the time limit of the search on it, s."""
    trip = Trip(
        train=instance.train, track=instance.track, origin_m=instance.origin_m, destination_m=instance.destination_m
    )
    grid = build_grid(trip, instance.distance_m / segments, speeds)
    return grid.graph, fastest_run(trip).duration_s * (1.0 + MARGIN)


def run(shared: Path = SHARED, quick: bool = False) -> Report | None:
    """Compare on grids of real and synthetic lines and on a random graph; None without a C compiler."""
    cc = compiler()
    if cc is None:
        return None
    peer = Peer(cc)
    cases = _cases(shared, quick)
    report = Report(
        "labels",
        "Exact label search: tgvdp against BOA* and NAMOA*dr in C",
        options={"margin": MARGIN, "flags": " ".join(FLAGS), "quick": quick},
        inputs={"peer": SOURCE},
        notes=[
            "The peers are plain C of our own writing (`benchmarks/peer_boa.c`), compiled with "
            f"`{' '.join(FLAGS)}`, with the ideal point to go as heuristic, a 4-ary heap and their own pruning by it; "
            "finding it is part of all times, and so is ours to extract all paths, which the peers need not do.",
            "Arc costs are whole multiples of powers of two, so that sums are exact: the fronts are asserted to be "
            "identical bit by bit.",
            "bytes/label: the memory that labels take at the peak, over the labels that are stored: of ours with all "
            "room that is not in use, of the peers without it. BOA* stores labels that it never expands; ours stores "
            "none that is dominated at its node or that its bounds rule out. MB: all memory of the search, but for "
            "the graph; of ours with bounds, scratch and the arcs sorted by their ends.",
        ],
    )
    for name, graph, limit_s in cases:
        print(f"labels: {name}, {len(graph.arc_to):,} arcs", file=sys.stderr, flush=True)
        report.rows.append(_compared(peer, name, exact_graph(graph), limit_s, repeats=1 if quick else 3))
    report.figures = {
        "boa_ratio_min": min(row["BOA* ratio"] for row in report.rows),
        "boa_ratio_median": float(np.median([row["BOA* ratio"] for row in report.rows])),
        "namoa_ratio_median": float(np.median([row["NAMOA*dr ratio"] for row in report.rows])),
        "namoa_ratio_min": min(row["NAMOA*dr ratio"] for row in report.rows),
        "bytes_per_label_most": max(row["bytes/label, ours"] for row in report.rows),
    }
    report.plot = _plot(report.rows)
    return report


def _cases(shared: Path, quick: bool) -> list[tuple[str, LayeredGraph, float]]:
    if quick:
        sizes, instances, random_size = [(12, 12)], [synthetic_instance(30e3)], (6, 8)
    else:
        sizes, random_size = [(20, 20), (30, 30)], (20, 40)
        wanted = ("00_var_speed_limit_wind", "CH_StGallen_Wil")
        instances = [one for one in reference_instances(shared) if one.name in wanted] + [synthetic_instance(30e3)]
    cases = []
    for instance in instances:
        for segments, speeds in sizes:
            graph, limit_s = grid_graph(instance, segments, speeds)
            cases.append((f"{instance.name}, {segments} × {speeds}", graph, limit_s))
    graph = random_graph(*random_size, seed=7)
    cases.append((f"random, {random_size[0]} × {random_size[1]}", graph, 10.0 * random_size[0]))
    return cases


def _compared(peer: Peer, name: str, graph: LayeredGraph, limit_s: float, repeats: int) -> dict[str, Any]:
    budget = SearchBudget(time_limit_s=600.0)
    exact_paths(graph, limit_s, budget)
    ours_s, ours = median_s(lambda: exact_paths(graph, limit_s, budget), repeats)
    row: dict[str, Any] = {
        "graph": name,
        "nodes": graph.n_nodes,
        "arcs": len(graph.arc_to),
        "front": len(ours.duration_s),
        "ours ms": 1e3 * ours_s,
    }
    for which in PEERS:
        peer_s, (front_s, front_j, counters) = median_s(
            lambda which=which: peer.search(graph, limit_s, which), repeats, _MOST_S
        )
        if not (np.array_equal(front_s, ours.duration_s) and np.array_equal(front_j, ours.energy_j)):
            raise AssertionError(f"{which} finds another front than tgvdp on {name}")
        row |= {
            f"{which} ms": 1e3 * peer_s,
            f"{which} ratio": peer_s / ours_s,
            f"labels, {which}": counters["labels"],
            f"expanded, {which}": counters["expanded"],
            f"bytes/label, {which}": counters["bytes"] / counters["labels"],
            f"MB, {which}": 1e-6 * counters["bytes"],
        }
    return row | {
        "labels, ours": ours.counters["labels"],
        "million labels/s, ours": 1e-6 * ours.counters["labels"] / ours_s,
        "bytes/label, ours": ours.counters["label_bytes"] / ours.counters["labels"],
        "MB, ours": 1e-6 * ours.counters["bytes"],
        "fronts identical": True,
    }


def _plot(rows: list[dict[str, Any]]) -> Any:
    figure = style.new_figure(2.2 + 0.4 * len(rows))
    axes = figure.add_subplot()
    place = np.arange(len(rows))
    bars = (("ours ms", palette.VERMILION), ("BOA* ms", palette.BLUE), ("NAMOA*dr ms", palette.SKY))
    for shift, (column, color) in enumerate(bars):
        axes.barh(place + 0.26 * (shift - 1), [row[column] for row in rows], 0.24, color=color, label=column[:-3])
    for y, row in zip(place, rows, strict=True):
        axes.annotate(
            f" {row['BOA* ratio']:.1f} ×", (row["BOA* ms"], y), va="center", fontsize=style.SMALL_PT,
            fontfamily=style.FONT, color=palette.INK,
        )  # fmt: skip
    axes.set_yticks(place, [row["graph"] for row in rows])
    axes.invert_yaxis()
    axes.set_xscale("log")
    style.dress(axes, "time of the search, ms")
    style.title(axes, "All Pareto-optimal paths of a graph", "one core, identical fronts; the ratio is that of BOA*")
    style.legend(figure, "outside lower center", columns=3)
    return figure
