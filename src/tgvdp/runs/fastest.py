"""The fastest run: the reference with zero delay, exact up to the rows of `physics.motion`.

In a uniform cell the fastest run is the lower envelope of three curves: full traction from the speed at its start,
the speed limit, and full braking backwards from the largest speed at its end. A backward sweep finds that largest
speed (`cap`) at every station, a forward sweep drives; the point where traction or holding meets braking is solved
for inside the cell, so that no mesh is needed (Howlett & Pudney, Energy-Efficient Train Control, 1995, ch. 2).
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import entry, part
from tgvdp.constants import FEASIBILITY_RTOL
from tgvdp.errors import InfeasibleError, NumericalError
from tgvdp.line.cells import Cells, cells_of
from tgvdp.line.resolved import resolve
from tgvdp.model.track import POWERED
from tgvdp.model.trip import Trip
from tgvdp.physics.cell import MOST_ROWS, cell_at, overrun, room_for_marches, room_for_rows
from tgvdp.physics.codes import BRAKING, NO_BRAKE, NO_ROOM, OK, STALLED, TOO_FAST, TRACTION
from tgvdp.physics.forces import KernelTrain, kernel_train, read_only, unpowered
from tgvdp.physics.march import march
from tgvdp.physics.motion import net_force_at
from tgvdp.runs.batch import Batch
from tgvdp.runs.bends import are_cut, cut_at_bends
from tgvdp.runs.braking_point import braked_w, drive_then_brake, driven_w, drop_slivers, emit_driven
from tgvdp.runs.profile import Profile, profile_of
from tgvdp.runs.resistance_correction import follow
from tgvdp.units import mps_to_kmh

#: Rows of the fastest run itself, per usual one. Near it the least energy falls with the square root of the time that
#: is spent: 1e-5 of the running time is worth 0.5 % of the energy, so that it must be right to 1e-7.
_FINE_ROWS = 10.0
#: Rows of one march for which there is room at first, ten times what is usual: for more the system may be asked anew
#: in each search, and handing over its pages takes longer than the run.
_SCRATCH = 2048
#: Largest acceleration by the starting effort. Rows of a train that takes off like a bullet are so short next to its
#: balancing speed that a run has millions, and that rounding fails the replay; a real one has some m/s².
_MOST_MPS2 = 1e5
#: How much more room there is for a run that found none; it is driven anew from its start.
_GROWTH = 8
#: Share of the traction effort that the slowest run keeps in hand, so that rounding and rows of other lengths do not
#: stall it. Of the effort, not of the speed in each cell: it adds up to the same over a stretch, whatever the cells.
_SPARE = 1e-3


@part
def _find_caps(train, dark, cells, end_w, cap, scratch):
    """Largest squared speed at each station that still obeys all that follows; ``cap`` (K + 1,) in place.

    It has what is not exceeded at the stations themselves.
    """
    count = cells.length_m.shape[0]
    cap[count] = end_w
    for k in range(count - 1, -1, -1):
        cell = cell_at(cells, k)
        if cap[k + 1] > cell.limit_w:
            cap[k + 1] = cell.limit_w
        here = train if cells.supply[k] == POWERED else dark
        cap[k] = min(cap[k], braked_w(here, BRAKING, cell, cap[k + 1], cell.length_m, scratch))
        if cap[k] <= 0.0:
            return NO_BRAKE, k
    return OK, 0


@part
def _drive_fastest(train, dark, cells, start_w, cap, fast, scratch, rows):
    """Drive the fastest run; ``fast`` (K + 1,) and the rows in place; returns status, cell, rows."""
    fast[0] = start_w
    rows.x[0] = 0.0
    rows.w[0] = start_w
    n = 1
    for k in range(cells.length_m.shape[0]):
        cell = cell_at(cells, k)
        w0 = fast[k]
        w1 = cap[k + 1]
        first = n
        here = train if cells.supply[k] == POWERED else dark
        landed = driven_w(here, TRACTION, cell, w0, cell.length_m, scratch)
        if landed > w1 or (landed >= cell.limit_w and net_force_at(here, BRAKING, cell, np.sqrt(w1)) > 0.0):
            landed = w1
            n = drive_then_brake(here, TRACTION, BRAKING, cell, w0, w1, scratch, rows, n)
        elif landed <= 0.0:
            return STALLED, k, n
        else:
            n = emit_driven(here, TRACTION, cell, cell.length_m, w0, rows, n)
            if n > 0:
                rows.w[n - 1] = landed
                rows.x[n - 1] = cell.end_m
        if n < 0:
            return NO_ROOM, k, n
        fast[k + 1] = landed
        n = drop_slivers(rows, first, n, cell.length_m)
    return OK, 0, n


@part
def _find_slowest(weaker, dark, cells, fast, end_w, low, scratch):
    """Slowest squared speed at each station from which a slightly weaker train reaches the end; ``low`` in place."""
    count = cells.length_m.shape[0]
    low[count] = end_w
    for k in range(count - 1, -1, -1):
        here = weaker if cells.supply[k] == POWERED else dark
        w = march(here, TRACTION, -1.0, cell_at(cells, k), cells.length_m[k], low[k + 1], 0.0, scratch, 0)[1]
        low[k] = min(w, fast[k])


@entry
def envelope_kernel(train, weaker, cells, start_w, end_w, cap, low, fast, scratch, rows):
    """Caps, fastest run and slowest speeds; the arrays of `Envelope` in place; returns status, cell, rows.

    ``scratch`` is `room_for_marches`.
    """
    dark = unpowered(train)
    status, cell = _find_caps(train, dark, cells, end_w, cap, scratch)
    if status != OK:
        return status, cell, 0
    if start_w > cap[0] * (1.0 + FEASIBILITY_RTOL):
        return TOO_FAST, 0, 0
    status, cell, n = _drive_fastest(train, dark, cells, min(start_w, cap[0]), cap, fast, scratch, rows)
    if status == OK:
        _find_slowest(weaker, dark, cells, fast, end_w, low, scratch)
    return status, cell, n


def _explain(status: int, trip: Trip, cells: Cells, cell: int, cap_w: float) -> InfeasibleError:
    where = f"at {trip.origin_m + float(cells.station_m[cell]):.6g} m"
    if status == NO_BRAKE:
        train = trip.train
        if not (train.friction_brake_n or train.braking_rates or train.braking.effort_n(0.0)):
            return InfeasibleError(f"train {train.name} has no brakes: it cannot keep its speed down {where}")
        return InfeasibleError(f"the brakes of train {train.name} cannot hold it {where}: the descent outruns them")
    if status == TOO_FAST:
        return InfeasibleError(
            f"start speed {mps_to_kmh(trip.start_speed_mps):.4g} km/h is too high: "
            f"what follows allows {mps_to_kmh(float(np.sqrt(cap_w))):.4g} km/h at most"
        )
    if cells.supply[cell] != POWERED:
        return InfeasibleError(f"train {trip.train.name} stalls {where}: it cannot coast through the neutral section")
    return InfeasibleError(f"train {trip.train.name} stalls {where}: full traction does not carry it over the climb")


class Envelope(NamedTuple):
    """Feasible speeds of a trip over given cells, float64.

    Attributes
    ----------
    low, fast : (K + 1,)
        Squared speeds at the stations of the slowest run that can still reach the end, and of the fastest, m²/s².
    x_m, w : (n,)
        Rows of the fastest run: positions from the origin and squared speeds.
    """

    low: NDArray[np.float64]
    fast: NDArray[np.float64]
    x_m: NDArray[np.float64]
    w: NDArray[np.float64]


def envelope_of(trip: Trip, cells: Cells, train: KernelTrain, passing: Sequence[tuple[float, float]] = ()) -> Envelope:
    """Fastest run and slowest feasible speeds over given cells.

    Parameters
    ----------
    trip : Trip
    cells : Cells
    train : KernelTrain
    passing : sequence of (float, float)
        Stations, from the origin, m, and speeds that are not exceeded there, m/s.

    Returns
    -------
    Envelope

    Raises
    ------
    InfeasibleError
        When the train stalls, cannot brake, or cannot meet its start or end speed.
    NumericalError
        When a run takes too many rows.
    """
    count = len(cells.length_m)
    for speed_mps, cell, label in ((trip.start_speed_mps, 0, "start"), (trip.end_speed_mps, -1, "end")):
        if speed_mps**2 > cells.limit_w[cell] * (1.0 + FEASIBILITY_RTOL):
            raise InfeasibleError(
                f"{label} speed {mps_to_kmh(speed_mps):.4g} km/h is above the limit there, "
                f"{mps_to_kmh(float(np.sqrt(cells.limit_w[cell]))):.4g} km/h"
            )
    low, fast = np.empty((2, count + 1))
    highest_w = np.full(count + 1, np.inf)
    for at_m, speed_mps in passing:
        highest_w[np.searchsorted(cells.station_m, at_m)] = speed_mps**2
    start_w, end_w = trip.start_speed_mps**2, trip.end_speed_mps**2
    weaker = train._replace(traction=weakened(train.traction, 1.0 - _SPARE))
    reachable = within_reach(trip, cells)
    size = min(16 * count + 2 * _SCRATCH, MOST_ROWS)
    march_size = _SCRATCH
    while True:
        rows, march = room_for_rows(size, "fastest run"), room_for_marches(march_size, "fastest run: march")
        cap = highest_w.copy()
        status, cell, n = envelope_kernel(train, weaker, reachable, start_w, end_w, cap, low, fast, march, rows)
        if overrun(march):
            march_size *= 2
        elif status == NO_ROOM:
            size = max(size + 1, min(_GROWTH * size, MOST_ROWS))
        else:
            break
    if status != OK:
        raise _explain(status, trip, cells, cell, cap[cell])
    if fast[-1] < end_w * (1.0 - FEASIBILITY_RTOL):
        raise InfeasibleError(
            f"end speed {mps_to_kmh(trip.end_speed_mps):.4g} km/h cannot be reached: "
            f"full traction gives {mps_to_kmh(float(np.sqrt(fast[-1]))):.4g} km/h"
        )
    return Envelope(low, fast, rows.x[:n].copy(), rows.w[:n].copy())


def weakened(table: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """Table of an effort curve, (n, 6), with all efforts multiplied by a share."""
    table = table.copy()
    table[:, 1:] *= share
    return read_only(table)


def within_reach(trip: Trip, cells: Cells) -> Cells:
    """Cells whose limits are no higher than `reachable_w`."""
    most_w = reachable_w(trip)
    return cells if math.isinf(most_w) else cells._replace(limit_w=np.minimum(cells.limit_w, most_w))


@lru_cache(maxsize=16)
def reachable_w(trip: Trip) -> float:
    """Squared speed that no run passes: what the largest effort below it gives over the whole distance, m²/s².

    Infinite when that is above all limits.
    """
    line = resolve(trip)
    highest_w = float(line.limit_mps.max()) ** 2
    pull_n = max(0.0, -float(line.grade_n.min()))
    per_newton = 2.0 * trip.distance_m / trip.train.inertia_kg
    w = trip.start_speed_mps**2 + per_newton * (trip.train.traction_limit.effort_n(0.0) + pull_n)
    while w < highest_w:
        effort_n = trip.train.traction_limit.largest_n(math.sqrt(w)) + pull_n
        if trip.start_speed_mps**2 + per_newton * effort_n <= w:
            return w * (1.0 + FEASIBILITY_RTOL)
        w *= 2.0
    return math.inf


def fastest_run(trip: Trip, passing: Sequence[tuple[float, float]] = ()) -> Profile:
    """Profile of the fastest run of a trip.

    Parameters
    ----------
    trip : Trip
    passing : sequence of (float, float)
        Positions on the track, m, that become rows of it, and speeds that are not exceeded there, m/s.

    Raises
    ------
    InfeasibleError
        When no run obeys all limits.
    NumericalError
        When the train is too light for its effort, or the run takes too many rows.
    """
    start_mps2 = trip.train.traction_limit.effort_n(0.0) / trip.train.inertia_kg
    if start_mps2 > _MOST_MPS2:
        raise NumericalError(f"it starts with {start_mps2:.3g} m/s², at most {_MOST_MPS2:g} can be computed")
    train = kernel_train(trip.train)._replace(rows=_FINE_ROWS)
    along = [(at_m - trip.origin_m, speed_mps) for at_m, speed_mps in passing]
    cells = cells_of(trip, np.array([at_m for at_m, _ in along]) if along else None)
    envelope = envelope_of(trip, cells, train, along)
    line = resolve(trip)
    rows = follow(trip.train, line, envelope.x_m, envelope.w)
    profile = profile_of(trip, *rows)
    if not are_cut(line, profile.time_s[-1:]):
        return profile
    runs = Batch.of([rows])
    cut, _ = cut_at_bends(trip.train, line, runs)
    return profile if cut is runs else profile_of(trip, cut.x_m, cut.w)
