"""The search for the speeds at which timing points are passed: on a grid, and from there by multipliers."""

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.journeys.section import SectionRuns
from tgvdp.journeys.timetable import Terms, earliest, sample, wait
from tgvdp.journeys.windows import Miss, TooFastError, WindowMissedError

_Floats = NDArray[np.float64]

#: A speed for each point where the train passes, m/s.
Speeds = tuple[float, ...]
#: Parts that share given speeds.
Parts = Callable[[Speeds], list[SectionRuns]]

#: Speeds tried for each point, and how much closer those around the best of them are.
_SPEEDS, _FINER = 8, 4
#: Lowest speed of the grid, as a share of the highest possible, and by which factor it goes on where lower is better.
_LOWEST, _LOWER = 0.25, 0.7
#: What is wrong with speeds: windows open later than the slowest run comes, or close before the fastest one does.
_TOO_FAST, _TOO_SLOW = range(2)
#: An arrival is too early where it is so by more than this multiple of the tolerance: windows open later by that, and
#: so is the earliest arrival of all, but for rounding.
_TOO_EARLY = 1.001


class Point(NamedTuple):
    """A point that is passed, m, between the lowest and highest speed that may be, m/s."""

    position_m: float
    lowest_mps: float
    highest_mps: float


class _Refusal(NamedTuple):
    """Speeds that are not possible, and the error.

    How far they are is told by what is wrong, and by how much windows are missed, s. What is too fast for a window is
    nearer than what is too slow for one, whatever the seconds: the latter is not asked how much too fast it is
    elsewhere. As the fastest run is too slow for no window that can be met, the search goes on from there and slows
    down.
    """

    far: tuple[int, float]
    speeds: Speeds
    error: InfeasibleError

    @classmethod
    def of(cls, speeds: Speeds, error: InfeasibleError) -> "_Refusal":
        """The refusal of speeds by an error."""
        missed_s = error.missed_s if isinstance(error, WindowMissedError) else math.inf
        return cls((_TOO_FAST if isinstance(error, TooFastError) else _TOO_SLOW, missed_s), speeds, error)


