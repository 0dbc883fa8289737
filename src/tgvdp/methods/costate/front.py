"""The front method: the whole Pareto front from a few multipliers (docs/front-method.md).

Extremals are solved by the costate program for chosen multipliers. Each point of the front drives a blend of the
switching speeds of the two extremals around it that meets its running time; where the blend costs other than the cubic
through the extremals' (T, E, slope −λ) promises, an extremal is added between them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.resolved import resolve
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.methods.costate.doubt import Doubt
from tgvdp.methods.costate.drivable import drivable
from tgvdp.methods.costate.found import Found
from tgvdp.methods.costate.mesh import Mesh, Run
from tgvdp.methods.costate.multipliers import ExtremalFront, OutOfTime
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import energy_tables
from tgvdp.runs.bends import enough_rows, most_off_s
from tgvdp.runs.followed import Followed
from tgvdp.runs.profile import Profile

#: How well a point meets its running time by default: a share of the step to the next point.
_STEP_TOL = 0.05
#: Relative difference below which running times are the same.
_SAME = 1e-9
#: How often runs are aimed anew where times are to be met more closely than rows tell them.
_AIMS = 3
#: What a second costs at least where credits pay for seconds, in usual multipliers.
_LEAST_COST = 1e-3
#: The first mesh, in cells of the usual size.
_COARSEST = 0.125


@dataclass
class OptimalRuns:
    """Runs of the front method, in the order of their target times.

    Attributes
    ----------
    duration_s, energy_j : (n,) float64
        Running time, and energy by the trip's model.
    multiplier_j_per_s : (n,) float64
        Multiplier λ of each run: energy saved per second more; infinite for the fastest run.
    complete : bool
        False when the time limit ended the search: the targets before that are met.
    exhausted : bool
        True when running longer saves nothing: the last run is the thriftiest, faster than the last targets.
    counters : dict of str to int
        Cells of the mesh that was fine enough, and work done on all meshes: extremals, runs, costates.
    missed_s : tuple of float
        Targets that no run meets, as running times jump over them: a faster run stands for each, or none.
    """

    duration_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]
    multiplier_j_per_s: NDArray[np.float64]
    complete: bool
    exhausted: bool
    counters: dict[str, int]
    _parts: Sequence[Followed]
    missed_s: tuple[float, ...] = ()

    def regimes(self, index: int) -> NDArray[np.int8] | None:
        """Regime of each row of one run as `runs.profile` numbers them, where it was commanded; −1 elsewhere."""
        part, at = self._at(index)
        return part.regimes(at)

    def rows(self, index: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Rows of one run: positions from the origin, m, and squared speeds, m²/s²."""
        part, at = self._at(index)
        return part.runs.run(at)

    def part(self, index: int) -> Followed:
        """One run."""
        part, at = self._at(index)
        return part.part(at)

    def _at(self, index: int) -> tuple[Followed, int]:
        """The part that has one of the runs, and its number there."""
        index = range(len(self.duration_s))[index]
        for part in self._parts:
            if index < part.runs.size:
                return part, index
            index -= part.runs.size
        raise IndexError("there are fewer runs")


