"""From a run of the relaxed problem to one that a train can drive: partial effort as switching between two efforts.

Where the map lies on its convex hull the effort of the relaxed run is applied as it is. Elsewhere the hull is the chord
between two demands at which it touches the map: the train applies the lower one first and then the upper one, and comes
back to the relaxed run at the end of the cell. The power drawn is then that of the hull, up to terms of second order in
the change of speed, and no speed limit is passed.
"""

import math

from tgvdp._jit import kernel, leaf, part
from tgvdp.model.track import LOWERED, POWERED
from tgvdp.physics.arc import arc, duration_and_work
from tgvdp.physics.cell import cell_at
from tgvdp.physics.codes import OK
from tgvdp.physics.energy import arc_energy, map_power
from tgvdp.physics.forces import mean_effort, mean_resistance, unpowered

#: Share of the power by which a map may lie above its hull where they touch.
_TOUCH = 1e-6
#: Landings and switching points are solved by so many sweeps; each leaves a small share of the error of the last one.
_SWEEPS = 5
#: Switching points nearer to an end of their cell than this share are left out.
_SLIVER = 1e-4


@leaf
def _touches(tables, relaxed, v, demand):
    """Whether the map lies on its hull at a speed and a demand."""
    hull = map_power(relaxed, v, demand)
    return map_power(tables, v, demand) - hull <= _TOUCH * (abs(hull) + abs(relaxed.power_w[-1, -1]))


@part
def _neighbours(tables, relaxed, v, demand):
    """The nodes of demand below and above a demand at which the map touches its hull."""
    nodes = tables.demand
    last = nodes.shape[0] - 1
    below = 0
    while below < last and nodes[below + 1] <= demand:
        below += 1
    above = min(below + 1, last)
    while below > 0 and not _touches(tables, relaxed, v, nodes[below]):
        below -= 1
    while above < last and not _touches(tables, relaxed, v, nodes[above]):
        above += 1
    return nodes[below], nodes[above]


@leaf
def _gain(train, cell, demand, v0, v1):
    """Slope of v² over distance at a demand, between two speeds."""
    effort = demand * mean_effort(train.traction if demand >= 0.0 else train.braking, v0, v1)
    return 2.0 * (effort - mean_resistance(train, cell.air, v0, v1) - cell.grade_n) / train.inertia_kg


@part
def _switching_point(train, cell, w0, w1, lower, upper):
    """Where to change from the lower to the upper demand to come from w0 to w1, and the squared speed there."""
    length = cell.length_m
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    x = 0.0
    middle = w0
    for _ in range(_SWEEPS):
        v = math.sqrt(middle)
        down = _gain(train, cell, lower, v0, v)
        up = _gain(train, cell, upper, v, v1)
        if up <= down:
            return 0.0, w0
        x = min(max((w0 + up * length - w1) / (up - down), 0.0), length)
        middle = max(w1 - up * (length - x), 0.0)
    return x, middle


@part
def _append(train, tables, cell, d, x, w0, w1, rows, n):
    """Append a row; returns its duration and its energy."""
    duration, work, _, _ = duration_and_work(train, d, cell.grade_n, cell.air, w0, w1)
    rows.x[n] = x
    rows.w[n] = w1
    return duration, arc_energy(train, tables, d, duration, work, w0, w1)


@kernel
def switch(train, tables, relaxed, cells, w, rows):
    """Follow a run of the relaxed problem with efforts at which the map touches its hull.

    Parameters
    ----------
    train : KernelTrain
    tables, relaxed : EnergyTables
        The map, and its convex hull over the effort.
    cells : Cells
    w : (K + 1,) float64
        The relaxed run.
    rows : Rows of 2·K + 1, modified in place
        Rows of the run: positions from the origin, squared speeds.

    Returns
    -------
    n : int
        Number of rows.
    time_s, energy_j : float
    """
    rows.x[0] = cells.station_m[0]
    rows.w[0] = w[0]
    n = 1
    time = 0.0
    energy = 0.0
    dark = unpowered(train)
    for k in range(cells.length_m.shape[0]):
        here = train if cells.supply[k] == POWERED else dark
        cell = cell_at(cells, k)
        d = cell.length_m
        v0 = math.sqrt(w[k])
        v1 = math.sqrt(w[k + 1])
        v = 0.5 * (v0 + v1)
        work = duration_and_work(here, d, cell.grade_n, cell.air, w[k], w[k + 1])[1]
        limit = d * mean_effort(here.traction if work >= 0.0 else here.braking, v0, v1)
        demand = min(max(work / limit, -1.0), 1.0) if limit > 0.0 else 0.0
        if cells.supply[k] == POWERED and not _touches(tables, relaxed, v, demand):
            lower, upper = _neighbours(tables, relaxed, v, demand)
            x, middle = _switching_point(train, cell, w[k], w[k + 1], lower, upper)
            if (
                _SLIVER * d < x < (1.0 - _SLIVER) * d
                and arc(train, x, cell.grade_n, cell.air, w[k], middle)[0] == OK
                and arc(train, d - x, cell.grade_n, cell.air, middle, w[k + 1])[0] == OK
            ):
                seconds, joules = _append(train, tables, cell, x, cell.start_m + x, w[k], middle, rows, n)
                time += seconds
                energy += joules
                n += 1
                d -= x
        seconds, joules = _append(here, tables, cell, d, cell.end_m, rows.w[n - 1], w[k + 1], rows, n)
        time += seconds
        if cells.supply[k] != LOWERED:
            energy += joules
        n += 1
    return n, time, energy
