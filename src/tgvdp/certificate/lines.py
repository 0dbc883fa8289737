"""Lines under a front: for which multipliers, and with how many cells, they are worth the time.

Every line holds for all runs, whatever multiplier and run it comes from (`certificate.line`); these only decide how
close it comes. All runs that are known, points of the front and runs of lines, lie on or above the lower hull of their
times and energies, and no line passes above it. What is between it and the highest line at the running time of a point
is what another line might still gain there. It has two parts: a line is at most as high as the known run of
least E + λT, which better costates and finer cells may close; and between the running times of two such runs only
another multiplier helps.

A few are chosen at a time and made side by side (`line_maker`); how many does not depend on the cores, so that a
certificate is the same on all machines.
"""

import contextlib
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tgvdp.certificate.hull import lower_hull
from tgvdp.certificate.line import BoundingProblem
from tgvdp.certificate.line_maker import NEXT_CARE, Line, LineMaker, Made, Wanted, level_line
from tgvdp.errors import BudgetExceededError
from tgvdp.methods.budget import Clock
from tgvdp.model.trip import Trip
from tgvdp.progress import tell
from tgvdp.runs.profile import Profile

_Floats = NDArray[np.float64]

#: Energy below this share of the kinetic energy at the top speed is a rounding error of none.
NO_ENERGY = 1e-9
#: Gaps that need no other line, relative to what gaps are shares of; and what they are meant to be at first.
_GOAL, _FIRST_GOAL = 4.8e-4, 4.4e-4
#: What another line might gain that is not worth it, likewise; and where care has been in vain.
_ENOUGH, _ENOUGH_IN_VAIN = 1e-4, 1e-3
#: Where care ends, relative to the goal: a hair below it.
_NEARLY = 0.98
#: How much of a gap at first may come of costates and cells, and is expected to before any line is known.
_MOST_SLACK, _USUAL_SLACK = 0.7, 0.3
#: A multiplier that is larger than any before.
_LARGER = 1.5
#: Multiplier for the thriftiest run, in usual ones: there is no line for none.
_THRIFTY = 0.01
#: What a refined line must gain of what its run costs more, if it is not in vain; so many in a row discourage.
_WORTH, _MOST_IN_VAIN = 0.3, 5
#: Other multipliers that are tried for one point.
_MOST_TRIES = 4
#: Share of the time that care may take before all points have a bound.
_CARE_AT_FIRST = 0.5
#: Lines that are chosen, and made, at a time.
_AT_ONCE = 4


def top_j(trip: Trip, profile: Profile) -> float:
    """Kinetic energy at the top speed of a run, J: the scale of energies."""
    return 0.5 * trip.train.inertia_kg * float(profile.speed_mps.max()) ** 2


def _require_memory(made: Sequence[Made]) -> None:
    """Raise what was wrong where there was no memory for a line; the others are kept by then."""
    for one in made:
        if isinstance(one, BudgetExceededError):
            raise one


