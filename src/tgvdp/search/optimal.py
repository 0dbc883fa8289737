"""The front method: the whole Pareto front from a few multipliers (docs/front-method.md).

Pilots are solved by the costate program for chosen multipliers. Each point of the front drives a blend of the
switching speeds of the two pilots around it that meets its running time; where the blend drives worse than the cubic
through the pilots' (T, E, slope −λ) promises, a pilot is added between them.
"""

import math
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tgvdp.model.trip import Trip
from tgvdp.physics.profile import Profile
from tgvdp.physics.resolved import follow
from tgvdp.search.blends import blend, cubic, slope, tangent_gap, unit
from tgvdp.search.budget import Clock, SearchBudget
from tgvdp.search.pilots import Mesh, Pilot

#: A blend of two pilots may cost this share of energy more than the cubic through them promises.
_BLEND_LOSS = 2e-4
#: How well a point meets its running time by default: a share of the step to the next point.
_STEP_TOL = 0.02
#: Step of ln λ towards slower runs, and how many steps without saving end the front.
_MARCH = 1.0
_IDLE_STEPS = 6
#: Between two pilots the front lies above their tangents; where these leave more room than this share of energy below
#: the chord, the front may bend where the cubic does not show it.
_BEND = 2e-3
#: Two multipliers whose logarithms differ by less are one.
_SAME_PRICE = 2e-3
#: Multipliers beyond this multiple of the usual one are infinite.
_HIGHEST_PRICE = 1e12
#: Relative difference below which running times or energies are the same.
_SAME = 1e-9
_MOST_PILOTS = 250
#: Share of energy that a finer mesh may save before it is used; its cells are smaller by this factor, this far at most.
_MESH_LOSS = 1.5e-3
_REFINEMENT = 2.0
_FINEST = 16.0


