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
from tgvdp.physics.cell import Cell, cell_at
from tgvdp.physics.codes import DYNAMIC, OK, TRACTION
from tgvdp.physics.energy import arc_energy, map_power
from tgvdp.physics.forces import mean_effort, mean_resistance, unpowered
from tgvdp.physics.motion import net_force

#: Share of the power by which a map may lie above its hull where they touch.
_TOUCH = 1e-6
#: Landings and switching points are solved by so many sweeps; each leaves a small share of the error of the last one.
_SWEEPS = 5
#: Switching points nearer to an end of their cell than this share are left out.
_SLIVER = 1e-4
#: A cell is switched in so often that no more than this share of its time is lost, so often at most.
_LOST = 2e-3
MOST_PULSES = 16


@leaf
def _touches(tables, relaxed, v, demand):
    """Whether the map lies on its hull at a speed and a demand."""
    hull = map_power(relaxed, v, demand)
    return map_power(tables, v, demand) - hull <= _TOUCH * (abs(hull) + abs(relaxed.power_w[-1, -1]))


@part
def _neighbours(tables, relaxed, v, demand):
    """The nodes of demand below and above a demand at which the map touches its hull."""
    nodes = relaxed.demand
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


@part
def _gain(train, cell, demand, v0, v1):
    """Slope of v² over distance at a demand, or at what comfort and braking rates leave of it, between two speeds."""
    effort = demand * mean_effort(train.traction if demand >= 0.0 else train.braking, v0, v1)
    net = effort - mean_resistance(train, cell.air, v0, v1) - cell.grade_n
    if demand > 0.0:
        net = min(net, net_force(train, TRACTION, cell, v0, v1))
    elif demand < 0.0:
        net = max(net, net_force(train, DYNAMIC, cell, v0, v1))
    return 2.0 * net / train.inertia_kg


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
def _demands(train, tables, relaxed, cell, w0, w1):
    """The two demands between which to switch along an arc; the same one where the map lies on its hull."""
    d = cell.length_m
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    v = 0.5 * (v0 + v1)
    work = duration_and_work(train, d, cell.grade_n, cell.air, w0, w1)[1]
    limit = d * mean_effort(train.traction if work >= 0.0 else train.braking, v0, v1)
    demand = min(max(work / limit, -1.0), 1.0) if limit > 0.0 else 0.0
    return (demand, demand) if _touches(tables, relaxed, v, demand) else _neighbours(tables, relaxed, v, demand)


@part
def _is_drivable(train, cell, x, w0, middle, w1):
    """Whether a cell can be driven in two parts, neither of them a sliver."""
    d = cell.length_m
    return (
        _SLIVER * d < x < (1.0 - _SLIVER) * d
        and arc(train, x, cell.grade_n, cell.air, w0, middle)[0] == OK
        and arc(train, d - x, cell.grade_n, cell.air, middle, w1)[0] == OK
    )


@part
def _pulses(train, cell, w0, w1, lower, upper):
    """How often to switch in a cell, so that little time is lost by it: what is lost falls with their number."""
    x, middle = _switching_point(train, cell, w0, w1, lower, upper)
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    v = math.sqrt(middle)
    whole_s = 2.0 * cell.length_m / (v0 + v1)
    lost_s = 2.0 * x / (v0 + v) + 2.0 * (cell.length_m - x) / (v + v1) - whole_s
    return max(math.ceil(min(lost_s / (_LOST * whole_s), MOST_PULSES)), 1)


@leaf
def _piece(cell, i, n):
    """One of n equal pieces of a cell."""
    length = cell.length_m / n
    end = cell.end_m if i + 1 == n else cell.start_m + (i + 1) * length
    return Cell(cell.start_m + i * length, end, length, cell.grade_n, cell.air, cell.limit_w)


@part
def _append(train, tables, cell, x, length, w1, rows, n):
    """Append a row in a cell, so far behind the one before; returns its duration and its energy."""
    w0 = rows.w[n - 1]
    duration, work, _, _ = duration_and_work(train, length, cell.grade_n, cell.air, w0, w1)
    rows.x[n] = x
    rows.w[n] = w1
    return duration, arc_energy(train, tables, length, duration, work, w0, w1)


@part
def _pulse(train, tables, piece, lower, upper, w1, rows, n):
    """Append two rows, or one where two are not drivable; returns how many, their duration and their energy."""
    x, middle = _switching_point(train, piece, rows.w[n - 1], w1, lower, upper)
    if not _is_drivable(train, piece, x, rows.w[n - 1], middle, w1):
        return 1, *_append(train, tables, piece, piece.end_m, piece.length_m, w1, rows, n)
    first_s, first_j = _append(train, tables, piece, piece.start_m + x, x, middle, rows, n)
    second_s, second_j = _append(train, tables, piece, piece.end_m, piece.length_m - x, w1, rows, n + 1)
    return 2, first_s + second_s, first_j + second_j


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
    rows : Rows of 2·K·MOST_PULSES + 1, modified in place
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
        w0 = w[k]
        w1 = w[k + 1]
        lower, upper = _demands(here, tables, relaxed, cell, w0, w1)
        pieces = _pulses(here, cell, w0, w1, lower, upper) if lower < upper else 1
        for i in range(pieces):
            end_w = w1 if i + 1 == pieces else w0 + (w1 - w0) * ((i + 1) / pieces)
            added, seconds, joules = _pulse(here, tables, _piece(cell, i, pieces), lower, upper, end_w, rows, n)
            n += added
            time += seconds
            if cells.supply[k] != LOWERED:
                energy += joules
    return n, time, energy
