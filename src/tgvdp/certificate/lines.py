"""Lines under a front: for which multipliers, and with how many cells, they are worth the time.

Every line holds for all runs, whatever multiplier and run it comes from (`certificate.line`); these only decide how
close it comes. All runs that are known, points of the front and runs of lines, lie on or above the lower hull of their
times and energies, and no line passes above it. What is between it and the highest line at the running time of a point
is what another line might still gain there. It has two parts: a line is at most as high as the known run of
least E + λT, which better costates and finer cells may close; and between the running times of two such runs only
another multiplier helps.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.certificate.kinked import kinked
from tgvdp.certificate.line import BoundingProblem
from tgvdp.errors import TgvdpError
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
#: Lines for the multipliers of the front at first; and one for a multiplier that is larger by this factor.
_FIRST_LINES, _LARGER = 12, 1.5
#: What another line might gain that is not worth it, relative to the energy; and where care has been in vain.
_ENOUGH, _ENOUGH_IN_VAIN = 2e-4, 1e-3
#: What a refined line must gain of what its run costs more, if it is not in vain; so many in a row discourage.
_WORTH, _MOST_IN_VAIN = 0.3, 3
#: Care that lines are made with, in this order: none; ascent; and ascent with so many times more cells.
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
    time_s, energy_j : (n,) float64
        Points: running times in s, energies in J.
    """

    def __init__(self, problem: BoundingProblem, fastest: Profile, time_s: _Floats, energy_j: _Floats) -> None:
        self._problem = problem
        self._mesh = Mesh.of(problem.trip, fastest, _FINENESS)
        self._time_s, self._energy_j = time_s, energy_j
        self._size_j = np.maximum(np.abs(energy_j), NO_ENERGY * top_j(problem.trip, fastest))
        self._runs = [(fastest.duration_s, fastest.total_energy_j)]
        self._runs += zip(time_s.tolist(), energy_j.tolist(), strict=True)
        self.lines = [level_line(problem)]

    def make_first(self, multiplier_j_per_s: _Floats, clock: Clock) -> bool:
        """Make lines for multipliers of the front, the steepest first; False when the time ended before the last."""
        given = np.unique(multiplier_j_per_s[np.isfinite(multiplier_j_per_s) & (multiplier_j_per_s > 0.0)])
        if len(given) == 0:
            given = np.array([self._mesh.usual_multiplier])
        count = min(len(given), _FIRST_LINES)
        chosen = given[np.linspace(0, len(given) - 1, count).round().astype(np.int64)]
        for multiplier in np.append(chosen, _LARGER * chosen[-1])[::-1].tolist():
            if clock.expired:
                return False
            self._make(multiplier, clock)
        return True

    def refine(self, clock: Clock) -> None:
        """Make lines where they promise most, until none promises enough, or the time is up."""
        tries = np.zeros(len(self._time_s), dtype=np.int64)
        in_vain = 0
        while not clock.expired:
            better_j, other_j = self._promises()
            other_j[tries == _MOST_TRIES] = 0.0
            if in_vain >= _MOST_IN_VAIN:
                better_j[better_j < _ENOUGH_IN_VAIN * self._size_j] = 0.0
            promise_j = np.maximum(better_j, other_j)
            promise_j[promise_j < _ENOUGH * self._size_j] = 0.0
            if not promise_j.any():
                return
            chosen = int(np.argmax(promise_j / self._size_j))
            if other_j[chosen] >= better_j[chosen]:
                tries[chosen] += 1
                self._make(self._multiplier_at(float(self._time_s[chosen])), clock)
            else:
                in_vain = 0 if self._improve(int(self._best_lines()[chosen]), clock) else in_vain + 1

    def _improve(self, index: int, clock: Clock) -> bool:
        """Make a line anew with more care; whether that was not in vain."""
        line = self.lines[index]
        short_j = self._contacts()[1][index] - line.line_j
        made = self._line(line.multiplier_j_per_s, line.care, clock)
        gained_j = 0.0 if made is None else made.line_j - line.line_j
        if made is None or gained_j < _WORTH * short_j:
            # where the best costates do not help, finer cells may: costates of these were as good before
            care = _NEXT_CARE[line.care] if line.care == 1.0 else math.nan
            self.lines[index] = line._replace(care=care, line_j=line.line_j + max(gained_j, 0.0))
            return False
        self.lines[index] = made
        return True

    def _make(self, multiplier: float, clock: Clock) -> None:
        """Add a line for a multiplier, J/s; the certificate is only looser without it."""
        tell("proving", lines=len(self.lines))
        line = self._line(multiplier, 0.0, clock)
        if line is not None:
            self.lines.append(line)
            self._runs.append((line.time_s, line.cost_j - multiplier * line.time_s))

    def _line(self, multiplier: float, care: float, clock: Clock) -> Line | None:
        """Line from the optimal run of a multiplier, J/s; none where the costate program finds none."""
        try:
            run = _optimal(self._problem, self._mesh, multiplier)
        except TgvdpError:
            return None
        size_j = float(np.interp(run.time_s, self._time_s, self._size_j)) if len(self._time_s) else abs(run.energy_j)
        gain_j = _ASCENT_GAIN * size_j if care else math.inf
        cost_j = run.energy_j + run.multiplier * run.time_s
        ledger = self._problem.ledger(run.x_m, run.w, multiplier, max(care, 1.0), gain_j, clock)
        found = kinked(self._problem, ledger, multiplier, gain_j, clock) if care > 1.0 else ledger
        line_j = self._problem.line_j(found)
        if care and cost_j - line_j > _ENOUGH * size_j and self._problem.may_curve(multiplier):
            line_j = max(line_j, self._problem.line_j(self._problem.curved(ledger, multiplier, gain_j, clock)))
        return Line(multiplier, line_j, run.time_s, cost_j, _NEXT_CARE[care])

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
        hull_j = _hull(np.array(self._runs), self._time_s)
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


def _hull(runs: _Floats, time_s: _Floats) -> _Floats:
    """Lower hull of running times and energies of runs, (n, 2), at given times; later ones need no more."""
    hull: list[tuple[float, float]] = []
    for t, e in sorted((float(run[0]), float(run[1])) for run in runs):
        if hull and e >= hull[-1][1]:
            continue
        while len(hull) > 1 and _rises(hull[-2], hull[-1], (t, e)):
            hull.pop()
        hull.append((t, e))
    return np.asarray(np.interp(time_s, *np.array(hull).T))


def _rises(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
    """Whether b lies on or above the line from a to c."""
    return (b[1] - a[1]) * (c[0] - a[0]) >= (c[1] - a[1]) * (b[0] - a[0])
