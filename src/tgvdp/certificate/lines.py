"""Lines under a front: for which multipliers, and with how many cells, they are worth the time.

Every line holds for all runs, whatever multiplier and run it comes from (`certificate.line`); these only decide how
close it comes. All runs that are known, points of the front and runs of lines, lie on or above the lower hull of their
times and energies, and no line passes above it. What is between it and the highest line at the running time of a point
is what another line might still gain there. It has two parts: a line is at most as high as the known run of
least E + λT, which better costates and finer cells may close; and between the running times of two such runs only
another multiplier helps.
"""

import contextlib
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.certificate.hull import lower_hull
from tgvdp.certificate.kinked import kinked
from tgvdp.certificate.line import BoundingProblem
from tgvdp.errors import BudgetExceededError, TgvdpError
from tgvdp.methods.budget import Clock
from tgvdp.methods.costate.mesh import Mesh, Run
from tgvdp.model.trip import Trip
from tgvdp.progress import tell
from tgvdp.runs.profile import Profile

_Floats = NDArray[np.float64]

#: Energy below this share of the kinetic energy at the top speed is a rounding error of none.
NO_ENERGY = 1e-9
#: The extremals of a certificate are solved on a mesh this much finer than the front's.
_FINENESS = 4.0
#: Gaps that need no other line, relative to what gaps are shares of; and what they are meant to be at first.
_GOAL, _FIRST_GOAL = 4.8e-4, 4.4e-4
#: What another line might gain that is not worth it, likewise; and where care has been in vain.
_ENOUGH, _ENOUGH_IN_VAIN = 1e-4, 1e-3
#: What a line is short of, likewise, for which curved potentials are worth the time.
_CURVED = 2e-4
#: Where care ends, relative to the goal: a hair below it.
_NEARLY = 0.98
#: How much of a gap at first may come of costates and cells, and is expected to before any line is known.
_MOST_SLACK, _USUAL_SLACK = 0.7, 0.3
#: A multiplier that is larger than any before.
_LARGER = 1.5
#: What a refined line must gain of what its run costs more, if it is not in vain; so many in a row discourage.
_WORTH, _MOST_IN_VAIN = 0.3, 3
#: Care that lines are made with, in this order: none; ascent; and ascent with so many times more cells. All with care
#: have this many times more, for what other causes leave is more than what the width of cells does.
_CAREFUL = 1.5
_NEXT_CARE = {0.0: 1.0, 1.0: 2.0, 2.0: 4.0, 4.0: math.nan}
#: What a step of an ascent must gain, relative to the energy.
_ASCENT_GAIN = 1e-5
#: Other multipliers that are tried for one point.
_MOST_TRIES = 4


def top_j(trip: Trip, profile: Profile) -> float:
    """Kinetic energy at the top speed of a run, J: the scale of energies."""
    return 0.5 * trip.train.inertia_kg * float(profile.speed_mps.max()) ** 2


class Line(NamedTuple):
    """E ≥ line_j − multiplier_j_per_s·T for every run, and the run that suggested the costate: its T and its E + λT.

    ``care`` is how a better one could be made: 1 by ascent, above it by ascent with so many times more cells; NaN where
    that is not worth it.
    """

    multiplier_j_per_s: float
    line_j: float
    time_s: float
    cost_j: float
    care: float = math.nan


def level_line(problem: BoundingProblem) -> Line:
    """The line of λ = 0, which no run suggests."""
    return Line(0.0, problem.least_energy_j, math.inf, problem.least_energy_j)


def _optimal(problem: BoundingProblem, mesh: Mesh, multiplier: float) -> Run:
    """The optimal run of a multiplier, J/s, in rows that the next one overwrites.

    The power of auxiliaries is part of the multipliers of a mesh, and of the run's, which otherwise know none.
    """
    return mesh.optimal_run(problem.total(multiplier), {"extremals": 0, "runs": 0, "costates": 0})


def least_cost_j(trip: Trip, fastest: Profile, multiplier: float, size_j: float, clock: Clock) -> float:
    """Lower bound of E + λT, less the trip's credits, of all of its runs, J, by ascent from the optimal one.

    Parameters
    ----------
    trip : Trip
        Whose credits leave the multiplier above 0 everywhere.
    fastest : Profile
        Its fastest run.
    multiplier : float
        λ, J/s.
    size_j : float
        Energy of which gains of the ascent are shares.
    clock : Clock

    Raises
    ------
    TgvdpError
        When the costate program fails.
    """
    problem, mesh = BoundingProblem(trip), Mesh.of(trip, fastest, _FINENESS)
    run = _optimal(problem, mesh, multiplier)
    return problem.line(run.x_m, run.w, multiplier, gain_j=_ASCENT_GAIN * size_j, clock=clock)


