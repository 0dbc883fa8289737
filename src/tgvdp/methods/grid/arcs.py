"""An arc over several cells: constant acceleration from one grid station to the next.

The arc is cut into rows, and each row must pass the one feasibility test, `physics.arc.arc`, and the pointwise effort
test at both ends. A row ends where a cell ends, where the speed has changed by 2 % (a power limit varies as 1/v, so
that rows keep it nearly constant), and where the effort at the wheel changes sign, so that the sum over rows counts
traction and braking each by its own multiplier. `long_arc` costs one and `path_rows` lists the rows of a whole
path: both walk through `next_cut`, which is why a profile made of these rows has the grid's own time and energy.
"""

import math

from tgvdp._jit import kernel, leaf
from tgvdp.constants import FEASIBILITY_RTOL
from tgvdp.model.track import LOWERED, POWERED
from tgvdp.physics.arc import arc, within_effort_at
from tgvdp.physics.codes import OK, OVER_EFFORT_AT_POINT, OVER_LIMIT
from tgvdp.physics.energy import arc_energy
from tgvdp.physics.forces import unpowered

#: Largest ratio of the squared speeds at the ends of a row: 2 % in speed.
ROW_RATIO_W = 1.02**2
#: Below this share of the arc's larger squared speed (20 % in speed) one row reaches down to standstill: there the
#: change of speed is large in any row, and shorter rows would only make an open-loop replay stop in the wrong one.
ROW_FLOOR_W = 0.2**2
#: A cut closer than this to the next one, relative in squared speed, is left out: rows need some length.
_ROW_SLIVER = 1e-3


@leaf
def next_cut(w, w_end, w_floor, w_zero):
    """Squared speed at which the row that starts at w ends, on the way to w_end."""
    cut = w_end
    if w_end > w:
        cut = max(w * ROW_RATIO_W, w_floor)
        if cut * (1.0 + _ROW_SLIVER) > w_end:
            cut = w_end
    elif w > w_floor:
        cut = max(w / ROW_RATIO_W, w_floor)
        if cut < w_end * (1.0 + _ROW_SLIVER):
            cut = w_end
    apart = 1e-6 * abs(w_end - w)
    if min(w, cut) + apart < w_zero < max(w, cut) - apart:
        cut = w_zero
    return cut


@leaf
def zero_effort_w(train, grade_n, air, acceleration):
    """Squared speed at which the effort inertia·a + R(v) + grade changes sign, or -1."""
    constant = train.inertia_kg * acceleration + train.davis_a_n + grade_n
    if constant >= 0.0:
        return -1.0
    slope = train.davis_b + math.sqrt(train.davis_b * train.davis_b - 4.0 * air * constant)
    if slope <= 0.0:
        return -1.0
    v = -2.0 * constant / slope
    return v * v


@leaf
def w_between(w0, w1, start_m, end_m, at_m):
    """Squared speed at a position of an arc; exact at both ends."""
    if at_m >= end_m:
        return w1
    return w0 + (w1 - w0) * ((at_m - start_m) / (end_m - start_m))


@kernel
def long_arc(train, tables, cells, first, last, w0, w1):
    """Evaluate the arc over cells ``first .. last - 1``.

    Parameters
    ----------
    train : KernelTrain
    tables : EnergyTables
    cells : Cells
    first, last : int
        Cell stations at the ends of the arc.
    w0, w1 : float
        Squared speeds at its ends, m²/s².

    Returns
    -------
    status : int
        ``OK`` or the first limit that is broken, a code of `physics.codes`.
    duration_s, energy_j : float
        Running time, and energy drawn by the tables, negative if returned; partial sums unless the status is ``OK``.
    """
    start_m = cells.station_m[first]
    end_m = cells.station_m[last]
    acceleration = 0.5 * (w1 - w0) / (end_m - start_m)
    floor = ROW_FLOOR_W * max(w0, w1)
    dark = unpowered(train)
    duration_s = 0.0
    energy_j = 0.0
    w_cell = w0
    for c in range(first, last):
        w_next = w_between(w0, w1, start_m, end_m, cells.station_m[c + 1])
        if max(w_cell, w_next) > cells.limit_w[c] * (1.0 + FEASIBILITY_RTOL):
            return OVER_LIMIT, duration_s, energy_j
        grade_n = cells.grade_n[c]
        air = cells.air[c]
        here = train if cells.supply[c] == POWERED else dark
        zero = zero_effort_w(train, grade_n, air, acceleration)
        if not within_effort_at(here, grade_n, air, acceleration, math.sqrt(w_cell)):
            return OVER_EFFORT_AT_POINT, duration_s, energy_j
        length_m = cells.station_m[c + 1] - cells.station_m[c]
        w = w_cell
        while True:
            cut = next_cut(w, w_next, floor, zero)
            row_m = length_m
            if w_next != w_cell:
                row_m = length_m * ((cut - w) / (w_next - w_cell))
            status, row_s, work_j = arc(here, row_m, grade_n, air, w, cut)
            if status != OK:
                return status, duration_s, energy_j
            if not within_effort_at(here, grade_n, air, acceleration, math.sqrt(cut)):
                return OVER_EFFORT_AT_POINT, duration_s, energy_j
            duration_s += row_s
            if cells.supply[c] != LOWERED:
                energy_j += arc_energy(here, tables, row_m, row_s, work_j, w, cut)
            w = cut
            if w == w_next:
                break
        w_cell = w_next
    return OK, duration_s, energy_j


@kernel
def long_arcs(train, tables, cells, first, last, w_from, w_to, status, duration_s, energy_j):
    """Evaluate the arcs between all pairs of speeds; the three (n_from, n_to) arrays are modified in place."""
    for i in range(w_from.size):
        for j in range(w_to.size):
            status[i, j], duration_s[i, j], energy_j[i, j] = long_arc(
                train, tables, cells, first, last, w_from[i], w_to[j]
            )


@kernel
def path_rows(train, cells, station_cell, station_w, x_m, w_row):
    """List the rows of a path.

    Parameters
    ----------
    train : KernelTrain
    cells : Cells
    station_cell : (n_stations,) int64
        Cell station of each grid station.
    station_w : (n_stations,) float64
        Squared speeds of the path at the grid stations, m²/s².
    x_m, w_row : (capacity,) float64
        Receive positions from the origin and squared speeds, modified in place; with capacity 0, only count.

    Returns
    -------
    int
        Number of rows, the last station included.
    """
    count = 0
    for k in range(station_cell.size - 1):
        first = station_cell[k]
        last = station_cell[k + 1]
        start_m = cells.station_m[first]
        end_m = cells.station_m[last]
        w0 = station_w[k]
        w1 = station_w[k + 1]
        acceleration = 0.5 * (w1 - w0) / (end_m - start_m)
        floor = ROW_FLOOR_W * max(w0, w1)
        w_cell = w0
        for c in range(first, last):
            w_next = w_between(w0, w1, start_m, end_m, cells.station_m[c + 1])
            zero = zero_effort_w(train, cells.grade_n[c], cells.air[c], acceleration)
            length_m = cells.station_m[c + 1] - cells.station_m[c]
            w = w_cell
            while True:
                if x_m.size > 0:
                    x_m[count] = cells.station_m[c]
                    if w != w_cell:
                        x_m[count] += length_m * ((w - w_cell) / (w_next - w_cell))
                    w_row[count] = w
                count += 1
                w = next_cut(w, w_next, floor, zero)
                if w == w_next:
                    break
            w_cell = w_next
    if x_m.size > 0:
        x_m[count] = cells.station_m[station_cell[-1]]
        w_row[count] = station_w[-1]
    return count + 1