class LinesUnder:
    """Lines under the points of a front, made a few at a time where they promise most.

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
        self._time_s, self._energy_j = time_s, energy_j
        self._size_j = np.maximum(size_j, NO_ENERGY * top_j(problem.trip, fastest))
        self._maker = LineMaker(problem, fastest, time_s, self._size_j)
        self._runs = [(fastest.duration_s, fastest.total_energy_j)]
        self._runs += zip(time_s.tolist(), energy_j.tolist(), strict=True)
        self._in_vain = 0
        self.lines = [level_line(problem)]

    def make_first(self, multiplier_j_per_s: _Floats, clock: Clock) -> bool:
        """Make lines for multipliers of the front, the steepest first; False when the time ended before the last.

        Each is as flat as the first point that has no bound yet allows, if it is as slack as the last of those before.
        """
        given = np.unique(multiplier_j_per_s[np.isfinite(multiplier_j_per_s) & (multiplier_j_per_s > 0.0)])
        if len(given) == 0:
            given = np.array([self._maker.usual_multiplier])
        if (multiplier_j_per_s == 0.0).any():  # of the thriftiest run
            given = np.append(min(given[0], _THRIFTY * self._maker.usual_multiplier), given)
        given = np.append(given, _LARGER * given[-1])
        given = np.sort(np.concatenate((given, np.sqrt(given[1:] * given[:-1]))))
        slack = _USUAL_SLACK * _FIRST_GOAL
        hull_j = lower_hull(np.array(self._runs), self._time_s)
        short = (hull_j - self._tangents_j(given)) / self._size_j
        seen = np.zeros(len(hull_j), dtype=np.bool_)
        while True:
            bare = (hull_j - self._highest_j() > _FIRST_GOAL * self._size_j) & ~seen
            if not bare.any():
                return True
            if clock.expired:
                return False
            chosen: list[int] = []
            while bare.any() and len(chosen) < _AT_ONCE:
                first = int(np.argmax(bare))
                covers = np.pad(short[:, first:] + slack <= _FIRST_GOAL, ((0, 0), (0, 1)))
                reach = np.argmin(covers, axis=1)
                chosen.append(int(np.argmax(reach) if reach.any() else np.argmin(short[:, first])))
                seen[first] = True
                bare[: first + max(int(reach.max()), 1)] = False
            slack = self._first(given[chosen].tolist(), slack, clock)

    def _first(self, multipliers: Sequence[float], usual: float, clock: Clock) -> float:
        """Make lines for multipliers, J/s, with care where they are too slack; how slack the next ones may be."""
        first = len(self.lines)
        self._make(multipliers, clock)
        careful = []
        for index, line in enumerate(self.lines[first:], first):
            size_j = self._maker.size_at(line.time_s)
            if line.cost_j - line.line_j > _MOST_SLACK * _FIRST_GOAL * size_j:
                careful.append((index, line.cost_j - _USUAL_SLACK * _FIRST_GOAL * size_j))
        if careful and self._in_vain < _MOST_IN_VAIN:
            with contextlib.suppress(BudgetExceededError):  # the lines to come need less memory than care for these
                self._improve(careful, clock.part(_CARE_AT_FIRST))
        if len(self.lines) == first:
            return usual
        last = self.lines[-1]
        return min((last.cost_j - last.line_j) / self._maker.size_at(last.time_s), _MOST_SLACK * _FIRST_GOAL)

    def refine(self, clock: Clock) -> None:
        """Make lines where they promise most, until none promises enough, or the time is up."""
        tries = np.zeros(len(self._time_s), dtype=np.int64)
        self._in_vain = 0
        while not clock.expired:
            better_j, other_j, best = self._promises()
            other_j[tries == _MOST_TRIES] = 0.0
            if self._in_vain >= _MOST_IN_VAIN:
                better_j[better_j < _ENOUGH_IN_VAIN * self._size_j] = 0.0
            promise_j = np.maximum(better_j, other_j)
            near = self._energy_j - self._highest_j() <= _GOAL * self._size_j
            promise_j[near | (promise_j < _ENOUGH * self._size_j)] = 0.0
            if not promise_j.any():
                return
            chosen = self._most_promising(promise_j / self._size_j, best)
            others = chosen[other_j[chosen] >= better_j[chosen]]
            tries[others] += 1
            self._make(list({self._multiplier_at(float(time_s)): None for time_s in self._time_s[others]}), clock)
            careful = []
            aim_j = self._energy_j - _NEARLY * _GOAL * self._size_j
            for index in best[np.setdiff1d(chosen, others)].tolist():
                enough_j = aim_j + self.lines[index].multiplier_j_per_s * self._time_s
                careful.append((index, float(enough_j[best == index].max())))  # of all points that wait for this line
            self._improve(careful, clock)

    @staticmethod
    def _most_promising(promise: _Floats, best: NDArray[np.int64]) -> NDArray[np.int64]:
        """A few points that promise most, one for each line that is the best for some."""
        order = np.argsort(-promise, kind="stable")
        order = order[promise[order] > 0.0]
        _, firsts = np.unique(best[order], return_index=True)
        return np.asarray(order[np.sort(firsts)[:_AT_ONCE]])

    def _improve(self, careful: Sequence[tuple[int, float]], clock: Clock) -> None:
        """Make lines anew with more care, until E + λT is bounded by what is enough, J; count how many were in vain."""
        tell("proving", lines=len(self.lines))
        wanted = [
            Wanted(self.lines[index].multiplier_j_per_s, self.lines[index].care, enough_j)
            for index, enough_j in careful
        ]
        short_j = self._contacts()[1]
        made = self._maker.made(wanted, clock)
        for (index, enough_j), better in zip(careful, made, strict=True):
            untried = better is None and clock.expired
            if not untried and not isinstance(better, BudgetExceededError):
                self._take(index, better, short_j[index] - self.lines[index].line_j, enough_j)
        _require_memory(made)

    def _take(self, index: int, made: Line | None, short_j: float, enough_j: float) -> None:
        """Take a line that was made anew, if it is better."""
        line = self.lines[index]
        gained_j = 0.0 if made is None else made.line_j - line.line_j
        if made is not None and (gained_j >= _WORTH * short_j or made.line_j >= enough_j):
            self.lines[index], self._in_vain = made, 0
            return
        # where the best costates do not help, finer cells may: costates of these were as good before
        care = NEXT_CARE[line.care] if line.care == 1.0 else math.nan
        self.lines[index] = line._replace(care=care, line_j=line.line_j + max(gained_j, 0.0))
        self._in_vain += 1

    def _make(self, multipliers: Sequence[float], clock: Clock) -> None:
        """Add lines for multipliers, J/s; the certificate is only looser without them."""
        tell("proving", lines=len(self.lines))
        made = self._maker.made([Wanted(multiplier) for multiplier in multipliers], clock)
        for line in made:
            if isinstance(line, Line):
                self.lines.append(line)
                self._runs.append((line.time_s, line.cost_j - line.multiplier_j_per_s * line.time_s))
        _require_memory(made)

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

    def _promises(self) -> tuple[_Floats, _Floats, NDArray[np.int64]]:
        """What more care, and what other multipliers might gain at each point, J, and its best line.

        That is the one that would bound it best, were it as high as the run that it must not pass above; one on which
        care was spent in vain is as high as it gets.
        """
        multiplier, line_j, _, _, care = np.array(self.lines).T
        _, cost_j = self._contacts()
        spent_j = multiplier[:, None] * self._time_s
        reach_j = np.where(np.isnan(care), line_j, cost_j)[:, None] - spent_j
        best = np.argmax(reach_j, axis=0)
        highest_j = np.max(line_j[:, None] - spent_j, axis=0)
        hull_j = lower_hull(np.array(self._runs), self._time_s)
        tangent_j = np.minimum(reach_j[best, np.arange(len(best))], hull_j)
        better_j = np.where(np.isnan(care[best]), 0.0, tangent_j - highest_j)
        return better_j, hull_j - np.maximum(tangent_j, highest_j), best

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
