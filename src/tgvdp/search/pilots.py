"""Pilots of the front method: multipliers that are solved by the costate program and driven, on one mesh."""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import TgvdpError
from tgvdp.line.cells import Cells, cells_of
from tgvdp.line.fastest import envelope_of, reachable_w
from tgvdp.line.stations import graded_stations
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import energy_tables
from tgvdp.physics.forces import KernelTrain, kernel_train
from tgvdp.physics.profile import Profile
from tgvdp.search import costate
from tgvdp.search.drive import Course, drive

#: Cells per trip at least, and cells within the distance over which starting effort would reach the top speed.
_CELLS_PER_TRIP = 100
_CELLS_PER_START = 4
#: Thinning tolerance of the costate polyline, per cell; smaller where the price of time is below E/T of the fastest
#: run, because the costates of coasting shrink with it.
_TOLERANCE = 5e-5
#: Squared speed below which costates are not carried, relative to the trip's top.
_FLOOR = 1e-4


def _per_kilogram(train: KernelTrain) -> KernelTrain:
    """The same train with all forces per unit of inertia."""
    per_kg = 1.0 / train.inertia_kg
    scale = np.array([1.0, *(per_kg,) * 5])
    return train._replace(
        inertia_kg=1.0,
        davis_a_n=train.davis_a_n * per_kg,
        davis_b=train.davis_b * per_kg,
        traction=train.traction * scale,
        braking=train.braking * scale,
        friction_n=train.friction_n * per_kg,
        rates=train.rates * scale,
    )


class Sample(NamedTuple):
    """A blend of two policies that was driven: the share of the second one, and its running time in s."""

    share: float
    time_s: float


class Blend(NamedTuple):
    """The last blend that was driven: its rows, running time in s, energy in J, share, and the bracket it leaves."""

    rows: int
    time_s: float
    energy_j: float
    share: float
    lo: float
    hi: float


