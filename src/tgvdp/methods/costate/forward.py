"""Drive a train by switching speeds: the forward pass of the front method.

A policy gives four switching speeds a, a' and c ≥ b ≥ a for every station: full traction below the line of switching,
which ends at a, coasting above it (from the start of the cell on to a' or more), dynamic braking above b, all brakes
above c, holding at any of them, and all brakes as late as the envelope of feasible speeds allows. Where braking returns
no energy b and c are the envelope. The run is exact within each cell: traction ends where it meets the line, and
coasting where it meets the braking curve. Where it is on the envelope, and stays there, its rows are those of the
fastest run: most of the cells in which it gains or loses speed.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part
from tgvdp.line.cells import Cells
from tgvdp.methods.costate.blend import LINES, falls_from_held, switch_at
from tgvdp.methods.costate.forward_brakes import coast_through
from tgvdp.methods.costate.forward_cell import drive_cell
from tgvdp.methods.costate.forward_lines import Lines
from tgvdp.methods.costate.forward_rows import ON_CURVE, coast, ended, evenly, pull
from tgvdp.methods.costate.intervals import through_cell
from tgvdp.model.track import POWERED
from tgvdp.physics.arc import duration_and_work, duration_and_work_of
from tgvdp.physics.cell import Rows, append, cell_at
from tgvdp.physics.codes import DYNAMIC
from tgvdp.physics.energy import regenerated
from tgvdp.physics.forces import mean_effort, resistance_at, unpowered
from tgvdp.physics.motion import land, net_force_at
from tgvdp.runs.braking_point import drop_slivers

#: Whether a run that enters a cell on the envelope stays on it: never, if a is not below it, if b is not, if c is not
#: (which is all that matters without current).
_LEAVES = 0
_AIMS_THERE = 1
_COASTS_THERE = 2
_BRAKES_THERE = 3


class Course(NamedTuple):
    """Cells with the envelope of feasible speeds, and the fastest run within each of them, for the kernel.

    Attributes
    ----------
    cells : Cells
    low, fast : (K + 1,) float64
        Slowest and fastest feasible squared speed at each station, m²/s².
    fastest : Rows
        Rows of the fastest run.
    row : (K + 1,) int64
        Its rows at the stations.
    stays : (K,) int64
        Whether a run on the envelope stays there; negative until the course is first driven.
    ride : (K, 2) float64
        Running time, s, and energy, J, of the fastest run in each cell, as `drive_blend` counts them.
    """

    cells: Cells
    low: NDArray[np.float64]
    fast: NDArray[np.float64]
    fastest: Rows
    row: NDArray[np.int64]
    stays: NDArray[np.int64]
    ride: NDArray[np.float64]


@leaf
def _energy(train, tables, length, work, w0, w1):
    """Energy in J of an arc, from its work, without auxiliaries."""
    if work >= 0.0:
        return tables.traction * work
    if tables.regeneration == 0.0:
        return 0.0
    return -tables.regeneration * length * regenerated(train, length, -work / length, math.sqrt(w0), math.sqrt(w1))


@part
def _measured(train, tables, cell, saved, rows, first, last):
    """Running time and energy of rows in a cell, from ``first`` on; ``saved`` is what auxiliaries do not draw, W."""
    time = 0.0
    energy = 0.0
    v1 = math.sqrt(rows.w[first - 1])
    for i in range(first, last):
        d = rows.x[i] - rows.x[i - 1]
        v0, v1 = v1, math.sqrt(rows.w[i])
        duration, work, _, _ = duration_and_work_of(train, d, cell.grade_n, cell.air, rows.w[i - 1], rows.w[i], v0, v1)
        time += duration
        energy += _energy(train, tables, d, work, rows.w[i - 1], rows.w[i]) - saved * duration
    return time, energy


@part
def find_rides(train, tables, course):
    """Fill in ``stays`` and ``ride`` of a course."""
    dark = unpowered(train)
    x = course.fastest.x
    w = course.fastest.w
    for k in range(course.stays.shape[0]):
        cell = cell_at(course.cells, k)
        driven = True
        braked = True
        rises = True
        falls = True
        for i in range(course.row[k], course.row[k + 1]):
            work = duration_and_work(train, x[i + 1] - x[i], cell.grade_n, cell.air, w[i], w[i + 1])[1]
            driven &= work >= 0.0
            braked &= work <= 0.0
            rises &= w[i + 1] >= w[i]
            falls &= w[i + 1] <= w[i]
        course.stays[k] = _LEAVES
        if driven and (rises or falls):
            course.stays[k] = _AIMS_THERE
        start = course.fast[k]
        top = course.fast[k + 1]
        if braked and falls and coast(train, cell, cell.length_m, start) > top:
            course.stays[k] = _COASTS_THERE
            if land(train, DYNAMIC, 1.0, cell, cell.length_m, start) > top * (1.0 + ON_CURVE):
                course.stays[k] = _BRAKES_THERE
        powered = course.cells.supply[k] == POWERED
        if not powered:
            course.stays[k] = _BRAKES_THERE
        course.ride[k, 0], course.ride[k, 1] = _measured(
            train if powered else dark, tables, cell, course.cells.saved_w[k], course.fastest, course.row[k] + 1,
            course.row[k + 1] + 1,
        )  # fmt: skip


@leaf
def _rides(stays, a, b, c, top):
    """Whether a run on the envelope, of switching speeds a, b and c at the end of the cell, stays there."""
    if stays == _BRAKES_THERE:
        return c >= top
    return (stays == _AIMS_THERE and a >= top) or (stays == _COASTS_THERE and b >= top)


@leaf
def _holds(train, cell, w):
    """Whether traction alone holds a speed."""
    v = math.sqrt(w)
    load = resistance_at(train, cell.air, v) + cell.grade_n
    return 0.0 <= load <= mean_effort(train.traction, v, v)


@part
def _falls_under(train, cells, k, w):
    """By how much v² falls per metre under full dynamic braking in a cell, at a squared speed."""
    v = math.sqrt(w)
    return -2.0 / train.inertia_kg * net_force_at(train, DYNAMIC, cell_at(cells, k), v)


@part
def _regenerates_before(train, course, blend, share, k, b):
    """Where dynamic braking begins at the start of a cell, of which the line ends at b.

    A line that comes out of the envelope within the cell, or out of a section without current before it, falls by as
    much more than a braking run as it does behind the cell.
    """
    cells = course.cells
    before = switch_at(blend, share, k, 2)
    top = course.fast[k]
    if before < top:
        return before
    if b < course.fast[k + 1] and k + 2 < course.fast.shape[0]:
        after = switch_at(blend, share, k + 2, 2)
        if after < course.fast[k + 2]:
            steeper = (b - after) / cells.length_m[k + 1] - _falls_under(train, cells, k + 1, 0.5 * (b + after))
            length = cells.length_m[k]
            middle = b + 0.5 * length * _falls_under(train, cells, k, b)
            begun = b + length * (steeper + _falls_under(train, cells, k, max(middle, 0.0)))
            return max(begun, top) if k > 0 and cells.supply[k - 1] == POWERED else min(begun, top)
    return top


@part
def drive_blend(train, tables, course, blend, share, scratch, passed, rows):
    """Drive the whole trip by a blend of two policies, from the first row on, which is there.

    Parameters
    ----------
    train : KernelTrain
    tables : EnergyTables
        Of which only the two factors count.
    course : Course
    blend : Blend
        Of policies as of `backward.switching_speeds`.
    share : float
        Of the second policy.
    scratch : Rows
    passed : (K + 1, 3) float64, modified in place
        Squared speed, running time and energy at each station.
    rows : Rows, modified in place
        Rows of the run: positions from the origin, squared speeds.

    Returns
    -------
    n : int
        Number of rows; −1 when the buffers are too small.
    time_s, energy_j : float
        Running time and energy, without auxiliaries, and less what these do not draw where the pantograph is lowered.
    """
    n = 1
    time = 0.0
    energy = 0.0
    dark = unpowered(train)
    passed[0, 0], passed[0, 1], passed[0, 2] = rows.w[0], time, energy
    for k in range(course.stays.shape[0]):
        w = rows.w[n - 1]
        top = course.fast[k + 1]
        bottom = course.low[k + 1]
        a = switch_at(blend, share, k + 1, 0)
        coasts = switch_at(blend, share, k + 1, 1)
        b = switch_at(blend, share, k + 1, 2)
        c = switch_at(blend, share, k + 1, 3)
        cell = cell_at(course.cells, k)
        powered = course.cells.supply[k] == POWERED
        here = train if powered else dark
        first = n
        if w == course.fast[k] and _rides(course.stays[k], a, b, c, top):
            for i in range(course.row[k] + 1, course.row[k + 1] + 1):
                n = append(course.fastest.x[i], course.fastest.w[i], rows, n)
            first = n
            time += course.ride[k, 0]
            energy += course.ride[k, 1]
        elif powered and w == a and a == coasts <= top and _holds(train, cell, w):  # most cells of a long line
            n = append(cell.end_m, w, rows, n)
        else:
            if powered:
                a = max(min(a, top), bottom)
                b = max(a, b)
                before_top = course.fast[k]
                before_b = _regenerates_before(train, course, blend, share, k, b)
                before_c = min(switch_at(blend, share, k, 3), before_top)
                before_a = switch_at(blend, share, k, 0)
                held = before_a if falls_from_held(blend, share, k) else math.inf
                if before_top <= held < math.inf:  # beyond the envelope nothing is
                    before_a = before_top
                    held = math.inf
                coasts = max(coasts, bottom)
                before_e = before_g = e = g = 0.0
                if blend.first.shape[1] > LINES:
                    before_b, before_e, before_g, b, e, g = through_cell(
                        train, cell, before_b, before_c, switch_at(blend, share, k, LINES),
                        switch_at(blend, share, k, LINES + 1), b, min(c, top), switch_at(blend, share, k + 1, LINES),
                        switch_at(blend, share, k + 1, LINES + 1), scratch,
                    )  # fmt: skip
                lines = Lines(
                    before_a, before_b, before_c, before_e, before_g, before_top, a, coasts, b, max(b, c), e, g, top,
                    held,
                )  # fmt: skip
                before = cell_at(course.cells, max(k - 1, 0))
                n = drive_cell(train, tables.regeneration > 0.0, before, cell, w, lines, scratch, rows, n)
            else:
                landed = coast(here, cell, cell.length_m, w)
                c = min(max(c, bottom), top)
                before_top = course.fast[k]
                before_c = min(switch_at(blend, share, k, 3), before_top)
                lines = Lines(
                    before_top, before_c, before_c, 0.0, 0.0, before_top, top, top, c, c, 0.0, 0.0, top, math.inf
                )
                n = coast_through(here, False, cell, w, landed, lines, scratch, rows, n)
            if n > first + 1:
                n = drop_slivers(rows, first, n, cell.length_m)
            if n > 0 and rows.w[n - 1] < bottom and powered and pull(here, cell, w, bottom) < math.inf:
                n = evenly(here, cell, w, bottom, scratch, rows, first)  # traction began too late
            if n > 0 and not bottom <= rows.w[n - 1] <= top:  # by an error of its rows, which all of them share
                n = ended(cell, bottom if rows.w[n - 1] < bottom else top, rows, first, n)
        if n < 0:
            return n, time, energy
        duration, work = _measured(here, tables, cell, course.cells.saved_w[k], rows, first, n)
        time += duration
        energy += work
        passed[k + 1, 0], passed[k + 1, 1], passed[k + 1, 2] = rows.w[n - 1], time, energy
    return n, time, energy
