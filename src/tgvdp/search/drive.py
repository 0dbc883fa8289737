"""Drive a train by switching speeds: the forward pass of the front method.

A policy gives one switching speed a for every station: full traction below it, coasting above it, holding at it, and
braking as late as the envelope of feasible speeds allows. The run is exact within each cell: it reaches a where it
reaches it, and coasting ends where it meets the braking curve. Where it is on the envelope, and stays there, its rows
are those of the fastest run: most of the cells in which it gains or loses speed.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, part
from tgvdp.line.meeting import SLIVER, braked_w, drive_then_brake, drop_slivers
from tgvdp.physics.arc import OK, arc
from tgvdp.physics.forces import mean_effort, mean_resistance, resistance_at
from tgvdp.physics.motion import BRAKING, COASTING, TRACTION, land, march

#: Below this share of full traction a change of speed is spread over the cell: it is a drift of the holding speed.
_GENTLE_SHARE = 0.5
#: Relative distance in v² within which a run is on the braking curve.
_ON_CURVE = 1e-8
#: A search for a running time ends when its bracket of shares is smaller than this, or after so many runs.
_SAME_SHARE = 1e-9
_MOST_RUNS = 30

#: Whether a run that enters a cell on the envelope stays on it: never, if the switching speed is not below it, always.
_LEAVES = 0
_AIMS_THERE = 1
_BRAKES = 2


class Course(NamedTuple):
    """Cells with the envelope of feasible speeds, and the fastest run within each of them, for the kernel.

    Attributes
    ----------
    station_m : (K + 1,) float64
    length_m, grade_n, air, limit_w : (K,) float64
        As in `Cells`.
    low, fast : (K + 1,) float64
        Slowest and fastest feasible squared speed at each station, m²/s².
    x_m, w : (n,) float64
        Rows of the fastest run.
    row : (K + 1,) int64
        Its rows at the stations.
    stays : (K,) int64
        Whether a run on the envelope stays there.
    ride_s, ride_j : (K,) float64
        Running time and energy of the fastest run in each cell.
    """

    station_m: NDArray[np.float64]
    length_m: NDArray[np.float64]
    grade_n: NDArray[np.float64]
    air: NDArray[np.float64]
    limit_w: NDArray[np.float64]
    low: NDArray[np.float64]
    fast: NDArray[np.float64]
    x_m: NDArray[np.float64]
    w: NDArray[np.float64]
    row: NDArray[np.int64]
    stays: NDArray[np.int64]
    ride_s: NDArray[np.float64]
    ride_j: NDArray[np.float64]


@part
def _append(x, w, xs, ws, n):
    xs[n] = x
    ws[n] = w
    return n + 1


@part
def _coast(train, length, grade, air, w):
    """`land` under coasting, without its generality: the resistance is nearly linear in w1, three sweeps solve it."""
    v = math.sqrt(w)
    factor = 2.0 * length / train.inertia_kg
    slope = 0.5 * air
    if v > 0.0:
        slope += 0.25 * train.davis_b / v
    damping = 1.0 / (1.0 + factor * slope)
    x = max(w - factor * damping * (resistance_at(train, air, v) + grade), 0.0)
    if train.davis_b > 0.0:
        for _ in range(2):
            load = mean_resistance(train, air, v, math.sqrt(x)) + grade
            x = max(x + damping * (w - factor * load - x), 0.0)
    gain = 0.5 * (x - w) / length
    if gain > train.max_acceleration or -gain > train.max_deceleration:
        return land(train, COASTING, 1.0, length, grade, air, w)
    return x


@part
def _brake_late(train, start, rest, end, grade, air, limit, w, top, bx, bw, xs, ws, n):
    """Coast from w and brake as late as possible to end at ``top``, where coasting alone would end above it."""
    braked = braked_w(train, grade, air, top, limit, rest, bx, bw)
    if w > braked * (1.0 + _ON_CURVE):
        first = n
        n = march(train, BRAKING, 1.0, rest, grade, air, w, top, xs, ws, n)[2]
        for i in range(first, n):
            xs[i] += start
        xs[n - 1] = end
        return n
    return drive_then_brake(train, COASTING, start, end, rest, grade, air, limit, w, top, bx, bw, xs, ws, n)


@part
def _drive_cell(train, start, end, length, grade, air, limit, w, a, top, bx, bw, xs, ws, n):
    """Append the rows of one cell, from w, with the switching speed a and the envelope ``top`` at its end."""
    rest = length
    if w < a * (1.0 - _ON_CURVE):
        status, _, work = arc(train, rest, grade, air, w, a)
        gentle = _GENTLE_SHARE * rest * mean_effort(train.traction, math.sqrt(w), math.sqrt(a))
        if work >= 0.0 and (status != OK or work > gentle):
            first = n
            used, w, n = march(train, TRACTION, 1.0, rest, grade, air, w, a, xs, ws, n)
            for i in range(first, n):
                xs[i] += start
            rest -= used
            if rest <= 1e-12 * length:
                xs[n - 1] = end
                return n
    status, _, work = arc(train, rest, grade, air, w, a)
    if work < 0.0:
        landed = _coast(train, rest, grade, air, w)
        if landed <= top:
            return _append(end, landed, xs, ws, n)
        return _brake_late(train, end - rest, rest, end, grade, air, limit, w, top, bx, bw, xs, ws, n)
    if status == OK:
        return _append(end, a, xs, ws, n)
    first = n
    n = march(train, TRACTION, 1.0, rest, grade, air, w, math.inf, xs, ws, n)[2]
    for i in range(first, n):
        xs[i] += end - rest
    xs[n - 1] = end
    return n


@kernel
def find_rides(train, course):
    """Fill in ``stays``, ``ride_s`` and ``ride_j`` of a course."""
    for k in range(course.length_m.shape[0]):
        grade = course.grade_n[k]
        air = course.air[k]
        time = 0.0
        energy = 0.0
        driven = True
        braked = True
        rises = True
        falls = True
        for i in range(course.row[k], course.row[k + 1]):
            w0 = course.w[i]
            w1 = course.w[i + 1]
            _, duration, work = arc(train, course.x_m[i + 1] - course.x_m[i], grade, air, w0, w1)
            time += duration
            energy += max(work, 0.0)
            driven &= work >= 0.0
            braked &= work <= 0.0
            rises &= w1 >= w0
            falls &= w1 <= w0
        course.ride_s[k] = time
        course.ride_j[k] = energy
        course.stays[k] = _LEAVES
        if driven and (rises or falls):
            course.stays[k] = _AIMS_THERE
        if braked and falls and _coast(train, course.length_m[k], grade, air, course.fast[k]) > course.fast[k + 1]:
            course.stays[k] = _BRAKES


@part
def _run(train, course, switch_a, switch_b, share, xs, ws, bx, bw):
    """Rows, time and energy of one run by a blend of two policies; −1 rows when the buffers are too small."""
    xs[0] = 0.0
    n = 1
    time = 0.0
    energy = 0.0
    for k in range(course.length_m.shape[0]):
        if n + 2048 > xs.shape[0]:
            return -1, time, energy
        w = ws[n - 1]
        top = course.fast[k + 1]
        bottom = course.low[k + 1]
        a = switch_a[k + 1] + share * (switch_b[k + 1] - switch_a[k + 1])
        if w == course.fast[k] and (course.stays[k] == _BRAKES or (course.stays[k] == _AIMS_THERE and a >= top)):
            for i in range(course.row[k] + 1, course.row[k + 1] + 1):
                xs[n] = course.x_m[i]
                ws[n] = course.w[i]
                n += 1
            time += course.ride_s[k]
            energy += course.ride_j[k]
            continue
        a = max(min(a, top), bottom)
        grade = course.grade_n[k]
        air = course.air[k]
        first = n
        n = _drive_cell(
            train, course.station_m[k], course.station_m[k + 1], course.length_m[k], grade, air, course.limit_w[k],
            w, a, top, bx, bw, xs, ws, n,
        )  # fmt: skip
        if n > first + 1:
            n = drop_slivers(xs, ws, first, n, SLIVER * course.length_m[k])
        ws[n - 1] = max(min(ws[n - 1], top), bottom)
        for i in range(first, n):
            _, duration, work = arc(train, xs[i] - xs[i - 1], grade, air, ws[i - 1], ws[i])
            time += duration
            energy += max(work, 0.0)
    return n, time, energy


@kernel
def drive(train, course, start_w, switch_a, switch_b, share, target_s, tolerance_s, lo, lo_s, hi, hi_s, xs, ws, bx, bw):
    """Drive the whole trip by a blend of two policies, again and again until it takes a given time (Illinois rule).

    Parameters
    ----------
    train : KernelTrain
    course : Course
    start_w : float
        Squared speed at the origin.
    switch_a, switch_b : (K + 1,) float64
        Two policies: squared switching speeds for the station at the end of each cell.
    share : float
        Weight of the second policy in the first run.
    target_s, tolerance_s : float
        Running time that is wanted, and how well.
    lo, lo_s, hi, hi_s : float
        Two shares and their running times. Unless these are below and above the target, there is one run only.
    xs, ws : (size,) float64, modified in place
        Rows of the run: positions from the origin, squared speeds.
    bx, bw : (size,) float64
        Scratch.

    Returns
    -------
    n : int
        Number of rows; −1 when the buffers are too small.
    time_s, energy_j : float
        Running time and traction energy.
    share, lo, hi : float
        Share of the run, and the bracket that is left.
    runs : int
        Number of runs.
    """
    ws[0] = start_w
    f_lo = lo_s - target_s
    f_hi = hi_s - target_s
    bracketed = f_lo < 0.0 < f_hi
    runs = 0
    side = 0
    while True:
        n, time, energy = _run(train, course, switch_a, switch_b, share, xs, ws, bx, bw)
        runs += 1
        f = time - target_s
        if n < 0 or not bracketed or abs(f) <= tolerance_s or hi - lo < _SAME_SHARE or runs >= _MOST_RUNS:
            return n, time, energy, share, lo, hi, runs
        if f < 0.0:
            lo = share
            f_lo = f
            if side == -1:
                f_hi *= 0.5
            side = -1
        else:
            hi = share
            f_hi = f
            if side == 1:
                f_lo *= 0.5
            side = 1
        share = (lo * f_hi - hi * f_lo) / (f_hi - f_lo)
