"""Rows of a run that suggests a costate, and the cells that they are cut into."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.certificate.cells import LOSS, Cut, count_cells, cut_rows, graded_step, join_rows, thin_rows
from tgvdp.certificate.regimes import row_efforts
from tgvdp.line.cells import Cells
from tgvdp.memory import ask_for
from tgvdp.model.trip import Trip
from tgvdp.physics.forces import KernelTrain

_Floats = NDArray[np.float64]

#: What all cells together may lose of the bound by their width, relative to the energy that is drawn.
_LOST = 1e-4
#: Energy that is drawn, at least, relative to the kinetic energy at the top speed.
_LEAST_DRAWN = 0.1
#: Cells of a bound per trip at least; and where speed is kept, for which costates are exact in cells of any length.
_CELLS_PER_TRIP, _STEADY_PER_TRIP = 150, 30
#: Rows of a run that are nearer to each other than this share of the trip, or to a break of the line, are one.
_SAME_PLACE = 1e-8
#: Squared speed inside a trip, relative to the top, below which a costate is not integrated.
_SLOWEST = 1e-8
#: Memory that a cell takes, B.
CELL_B = 500.0


class RunRows(NamedTuple):
    """Rows of a run from end to end of the trip, none across a break of the line.

    Attributes
    ----------
    x_m, w : (n + 1,) float64
        Their ends: positions from the origin, m, and squared speeds, m²/s².
    effort : (n,) float64
        Their mean efforts per unit of inertia, m/s².
    place : (n,) int64
        Cells of the line that they lie in.
    """

    x_m: _Floats
    w: _Floats
    effort: _Floats
    place: NDArray[np.int64]


def rows_of(trip: Trip, train: KernelTrain, cells: Cells, x_m: _Floats, w: _Floats) -> RunRows:
    """Rows of a run, between the breaks of the cells of a line, from its rows at ``x_m``, ``w``."""
    x_m, w = _with_breaks(trip, cells.station_m, x_m, w)
    place = np.searchsorted(cells.station_m, 0.5 * (x_m[:-1] + x_m[1:]), side="right") - 1
    effort = np.empty(len(place))
    row_efforts(train, x_m, w, cells.grade_n[place], cells.air[place], effort)
    return RunRows(x_m, w, effort / train.inertia_kg, place)


def cut_into_cells(
    rows: RunRows, distance_m: float, price_s: float
) -> tuple[RunRows, _Floats, _Floats, NDArray[np.int64]]:
    """Cells of a run.

    Parameters
    ----------
    rows : RunRows
        Written over.
    distance_m : float
        Length of the trip.
    price_s : float
        Seconds that are worth a joule of traction, per unit of inertia; fewer make finer cells.

    Returns
    -------
    rows : RunRows
        Rows that are joined where they need not be cells of their own.
    node_m, node_w : (K + 1,) float64
        Ends of the cells, and squared speeds there.
    row : (K,) int64
        Rows that they belong to.
    """
    x_m, w, effort, place = rows
    drawn = float(np.maximum(effort, 0.0) @ np.diff(x_m))
    budget_s = _LOST / LOSS * max(drawn, 0.5 * _LEAST_DRAWN * float(w.max())) * price_s
    step = graded_step(x_m, w, np.empty(len(place)), budget_s)
    cut = Cut(distance_m / _CELLS_PER_TRIP, distance_m / _STEADY_PER_TRIP, step)
    n = join_rows(x_m, w, effort, place, cut)
    joined = RunRows(x_m[: n + 1], w[: n + 1], effort[:n], place[:n])
    parts = np.empty(n, dtype=np.int64)
    count = count_cells(joined.x_m, joined.w, cut, parts)
    ask_for(CELL_B * count, f"a bound on {count:,} cells")
    node_m, node_w, row = np.empty(count + 1), np.empty(count + 1), np.empty(count, dtype=np.int64)
    cut_rows(joined.x_m, joined.w, parts, node_m, node_w, row)
    return joined, node_m, node_w, row


def _with_breaks(trip: Trip, breaks_m: _Floats, x_m: _Floats, w: _Floats) -> tuple[_Floats, _Floats]:
    """Rows from end to end of the trip with every break of the line among them."""
    gap_m = _SAME_PLACE * trip.distance_m
    near = np.searchsorted(x_m, breaks_m).clip(1, len(x_m) - 1)
    near -= np.abs(x_m[near - 1] - breaks_m) < np.abs(x_m[near] - breaks_m)
    found = np.abs(x_m[near] - breaks_m) <= gap_m
    rows_m = x_m.copy()
    rows_m[near[found]] = breaks_m[found]
    x_m = np.sort(np.concatenate((rows_m, breaks_m[~found])))
    w = np.interp(x_m, rows_m, w)
    w = np.maximum(w, _SLOWEST * w.max())
    w[0], w[-1] = trip.start_speed_mps**2, trip.end_speed_mps**2
    fixed = np.zeros(len(x_m), dtype=np.bool_)
    fixed[np.searchsorted(x_m, breaks_m)] = True
    count = thin_rows(x_m, w, fixed, gap_m)
    return x_m[:count], w[:count]