class LinesUnder:
    """Lines under the points of a front, made one by one where they promise most.

    Parameters
    ----------
    problem : BoundingProblem
    fastest : Profile
        Fastest run of its trip.
    time_s, energy_j, size_j : (n,) float64
        Points: running times in s, increasing, energies in J, and of what J their gaps are shares.
    """

    def __init__(
        self, problem: BoundingProblem, fastest: Profile, time_s: _Floats, energy_j: _Floats, size_j: _Floats
    ) -> None:
        self._problem = problem
        self._mesh = Mesh.of(problem.trip, fastest, _FINENESS)
        self._time_s, self._energy_j = time_s, energy_j
        self._size_j = np.maximum(size_j, NO_ENERGY * top_j(problem.trip, fastest))
        self._runs = [(fastest.duration_s, fastest.total_energy_j)]
        self._runs += zip(time_s.tolist(), energy_j.tolist(), strict=True)
        self._in_vain = 0
        self.lines = [level_line(problem)]

    def make_first(self, multiplier_j_per_s: _Floats, clock: Clock) -> bool:
        """Make lines for multipliers of the front, the steepest first; False when the time ended before the last.

        Each is as flat as the first point that has no bound yet allows, if it is as slack as the line before.
        """
        given = np.unique(multiplier_j_per_s[np.isfinite(multiplier_j_per_s) & (multiplier_j_per_s > 0.0)])
        if len(given) == 0:
            given = np.array([self._mesh.usual_multiplier])
        given = np.append(given, _LARGER * given[-1])
        given = np.sort(np.concatenate((given, np.sqrt(given[1:] * given[:-1]))))
        slack, done = _USUAL_SLACK * _FIRST_GOAL, 0
        hull_j = lower_hull(np.array(self._runs), self._time_s)
        short = (hull_j - self._tangents_j(given)) / self._size_j
        while True:
            bare = hull_j - self._highest_j() > _FIRST_GOAL * self._size_j
            bare[:done] = False
            if not bare.any():
                return True
            if clock.expired:
                return False
            first = int(np.argmax(bare))
            done = first + 1
            covers = np.pad(short[:, first:] + slack <= _FIRST_GOAL, ((0, 0), (0, 1)))
            reach = np.argmin(covers, axis=1)
            chosen = int(np.argmax(reach) if reach.any() else np.argmin(short[:, first]))
            slack = self._first(float(given[chosen]), slack, clock)

    def _first(self, multiplier: float, usual: float, clock: Clock) -> float:
        """Make a line for a multiplier, J/s, with care if it is too slack; how slack the next one may be."""
        line = self._make(multiplier, clock)
        if line is None:
            return usual
        size_j = self._size_at(line.time_s)
        most_j = _MOST_SLACK * _FIRST_GOAL * size_j
        if line.cost_j - line.line_j > most_j and self._in_vain < _MOST_IN_VAIN:
            with contextlib.suppress(BudgetExceededError):  # the lines to come need less memory than care for this one
                self._improve(len(self.lines) - 1, line.cost_j - _USUAL_SLACK * _FIRST_GOAL * size_j, clock)
        return min(line.cost_j - self.lines[-1].line_j, most_j) / size_j

    def refine(self, clock: Clock) -> None:
        """Make lines where they promise most, until none promises enough, or the time is up."""
        tries = np.zeros(len(self._time_s), dtype=np.int64)
        self._in_vain = 0
        while not clock.expired:
            better_j, other_j = self._promises()
            other_j[tries == _MOST_TRIES] = 0.0
            if self._in_vain >= _MOST_IN_VAIN:
                better_j[better_j < _ENOUGH_IN_VAIN * self._size_j] = 0.0
            promise_j = np.maximum(better_j, other_j)
            near = self._energy_j - self._highest_j() <= _GOAL * self._size_j
            promise_j[near | (promise_j < _ENOUGH * self._size_j)] = 0.0
            if not promise_j.any():
                return
            chosen = int(np.argmax(promise_j / self._size_j))
            if other_j[chosen] >= better_j[chosen]:
                tries[chosen] += 1
                self._make(self._multiplier_at(float(self._time_s[chosen])), clock)
                continue
            best = self._best_lines()
            own = best == best[chosen]  # points that wait for this line
            enough_j = self._energy_j - _NEARLY * _GOAL * self._size_j
            enough_j += self.lines[best[chosen]].multiplier_j_per_s * self._time_s
            self._improve(int(best[chosen]), float(enough_j[own].max()), clock)

    def _improve(self, index: int, enough_j: float, clock: Clock) -> None:
        """Make a line anew with more care, until E + λT is bounded by ``enough_j``; count if that was in vain."""
        line = self.lines[index]
        short_j = self._contacts()[1][index] - line.line_j
        made = self._line(line.multiplier_j_per_s, line.care, clock, enough_j)
        gained_j = 0.0 if made is None else made.line_j - line.line_j
        if made is not None and (gained_j >= _WORTH * short_j or made.line_j >= enough_j):
            self.lines[index], self._in_vain = made, 0
            return
        # where the best costates do not help, finer cells may: costates of these were as good before
        care = _NEXT_CARE[line.care] if line.care == 1.0 else math.nan
        self.lines[index] = line._replace(care=care, line_j=line.line_j + max(gained_j, 0.0))
        self._in_vain += 1

    def _make(self, multiplier: float, clock: Clock) -> Line | None:
        """Add a line for a multiplier, J/s; the certificate is only looser without it."""
        tell("proving", lines=len(self.lines))
        line = self._line(multiplier, 0.0, clock)
        if line is not None:
            self.lines.append(line)
            self._runs.append((line.time_s, line.cost_j - multiplier * line.time_s))
        return line

    def _size_at(self, time_s: float) -> float:
        """What gaps are shares of at a running time, J."""
        return float(np.interp(time_s, self._time_s, self._size_j))

    def _line(self, multiplier: float, care: float, clock: Clock, enough_j: float = math.inf) -> Line | None:
        """Line from the optimal run of a multiplier, J/s; none where the costate program finds none.

        It needs no more care than bounds E + λT by ``enough_j``.
        """
        try:
            run = _optimal(self._problem, self._mesh, multiplier)
        except TgvdpError:
            return None
        size_j = self._size_at(run.time_s)
        gain_j = _ASCENT_GAIN * size_j if care else math.inf
        cost_j = run.energy_j + run.multiplier * run.time_s
        problem = self._problem
        ledger = problem.ledger(run.x_m, run.w, multiplier, max(_CAREFUL * care, 1.0), gain_j, clock, enough_j)
        line_j = problem.line_j(ledger)
        if care > 1.0 and line_j < enough_j:
            line_j = problem.line_j(kinked(problem, ledger, multiplier, gain_j, clock))
        if care and line_j < min(enough_j, cost_j - _CURVED * size_j) and problem.may_curve(multiplier):
            line_j = max(line_j, problem.line_j(problem.curved(ledger, multiplier, gain_j, clock)))
        return Line(multiplier, line_j, run.time_s, cost_j, care if line_j >= enough_j else _NEXT_CARE[care])

    def _highest_j(self) -> _Floats:
        """The highest of the lines at each point, J."""
        multiplier, line_j, *_ = np.array(self.lines).T
        return np.asarray(np.max(line_j[:, None] - multiplier[:, None] * self._time_s, axis=0))

    def _tangents_j(self, multiplier: _Floats) -> _Floats:
        """Lines of multipliers at each point, (m, n), J, were they as high as known runs allow."""
        time_s, energy_j = np.array(self._runs).T
        cost_j = np.min(energy_j + multiplier[:, None] * time_s, axis=1)
        return np.asarray(cost_j[:, None] - multiplier[:, None] * self._time_s)

    def _contacts(self) -> tuple[_Floats, _Floats]:
        """For each line the known run that it must not pass above: its time, and its E + λT, the least of all."""
        multiplier, line_j, *_ = np.array(self.lines).T
        time_s, energy_j = np.array(self._runs).T
        cost_j = energy_j + multiplier[:, None] * time_s
        first = np.argmin(cost_j, axis=1)
        least_j = cost_j[np.arange(len(first)), first]
        level = multiplier == 0.0  # which no run suggests: it is as high as it can be
        return np.where(level, math.inf, time_s[first]), np.where(level, line_j, least_j)

    def _best_lines(self) -> NDArray[np.int64]:
        """For each point the line that would bound it best, were it as high as the run that it must not pass above."""
        multiplier, *_ = np.array(self.lines).T
        _, cost_j = self._contacts()
        return np.asarray(np.argmax(cost_j[:, None] - multiplier[:, None] * self._time_s, axis=0))

    def _promises(self) -> tuple[_Floats, _Floats]:
        """What more care, and what other multipliers might gain at each point, J."""
        multiplier, line_j, _, _, care = np.array(self.lines).T
        _, cost_j = self._contacts()
        spent_j = multiplier[:, None] * self._time_s
        best = self._best_lines()
        highest_j = np.max(line_j[:, None] - spent_j, axis=0)
        hull_j = lower_hull(np.array(self._runs), self._time_s)
        tangent_j = np.minimum((cost_j[:, None] - spent_j)[best, np.arange(len(best))], hull_j)
        better_j = np.where(np.isnan(care[best]), 0.0, tangent_j - highest_j)
        return better_j, hull_j - np.maximum(tangent_j, highest_j)

    def _multiplier_at(self, time_s: float) -> float:
        """Multiplier between those of the lines that meet runs of next less and next more time: their secant."""
        multiplier, *_ = np.array(self.lines[1:]).T
        line_s, cost_j = (column[1:] for column in self._contacts())
        before, after = np.flatnonzero(line_s <= time_s), np.flatnonzero(line_s > time_s)
        if len(before) == 0:
            return float(_LARGER * multiplier.max())
        if len(after) == 0:
            return float(multiplier.min() / _LARGER)
        i, j = before[np.argmax(line_s[before])], after[np.argmin(line_s[after])]
        energy_j = cost_j - multiplier * line_s
        low, high = sorted((float(multiplier[i]), float(multiplier[j])))
        secant = float((energy_j[i] - energy_j[j]) / (line_s[j] - line_s[i]))
        return secant if low < secant < high else math.sqrt(low * high)
