"""Certificates: a lower bound of the least energy of the continuous problem at given running times.

For a multiplier λ and any costate p(s), every run satisfies E + λT ≥ B(λ, p) (`front.bounds`). That is a line in the
(T, E) plane which no run of the continuous problem passes under: E ≥ B − λT. A certificate is the upper envelope of
such lines. A poor λ or p only loosens it. See docs/certificate.md for the derivation and for what is proven.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import TgvdpError
from tgvdp.front.problem import BoundingProblem
from tgvdp.model.checks import require_number
from tgvdp.model.trip import Trip
from tgvdp.physics.profile import Profile
from tgvdp.search.budget import Clock, SearchBudget
from tgvdp.search.pilots import Mesh

_Floats = NDArray[np.float64]

#: The pilots of a front's certificate are solved on a mesh this much finer than the front's.
_FINENESS = 4.0
#: Multipliers of a front's certificate at most.
_MOST_LINES = 64
#: Further ones, relative to the largest: next to the fastest run a line is good only near its own point.
_LARGER = (1.15, 1.35, 1.8)
#: Between multipliers further apart than this factor another one is solved: a line may be poor where T(λ) jumps.
_APART = 1.1
#: Multipliers for the fastest run itself grow by this factor until they do not help, and then by smaller ones. The
#: losses of a line grow with them, so that it needs this many times more cells.
_STEEPER, _BETWEEN = 4.0, 1.4
_STEEP_FINENESS = 32.0
_MOST_STEEP = 12
_STEEPEST = 1000.0
#: Least of these multipliers, relative to energy over running time of the fastest run.
_STEEP = 30.0
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
        For each point: the bound at its running time, and how far its energy is above, in percent of the energy. NaN
        for points that the time limit left without one, and where energy is that of a map.
    price_j_per_s, line_j : (m,) float64
        The lines behind it: E ≥ line_j − price_j_per_s·T for every run.
    complete : bool
        False when the time limit ended the work.
    """

    lower_bound_j: _Floats
    gap_pct: _Floats
    price_j_per_s: _Floats
    line_j: _Floats
    complete: bool = True

    def at(self, time_s: float) -> float:
        """Lower bound of the energy of every run that takes a given time or less, J; −∞ where nothing is known."""
        if len(self.line_j) == 0:
            return -math.inf
        return float(_envelope(np.array([time_s]), self.price_j_per_s, self.line_j)[0])


def _envelope(time_s: _Floats, price_j_per_s: _Floats, line_j: _Floats) -> _Floats:
    """Highest of the lines at given times."""
    cost = price_j_per_s[:, None] * time_s * (1.0 + _ROUNDING)
    return np.asarray(np.max(line_j[:, None] - _ROUNDING * np.abs(line_j[:, None]) - cost, axis=0))


def _gap_pct(energy_j: _Floats, lower_bound_j: _Floats, scale_j: float) -> _Floats:
    """Gap in percent of the energy; none where the energy is 0 but for rounding against ``scale_j``."""
    size_j = np.abs(energy_j)
    some = size_j > _NO_ENERGY * scale_j
    return np.where(some, 100.0 * (energy_j - lower_bound_j) / np.where(some, size_j, 1.0), 0.0)


def _top_j(trip: Trip, profile: Profile) -> float:
    """Kinetic energy at the top speed of a run, J: the scale of energies."""
    return 0.5 * trip.train.inertia_kg * float(profile.speed_mps.max()) ** 2


def certify(trip: Trip, profile: Profile, price_j_per_s: float) -> Bound:
    """Bound the least energy at the running time of one profile.

    Parameters
    ----------
    trip : Trip
    profile : Profile
        A run of the trip, best an optimal one: the bound holds whatever it is, but is tight only then.
    price_j_per_s : float
        Its multiplier λ: energy saved per second more, J/s. For the fastest run, whose λ is infinite, the best of some
        large ones is taken.

    Returns
    -------
    Bound

    Raises
    ------
    InputError
        When the multiplier is not above 0.
    """
    price = require_number("certify", "price", price_j_per_s, "J/s", above=0.0, infinite_ok=True)
    problem = BoundingProblem(trip)
    if math.isinf(price):
        lines = list(_steep_lines(problem, profile, 0.0, SearchBudget().start()))
    else:
        lines = [(price, problem.line(profile.position_m - trip.origin_m, profile.speed_mps**2, price))]
    prices, line_j = np.array([(0.0, problem.least_energy_j), *lines]).T
    lower = _envelope(np.array([profile.duration_s]), prices, line_j)
    return Bound(float(lower[0]), float(_gap_pct(np.array([profile.total_energy_j]), lower, _top_j(trip, profile))[0]))


