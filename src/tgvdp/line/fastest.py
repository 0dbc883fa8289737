"""The fastest run: the reference with zero delay, exact up to the rows of `physics.motion`.

In a uniform cell the fastest run is the lower envelope of three curves: full traction from the speed at its start,
the speed limit, and full braking backwards from the largest speed at its end. A backward sweep finds that largest
speed (`cap`) at every station, a forward sweep drives; the point where traction or holding meets braking is solved
for inside the cell, so that no mesh is needed (Howlett & Pudney, Energy-Efficient Train Control, 1995, ch. 2).
"""

import numpy as np

from tgvdp._jit import kernel
from tgvdp.constants import FEASIBILITY_RTOL
from tgvdp.errors import InfeasibleError
from tgvdp.line.cells import Cells, cells_of
from tgvdp.line.meeting import SLIVER, braked_w, driven_w, drop_slivers, emit_braked, emit_driven, meeting_point
from tgvdp.model.trip import Trip
from tgvdp.physics.forces import KernelTrain, kernel_train
from tgvdp.physics.motion import BRAKING, TRACTION, march, net_force
from tgvdp.physics.profile import Profile, profile_of
from tgvdp.units import mps_to_kmh

DONE = 0
FULL = 1  # the row buffers are too small
NO_BRAKE = 2  # no speed at this station lets the train obey what comes after
TOO_FAST = 3  # the start speed is too high for what comes after
STALLED = 4  # full traction does not carry the train over this cell
TOO_SLOW = 5  # the end speed cannot be reached


@kernel
def caps_kernel(train, length, grade, air, limit, end_w, cap):
    """Largest squared speed at each station that still obeys all that follows; ``cap`` (K + 1,) in place."""
    count = length.shape[0]
    xs = np.empty(4096)
    ws = np.empty(4096)
    cap[count] = end_w
    for k in range(count - 1, -1, -1):
        if cap[k + 1] > limit[k]:
            cap[k + 1] = limit[k]
        w = braked_w(train, grade[k], air[k], cap[k + 1], limit[k], length[k], xs, ws)
        cap[k] = w
        if w <= 0.0:
            return NO_BRAKE, k
    return DONE, 0


@kernel
def fastest_kernel(train, station, length, grade, air, limit, start_w, cap, fast, xs, ws):
    """Drive the fastest run; ``fast`` (K + 1,) and the rows ``xs``, ``ws`` in place; returns status, cell, rows."""
    count = length.shape[0]
    bx = np.empty(4096)
    bw = np.empty(4096)
    fast[0] = start_w
    xs[0] = 0.0
    ws[0] = start_w
    n = 1
    for k in range(count):
        if n + 8192 > xs.shape[0]:
            return FULL, k, n
        d = length[k]
        w0 = fast[k]
        w1 = cap[k + 1]
        landed = driven_w(train, TRACTION, grade[k], air[k], w0, limit[k], d, bx, bw)
        x = d
        if landed > w1 or (
            landed >= limit[k] and net_force(train, BRAKING, grade[k], air[k], np.sqrt(w1), np.sqrt(w1)) > 0.0
        ):
            x = meeting_point(train, TRACTION, d, grade[k], air[k], limit[k], w0, w1, bx, bw)
            landed = w1
        elif landed <= 0.0:
            return STALLED, k, n
        fast[k + 1] = landed
        first = n
        n = emit_driven(train, TRACTION, station[k], x, grade[k], air[k], w0, limit[k], xs, ws, n)
        if x < d:
            n = emit_braked(train, station[k + 1], d - x, grade[k], air[k], w1, limit[k], bx, bw, xs, ws, n)
        else:
            ws[n - 1] = landed
        xs[n - 1] = station[k + 1]
        n = drop_slivers(xs, ws, first, n, SLIVER * d)
    return DONE, 0, n


@kernel
def slowest_kernel(train, length, grade, air, fast, end_w, low):
    """Slowest squared speed at each station from which full traction still reaches the end; ``low`` in place."""
    count = length.shape[0]
    xs = np.empty(4096)
    ws = np.empty(4096)
    low[count] = end_w
    for k in range(count - 1, -1, -1):
        w = march(train, TRACTION, -1.0, length[k], grade[k], air[k], low[k + 1], 0.0, xs, ws, 0)[1]
        low[k] = min(w, fast[k])