def optimal_front(
    trip: Trip,
    fastest: Profile,
    target_s: NDArray[np.float64],
    budget: SearchBudget,
    tolerance_s: float | None = None,
    min_phase_s: float = 0.0,
    *,
    rough: bool = False,
) -> OptimalRuns:
    """Least energy of the continuous problem at given running times.

    Parameters
    ----------
    trip : Trip
    fastest : Profile
        Its fastest run, which is the point for every target that it meets.
    target_s : (n,) float64
        Increasing running times, s.
    budget : SearchBudget
    tolerance_s : float, optional
        How well running times are met, s; by default a small share of the smallest step between them.
    min_phase_s : float
        Shorter phases of driving, s, are left out of the runs where that costs next to nothing; 0 leaves all.
    rough : bool
        Whether cells are taken as they come, for plans: runs are feasible and met, some may be a little too dear.

    Returns
    -------
    OptimalRuns
        One run for each target, or for those before the budget ended; none is later than its target. Where running
        times jump over a target, and no blend meets it, a faster run stands for it, or none, and `missed_s` names it.
        Where no slower run saves energy any more, the front ends with the thriftiest run.

    Raises
    ------
    NumericalError
        When the costate program fails; it never returns a wrong front in silence.
    """
    clock = budget.start()
    counters = {"cells": 0, "extremals": 0, "runs": 0, "costates": 0, "short": 0}
    slower_s = target_s[target_s > fastest.duration_s * (1.0 + _SAME)]
    if tolerance_s is None:
        times_s = np.concatenate(([fastest.duration_s], slower_s))
        tolerance_s = _STEP_TOL * float((times_s[1:] - times_s[:-1]).min(initial=math.inf))
    rows = fastest.position_m - trip.origin_m, fastest.speed_mps**2
    met = len(target_s) - len(slower_s)
    known = Found.of([Run(fastest.duration_s, fastest.total_energy_j, math.inf, *rows)] * met) if met else Found.none()
    # No point is later than its target: a timetable allows for no more. Cutting rows may make a run later.
    half_s = 0.5 * tolerance_s
    middle_s = slower_s - half_s
    last_s = float(target_s.max(initial=0.0))
    rows_per_usual = enough_rows(resolve(trip), last_s, 0.25 * half_s)
    meets_s = max(half_s - most_off_s(last_s, rows_per_usual), 0.5 * half_s)
    search = _Search(
        trip, fastest, rows_per_usual, meets_s, min_phase_s, counters, clock, Doubt(0) if rough else Doubt(), known
    )
    aims_s = middle_s
    points = search.points(aims_s)
    for _ in range(_AIMS):
        late_s = points.late_s(middle_s)
        if not points.complete or (np.abs(late_s) <= half_s * (1.0 + _SAME)).all():
            break
        aims_s = aims_s - late_s
        points = search.points(aims_s)
    duration, energy, multipliers = points.outcome.T.copy()
    return OptimalRuns(
        duration, energy, np.maximum(multipliers - search.auxiliary_w, 0.0), points.complete, not points.saves,
        counters, points.parts, tuple(slower_s[points.missed].tolist()),
    )  # fmt: skip


class _Driven(NamedTuple):
    """Runs in the order of their times, whether that is all, and whether running longer saves until the last time."""

    found: Found
    complete: bool
    saves: bool