def certify_front(
    trip: Trip,
    fastest: Profile,
    time_s: _Floats,
    energy_j: _Floats,
    price_j_per_s: _Floats,
    clock: Clock | None = None,
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
    clock : Clock, optional
        Ends the work between two multipliers. The fastest points come first; those that were not reached have no
        bound.

    Returns
    -------
    Certificate
        Without any bound where the energy is that of a map: its Hamiltonian has no minima in closed form.
    """
    if trip.energy.kind == "map":
        unknown = np.full_like(time_s, np.nan)
        return Certificate(unknown, unknown, np.empty(0), np.empty(0))
    clock = SearchBudget(time_limit_s=math.inf).start() if clock is None else clock
    problem = BoundingProblem(trip)
    mesh = Mesh.of(trip, fastest, _FINENESS)
    prices = _multipliers(price_j_per_s, mesh.usual_price)
    lines = list(
        chain(
            [(0.0, problem.least_energy_j)],
            _pilot_lines(problem, mesh, prices, clock),
            _steep_lines(problem, fastest, float(prices[0]), clock),
        )
    )
    price_used, line_j = np.array(lines).T
    lower = _envelope(time_s, price_used, line_j)
    complete = not clock.expired
    if not complete:  # where the last line is the highest, flatter ones would be higher
        flattest = np.argsort(price_used)[: min(2, len(price_used))]
        lower[lower <= _envelope(time_s, price_used[flattest], line_j[flattest])] = np.nan
    return Certificate(lower, _gap_pct(energy_j, lower, _top_j(trip, fastest)), price_used, line_j, complete)


def _multipliers(price_j_per_s: _Floats, usual_price: float) -> _Floats:
    """Multipliers to solve, decreasing: those given, thinned out and filled up; the usual one where none is given."""
    prices = np.unique(price_j_per_s[np.isfinite(price_j_per_s) & (price_j_per_s > 0.0)])
    if len(prices) == 0:
        prices = np.array([usual_price])
    if len(prices) > _MOST_LINES:
        prices = prices[np.linspace(0, len(prices) - 1, _MOST_LINES).round().astype(np.int64)]
    between = np.sqrt(prices[1:] * prices[:-1])[prices[1:] > _APART * prices[:-1]]
    return np.sort(np.concatenate((prices, between, prices[-1] * np.array(_LARGER))))[::-1]


def _pilot_lines(problem: BoundingProblem, mesh: Mesh, prices: _Floats, clock: Clock) -> Iterator[tuple[float, float]]:
    """Multipliers in J/s and lines in J, from the optimal runs of the multipliers, until the time is up."""
    counters = {"pilots": 0, "runs": 0, "costates": 0}
    for price in prices.tolist():
        if clock.expired:
            return
        try:
            pilot = mesh.pilot(price, counters)
        except TgvdpError:
            continue  # one line less: the certificate is only looser
        n, _, _ = mesh.drive(pilot.switch, pilot.switch, 0.0, counters)
        yield price, problem.line(mesh.rows[0][:n], mesh.rows[1][:n], price)


def _steep_lines(
    problem: BoundingProblem, fastest: Profile, above: float, clock: Clock
) -> Iterator[tuple[float, float]]:
    """Multipliers in J/s and lines in J for the fastest run, whose own multiplier is infinite.

    Next to it the least energy falls as c·√(T − T_min): a line of multiplier λ is c²/(4λ) too low there, and its own
    losses grow with λ. In between is a best one; the costates of all are taken from the fastest run.
    """
    energy_j, time_s = fastest.total_energy_j, fastest.duration_s
    x_m, w = fastest.position_m - problem.trip.origin_m, fastest.speed_mps**2
    found: dict[float, float] = {}
    price = max(above, _STEEP * max(energy_j, 1e-3 * _top_j(problem.trip, fastest)) / time_s)
    most = _STEEPEST * price
    while price <= most and len(found) < _MOST_STEEP and not clock.expired:
        line_j = problem.line(x_m, w, price, _STEEP_FINENESS)
        if line_j - price * time_s > energy_j:
            return  # the losses are below the precision of the run, and so is what a steeper line could tell
        yield price, line_j
        found[price] = line_j - price * time_s
        best = max(found, key=found.__getitem__)
        if best == max(found):
            price = _STEEPER * best
            continue
        nearby = [other for other in (best * _BETWEEN, best / _BETWEEN) if other not in found]
        if not nearby:
            return
        price = nearby[0]
