"""The front method: the whole Pareto front from a few multipliers (docs/front-method.md).

Extremals are solved by the costate program for chosen multipliers. Each point of the front drives a blend of the
switching speeds of the two extremals around it that meets its running time; where the blend drives worse than the cubic
through the extremals' (T, E, slope −λ) promises, an extremal is added between them.
"""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.resolved import ResolvedLine, resolve
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.methods.costate.doubt import Doubt
from tgvdp.methods.costate.drivable import drivable
from tgvdp.methods.costate.mesh import Mesh, Run
from tgvdp.methods.costate.multipliers import ExtremalFront, OutOfTime
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import energy_tables
from tgvdp.runs.profile import Profile, profile_of
from tgvdp.runs.resistance_correction import follow

#: How well a point meets its running time by default: a share of the step to the next point.
_STEP_TOL = 0.05
#: Relative difference below which running times are the same.
_SAME = 1e-9
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
    _rows: list[tuple[NDArray[np.float64], NDArray[np.float64]]]
    missed_s: tuple[float, ...] = ()
    _regimes: list[NDArray[np.int8] | None] | None = None

    def regimes(self, index: int) -> NDArray[np.int8] | None:
        """Regime of each row of one run as `runs.profile` numbers them, where it was commanded; −1 elsewhere."""
        return None if self._regimes is None else self._regimes[index]

    def rows(self, index: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Rows of one run: positions from the origin, m, and squared speeds, m²/s²."""
        return self._rows[index]


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
    slower = target_s > fastest.duration_s * (1.0 + _SAME)
    if tolerance_s is None:
        times_s = [fastest.duration_s, *target_s[slower].tolist()]
        tolerance_s = _STEP_TOL * min((later_s - time_s for time_s, later_s in pairwise(times_s)), default=math.inf)
    auxiliary_w = energy_tables(trip.train, trip.energy).auxiliary_w
    traction_j = fastest.total_energy_j - auxiliary_w * fastest.duration_s
    # No point is later than its target: a timetable allows for no more.
    half_s = 0.5 * tolerance_s
    aims_s = target_s[slower] - half_s
    search = _Search(trip, fastest, aims_s, half_s, auxiliary_w, counters, clock, Doubt(0) if rough else Doubt())
    runs, complete, saves = search.runs() if slower.any() else _Found([], True, True)
    rows = fastest.position_m - trip.origin_m, fastest.speed_mps**2
    met = int(np.sum(~slower))
    found = [Run(fastest.duration_s, traction_j, math.inf, *rows)] * met
    missed_s: list[float] = []
    for aim_s, run in zip(aims_s.tolist(), runs, strict=False):
        if abs(run.time_s - aim_s) > half_s * (1.0 + _SAME) and (saves or run is not runs[-1]):
            missed_s.append(aim_s + half_s)
        # A run that is no slower than the last one is among the points already.
        if run.time_s <= (aim_s + half_s) * (1.0 + _SAME) and (
            not found or run.time_s > found[-1].time_s * (1.0 + _SAME)
        ):
            found.append(run)
    line = resolve(trip)
    regimes: list[NDArray[np.int8] | None] = [None] * len(found)
    if search.mesh is not None and min_phase_s > 0.0:
        found[met:], regimes[met:], in_time = drivable(
            search.mesh, found[met:], aims_s, half_s, min_phase_s, counters, clock
        )
        complete = complete and in_time
    for i in range(met, len(found)):
        found[i], regimes[i] = _followed(trip, line, found[i], regimes[i], auxiliary_w)
    duration, energy, multipliers = np.array([run[:3] for run in found], dtype=np.float64).reshape(-1, 3).T.copy()
    return OptimalRuns(
        duration, energy + auxiliary_w * duration, np.maximum(multipliers - auxiliary_w, 0.0), complete, not saves,
        counters, [(run.x_m, run.w) for run in found], tuple(missed_s), regimes,
    )  # fmt: skip


def _followed(
    trip: Trip, line: ResolvedLine, run: Run, regime: NDArray[np.int8] | None, auxiliary_w: float
) -> tuple[Run, NDArray[np.int8] | None]:
    """The run with its true resistance, and rows cut where an effort drops: its time is another then."""
    x_m, w = follow(trip.train, line, run.x_m, run.w)
    if len(x_m) == len(run.x_m):
        return run._replace(x_m=x_m, w=w), regime
    if regime is not None:
        regime = regime[np.searchsorted(run.x_m, 0.5 * (x_m[1:] + x_m[:-1])) - 1]
    profile = profile_of(trip, x_m, w)
    energy_j = profile.total_energy_j - auxiliary_w * profile.duration_s
    return Run(profile.duration_s, energy_j, run.multiplier, x_m, w), regime


class _Found(NamedTuple):
    """Runs in the order of their times, whether that is all, and whether running longer saves until the last time."""

    runs: list[Run]
    complete: bool
    saves: bool


@dataclass
class _Search:
    """The search for the runs that take given times, on a mesh that is fine enough."""

    trip: Trip
    fastest: Profile
    aims_s: NDArray[np.float64]
    tolerance_s: float
    least_multiplier: float
    counters: dict[str, int]
    clock: Clock
    doubt: Doubt
    mesh: Mesh | None = None  # of the runs that were found

    def runs(self) -> _Found:
        """Runs on a mesh that is fine enough.

        Cells are halved where that makes extremals cheaper, and once more where one is dearer, at its own multiplier,
        than another run that was found.
        """
        found: _Found | None = None
        if self.clock.expired:
            return _Found([], False, True)
        try:
            mesh = Mesh.of(self.trip, self.fastest, _COARSEST)
            while True:
                front = self.doubt.answered(self._foreseen(mesh))
                mesh = front.mesh
                driven = self._driven(front)
                if found is None or driven.complete:
                    self.counters["cells"] = len(mesh.cells.length_m)
                    found, self.mesh = driven, mesh
                if not driven.complete or self.doubt.is_settled(front, driven.runs):
                    break
        except OutOfTime:
            pass
        return found or _Found([], False, True)

    def _foreseen(self, mesh: Mesh) -> ExtremalFront:
        least_multiplier, saved_w = self.least_multiplier, float(mesh.cells.saved_w.max())
        if saved_w > 0.0:  # every second has to cost something: of those that cost nothing a run takes without end
            least_multiplier = max(least_multiplier, saved_w + _LEAST_COST * mesh.usual_multiplier)
        front = ExtremalFront(mesh, self.tolerance_s, least_multiplier, self.counters, self.clock)
        front.reach(float(self.aims_s[-1]))
        front.foresee(self.aims_s)
        return front

    def _driven(self, front: ExtremalFront) -> _Found:
        front.reach(float(self.aims_s[-1]))
        reached = int(np.sum(self.aims_s <= front.extremals[-1].time_s + self.tolerance_s))
        saves = reached == len(self.aims_s)
        runs: list[Run] = []
        try:
            runs.extend(front.points(self.aims_s[:reached]))
            if not saves:
                runs.append(front.thriftiest())
        except OutOfTime:
            return _Found(runs, False, saves)
        return _Found(runs, True, saves)
