"""The mesh of the front method: multipliers are solved by the costate program on it, and runs are driven."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.cores import even_parts, shares, side_by_side
from tgvdp.errors import NumericalError
from tgvdp.line.cells import Cells, cells_between, cells_of, cut, halved
from tgvdp.memory import ask_for
from tgvdp.methods.costate import backward as costate
from tgvdp.methods.costate.blend import LINES, Blend
from tgvdp.methods.costate.descents import parts_on_descents
from tgvdp.methods.costate.extremal import Extremal
from tgvdp.methods.costate.forward import Course
from tgvdp.methods.costate.forward_rows import ON_CURVE
from tgvdp.methods.costate.interpolate import RUN_COLUMNS, Scratch, drive
from tgvdp.methods.costate.room import Room, room_for
from tgvdp.methods.costate.stations import graded_stations
from tgvdp.methods.costate.trend import unit_train_on
from tgvdp.model.trip import Trip
from tgvdp.physics.cell import Rows, overrun
from tgvdp.physics.codes import OK
from tgvdp.physics.energy import EnergyTables, energy_tables
from tgvdp.physics.forces import KernelTrain, kernel_train
from tgvdp.runs.bends import USUAL_ROWS
from tgvdp.runs.fastest import Envelope, envelope_of, within_reach
from tgvdp.runs.profile import Profile

#: Cells per trip at least, within the distance over which starting effort would reach the top speed, and within that
#: over which drag alone leaves 1/e of the squared speed.
_CELLS_PER_TRIP = 100
_CELLS_PER_START = 4
_CELLS_PER_SLOWING = 8
#: Cells between the breaks of a line at most, five times those of a metro on 500 km on its usual mesh: a train
#: that is at its top speed within centimetres gets longer ones.
_MOST_CELLS = 50_000
#: Thinning tolerance of the costate polyline, per cell; smaller where the multiplier is below E/T of the fastest
#: run, because the costates of coasting shrink with it.
_TOLERANCE = 2e-5
#: What the fastest run draws at least, as a share of the kinetic energy at top speed; and least energies as shares of
#: what it draws, or of that kinetic energy.
_LEAST_DRAWN = 1e-3
_LEAST_SHARE = 0.1
#: Squared speed below which costates are not carried, relative to the trip's top: a run over a summit keeps as much
#: there, and loses it where brakes hold it back on the other side.
_FLOOR = 1e-6
#: Memory of a cell, B: its columns twice, the rows of a run through it, and the policies of thirty extremals.
_CELL_B = 2000.0
#: Cells of extremals that are worth a thread of its own, a microsecond each.
_LEAST_CELLS = 450
_NO_POLICIES = np.empty((0, 0, 0))
_NO_BLEND = Blend(*np.empty((4, 0, LINES)))
_NO_KNOWN = np.empty((0, 3))
_NO_TIMES = np.empty(0)


class Run(NamedTuple):
    """A run that is kept: running time in s, energy in J, multiplier in J/s; its rows, from the origin, (n,)."""

    time_s: float
    energy_j: float
    multiplier: float
    x_m: NDArray[np.float64]
    w: NDArray[np.float64]

    def copied(self) -> "Run":
        """The run in rows of its own."""
        return self._replace(x_m=self.x_m.copy(), w=self.w.copy())


@dataclass
class Mesh:
    """Cells of a trip with the envelope of feasible speeds.

    Energies are without auxiliaries, multipliers with them: their power only adds to the price of time, and what they
    do not draw where the pantograph is lowered is taken off the energy. The usual multiplier is the energy for
    traction over the running time of the fastest run, J/s: the scale of multipliers.

    Net energies may be 0: what is a share of an energy is one of ``least_energy_j`` at least, or of ``least_drawn_j``
    where cells are judged, which are dear. Policies have ``lines`` switching speeds at a station.
    """

    trip: Trip
    train: KernelTrain
    tables: EnergyTables
    cells: Cells
    envelope: Envelope
    typical_m: float
    usual_multiplier: float
    least_energy_j: float
    least_drawn_j: float

    def __post_init__(self) -> None:
        inertia_kg = self.train.inertia_kg
        self.low, self.fast = self.envelope.low, self.envelope.fast
        self.unit_cells = self.cells._replace(
            grade_n=self.cells.grade_n / inertia_kg, air=self.cells.air / inertia_kg,
            saved_w=self.cells.saved_w / (self.tables.traction * inertia_kg),
        )  # fmt: skip
        rises = max(self.train.last_rise_mps, self.train.ramps_to_mps) > 0.0 and self.train.last_drop_mps == 0.0
        self.lines = LINES + 2 if rises and self.tables.regeneration > 0.0 else LINES
        self.floor_w = _FLOOR * float(self.fast.max())

    @classmethod
    def of(cls, trip: Trip, fastest: Profile, fineness: float = 1.0, rows: float = USUAL_ROWS) -> "Mesh":
        """Mesh for a trip whose fastest run is known, its cells ``fineness`` times as fine as usual.

        It is driven in ``rows`` times as many rows as motion makes on its own; under brakes, and where drag alone
        brakes a train within a cell, always in the usual ones of a search: next to a comfort limit or a braking rate
        rougher ones are beyond it.
        """
        cell_m = max(_cell_size(trip, fastest) / fineness, trip.distance_m / _MOST_CELLS)
        kinetic_j = 0.5 * trip.train.inertia_kg * float(fastest.speed_mps.max()) ** 2
        balance = fastest.balance
        drawn_j = balance.wheel_j
        if trip.energy.kind != "wheel":
            drawn_j = balance.pantograph_j + balance.regenerated_j - balance.auxiliary_j
        scale_j = max(drawn_j, _LEAST_DRAWN * kinetic_j)  # a run downhill may need no energy at all
        train = kernel_train(trip.train)._replace(rows=rows, other_rows=USUAL_ROWS / rows)
        tables = energy_tables(trip.train, trip.energy)
        if not train.braking[:, 1:].any():
            tables = tables._replace(regeneration=0.0)
        cells = within_reach(trip, cells_between(trip, graded_stations(trip, fastest, cell_m)))
        envelope = _envelope(trip, cells, train)
        mesh = cls(
            trip, train, tables, cells, envelope, cell_m,
            scale_j / fastest.duration_s, _LEAST_SHARE * min(scale_j, kinetic_j), _LEAST_SHARE * scale_j,
        )  # fmt: skip
        return mesh.cut(parts_on_descents(train, cells, mesh.fast)) if tables.regeneration > 0.0 else mesh

    @classmethod
    def along(cls, trip: Trip, x_m: NDArray[np.float64], w: NDArray[np.float64]) -> "Mesh":
        """Mesh of cells as they come, with a run, (n,), for its envelope: for who drives, but searches for nothing."""
        cells = cells_of(trip)
        fast = np.interp(cells.station_m, x_m, w)
        train, envelope = kernel_train(trip.train), Envelope(np.zeros_like(fast), fast, x_m, w)
        tables = energy_tables(trip.train, trip.energy)
        return cls(trip, train, tables, cells, envelope, trip.distance_m, 1.0, 1.0, 1.0)

    def cut(self, parts: NDArray[np.int64]) -> "Mesh":
        """The mesh with its cells cut into so many parts, (K,); the mesh itself where none is cut."""
        return self if (parts == 1).all() else self._on(cut(self.cells, parts))

    @cached_property
    def unit_train(self) -> KernelTrain:
        """The train per unit of inertia, with the trends of its effort curves."""
        return unit_train_on(self.train, self.cells)

    @cached_property
    def finer(self) -> "Mesh":
        """The mesh with all of its cells cut in two."""
        return self._on(halved(self.cells))

    def _on(self, cells: Cells) -> "Mesh":
        """The mesh on other cells."""
        return replace(self, cells=cells, envelope=_envelope(self.trip, cells, self.train))

    @property
    def room(self) -> Room:
        """What this thread writes on this mesh."""
        return room_for(len(self.cells.length_m))

    def switching_speeds(
        self,
        multipliers: NDArray[np.float64],
        policies: NDArray[np.float64],
        least_w: NDArray[np.float64] | None = None,
    ) -> int:
        """Fill in optimal squared switching speeds, (m, K + 1, 4 or 6), for multipliers in J/s, (m,); returns costates.

        Runs below ``least_w``, (m, K + 1), are not looked at.
        """
        low = self.low[np.newaxis].repeat(len(multipliers), axis=0)
        if least_w is not None:
            np.maximum(low, least_w, out=low)
        done, points = costate.switching_speeds(
            self.unit_train, self.tables.regeneration / self.tables.traction, self.unit_cells, low, self.fast,
            self.trip.end_speed_mps**2, multipliers, self.tables.traction * self.train.inertia_kg,
            self.usual_multiplier, _TOLERANCE, self.typical_m, self.floor_w, policies, self.room.costates,
        )  # fmt: skip
        if done < len(multipliers):
            raise NumericalError(f"the costate program lost its way at λ = {multipliers[done]:g} J/s: too many points")
        return int(points)

    @cached_property
    def course(self) -> Course:
        """What the kernel needs to drive; whoever drives first fills in the rides of the envelope."""
        fastest = Rows(self.envelope.x_m, self.envelope.w)
        row = np.searchsorted(fastest.x, self.cells.station_m)
        count = len(self.cells.length_m)
        return Course(self.cells, self.low, self.fast, fastest, row, np.full(count, -1), np.empty((count, 2)))

    def share(self) -> None:
        """Make what threads that drive on it side by side have in common."""
        if self.course.stays[0] < 0:
            self._drive_in(_NO_POLICIES, _NO_POLICIES, np.empty((0, RUN_COLUMNS)))

    def drive(self, policy: NDArray[np.float64], counters: dict[str, int]) -> Run:
        """Drive a policy, (K + 1, 4 or 6), in rows that the next run overwrites; its multiplier is unknown."""
        runs, _, driven = self._driven(policy[np.newaxis])
        counters["runs"] += driven
        n, time_s, energy_j = runs[0, 1:4].tolist()
        x_m, w = self.room.rows
        return Run(time_s, energy_j, math.nan, x_m[: int(n)], w[: int(n)])

    def _driven(self, policies: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
        """Drive policies, (m, K + 1, 4 or 6), each into the rows of the one before it.

        Returns their runs, what they passed, and how many were driven.
        """
        runs, passed = np.empty((len(policies), RUN_COLUMNS)), np.empty((*policies.shape[:2], 3))
        room = self.room
        first = count = 0
        while first < len(policies):
            done, status, driven = self._drive_in(policies[first:], passed[first:], runs[first:])
            count += driven
            if overrun(room.march):
                room.double_march()
                continue
            first += done
            if status != OK:
                room.double_rows()
        return runs, passed, count

    def _drive_in(
        self, policies: NDArray[np.float64], passed: NDArray[np.float64], runs: NDArray[np.float64]
    ) -> tuple[int, int, int]:
        """Call the kernel for policies alone."""
        room = self.room
        scratch = Scratch(room.march, room.passed, _NO_BLEND, room.samples, room.resumed)
        return drive(
            self.train, self.tables, self.course, self.trip.start_speed_mps**2, policies, passed, _NO_KNOWN, _NO_TIMES,
            0.0, _NO_TIMES, 0.0, room.rows, scratch, runs,
        )  # fmt: skip

    def extremal(self, multiplier: float, counters: dict[str, int]) -> Extremal:
        """Solve and drive one multiplier, J/s; infinite is the fastest run, full traction up to the envelope."""
        return self.extremals([multiplier], counters)[0]

    def extremals(
        self, multipliers: Sequence[float], counters: dict[str, int], least_w: NDArray[np.float64] | None = None
    ) -> list[Extremal]:
        """Solve and drive multipliers, J/s, side by side where they are many; the first alone may be infinite.

        Their runs are not sought below squared speeds (m, K + 1).
        """
        numbers = range(len(multipliers))
        parts = even_parts(numbers, shares(len(numbers) * len(self.cells.length_m), _LEAST_CELLS))
        if len(parts) > 1:
            self.share()
        found: list[Extremal] = []
        for extremals, costates, runs in side_by_side(lambda part: self._extremals(multipliers, least_w, part), parts):
            found += extremals
            counters["costates"] += costates
            counters["runs"] += runs
        counters["extremals"] += len(multipliers) - math.isinf(multipliers[0])
        return found

    def _extremals(
        self, multipliers: Sequence[float], least_w: NDArray[np.float64] | None, part: Sequence[int]
    ) -> tuple[list[Extremal], int, int]:
        """Extremals of some neighbouring multipliers, by their numbers, and the costates carried, and runs driven."""
        multipliers = multipliers[part[0] : part[-1] + 1]
        policies = np.empty((len(multipliers), len(self.fast), self.lines))
        first = 0
        if math.isinf(multipliers[0]):
            policies[0] = self.fast[:, np.newaxis]
            policies[0, :, LINES:] = self.train.brakes_from_mps**2
            first = 1
        solved = np.array(multipliers[first:], dtype=np.float64)
        if least_w is not None:
            least_w = least_w[part[0] + first : part[-1] + 1]
        costates = self.switching_speeds(solved, policies[first:], least_w)
        runs, passed, count = self._driven(policies)
        times_s, energies_j = runs[:, 2:4].T.tolist()
        _require_arrival(multipliers, times_s)
        return list(map(Extremal, multipliers, policies, times_s, energies_j, passed)), costates, count

    def optimal_run(self, multiplier: float, counters: dict[str, int]) -> Run:
        """The optimal run of a finite multiplier, J/s, in rows that the next one overwrites."""
        policies = np.empty((1, len(self.fast), self.lines))
        counters["extremals"] += 1
        counters["costates"] += self.switching_speeds(np.array([multiplier], dtype=np.float64), policies)
        run = self.drive(policies[0], counters)
        _require_arrival([multiplier], [run.time_s])
        return run._replace(multiplier=multiplier)


def _require_arrival(multipliers: Sequence[float], times_s: Sequence[float]) -> None:
    if not math.isfinite(sum(times_s)):
        multiplier = next(one for one, time_s in zip(multipliers, times_s, strict=True) if not math.isfinite(time_s))
        raise NumericalError(f"the train of the costate program stalls at λ = {multiplier:g} J/s")


def _envelope(trip: Trip, cells: Cells, train: KernelTrain) -> Envelope:
    """The envelope over cells; where it falls through the speed at which the dynamic brake begins it is that speed."""
    ask_for(_CELL_B * len(cells.length_m), f"a mesh of {len(cells.length_m):,} cells")
    envelope = envelope_of(trip, cells, train)
    begins_w = train.brakes_from_mps**2
    if begins_w == 0.0:
        return envelope
    fast, w = envelope.fast, envelope.w
    return envelope._replace(
        fast=np.where(abs(fast - begins_w) <= ON_CURVE * begins_w, begins_w, fast),
        w=np.where(abs(w - begins_w) <= ON_CURVE * begins_w, begins_w, w),
    )


def _cell_size(trip: Trip, fastest: Profile) -> float:
    """Cell size from the trip's own scales, m: its length, and how fast effort and drag change the train's speed."""
    top_w = float(fastest.speed_mps.max()) ** 2
    start_m = 0.5 * trip.train.inertia_kg * top_w / trip.train.traction_limit.effort_n(0.0)
    drag = trip.train.davis_c_n_per_mps2
    slowed_m = 0.5 * trip.train.inertia_kg / drag if drag > 0.0 else math.inf
    return min(trip.distance_m / _CELLS_PER_TRIP, start_m / _CELLS_PER_START, slowed_m / _CELLS_PER_SLOWING)
