"""Pilots of one mesh in the order of their running times, and the blends of their policies between them.

Pilots are added where a blend drives worse than the cubic through the pilots' (T, E, slope −λ) promises, and where the
tangents through them leave room for more than that.
"""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.budget import Clock
from tgvdp.methods.costate.extremal import Pilot, blend, energy_between, price_between, tangent_gap
from tgvdp.methods.costate.mesh import Interval, Mesh, Run
from tgvdp.physics.codes import NOT_KEPT, NOT_MET

#: A blend of two pilots may cost this share of energy more than the cubic through them promises.
_BLEND_LOSS = 2e-4
#: First multiplier, in usual ones, and the factor from it to the fastest run, whose price is infinite.
_FIRST_PRICE = 4.0
#: Step of ln λ towards slower runs, and how many steps without saving end the front.
_MARCH = 1.0
_IDLE_STEPS = 6
#: Between two pilots the front lies above their tangents; where these leave more room than this share of energy below
#: the chord, the front may bend where the cubic does not show it.
_BEND = 2e-3
#: ... but of no less than this share of the energy of the fastest run: a net energy may be 0.
_LEAST_SHARE = 0.1
#: Two multipliers whose logarithms differ by less are one.
_SAME_PRICE = 2e-3
#: Multipliers beyond this multiple of the usual one are infinite.
_HIGHEST_PRICE = 1e12
#: Relative difference below which running times or energies are the same.
_SAME = 1e-9
_MOST_PILOTS = 250
#: Runs between two looks at the clock, at most.
_AT_ONCE = 50
#: A mesh is fine enough when its cost is below that of the mesh before by less than this share of the energy: as
#: errors fall by 3 to 8 from mesh to mesh, its own is a fraction of that.
_MESH_LOSS = 1e-3
#: ... if it has more cells by this factor at least, ...
_GROWTH = 1.08
#: ... and when no pilot is dearer, at its own multiplier, than any other run by this share of the energy.
_PILOT_LOSS = 5e-4


class OutOfTime(Exception):
    """The time limit has passed: what was found until then stands."""


