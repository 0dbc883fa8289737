"""The run from one stop to the next: its trip, its fastest run, and all slower runs that were found so far."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import NumericalError
from tgvdp.methods.costate.front import OptimalRuns
from tgvdp.model.trip import Trip
from tgvdp.pareto import ParetoFront
from tgvdp.runs.batch import Batch, totals_of
from tgvdp.runs.profile import Profile, profile_of

#: Least energy of a trip at increasing running times, s, each met to a tolerance, s: a method.
Method = Callable[[Trip, Profile, NDArray[np.float64], float], OptimalRuns]

#: Relative difference below which running times are the same.
_SAME = 1e-9
#: A run that misses its time by more than this multiple of the tolerance takes another one.
_MISSED = 2.0


class SectionRuns:
    """Runs of one section, fastest first.

    Attributes
    ----------
    trip : Trip
    fastest : Profile
    time_s, energy_j, multiplier_j_per_s : (n,) float64
        Running times, s, increasing, energies, J, and multipliers λ, J/s, of all runs; λ is infinite for the fastest.
    front : ParetoFront
        Of them, whose ``source`` are their numbers: runs may be slower and dearer than another, as those by a map.
    complete : bool
        False when a time limit left running times out.
    exhausted : bool
        Whether running longer than the slowest run saves nothing.
    """

    def __init__(self, trip: Trip, fastest: Profile, method: Method) -> None:
        self.trip = trip
        self.fastest = fastest
        self.method = method
        self.time_s, self.energy_j, self.multiplier_j_per_s = np.empty((3, 0))
        self.front = ParetoFront.of([], [])
        self._runs: list[tuple[OptimalRuns, int]] = []
        self.complete = True
        self.exhausted = False

    def reach(self, supplement_s: NDArray[np.float64], tolerance_s: float) -> None:
        """Find the runs that take given supplements over the fastest run, s, in any order.

        None is earlier than that by more than the tolerance: half of it is the run's own, and those within the other
        half have one run in common. Nothing is sought where one is known, nor where time has run out before.
        """
        half_s = 0.5 * tolerance_s
        known_s = np.append(self.time_s, -np.inf)[self.slowest_within(supplement_s)]
        wanted_s = np.sort(supplement_s[self.fastest.duration_s + supplement_s - known_s > tolerance_s])
        if not self.complete or not len(wanted_s):
            return
        _, first = np.unique(np.floor(wanted_s / half_s), return_index=True)
        found = self.method(self.trip, self.fastest, self.fastest.duration_s + wanted_s[first], half_s)
        self.complete &= found.complete
        self.exhausted |= found.exhausted
        self._take(found, found.energy_j, found.multiplier_j_per_s)

    def takes(self, supplement_s: float, tolerance_s: float) -> bool:
        """Whether a run is known that takes a supplement over the fastest one, s."""
        known_s = float(self.time_s[self.slowest_within(np.array([supplement_s]))[0]])
        return self.fastest.duration_s + supplement_s - known_s <= tolerance_s

    def add(self, found: OptimalRuns) -> None:
        """Take runs in that waste energy on purpose, of a trip that differs in what it forbids or charges."""
        if len(found.duration_s):
            _, energy_j = totals_of(self.trip, Batch.of([found.rows(i) for i in range(len(found.duration_s))]))
            self._take(found, energy_j, np.zeros(len(energy_j)))

    def _take(self, found: OptimalRuns, energy_j: NDArray[np.float64], multiplier_j_per_s: NDArray[np.float64]) -> None:
        runs = self._runs + [(found, index) for index in range(len(found.duration_s))]
        known = np.array([found.duration_s, energy_j, multiplier_j_per_s])
        columns = np.concatenate(([self.time_s, self.energy_j, self.multiplier_j_per_s], known), axis=1)
        order = np.lexsort((columns[1], columns[0]))
        order = order[np.diff(columns[0][order], prepend=-np.inf) > 0.0]  # of equal times the cheapest
        self.time_s, self.energy_j, self.multiplier_j_per_s = columns[:, order]
        self._runs = [runs[index] for index in order.tolist()]
        self.front = ParetoFront.of(self.time_s, self.energy_j)

    def charged(self, trip: Trip, time_s: float, tolerance_s: float) -> tuple[Profile, float] | None:
        """Run of least energy of a trip that differs in what it charges (`Trip.credits`) in a time, s.

        And its multiplier where it ends, J/s. None where no run takes that time, unless running so long saves nothing:
        then it is the thriftiest run.
        """
        try:
            found = self.method(trip, self.fastest, np.array([time_s]), tolerance_s)
        except NumericalError:
            return None
        self.complete &= found.complete
        if len(found.duration_s) == 0:
            return None
        if not found.exhausted and abs(found.duration_s[-1] - time_s) > _MISSED * tolerance_s:
            return None
        x_m, w = found.rows(-1)
        return profile_of(self.trip, x_m, w), float(found.multiplier_j_per_s[-1])

    @property
    def supplement_s(self) -> NDArray[np.float64]:
        """Supplement of each run of the front over the fastest one, s, (n,) float64."""
        return np.asarray(self.front.time_s - self.fastest.duration_s)

    def energy_between(self, supplement_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Energy of the front at some supplements, J: between two runs the cubic of their multipliers, or their chord.

        It is the chord next to the fastest run, where the front is too steep, and where it is not convex.
        """
        x, y = self.supplement_s, self.front.energy_j
        if len(x) == 1:
            return np.full(len(supplement_s), y[0])
        last = np.searchsorted(x, supplement_s).clip(1, len(x) - 1)
        width, fall = np.diff(x)[last - 1], -np.diff(y)[last - 1]
        u = ((supplement_s - x[last - 1]) / width).clip(0.0, 1.0)
        slope = self.multiplier_j_per_s[self.front.source]
        before, after = slope[last - 1] * width, slope[last] * width
        convex = (before > fall) & (fall > after) & np.isfinite(before)
        before, after = np.where(convex, before, fall), np.where(convex, after, fall)
        fallen = u * (before + u * ((3.0 * fall - 2.0 * before - after) + u * (before + after - 2.0 * fall)))
        return np.asarray(y[last - 1] - fallen)

    def energy_at(self, supplement_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Energy at some supplements, J: as `energy_between`, behind the front that of the slowest run within them."""
        slowest_j = self.energy_j[self.slowest_within(supplement_s)]
        return np.where(supplement_s > self.supplement_s[-1], slowest_j, self.energy_between(supplement_s))

    def cheapest_within(self, supplement_s: NDArray[np.float64]) -> NDArray[np.int64]:
        """Number of the cheapest run that takes no more than each of some supplements, s."""
        return np.asarray(self.front.source[self._last_within(self.front.time_s, supplement_s)])

    def slowest_within(self, supplement_s: NDArray[np.float64]) -> NDArray[np.int64]:
        """Number of the slowest run that takes no more than each of some supplements, s."""
        return self._last_within(self.time_s, supplement_s)

    def _last_within(self, time_s: NDArray[np.float64], supplement_s: NDArray[np.float64]) -> NDArray[np.int64]:
        limit_s = (self.fastest.duration_s + supplement_s) * (1.0 + _SAME)
        return np.asarray(np.searchsorted(time_s, limit_s, side="right") - 1)

    def rows(self, index: int) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int8]]:
        """Rows of one run: positions from the origin, m, squared speeds, m²/s², and what is known of their regimes."""
        found, at = self._runs[index]
        x_m, w = found.rows(at)
        known = found.regimes(at)
        return x_m, w, np.full(len(x_m) - 1, -1, dtype=np.int8) if known is None else known

    def profile(self, index: int) -> Profile:
        """Speed profile of one run."""
        return profile_of(self.trip, *self.rows(index))
