"""Extremals of the generic refinement in the order of their running times, and the runs between them."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.budget import Clock
from tgvdp.methods.costate.extremal import Extremal, between
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.refine.convex_map import relaxed_tables
from tgvdp.methods.refine.guide import Guide
from tgvdp.methods.refine.mesh import HALF, SHRINK, WIDEST, Level
from tgvdp.physics.energy import EnergyTables
from tgvdp.physics.roots import Bracket
from tgvdp.progress import tell
from tgvdp.runs.profile import Profile

#: Starts are compared on every so-many-th station, after steps that shrink to this share of the largest v²; the best
#: one goes on there on all stations, to the last step. One start comes from a grid on fewer stations yet.
_COMPARED_EVERY, _GRID_EVERY = 4, 8
_COMPARED_STEP = 1e-3
_FIRST_STEP = _COMPARED_STEP / SHRINK**2
_LAST_STEP = 1e-7
#: Two multipliers within this factor are neighbours: the run between them starts from their blend, too. Runs further
#: apart may differ in where they coast, which sweeps cannot mend (0.15 % on a line with 150 gradients).
_NEAR = 2.0
#: Largest share of energy by which a point may lie above the tangents of its neighbouring runs.
_GAP = 1e-4
#: A run that switches is aimed again so often at most, each time planned with this share of the tolerance.
_AIMS = 6
_PLAN_SHARE = 0.3
#: Step of ln λ towards slower runs, and how many steps without saving end the front.
_MARCH = 1.0
_IDLE_STEPS = 6
#: Relative difference below which running times, energies or multipliers are the same.
_SAME = 1e-9
_MOST_EXTREMALS = 250


class Extremals:
    """Extremals of one mesh, with the envelope as the first; more are solved where a time is asked for."""

    def __init__(self, mesh: Mesh, fastest: Profile, energy: EnergyTables) -> None:
        self.mesh = mesh
        self.energy, self.relaxed = energy, relaxed_tables(mesh.trip.train, energy)
        self.guide = Guide(mesh.trip, fastest, self.relaxed)
        self.level = Level(mesh.trip, mesh.train, mesh.cells)
        self.grid, self.compared = (
            self.level.coarser(energy, every) or self.level for every in (_GRID_EVERY, _COMPARED_EVERY)
        )
        fast = self.level.fast
        self.extremals = [Extremal(math.inf, fast, *self.level.measured(energy, fast))]
        self.multiplier = mesh.usual_multiplier
        self.scale_j = mesh.usual_multiplier * self.extremals[0].time_s
        self.idle = 0
        self.closed: set[tuple[float, float]] = set()
        self.dents: dict[tuple[float, float], list[Extremal]] = {}

    def asked(self, tolerance_s: float, counters: dict[str, int], clock: Clock, holds: bool) -> "Extremals":
        """These extremals, for times that have to be met so closely, in the time that a clock leaves.

        Where T jumps, runs that hold a time are sought, or blends are taken, which is several times as fast.
        """
        self.tolerance_s, self.counters, self.clock, self.holds = tolerance_s, counters, clock, holds
        return self

    def mesh_error(self) -> float:
        """What one acceleration per cell adds to the cost of the guide's run, as a share of energy."""
        run = self.guide.run(self.multiplier)
        if run is None:
            return 0.0
        tables = self.guide.tables
        time_s, energy_j = self.level.measured(tables, self.level.followed(run.x_m, run.w))
        if math.isinf(energy_j):  # cut to what is feasible it still is not: no run to compare with
            return 0.0
        late_j = (self.multiplier + tables.auxiliary_w) * run.time_s - self.multiplier * time_s
        return abs(energy_j - run.energy_j - late_j) / max(abs(energy_j), 0.1 * self.scale_j)

    def _solve(self, multiplier: float, *known: NDArray[np.float64]) -> Extremal:
        """Run of least E + λT: the best of those that all starts lead to, among them runs that are known."""
        self.counters["extremals"] += 1
        best, least_j = self.compared.fast, math.inf
        for w in (*self._starts(multiplier), *(self.compared.carried(self.level, one) for one in known)):
            self._descend(self.compared, multiplier, w, HALF, _FIRST_STEP, _COMPARED_STEP)
            time_s, energy_j = self.compared.measured(self.relaxed, w)
            if energy_j + multiplier * time_s < least_j:
                best, least_j = w, energy_j + multiplier * time_s
        w = self.level.carried(self.compared, best)
        self._descend(self.level, multiplier, w, HALF, _COMPARED_STEP, _LAST_STEP)
        return Extremal(multiplier, w, *self.level.measured(self.relaxed, w))

    def _descend(
        self, level: Level, multiplier: float, w: NDArray[np.float64], half: int, first: float, last: float
    ) -> None:
        self.counters["sweeps"] += level.descend(self.relaxed, multiplier, w, half, first, last, self.clock)

    def _starts(self, multiplier: float) -> Iterator[NDArray[np.float64]]:
        """Runs that are optimal but for details, made of nothing: of the costate program, and of a coarse grid."""
        run = self.guide.run(multiplier)
        if run is not None:
            yield self.compared.followed(run.x_m, run.w)
        w = self.grid.fast.copy()
        step = 1.0 / WIDEST
        self._descend(self.grid, multiplier, w, WIDEST, step, step)
        self._descend(self.grid, multiplier, w, HALF, 0.5 * step, _COMPARED_STEP)
        yield self.compared.carried(self.grid, w)

    def reach(self, target_s: float) -> bool:
        """March λ down until an extremal takes the target time; False when running longer saves nothing."""
        while self.extremals[-1].time_s < target_s - self.tolerance_s:
            if self.idle >= _IDLE_STEPS:
                return False
            extremal = self._solve(self.multiplier)
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
            least_j = _tangents_j(before, after, found.time_s)
            enough_j = _GAP * max(abs(found.energy_j), 0.1 * self.scale_j)
            if found.energy_j - least_j <= enough_j:
                return found
            if not self._split(second):
                held = self._held(second, target_s, enough_j) if self.holds else found
                if held is not None:
                    return held

    def _held(self, second: int, target_s: float, enough_j: float) -> Extremal | None:
        """Run for a time over which T jumps; None where it leads to a run below the chord, which is one more extremal.

        Blends of two runs of different structure may be a quarter dearer than a run that is improved at its own time.
        Runs that are known of such times are blended where they are near enough.
        """
        before, after = self.extremals[second - 1], self.extremals[second]
        dent = self.dents.setdefault((before.time_s, after.time_s), [before, after])
        at = next((i for i in range(1, len(dent)) if dent[i].time_s >= target_s), len(dent) - 1)
        found = self._meet(dent[at - 1], dent[at], target_s)
        if found.energy_j - _chord_j(dent[at - 1], dent[at], found.time_s) <= enough_j:
            return found
        run = self._hold(dent[at - 1], dent[at], found)
        if not dent[at - 1].time_s < run.time_s < dent[at].time_s or run.energy_j >= found.energy_j:
            return found
        if len(self.extremals) < _MOST_EXTREMALS and run.energy_j < _chord_j(before, after, run.time_s):
            chord, w = _chord(before, after), run.switch.copy()
            self._descend(self.level, chord, w, HALF, _COMPARED_STEP, _LAST_STEP)
            if self._insert(second, Extremal(chord, w, *self.level.measured(self.relaxed, w))):
                return None
        dent.insert(at, run)
        return (
            self._meet(dent[at - 1], run, target_s)
            if run.time_s >= target_s
            else self._meet(run, dent[at + 1], target_s)
        )

    def _hold(self, quick: Extremal, late: Extremal, blended: Extremal) -> Extremal:
        """The best run of the time of a blend, from that and from runs that go from one to the other on the way."""
        self.counters["extremals"] += 1
        time_s, best, least_j, price = blended.time_s, blended.switch, math.inf, _chord(quick, late)
        for start in (blended.switch, self._changed(quick, late, time_s), self._changed(late, quick, time_s)):
            w = self.compared.carried(self.level, start)
            if math.isinf(self.compared.measured(self.relaxed, w)[1]):
                continue
            sweeps, multiplier = self.compared.hold(
                self.relaxed, price, w, time_s, _FIRST_STEP, _COMPARED_STEP, self.clock
            )
            self.counters["sweeps"] += sweeps
            own_s, energy_j = self.compared.measured(self.relaxed, w)
            energy_j += multiplier * (own_s - time_s)
            if energy_j < least_j:
                best, least_j = self.level.carried(self.compared, w), energy_j
        self.counters["sweeps"] += self.level.hold(
            self.relaxed, price, best, time_s, _COMPARED_STEP, _LAST_STEP, self.clock
        )[0]
        return Extremal(blended.multiplier, best, *self.level.measured(self.relaxed, best))

    def _changed(self, first: Extremal, second: Extremal, time_s: float) -> NDArray[np.float64]:
        """Run that is one up to a station and another from there, as near to a time as the stations allow."""
        low, high = 0, len(first.switch)
        while True:
            middle = (low + high) // 2
            w = np.concatenate((first.switch[:middle], second.switch[middle:]))
            w = self._blend(w, w, 0.0)
            if high - low <= 1:
                return w
            is_late = self.level.measured(self.relaxed, w)[0] > time_s
            if is_late == (first.time_s > second.time_s):
                high = middle
            else:
                low = middle

    def _split(self, second: int) -> bool:
        """Solve the multiplier of the chord between two neighbouring extremals; False when the chord is the front."""
        before, after = self.extremals[second - 1], self.extremals[second]
        chord = _chord(before, after)
        pair = before.time_s, after.time_s
        if len(self.extremals) >= _MOST_EXTREMALS or pair in self.closed or chord <= 0.0:
            return False
        near = before.multiplier < _NEAR * after.multiplier
        known = [self._blend(before.switch, after.switch, 0.5)] if near else []
        if not before.multiplier > chord > after.multiplier:  # one of them is beaten by the other at its own multiplier
            known += [before.switch, after.switch]
        middle = self._solve(chord, *known)
        if not self._insert(second, middle):  # no run is below the chord, which then is the tangent of both
            self.closed.add(pair)
            self.extremals[second - 1], self.extremals[second] = (
                before._replace(multiplier=chord),
                after._replace(multiplier=chord),
            )
        return True

    def _insert(self, second: int, middle: Extremal) -> bool:
        """Take a run in between two neighbours if it is below their chord."""
        before, after = self.extremals[second - 1], self.extremals[second]
        saved = before.cost_j(middle.multiplier) - middle.cost_j(middle.multiplier)
        inside = before.time_s < middle.time_s < after.time_s and after.energy_j < middle.energy_j < before.energy_j
        if inside and saved > _SAME * self.scale_j:
            self.extremals.insert(second, middle)
            return True
        return False

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
        return run._replace(multiplier=between(before, after, run.time_s).multiplier)


def _chord(before: Extremal, after: Extremal) -> float:
    """Energy saved per second more between two extremals, J/s."""
    return (before.energy_j - after.energy_j) / (after.time_s - before.time_s)


def _chord_j(before: Extremal, after: Extremal, time_s: float) -> float:
    """Energy at a time on the chord of two extremals, J."""
    return before.energy_j + _chord(before, after) * (before.time_s - time_s)


def _tangents_j(before: Extremal, after: Extremal, time_s: float) -> float:
    """Energy below which no run of a time between two extremals is known to be, by the tangents of both.

    One that is beaten by the other at its own multiplier is no optimum there: its tangent says nothing.
    """
    chord = _chord(before, after)
    least_j = -math.inf
    if chord <= before.multiplier < math.inf:
        least_j = before.energy_j + before.multiplier * (before.time_s - time_s)
    if after.multiplier <= chord:
        least_j = max(least_j, after.energy_j + after.multiplier * (after.time_s - time_s))
    return least_j
