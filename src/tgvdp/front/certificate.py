"""Certificates: a lower bound of the least energy of the continuous problem at given running times.

For a multiplier λ and any costate p(s), every run satisfies E + λT ≥ B(λ, p) (`front.bounds`). That is a line in the
(T, E) plane which no run of the continuous problem passes under: E ≥ B − λT. A certificate is the upper envelope of
such lines. A poor λ or p only loosens it. See docs/certificate.md for the derivation and for what is proven.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import TgvdpError
from tgvdp.front.bounds import bound_kernel
from tgvdp.front.costates import integrate_costates
from tgvdp.front.phases import count_cells, cut_rows, label_cells, row_efforts, thin_rows, tidy_labels
from tgvdp.front.pieces import PIECE_COLUMNS
from tgvdp.line.cells import Cells, cells_of
from tgvdp.line.fastest import reachable_w
from tgvdp.model.checks import require_number
from tgvdp.model.trip import Trip
from tgvdp.physics.forces import KernelTrain, kernel_train
from tgvdp.physics.profile import Profile
from tgvdp.search.pilots import Mesh

_Floats = NDArray[np.float64]

#: Cells of a bound per trip at least.
_CELLS_PER_TRIP = 300
#: Rows of a run that are nearer to each other than this share of the trip, or to a break of the line, are one.
_SAME_PLACE = 1e-8
#: Phases shorter than this share of the trip are rounding errors.
_SLIVER = 1e-6
#: Squared speed inside a trip, relative to the top, below which a costate is not integrated.
_SLOWEST = 1e-8
#: The pilots of a front's certificate are solved on a mesh this much finer than the front's.
_FINENESS = 4.0
#: Multipliers of a front's certificate at most, and those tried beyond the largest one, for the fastest run.
_MOST_LINES = 64
_STEEPER = (1.1, 1.3, 1.7, 2.5, 4.0, 6.0, 10.0, 16.0, 25.0, 40.0)
#: Between multipliers further apart than this factor another one is solved: a line may be poor where T(λ) jumps.
_APART = 1.1
#: Multipliers tried where a run has an infinite one, relative to its energy over its time.
_STEEP = (3.0, 10.0, 30.0, 100.0)
#: Energy below this share of the kinetic energy at the top speed is a rounding error of none.
_NO_ENERGY = 1e-9
#: A few roundings of one multiplication each.
_ROUNDING = 8.0 * 2.0**-53


@dataclass(frozen=True)
class Bound:
    """Lower bound of the least energy at one running time, J, and how far above it the energy is, in percent of it."""

    lower_bound_j: float
    gap_pct: float


@dataclass(frozen=True, eq=False)
class Certificate:
    """Lower bounds of the least energy of the continuous problem, for the points of a front and everywhere else.

    Attributes
    ----------
    lower_bound_j, gap_pct : (n,) float64
        For each point: the bound at its running time, and how far its energy is above, in percent of the energy.
    price_j_per_s, line_j : (m,) float64
        The lines behind it: E ≥ line_j − price_j_per_s·T for every run.
    """

    lower_bound_j: _Floats
    gap_pct: _Floats
    price_j_per_s: _Floats
    line_j: _Floats

    def at(self, time_s: float) -> float:
        """Lower bound of the energy of every run that takes a given time or less, J."""
        return float(_envelope(np.array([time_s]), self.price_j_per_s, self.line_j)[0])


class Ledger(NamedTuple):
    """How one bound came about, per unit of inertia: E + λT ≥ inertia·(total − error).

    Attributes
    ----------
    total, error : float
        The bound, and a bound of its rounding error.
    bound : (K,) float64
        Lower bound of each cell; they sum to the total.
    left, right : (K,) float64
        Costate at the two ends of each cell.
    cells : Cells
        The cells; ``limit_w`` is the squared speed that no run passes.
    w : (K + 1,) float64
        Squared speeds of the run that the costate comes from, m²/s².
    label : (K,) int8
        Its regimes (`front.phases`).
    """

    total: float
    error: float
    bound: _Floats
    left: _Floats
    right: _Floats
    cells: Cells
    w: _Floats
    label: NDArray[np.int8]


class BoundingProblem:
    """A trip prepared for lower bounds."""

    def __init__(self, trip: Trip) -> None:
        self.trip = trip
        self.train: KernelTrain = kernel_train(trip.train)
        cells = cells_of(trip)
        self.cells = cells._replace(limit_w=np.minimum(cells.limit_w, reachable_w(trip, cells)))
        size = 2 * max(len(self.train.traction), len(self.train.braking))
        self._pull, self._brake = np.empty((size, PIECE_COLUMNS)), np.empty((size, PIECE_COLUMNS))

    def line(self, x_m: _Floats, w: _Floats, price_j_per_s: float) -> float:
        """Lower bound of E + λT of every run, J, with the costate of the run of rows ``x_m``, ``w``."""
        ledger = self.ledger(x_m, w, price_j_per_s)
        return self.train.inertia_kg * (ledger.total - ledger.error)

    def ledger(self, x_m: _Floats, w: _Floats, price_j_per_s: float) -> Ledger:
        """Bound of E + λT cell by cell.

        Parameters
        ----------
        x_m, w : (n,) float64
            Rows of a run that suggests the costate: positions from the origin, m, and squared speeds, m²/s². The bound
            holds for every run of the trip, whatever the rows.
        price_j_per_s : float
            Multiplier λ, above 0.
        """
        x_m, w = self._with_breaks(x_m, w)
        row_cell = np.searchsorted(self.cells.station_m, 0.5 * (x_m[:-1] + x_m[1:]), side="right") - 1
        grade_n, air, cap = self.cells.grade_n[row_cell], self.cells.air[row_cell], self.cells.limit_w[row_cell]
        effort = np.empty(len(row_cell))
        row_efforts(self.train, x_m, w, grade_n, air, effort)
        longest_m = self.trip.distance_m / _CELLS_PER_TRIP
        count = count_cells(x_m, w, longest_m)
        node_m, node_w, row = np.empty(count + 1), np.empty(count + 1), np.empty(count, dtype=np.int64)
        cut_rows(x_m, w, longest_m, node_m, node_w, row)
        cells = Cells(node_m, np.diff(node_m), grade_n[row], air[row], cap[row], self.cells.supply[row_cell[row]])
        price = price_j_per_s / self.train.inertia_kg
        arrays = cells[1:5]
        label, source, growth = np.empty(count, dtype=np.int8), np.zeros((count, 3)), np.zeros((count, 3))
        label_cells(
            self.train, *arrays, node_w, effort[row], price, self._pull, self._brake, label, source, growth
        )  # fmt: skip
        tidy_labels(_SLIVER * self.trip.distance_m, cells.length_m, node_w, cells.limit_w, label, source, growth)
        left, right = np.zeros(count), np.zeros(count)
        integrate_costates(
            cells.length_m, node_w, cells.limit_w, effort[row] / self.train.inertia_kg, price, label, source, growth,
            left, right, np.empty(count + 1), np.empty(count + 1),
        )  # fmt: skip
        lost = ~(np.isfinite(left) & np.isfinite(right))  # rows that are no run at all may make p overflow
        left[lost] = right[lost] = 0.0
        return self.evaluate(cells, node_w, price, left, right, label)

    def evaluate(
        self, cells: Cells, w: _Floats, price: float, left: _Floats, right: _Floats, label: NDArray[np.int8]
    ) -> Ledger:
        """Bound for given cells and costates, all per unit of inertia; any finite costates will do."""
        bound = np.empty(len(cells.length_m))
        total, error = bound_kernel(
            self.train, *cells[1:5], w, price, left, right, self._pull, self._brake, bound
        )  # fmt: skip
        return Ledger(total, error, bound, left, right, cells, w, label)

    def _with_breaks(self, x_m: _Floats, w: _Floats) -> tuple[_Floats, _Floats]:
        """Rows from end to end of the trip with every break of the line among them."""
        breaks_m = self.cells.station_m
        gap_m = _SAME_PLACE * self.trip.distance_m
        near = np.searchsorted(x_m, breaks_m).clip(1, len(x_m) - 1)
        near -= np.abs(x_m[near - 1] - breaks_m) < np.abs(x_m[near] - breaks_m)
        found = np.abs(x_m[near] - breaks_m) <= gap_m
        rows_m = x_m.copy()
        rows_m[near[found]] = breaks_m[found]
        x_m = np.union1d(rows_m, breaks_m)
        w = np.interp(x_m, rows_m, w)
        w = np.maximum(w, _SLOWEST * w.max())
        w[0], w[-1] = self.trip.start_speed_mps**2, self.trip.end_speed_mps**2
        count = thin_rows(x_m, w, np.isin(x_m, breaks_m), gap_m)
        return x_m[:count], w[:count]


def _envelope(time_s: _Floats, price_j_per_s: _Floats, line_j: _Floats) -> _Floats:
    """Highest of the lines at given times, at least 0."""
    cost = price_j_per_s[:, None] * time_s * (1.0 + _ROUNDING)
    return np.asarray(np.max(line_j[:, None] * (1.0 - _ROUNDING) - cost, axis=0, initial=0.0))


def _gap_pct(energy_j: _Floats, lower_bound_j: _Floats, scale_j: float) -> _Floats:
    """Gap in percent of the energy; none where the energy is 0 but for rounding against ``scale_j``."""
    positive = energy_j > _NO_ENERGY * scale_j
    return np.where(positive, 100.0 * (energy_j - lower_bound_j) / np.where(positive, energy_j, 1.0), 0.0)


def certify(trip: Trip, profile: Profile, price_j_per_s: float) -> Bound:
    """Bound the least energy at the running time of one profile.

    Parameters
    ----------
    trip : Trip
    profile : Profile
        A run of the trip, best an optimal one: the bound holds whatever it is, but is tight only then.
    price_j_per_s : float
        Its multiplier λ: energy saved per second more, J/s. For the fastest run, whose λ is infinite, a few large
        ones are tried.

    Returns
    -------
    Bound

    Raises
    ------
    InputError
        When the multiplier is not above 0.
    """
    price = require_number("certify", "price", price_j_per_s, "J/s", above=0.0, infinite_ok=True)
    energy_j, time_s = profile.total_energy_j, profile.duration_s
    prices = [price]
    top_j = 0.5 * trip.train.inertia_kg * float(profile.speed_mps.max()) ** 2
    if math.isinf(price):
        prices = [factor * max(energy_j, 1e-3 * top_j) / time_s for factor in _STEEP]
    problem = BoundingProblem(trip)
    x_m, w = profile.position_m - trip.origin_m, profile.speed_mps**2
    lines = np.array([problem.line(x_m, w, price) for price in prices])
    lower = _envelope(np.array([time_s]), np.array(prices), lines)
    return Bound(float(lower[0]), float(_gap_pct(np.array([energy_j]), lower, top_j)[0]))


def certify_front(
    trip: Trip, fastest: Profile, time_s: _Floats, energy_j: _Floats, price_j_per_s: _Floats
) -> Certificate:
    """Bound the least energy at the running times of a whole front.

    For each multiplier the optimal run is solved anew on a finer mesh, since runs that blend two multipliers, as those
    of a front do, make poor costates. The bounds hold for points of any origin.

    Parameters
    ----------
    trip : Trip
    fastest : Profile
        Its fastest run.
    time_s, energy_j : (n,) float64
        Points: running times in s, energies in J.
    price_j_per_s : (m,) float64
        Multipliers near those of the points, J/s; infinite ones and those that are not above 0 are left out.

    Returns
    -------
    Certificate
    """
    problem = BoundingProblem(trip)
    mesh = Mesh.of(trip, fastest, _FINENESS)
    prices = np.unique(price_j_per_s[np.isfinite(price_j_per_s) & (price_j_per_s > 0.0)])
    if len(prices) == 0:
        prices = np.array([mesh.usual_price])
    if len(prices) > _MOST_LINES:
        prices = prices[np.linspace(0, len(prices) - 1, _MOST_LINES).round().astype(np.int64)]
    between = np.sqrt(prices[1:] * prices[:-1])[prices[1:] > _APART * prices[:-1]]
    prices = np.concatenate((prices, between, prices[-1] * np.array(_STEEPER)))
    counters = {"pilots": 0, "runs": 0, "costates": 0}
    used, lines = [], []
    for price in prices:
        try:
            pilot = mesh.pilot(float(price), counters)
        except TgvdpError:
            continue  # one line less: the certificate is only looser
        n, _, _ = mesh.drive(pilot.switch, pilot.switch, 0.0, counters)
        used.append(price)
        lines.append(problem.line(mesh.rows[0][:n], mesh.rows[1][:n], float(price)))
    price_used, line_j = np.array(used), np.array(lines)
    lower = _envelope(time_s, price_used, line_j)
    top_j = 0.5 * trip.train.inertia_kg * float(fastest.speed_mps.max()) ** 2
    return Certificate(lower, _gap_pct(energy_j, lower, top_j), price_used, line_j)
