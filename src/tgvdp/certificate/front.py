"""Certificates: a lower bound of the least energy of the continuous problem at given running times.

For a multiplier λ and any costate p(s), every run satisfies E + λT ≥ B(λ, p) (`certificate.cell_bounds`). That is a
line in the (T, E) plane which no run of the continuous problem passes under: E ≥ B − λT. A certificate is the upper
envelope of such lines. A poor λ or p only loosens it. See docs/certificate.md for the derivation and for what is
proven.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tgvdp.certificate.line import BoundingProblem
from tgvdp.certificate.lines import NO_ENERGY, all_lines, level_line, own_line, steep_lines, top_j
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.model.checks import require_number
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile

_Floats = NDArray[np.float64]

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
    multiplier_j_per_s, line_j : (m,) float64
        The lines behind it: E ≥ line_j − multiplier_j_per_s·T for every run.
    complete : bool
        False when the time limit ended the work.
    """

    lower_bound_j: _Floats
    gap_pct: _Floats
    multiplier_j_per_s: _Floats
    line_j: _Floats
    complete: bool = True

    def at(self, time_s: float) -> float:
        """Lower bound of the energy of every run that takes a given time or less, J; −∞ where nothing is known."""
        if len(self.line_j) == 0:
            return -math.inf
        return float(_envelope(np.array([time_s]), self.multiplier_j_per_s, self.line_j)[0])


def _envelope(time_s: _Floats, multiplier_j_per_s: _Floats, line_j: _Floats) -> _Floats:
    """Highest of the lines at given times."""
    cost = multiplier_j_per_s[:, None] * time_s * (1.0 + _ROUNDING)
    return np.asarray(np.max(line_j[:, None] - _ROUNDING * np.abs(line_j[:, None]) - cost, axis=0))


def _gap_pct(energy_j: _Floats, lower_bound_j: _Floats, scale_j: float) -> _Floats:
    """Gap in percent of the energy; none where the energy is 0 but for rounding against ``scale_j``."""
    size_j = np.abs(energy_j)
    some = size_j > NO_ENERGY * scale_j
    return np.where(some, 100.0 * (energy_j - lower_bound_j) / np.where(some, size_j, 1.0), 0.0)


def certify(trip: Trip, profile: Profile, multiplier_j_per_s: float) -> Bound:
    """Bound the least energy at the running time of one profile.

    Parameters
    ----------
    trip : Trip
    profile : Profile
        A run of the trip, best an optimal one: the bound holds whatever it is, but is tight only then.
    multiplier_j_per_s : float
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
    multiplier = require_number("certify", "multiplier", multiplier_j_per_s, "J/s", above=0.0, infinite_ok=True)
    problem = BoundingProblem(trip)
    if math.isinf(multiplier):
        lines = list(steep_lines(problem, profile, 0.0, SearchBudget().start()))
    else:
        lines = [own_line(problem, profile, multiplier)]
    multipliers, line_j = np.array([level_line(problem), *lines]).T[:2]
    lower = _envelope(np.array([profile.duration_s]), multipliers, line_j)
    return Bound(float(lower[0]), float(_gap_pct(np.array([profile.total_energy_j]), lower, top_j(trip, profile))[0]))


def certify_front(
    trip: Trip,
    fastest: Profile,
    time_s: _Floats,
    energy_j: _Floats,
    multiplier_j_per_s: _Floats,
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
    multiplier_j_per_s : (m,) float64
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
    lines, reached = all_lines(BoundingProblem(trip), fastest, time_s, energy_j, multiplier_j_per_s, clock)
    multipliers, line_j = np.array(lines).T[:2]
    lower = _envelope(time_s, multipliers, line_j)
    if not reached:  # where the last line is the highest, flatter ones would be higher
        flattest = np.argsort(multipliers)[: min(2, len(multipliers))]
        lower[lower <= _envelope(time_s, multipliers[flattest], line_j[flattest])] = np.nan
    return Certificate(lower, _gap_pct(energy_j, lower, top_j(trip, fastest)), multipliers, line_j, not clock.expired)
