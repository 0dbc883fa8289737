"""The explicit grid of a trip: stations × speeds, joined by arcs of constant acceleration.

Stations are the trip's ends, the breaks of the speed limit, points evenly between them, and some more next to a stop.
The speeds ("levels") are evenly spaced, plus those of the limits and of the trip's ends; standstill exists only at the
ends. An arc exists where `arcs.long_arc` finds a run that obeys all limits, and is kept where it lies on some path
from the root to the terminal. Searches see the grid as a `LayeredGraph`, in which a layer is a station.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tgvdp.constants import FEASIBILITY_RTOL
from tgvdp.errors import BudgetExceededError, InfeasibleError
from tgvdp.line.cells import Cells, cells_of
from tgvdp.line.resolved import resolve
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.methods.grid.arcs import long_arcs, path_rows
from tgvdp.methods.grid.layered import Incoming, LayeredGraph, layered_graph
from tgvdp.methods.grid.points import DEFAULT_SPEEDS, grid_levels, grid_stations
from tgvdp.model.trip import Trip
from tgvdp.physics.codes import (
    OK,
    OVER_ACCELERATION,
    OVER_BRAKE,
    OVER_DECELERATION,
    OVER_EFFORT_AT_POINT,
    OVER_LIMIT,
    OVER_TRACTION,
    STANDSTILL,
)
from tgvdp.physics.energy import energy_tables
from tgvdp.physics.forces import kernel_train
from tgvdp.runs.resistance_correction import follow

_CHUNK_ARCS = 20_000
#: The segment beside a standstill is cut at these shares, for there the speed changes most along a segment. Measured
#: on a main line of 30 km with 60 segments and speeds: 7 % instead of 12 % above the continuous optimum. Where the
#: speeds are too coarse for such short segments, the next choice is tried.
_END_CUTS = ((0.125, 0.25, 0.5), (0.5,), ())
_REASONS = {
    OVER_TRACTION: "traction effort",
    OVER_BRAKE: "braking effort",
    OVER_ACCELERATION: "acceleration",
    OVER_DECELERATION: "deceleration",
    STANDSTILL: "standstill",
    OVER_EFFORT_AT_POINT: "traction or braking effort",
    OVER_LIMIT: "speed limit",
}


@dataclass(frozen=True, eq=False)
class Grid:
    """The explicit grid of a trip, pruned to what lies on a path from root to terminal.

    Attributes
    ----------
    trip : Trip
    station_m : (n_stations,) float64
        Positions from the trip's origin, m.
    level_mps : (n_levels,) float64
        Speeds, increasing, m/s.
    graph : LayeredGraph
        Nodes of layer k are the speeds that are in use at station k.
    level : (n_nodes,) int32
        Speed index of each node.
    blocked : (n_nodes,) int32
        Arcs from each node that obey the speed limits at their ends and break some other constraint.
    floor_j : (n_stations - 1,) float64
        What the graph's energies are counted from in each segment: 0 where no arc returns energy, else the least
        energy of its arcs. Each path crosses each segment once, so that all differ from their own energy by the same.
    """

    trip: Trip
    station_m: NDArray[np.float64]
    level_mps: NDArray[np.float64]
    graph: LayeredGraph
    level: NDArray[np.int32]
    blocked: NDArray[np.int32]
    floor_j: NDArray[np.float64]

    @cached_property
    def incoming(self) -> Incoming:
        """Arcs sorted by the node where they end."""
        return self.graph.incoming()

    def nodes(self, levels: NDArray[np.integer]) -> NDArray[np.int64]:
        """Nodes of the path with these levels, (n_stations,) each."""
        layer_ptr = self.graph.layer_ptr
        layers = zip(layer_ptr[:-1], layer_ptr[1:], levels, strict=True)
        return np.array([first + np.searchsorted(self.level[first:end], level) for first, end, level in layers])

    def rows(self, levels: NDArray[np.integer]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Rows of the path with these levels, between which the acceleration is constant.

        Parameters
        ----------
        levels : (n_stations,) int
            Speed index at every station.

        Returns
        -------
        x_m, w : (n_rows,) float64
            Positions from the origin, m, and squared speeds, m²/s². All breaks of the line are rows; within a row
            the speed changes by 2 % at most, except close to standstill, and the effort does not change sign.
        """
        cells = cells_of(self.trip, self.station_m)
        train = kernel_train(self.trip.train)
        station_cell = np.searchsorted(cells.station_m, self.station_m)
        station_w = self.level_mps[levels] ** 2
        none = np.empty(0)
        count = path_rows(train, cells, station_cell, station_w, none, none)
        x_m, w = np.empty(count), np.empty(count)
        path_rows(train, cells, station_cell, station_w, x_m, w)
        return follow(self.trip.train, resolve(self.trip), x_m, w)


