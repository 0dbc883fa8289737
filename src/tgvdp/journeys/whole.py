"""A section in one piece with windows on its way: one multiplier for each timing point, by a small dual search.

A window that binds adds its own multiplier to every second before the point. The section is solved in one piece with
these as credits (`Trip.credits`), to the running time that it shall have, and no speed at the points is assumed. The
time at which a point is passed falls as its multiplier rises, and so each has its root, one after the other, in rounds.
Where that time jumps over the end of a window, the train passes a little inside.
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
#: The largest share of a round's changes in those of the round before from which the end of all rounds is foreseen.
_SLOWEST = 0.95
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
        search.foresee(before_w)
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
        self._change_w: _Floats | None = None
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

    def foresee(self, before_w: _Floats) -> None:
        """Go on to where the last two rounds lead: one point moves the others, and so their changes shrink evenly."""
        change_w, last_w = self.own_w - before_w, self._change_w
        self._change_w = change_w
        if last_w is None or not last_w.any():
            return
        share = float(change_w @ last_w / (last_w @ last_w))
        if 0.0 < share < _SLOWEST:
            self.own_w += share / (1.0 - share) * change_w
            self._change_w = None

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
