"""Drive a train by switching speeds: the forward pass of the front method.

A policy gives three switching speeds a, a' and b ≥ a for every station: full traction below the line of switching,
which ends at a, coasting above it (from the start of the cell on to a' or more), dynamic braking above b, holding at
either, and all brakes as late as the envelope of feasible speeds allows. Where braking returns no energy b is the
envelope. The run is exact within each cell: traction ends where it meets the line, and coasting where it meets the
braking curve. Where it is on the envelope, and stays there, its rows are those of the fastest run: most of the cells in
which it gains or loses speed.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part
from tgvdp.methods.costate.forward_cell import ON_CURVE, coast, drive_cell
from tgvdp.physics.arc import duration_and_work
from tgvdp.physics.energy import regenerated
from tgvdp.physics.forces import mean_effort, resistance_at
from tgvdp.physics.motion import DYNAMIC, land
from tgvdp.runs.braking_point import drop_slivers

#: Rows that one cell may take.
_MOST_ROWS = 2048
#: Whether a run that enters a cell on the envelope stays on it: never, if a is not below it, if b is not, always.
_LEAVES = 0
_AIMS_THERE = 1
_COASTS_THERE = 2
_BRAKES_THERE = 3
#: Rows of `Course.cells`.
STATION, LENGTH, GRADE, AIR, LIMIT, LOW, FAST = range(7)


class Course(NamedTuple):
    """Cells with the envelope of feasible speeds, and the fastest run within each of them, for the kernel.

    Few large arrays: each one costs a tenth of a microsecond per call.

    Attributes
    ----------
    cells : (7, K + 1) float64
        Stations in m, lengths in m, grade forces in N, drag in N/(m/s)² and squared limits of the K cells, as in
        `Cells`; slowest and fastest feasible squared speed at each station, m²/s².
    fastest : (2, n) float64
        Rows of the fastest run: positions and squared speeds.
    row : (K + 1,) int64
        Its rows at the stations.
    stays : (K,) int64
        Whether a run on the envelope stays there; negative until the course is first driven.
    """

    cells: NDArray[np.float64]
    fastest: NDArray[np.float64]
    row: NDArray[np.int64]
    stays: NDArray[np.int64]


@leaf
def _energy(train, drawn, returned, length, work, w0, w1):
    """Energy in J of an arc, from its work: drawn per joule of traction, returned per joule of the dynamic brake."""
    if work >= 0.0:
        return drawn * work
    if returned == 0.0:
        return 0.0
    return -returned * length * regenerated(train, -work / length, math.sqrt(w0), math.sqrt(w1))


@part
def find_rides(train, course):
    """Fill in ``stays`` of a course."""
    cells = course.cells
    x = course.fastest[0]
    w = course.fastest[1]
    for k in range(course.stays.shape[0]):
        grade = cells[GRADE, k]
        air = cells[AIR, k]
        driven = True
        braked = True
        rises = True
        falls = True
        for i in range(course.row[k], course.row[k + 1]):
            work = duration_and_work(train, x[i + 1] - x[i], grade, air, w[i], w[i + 1])[1]
            driven &= work >= 0.0
            braked &= work <= 0.0
            rises &= w[i + 1] >= w[i]
            falls &= w[i + 1] <= w[i]
        course.stays[k] = _LEAVES
        if driven and (rises or falls):
            course.stays[k] = _AIMS_THERE
        top = cells[FAST, k + 1]
        if braked and falls and coast(train, cells[LENGTH, k], grade, air, cells[FAST, k]) > top:
            course.stays[k] = _COASTS_THERE
            if land(train, DYNAMIC, 1.0, cells[LENGTH, k], grade, air, cells[FAST, k]) > top * (1.0 + ON_CURVE):
                course.stays[k] = _BRAKES_THERE


@leaf
def _rides(stays, a, b, top):
    """Whether a run on the envelope, of switching speeds a and b at the end of the cell, stays there."""
    return stays == _BRAKES_THERE or (stays == _AIMS_THERE and a >= top) or (stays == _COASTS_THERE and b >= top)


@leaf
def _holds(train, grade, air, w):
    """Whether traction alone holds a speed."""
    v = math.sqrt(w)
    load = resistance_at(train, air, v) + grade
    return 0.0 <= load <= mean_effort(train.traction, v, v)


@part
def drive_blend(train, drawn, returned, course, first_policy, second_policy, share, xs, ws, bx, bw):
    """Drive the whole trip by a blend of two policies, from the first row on, which is there.

    Parameters
    ----------
    train : KernelTrain
    drawn, returned : float
        Energy drawn per joule of traction work, and returned per joule of work of the dynamic brake.
    course : Course
    first_policy, second_policy : (K + 1, 3) float64
        As of `costate.switching_speeds`.
    share : float
        Weight of the second policy.
    xs, ws : (size,) float64, modified in place
        Rows of the run: positions from the origin, squared speeds.
    bx, bw : (size,) float64
        Scratch.

    Returns
    -------
    n : int
        Number of rows; −1 when the buffers are too small.
    time_s, energy_j : float
        Running time and energy, without auxiliaries.
    """
    cells = course.cells
    n = 1
    time = 0.0
    energy = 0.0
    for k in range(course.stays.shape[0]):
        if n + _MOST_ROWS > xs.shape[0]:
            return -1, time, energy
        w = ws[n - 1]
        top = cells[FAST, k + 1]
        bottom = cells[LOW, k + 1]
        a = first_policy[k + 1, 0] + share * (second_policy[k + 1, 0] - first_policy[k + 1, 0])
        coasts = first_policy[k + 1, 1] + share * (second_policy[k + 1, 1] - first_policy[k + 1, 1])
        b = first_policy[k + 1, 2] + share * (second_policy[k + 1, 2] - first_policy[k + 1, 2])
        length = cells[LENGTH, k]
        grade = cells[GRADE, k]
        air = cells[AIR, k]
        first = n
        if w == cells[FAST, k] and _rides(course.stays[k], a, b, top):
            for i in range(course.row[k] + 1, course.row[k + 1] + 1):
                xs[n] = course.fastest[0, i]
                ws[n] = course.fastest[1, i]
                n += 1
        elif w == a and a == coasts <= top and _holds(train, grade, air, w):  # most cells of a long line
            xs[n] = cells[STATION, k + 1]
            ws[n] = w
            n += 1
        else:
            a = max(min(a, top), bottom)
            n = drive_cell(
                train, returned > 0.0, cells[STATION, k], cells[STATION, k + 1], length, grade, air, cells[LIMIT, k],
                w, a, max(coasts, bottom), max(a, b), top, bx, bw, xs, ws, n,
            )  # fmt: skip
            if n > first + 1:
                n = drop_slivers(xs, ws, first, n, length)
            ws[n - 1] = max(min(ws[n - 1], top), bottom)
        for i in range(first, n):
            d = xs[i] - xs[i - 1]
            duration, work, _, _ = duration_and_work(train, d, grade, air, ws[i - 1], ws[i])
            time += duration
            energy += _energy(train, drawn, returned, d, work, ws[i - 1], ws[i])
    return n, time, energy
