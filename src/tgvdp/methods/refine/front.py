"""The generic refinement: the front for any energy of an arc, by discrete differential dynamic programming.

For each of a few multipliers λ the run of least E + λT is found by repeated dynamic programs over a few speeds around
an incumbent, with ever smaller steps (docs/refine.md). Between two neighbouring runs the front lies above their
tangents, so that multipliers are added only until a blend of the two is as good as any run could be.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import NumericalError
from tgvdp.line.resolved import resolve
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.methods.costate.extremal import Extremal, between
from tgvdp.methods.costate.front import OptimalRuns
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.costate.multipliers import OutOfTime
from tgvdp.methods.refine.convex_map import relaxed_tables
from tgvdp.methods.refine.mesh import WIDEST, Level, mesh_for
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import EnergyTables, energy_tables
from tgvdp.physics.roots import Bracket
from tgvdp.progress import tell
from tgvdp.runs.profile import Profile, profile_of
from tgvdp.runs.resistance_correction import follow

#: Speeds above and below the incumbent in a sweep.
_HALF = 2
#: The first step between those speeds: a share of the distance between two neighbouring runs, and at least this share
#: of the largest v² of the trip.
_STEP_SHARE = 0.15
_LEAST_STEP = 1e-3
#: The last step, as a share of the largest v²; on the coarser level it ends earlier.
_LAST_STEP = 1e-5
_LAST_COARSE_STEP = 1e-3
#: Two multipliers within this factor are neighbours: the run between them starts from their blend. Runs further apart
#: may differ in where they coast, which sweeps cannot mend (0.15 % on a line with 150 gradients).
_NEAR = 2.0
#: Largest share of energy by which a point may lie above the tangents of its neighbouring runs.
_GAP = 6e-4
#: Cells are so many times as fine as those of the front method, whose cells hold more than one arc.
_FINENESS = 2.5
#: They are made finer, this far at most, until the mesh's own fastest run is as fast as the true one to this share.
_MESH_ERROR = 2e-4
_FINEST = 16.0
#: How well a point meets its running time by default: a share of the step to the next point.
_STEP_TOL = 0.03
#: ... a run that switches is aimed again so often at most, each time planned with this share of the tolerance.
_AIMS = 6
_PLAN_SHARE = 0.3
#: Step of ln λ towards slower runs, and how many steps without saving end the front.
_MARCH = 1.0
_IDLE_STEPS = 6
#: Relative difference below which running times, energies or multipliers are the same.
_SAME = 1e-9
_MOST_EXTREMALS = 250


def refine_front(
    trip: Trip,
    fastest: Profile,
    target_s: NDArray[np.float64],
    budget: SearchBudget,
    tolerance_s: float | None = None,
) -> OptimalRuns:
    """Least energy, by any energy model, at given running times.

    Parameters
    ----------
    trip : Trip
    fastest : Profile
        Its fastest run, which is the point for every target that it meets.
    target_s : (n,) float64
        Increasing running times, s.
    budget : SearchBudget
        Its time limit is looked at between sweeps.
    tolerance_s : float, optional
        How well running times are met, s; by default a small share of the smallest step between them.

    Returns
    -------
    OptimalRuns
        As `tgvdp.methods.costate.front.optimal_front` returns it, with the energy of the trip's model.

    Raises
    ------
    NumericalError
        When no run with one constant acceleration per cell is as fast as the envelope.
    """
    clock, line = budget.start(), resolve(trip)
    energy = energy_tables(trip.train, trip.energy)
    if tolerance_s is None:
        tolerance_s = _STEP_TOL * float(np.diff(target_s, prepend=0.0).min())
    slower = target_s > fastest.duration_s * (1.0 + _SAME)
    counters = {"extremals": 0, "sweeps": 0, "blends": 0}
    first_rows = fastest.position_m - trip.origin_m, fastest.speed_mps**2
    found = [(fastest.duration_s, fastest.total_energy_j, math.inf)] * int(np.sum(~slower))
    rows = [first_rows] * len(found)
    complete, saves = True, True
    try:
        half_s = 0.5 * tolerance_s  # as of the front method, no point is later than its target
        if slower.any():
            front = _front_on_fine_mesh(trip, fastest, energy, half_s, counters, clock)
        for middle_s in (target_s[slower] - half_s).tolist():
            saves = front.reach(middle_s)
            aim_s = middle_s
            for _ in range(_AIMS):
                point = front.point(aim_s) if saves else front.thriftiest()
                x_m, w = follow(trip.train, line, *front.rows(point))
                run = profile_of(trip, x_m, w)  # across a drop of traction a train is slower than its arcs
                late_s = run.duration_s - middle_s
                if not saves or abs(late_s) <= half_s:
                    break
                aim_s -= late_s
            rows.append((x_m, w))
            found.append((run.duration_s, run.total_energy_j, point.multiplier))
            if not saves:
                break
    except OutOfTime:
        complete = False
    duration, joules, multipliers = np.array(found, dtype=np.float64).reshape(-1, 3).T
    return OptimalRuns(duration, joules, multipliers, complete, not saves, counters, rows)


def _front_on_fine_mesh(
    trip: Trip,
    fastest: Profile,
    energy: EnergyTables,
    tolerance_s: float,
    counters: dict[str, int],
    clock: Clock,
) -> "_Front":
    """A mesh so fine that its fastest run, with one acceleration per cell, takes the time of the true one."""
    fineness, before_s = _FINENESS, math.inf
    while True:
        front = _Front(mesh_for(trip, fastest, fineness), energy, tolerance_s, counters, clock)
        reference = front.extremals[0]
        drivable = math.isfinite(reference.energy_j)
        nearest_s = min(abs(reference.time_s - known_s) for known_s in (fastest.duration_s, before_s))
        if drivable and (nearest_s <= _MESH_ERROR * fastest.duration_s or fineness >= _FINEST):
            return front
        if fineness >= _FINEST:
            raise NumericalError("the refinement finds no fastest run with one acceleration per cell")
        if clock.expired:
            raise OutOfTime
        fineness, before_s = 2.0 * fineness, reference.time_s


class _Front:
    """Extremals in the order of their running times, and the runs between them."""

    def __init__(
        self, mesh: Mesh, energy: EnergyTables, tolerance_s: float, counters: dict[str, int], clock: Clock
    ) -> None:
        self.mesh, self.tolerance_s, self.counters, self.clock = mesh, tolerance_s, counters, clock
        self.energy, self.relaxed = energy, relaxed_tables(mesh.trip.train, energy)
        self.level = Level(mesh.trip, mesh.train, mesh.cells, clock)
        self.coarse = self.level.coarser(energy)
        fast = self.level.fast
        self.extremals = [Extremal(math.inf, fast, *self.level.measured(energy, fast))]
        self.multiplier = mesh.usual_multiplier
        self.scale_j = mesh.usual_multiplier * self.extremals[0].time_s
        self.idle = 0

    def _solve(self, multiplier: float, start: NDArray[np.float64] | None, step: float) -> Extremal:
        """Run of least E + λT: from a feasible run near it, or from nothing."""
        self.counters["extremals"] += 1
        if start is None:
            start, step = self._start(multiplier)
        step = max(step, _LEAST_STEP)
        self.counters["sweeps"] += self.level.descend(self.relaxed, multiplier, start, _HALF, step, _LAST_STEP)
        return Extremal(multiplier, start, *self.level.measured(self.relaxed, start))

    def _start(self, multiplier: float) -> tuple[NDArray[np.float64], float]:
        """A run that is optimal but for details, from nothing, and the step that the next program should take."""
        level = self.level if self.coarse is None else self.coarse
        w = level.fast.copy()
        step = 1.0 / WIDEST
        self.counters["sweeps"] += level.descend(self.relaxed, multiplier, w, WIDEST, step, step)
        if self.coarse is None:
            return w, 0.5 * step
        self.counters["sweeps"] += level.descend(self.relaxed, multiplier, w, _HALF, 0.5 * step, _LAST_COARSE_STEP)
        return self.level.carried(level, w), _LAST_COARSE_STEP

    def reach(self, target_s: float) -> bool:
        """March λ down until an extremal takes the target time; False when running longer saves nothing."""
        while self.extremals[-1].time_s < target_s - self.tolerance_s:
            if self.idle >= _IDLE_STEPS:
                return False
            extremal = self._solve(self.multiplier, None, 0.0)
            last = self.extremals[-1]
            if extremal.energy_j < last.energy_j - _SAME * self.scale_j and extremal.time_s > last.time_s:
                self.extremals.append(extremal)
                self.idle = 0
            else:
                self.idle += 1
            self.multiplier *= math.exp(-_MARCH)
        return True

    def thriftiest(self) -> Extremal:
        """The slowest extremal, driven."""
        last = self.extremals[-1]
        return (
            last
            if self.relaxed is self.energy
            else Extremal(last.multiplier, last.switch, *self._switched(last.switch))
        )

    def point(self, target_s: float) -> Extremal:
        """The best run for one running time; to switch between efforts takes a little longer than planned."""
        run = self._planned(target_s)
        if self.relaxed is self.energy:
            return run
        aim_s = target_s
        for _ in range(_AIMS):
            driven = Extremal(run.multiplier, run.switch, *self._switched(run.switch))
            if abs(driven.time_s - target_s) <= self.tolerance_s:
                break
            aim_s -= driven.time_s - target_s
            run = self._planned(aim_s)
        return driven

    def _planned(self, target_s: float) -> Extremal:
        """Run of the relaxed problem for one running time: a blend of the extremals around it."""
        if len(self.extremals) == 1:  # with one acceleration per cell even the fastest run takes as long as that
            return self.extremals[0]
        while True:
            tell("searching", **self.counters)
            second = next((i for i in range(1, len(self.extremals)) if self.extremals[i].time_s >= target_s), None)
            second = len(self.extremals) - 1 if second is None else second
            before, after = self.extremals[second - 1], self.extremals[second]
            found = self._meet(before, after, target_s)
            least_j = max(
                extremal.energy_j + extremal.multiplier * (extremal.time_s - found.time_s)
                for extremal in (before, after)
                if math.isfinite(extremal.multiplier)
            )
            enough_j = _GAP * max(abs(found.energy_j), 0.1 * self.scale_j)
            if found.energy_j - least_j <= enough_j or not self._split(second):
                return found

    def _split(self, second: int) -> bool:
        """Solve the multiplier of the chord between two neighbouring extremals; False when the chord is the front."""
        before, after = self.extremals[second - 1], self.extremals[second]
        chord = (before.energy_j - after.energy_j) / (after.time_s - before.time_s)
        if len(self.extremals) >= _MOST_EXTREMALS or not before.multiplier > chord > after.multiplier * (1.0 + _SAME):
            return False
        start = self._blend(before.switch, after.switch, 0.5) if before.multiplier < _NEAR * after.multiplier else None
        apart = float(np.abs(before.switch - after.switch).max())
        middle = self._solve(chord, start, _STEP_SHARE * apart / self.level.top_w)
        saved = before.cost_j(chord) - middle.cost_j(chord)
        inside = before.time_s < middle.time_s < after.time_s and after.energy_j < middle.energy_j < before.energy_j
        if inside and saved > _SAME * self.scale_j:
            self.extremals.insert(second, middle)
        else:  # no run is below the chord, which then is the tangent of both
            self.extremals[second - 1], self.extremals[second] = (
                replace(before, multiplier=chord),
                replace(after, multiplier=chord),
            )
        return True

    def _blend(self, first: NDArray[np.float64], second: NDArray[np.float64], share: float) -> NDArray[np.float64]:
        self.counters["blends"] += 1
        return self.level.blend(first, second, share)

    def rows(self, run: Extremal) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Rows of a run that is returned: positions from the origin, m, and squared speeds, m²/s²."""
        if self.relaxed is self.energy:
            return self.level.cells.station_m, run.switch
        return self.level.switched(self.energy, self.relaxed, run.switch)[2:]

    def _switched(self, w: NDArray[np.float64]) -> tuple[float, float]:
        return self.level.switched(self.energy, self.relaxed, w)[:2]

    def _meet(self, before: Extremal, after: Extremal, target_s: float) -> Extremal:
        """Blend of two extremals that takes the target time (Illinois rule)."""
        tolerance_s = self.tolerance_s * (1.0 if self.relaxed is self.energy else _PLAN_SHARE)
        bracket = Bracket(0.0, 1.0, before.time_s - target_s, after.time_s - target_s)
        if bracket.f_lo >= 0.0 or bracket.f_hi <= 0.0:
            return before if bracket.f_lo >= 0.0 else after
        run = before
        for _ in range(40):
            share = bracket.secant()
            w = self._blend(before.switch, after.switch, share)
            run = Extremal(0.0, w, *self.level.measured(self.relaxed, w))
            f = run.time_s - target_s
            if abs(f) <= tolerance_s or bracket.hi - bracket.lo < _SAME:
                break
            bracket = bracket.narrowed(share, f)
        return replace(run, multiplier=between(before, after, run.time_s).multiplier)