class SpeedSearch:
    """The speeds of least energy for each arrival.

    Parameters
    ----------
    points : sequence of sequence of Point
        By sections.
    parts : callable
    terms : Terms
    arrival_s : (n,) float64
        Arrivals at the end of the journey, s.
    """

    def __init__(self, points: Sequence[Sequence[Point]], parts: Parts, terms: Terms, arrival_s: _Floats) -> None:
        self.points = [point for own in points for point in own]
        self.parts = parts
        self.terms = terms
        self.arrival_s = arrival_s
        #: By the number of the arrival; not where those that were tried are too slow.
        self.found: dict[int, Speeds] = {}
        self._least_j = np.full(len(arrival_s), np.inf)
        self._fastest = tuple(point.highest_mps for point in self.points)
        #: The nearest of the speeds that are not possible.
        self._nearest = _Refusal.of(self._fastest, InfeasibleError())
        # Points that are near to each other cannot have other speeds one by one: the train would have to brake.
        places = iter(range(len(self.points)))
        sections = [tuple(islice(places, len(own))) for own in points]
        everywhere = tuple(range(len(self.points)))
        self._groups = dict.fromkeys(group for group in (everywhere, *sections, *zip(everywhere)) if group)

    def on_grid(self) -> None:
        """Try speeds on a grid: at all points together, at those of each section, and one after the other.

        Raises
        ------
        InfeasibleError
            When a window cannot be met by any of them.
        """
        for share in np.linspace(1.0, _LOWEST, _SPEEDS).tolist():
            self._attempt(tuple(max(share * point.highest_mps, point.lowest_mps) for point in self.points))
            if self.found:
                break
        if not self.found:
            self._lower(tuple(range(len(self.points))))
        self._sweep(range(-_SPEEDS, _SPEEDS + 1), 1.0)
        share = 1.0
        while not self.found:
            before, share = self._nearest.far, share / _FINER
            self.around(share)
            if not self._nearest.far < before:
                break
        if not self.found:
            raise self._nearest.error

    def around(self, share: float = 1.0 / _FINER) -> None:
        """Try speeds around the best ones, closer than those of the grid: in steps of a share of its own."""
        self._sweep(range(1 - _FINER, _FINER), share)

    def _sweep(self, steps: range, share: float) -> None:
        for group in self._groups:
            for speeds in self._best():
                moves = (self._moved(speeds, dict.fromkeys(group, share * step)) for step in steps)
                for moved in sorted(set(moves)):
                    self._attempt(moved)
            self._lower(group)

    def _best(self) -> set[Speeds]:
        return set(self.found.values()) or {self._nearest.speeds}

    def _moved(self, speeds: Speeds, steps: Mapping[int, float]) -> Speeds:
        """Speeds some steps of the grid away, which are smaller for low ones."""
        moved = list(speeds)
        for place, step in steps.items():
            point, low, speed = self.points[place], self._lowest(place), speeds[place]
            step_mps = min((point.highest_mps - low) / (_SPEEDS - 1), (1.0 - _LOWER) * speed)
            if speed <= low:
                low = max(_LOWER * speed, point.lowest_mps)
            moved[place] = min(max(speed + step * step_mps, low), point.highest_mps)
        return tuple(moved)

    def _lowest(self, place: int) -> float:
        """Lowest speed of the grid at a point, m/s."""
        point = self.points[place]
        return min(max(point.lowest_mps, _LOWEST * point.highest_mps), point.highest_mps)

    def _lower(self, group: Sequence[int]) -> None:
        """Go on below the grid from speeds at its end, as long as that is better."""
        for speeds in self._best():
            is_better = all(speeds[place] <= self._lowest(place) for place in group)
            while is_better:
                slower = list(speeds)
                for place in group:
                    slower[place] = max(_LOWER * speeds[place], self.points[place].lowest_mps)
                is_better = tuple(slower) != speeds and self._attempt(speeds := tuple(slower))

    def _attempt(self, speeds: Speeds) -> bool:
        """Try speeds; whether they are the best ones for an arrival, or nearer to any where none were found."""
        try:
            energy_j = self._energy_j(speeds)
        except InfeasibleError as error:
            refusal = _Refusal.of(speeds, error)
            is_nearer = refusal.far < self._nearest.far
            if refusal.far <= self._nearest.far:
                self._nearest = refusal
            return is_nearer and not self.found
        better = np.flatnonzero(energy_j < self._least_j).tolist()
        for at in better:
            self.found[at], self._least_j[at] = speeds, energy_j[at]
        return bool(better)

    def _energy_j(self, speeds: Speeds) -> _Floats:
        """Energy of the journey for each arrival, as far as the parts' fronts are sampled, J; infinite if too early."""
        parts, (windows, tolerance_s, waiting_w) = self.parts(speeds), self.terms
        early_s = _TOO_EARLY * tolerance_s
        earliest(parts, windows, tolerance_s)  # asked first, as nothing is solved for it
        sample(parts, self.terms, self.arrival_s)
        timetable = self.terms.timetable(parts)
        first_s, last_s = timetable.arrival.first_s, float(self.arrival_s[-1])
        if last_s < first_s - early_s:
            which = f"an arrival at {last_s:.6g} s is wanted, the first one that was found is at {first_s:.6g} s"
            raise WindowMissedError([Miss(which, first_s - last_s, "is so much later")])
        taken_s = timetable.at(self.arrival_s).supplement_s
        wait(parts, self.terms, taken_s)
        energy_j = np.sum([one.energy_at(own_s) for one, own_s in zip(parts, taken_s.T, strict=True)], axis=0)
        energy_j += waiting_w * np.clip(self.arrival_s, first_s, timetable.arrival.last_s)
        return np.where(self.arrival_s >= first_s - early_s, energy_j, np.inf)
