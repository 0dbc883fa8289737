"""The search for the speeds at which timing points are passed: on a grid, and from there by multipliers."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.journeys.section import SectionRuns
from tgvdp.journeys.timetable import sample, timetable_of
from tgvdp.journeys.windows import WindowMissedError, Windows

_Floats = NDArray[np.float64]

#: A speed for each point where the train passes, m/s.
Speeds = tuple[float, ...]
#: Parts that share given speeds.
Parts = Callable[[Speeds], list[SectionRuns]]

#: Speeds tried for each point, then around the best of them at a finer distance, so often.
_SPEEDS, _FINER, _LEVELS = 8, 4, 2
#: Lowest speed of the grid, as a share of the highest possible.
_LOWEST = 0.25


class Point(NamedTuple):
    """A point that is passed, m, between the lowest and highest speed that may be, m/s."""

    position_m: float
    lowest_mps: float
    highest_mps: float


class SpeedSearch:
    """The speeds of least energy for each arrival.

    Parameters
    ----------
    points : sequence of Point
    parts : callable
    windows : Windows
    arrival_s : (n,) float64
        Arrivals at the end of the journey, s.
    tolerance_s : float
        How well running times are met, s.
    """

    def __init__(
        self, points: Sequence[Point], parts: Parts, windows: Windows, arrival_s: _Floats, tolerance_s: float
    ) -> None:
        self.points = points
        self.parts = parts
        self.windows = windows
        self.arrival_s = arrival_s
        self.tolerance_s = tolerance_s
        #: By the number of the arrival; not where those that were tried are too slow.
        self.found: dict[int, Speeds] = {}
        self._least_j = np.full(len(arrival_s), np.inf)
        self._refusals: list[InfeasibleError] = []

    def on_grid(self) -> None:
        """Try speeds on a grid, one point after the other, then around the best ones.

        Raises
        ------
        InfeasibleError
            When a window cannot be met by any of them.
        """
        fastest = tuple(point.highest_mps for point in self.points)
        self._attempt(fastest)
        for level in range(_LEVELS):
            for place, point in enumerate(self.points):
                high = point.highest_mps
                low = min(max(point.lowest_mps, _LOWEST * high), high)
                step = (high - low) / (_SPEEDS - 1) / _FINER**level
                steps = np.arange(-_SPEEDS, _SPEEDS + 1) if level == 0 else np.arange(1 - _FINER, _FINER)
                for speeds in set(self.found.values()) or {fastest}:
                    for speed in np.unique(np.clip(speeds[place] + step * steps, low, high)).tolist():
                        self._attempt((*speeds[:place], speed, *speeds[place + 1 :]))
        if not self.found:
            raise min(self._refusals, key=lambda one: one.missed_s if isinstance(one, WindowMissedError) else np.inf)

    def _attempt(self, speeds: Speeds) -> None:
        try:
            energy_j = self._energy_j(speeds)
        except InfeasibleError as error:
            self._refusals.append(error)
            return
        for at in np.flatnonzero(energy_j < self._least_j).tolist():
            self.found[at], self._least_j[at] = speeds, energy_j[at]

    def _energy_j(self, speeds: Speeds) -> _Floats:
        """Energy of the journey for each arrival, as far as the parts' fronts are sampled, J; infinite if too early."""
        parts = self.parts(speeds)
        sample(parts, self.windows, self.arrival_s, self.tolerance_s)
        timetable = timetable_of(parts, self.windows, self.tolerance_s)
        taken_s = timetable.at(self.arrival_s).supplement_s
        energy_j = np.sum(
            [one.energy_between(own_s) for one, own_s in zip(parts, taken_s.T, strict=True)],
            axis=0,
        )
        return np.where(self.arrival_s >= timetable.arrival.first_s - self.tolerance_s, energy_j, np.inf)
