"""A section in one piece with windows on its way: one multiplier for each timing point, by a small dual search.

A window that binds adds its own multiplier to every second before the point. The section is solved in one piece with
these as credits (`Trip.credits`), to the running time that it shall have, and no speed at the points is assumed. The
time at which a point is passed falls as its multiplier rises, and so each has its root, one after the other, in rounds.
Where a train passes two points in one go, each round moves both multipliers by as little as the one before: so the way
of a round is gone on as far as the least energy at these multipliers, less what windows allow for, rises on it (Powell,
Comput. J. 7, 1964). It is concave in all of them, and its slopes are by how much points are passed too late.
Where a time jumps over the end of a window, the train passes a little inside.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tgvdp.journeys.passed import PassedRun, run_in_one_piece
from tgvdp.journeys.section import SectionRuns
from tgvdp.model.journey import TimingPoint
from tgvdp.model.trip import Trip
from tgvdp.physics.roots import Bracket

_Floats = NDArray[np.float64]

#: Rounds over the points, and runs of each round for each point, at most.
_ROUNDS, _RUNS = 12, 24
#: First step of a multiplier, in mean powers of the fastest run, and how steps grow until a time is between two.
_FIRST, _GROWTH = 0.25, 2.5
#: Multipliers of a point that differ by less than this share are one: its time jumps there.
_NEAR = 1e-4
#: Largest multiplier of a point, in the same measure: no time is worth more, but next to the fastest run.
_MOST = 1e3
#: The way of a round is gone to where it is so much less steep than at its beginning.
_LEVEL = 0.1
#: Change of multipliers, relative to them or the mean power, below which another round changes nothing.
_SETTLED = 1e-2


def whole_run(
    section: SectionRuns,
    trip: Trip,
    points: Sequence[TimingPoint],
    time_s: float,
    multiplier_j_per_s: _Floats,
    tolerance_s: float,
) -> tuple[PassedRun, bool] | None:
    """Least energy of a section that takes a time, s, and whether it is in its windows; None where there is no run.

    It is not in its windows where no multipliers lead there; those that it has are still the best ones for a bound.

    Parameters
    ----------
    section : SectionRuns
    trip : Trip
        The section's, as its energy is counted here.
    points : sequence of TimingPoint
        Where it passes, and where it ends; windows of time count from its departure.
    time_s : float
        Running time, s.
    multiplier_j_per_s : (n,) float64
        Multipliers of its parts that may be near to what is sought, J/s.
    tolerance_s : float
        How well times are met, s.
    """
    search = _Search(section, trip, points, time_s, tolerance_s)
    own_w = np.abs(np.diff(np.where(np.isfinite(multiplier_j_per_s), multiplier_j_per_s, 0.0))).tolist()
    for _ in range(_ROUNDS):
        before_w = search.own_w.copy()
        if not all([search.bind(at, abs(before_w[at]) or own_w[at]) for at in range(len(own_w))]):
            return None
        run = search.run()
        is_met = run is not None and run.keeps(points, tolerance_s)
        if len(own_w) == 1 or (is_met and search.is_settled(before_w)):
            break
        if before_w.any() and not search.go_on(before_w):
            break
    return None if run is None else (run, is_met)


class _Search:
    """Runs of one section and one running time, s, by the multipliers of its timing points, J/s."""

    def __init__(
        self, section: SectionRuns, trip: Trip, points: Sequence[TimingPoint], time_s: float, tolerance_s: float
    ) -> None:
        self.section = section
        self.trip = trip
        self.points = points
        self.time_s = time_s
        self.tolerance_s = tolerance_s
        self.scale_w = abs(section.fastest.total_energy_j) / section.fastest.duration_s
        self.own_w = np.zeros(len(points) - 1)
        self._known: dict[tuple[float, ...], PassedRun | None] = {}

    def run(self) -> PassedRun | None:
        """The run at the points' multipliers; None where there is none."""
        key = tuple(self.own_w.tolist())
        if key not in self._known:
            self._known[key] = self._solved()
        return self._known[key]

    def _solved(self) -> PassedRun | None:
        at_m = [point.position_m for point in self.points[:-1]]
        credits = tuple(zip(at_m, (-self.own_w).tolist(), strict=True))
        found = self.section.charged(replace(self.trip, credits=credits), self.time_s, self.tolerance_s)
        if found is None:
            return None
        profile, last_w = found
        multiplier = last_w + np.append(np.cumsum(self.own_w[::-1])[::-1], 0.0)
        return run_in_one_piece(profile, self.points, multiplier, self.time_s, self.tolerance_s)

    def is_settled(self, before_w: _Floats) -> bool:
        """Whether multipliers are those of the round before."""
        size_w = np.maximum(np.abs(self.own_w), self.scale_w)
        return bool((np.abs(self.own_w - before_w) <= _SETTLED * size_w).all())

    def go_on(self, before_w: _Floats) -> bool:
        """Go on the way of a round, from the multipliers before it, as long as it rises; whether that ends anywhere.

        If not, windows ask for more than multipliers lead to.
        """
        run, start_w, way_w = self.run(), self.own_w.copy(), self.own_w - before_w
        if run is None:
            return False
        least_s = float(run.ends_s[-1]) - self.tolerance_s
        start_j = self._falls_j(way_w, least_s)
        bracket = Bracket(0.0, math.inf, start_j, math.inf)
        for _ in range(_RUNS):
            if not start_j < 0.0:
                break
            if math.isinf(bracket.hi):
                share = max(_GROWTH * bracket.lo, 1.0)
            elif math.isinf(bracket.f_hi):
                share = 0.5 * (bracket.lo + bracket.hi)
            else:
                share = bracket.secant()
            self.own_w = start_w + share * way_w
            falls_j = self._falls_j(way_w, least_s)
            bracket = bracket.narrowed(share, falls_j)
            jumps = math.isfinite(bracket.hi) and bracket.hi - bracket.lo <= _NEAR * bracket.hi
            if abs(falls_j) <= _LEVEL * abs(start_j) or jumps:
                break
            if np.abs(self.own_w).max() > _MOST * self.scale_w:
                break
        is_end = not start_j < 0.0 or math.isfinite(bracket.f_hi) or abs(falls_j) <= _LEVEL * abs(start_j)
        self.own_w = start_w + (bracket.lo * way_w if is_end else 0.0)
        return is_end

    def _falls_j(self, way_w: _Floats, least_s: float) -> float:
        """By how much the least energy less what windows allow for falls on a way of multipliers, J.

        By ∞ where there is no run, or one that takes less than a time, s: it saves nothing by taking longer.
        """
        run = self.run()
        if run is None or run.ends_s[-1] < least_s:
            return math.inf
        ahead_s = 0.0
        for own_w, point, passed_s, way in zip(
            self.own_w.tolist(), self.points[:-1], run.ends_s[:-1].tolist(), way_w.tolist(), strict=True
        ):
            side = float(np.sign(own_w)) or float(passed_s > point.latest_s) - float(passed_s < point.earliest_s)
            ahead_s += way * (self._aim_s(point, side) - passed_s) if side else 0.0
        return ahead_s

    def bind(self, at: int, first_w: float) -> bool:
        """Find the multiplier of one point, the others given, 0 where it is passed in time; whether one is found."""
        if self.own_w[at] and self._is_bound(at):
            return True
        self.own_w[at] = 0.0
        run = self.run()
        if run is None:
            return False
        point, passed_s = self.points[at], float(run.ends_s[at])
        if point.earliest_s <= passed_s <= point.latest_s:
            return True
        side = 1.0 if passed_s > point.latest_s else -1.0
        bound_s = self._aim_s(point, side)
        step_w = max(first_w, _FIRST * self.scale_w)
        bracket = Bracket(0.0, math.inf, -abs(passed_s - bound_s), math.inf)
        for _ in range(_RUNS):
            if math.isinf(bracket.hi):
                own_w = max(_GROWTH * bracket.lo, step_w)
            elif math.isinf(bracket.f_hi):
                own_w = 0.5 * (bracket.lo + bracket.hi)
            else:
                own_w = bracket.secant()
            self.own_w[at] = side * own_w
            run = self.run()
            ahead_s = math.inf if run is None else side * (bound_s - float(run.ends_s[at]))
            if abs(ahead_s) <= 0.5 * self.tolerance_s:
                return True
            bracket = bracket.narrowed(own_w, ahead_s)
            jumps = math.isfinite(bracket.hi) and bracket.hi - bracket.lo <= _NEAR * bracket.hi
            if jumps or bracket.lo > _MOST * self.scale_w:
                break
        if math.isinf(bracket.f_hi):
            return False
        # The time jumps over the end of the window: in it the train is a little away from that.
        self.own_w[at] = side * bracket.hi
        return True

    def _is_bound(self, at: int) -> bool:
        """Whether the train passes at that end of a window to which its multiplier drives it."""
        run, bound_s = self.run(), self._aim_s(self.points[at], self.own_w[at])
        return run is not None and abs(float(run.ends_s[at]) - bound_s) <= 0.5 * self.tolerance_s

    def _aim_s(self, point: TimingPoint, side: float) -> float:
        """Time at that end of a window, as far within it as a time may be missed, s."""
        inside_s = 0.5 * min(self.tolerance_s, point.latest_s - point.earliest_s)
        return point.latest_s - inside_s if side > 0.0 else point.earliest_s + inside_s
