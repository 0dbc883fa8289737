"""Extremals of one mesh in the order of their running times, and the blends of their policies between them.

They are added where a blend drives worse than the extremals around it foretell, and where the tangents through these
leave room for more than that.
"""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.budget import Clock
from tgvdp.methods.costate.blend import Blend, blend_of
from tgvdp.methods.costate.bridge import bridge
from tgvdp.methods.costate.extremal import Extremal, between, tangent_gap
from tgvdp.methods.costate.mesh import Interval, Mesh, Run
from tgvdp.physics.codes import NOT_KEPT, NOT_MET
from tgvdp.progress import tell

#: A blend of two extremals may cost this share of energy more than they foretell.
_BLEND_LOSS = 5e-5
#: First multiplier, in usual ones, and the factor from it to the fastest run, whose multiplier is infinite.
_FIRST_MULTIPLIER = 4.0
#: Step of ln λ towards slower runs, and how many steps without saving end the front.
_MARCH = 0.5
_IDLE_STEPS = 12
#: Between two extremals the front lies above their tangents; where these leave more room than this share of energy
#: below the chord, the front may bend in a way that they do not foretell: unless they foretold one between them.
_BEND = 5e-3
#: ... but of no less than this share of the energy of the fastest run: a net energy may be 0.
_LEAST_SHARE = 0.1
#: Two multipliers whose logarithms differ by less are one.
_SAME_MULTIPLIER = 2e-3
#: Multipliers beyond this multiple of the usual one are infinite.
_HIGHEST_MULTIPLIER = 1e12
#: Relative difference below which running times or energies are the same.
_SAME = 1e-9
_MOST_EXTREMALS = 250
#: Runs between two looks at the clock, at most.
_AT_ONCE = 50
#: A mesh is too coarse when an extremal is dearer, at its own multiplier, than another run by this share of the energy.
_EXTREMAL_LOSS = 5e-4


class OutOfTime(Exception):
    """The time limit has passed: what was found until then stands."""


