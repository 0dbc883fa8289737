"""Extremals of one mesh in the order of their running times, and the blends of their policies between them.

They are added where a blend costs other than the extremals around it foretell, and where the tangents through these
leave room for more than that.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.budget import Clock
from tgvdp.methods.costate.bridge import bridge
from tgvdp.methods.costate.extremal import Extremal, between
from tgvdp.methods.costate.found import Found
from tgvdp.methods.costate.interpolate import CHEAPER
from tgvdp.methods.costate.meet import meet
from tgvdp.methods.costate.mesh import Mesh, Run
from tgvdp.methods.costate.slower import held_up, least_squared_speeds
from tgvdp.methods.costate.surprises import FIRST_MULTIPLIER, HIGHEST_MULTIPLIER, MOST_EXTREMALS, surprising
from tgvdp.physics.codes import NOT_KEPT, OK
from tgvdp.progress import tell

#: A blend of two extremals may cost this share of energy more than they foretell.
_BLEND_LOSS = 5e-5
#: Step of ln λ towards slower runs, and how many steps without saving end the front.
_MARCH = 0.5
_IDLE_STEPS = 12
#: Steps that are solved at once: at first, on a mesh of few cells more of them, and later on.
_FIRST_STEPS = 4
_FEW_CELLS, _FIRST_STEPS_ON_FEW = 128, 5
_STEPS = 2
#: Two multipliers whose logarithms differ by less are one.
_SAME_MULTIPLIER = 2e-3
#: Relative difference below which running times or energies are the same.
_SAME = 1e-9
#: Runs between two looks at the clock, at most, and the cells that these have: a tenth of a second.
_AT_ONCE = 128
_CELLS_OF_RUNS_AT_ONCE = 500_000
#: Cells through which extremals are solved between two looks at the clock: some 10 ms.
_CELLS_AT_ONCE = 20_000


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
        self.extremals: list[Extremal] = []
        self.multiplier = max(FIRST_MULTIPLIER * mesh.usual_multiplier, least_multiplier)
        self.idle = 0
        self.foretold: set[float] = set()
        self.settled: set[tuple[float, float]] = set()  # neighbours' multipliers between which there is no surprise
        self.repeated: set[float] = set()  # multipliers whose extremal is one of the two around them

    def around(self, target_s: NDArray[np.float64]) -> list[Extremal]:
        """Extremals of finite multipliers next to increasing running times: between any others no point is sought."""
        times_s = np.array([one.time_s for one in self.extremals])
        # Targets that are slower than each extremal's faster neighbour, and than its slower one.
        above = np.searchsorted(target_s, np.concatenate(([-math.inf], times_s[:-1])))
        below = np.searchsorted(target_s, np.concatenate((times_s[1:], [math.inf])), side="right")
        return [
            one for one, has in zip(self.extremals, below > above, strict=True) if has and math.isfinite(one.multiplier)
        ]

    def on(self, mesh: Mesh, fastest: Extremal, extremals: Sequence[Extremal]) -> "ExtremalFront":
        """The front on another mesh, from extremals that were solved on it in place of this one's."""
        front = ExtremalFront(mesh, self.tolerance_s, self.least_multiplier, self.counters, self.clock)
        front.extremals.append(fastest)
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
        saves = extremal.energy_j < last.energy_j - _SAME * self.mesh.least_energy_j and extremal.time_s > last.time_s
        if saves:
            self.extremals.append(extremal)
        return saves

    def reach(self, last_s: float) -> bool:
        """March λ down until an extremal takes the last time; False when running longer saves nothing."""
        while self._is_short_of(last_s):
            if self.idle >= _IDLE_STEPS:
                return False
            # Some at once: what is solved in vain takes less time than to ask for each on its own.
            count = _STEPS
            if len(self.extremals) < 2:
                count = _FIRST_STEPS_ON_FEW if len(self.mesh.cells.length_m) < _FEW_CELLS else _FIRST_STEPS
            ahead = [self.multiplier]
            while len(ahead) < count:
                ahead.append(self._after(ahead[-1]))
            if self.extremals:
                solved = self.solved(self.mesh, ahead)
            else:
                fastest, *solved = self.solved(self.mesh, [math.inf, *ahead])
                self.extremals.append(fastest)
            for extremal in solved:
                self.idle = 0 if self._append(extremal) else self.idle + 1
                if self.multiplier <= self.least_multiplier:
                    self.idle = _IDLE_STEPS
                self.multiplier = self._after(self.multiplier)
                if self.idle >= _IDLE_STEPS or not self._is_short_of(last_s):
                    break
        return True

    def _is_short_of(self, last_s: float) -> bool:
        """Whether no extremal is as slow as that yet."""
        return len(self.extremals) < 2 or self.extremals[-1].time_s < last_s - self.tolerance_s

    def watch(self) -> None:
        """Look at the clock, and tell what is done; between two looks lie some kernels of 10 ms each on 1000 km."""
        tell("searching", **self.counters)
        if self.clock.expired:
            raise OutOfTime

    def base_j(self, energy_j: float) -> float:
        """What shares of an energy are shares of: a net energy may be 0."""
        return max(energy_j, self.mesh.least_energy_j)

    def excess(self, outcome: NDArray[np.float64]) -> float:
        """By which share of its energy an extremal costs more than one of some runs at its own multiplier, at most.

        That none can do; 0 where none does. Of the runs it takes times, energies and multipliers, (n, 3).
        """
        known = [extremal for extremal in self.extremals[1:] if math.isfinite(extremal.multiplier)]
        if not known or not len(outcome):
            return 0.0
        times_s, energies_j, _ = outcome.T
        own_s, own_j, multipliers = np.array([one.outcome for one in known]).T
        least_j = (energies_j + multipliers[:, np.newaxis] * times_s).min(axis=1)
        bases_j = np.maximum(own_j, self.mesh.least_drawn_j)
        return max(0.0, float(np.max((own_j + multipliers * own_s - least_j) / bases_j)))

    def thriftiest(self) -> Run:
        """Run of the slowest extremal."""
        last = self.extremals[-1]
        return self.mesh.drive(last.switch, self.counters).copied()._replace(multiplier=last.multiplier)

    def foresee(self, target_s: NDArray[np.float64]) -> None:
        """Add the extremals without which those around running times may hold a surprise."""
        targets_s = target_s.tolist()
        while wanted := surprising(self, targets_s):
            self._solve_between(wanted)

    def solved(self, mesh: Mesh, multipliers: Sequence[float]) -> list[Extremal]:
        """Extremals of multipliers, as of `Mesh.extremals`, as many at once as leave time for looks at the clock."""
        at_once = math.ceil(_CELLS_AT_ONCE / len(mesh.cells.length_m))
        found: list[Extremal] = []
        for first in range(0, len(multipliers), at_once):
            self.watch()
            some = multipliers[first : first + at_once]
            least_w = least_squared_speeds(self.mesh, self.extremals, mesh, some)
            solved = mesh.extremals(some, self.counters, least_w)
            again = [] if least_w is None else held_up(least_w, solved)
            if again:
                free = mesh.extremals([some[i] for i in again], self.counters)
                for i, extremal in zip(again, free, strict=True):
                    solved[i] = extremal
            found += solved
        return found

    def points(self, target_s: NDArray[np.float64]) -> tuple[Found, bool]:
        """The best runs for increasing running times, which the extremals reach, before the clock ran out; if all."""
        found: list[Found] = []
        numbers: list[NDArray[np.intp]] = []  # of the times that these take
        is_open = np.ones(len(target_s), dtype=np.bool_)
        try:
            self.foresee(target_s)
            at_once = max(1, min(_AT_ONCE, _CELLS_OF_RUNS_AT_ONCE // len(self.mesh.cells.length_m)))
            closed: set[float] = set()  # multipliers of extremals between which and those before them there is nothing
            for first in range(0, len(target_s), at_once):
                wanted = np.arange(first, min(first + at_once, len(target_s)))
                while len(wanted):
                    self.watch()
                    which, runs, splits = self._round(target_s, wanted, closed)
                    numbers.append(which)
                    found.append(runs)
                    is_open[which] = False
                    self._split(splits, closed)
                    wanted = wanted[is_open[wanted]]
        except OutOfTime:
            pass
        if not found:
            return Found.none(), not len(target_s)
        done = int(is_open.argmax()) if is_open.any() else len(target_s)
        order = np.argsort(np.concatenate(numbers))
        return Found.joined(found).picked(order[:done]), done == len(target_s)

    def _round(
        self, target_s: NDArray[np.float64], wanted: NDArray[np.intp], closed: set[float]
    ) -> tuple[NDArray[np.intp], Found, list[int]]:
        """Look for runs of wanted times.

        Returns the numbers of the times for which there are runs, these, and the extremals between which and those
        before them one is to be solved, as what is there does not do.
        """
        losses = np.array([math.inf if one.multiplier in closed else _BLEND_LOSS for one in self.extremals])
        met = meet(self.mesh, self.extremals, losses, target_s[wanted], self.tolerance_s, self.counters)
        splits = set(met.second[met.status == NOT_KEPT].tolist())
        bridged: dict[int, Run] = {}
        for i, (fast, slow) in met.brackets.items():
            second = int(met.second[i])
            before, after = self.extremals[max(second - 1, 0)], self.extremals[second]
            aim_s = float(target_s[wanted[i]])
            run = bridge(self.mesh, fast, slow, aim_s, self.tolerance_s, self.counters)
            is_met = abs(run.time_s - aim_s) <= self.tolerance_s
            if after.multiplier in closed or (is_met and self._keeps(before, after, run)):
                bridged[i] = run._replace(multiplier=between(before, after, run.time_s).multiplier)
            else:
                splits.add(second)
        which = wanted[met.status == OK]
        if not bridged:
            return which, met.found, sorted(splits)
        runs = Found.joined((met.found, Found.of(list(bridged.values()))))
        return np.concatenate((which, wanted[list(bridged)])), runs, sorted(splits)

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
        return -CHEAPER * loss_j <= run.energy_j - between(before, after, run.time_s).energy_j <= loss_j

    def middle(self, second: int, share: float = 0.5) -> float | None:
        """A multiplier between those of an extremal and the one before it, if any."""
        before, after = self.extremals[second - 1].multiplier, self.extremals[second].multiplier
        if math.isinf(before):
            higher = FIRST_MULTIPLIER * after
            return higher if higher < HIGHEST_MULTIPLIER * self.mesh.usual_multiplier else None
        return before ** (1.0 - share) * after**share if math.log(before / after) >= _SAME_MULTIPLIER else None

    def _split(self, seconds: Sequence[int], closed: set[float]) -> None:
        """Solve multipliers between extremals and those before them; where there are none they are closed."""
        wanted: list[tuple[int, float]] = []
        for second in seconds:
            full = len(self.extremals) + len(wanted) >= MOST_EXTREMALS
            multiplier = self.middle(second) if second > 0 and not full else None
            if multiplier is None:
                closed.add(self.extremals[second].multiplier)
            else:
                wanted.append((second, multiplier))
        self._solve_between(wanted)

    def _solve_between(self, wanted: Sequence[tuple[int, float]]) -> None:
        """Solve multipliers, each with the slower one of the extremals around it, in order, and take them in."""
        middles = self.solved(self.mesh, [multiplier for _, multiplier in wanted])
        for (second, _), middle in zip(reversed(wanted), reversed(middles), strict=True):
            self._insert(second, middle)

    def _insert(self, second: int, middle: Extremal) -> None:
        """Take in an extremal that was solved between two neighbouring ones."""
        before, after = self.extremals[second - 1], self.extremals[second]
        if before.time_s < middle.time_s < after.time_s and after.energy_j < middle.energy_j < before.energy_j:
            if self._is_foretold(before, middle, after):
                self.foretold.add(middle.multiplier)
            self.extremals.insert(second, middle)
            return
        # One of them at another multiplier: between its two T stands still, and jumps beyond them, or nearly.
        self.repeated.add(middle.multiplier)
        is_before = middle.time_s - before.time_s < after.time_s - middle.time_s
        run, beyond = (before, second - 2) if is_before else (after, second + 1)
        again = run._replace(multiplier=middle.multiplier)
        if abs(middle.time_s - run.time_s) <= self.tolerance_s:  # else another run, which is none of the front's
            again = middle._replace(time_s=run.time_s, energy_j=run.energy_j)
        if 0 <= beyond < len(self.extremals) and self.extremals[beyond].time_s == run.time_s:
            self.extremals[second - 1 if is_before else second] = again
        else:
            self.extremals.insert(second, again)