def _explain(status: int, at_m: float, trip: Trip) -> InfeasibleError:
    where = f"at {trip.origin_m + at_m:.6g} m"
    if status == NO_BRAKE:
        name = trip.train.name
        return InfeasibleError(f"the brakes of train {name} cannot hold it {where}: the descent outruns them")
    if status == TOO_FAST:
        return InfeasibleError(
            f"start speed {mps_to_kmh(trip.start_speed_mps):.4g} km/h is too high {where}: "
            f"the limits that follow allow {mps_to_kmh(at_m):.4g} km/h"
        )
    return InfeasibleError(f"train {trip.train.name} stalls {where}: full traction does not carry it over the climb")


def envelope_of(trip: Trip, cells: Cells, train: KernelTrain) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Fastest run over given cells.

    Parameters
    ----------
    trip : Trip
    cells : Cells
    train : KernelTrain

    Returns
    -------
    cap : (K + 1,) float64
        Largest squared speed at each station from which all that follows can be obeyed, m²/s².
    fast : (K + 1,) float64
        Squared speed of the fastest run at each station.
    x_m, w : (n,) float64
        Rows of the fastest run: positions from the origin and squared speeds.

    Raises
    ------
    InfeasibleError
        When the train stalls, cannot brake, or cannot meet its start or end speed.
    """
    count = len(cells.length_m)
    top_w = _finite_limit(trip, cells)
    limit_w = np.minimum(cells.limit_w, top_w)
    for speed_mps, cell, label in ((trip.start_speed_mps, 0, "start"), (trip.end_speed_mps, -1, "end")):
        if speed_mps**2 > limit_w[cell] * (1.0 + FEASIBILITY_RTOL):
            raise InfeasibleError(
                f"{label} speed {mps_to_kmh(speed_mps):.4g} km/h is above the limit there, "
                f"{mps_to_kmh(float(np.sqrt(limit_w[cell]))):.4g} km/h"
            )
    cap = np.empty(count + 1)
    fast = np.empty(count + 1)
    arrays = (cells.length_m, cells.grade_n, cells.air, limit_w)
    status, cell = caps_kernel(train, *arrays, trip.end_speed_mps**2, cap)
    if status != DONE:
        raise _explain(status, cells.station_m[cell], trip)
    start_w = trip.start_speed_mps**2
    if start_w > cap[0] * (1.0 + FEASIBILITY_RTOL):
        raise InfeasibleError(
            f"start speed {mps_to_kmh(trip.start_speed_mps):.4g} km/h is too high: "
            f"what follows allows {mps_to_kmh(float(np.sqrt(cap[0]))):.4g} km/h at most"
        )
    size = 16 * count + 16384
    while True:
        xs, ws = np.empty(size), np.empty(size)
        status, cell, n = fastest_kernel(train, cells.station_m, *arrays, min(start_w, cap[0]), cap, fast, xs, ws)
        if status != FULL:
            break
        size *= 2
    if status != DONE:
        raise _explain(status, cells.station_m[cell], trip)
    if fast[-1] < trip.end_speed_mps**2 * (1.0 - FEASIBILITY_RTOL):
        raise InfeasibleError(
            f"end speed {mps_to_kmh(trip.end_speed_mps):.4g} km/h cannot be reached: "
            f"full traction gives {mps_to_kmh(float(np.sqrt(fast[-1]))):.4g} km/h"
        )
    return cap, fast, xs[:n], ws[:n]


def _finite_limit(trip: Trip, cells: Cells) -> float:
    """Squared speed that no run can pass where there is no limit: what full effort gives over the whole trip."""
    finite = cells.limit_w[np.isfinite(cells.limit_w)]
    if len(finite) == len(cells.limit_w):
        return float(finite.max())
    strongest_n = max(piece.effort_n(piece.from_mps) for piece in trip.train.traction.pieces)
    pull_n = strongest_n + max(0.0, -float(cells.grade_n.min()))
    return trip.start_speed_mps**2 + 2.0 * pull_n * trip.distance_m / trip.train.inertia_kg


def fastest_run(trip: Trip) -> Profile:
    """Profile of the fastest run of a trip.

    Raises
    ------
    InfeasibleError
        When no run obeys all limits.
    """
    train = kernel_train(trip.train)
    _, _, x_m, w = envelope_of(trip, cells_of(trip), train)
    return profile_of(trip, x_m, w)
