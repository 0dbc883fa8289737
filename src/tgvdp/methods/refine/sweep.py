"""Discrete differential dynamic programming: a run is improved by programs over a few speeds around it.

The speeds of a station are those of the run at first, and whole steps above and below. So an arc between two of them is
the same arc in the next sweep, wherever the run has moved meanwhile, and what it costs is kept: of the 5 × 5 arcs of a
cell none is new where the run has not moved, and 9 are where it has moved by one step.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf, part
from tgvdp.model.track import LOWERED, POWERED
from tgvdp.physics.arc import arc
from tgvdp.physics.codes import OK, OVER_ACCELERATION, OVER_TRACTION
from tgvdp.physics.energy import arc_energy
from tgvdp.physics.forces import unpowered

#: Gain of a sweep, as a share of E + λT, above which the next one keeps its step.
GAIN = 1e-7
#: What an arc costs that no train drives, and one that asks for more traction or acceleration than there is.
_NO_ARC = math.inf
_TOO_FAST = -math.inf
#: An arc is known by its cell and by its speeds at both ends, in steps from the run at first: the number of the cell,
#: and two of less than half of this.
_FEWER_STEPS = 1 << 16
NOBODY = -1 << 62


class Scratch(NamedTuple):
    """Memory of the sweeps on a mesh of K + 1 stations, with n speeds at most at each.

    Attributes
    ----------
    steps, lowest : (K + 1,) int64
        Of the run, and of the lowest speed to choose from: steps above the run at first.
    best : (K + 1, n) int16
        Which speed of the next station is best behind each one.
    value : (2, n) float64
        What the rest of the way costs, J, from this station and from the next one.
    known : (m,) int64
        Names of arcs.
    joules, seconds : (m,) float64
        What these draw, J, and how long they take, s.
    around : (3, K + 1) int64
        Steps of the runs among which `hold` looks for one of a given time.
    """

    steps: NDArray[np.int64]
    lowest: NDArray[np.int64]
    best: NDArray[np.int16]
    value: NDArray[np.float64]
    known: NDArray[np.int64]
    joules: NDArray[np.float64]
    seconds: NDArray[np.float64]
    around: NDArray[np.int64]

    @classmethod
    def of(cls, stations: int, most: int, usual: int) -> "Scratch":
        """For so many stations and speeds; the costs of all arcs between the usual number of speeds are kept."""
        arcs = max(stations * usual**2, most**2)
        steps, lowest = np.empty((2, stations), dtype=np.int64)
        best, value = np.empty((stations, most), dtype=np.int16), np.empty((2, most))
        known, around = np.empty(arcs, dtype=np.int64), np.empty((3, stations), dtype=np.int64)
        return cls(steps, lowest, best, value, known, np.empty(arcs), np.empty(arcs), around)


@leaf
def speed(start_w, steps, step, low, fast):
    """Squared speed so many steps above the one at first."""
    return min(max(start_w + steps * step, low), fast)


@leaf
def _wrapped(place, width):
    """A place of a ring of so many, of one that is less than once around behind its last."""
    return place if place < width else place - width


@part
def _drawn(train, tables, cells, k, w0, w1):
    """Energy in J and duration in s of an arc of cell k."""
    status, duration, work = arc(train, cells.length_m[k], cells.grade_n[k], cells.air[k], w0, w1)
    if status != OK:
        return _TOO_FAST if status in (OVER_TRACTION, OVER_ACCELERATION) else _NO_ARC, 0.0
    energy = 0.0
    if cells.supply[k] != LOWERED:
        energy = arc_energy(train, tables, cells.length_m[k], duration, work, w0, w1)
    return energy, duration


@kernel
def program(train, tables, cells, low, fast, multiplier, half, step, start_w, w, scratch):
    """Find the best run among all combinations of the speeds around w; returns its E + λT."""
    steps, lowest, best, value = scratch.steps, scratch.lowest, scratch.best, scratch.value
    count = cells.length_m.shape[0]
    width = 2 * half + 1
    rows = scratch.known.shape[0] // width**2
    dark = unpowered(train)
    value[1, 0] = 0.0
    lowest[count] = steps[count]
    size = 1  # both ends have one speed
    for k in range(count - 1, -1, -1):
        after = size
        here = train if cells.supply[k] == POWERED else dark
        lowest[k] = steps[k] - math.ceil(min(half, (w[k] - low[k]) / step))
        size = steps[k] + math.ceil(min(half, (fast[k] - w[k]) / step)) - lowest[k] + 1
        row, column = lowest[k] % width, lowest[k + 1] % width
        for i in range(size):
            at = lowest[k] + i
            w0 = speed(start_w[k], at, step, low[k], fast[k])
            slots = (k % rows * width + _wrapped(row + i, width)) * width
            least = math.inf
            for j in range(after):
                to = lowest[k + 1] + j
                name = (k * _FEWER_STEPS + at) * _FEWER_STEPS + to
                slot = slots + _wrapped(column + j, width)
                if scratch.known[slot] != name:
                    w1 = speed(start_w[k + 1], to, step, low[k + 1], fast[k + 1])
                    scratch.known[slot] = name
                    scratch.joules[slot], scratch.seconds[slot] = _drawn(here, tables, cells, k, w0, w1)
                cost = multiplier * scratch.seconds[slot] + scratch.joules[slot]
                if cost == _TOO_FAST:
                    if to > steps[k + 1]:
                        break  # as are the speeds above; the run's own arc has been looked at
                elif cost + value[1, j] < least:
                    least = cost + value[1, j]
                    best[k, i] = j
            value[0, i] = least
        for i in range(size):
            value[1, i] = value[0, i]
    return value[1, 0]


@part
def _take(low, fast, step, start_w, w, scratch):
    """Replace w by the run that a program has found."""
    steps, lowest = scratch.steps, scratch.lowest
    i = 0
    for k in range(w.shape[0] - 1):
        i = scratch.best[k, i]
        steps[k + 1] = lowest[k + 1] + i
        w[k + 1] = speed(start_w[k + 1], steps[k + 1], step, low[k + 1], fast[k + 1])


@kernel
def descend(train, tables, cells, low, fast, multiplier, half, step, cost, most, w, start_w, scratch):
    """Improve a run by sweeps of one step until it is stationary, or has been swept so often.

    Parameters
    ----------
    train : KernelTrain
    tables : EnergyTables
    cells : Cells
    low, fast : (K + 1,) float64
        Slowest and fastest feasible squared speed at each station, m²/s²; equal at both ends.
    multiplier : float
        Multiplier λ, J/s.
    half : int
        Speeds to try above and below that of the run, at each station.
    step : float
        Step between these speeds, m²/s².
    cost : float
        E + λT of the run by the sweep before, J; infinite where there was none.
    most : int
        Sweeps at most.
    w : (K + 1,) float64, modified in place
        The run; a feasible one stays so, and one that is not stays as it is where nothing around it is feasible.
    start_w : (K + 1,) float64
        The run at first.
    scratch : Scratch

    Returns
    -------
    sweeps : int
    cost : float
        E + λT of the run, J; infinite where it is not feasible.
    stationary : bool
    """
    scratch.steps[:] = 0
    scratch.known[:] = NOBODY
    for done in range(most):
        before = cost
        cost = program(train, tables, cells, low, fast, multiplier, half, step, start_w, w, scratch)
        if cost == math.inf:
            return done + 1, cost, True
        _take(low, fast, step, start_w, w, scratch)
        if before - cost <= GAIN * abs(cost):
            return done + 1, cost, True
    return most, cost, False
