"""Many runs of one trip, side by side: what is asked of each of them takes one call of a kernel, not one per run."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import entry
from tgvdp.line.piecewise import Floats
from tgvdp.line.resolved import resolve
from tgvdp.line.walk import piece_from, sum_to
from tgvdp.model.energy import PANTOGRAPH
from tgvdp.model.track import POWERED
from tgvdp.model.trip import Trip
from tgvdp.physics.arc import duration_and_work_of
from tgvdp.physics.energy import energy_tables
from tgvdp.physics.forces import kernel_train, unpowered
from tgvdp.runs.profile import drawn_on


class Batch(NamedTuple):
    """Rows of n runs, one behind the other.

    Attributes
    ----------
    x_m, w : (N,) float64
        Positions from the origin, m, with all breaks of the line among those of each run, and squared speeds, m²/s².
    first : (n + 1,) int64
        Row with which each run begins, and N.
    """

    x_m: Floats
    w: Floats
    first: NDArray[np.int64]

    @classmethod
    def of(cls, runs: Sequence[tuple[Floats, Floats]]) -> "Batch":
        """Put runs, each its positions and squared speeds, one behind the other."""
        first = np.cumsum([0, *(len(x_m) for x_m, _ in runs)])
        x_m, w = (np.concatenate(columns) for columns in zip(*runs, strict=True))
        return cls(x_m, w, first)

    def runs(self) -> list[tuple[Floats, Floats]]:
        """Positions and squared speeds of each run."""
        ends = pairwise(self.first.tolist())
        return [(self.x_m[start:end], self.w[start:end]) for start, end in ends]


@entry
def total_runs(train, tables, at_wheel, line, x, w, first, time, energy):
    """Fill in running time and energy of each run, as `measure_rows` has them."""
    dark = unpowered(train)
    for run in range(time.shape[0]):
        start = first[run]
        step = force = drag = 0
        force_nm, drag_nm = sum_to(line.force, 0, x[start]), sum_to(line.drag, 0, x[start])
        seconds = joules = 0.0
        v1 = math.sqrt(w[start])
        for i in range(start, first[run + 1] - 1):
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
            seconds += duration
            if at_wheel:
                joules += max(work, 0.0)
            else:
                joules += drawn_on(here, tables, False, supply, d, duration, work, w[i], w[i + 1])[0]
        time[run], energy[run] = seconds, joules


def totals_of(trip: Trip, runs: Batch) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Running times, s, and energies by the trip's model, J, of runs, (n,) float64, as their `profile_of` has them."""
    at_wheel = trip.energy.kind == "wheel"
    tables = energy_tables(trip.train, PANTOGRAPH if at_wheel else trip.energy)
    time_s, energy_j = np.empty((2, len(runs.first) - 1))
    total_runs(kernel_train(trip.train), tables, at_wheel, resolve(trip), *runs, time_s, energy_j)
    return time_s, energy_j