def build_grid(
    trip: Trip, segment_m: float | None = None, speeds: int | None = None, budget: SearchBudget | None = None
) -> Grid:
    """Build the grid of a trip.

    Parameters
    ----------
    trip : Trip
    segment_m : float, optional
        Largest distance between stations, m; default: a fortieth of the trip.
    speeds : int, optional
        Number of evenly spaced speeds up to the largest one of the fastest run; default 40.
    budget : SearchBudget, optional
        Its time limit holds while the grid is built.

    Raises
    ------
    InputError
        When ``segment_m`` or ``speeds`` is out of range.
    InfeasibleError
        When no run obeys all limits, or none on this grid; says where it ends.
    BudgetExceededError
        When the time limit passes first.
    """
    level_mps = grid_levels(trip, DEFAULT_SPEEDS if speeds is None else speeds)
    clock = (budget or SearchBudget(time_limit_s=math.inf)).start()
    dead_end = None
    for cuts in _END_CUTS:
        station_m = grid_stations(trip, segment_m, np.array(cuts))
        try:
            return _assemble(trip, station_m, level_mps, _arcs_by_segment(trip, station_m, level_mps, clock), clock)
        except InfeasibleError as error:
            dead_end = error
    assert dead_end is not None
    raise dead_end


def _allowed_levels(
    trip: Trip, station_m: NDArray[np.float64], cells: Cells, level_mps: NDArray[np.float64]
) -> list[NDArray[np.int64]]:
    """Levels that the limits on both sides of each station allow; at the trip's ends only its own speeds."""
    at = np.searchsorted(cells.station_m, station_m)
    limit_w = np.minimum(cells.limit_w[at[1:-1] - 1], cells.limit_w[at[1:-1]]) * (1.0 + FEASIBILITY_RTOL)
    start, end = np.searchsorted(level_mps, [trip.start_speed_mps, trip.end_speed_mps])
    inner = [np.flatnonzero((level_mps > 0.0) & (level_mps**2 <= most)) for most in limit_w]
    return [np.array([start]), *inner, np.array([end])]


@dataclass(frozen=True, eq=False)
class _Segment:
    """Feasible arcs of one segment, by speed index, and the number of infeasible ones from each start."""

    start: NDArray[np.int64]
    end: NDArray[np.int64]
    duration_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]
    blocked: NDArray[np.int64]