class _Points(NamedTuple):
    """True runs in the order of their times, first those that are known.

    ``outcome`` are their times, energies with auxiliaries, and multipliers, (n, 3); ``aim`` is the number of the time
    that each of the others meets, −1 if none; ``missed`` are those that none meets.
    """

    outcome: NDArray[np.float64]
    parts: list[Followed]
    aim: NDArray[np.intp]
    missed: NDArray[np.intp]
    complete: bool
    saves: bool

    def late_s(self, aims_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """How much later than each aim the run is that meets it, s; 0 where none does."""
        late_s = np.zeros(len(aims_s))
        meets = self.aim >= 0
        aim = self.aim[meets]
        late_s[aim] = self.outcome[len(self.outcome) - len(self.aim) :, 0][meets] - aims_s[aim]
        return late_s


@dataclass
class _Search:
    """The search for the runs that take given times, on a mesh that is fine enough."""

    trip: Trip
    fastest: Profile
    rows: float  # of `KernelTrain`
    tolerance_s: float
    min_phase_s: float
    counters: dict[str, int]
    clock: Clock
    doubt: Doubt
    known: Found
    front: ExtremalFront | None = None  # of the runs that were found

    @cached_property
    def auxiliary_w(self) -> float:
        """What multipliers of extremals have on top."""
        return energy_tables(self.trip.train, self.trip.energy).auxiliary_w

    def points(self, aims_s: NDArray[np.float64]) -> _Points:
        """Runs that are known, and true ones for aims; a second time on the mesh of the first."""
        driven = _Driven(Found.none(), True, True)
        if len(aims_s):
            driven = self._runs(aims_s) if self.front is None else self._driven(self.front, aims_s)
        picked, aim, missed = self._picked(driven, aims_s)
        outcome, complete = self.known.outcome, driven.complete
        parts = [Followed(self.known.rows, None, outcome[:, 0], outcome[:, 1])]
        if len(aim) and self.front is not None:
            wanted_s = np.where(aim >= 0, aims_s[aim], picked.outcome[:, 0])
            true = drivable(
                self.front.mesh, picked, wanted_s, self.tolerance_s, self.min_phase_s, self.counters, self.clock
            )
            outcome = np.concatenate((outcome, true.outcome))
            complete = complete and true.complete
            parts += true.parts
        return _Points(outcome, parts, aim, missed, complete, driven.saves)

    def _picked(self, driven: _Driven, aims_s: NDArray[np.float64]) -> tuple[Found, NDArray[np.intp], NDArray[np.intp]]:
        """Runs driven that are slower than the one before; the aim that each meets, −1 if none; aims missed."""
        time_s = driven.found.outcome[:, 0]
        late_s = time_s - aims_s[: len(time_s)]
        most_s = self.tolerance_s + _SAME * time_s
        is_met = np.abs(late_s) <= most_s
        is_missed = ~is_met
        if len(is_missed) and not driven.saves:
            is_missed[-1] = False  # the thriftiest run
        in_time = np.flatnonzero(late_s <= most_s)
        # A run that is no slower than the last one is among the points already.
        known_s = [float(self.known.outcome[-1, 0]) if self.known.rows.size else -math.inf]
        before_s = np.maximum.accumulate(np.concatenate((known_s, time_s[in_time])))[:-1]
        which = in_time[time_s[in_time] * (1.0 - _SAME) > before_s]
        return driven.found.picked(which), np.where(is_met[which], which, -1), np.flatnonzero(is_missed)

    def _runs(self, aims_s: NDArray[np.float64]) -> _Driven:
        """Runs on a mesh that is fine enough.

        Cells are halved where that makes extremals cheaper, and once more where one is dearer, at its own multiplier,
        than another run that was found.
        """
        found: _Driven | None = None
        if self.clock.expired:
            return _Driven(Found.none(), False, True)
        try:
            mesh = Mesh.of(self.trip, self.fastest, _COARSEST, self.rows)
            while True:
                front = self.doubt.answered(self._foreseen(mesh, aims_s), aims_s)
                driven = self._driven(front, aims_s)
                if found is None or driven.complete:
                    self.counters["cells"] = len(front.mesh.cells.length_m)
                    found, self.front = driven, front
                if not driven.complete or self.doubt.is_settled(front, driven.found.outcome):
                    break
                mesh = front.mesh.finer
        except OutOfTime:
            pass
        return found or _Driven(Found.none(), False, True)

    def _foreseen(self, mesh: Mesh, aims_s: NDArray[np.float64]) -> ExtremalFront:
        least_multiplier, saved_w = self.auxiliary_w, float(mesh.cells.saved_w.max())
        if saved_w > 0.0:  # every second has to cost something: of those that cost nothing a run takes without end
            least_multiplier = max(least_multiplier, saved_w + _LEAST_COST * mesh.usual_multiplier)
        front = ExtremalFront(mesh, self.tolerance_s, least_multiplier, self.counters, self.clock)
        front.reach(float(aims_s[-1]))
        front.foresee(aims_s)
        return front

    def _driven(self, front: ExtremalFront, aims_s: NDArray[np.float64]) -> _Driven:
        try:
            front.reach(float(aims_s[-1]))
        except OutOfTime:
            return _Driven(Found.none(), False, True)
        reached = int(np.sum(aims_s <= front.extremals[-1].time_s + self.tolerance_s))
        saves = reached == len(aims_s)
        found, complete = front.points(aims_s[:reached])
        if complete and not saves:
            found = Found.joined((found, Found.of([front.thriftiest()])))
        return _Driven(found, complete, saves)
