"""Pilots of the front method: multipliers that are solved by the costate program and driven, on one mesh."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import TgvdpError
from tgvdp.line.cells import Cells, cells_of
from tgvdp.line.fastest import envelope_of, reachable_w
from tgvdp.line.stations import graded_stations
from tgvdp.model.trip import Trip
from tgvdp.physics.forces import KernelTrain, kernel_train
from tgvdp.physics.profile import Profile
from tgvdp.search import costate
from tgvdp.search.drive import drive

#: Cells per trip at least, and cells within the distance over which starting effort would reach the top speed.
_CELLS_PER_TRIP = 100
_CELLS_PER_START = 4
#: Thinning tolerance of the costate polyline, per cell; smaller where the price of time is below E/T of the fastest
#: run, because the costates of coasting shrink with it.
_TOLERANCE = 5e-5
#: Squared speed below which costates are not carried, relative to the trip's top.
_FLOOR = 1e-4


@dataclass
class Mesh:
    """Cells of a trip with the envelope of feasible speeds and room for the rows of one run.

    The usual price is energy over running time of the fastest run, J/s: the scale of multipliers.
    """

    trip: Trip
    train: KernelTrain
    cells: Cells
    low: NDArray[np.float64]
    fast: NDArray[np.float64]
    typical_m: float
    usual_price: float
    rows: tuple[NDArray[np.float64], NDArray[np.float64]] = field(init=False)
    scratch: tuple[NDArray[np.float64], NDArray[np.float64]] = field(init=False)

    def __post_init__(self) -> None:
        size = 24 * len(self.cells.length_m) + 8192
        self.rows = (np.empty(size), np.empty(size))
        self.scratch = (np.empty(4096), np.empty(4096))

    @classmethod
    def of(cls, trip: Trip, fastest: Profile, fineness: float = 1.0) -> "Mesh":
        """Mesh for a trip whose fastest run is known, its cells ``fineness`` times as fine as usual."""
        train = kernel_train(trip.train)
        cell_m = _cell_size(trip, fastest) / fineness
        cells = cells_of(trip, graded_stations(trip, fastest, cell_m))
        low, fast, _, _ = envelope_of(trip, cells, train)
        top_w = float(fast.max())
        cells = cells._replace(limit_w=np.minimum(cells.limit_w, reachable_w(trip, cells)))
        least_j = 5e-4 * train.inertia_kg * top_w  # a run downhill may need no energy at all
        usual_price = max(fastest.total_energy_j, least_j) / fastest.duration_s
        return cls(trip, train, cells, low, fast, cell_m, usual_price)

    def _switching_speeds(self, price: float, counters: dict[str, int]) -> NDArray[np.float64]:
        """Optimal squared switching speeds, (K + 1,), for a multiplier in J/s."""
        cells = self.cells
        switch = np.empty_like(self.fast)
        tolerance = _TOLERANCE * min(1.0, price / self.usual_price)
        status, points = costate.switching_speeds(
            self.train, cells.length_m, cells.grade_n, cells.air, cells.supply, self.low, self.fast, self.trip.end_speed_mps**2,
            price / self.train.inertia_kg, tolerance, self.typical_m, _FLOOR * float(self.fast.max()), switch,
        )  # fmt: skip
        counters["pilots"] += 1
        counters["costates"] += points
        if status != costate.DONE:
            raise TgvdpError(f"the costate program lost its way at λ = {price:g} J/s (status {status}); please report")
        return switch

    def drive(
        self, first: NDArray[np.float64], second: NDArray[np.float64], share: float, counters: dict[str, int]
    ) -> tuple[int, float, float]:
        """Drive a blend of two policies into `rows`; returns rows, running time in s, energy in J."""
        counters["runs"] += 1
        while True:
            n, time_s, energy_j = drive(
                self.train, *self.cells, self.low, self.fast, self.trip.start_speed_mps**2,
                first, second, share, *self.rows, *self.scratch,
            )  # fmt: skip
            if n > 0:
                return n, time_s, energy_j
            size = 2 * len(self.rows[0])
            self.rows = (np.empty(size), np.empty(size))

    def pilot(self, price: float, counters: dict[str, int]) -> "Pilot":
        """Solve and drive one multiplier, J/s; infinite is the fastest run, full traction up to the envelope."""
        switch = self.fast if math.isinf(price) else self._switching_speeds(price, counters)
        _, time_s, energy_j = self.drive(switch, switch, 0.0, counters)
        if not math.isfinite(time_s):
            raise TgvdpError(f"the train of the costate program stalls at λ = {price:g} J/s; please report")
        return Pilot(price, switch, time_s, energy_j)


@dataclass(frozen=True)
class Pilot:
    """A solved multiplier: price λ in J/s, its switching speeds (K + 1,), running time in s and energy in J."""

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
    start_m = 0.5 * trip.train.inertia_kg * top_w / trip.train.traction.effort_n(0.0)
    return min(trip.distance_m / _CELLS_PER_TRIP, start_m / _CELLS_PER_START)