class ExtremalFront:
    """Extremals in the order of their running times, fewer and fewer joules, and the blends between them.

    Energies are without auxiliaries, multipliers with them: E + λT of a run that draws P at any time is E' + (λ + P)·T,
    so that P is the least multiplier there is.
    """

    def __init__(
        self, mesh: Mesh, tolerance_s: float, least_multiplier: float, counters: dict[str, int], clock: Clock
    ) -> None:
        self.mesh = mesh
        self.tolerance_s = tolerance_s
        self.least_multiplier = least_multiplier
        self.counters = counters
        self.clock = clock
        self.extremals = [mesh.extremal(math.inf, self.counters)]
        self.scale_j = mesh.usual_multiplier * self.extremals[0].time_s
        self.multiplier = max(_FIRST_MULTIPLIER * mesh.usual_multiplier, least_multiplier)
        self.idle = 0
        self.foretold: set[float] = set()
        self.interval: Interval | None = None

    def on(self, mesh: Mesh, extremals: Sequence[Extremal]) -> "ExtremalFront":
        """The front on another mesh, from extremals that were solved on it in place of this one's."""
        front = ExtremalFront(mesh, self.tolerance_s, self.least_multiplier, self.counters, self.clock)
        front.foretold = self.foretold
        for extremal in extremals:
            front._append(extremal)
            front.multiplier = self._after(extremal.multiplier)
        return front

    def _after(self, multiplier: float) -> float:
        """The next multiplier of the march to slower runs."""
        return max(multiplier * math.exp(-_MARCH), self.least_multiplier)

    def _append(self, extremal: Extremal) -> bool:
        """Take an extremal in behind the last one, unless it saves nothing against that."""
        last = self.extremals[-1]
        saves = extremal.energy_j < last.energy_j - _SAME * self.scale_j and extremal.time_s > last.time_s
        if saves:
            self.extremals.append(extremal)
        return saves

    def reach(self, first_s: float, last_s: float) -> bool:
        """March λ down until an extremal takes the last time, and up until one is no slower than the first.

        False when running longer saves nothing.
        """
        saves = self._march_down(last_s)
        while (
            len(self.extremals) > 1
            and math.isinf(self.extremals[0].multiplier)
            and self.extremals[1].time_s > first_s
            and self._pieces(*self.extremals[:2]) > 1
        ):
            self.watch()
            if not self._split(1):
                break
        return saves

    def _march_down(self, target_s: float) -> bool:
        while len(self.extremals) < 2 or self.extremals[-1].time_s < target_s - self.tolerance_s:
            if self.idle >= _IDLE_STEPS:
                return False
            self.watch()
            is_slower = self._append(self.mesh.extremal(self.multiplier, self.counters))
            self.idle = 0 if is_slower else self.idle + 1
            if self.multiplier <= self.least_multiplier:
                self.idle = _IDLE_STEPS
            self.multiplier = self._after(self.multiplier)
        return True

    def watch(self) -> None:
        """Look at the clock, and tell what is done; between two looks lie some kernels of 10 ms each on 1000 km."""
        tell("searching", **self.counters)
        if self.clock.expired:
            raise OutOfTime

    def base_j(self, energy_j: float) -> float:
        """What shares of an energy are shares of: a net energy may be 0."""
        return max(energy_j, _LEAST_SHARE * self.scale_j)

    def stands(self, runs: Sequence[Run]) -> bool:
        """Whether no run is cheaper than an extremal at the extremal's own multiplier, which no run can be."""
        known = [extremal for extremal in self.extremals[1:] if math.isfinite(extremal.multiplier)]
        if not known or not runs:
            return True
        times_s, energies_j = np.array([run[:2] for run in runs]).T
        multipliers, costs_j, bases_j = np.array(
            [(one.multiplier, one.cost_j(one.multiplier), self.base_j(one.energy_j)) for one in known]
        ).T
        least_j = (energies_j + multipliers[:, np.newaxis] * times_s).min(axis=1)
        return bool((costs_j - least_j <= _EXTREMAL_LOSS * bases_j).all())

    def thriftiest(self) -> Run:
        """Run of the slowest extremal."""
        last = self.extremals[-1]
        return self._kept_run(self.mesh.drive(last.switch, self.counters), last.multiplier)

    def _kept_run(self, driven: tuple[int, float, float], multiplier: float) -> Run:
        """The run in the mesh's rows, copied."""
        n, time_s, energy_j = driven
        x_m, w = self.mesh.rows
        return Run(time_s, energy_j, multiplier, x_m[:n].copy(), w[:n].copy())

    def foresee(self, target_s: NDArray[np.float64]) -> None:
        """Add the extremals without which those around increasing running times may hold a surprise."""
        times_s = target_s.tolist()
        at = 0
        while at < len(times_s) and len(self.extremals) > 1:  # alone it is the thriftiest run as well
            self.watch()
            second = self._second(times_s[at])
            if not self._cut(second):
                at = max(bisect_right(times_s, self.extremals[second].time_s), at + 1)

    def _second(self, time_s: float) -> int:
        """The slower one of the two extremals around a running time; the last one beyond it."""
        at = bisect_left(self.extremals, time_s, key=lambda extremal: extremal.time_s)
        return min(max(at, 1), len(self.extremals) - 1)

    def _cut(self, second: int) -> bool:
        """Solve a multiplier between an extremal and the one before it, if any, where these may hold a surprise."""
        if second == 0:
            return False
        pieces = self._pieces(*self.extremals[second - 1 : second + 1])
        return pieces > 1 and self._split(second, (pieces // 2) / pieces)

    def points(self, target_s: NDArray[np.float64]) -> Iterator[Run]:
        """The best runs for increasing running times, which the extremals reach."""
        times_s = target_s.tolist()
        at = 0
        while at < len(times_s):
            self.watch()
            second = self._second(times_s[at])
            if self._cut(second):
                continue
            last = second == len(self.extremals) - 1
            until = len(times_s) if last else max(bisect_right(times_s, self.extremals[second].time_s), at + 1)
            for run in self._between(second, target_s[at : min(until, at + _AT_ONCE)]):
                at += 1
                yield run

    def _between(self, second: int, target_s: NDArray[np.float64]) -> Iterator[Run]:
        """Runs between two neighbouring extremals; ends early where an extremal was added between them."""
        before, after = self.extremals[second - 1], self.extremals[second]
        if self.interval is None or (self.interval.before, self.interval.after) != (before, after):  # by identity
            self.interval = Interval(before, after, self._blend(second))
        interval = self.interval
        at = 0
        loss = _BLEND_LOSS
        while at < len(target_s):
            runs, status = self.mesh.meet(
                interval, target_s[at:], self.tolerance_s, loss, loss * _LEAST_SHARE * self.scale_j, self.counters
            )
            at += len(runs)
            yield from runs
            if status == NOT_KEPT:
                if self._split(second):
                    return
                loss = math.inf
            elif status == NOT_MET:
                self.watch()
                fast, slow = map(interval.blend.at, interval.bracket)
                run = bridge(self.mesh, fast, slow, float(target_s[at]), self.tolerance_s, self.counters)
                if loss < math.inf and not self._keeps(before, after, run) and self._split(second):
                    return
                at += 1
                yield run._replace(multiplier=between(before, after, run.time_s).multiplier)

    def _blend(self, second: int) -> Blend:
        """Blend of the policies of an extremal and the one before it."""
        finite = [extremal for extremal in self.extremals[: second + 2] if math.isfinite(extremal.multiplier)]
        return blend_of(self.extremals[second - 1], self.extremals[second], finite[-4:], self.mesh.fast)

    def _pieces(self, before: Extremal, after: Extremal) -> int:
        """Into how many pieces to cut the front between two extremals so that none holds a surprise."""
        if math.isinf(before.multiplier):
            return 1 if after.time_s - before.time_s <= self.tolerance_s else 2
        if before.multiplier in self.foretold or after.multiplier in self.foretold:
            return 1  # their tangents part a quarter as far as those of the two that foretold
        bend = tangent_gap(before, after) / self.base_j(after.energy_j)
        # Tangents part from the chord with the square of the distance between the extremals.
        return math.ceil(math.sqrt(bend / _BEND))

    def _is_foretold(self, before: Extremal, middle: Extremal, after: Extremal) -> bool:
        """Whether two extremals told the energy of the one between them."""
        if math.isinf(before.multiplier):
            return False
        error_j = middle.energy_j - between(before, after, middle.time_s).energy_j
        return abs(error_j) <= _BLEND_LOSS * self.base_j(middle.energy_j)

    def _keeps(self, before: Extremal, after: Extremal, run: Run) -> bool:
        """Whether a run keeps what two extremals foretell."""
        if math.isinf(before.multiplier):
            return True
        loss_j = _BLEND_LOSS * self.base_j(run.energy_j)
        return run.energy_j <= between(before, after, run.time_s).energy_j + loss_j

    def _split(self, second: int, share: float = 0.5) -> bool:
        """Solve a multiplier between two neighbouring extremals; False when there is nothing between them."""
        before, after = self.extremals[second - 1], self.extremals[second]
        if len(self.extremals) >= _MOST_EXTREMALS:
            return False
        if math.isinf(before.multiplier):
            middle = self.mesh.extremal(_FIRST_MULTIPLIER * after.multiplier, self.counters)
        elif math.log(before.multiplier / after.multiplier) < _SAME_MULTIPLIER:
            return False
        else:
            middle = self.mesh.extremal(before.multiplier ** (1.0 - share) * after.multiplier**share, self.counters)
        if before.time_s < middle.time_s < after.time_s and after.energy_j < middle.energy_j < before.energy_j:
            if self._is_foretold(before, middle, after):
                self.foretold.add(middle.multiplier)
            self.extremals.insert(second, middle)
        elif middle.time_s - before.time_s < after.time_s - middle.time_s:
            self.extremals[second - 1] = replace(
                before, multiplier=middle.multiplier
            )  # the same run: T jumps at a lower multiplier
        else:
            self.extremals[second] = replace(after, multiplier=middle.multiplier)  # ... or at a higher multiplier
        return middle.multiplier < _HIGHEST_MULTIPLIER * self.mesh.usual_multiplier
