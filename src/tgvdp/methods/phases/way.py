"""What a train drives on: cells, the envelope, and what rows cost there."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part
from tgvdp.line.cells import Cells
from tgvdp.methods.extremal.course import account
from tgvdp.model.track import POWERED
from tgvdp.physics.arc import duration_and_work
from tgvdp.physics.cell import Rows, is_row_of
from tgvdp.physics.energy import EnergyTables
from tgvdp.physics.forces import KernelTrain, mean_brake, mean_effort, unpowered

#: Positions that differ by less are one, m.
SAME_M = 1e-9
#: Positions that differ by less than this share of the destination are one to the referee.
_SAME_PLACE = 1e-12
#: Share by which a row may pass its limit: what joins the run does so within one of its rows.
_EXCESS = 5e-4
#: An effort below this share of the starting effort is none.
_NONE = 1e-4
#: Rows of a march, per row of the search under full traction: those of the usual ones are right to 2e-6 in time and
#: energy, rougher ones are cut later.
_ROWS_PER_DRIVEN = 2.0


class Way(NamedTuple):
    """What a train drives on.

    Attributes
    ----------
    train : KernelTrain
    cells : Cells
    has_power : bool
        In all of them.
    envelope : Rows
        Of the fastest run.
    traction, returned : float
        Energy of a joule of traction, and what a joule of the dynamic brake is worth in joules of traction.
    little_n : float
        An effort below it is none, N.
    """

    train: KernelTrain
    cells: Cells
    has_power: bool
    envelope: Rows
    traction: float
    returned: float
    little_n: float


class Room(NamedTuple):
    """What changes of a run may cost together.

    Attributes
    ----------
    most_j : float
        By how much E + λT may rise, J.
    earliest_s, latest_s : float
        From how much less to how much more time it may take, s.
    each_j, cheap_j : float
        What a single change may cost besides, J, and all such changes together.
    """

    most_j: float
    earliest_s: float
    latest_s: float
    each_j: float
    cheap_j: float


class Run(NamedTuple):
    """Rows of a run, (size,) each: positions, m, squared speeds, m²/s², and of the row that starts there its regime,
    running time, s, and energy, J.

    Energies are without auxiliaries, less what these do not draw where the pantograph is lowered.
    """

    x: NDArray[np.float64]
    w: NDArray[np.float64]
    regime: NDArray[np.int64]
    time: NDArray[np.float64]
    energy: NDArray[np.float64]

    @classmethod
    def of(cls, room: NDArray[np.float64]) -> "Run":
        """Room for a run of so many rows, (5, size)."""
        x, w, regime, time, energy = room
        return cls(x, w, regime.view(np.int64), time, energy)


def way_of(train: KernelTrain, cells: Cells, envelope: Rows, tables: EnergyTables) -> Way:
    """What a train drives on, by a mesh and an energy model."""
    train = train._replace(rows=_ROWS_PER_DRIVEN * train.rows, other_rows=1.0)
    starting_n = float(train.traction[0, 2])  # the constant of the curve that starts at a standstill
    returned = tables.regeneration / tables.traction
    has_power = bool((cells.supply == POWERED).all())
    return Way(train, cells, has_power, envelope, tables.traction, returned, _NONE * starting_n)


@leaf
def row_at(x, n, at):
    """Row, of n − 1, that starts at a position, or holds it; the first or the last one beyond them."""
    first = 0
    end = n - 1
    while end - first > 1:
        middle = (first + end) // 2
        if x[middle] <= at:
            first = middle
        else:
            end = middle
    return first


@leaf
def cell_from(cells, k, at):
    """The cell, from k on, in which a row that starts at a position lies; no farther than the last one."""
    while k < cells.length_m.shape[0] - 1 and cells.station_m[k + 1] <= at + SAME_M:
        k += 1
    return k


@leaf
def w_on(x, w, i, at):
    """Squared speed at a position on the row that starts at i."""
    return w[i] + (w[i + 1] - w[i]) * ((at - x[i]) / (x[i + 1] - x[i]))


@leaf
def train_in(way, k):
    """The train as it is in a cell."""
    return way.train if way.cells.supply[k] == POWERED else unpowered(way.train)


@leaf
def measure_row(way, k, run, j):
    """Fill in running time and energy of row j, which lies in cell k; returns its mean effort, N."""
    cells = way.cells
    d = run.x[j + 1] - run.x[j]
    duration, work, effort = account(
        train_in(way, k), way.returned, cells.grade_n[k], cells.air[k], d, run.w[j], run.w[j + 1]
    )
    run.time[j] = duration
    run.energy[j] = way.traction * work - cells.saved_w[k] * duration
    return effort


@part
def measure(way, run, first, last):
    """Fill in running times and energies of rows ``first`` to ``last`` − 1."""
    cells = way.cells
    k = row_at(cells.station_m, cells.station_m.shape[0], run.x[first] + SAME_M)
    for j in range(first, last):
        k = cell_from(cells, k, run.x[j])
        measure_row(way, k, run, j)


@part
def total(run, first, last):
    """Running time, s, and energy, J, of rows ``first`` to ``last`` − 1."""
    time = 0.0
    energy = 0.0
    for j in range(first, last):
        time += run.time[j]
        energy += run.energy[j]
    return time, energy


@part
def copy_rows(run, first, last, out, m):
    """Append rows ``first`` to ``last`` − 1 of a run to ``m`` − 1 others, which end where they start."""
    for j in range(last - first):
        out.x[m + j] = run.x[first + 1 + j]
        out.w[m + j] = run.w[first + 1 + j]
    for j in range(last - first):
        out.regime[m - 1 + j] = run.regime[first + j]
        out.time[m - 1 + j] = run.time[first + j]
        out.energy[m - 1 + j] = run.energy[first + j]


@leaf
def _is_cheap(room, dearer_j):
    """Whether a change is one of those that may be made besides."""
    return 0.0 < dearer_j <= min(room.each_j, room.cheap_j)


@leaf
def is_within(room, dearer_j, later_s):
    """Whether a change of E + λT and of the running time is within what there is."""
    affordable = dearer_j <= room.most_j or _is_cheap(room, dearer_j)
    return affordable and room.earliest_s <= later_s <= room.latest_s


@leaf
def left_of(room, dearer_j, later_s):
    """Room that is left after a change."""
    cheap = _is_cheap(room, dearer_j)
    most_j = room.most_j if cheap else room.most_j - dearer_j
    cheap_j = room.cheap_j - dearer_j if cheap else room.cheap_j
    return Room(most_j, room.earliest_s - later_s, room.latest_s - later_s, room.each_j, cheap_j)


@part
def is_feasible(way, k, d, w0, w1):
    """Whether a train gives the effort of a row, within its comfort limits."""
    here = train_in(way, k)
    _, work, load, noise = duration_and_work(here, d, way.cells.grade_n[k], way.cells.air[k], w0, w1)
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    slack = 1.0 + _EXCESS
    gain = 0.5 * (w1 - w0)
    if gain > d * here.max_acceleration * slack or -gain > d * here.max_deceleration * slack:
        return False
    if work >= 0.0:
        return work <= d * mean_effort(here.traction, v0, v1) * slack + noise
    return -work <= d * mean_brake(here, load, v0, v1) * slack + noise


@part
def is_sound(way, run, n, given, first, last):
    """Whether rows advance, end wherever the line may change, and ask for no more than the train gives.

    All but those that are among rows ``first`` to ``last`` − 1 of the ``given``, which are sound.
    """
    station_m = way.cells.station_m
    same = _SAME_PLACE * station_m[-1]
    k = 0
    g = first
    for j in range(n - 1):
        while g < last - 1 and given.x[g] < run.x[j]:
            g += 1
        if is_row_of(run, j, given, g):
            continue
        d = run.x[j + 1] - run.x[j]
        while k < way.cells.length_m.shape[0] - 1 and station_m[k + 1] <= run.x[j] + same:
            k += 1
        within = d > 0.0 and run.x[j + 1] <= station_m[k + 1] + same
        if not within or not is_feasible(way, k, d, run.w[j], run.w[j + 1]):
            return False
    return True
