"""Method ``front`` with clean runs: each point of the costate program is replaced by an extremal that is no dearer.

The costate program is the global search: its runs say where to pull, coast, hold and brake. From their commands, or
those of the point before, an extremal is descended to that takes the point's own time. Where none is found that is no
dearer, the program's run stands, and the counters say so (docs/extremals.md).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.resolved import resolve
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.methods.costate.front import OptimalRuns, optimal_front
from tgvdp.methods.extremal.rows import ENVELOPE
from tgvdp.methods.extremal.solve import Extremal, Floats, Solver, unbound
from tgvdp.model.trip import Trip
from tgvdp.physics.codes import BRAKING, COASTING, DYNAMIC, HELD_BACK, HOLDING, RETARDED, TRACTION
from tgvdp.progress import tell
from tgvdp.runs.batch import Batch
from tgvdp.runs.bends import allowed_off_s, are_cut
from tgvdp.runs.followed import Followed, follow_all
from tgvdp.runs.profile import Profile

#: Relative difference below which running times are the same; how well extremals meet theirs.
_SAME = 1e-9
_TIME_RTOL = 2e-7
#: An extremal may cost this share of energy more than the program's run, and as much as so large a share of the running
#: time is worth: the program's runs are as right as that.
_DEARER = 2e-5
_TIME_DOUBT = 5e-6
#: Net energies may be 0: shares are of no less than this share of the fastest run's.
_LEAST_SHARE = 0.1
#: What a phase that is too short to drive may save, as a share of energy, and be dropped all the same.
_PRUNED = 1e-5
#: Points at which structures are searched anew, and how many more there may be where walks end.
_MARKS = 8
_MORE_MARKS = 8
#: What is dearer than the program's run by this share of energy at its multiplier will hardly become an extremal; after
#: so many searches in vain in a row there are no more.
_HOPELESS = 3e-3
_MOST_IN_VAIN = 3
#: Longest step of the running time along the front, as a share.
_STRIDE = 0.006
#: Steps from an extremal of a multiplier to a running time, where one is too long.
_STEPS = 4
#: Two energies at one time are the same within this share.
_SAME_ENERGY = 1e-7
#: Largest share by which a row's effort may pass its limit: it may join the envelope within one of its rows.
_MOST_EXCESS = 8e-4
#: Regime of a profile for each of a row; the envelope has none of its own.
_PROFILE_REGIMES = np.full(ENVELOPE + 1, -1, dtype=np.int8)
_PROFILE_REGIMES[[TRACTION, COASTING, DYNAMIC]] = TRACTION, COASTING, BRAKING
_PROFILE_REGIMES[[HOLDING, RETARDED, HELD_BACK]] = HOLDING


@dataclass
class _Point:
    """A point with an extremal: its time, energy and price, rows and regimes."""

    extremal: Extremal
    x_m: Floats
    w: Floats
    regime: NDArray[np.int8]


def extremal_front(
    trip: Trip,
    fastest: Profile,
    target_s: Floats,
    budget: SearchBudget,
    tolerance_s: float | None = None,
    min_phase_s: float = 0.0,
) -> OptimalRuns:
    """Least energy of the continuous problem at given running times, by clean extremals where there are any.

    Parameters, return value and errors are those of `tgvdp.methods.costate.front.optimal_front`; its counters are
    joined by ``clean``, the points that are clean extremals, and ``drives``, the blocks that were driven for them.
    """
    clock = budget.start()
    found = optimal_front(trip, fastest, target_s, budget, tolerance_s, min_phase_s)
    found.counters |= {"clean": 0, "drives": 0}
    if not resolve(trip).even or not (found.duration_s > fastest.duration_s * (1.0 + _SAME)).any():
        return found
    return _Cleaning(trip, fastest, target_s, found, clock).result()


@dataclass
class _Cleaning:
    trip: Trip
    fastest: Profile
    target_s: Floats
    found: OptimalRuns
    clock: Clock

    def __post_init__(self) -> None:
        self.solver = Solver(self.trip)
        self.auxiliary_w = self.solver.tables.auxiliary_w
        found = self.found
        self.prices = found.multiplier_j_per_s + self.auxiliary_w
        self.energies = found.energy_j - self.auxiliary_w * found.duration_s
        self.scale_j = abs(float(self.energies[0]))
        #: The run of the program that each target has, or −1.
        self.own = np.full(len(self.target_s), -1)
        at = np.searchsorted(self.target_s, found.duration_s * (1.0 - _SAME))
        self.own[at[at < len(self.own)]] = np.flatnonzero(at < len(self.own))
        self.points: dict[int, _Point] = {}
        self.searched: set[int] = set()

    def result(self) -> OptimalRuns:
        """The program's runs, replaced where that is possible."""
        wanted = np.flatnonzero(self.target_s > self.fastest.duration_s * (1.0 + _SAME))
        if self.found.exhausted or not self.found.complete:
            wanted = wanted[self.target_s[wanted] <= self.found.duration_s[-1]]
        if len(wanted):
            self.first, self.last = int(wanted[0]), int(wanted[-1])
            marks = np.unique(np.linspace(self.first, self.last, _MARKS + 1).astype(np.int64)[1:]).tolist()
            vain = 0
            for _ in range(_MARKS + _MORE_MARKS):
                if vain == _MOST_IN_VAIN:
                    break
                if marks:
                    k = marks.pop(0)
                else:
                    left = [k for k in wanted.tolist() if k not in self.points and k not in self.searched]
                    if not left:
                        break
                    k = left[len(left) // 2]
                if k in self.points and self._excess(k, self.points[k].extremal, 0.0) <= 0.0:
                    continue
                self.searched.add(k)
                self._search(k)
                vain = 0 if k in self.points else vain + 1
        return self._joined()

    def _search(self, k: int) -> None:
        """Search the structure of a point from the program's run, and go on with it in both directions."""
        own = int(self.own[k])
        if self.clock.expired or own < 0 or not math.isfinite(self.prices[own]) or self.prices[own] <= 0.0:
            return
        price = float(self.prices[own])
        seeds = [self.solver.commands_of(*self.found.rows(own), price, short_s) for short_s in (1.5, 0.1)]
        candidates = [seed for seed in seeds if seed is not None]
        if k in self.points:
            candidates.append(self.points[k].extremal.commands)
        most_j = float(self.energies[own] + price * self.found.duration_s[own]) + _HOPELESS * self._base_j(own)
        settled = self.solver.settle(candidates, price, most_j) if candidates else None
        if settled is not None and self._meet(k, k, settled.commands, price) is not None:
            self._walk(k, self.first)
            self._walk(k, self.last)

    def _walk(self, k: int, end: int) -> None:
        """Go on from a point to its neighbours as long as that is better than what there is."""
        if k not in self.points or k == end:
            return
        step = 1 if end > k else -1
        here = self.points[k].extremal
        _, commands, price = self.solver.meet(here.commands, here.price, *self._aims(k, k + step), self._tolerance_s(k))
        while k != end and not self.clock.expired:
            tell("rebuilding clean runs", len(self.points), self.last - self.first + 1)
            way_s = self._way(k, k + step)
            for aim_s, next_s in pairwise(way_s[1:]):
                found, commands, price = self.solver.meet(commands, price, aim_s, next_s, self._tolerance_s(k))
                if found is None:
                    return
            k += step
            ahead = self._meet(k, k + step, commands, price)
            if ahead is None:
                return
            commands, price = ahead

    def _way(self, k: int, after: int) -> list[float]:
        """Running times from one target to another, in steps that Newton's rule can follow."""
        after = min(max(after, self.first), self.last)
        start_s, end_s = self.target_s[[k, after]] * (1.0 - 0.5 * _TIME_RTOL)
        steps = max(math.ceil(abs(end_s - start_s) / (_STRIDE * start_s)), 1)
        return np.linspace(start_s, end_s, steps + 1).tolist()

    def _aims(self, k: int, after: int) -> tuple[float, float]:
        """The running time of a target, and that which comes next on the way to another."""
        way_s = self._way(k, after)
        return way_s[0], way_s[1]

    def _tolerance_s(self, k: int) -> float:
        return 0.5 * _TIME_RTOL * float(self.target_s[k])

    def _meet(self, k: int, after: int, commands: Floats, price: float) -> tuple[Floats, float] | None:
        """Meet a target's time from some commands, and keep what is found if it is better than what there is.

        Returns commands and price foreseen for another target; None if nothing better is found.
        """
        solver = self.solver
        aims, tolerance_s = self._aims(k, after), self._tolerance_s(k)
        found, ahead, ahead_price = solver.meet(commands, price, *aims, tolerance_s)
        if found is None or self._excess(k, found) > _DEARER:
            settled = solver.at_price(unbound(commands), price)
            if settled is not None:
                found, ahead, ahead_price = self._approach(settled, aims, tolerance_s)
        if found is None:
            return None
        fewer = solver.shorter(found)
        if fewer is not None:
            pruned, onward, onward_price = solver.meet(fewer, found.price, *aims, tolerance_s)
            dropped = len(found.commands) - len(fewer)
            if pruned is not None and pruned.energy_j <= found.energy_j + dropped * _PRUNED * self._base_j(k):
                found, ahead, ahead_price = pruned, onward, onward_price
            else:
                found, ahead, ahead_price = solver.meet(found.commands, found.price, *aims, tolerance_s)
        if found is None or self._excess(k, found) > _DEARER:
            return None
        if k in self.points and found.energy_j > self.points[k].extremal.energy_j - _SAME_ENERGY * self.scale_j:
            return None
        rows = solver.kept_rows()
        if rows[3] > _MOST_EXCESS:
            return None
        self.points[k] = _Point(found, *rows[:3])
        return ahead, ahead_price

    def _approach(
        self, settled: Extremal, aims: tuple[float, float], tolerance_s: float
    ) -> tuple[Extremal | None, Floats, float]:
        """Go on from an extremal to a running time in small steps."""
        way_s = [*np.linspace(settled.time_s, aims[0], _STEPS + 1).tolist(), aims[1]]
        found: Extremal | None = settled
        commands, price = settled.commands, settled.price
        for aim_s, next_s in pairwise(way_s):
            found, commands, price = self.solver.meet(commands, price, aim_s, next_s, tolerance_s)
            if found is None:
                break
        return found, commands, price

    def _base_j(self, k: int) -> float:
        """Energy that shares are of."""
        return max(abs(float(self.energies[min(k, len(self.energies) - 1)])), _LEAST_SHARE * self.scale_j)

    def _excess(self, k: int, extremal: Extremal, doubt: float = _TIME_DOUBT) -> float:
        """By what share an extremal is dearer than the program's run at the same time, which is in doubt by a share."""
        own = int(self.own[k])
        if own < 0:
            own = int(np.searchsorted(self.found.duration_s, self.target_s[k])) - 1
        price = extremal.price if math.isfinite(self.prices[own]) else 0.0
        late_s = extremal.time_s - float(self.found.duration_s[own])
        if late_s > 0.05 * extremal.time_s:  # a faster run stood for the target: to be cheaper is all that is asked
            late_s = 0.0
        base_j = self._base_j(own)
        doubt_j = price * doubt * extremal.time_s
        return (extremal.energy_j + price * late_s - doubt_j - float(self.energies[own])) / base_j

    def _followed(self, points: Sequence[_Point]) -> list[tuple[float, Followed]]:
        """Prices and true runs of points."""
        runs = Batch.of([(point.x_m, point.w) for point in points])
        regime = np.concatenate([np.append(_PROFILE_REGIMES[point.regime], np.int8(-1)) for point in points])
        time_s = np.array([point.extremal.time_s for point in points])
        energy_j = np.array([point.extremal.energy_j for point in points]) + self.auxiliary_w * time_s
        base_j = np.maximum(energy_j, _LEAST_SHARE * self.scale_j)
        most_s = allowed_off_s(base_j, np.array([point.extremal.price for point in points]))
        bends = are_cut(resolve(self.trip), time_s, most_s)
        true = follow_all(self.trip, runs, regime, time_s, energy_j, most_s, bends=bends)
        prices = [max(point.extremal.price - self.auxiliary_w, 0.0) for point in points]
        return [(price, true.part(i)) for i, price in enumerate(prices)]

    def _joined(self) -> OptimalRuns:
        """All points in order of time: extremals, and the program's runs for the others."""
        found = self.found
        counters = found.counters | {"clean": len(self.points), "drives": self.solver.runs}
        replaced = {int(self.own[k]) for k in self.points}
        prices = found.multiplier_j_per_s.tolist()
        runs = [(price, found.part(i)) for i, price in enumerate(prices) if i not in replaced]
        if self.points:
            runs += self._followed(list(self.points.values()))
        runs.sort(key=lambda run: float(run[1].time_s[0]))
        met_s = self.target_s[sorted(self.points)]
        parts = [part for _, part in runs]
        return replace(
            found, duration_s=np.concatenate([part.time_s for part in parts]),
            energy_j=np.concatenate([part.energy_j for part in parts]),
            multiplier_j_per_s=np.array([price for price, _ in runs]), counters=counters, _parts=parts,
            missed_s=tuple(s for s in found.missed_s if not np.isclose(met_s, s, rtol=_SAME, atol=0.0).any()),
        )  # fmt: skip
