"""The mesh of the front method: multipliers are solved by the costate program on it, and runs are driven."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import NumericalError
from tgvdp.line.cells import Cells, cells_of
from tgvdp.memory import ask_for
from tgvdp.methods.costate import backward as costate
from tgvdp.methods.costate.blend import Blend
from tgvdp.methods.costate.extremal import Extremal, ends_of
from tgvdp.methods.costate.forward import Course
from tgvdp.methods.costate.interpolate import RUN_COLUMNS, SAMPLES, drive
from tgvdp.methods.costate.stations import graded_stations
from tgvdp.model.trip import Trip
from tgvdp.physics.cell import Rows, overrun, room_for_marches, room_for_rows
from tgvdp.physics.codes import NO_ROOM, NOT_MET, OK
from tgvdp.physics.energy import energy_tables
from tgvdp.physics.forces import KernelTrain, kernel_train, per_kilogram
from tgvdp.runs.fastest import envelope_of, reachable_w
from tgvdp.runs.profile import Profile

#: Cells per trip at least, and cells within the distance over which starting effort would reach the top speed.
_CELLS_PER_TRIP = 100
_CELLS_PER_START = 4
#: Cells between the breaks of a line at most, five times those of a metro on 500 km on its usual mesh: a train
#: that is at its top speed within centimetres gets longer ones.
_MOST_CELLS = 50_000
#: Thinning tolerance of the costate polyline, per cell; smaller where the multiplier is below E/T of the fastest
#: run, because the costates of coasting shrink with it.
_TOLERANCE = 2e-5
#: Times as many rows as motion makes on its own where a limit of effort binds: a run's time is right to 1e-6 then.
_ROWS = 4.0
#: Rows of one march for which there is room at first.
_MARCH_ROWS = 4096
#: Squared speed below which costates are not carried, relative to the trip's top.
_FLOOR = 1e-4
#: Memory of a cell, B: its columns twice, the rows of a run through it, and the policies of thirty extremals.
_CELL_B = 2000.0
_NO_ENDS = np.full(6, np.inf)
_NO_TARGET = np.full(1, np.nan)


class Run(NamedTuple):
    """A run that is kept: running time in s, energy in J, multiplier in J/s; its rows, from the origin, (n,)."""

    time_s: float
    energy_j: float
    multiplier: float
    x_m: NDArray[np.float64]
    w: NDArray[np.float64]


class Interval:
    """Two neighbouring extremals, and the blends of them that were driven: shares and running times, in order."""

    def __init__(self, before: Extremal, after: Extremal, blend: Blend) -> None:
        self.before = before
        self.after = after
        self.blend = blend
        self.ends = ends_of(before, after)
        self.samples = np.empty((SAMPLES, 2))
        self.samples[:2] = (0.0, before.time_s), (1.0, after.time_s)
        self.known = 2
        #: Shares between which the running time jumps, where it does.
        self.bracket = (0.0, 1.0)


@dataclass
class Mesh:
    """Cells of a trip with the envelope of feasible speeds and room for the rows of one run.

    Energies are without auxiliaries, multipliers with them: their power only adds to the price of time, and what they
    do not draw where the pantograph is lowered is taken off the energy. The usual multiplier is the energy for
    traction over the running time of the fastest run, J/s: the scale of multipliers.
    """

    trip: Trip
    train: KernelTrain
    cells: Cells
    low: NDArray[np.float64]
    fast: NDArray[np.float64]
    fastest_rows: tuple[NDArray[np.float64], NDArray[np.float64]]
    typical_m: float
    usual_multiplier: float

    def __post_init__(self) -> None:
        inertia_kg = self.train.inertia_kg
        self.tables = energy_tables(self.trip.train, self.trip.energy)
        self.unit_train = per_kilogram(self.train)
        self.unit_cells = self.cells._replace(
            grade_n=self.cells.grade_n / inertia_kg, air=self.cells.air / inertia_kg,
            saved_w=self.cells.saved_w / (self.tables.traction * inertia_kg),
        )  # fmt: skip
        self.floor_w = _FLOOR * float(self.fast.max())
        self.flat_out = np.column_stack((self.fast,) * 4)
        if not self.train.braking[:, 1:].any():
            self.tables = self.tables._replace(regeneration=0.0)
        self.size = 24 * len(self.cells.length_m) + 8192
        self.rows = room_for_rows(self.size)
        self.kept, self.stored = Rows(*np.empty((2, 0))), 0
        self.scratch = room_for_marches(_MARCH_ROWS)
        self.samples = np.empty((SAMPLES, 2))
        self.runs = np.empty((1, RUN_COLUMNS))
        self.room = np.empty((6, costate.ROOM))

    @classmethod
    def of(cls, trip: Trip, fastest: Profile, fineness: float = 1.0) -> "Mesh":
        """Mesh for a trip whose fastest run is known, its cells ``fineness`` times as fine as usual."""
        cell_m = max(_cell_size(trip, fastest) / fineness, trip.distance_m / _MOST_CELLS)
        # A run downhill may need no energy at all.
        least_j = 5e-4 * trip.train.inertia_kg * float(fastest.speed_mps.max()) ** 2
        balance = fastest.balance
        drawn_j = balance.wheel_j
        if trip.energy.kind != "wheel":
            drawn_j = balance.pantograph_j + balance.regenerated_j - balance.auxiliary_j
        usual_multiplier = max(drawn_j, least_j) / fastest.duration_s
        return cls._on(trip, graded_stations(trip, fastest, cell_m), cell_m, usual_multiplier)

    @classmethod
    def _on(cls, trip: Trip, stations_m: NDArray[np.float64], typical_m: float, usual_multiplier: float) -> "Mesh":
        ask_for(_CELL_B * len(stations_m), f"a mesh of {len(stations_m):,} cells")
        train = kernel_train(trip.train)._replace(rows=_ROWS)
        cells = cells_of(trip, stations_m)
        low, fast, *fastest_rows = envelope_of(trip, cells, train)
        cells = cells._replace(limit_w=np.minimum(cells.limit_w, reachable_w(trip, cells)))
        return cls(trip, train, cells, low, fast, (fastest_rows[0], fastest_rows[1]), typical_m, usual_multiplier)

    def halved(self, which: NDArray[np.bool_]) -> "Mesh":
        """The mesh with some of its cells, (K,), cut in two."""
        middle_m = self.cells.station_m[:-1][which] + 0.5 * self.cells.length_m[which]
        stations_m = np.concatenate((self.cells.station_m, middle_m))
        return Mesh._on(self.trip, stations_m, self.typical_m, self.usual_multiplier)

    def _switching_speeds(self, multiplier: float, counters: dict[str, int]) -> NDArray[np.float64]:
        """Optimal squared switching speeds, (K + 1, 4), for a multiplier in J/s."""
        inertia_kg = self.train.inertia_kg
        switch = np.empty_like(self.flat_out)
        tolerance = _TOLERANCE * min(1.0, multiplier / self.usual_multiplier)
        status, points = costate.switching_speeds(
            self.unit_train, self.tables.regeneration / self.tables.traction, self.unit_cells, self.low, self.fast,
            self.trip.end_speed_mps**2, multiplier / (self.tables.traction * inertia_kg), tolerance, self.typical_m,
            self.floor_w, switch, self.room,
        )  # fmt: skip
        counters["extremals"] += 1
        counters["costates"] += points
        if status != OK:
            raise NumericalError(f"the costate program lost its way at λ = {multiplier:g} J/s (status {status})")
        return switch

    @cached_property
    def course(self) -> Course:
        """What the kernel needs to drive, made once; the kernel adds the rides when it first drives."""
        row = np.searchsorted(self.fastest_rows[0], self.cells.station_m)
        fastest = Rows(*np.array(self.fastest_rows))
        count = len(self.cells.length_m)
        ride, passed = np.empty((count, 2)), np.empty((count + 1, 3))
        return Course(self.cells, self.low, self.fast, fastest, row, np.full(count, -1), ride, passed)

    def drive(self, policy: NDArray[np.float64], counters: dict[str, int]) -> tuple[int, float, float]:
        """Drive a policy into `rows`; returns rows, running time in s, energy in J."""
        self.samples[0, 0] = 0.0
        while True:
            _, status, _, driven = drive(
                self.train, self.tables, self.course, self.trip.start_speed_mps**2, Blend(policy, policy, policy),
                _NO_ENDS, math.inf, 0.0, self.samples, 1, _NO_TARGET, 0.0, self.rows, 0, self.scratch, self.runs,
            )  # fmt: skip
            counters["runs"] += driven
            if overrun(self.scratch):
                self._double_scratch()
            elif status == OK:
                return int(self.runs[0, 1]), self.runs[0, 2], self.runs[0, 3]
            else:
                self.rows = room_for_rows(2 * len(self.rows.x))

    def meet(
        self,
        interval: Interval,
        target_s: NDArray[np.float64],
        tolerance_s: float,
        loss: float,
        least_loss_j: float,
        counters: dict[str, int],
    ) -> tuple[list[Run], int]:
        """Drive blends of two extremals that take given times; returns them, and why they end before the last, or OK.

        ``loss`` and ``least_loss_j`` are those of `interpolate.drive`.
        """
        found: list[Run] = []
        runs = np.empty((len(target_s), RUN_COLUMNS))
        while True:
            rows = self.kept
            done, status, interval.known, driven = drive(
                self.train, self.tables, self.course, self.trip.start_speed_mps**2,
                interval.blend, interval.ends, loss, least_loss_j, interval.samples,
                interval.known, target_s[len(found) :], tolerance_s, rows, self.stored, self.scratch, runs,
            )  # fmt: skip
            counters["runs"] += driven
            if overrun(self.scratch):
                self._double_scratch()
                continue
            for first, last, time_s, energy_j, multiplier, *_ in runs[:done].tolist():
                kept = slice(int(first), int(last))
                found.append(Run(time_s, energy_j, multiplier, rows.x[kept], rows.w[kept]))
                self.stored = int(last)
            if status != NO_ROOM:
                if status == NOT_MET:
                    interval.bracket = (runs[done, 5], runs[done, 6])
                return found, status
            if not done:
                self.size *= 2
            self.kept, self.stored = room_for_rows(self.size), 0

    def _double_scratch(self) -> None:
        self.scratch = room_for_marches(2 * len(self.scratch.x))

    def extremal(self, multiplier: float, counters: dict[str, int]) -> Extremal:
        """Solve and drive one multiplier, J/s; infinite is the fastest run, full traction up to the envelope."""
        switch = self.flat_out if math.isinf(multiplier) else self._switching_speeds(multiplier, counters)
        _, time_s, energy_j = self.drive(switch, counters)
        if not math.isfinite(time_s):
            raise NumericalError(f"the train of the costate program stalls at λ = {multiplier:g} J/s")
        return Extremal(multiplier, switch, time_s, energy_j, self.course.passed.copy())


def _cell_size(trip: Trip, fastest: Profile) -> float:
    """Cell size from the trip's own scales, m: its length, and how fast the train gains speed."""
    top_w = float(fastest.speed_mps.max()) ** 2
    start_m = 0.5 * trip.train.inertia_kg * top_w / trip.train.traction_limit.effort_n(0.0)
    return min(trip.distance_m / _CELLS_PER_TRIP, start_m / _CELLS_PER_START)
