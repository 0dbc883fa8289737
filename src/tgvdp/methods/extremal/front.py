"""Method ``front`` with clean runs: each point of the costate program is replaced by an extremal that is no dearer.

The costate program is the global search: its runs say where to pull, coast, hold and brake. From their commands, or
those of the point before, an extremal is descended to that takes the point's own time. Where none is found that is no
dearer, the program's run stands, and the counters say so (docs/extremals.md).
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.resolved import resolve
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.methods.costate.front import OptimalRuns, optimal_front
from tgvdp.methods.extremal.simulate import ENVELOPE
from tgvdp.methods.extremal.solve import Extremal, Floats, Solver
from tgvdp.model.trip import Trip
from tgvdp.physics.codes import BRAKING, COASTING, DYNAMIC, HELD_BACK, HOLDING, RETARDED, TRACTION
from tgvdp.runs.profile import Profile
from tgvdp.runs.resistance_correction import follow

#: Relative difference below which running times are the same; how well extremals meet theirs.
_SAME = 1e-9
_TIME_RTOL = 2e-7
#: An extremal may cost this share of energy more than the program's run, and as much as so large a share of the running
#: time is worth: the program's rows claim times that are short by a few times 1e-5.
_DEARER = 2e-5
_TIME_DOUBT = 2e-5
#: ... if it goes on with the commands of the point before, it must not cost more than this, or its own are tried.
_NO_DEARER = -2e-6
#: Net energies may be 0: shares are of no less than this share of the fastest run's.
_LEAST_SHARE = 0.1
#: Every so many points the program's own commands are tried in any case.
_OFTEN = 8
#: After so many points the attempt ends where a smaller share of them has an extremal.
_HOPELESS = 6
_LEAST_FOUND = 0.6
#: What a phase under a second may save, as a share of energy, and be dropped all the same.
_PRUNED = 1e-5
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
    regime: NDArray[np.int64]


def extremal_front(
    trip: Trip,
    fastest: Profile,
    target_s: Floats,
    budget: SearchBudget,
    tolerance_s: float | None = None,
) -> OptimalRuns:
    """Least energy of the continuous problem at given running times, by clean extremals where there are any.

    Parameters, return value and errors are those of `tgvdp.methods.costate.front.optimal_front`; its counters are
    joined by ``clean``, the points that are clean extremals, and ``drives``, the blocks that were driven for them.
    """
    clock = budget.start()
    found = optimal_front(trip, fastest, target_s, budget, tolerance_s)
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
        finite = np.isfinite(self.prices) & (self.prices > 0.0)
        self.known_s, self.known_price = found.duration_s[finite], self.prices[finite]
        #: The run of the program that each target has, or −1.
        self.own = np.full(len(self.target_s), -1)
        at = np.searchsorted(self.target_s, found.duration_s * (1.0 - _SAME))
        self.own[at[at < len(self.own)]] = np.flatnonzero(at < len(self.own))
        self.points: dict[int, _Point] = {}

    def result(self) -> OptimalRuns:
        """The program's runs, replaced where that is possible."""
        wanted = np.flatnonzero(self.target_s > self.fastest.duration_s * (1.0 + _SAME))
        if self.found.exhausted or not self.found.complete:
            wanted = wanted[self.target_s[wanted] <= self.found.duration_s[-1]]
        if len(self.known_s):
            before: Extremal | None = None
            for count, k in enumerate(wanted.tolist()):
                if self.clock.expired:
                    break
                self._find(k, before, count % _OFTEN == 0)
                before = self.points[k].extremal if k in self.points else None
                if count >= _HOPELESS and len(self.points) < _LEAST_FOUND * count:
                    break
            for k in wanted[::-1].tolist():
                if self.clock.expired:
                    break
                if k + 1 in self.points and (k not in self.points or self._differs(k)):
                    self._try(k, [self.points[k + 1].extremal.commands], self.points[k + 1].extremal.price)
            for k in sorted(self.points):
                if self.clock.expired:
                    break
                self._prune(k)
        return self._joined()

    def _prune(self, k: int) -> None:
        """Drop the phases of a point that are shorter than a second, where that costs little."""
        solver, extremal, time_s = self.solver, self.points[k].extremal, float(self.target_s[k])
        solver.descend(extremal.commands, extremal.price, 0)
        pruned = solver.prune(extremal, extremal.price, loss=_PRUNED)
        if len(pruned.commands) >= len(extremal.commands):
            return
        aim_s = time_s * (1.0 - 0.5 * _TIME_RTOL)
        slope = self._slope(time_s)[1]
        met = solver.meet(pruned.commands, extremal.price, slope, aim_s, 0.5 * _TIME_RTOL * time_s)
        shorter = len(extremal.commands) - len(pruned.commands)
        if met is None or self._excess(k, met) > _DEARER:
            return
        if met.energy_j <= extremal.energy_j + shorter * _PRUNED * max(
            abs(extremal.energy_j), _LEAST_SHARE * self.scale_j
        ):
            rows = solver.kept_rows()
            if solver.excess <= _MOST_EXCESS:
                self.points[k] = _Point(met, *rows)

    def _differs(self, k: int) -> bool:
        """Whether a point has other commands than the next one."""
        one, other = self.points[k].extremal.commands, self.points[k + 1].extremal.commands
        return len(one) != len(other) or bool((one[:, 0] != other[:, 0]).any())

    def _slope(self, time_s: float) -> tuple[float, float]:
        """Price at a time, and dT/dlnλ there, by the program's runs."""
        logs = np.log(self.known_price)
        price = math.exp(float(np.interp(time_s, self.known_s, logs)))
        i = int(np.clip(np.searchsorted(self.known_s, time_s), 1, max(len(logs) - 2, 1)))
        low, high = max(i - 2, 0), min(i + 1, len(logs) - 1)
        span = float(logs[high] - logs[low])
        slope = float(self.known_s[high] - self.known_s[low]) / span if span < 0.0 else -0.2 * time_s
        return price, min(slope, -1e-4 * time_s)

    def _find(self, k: int, before: Extremal | None, look: bool) -> None:
        """Find an extremal for a target."""
        time_s = float(self.target_s[k])
        price, slope = self._slope(time_s)
        if before is not None:
            warm = before.price * math.exp((time_s - before.time_s) / slope) if before.price > 0.0 else price
            self._try(k, [before.commands], warm)
            if not look and k in self.points and self._excess(k, self.points[k].extremal) <= _NO_DEARER:
                return
        own = int(self.own[k])
        if own < 0 or not math.isfinite(self.prices[own]) or self.prices[own] <= 0.0:
            return
        x_m, w = self.found.rows(own)
        price = float(self.prices[own])
        seeds = [self.solver.commands_of(x_m, w, price, short_s) for short_s in (1.5, 0.1)]
        candidates = [seed for seed in seeds if seed is not None]
        if before is not None:
            candidates.append(before.commands)
        settled = self.solver.settle(candidates, price) if candidates else None
        if settled is not None:
            self._try(k, [settled.commands], price)

    def _try(self, k: int, seeds: list[Floats], price: float) -> None:
        """Meet a target's time from some commands, and keep what is cheaper than what there is."""
        time_s = float(self.target_s[k])
        slope = self._slope(time_s)[1]
        aim_s = time_s * (1.0 - 0.5 * _TIME_RTOL)
        for commands in seeds:
            extremal = self.solver.meet(commands, price, slope, aim_s, 0.5 * _TIME_RTOL * time_s)
            if extremal is None or self._excess(k, extremal) > _DEARER:
                continue
            if k in self.points and extremal.energy_j > self.points[k].extremal.energy_j - 1e-9 * self.scale_j:
                continue
            rows = self.solver.kept_rows()
            if self.solver.excess <= _MOST_EXCESS:
                self.points[k] = _Point(extremal, *rows)

    def _excess(self, k: int, extremal: Extremal) -> float:
        """By what share an extremal is dearer than the program's run at the same time."""
        own = int(self.own[k])
        if own < 0:
            own = int(np.searchsorted(self.found.duration_s, self.target_s[k])) - 1
        price = extremal.price if math.isfinite(self.prices[own]) else 0.0
        late_s = extremal.time_s - float(self.found.duration_s[own])
        if late_s > 0.05 * extremal.time_s:  # a faster run stood for the target: to be cheaper is all that is asked
            late_s = 0.0
        base_j = max(abs(float(self.energies[own])), _LEAST_SHARE * self.scale_j)
        doubt_j = price * _TIME_DOUBT * extremal.time_s
        return (extremal.energy_j + price * late_s - doubt_j - float(self.energies[own])) / base_j

    def _joined(self) -> OptimalRuns:
        """All points in order of time: extremals, and the program's runs for the others."""
        found = self.found
        counters = found.counters | {"clean": len(self.points), "drives": self.solver.runs}
        rows: list[tuple[float, float, float, tuple[Floats, Floats], NDArray[np.int8] | None]] = []
        replaced = {int(self.own[k]) for k in self.points}
        for i in range(len(found.duration_s)):
            if i not in replaced:
                rows.append(
                    (float(found.duration_s[i]), float(found.energy_j[i]), float(found.multiplier_j_per_s[i]),
                     found.rows(i), None)
                )  # fmt: skip
        line = resolve(self.trip)
        for point in self.points.values():
            extremal = point.extremal
            x_m, w = follow(self.trip.train, line, point.x_m, point.w)
            regime = _PROFILE_REGIMES[point.regime] if len(x_m) == len(point.x_m) else None
            rows.append(
                (extremal.time_s, extremal.energy_j + self.auxiliary_w * extremal.time_s,
                 max(extremal.price - self.auxiliary_w, 0.0), (x_m, w), regime)
            )  # fmt: skip
        rows.sort(key=lambda row: row[0])
        met_s = self.target_s[sorted(self.points)]
        duration, energy, price = (np.array([row[column] for row in rows]) for column in range(3))
        return replace(
            found, duration_s=duration, energy_j=energy, multiplier_j_per_s=price, counters=counters,
            _rows=[row[3] for row in rows], _regimes=[row[4] for row in rows],
            missed_s=tuple(s for s in found.missed_s if not np.isclose(met_s, s, rtol=_SAME, atol=0.0).any()),
        )  # fmt: skip
