"""One mesh of the generic refinement: cells, the envelope of feasible runs, and the improvement of runs on it."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.cells import Cells, breaks_of, cells_of
from tgvdp.memory import ask_for
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.costate.multipliers import OutOfTime
from tgvdp.methods.refine.hold import hold
from tgvdp.methods.refine.kernel import blend, envelope_kernel, measure
from tgvdp.methods.refine.pulse_and_glide import MOST_PULSES, switch
from tgvdp.methods.refine.sweep import Scratch, descend
from tgvdp.model.trip import Trip
from tgvdp.physics.cell import Rows
from tgvdp.physics.energy import EnergyTables, energy_tables
from tgvdp.physics.forces import KernelTrain, kernel_train
from tgvdp.runs.profile import Profile

#: Speeds above and below the incumbent in the first program of a run, from standstill to the fastest run.
WIDEST = 24
#: ... and in all others.
HALF = 2
#: Memory of a station, B: the choice at each of its speeds, arcs between the usual ones with their names, its columns.
_STATION_B = 2.0 * (2 * WIDEST + 1) + 16.0 * (2 * HALF + 1) ** 2 + 100.0
#: Sweeps with one step at most, and from one step to the next finer one. Of a program of all speeds there is nothing
#: left to improve.
_PASSES = 60
SHRINK = 0.4
#: Arcs between two looks at the clock, if one sweep has no more: a quarter of a second.
_ARCS_AT_ONCE = 2_000_000
#: Programs of a sweep that holds a time, about.
_TRIALS = 5
#: Rows nearer to a station than this share of its cell make no station.
_SLIVER = 1e-3


def mesh_for(trip: Trip, fastest: Profile, fineness: float) -> Mesh:
    """Mesh of the front method; its first and last cells are cut at the rows of the fastest run.

    Next to standstill the duration of a cell hangs on small changes of effort, which those rows follow.
    """
    mesh = Mesh.of(trip, fastest, fineness)
    station_m, rows_m = mesh.cells.station_m, fastest.position_m - trip.origin_m
    at = np.searchsorted(station_m, rows_m).clip(1, len(station_m) - 1)
    share = (rows_m - station_m[at - 1]) / mesh.cells.length_m[at - 1]
    inside = ((at == 1) | (at == len(station_m) - 1)) & (share > _SLIVER) & (share < 1.0 - _SLIVER)
    cells = cells_of(trip, np.union1d(station_m, rows_m[inside]))
    return replace(mesh, cells=cells._replace(limit_w=np.minimum(cells.limit_w, 4.0 * float(mesh.fast.max()))))


class Level:
    """A mesh on which a run is one squared speed per station, with one arc per cell.

    Attributes
    ----------
    cells : Cells
    low, fast : (K + 1,) float64
        Slowest and fastest feasible squared speeds, runs themselves.
    top_w : float
        Largest of them.
    """

    def __init__(self, trip: Trip, train: KernelTrain, cells: Cells) -> None:
        self.trip, self.train, self.cells = trip, train, cells
        n = len(cells.station_m)
        ask_for(_STATION_B * n, f"a refinement on {n:,} stations")
        self.low, self.fast = np.empty(n), np.empty(n)
        ends_w = trip.start_speed_mps**2, trip.end_speed_mps**2
        envelope_kernel(train, cells, *ends_w, self.low, self.fast)
        self.top_w = float(self.fast.max())
        self._scratch = Scratch.of(n, 2 * WIDEST + 1, 2 * HALF + 1)

    def measured(self, tables: EnergyTables, w: NDArray[np.float64]) -> tuple[float, float]:
        """Time in s and energy in J of a run; an infinite energy where it is not feasible."""
        time_s, energy_j, feasible = measure(self.train, tables, self.cells, w)
        return time_s, energy_j if feasible else math.inf

    def switched(
        self, tables: EnergyTables, relaxed: EnergyTables, w: NDArray[np.float64]
    ) -> tuple[float, float, NDArray[np.float64], NDArray[np.float64]]:
        """Drive a run of the relaxed problem by the map's own efforts: time, energy, and its rows (position, v²)."""
        rows = Rows(*np.empty((2, 2 * MOST_PULSES * len(w))))
        n, time_s, energy_j = switch(self.train, tables, relaxed, self.cells, w, rows)
        return time_s, energy_j, rows.x[:n].copy(), rows.w[:n].copy()  # runs do not keep the room for all pulses

    def descend(
        self,
        tables: EnergyTables,
        multiplier: float,
        w: NDArray[np.float64],
        half: int,
        first: float,
        last: float,
        clock: Clock,
    ) -> int:
        """Improve a run in place with steps from ``first`` to ``last``, shares of the largest v²; returns sweeps.

        Raises
        ------
        OutOfTime
            When the time is up; the run is feasible then, too.
        """
        sweeps, cost, step = 0, math.inf, first * self.top_w
        passes = _PASSES if half < WIDEST else 1
        at_once = max(1, _ARCS_AT_ONCE // (len(w) * (2 * half + 1) ** 2))
        while True:
            left, stationary = passes, False
            while left and not stationary:
                if clock.expired:
                    raise OutOfTime
                done, cost, stationary = descend(
                    self.train, tables, self.cells, self.low, self.fast, multiplier, half, step, cost,
                    min(left, at_once), w, w.copy(), self._scratch,
                )  # fmt: skip
                left -= done
            sweeps += passes - left
            step *= SHRINK
            if step < last * self.top_w:
                return sweeps

    def hold(
        self,
        tables: EnergyTables,
        multiplier: float,
        w: NDArray[np.float64],
        target_s: float,
        first: float,
        last: float,
        clock: Clock,
    ) -> tuple[int, float]:
        """Improve a run that keeps its time in place, as `descend`; returns sweeps, and the multiplier of that time."""
        sweeps, step = 0, first * self.top_w
        at_once = max(1, _ARCS_AT_ONCE // (_TRIALS * len(w) * (2 * HALF + 1) ** 2))
        while step >= last * self.top_w:
            left, stationary, cost = _PASSES, False, math.inf
            while left and not stationary:
                if clock.expired:
                    raise OutOfTime
                done, multiplier, cost, stationary = hold(
                    self.train, tables, self.cells, self.low, self.fast, multiplier, HALF, step, target_s, cost,
                    min(left, at_once), w, w.copy(), self._scratch,
                )  # fmt: skip
                left -= done
            sweeps += _PASSES - left
            step *= SHRINK
        return sweeps, multiplier

    def blend(self, first: NDArray[np.float64], second: NDArray[np.float64], share: float) -> NDArray[np.float64]:
        """Run between two runs, cut to what is feasible."""
        w = np.empty_like(self.fast)
        blend(self.train, self.cells, self.low, self.fast, first, second, share, w)
        return w

    def carried(self, other: "Level", w: NDArray[np.float64]) -> NDArray[np.float64]:
        """A run of another level on the stations of this one: v² is linear along an arc."""
        return self.followed(other.cells.station_m, w)

    def followed(self, x_m: NDArray[np.float64], w: NDArray[np.float64]) -> NDArray[np.float64]:
        """Run nearest to rows: positions from the origin, m, and squared speeds, m²/s²."""
        here = np.interp(self.cells.station_m, x_m, w)
        return self.blend(here, here, 0.0)

    def coarser(self, tables: EnergyTables, every: int) -> "Level | None":
        """The same trip on every so-many-th station and all breaks; None where its fastest run is not feasible."""
        kept_m = np.union1d(breaks_of(self.trip), self.cells.station_m[::every])
        cells = cells_of(self.trip, kept_m)
        top_w = float(self.cells.limit_w.max())
        level = Level(self.trip, self.train, cells._replace(limit_w=np.minimum(cells.limit_w, top_w)))
        return level if math.isfinite(level.measured(tables, level.fast)[1]) else None


def hold_fastest(trip: Trip) -> None:
    """Improve a run at its own time, in vain: all kernels are called, as where times jump, and no search is needed."""
    level = Level(trip, kernel_train(trip.train), cells_of(trip))
    tables, clock = energy_tables(trip.train, trip.energy), SearchBudget().start()
    level.hold(tables, 1.0, level.fast.copy(), math.inf, 1.0, 1.0, clock)