@dataclass
class Mesh:
    """Cells of a trip with the envelope of feasible speeds and room for the rows of one run.

    Energies and prices are without auxiliaries: their power only adds to the price of time. The usual price is the
    energy for traction over the running time of the fastest run, J/s: the scale of multipliers.
    """

    trip: Trip
    train: KernelTrain
    cells: Cells
    low: NDArray[np.float64]
    fast: NDArray[np.float64]
    fastest_rows: tuple[NDArray[np.float64], NDArray[np.float64]]
    typical_m: float
    usual_price: float
    rows: tuple[NDArray[np.float64], NDArray[np.float64]] = field(init=False)
    scratch: tuple[NDArray[np.float64], NDArray[np.float64]] = field(init=False)
    room: NDArray[np.float64] = field(init=False)

    def __post_init__(self) -> None:
        inertia_kg = self.train.inertia_kg
        self.unit_train = _per_kilogram(self.train)
        self.unit_grade, self.unit_air = self.cells.grade_n / inertia_kg, self.cells.air / inertia_kg
        self.top_w = float(self.fast.max())
        self.flat_out = np.column_stack((self.fast,) * 3)
        tables = energy_tables(self.trip.train, self.trip.energy)
        brakes = bool(self.train.braking[:, 1:].any())
        self.drawn, self.returned = tables.traction, tables.regeneration if brakes else 0.0
        size = 24 * len(self.cells.length_m) + 8192
        self.rows = (np.empty(size), np.empty(size))
        self.scratch = (np.empty(4096), np.empty(4096))
        self.room = np.empty((4, costate.ROOM))

    @classmethod
    def of(cls, trip: Trip, fastest: Profile, fineness: float = 1.0) -> "Mesh":
        """Mesh for a trip whose fastest run is known, its cells ``fineness`` times as fine as usual."""
        train = kernel_train(trip.train)
        cell_m = _cell_size(trip, fastest) / fineness
        cells = cells_of(trip, graded_stations(trip, fastest, cell_m))
        low, fast, *fastest_rows = envelope_of(trip, cells, train)
        cells = cells._replace(limit_w=np.minimum(cells.limit_w, reachable_w(trip, cells)))
        # A run downhill may need no energy at all.
        least_j = 5e-4 * train.inertia_kg * float(fastest.speed_mps.max()) ** 2
        balance = fastest.balance
        drawn_j = balance.wheel_j
        if trip.energy.kind != "wheel":
            drawn_j = balance.pantograph_j + balance.regenerated_j - balance.auxiliary_j
        usual_price = max(drawn_j, least_j) / fastest.duration_s
        return cls(trip, train, cells, low, fast, (fastest_rows[0], fastest_rows[1]), cell_m, usual_price)

    def _switching_speeds(self, price: float, counters: dict[str, int]) -> NDArray[np.float64]:
        """Optimal squared switching speeds, (K + 1, 2), for a multiplier in J/s."""
        cells = self.cells
        switch = np.empty_like(self.flat_out)
        tolerance = _TOLERANCE * min(1.0, price / self.usual_price)
        status, points = costate.switching_speeds(
            self.unit_train, self.returned / self.drawn, cells.length_m, self.unit_grade, self.unit_air, self.low,
            self.fast, self.trip.end_speed_mps**2, price / (self.drawn * self.train.inertia_kg), tolerance,
            self.typical_m, _FLOOR * self.top_w, switch, self.room,
        )  # fmt: skip
        counters["pilots"] += 1
        counters["costates"] += points
        if status != costate.DONE:
            raise TgvdpError(f"the costate program lost its way at λ = {price:g} J/s (status {status}); please report")
        return switch

    @cached_property
    def course(self) -> Course:
        """What the kernel needs to drive, made once; the kernel adds the rides when it first drives."""
        count = len(self.cells.length_m)
        x_m, w = self.fastest_rows
        row = np.searchsorted(x_m, self.cells.station_m)
        rides = np.zeros(count, dtype=np.int64), np.full(count, np.nan), np.full(count, np.nan)
        return Course(*self.cells[:5], self.low, self.fast, x_m, w, row, *rides)

    def drive(
        self, first: NDArray[np.float64], second: NDArray[np.float64], share: float, counters: dict[str, int]
    ) -> tuple[int, float, float]:
        """Drive a blend of two policies into `rows`; returns rows, running time in s, energy in J."""
        never = Sample(share, math.inf)
        return self.meet(first, second, share, 0.0, 0.0, (never, never), counters)[:3]

    def meet(
        self,
        first: NDArray[np.float64],
        second: NDArray[np.float64],
        share: float,
        target_s: float,
        tolerance_s: float,
        bracket: tuple["Sample", "Sample"],
        counters: dict[str, int],
    ) -> "Blend":
        """Drive blends of two policies into `rows` until one takes a given time, from a first share on.

        The bracket holds a faster and a slower blend.
        """
        (lo, lo_s), (hi, hi_s) = bracket
        while True:
            *run, runs = drive(
                self.train, self.drawn, self.returned, self.course, self.trip.start_speed_mps**2, first, second, share,
                target_s, tolerance_s, lo, lo_s, hi, hi_s, *self.rows, *self.scratch,
            )  # fmt: skip
            counters["runs"] += runs
            if run[0] > 0:
                return Blend(*run)
            size = 2 * len(self.rows[0])
            self.rows = (np.empty(size), np.empty(size))

    def pilot(self, price: float, counters: dict[str, int]) -> "Pilot":
        """Solve and drive one multiplier, J/s; infinite is the fastest run, full traction up to the envelope."""
        switch = self.flat_out if math.isinf(price) else self._switching_speeds(price, counters)
        _, time_s, energy_j = self.drive(switch, switch, 0.0, counters)
        if not math.isfinite(time_s):
            raise TgvdpError(f"the train of the costate program stalls at λ = {price:g} J/s; please report")
        return Pilot(price, switch, time_s, energy_j)


@dataclass(frozen=True, eq=False)
class Pilot:
    """A solved multiplier: price λ in J/s, its switching speeds (K + 1, 2), running time in s and energy in J."""

    price: float
    switch: NDArray[np.float64]
    time_s: float
    energy_j: float

    def cost_j(self, price: float) -> float:
        """Cost E + λT of this run at a multiplier in J/s."""
        return self.energy_j + price * self.time_s


def _cell_size(trip: Trip, fastest: Profile) -> float:
    """Cell size from the trip's own scales, m: its length, and how fast the train gains speed."""
    top_w = float(fastest.speed_mps.max()) ** 2
    start_m = 0.5 * trip.train.inertia_kg * top_w / trip.train.traction_limit.effort_n(0.0)
    return min(trip.distance_m / _CELLS_PER_TRIP, start_m / _CELLS_PER_START)
