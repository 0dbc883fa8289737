"""Certificates: a lower bound of the least energy of the continuous problem at given running times.

For a multiplier λ and any costate p(s), every run satisfies E + λT ≥ B(λ, p) (`certificate.cell_bounds`). That is a
line in the (T, E) plane which no run of the continuous problem passes under: E ≥ B − λT. A certificate is the upper
envelope of such lines. A poor λ or p only loosens it. At the running time of the fastest run it is the energy of that:
no run is as fast, for none is faster anywhere. See docs/certificate.md for the derivation and for what is proven.
"""

import contextlib
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tgvdp.certificate.line import BoundingProblem
from tgvdp.certificate.lines import NO_ENERGY, LinesUnder, top_j
from tgvdp.errors import BudgetExceededError
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile, drawn_energy_j

_Floats = NDArray[np.float64]

#: Running times that are nearer to the fastest one, relative to it, are that one.
_SAME_TIME = 1e-9
#: Gaps are shares of at least this share of what the fastest run draws.
_LEAST_SHARE = 0.1
#: A few roundings of one multiplication each.
_ROUNDING = 8.0 * 2.0**-53


@dataclass(frozen=True, eq=False)
class Certificate:
    """Lower bounds of the least energy of the continuous problem, for the points of a front and everywhere else.

    Attributes
    ----------
    lower_bound_j, gap_pct : (n,) float64
        For each point: the bound at its running time, and how far its energy is above, in percent of the energy that
        it draws, or of what it returns on balance, or of a tenth of what the fastest run draws, whichever is most: what
        is left after braking, or on a descent, may be next to nothing. NaN for points that the time limit left without
        one, and where energy is that of a map.
    multiplier_j_per_s, line_j : (m,) float64
        The lines behind it: E ≥ line_j − multiplier_j_per_s·T for every run.
    fastest_s, fastest_j : float
        Running time and energy of the fastest run: no other is as fast.
    complete : bool
        False when the time limit ended the work.
    """

    lower_bound_j: _Floats
    gap_pct: _Floats
    multiplier_j_per_s: _Floats
    line_j: _Floats
    fastest_s: float
    fastest_j: float
    complete: bool = True

    def at(self, time_s: float) -> float:
        """Lower bound of the energy of every run that takes a given time or less, J; −∞ where nothing is known."""
        if len(self.line_j) == 0:
            return -math.inf
        if time_s <= self.fastest_s * (1.0 + _SAME_TIME):
            return self.fastest_j
        return float(_envelope(np.array([time_s]), self.multiplier_j_per_s, self.line_j)[0])


def _envelope(time_s: _Floats, multiplier_j_per_s: _Floats, line_j: _Floats) -> _Floats:
    """Highest of the lines at given times."""
    cost = multiplier_j_per_s[:, None] * time_s * (1.0 + _ROUNDING)
    return np.asarray(np.max(line_j[:, None] - _ROUNDING * np.abs(line_j[:, None]) - cost, axis=0))


def _gap_pct(above_j: _Floats, size_j: _Floats, scale_j: float) -> _Floats:
    """Gap in percent of ``size_j``; none where that is a rounding error of ``scale_j``."""
    some = size_j > NO_ENERGY * scale_j
    return np.where(some, 100.0 * above_j / np.where(some, size_j, 1.0), 0.0)


def certify_front(
    trip: Trip,
    fastest: Profile,
    time_s: _Floats,
    energy_j: _Floats,
    drawn_j: _Floats,
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
    drawn_j : (n,) float64
        Energies in J before what braking returns, of which gaps are shares.
    multiplier_j_per_s : (m,) float64
        Multipliers near those of the points, J/s; infinite ones and those that are not above 0 are left out.
    clock : Clock, optional
        Ends the work between two multipliers. The fastest points come first; those that were not reached have no
        bound.

    Returns
    -------
    Certificate
        Without any bound where the energy is that of a map: its Hamiltonian has no minima in closed form. Not
        `complete` where time, or memory, ended the work.
    """
    if trip.energy.kind == "map":
        return _without_bounds(len(time_s), fastest, complete=True)
    clock = SearchBudget(time_limit_s=math.inf).start() if clock is None else clock
    slower = time_s > fastest.duration_s * (1.0 + _SAME_TIME)
    least_j = _LEAST_SHARE * drawn_energy_j(trip, fastest)
    size_j = np.maximum(np.maximum(drawn_j, -energy_j), least_j)
    try:
        under = LinesUnder(BoundingProblem(trip), fastest, time_s[slower], energy_j[slower], size_j[slower])
    except BudgetExceededError:
        return _without_bounds(len(time_s), fastest, complete=False)
    reached = within_memory = False
    with contextlib.suppress(BudgetExceededError):
        # The fastest run needs no line: it is the only run of its time.
        reached = not slower.any() or under.make_first(multiplier_j_per_s, clock)
        under.refine(clock)
        within_memory = True
    multipliers, line_j = np.array(under.lines).T[:2]
    lower = _envelope(time_s, multipliers, line_j)
    if not reached:  # where the last line is the highest, flatter ones would be higher
        flattest = np.argsort(multipliers)[: min(2, len(multipliers))]
        lower[lower <= _envelope(time_s, multipliers[flattest], line_j[flattest])] = np.nan
    lower[~slower] = fastest.total_energy_j
    gap_pct = _gap_pct(energy_j - lower, size_j, top_j(trip, fastest))
    return Certificate(
        lower, gap_pct, multipliers, line_j, fastest.duration_s, fastest.total_energy_j,
        within_memory and not clock.expired,
    )  # fmt: skip


def _without_bounds(count: int, fastest: Profile, *, complete: bool) -> Certificate:
    """A certificate of points that have no bound."""
    unknown = np.full(count, np.nan)
    return Certificate(unknown, unknown, np.empty(0), np.empty(0), fastest.duration_s, fastest.total_energy_j, complete)