class PilotFront:
    """Pilots in the order of their running times, fewer and fewer joules, and the blends between them.

    Energies and prices are without auxiliaries: E + λT of a run that draws P at any time is E' + (λ + P)·T, so that P
    is the least price there is.
    """

    def __init__(
        self, mesh: Mesh, tolerance_s: float, least_price: float, counters: dict[str, int], clock: Clock
    ) -> None:
        self.mesh = mesh
        self.tolerance_s = tolerance_s
        self.least_price = least_price
        self.counters = counters
        self.clock = clock
        self.pilots = [mesh.pilot(math.inf, self.counters)]
        self.scale_j = mesh.usual_price * self.pilots[0].time_s
        self.price = max(_FIRST_PRICE * mesh.usual_price, least_price)
        self.idle = 0
        self.interval: Interval | None = None

    def reach(self, first_s: float, last_s: float) -> bool:
        """March λ down until a pilot takes the last time, and up until one is no slower than the first.

        False when running longer saves nothing.
        """
        saves = self._march_down(last_s)
        while (
            len(self.pilots) > 1
            and math.isinf(self.pilots[0].price)
            and self.pilots[1].time_s > first_s
            and self._pieces(*self.pilots[:2]) > 1
        ):
            self._watch()
            if not self._split(1):
                break
        return saves

    def _march_down(self, target_s: float) -> bool:
        while len(self.pilots) < 2 or self.pilots[-1].time_s < target_s - self.tolerance_s:
            if self.idle >= _IDLE_STEPS:
                return False
            self._watch()
            pilot = self.mesh.pilot(self.price, self.counters)
            last = self.pilots[-1]
            if pilot.energy_j < last.energy_j - _SAME * self.scale_j and pilot.time_s > last.time_s:
                self.pilots.append(pilot)
                self.idle = 0
            else:
                self.idle += 1
            if self.price <= self.least_price:
                self.idle = _IDLE_STEPS
            self.price = max(self.price * math.exp(-_MARCH), self.least_price)
        return True

    def _watch(self) -> None:
        """Look at the clock; between two looks lie a few kernels of some 10 ms each on 1000 km."""
        if self.clock.expired:
            raise OutOfTime

    def _base_j(self, energy_j: float) -> float:
        """What shares of an energy are shares of: a net energy may be 0."""
        return max(energy_j, _LEAST_SHARE * self.scale_j)

    def agrees(self, coarser: "PilotFront") -> bool:
        """Whether a coarser mesh gives runs that are hardly dearer, for the multipliers that both marched through.

        Not where the line's own breaks make nearly all cells: two meshes that are the same always agree.
        """
        if len(self.mesh.cells.length_m) < _GROWTH * len(coarser.mesh.cells.length_m):
            return False
        costs = {pilot.price: pilot.cost_j(pilot.price) for pilot in coarser.pilots[1:]}
        both = [pilot for pilot in self.pilots[1:] if pilot.price in costs]
        return bool(both) and all(
            costs[pilot.price] - pilot.cost_j(pilot.price) <= _MESH_LOSS * self._base_j(pilot.energy_j)
            for pilot in both
        )

    def stands(self, runs: list[Run]) -> bool:
        """Whether no run is cheaper than a pilot at the pilot's own multiplier, which no run can be."""
        times_s, energies_j = (np.array([run[column] for run in runs]) for column in range(2))
        return all(
            pilot.cost_j(pilot.price) - float((energies_j + pilot.price * times_s).min())
            <= _PILOT_LOSS * self._base_j(pilot.energy_j)
            for pilot in self.pilots[1:]
            if math.isfinite(pilot.price)
        )

    def thriftiest(self) -> Run:
        """Run of the slowest pilot."""
        last = self.pilots[-1]
        return self._kept_run(self.mesh.drive(last.switch, last.switch, 0.0, self.counters), last.price)

    def _kept_run(self, driven: tuple[int, float, float], price: float) -> Run:
        """The run in the mesh's rows, copied."""
        n, time_s, energy_j = driven
        x_m, w = self.mesh.rows
        return Run(time_s, energy_j, price, x_m[:n].copy(), w[:n].copy())

    def points(self, target_s: NDArray[np.float64]) -> Iterator[Run]:
        """The best runs for increasing running times, which the pilots reach."""
        times_s = target_s.tolist()
        at = 0
        while at < len(times_s):
            self._watch()
            ends_s = [pilot.time_s for pilot in self.pilots]
            second = min(max(bisect_left(ends_s, times_s[at]), 1), len(ends_s) - 1)
            before, after = self.pilots[second - 1], self.pilots[second]
            pieces = self._pieces(before, after)
            if pieces > 1 and self._split(second, (pieces // 2) / pieces):
                continue
            until = len(times_s) if second == len(ends_s) - 1 else max(bisect_right(times_s, after.time_s), at + 1)
            for run in self._between(second, target_s[at : min(until, at + _AT_ONCE)]):
                at += 1
                yield run

    def _between(self, second: int, target_s: NDArray[np.float64]) -> Iterator[Run]:
        """Runs between two neighbouring pilots; ends early where a pilot was added between them."""
        before, after = self.pilots[second - 1], self.pilots[second]
        if self.interval is None or (self.interval.before, self.interval.after) != (before, after):  # by identity
            self.interval = Interval(before, after)
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
                self._watch()
                fast, slow = (blend(before, after, share) for share in interval.bracket)
                run = self._bridge(fast, slow, float(target_s[at]))
                if loss < math.inf and not self._keeps(before, after, run) and self._split(second):
                    return
                at += 1
                yield run._replace(price=price_between(before, after, run.time_s))

    def _pieces(self, before: Pilot, after: Pilot) -> int:
        """Into how many pieces to cut the front between two pilots so that none holds a surprise."""
        if math.isinf(before.price):
            return 1 if after.time_s - before.time_s <= self.tolerance_s else 2
        bend = tangent_gap(before, after) / self._base_j(after.energy_j)
        # Tangents part from the chord with the square of the distance between the pilots.
        return math.ceil(math.sqrt(bend / _BEND))

    def _keeps(self, before: Pilot, after: Pilot, run: Run) -> bool:
        """Whether a run keeps what the cubic through two pilots promises."""
        if math.isinf(before.price):
            return True
        loss_j = _BLEND_LOSS * self._base_j(run.energy_j)
        return run.energy_j <= energy_between(before, after, run.time_s) + loss_j

    def _split(self, second: int, share: float = 0.5) -> bool:
        """Solve a multiplier between two neighbouring pilots; False when there is nothing between them."""
        before, after = self.pilots[second - 1], self.pilots[second]
        if len(self.pilots) >= _MOST_PILOTS:
            return False
        if math.isinf(before.price):
            middle = self.mesh.pilot(_FIRST_PRICE * after.price, self.counters)
        elif math.log(before.price / after.price) < _SAME_PRICE:
            return False
        else:
            middle = self.mesh.pilot(before.price ** (1.0 - share) * after.price**share, self.counters)
        if before.time_s < middle.time_s < after.time_s and after.energy_j < middle.energy_j < before.energy_j:
            self.pilots.insert(second, middle)
        elif middle.time_s - before.time_s < after.time_s - middle.time_s:
            self.pilots[second - 1] = replace(before, price=middle.price)  # the same run: T jumps at a lower price
        else:
            self.pilots[second] = replace(after, price=middle.price)  # ... or at a higher price
        return middle.price < _HIGHEST_PRICE * self.mesh.usual_price

    def _bridge(self, fast: NDArray[np.float64], slow: NDArray[np.float64], target_s: float) -> Run:
        """Meet a time at which the running time of blends jumps: the slow policy up to one station, then the fast.

        Moving that station cell by cell, and blending in its own cell alone, leaves no jump.
        """
        first, last = 0, len(fast)
        while last - first > 1:
            middle = (first + last) // 2
            mixed = np.concatenate((slow[:middle], fast[middle:]))
            if self.mesh.drive(mixed, mixed, 0.0, self.counters)[1] < target_s:
                first = middle
            else:
                last = middle
        here = np.concatenate((slow[:first], fast[first:]))
        there = np.concatenate((slow[:last], fast[last:]))
        lo, hi = 0.0, 1.0
        run = self.mesh.drive(here, there, 0.5, self.counters)
        while abs(run[1] - target_s) > self.tolerance_s and hi - lo > _SAME:
            middle_share = 0.5 * (lo + hi)
            lo, hi = (middle_share, hi) if run[1] < target_s else (lo, middle_share)
            run = self.mesh.drive(here, there, 0.5 * (lo + hi), self.counters)
        if run[1] > target_s + self.tolerance_s:  # the time jumps even within one cell: rather too early than too late
            run = self.mesh.drive(here, there, lo, self.counters)
        return self._kept_run(run, math.nan)