def _arcs_by_segment(
    trip: Trip,
    station_m: NDArray[np.float64],
    level_mps: NDArray[np.float64],
    clock: Clock,
) -> list[_Segment]:
    """Evaluate arcs forward, from reachable speeds only."""
    cells = cells_of(trip, station_m)
    allowed = _allowed_levels(trip, station_m, cells, level_mps)
    train = kernel_train(trip.train)
    tables = energy_tables(trip.train, trip.energy)
    station_cell = np.searchsorted(cells.station_m, station_m)
    level_w = level_mps**2
    reachable = allowed[0]
    segments = []
    for k, target in enumerate(allowed[1:]):
        shape = (len(reachable), len(target))
        status = np.empty(shape, dtype=np.int8)
        duration_s, energy_j = np.empty(shape), np.empty(shape)
        n_rows = max(1, _CHUNK_ARCS // max(1, len(target) * int(station_cell[k + 1] - station_cell[k])))
        for i in range(0, len(reachable), n_rows):
            part = slice(i, i + n_rows)
            long_arcs(
                train, tables, cells, station_cell[k], station_cell[k + 1], level_w[reachable[part]],
                level_w[target], status[part], duration_s[part], energy_j[part],
            )  # fmt: skip
            _look_at(clock, k, len(allowed) - 1)
        start, end = np.nonzero(status == OK)
        if not len(start):
            raise _dead_end(trip, station_m, k, status)
        blocked = np.zeros(len(level_mps), dtype=np.int64)
        blocked[reachable] = np.count_nonzero(status != OK, axis=1)
        segments.append(_Segment(reachable[start], target[end], duration_s[start, end], energy_j[start, end], blocked))
        reachable = np.unique(target[end])
    return segments


def _look_at(clock: Clock, station: int, last: int) -> None:
    if clock.expired:
        raise BudgetExceededError(
            f"grid: the time limit passed at station {station} of {last}; "
            "try fewer speeds, longer segments or more time"
        )


def _dead_end(trip: Trip, station_m: NDArray[np.float64], k: int, status: NDArray[np.int8]) -> InfeasibleError:
    reason = ""
    if status.size:
        codes, counts = np.unique(status, return_counts=True)
        reason = f"; most arcs break the limit of {_REASONS[int(codes[np.argmax(counts)])]}"
    return InfeasibleError(
        f"grid: no speed of station {k + 1} of {len(station_m) - 1}, at {trip.origin_m + station_m[k + 1]:g} m, can be "
        f"reached from the station before it, at {trip.origin_m + station_m[k]:g} m{reason}; "
        "try more speeds or longer segments"
    )


def _joined(parts: list[NDArray[Any]], dtype: type[np.generic]) -> NDArray[Any]:
    """Concatenation, a segment at a time: an interrupt need not wait for all."""
    whole = np.empty(sum(len(part) for part in parts), dtype=dtype)
    at = 0
    for part in parts:
        whole[at : at + len(part)] = part
        at += len(part)
    return whole


def _assemble(
    trip: Trip, station_m: NDArray[np.float64], level_mps: NDArray[np.float64], segments: list[_Segment], clock: Clock
) -> Grid:
    """Drop arcs that cannot reach the destination, and number the nodes."""
    kept: list[_Segment] = []
    useful = np.unique(segments[-1].end)
    last = len(segments)
    for segment in reversed(segments):
        _look_at(clock, last, last)
        keep = np.isin(segment.end, useful)
        useful = np.unique(segment.start[keep])
        kept.append(
            _Segment(
                segment.start[keep],
                segment.end[keep],
                segment.duration_s[keep],
                segment.energy_j[keep],
                segment.blocked,
            )
        )
    kept.reverse()
    layers = [np.unique(segment.start) for segment in kept] + [np.unique(kept[-1].end)]
    sizes = np.array([len(layer) for layer in layers])
    first = np.concatenate(([0], np.cumsum(sizes)))
    floor_j = np.array([min(0.0, float(segment.energy_j.min())) for segment in kept])
    places = [
        (first[k] + np.searchsorted(layers[k], one.start), first[k + 1] + np.searchsorted(layers[k + 1], one.end))
        for k, one in enumerate(kept)
    ]
    graph = layered_graph(
        sizes,
        _joined([start for start, _ in places], np.int32),
        _joined([end for _, end in places], np.int32),
        _joined([one.duration_s for one in kept], np.float64),
        _joined([one.energy_j - floor for one, floor in zip(kept, floor_j, strict=True)], np.float64),
    )
    blocked = [segment.blocked[layer] for segment, layer in zip(kept, layers[:-1], strict=True)]
    return Grid(
        trip,
        station_m,
        level_mps,
        graph,
        np.concatenate(layers).astype(np.int32),
        np.concatenate([*blocked, [0]]).astype(np.int32),
        floor_j,
    )
