"""Pilots of one mesh in the order of their running times, and the blends of their policies between them.

Pilots are added where a blend drives worse than the cubic through the pilots' (T, E, slope −λ) promises, and where the
tangents through them leave room for more than that.
"""

import math
from bisect import bisect_left
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tgvdp.search.blends import blend, cubic, first_share, slope, tangent_gap
from tgvdp.search.budget import Clock
from tgvdp.search.pilots import Mesh, Pilot, Sample

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
_LEAST_SHARE = 0.05
#: Two multipliers whose logarithms differ by less are one.
_SAME_PRICE = 2e-3
#: Multipliers beyond this multiple of the usual one are infinite.
_HIGHEST_PRICE = 1e12
#: Relative difference below which running times or energies are the same.
_SAME = 1e-9
_MOST_PILOTS = 250
#: A mesh is fine enough when its cost differs from that of the mesh before by less than this share of the energy: as
#: errors fall by 3 to 8 from mesh to mesh, its own is a fraction of that.
_MESH_LOSS = 1.5e-3


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
        self.between: tuple[Pilot, Pilot] | None = None
        self.samples: list[Sample] = []

    def reach(self, target_s: float) -> bool:
        """March λ down until a pilot takes the target time; False when running longer saves nothing."""
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

    def agrees(self, other: "PilotFront") -> bool:
        """Whether two meshes give runs of nearly the same cost for the multipliers that both have marched through."""
        costs = {pilot.price: pilot.cost_j(pilot.price) for pilot in other.pilots[1:]}
        both = [pilot for pilot in self.pilots[1:] if pilot.price in costs]
        return bool(both) and all(
            abs(pilot.cost_j(pilot.price) - costs[pilot.price])
            <= _MESH_LOSS * max(pilot.energy_j, _LEAST_SHARE * self.scale_j)
            for pilot in both
        )

    def thriftiest(self) -> tuple[int, float, float, float]:
        """Rows, running time, energy and price of the slowest pilot."""
        last = self.pilots[-1]
        return *self.mesh.drive(last.switch, last.switch, 0.0, self.counters), last.price

    def point(self, target_s: float) -> tuple[int, float, float, float]:
        """Rows, running time, energy and price of the best run for one running time."""
        while True:
            self._watch()
            second = next((i for i in range(1, len(self.pilots)) if self.pilots[i].time_s >= target_s), None)
            second = len(self.pilots) - 1 if second is None else second
            before, after = self.pilots[second - 1], self.pilots[second]
            pieces = self._pieces(before, after)
            if pieces > 1 and self._split(second, (pieces // 2) / pieces):
                continue
            run = self._meet(before, after, target_s)
            if not self._kept(before, after, *run[1:]):
                if self._split(second):
                    continue
                run = self._meet(before, after, target_s)  # the split may have driven another run into the rows
            return *run, after.price if math.isinf(before.price) else slope(before, after, run[1])

    def _pieces(self, before: Pilot, after: Pilot) -> int:
        """Into how many pieces to cut the front between two pilots so that none holds a surprise."""
        if math.isinf(before.price):
            return 1 if after.time_s - before.time_s <= self.tolerance_s else 2
        bend = tangent_gap(before, after) / max(after.energy_j, _LEAST_SHARE * self.scale_j)
        # Tangents part from the chord with the square of the distance between the pilots.
        return math.ceil(math.sqrt(bend / _BEND))

    def _kept(self, before: Pilot, after: Pilot, time_s: float, energy_j: float) -> bool:
        """Whether a blend keeps what the cubic through its pilots promises."""
        if math.isinf(before.price):
            return True
        return energy_j <= cubic(before, after, time_s) + _BLEND_LOSS * max(energy_j, _LEAST_SHARE * self.scale_j)

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

    def _meet(self, before: Pilot, after: Pilot, target_s: float) -> tuple[int, float, float]:
        """Find the blend of two pilots that takes the target time."""
        if self.between != (before, after):  # compared by identity
            self.between = (before, after)
            self.samples = [Sample(0.0, before.time_s), Sample(1.0, after.time_s)]
        at = bisect_left(self.samples, target_s, 1, len(self.samples) - 1, key=lambda sample: sample.time_s)
        bracket = self.samples[at - 1], self.samples[at]
        run = self.mesh.meet(
            before.switch, after.switch, first_share(self.samples, at, target_s), target_s, self.tolerance_s, bracket,
            self.counters,
        )  # fmt: skip
        if bracket[0].time_s < run.time_s < bracket[1].time_s:
            self.samples.insert(at, Sample(run.share, run.time_s))
        if abs(run.time_s - target_s) <= self.tolerance_s or not bracket[0].time_s < target_s < bracket[1].time_s:
            return run[:3]
        return self._bridge(blend(before, after, run.lo), blend(before, after, run.hi), target_s)

    def _bridge(
        self, fast: NDArray[np.float64], slow: NDArray[np.float64], target_s: float
    ) -> tuple[int, float, float]:
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
        return run
