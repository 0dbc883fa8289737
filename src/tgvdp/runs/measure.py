"""Runs measured: running time, energy, and what each row does."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import entry, leaf
from tgvdp.line.piecewise import Floats
from tgvdp.line.resolved import resolve
from tgvdp.line.walk import piece_from, sum_to
from tgvdp.model.energy import PANTOGRAPH
from tgvdp.model.track import LOWERED, POWERED
from tgvdp.model.trip import Trip
from tgvdp.physics.arc import duration_and_work_of
from tgvdp.physics.codes import BRAKING, COASTING, HOLDING, TRACTION
from tgvdp.physics.energy import arc_energy, energy_tables
from tgvdp.physics.forces import kernel_train, mean_brake, mean_effort, mean_resistance, unpowered

#: An effort below this share of the starting effort counts as none (coasting).
_COASTING_SHARE = 1e-4
#: An acceleration below this share of what the starting effort gives counts as none (cruising).
_CRUISING_SHARE = 0.03
#: A row at less than this share of its limit may cruise.
_NOT_FULL = 0.95
#: ... and does, where it slows down, or the effort that it spares would accelerate it more than twice as much again.
_SPARED = 0.5
#: A row that slows down coasts where its effort is below this share of its limit: that is no pull.
_LITTLE = 0.02
#: Columns of totals: running time, s, and energy by the trip's model, J; and work of traction and of brakes, what is
#: drawn and returned by the tables, auxiliaries aside, and what these draw, J.
_TOTALS = 7


class Columns(NamedTuple):
    """What is told of each row, (N,) float64 each and int8: none, where totals are all that is asked for.

    Attributes
    ----------
    time, energy : float64
        Since departure, s and J.
    force : float64
        Mean effort at the wheel up to the next row, N.
    regime : int8
        Up to the next row; see `physics.codes`.
    """

    time: Floats
    energy: Floats
    force: Floats
    regime: NDArray[np.int8]

    @classmethod
    def of(cls, rows: int) -> "Columns":
        """Room for so many rows."""
        time, energy, force = np.empty((3, rows))
        return cls(time, energy, force, np.empty(rows, dtype=np.int8))


@leaf
def _regime(train, start_effort, effort, acceleration, limit):
    """Regime of a row by its effort and acceleration; ``limit`` is that of its effort."""
    if abs(effort) <= _COASTING_SHARE * start_effort:
        return COASTING
    net_n, left_n = acceleration * train.inertia_kg, limit - abs(effort)
    if 0.0 < effort <= _LITTLE * limit and net_n < 0.0:
        return COASTING
    if left_n > (1.0 - _NOT_FULL) * limit:
        if abs(net_n) <= _CRUISING_SHARE * start_effort:
            return HOLDING
        capped = acceleration >= _NOT_FULL * train.max_acceleration
        if effort > 0.0 and net_n <= _SPARED * left_n and not capped:
            return HOLDING
    return TRACTION if effort > 0.0 else BRAKING


@entry
def measure_runs(train, tables, at_wheel, line, x, w, first, totals, columns):
    """Measure runs, row by row.

    Parameters
    ----------
    train : KernelTrain
    tables : EnergyTables
        By which energy is counted, and the balance where energy is counted at the wheel.
    at_wheel : bool
        Whether energy is counted at the wheel.
    line : ResolvedLine
    x, w : (N,) float64
        Rows of n runs, one behind the other: positions from the origin, m, with all breaks of the line among them, and
        squared speeds, m²/s².
    first : (n + 1,) int64
        Row with which each run begins, and N.
    totals : (n, 7) float64, modified in place
        `_TOTALS` of each run, beyond the first two where its rows are asked for.
    columns : Columns, modified in place
        Of all rows, or of none.
    """
    dark = unpowered(train)
    told = columns.time.shape[0] > 0
    start_effort = mean_effort(train.traction, 0.0, 0.0)
    for run in range(first.shape[0] - 1):
        start = first[run]
        last = first[run + 1] - 1
        step = force = drag = 0
        force_nm, drag_nm = sum_to(line.force, 0, x[start]), sum_to(line.drag, 0, x[start])
        seconds = joules = wheel = braking = drawn = returned = auxiliary = 0.0
        if told:
            columns.time[start] = columns.energy[start] = 0.0
        v1 = math.sqrt(w[start])
        for i in range(start, last):
            d = x[i + 1] - x[i]
            step = piece_from(line.break_m, step, 0.5 * (x[i] + x[i + 1]))
            grade = line.grade_n[step]
            air = line.air[step]
            if not line.even:
                force = piece_from(line.force.knot_m, force, x[i + 1])
                drag = piece_from(line.drag.knot_m, drag, x[i + 1])
                before_nm, force_nm = force_nm, sum_to(line.force, force, x[i + 1])
                grade = (force_nm - before_nm) / d
                before_nm, drag_nm = drag_nm, sum_to(line.drag, drag, x[i + 1])
                air = (drag_nm - before_nm) / d
            supply = line.supply[step]
            here = train if supply == POWERED else dark
            v0, v1 = v1, math.sqrt(w[i + 1])
            duration, work, _, _ = duration_and_work_of(here, d, grade, air, w[i], w[i + 1], v0, v1)
            row = 0.0
            if supply != LOWERED and (told or not at_wheel):
                row = arc_energy(here, tables, d, duration, work, w[i], w[i + 1])
            seconds += duration
            joules += max(work, 0.0) if at_wheel else row
            if told:
                if supply != LOWERED:
                    auxiliary += tables.auxiliary_w * duration
                    row -= tables.auxiliary_w * duration
                wheel += max(work, 0.0)
                braking += max(-work, 0.0)
                drawn += max(row, 0.0)
                returned += max(-row, 0.0)
                effort = work / d
                load = mean_resistance(train, air, v0, v1) + grade
                limit = mean_effort(here.traction, v0, v1) if effort > 0.0 else mean_brake(here, load, v0, v1)
                columns.time[i + 1] = seconds
                columns.energy[i + 1] = joules
                columns.force[i] = effort
                columns.regime[i] = _regime(train, start_effort, effort, 0.5 * (w[i + 1] - w[i]) / d, limit)
        if told:
            columns.force[last] = 0.0
            columns.regime[last] = columns.regime[last - 1]
        one = totals[run]
        one[0], one[1], one[2], one[3], one[4], one[5], one[6] = (
            seconds, joules, wheel, braking, drawn, returned, auxiliary,
        )  # fmt: skip


def measured(trip: Trip, x_m: Floats, w: Floats, first: NDArray[np.int64], columns: Columns) -> Floats:
    """Totals of runs of a trip, (n, 7), with the columns of their rows where there is room for them: `measure_runs`."""
    totals = np.empty((len(first) - 1, _TOTALS))
    at_wheel = trip.energy.kind == "wheel"
    tables = energy_tables(trip.train, PANTOGRAPH if at_wheel else trip.energy)
    measure_runs(kernel_train(trip.train), tables, at_wheel, resolve(trip), x_m, w, first, totals, columns)
    return totals
