"""What a search on a grid returns: paths with their costs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.methods.grid.grid import Grid
from tgvdp.methods.grid.layered import LayeredGraph
from tgvdp.methods.grid.node import LabelPool, Node
from tgvdp.model.checks import require_number


@dataclass(frozen=True, eq=False)
class GraphPaths:
    """Paths of a layered graph, sorted by time.

    Attributes
    ----------
    duration_s, energy_j : (n_paths,) float64
        Sums along each path, added from the root forward.
    nodes : (n_paths, n_layers) int32
        Nodes of each path.
    complete : bool
        False when a budget ended the search.
    counters : dict of str to int
        Work done, by kind.
    ended_by : str
        What ended a search that is not complete.
    """

    duration_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]
    nodes: NDArray[np.int32]
    complete: bool
    counters: dict[str, int]
    ended_by: str = ""


@dataclass(frozen=True, eq=False)
class GridPaths:
    """Paths of a grid, sorted by time.

    Attributes
    ----------
    grid : Grid
    duration_s, energy_j : (n_paths,) float64
        Running time, and energy by the trip's model.
    path_levels : (n_paths, n_stations) int16
        Speed index of each path at every station.
    complete : bool
        False when a budget ended the search.
    counters : dict of str to int
        Work done, by kind.
    ended_by : str
        What ended a search that is not complete.
    """

    grid: Grid
    duration_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]
    path_levels: NDArray[np.int16]
    complete: bool
    counters: dict[str, int]
    ended_by: str = ""

    def __len__(self) -> int:
        return len(self.duration_s)

    def rows(self, index: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Rows of one path: positions from the origin, m, and squared speeds, m²/s²; see `Grid.rows`."""
        return self.grid.rows(self.path_levels[index])

    def node(self, index: int) -> Node:
        """Terminal node of one path; its ancestors are the nodes of the path."""
        levels = self.path_levels[index]
        stations = np.arange(len(levels), dtype=np.int32)
        duration_s, energy_j = path_costs(self.grid.graph, self.grid.nodes(levels))
        energy_j[1:] += np.cumsum(self.grid.floor_j)
        pool = LabelPool(
            self.grid.station_m, self.grid.level_mps, stations, levels, duration_s, energy_j, stations - np.int32(1)
        )
        return pool.node(len(levels) - 1)


def path_costs(graph: LayeredGraph, nodes: NDArray[np.integer]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Time and energy at each node of one path, added from the root forward, (n_layers,) float64 each."""
    duration_s, energy_j = np.zeros(len(nodes)), np.zeros(len(nodes))
    for k in range(len(nodes) - 1):
        arcs = slice(graph.arc_ptr[nodes[k]], graph.arc_ptr[nodes[k] + 1])
        arc = arcs.start + int(np.searchsorted(graph.arc_to[arcs], nodes[k + 1]))
        duration_s[k + 1] = duration_s[k] + graph.duration_s[arc]
        energy_j[k + 1] = energy_j[k] + graph.energy_j[arc]
    return duration_s, energy_j


def grid_paths(grid: Grid, paths: GraphPaths) -> GridPaths:
    """Paths of a grid's graph as paths of the grid."""
    levels = grid.level[paths.nodes].astype(np.int16)
    energy_j = paths.energy_j + float(grid.floor_j.sum())
    return GridPaths(grid, paths.duration_s, energy_j, levels, paths.complete, paths.counters, paths.ended_by)


def require_limit(max_time_s: float) -> None:
    """Raise `InputError` unless a time limit is a finite number above 0."""
    require_number("search", "max_time_s", max_time_s, "s", above=0.0)


def too_slow(fastest_s: float, max_time_s: float) -> InfeasibleError:
    """The error for a time limit that no path keeps."""
    return InfeasibleError(
        f"grid: its fastest path takes {fastest_s:.6g} s, longer than the limit of {max_time_s:.6g} s; "
        "allow more delay, or use more speeds or shorter segments"
    )