@dataclass
class OptimalRuns:
    """Runs of the front method, in the order of their target times.

    Attributes
    ----------
    duration_s, energy_j : (n,) float64
        Running time and traction energy.
    price_j_per_s : (n,) float64
        Multiplier λ of each run: energy saved per second more; infinite for the fastest run.
    complete : bool
        False when the time limit ended the search: the targets before that are met.
    exhausted : bool
        True when running longer saves nothing: the last run is the thriftiest, faster than the last targets.
    counters : dict of str to int
    """

    duration_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]
    price_j_per_s: NDArray[np.float64]
    complete: bool
    exhausted: bool
    counters: dict[str, int]
    _rows: list[tuple[NDArray[np.float64], NDArray[np.float64]]]

    def rows(self, index: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Rows of one run: positions from the origin, m, and squared speeds, m²/s²."""
        return self._rows[index]


def optimal_front(
    trip: Trip,
    fastest: Profile,
    target_s: NDArray[np.float64],
    budget: SearchBudget,
    tolerance_s: float | None = None,
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

    Returns
    -------
    OptimalRuns
        One run for each target, or for those before the budget ended. A target is left out where the running times of
        optimal runs jump over it and no blend meets it. Where no slower run saves energy any more, the
        front ends with the thriftiest run.

    Raises
    ------
    TgvdpError
        When the costate program fails; it never returns a wrong front in silence.
    """
    clock = budget.start()
    counters = {"pilots": 0, "runs": 0, "costates": 0}
    slower = target_s > fastest.duration_s * (1.0 + _SAME)
    if tolerance_s is None:
        steps_s = np.diff(target_s[slower], prepend=fastest.duration_s)
        tolerance_s = _STEP_TOL * float(steps_s.min(initial=math.inf))
    found = [(fastest.duration_s, fastest.total_energy_j, math.inf)] * int(np.sum(~slower))
    rows = [(fastest.position_m - trip.origin_m, fastest.speed_mps**2)] * len(found)
    complete, saves = True, True
    try:
        if slower.any():
            front = _front_on_fine_mesh(trip, fastest, tolerance_s, float(target_s[-1]), counters, clock)
        for target in target_s[slower].tolist():
            saves = front.reach(target)
            n, *point = front.point(target) if saves else front.thriftiest()
            # The same run again: running times jump here, or the thriftiest run is among the points already.
            if not found or point[0] > found[-1][0] * (1.0 + _SAME):
                found.append((point[0], point[1], point[2]))
                x_m, w = (column[:n].copy() for column in front.mesh.rows)
                rows.append((x_m, follow(trip, x_m, w)))
            if not saves:
                break
    except _OutOfTime:
        complete = False
    duration, energy, prices = np.array(found, dtype=np.float64).reshape(-1, 3).T
    return OptimalRuns(duration, energy, prices, complete, not saves, counters, rows)


class _OutOfTime(Exception):
    """The time limit has passed: what was found until then stands."""


def _front_on_fine_mesh(
    trip: Trip, fastest: Profile, tolerance_s: float, last_s: float, counters: dict[str, int], clock: Clock
) -> "_Front":
    """Pilots down to the last time, on a mesh so fine that a finer one would hardly save anything.

    The usual mesh suits trains that keep their speed; where they climb by momentum it may have to be finer.
    """
    finer = 1.0
    front = _Front(Mesh.of(trip, fastest), tolerance_s, counters, clock)
    front.reach(last_s)
    with suppress(_OutOfTime):  # the coarser front stands
        while finer < _FINEST:
            finer *= _REFINEMENT
            check = _Front(Mesh.of(trip, fastest, finer), tolerance_s, counters, clock)
            if all(check.saves_little(pilot) for pilot in front.pilots[:0:-1]):
                break
            check.reach(last_s)
            front = check
    return front


class _Front:
    """Pilots in the order of their running times, fewer and fewer joules, and the blends between them."""

    def __init__(self, mesh: Mesh, tolerance_s: float, counters: dict[str, int], clock: Clock) -> None:
        self.mesh = mesh
        self.tolerance_s = tolerance_s
        self.counters = counters
        self.clock = clock
        self.pilots = [mesh.pilot(math.inf, self.counters)]
        self.scale_j = mesh.usual_price * self.pilots[0].time_s
        self.price = mesh.usual_price
        self.idle = 0

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
            self.price *= math.exp(-_MARCH)
        return True

    def _watch(self) -> None:
        """Look at the clock; between two looks lie a few kernels of some 10 ms each on 1000 km."""
        if self.clock.expired:
            raise _OutOfTime

    def saves_little(self, pilot: Pilot) -> bool:
        """Whether this mesh hardly improves on a pilot of another mesh."""
        cost_j = self.mesh.pilot(pilot.price, self.counters).cost_j(pilot.price)
        return pilot.cost_j(pilot.price) - cost_j <= _MESH_LOSS * max(pilot.energy_j, 0.1 * self.scale_j)

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
            share = (target_s - before.time_s) / (after.time_s - before.time_s)
            n, time_s, energy_j = self.mesh.drive(before.switch, after.switch, unit(share), self.counters)
            if self._kept(before, after, time_s, energy_j):
                break
            if not self._split(second):  # it may have driven another run into the rows
                n, time_s, energy_j = self.mesh.drive(before.switch, after.switch, unit(share), self.counters)
                break
        return self._meet(before, after, target_s, unit(share), (n, time_s, energy_j))

    def _kept(self, before: Pilot, after: Pilot, time_s: float, energy_j: float) -> bool:
        """Whether a blend keeps what the cubic through its pilots promises."""
        if math.isinf(before.price):
            return after.time_s - before.time_s <= self.tolerance_s
        scale_j = max(energy_j, 0.01 * self.scale_j)
        return (
            tangent_gap(before, after) <= _BEND * scale_j
            and energy_j <= cubic(before, after, time_s) + _BLEND_LOSS * scale_j
        )

    def _split(self, second: int) -> bool:
        """Solve a multiplier between two neighbouring pilots; False when there is nothing between them."""
        before, after = self.pilots[second - 1], self.pilots[second]
        if len(self.pilots) >= _MOST_PILOTS:
            return False
        if math.isinf(before.price):
            middle = self.mesh.pilot(4.0 * after.price, self.counters)
        elif math.log(before.price / after.price) < _SAME_PRICE:
            return False
        else:
            middle = self.mesh.pilot(math.sqrt(before.price * after.price), self.counters)
        if before.time_s < middle.time_s < after.time_s and after.energy_j < middle.energy_j < before.energy_j:
            self.pilots.insert(second, middle)
        elif middle.time_s - before.time_s < after.time_s - middle.time_s:
            self.pilots[second - 1] = replace(before, price=middle.price)  # the same run: T jumps at a lower price
        else:
            self.pilots[second] = replace(after, price=middle.price)  # ... or at a higher price
        return middle.price < _HIGHEST_PRICE * self.mesh.usual_price

    def _meet(
        self, before: Pilot, after: Pilot, target_s: float, share: float, run: tuple[int, float, float]
    ) -> tuple[int, float, float, float]:
        """Correct a blend until it takes the target time (Illinois rule)."""
        lo, hi = 0.0, 1.0
        f_lo, f_hi = before.time_s - target_s, after.time_s - target_s
        for _ in range(30):
            f = run[1] - target_s
            if abs(f) <= self.tolerance_s or not f_lo < 0.0 < f_hi or hi - lo < _SAME:
                break
            if f < 0.0:
                f_hi *= 0.5 if lo > 0.0 else 1.0
                lo, f_lo = share, f
            else:
                f_lo *= 0.5 if hi < 1.0 else 1.0
                hi, f_hi = share, f
            share = (lo * f_hi - hi * f_lo) / (f_hi - f_lo)
            run = self.mesh.drive(before.switch, after.switch, share, self.counters)
        if abs(run[1] - target_s) > self.tolerance_s and f_lo < 0.0 < f_hi:
            run = self._bridge(blend(before, after, lo), blend(before, after, hi), target_s)
        return *run, after.price if math.isinf(before.price) else slope(before, after, run[1])

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
