"""Small cases in which everything can be tried: all paths of a grid, all schedules of an instance."""

import warnings
from collections.abc import Iterator

import numpy as np

from tgvdp.formats import load_train
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.instances import find, index
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.grid.best_first import best_first
from tgvdp.methods.grid.exact import exact_front
from tgvdp.methods.grid.grid import Grid, build_grid
from tgvdp.methods.grid.layered import LayeredGraph
from tgvdp.methods.grid.paths import GridPaths
from tgvdp.model.track import Gradient, SpeedLimit, Track
from tgvdp.model.trip import Trip
from tgvdp.solvers.registry import SOLVERS, solve
from tgvdp.verification.case import Case, equal

PART = "exhaustive small cases"
#: Steps of the instances that are enumerated, at most.
_MOST_STEPS = 6
_FAR_S = 1e6

Points = list[tuple[float, float]]


def cases() -> Iterator[Case]:
    """Grids, then instances of the formulations."""
    for name, gradients in {
        "level": (Gradient(0.0, 0.0),),
        "hill": (Gradient(0.0, 8.0), Gradient(900.0, -12.0)),
    }.items():
        grid = _grid(gradients)
        every = _front(_all_paths(grid.graph))
        budget = SearchBudget()
        methods = {"exact": exact_front(grid, _FAR_S, budget), "best-first": best_first(grid, _FAR_S, budget, "energy")}
        for method, found in methods.items():
            yield equal(PART, f"grid {name}, {method}: Pareto-optimal paths", len(found), len(every), 15.0)
            yield equal(PART, f"grid {name}, {method}: times and energies", _apart(found, grid, every), 0.0, 12.0, 1.0)
    yield from _instances()


def _instances() -> Iterator[Case]:
    """Enumeration and dynamic programming against the certified optima of all small instances that they take."""
    rows = {name: row for name, row in index().items() if int(row["N"]) <= _MOST_STEPS}
    for solver in ("brute", "dp"):
        worst = 0.0
        for name, row in rows.items():
            if row["kind"] not in SOLVERS[solver].kinds:
                continue
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", FormulationWarning)  # some are degenerate on purpose
                found = solve(read_instance(find(name)), solver).objective
            best = float(row["objective"])
            worst = max(worst, abs(found - best) / (abs(best) or 1.0))
        yield equal(
            PART, f"instances of {_MOST_STEPS} steps or fewer, {solver}: largest error of optima", worst, 0.0, 12.0
        )


def _grid(gradients: tuple[Gradient, ...]) -> Grid:
    """Some thousand paths."""
    track = Track(length_m=2e3, speed_limits=(SpeedLimit(0.0, 25.0),), gradients=gradients)
    trip = Trip(train=load_train("alstom-emu"), track=track, origin_m=0.0, destination_m=track.length_m)
    return build_grid(trip, 500.0, 10)


def _all_paths(graph: LayeredGraph) -> Points:
    """Time and energy of every path from the first to the last node; energies without what all paths need."""
    paths: Points = []
    ahead = [(0, 0.0, 0.0)]
    while ahead:
        node, seconds, joules = ahead.pop()
        if node == graph.n_nodes - 1:
            paths.append((seconds, joules))
        for arc in range(int(graph.arc_ptr[node]), int(graph.arc_ptr[node + 1])):
            ahead.append((int(graph.arc_to[arc]), seconds + graph.duration_s[arc], joules + graph.energy_j[arc]))
    return paths


def _front(points: Points) -> Points:
    front: Points = []
    for seconds, joules in sorted(points):
        if not front or joules < front[-1][1]:
            front.append((seconds, joules))
    return front


def _apart(found: GridPaths, grid: Grid, every: Points) -> float:
    """Largest relative difference of times and energies; 1 where the numbers of points differ."""
    if len(found) != len(every):
        return 1.0
    seconds, joules = np.array(every).T
    joules = joules + float(grid.floor_j.sum())
    return float(max(np.abs(found.duration_s / seconds - 1.0).max(), np.abs(found.energy_j / joules - 1.0).max()))
