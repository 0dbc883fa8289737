"""Sections in one piece: as if nothing were asked between stops, and with windows there, one multiplier for each.

What knows no windows between stops and keeps them all is the optimum: fewer windows cost no more. Where one is left,
the runs without them tell what stretches from point to point take at each multiplier (`stretches`), and a `Timetable`
plans with that when each section leaves and arrives. Each is solved in one piece then (`whole`). Its times and
multipliers move what is told of its stretches, and the next plan saves what multipliers differ by where no window
parts them.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.journeys.front import SAVING
from tgvdp.journeys.passed import PassedRun, run_in_one_piece, run_of_parts
from tgvdp.journeys.section import SectionRuns
from tgvdp.journeys.slower import slow_down
from tgvdp.journeys.stretches import Stretches, through
from tgvdp.journeys.timetable import Terms, planned, sample
from tgvdp.journeys.waiting import waiting_for_free
from tgvdp.journeys.whole import whole_run
from tgvdp.journeys.windows import Schedule, Timetable, WindowMissedError, Windows
from tgvdp.model.journey import TimingPoint
from tgvdp.runs.profile import profile_of

_Floats = NDArray[np.float64]

#: Rounds of planning and solving, at most.
_ROUNDS = 16
#: A stretch that saves nothing any more has this share of its section's mean power as its multiplier.
_LEAST = 1e-3


class Timed(NamedTuple):
    """One journey: when its sections depart as planned, s, (sections,), and their runs."""

    departure_s: _Floats
    runs: list[PassedRun]

    @property
    def energy_j(self) -> float:
        """Of all sections, J."""
        return sum(run.profile.total_energy_j for run in self.runs)

    def cost_j(self, waiting_w: float) -> float:
        """Energy less what would be drawn in waiting for as long as it runs, J."""
        return sum(run.cost_j(waiting_w) for run in self.runs)


class JoinedSections:
    """The sections of a journey with windows, in one piece each.

    Parameters
    ----------
    sections, free : sequence of SectionRuns
        Between stops: whose energies are told, and the same with what is drawn in waiting left out.
    windows : Windows
        As the timetable has them.
    """

    def __init__(self, sections: Sequence[SectionRuns], free: Sequence[SectionRuns], windows: Windows) -> None:
        self.sections = sections
        self.free = free
        self.windows = windows
        self._stretches = [
            Stretches(section, [windows.arrivals[part].position_m for part in parts])
            for section, parts in zip(free, windows.sections, strict=True)
        ]
        self._first = [parts[0] for parts in windows.sections]
        self._fastest_s = np.concatenate([one.fastest_s for one in self._stretches]).tolist()

    def unbound(self, terms: Terms, arrival_s: _Floats) -> dict[int, Timed]:
        """Journeys without windows between stops that keep those, by the numbers of their arrivals, s.

        Raises
        ------
        InfeasibleError
            When a window at a stop cannot be met.
        """
        at_stops = terms._replace(windows=terms.windows.at_stops)
        sample(self.free, at_stops, arrival_s)
        plan = planned(self.free, at_stops, arrival_s)
        found = {}
        for at, row in enumerate(map(Schedule, *plan)):
            runs = []
            for number, (supplement_s, departure_s) in enumerate(
                zip(row.supplement_s.tolist(), row.departure_s.tolist(), strict=True)
            ):
                points = points_since(self.windows, number, departure_s)
                run = self._unbound_run(number, supplement_s, row.multiplier_j_per_s[number], points, terms)
                if len(points) > 1 and not run.keeps(points, terms.tolerance_s):
                    break
                runs.append(run)
            else:
                found[at] = Timed(row.departure_s, runs)
        return found

    def _unbound_run(
        self, number: int, supplement_s: float, multiplier_w: float, points: Sequence[TimingPoint], terms: Terms
    ) -> PassedRun:
        section, free = self.sections[number], self.free[number]
        if len(points) == 1:
            return run_of_parts(section.trip, [free], np.array([supplement_s]), np.array([multiplier_w]))
        run = int(free.slowest_within(np.array([supplement_s]))[0])
        time_s = free.fastest.duration_s + supplement_s
        own = np.full(len(points), multiplier_w)
        return run_in_one_piece(profile_of(section.trip, *free.rows(run)), points, own, time_s, terms.tolerance_s)

    def bound(self, terms: Terms, arrival_s: float) -> Timed | None:
        """The journey that ends at a time, s, a multiplier for each window that binds, or None."""
        if any(one.trip.energy.map is not None for one in self.free):
            return None
        plan, best, last = self._planned(terms, arrival_s), None, None
        seen: list[list[tuple[float, float]]] = [[] for _ in self._fastest_s]
        for _ in range(_ROUNDS):
            runs = None if plan is None else self._runs(plan, terms, arrival_s, last)
            if plan is None or runs is None:
                break
            found = Timed(plan.departure_s[self._first], runs)
            if best is None or found.cost_j(terms.waiting_w) < best.cost_j(terms.waiting_w):
                best = found
            self._look(runs, seen)
            before, plan, last = plan, self._planned(terms, arrival_s, seen), found
            if plan is None or self._is_settled(before, plan, terms.tolerance_s):
                break
            if self._saving_j(runs, plan) <= SAVING * abs(found.energy_j):
                break
        return best

    def _planned(
        self, terms: Terms, arrival_s: float, seen: Sequence[Sequence[tuple[float, float]]] = ()
    ) -> Schedule | None:
        """Plan by what is known of all stretches, and what was seen of them with windows."""
        demands = [demand for one in self._stretches for demand in one.demands()]
        if seen:
            demands = [through(demand, own) for demand, own in zip(demands, seen, strict=True)]
        try:
            table = Timetable(terms.windows, self._fastest_s, demands, terms.tolerance_s, terms.waiting_w)
        except WindowMissedError:
            return None
        return Schedule(*(column[0] for column in table.at(np.array([arrival_s]))))

    def _look(self, runs: Sequence[PassedRun], seen: Sequence[list[tuple[float, float]]]) -> None:
        """Note what stretches of runs in one piece take, at which multipliers."""
        for parts, run in zip(self.windows.sections, runs, strict=True):
            if len(parts) == 1:  # its own runs tell that
                continue
            least_w = _LEAST * abs(run.profile.total_energy_j) / run.profile.duration_s
            taken_s = np.diff(run.ends_s, prepend=0.0)
            for part, own_s, own_w in zip(parts, taken_s.tolist(), run.multiplier_j_per_s.tolist(), strict=True):
                if math.isfinite(own_w):
                    seen[part].append((own_s - self._fastest_s[part], max(own_w, least_w)))

    def _is_settled(self, before: Schedule, plan: Schedule, tolerance_s: float) -> bool:
        """Whether all sections depart and arrive as planned before: they would be solved as they are."""
        shift_s = plan.departure_s - before.departure_s
        later_s = shift_s + (plan.supplement_s - before.supplement_s)
        last = [parts[-1] for parts in self.windows.sections]
        return bool(max(np.abs(shift_s[self._first]).max(), np.abs(later_s[last]).max()) <= tolerance_s)

    def _saving_j(self, runs: Sequence[PassedRun], plan: Schedule) -> float:
        """What another plan promises to save, J: a second costs about the mean of both multipliers."""
        own = np.concatenate([run.multiplier_j_per_s for run in runs])
        taken_s = np.concatenate([np.diff(run.ends_s, prepend=0.0) for run in runs])
        more_s = self._fastest_s + plan.supplement_s - taken_s
        known = np.isfinite(own) & np.isfinite(plan.multiplier_j_per_s)
        above = np.subtract(own, plan.multiplier_j_per_s, out=np.zeros_like(own), where=known)
        return float(0.5 * np.sum(np.abs(above * more_s)))

    def _runs(self, plan: Schedule, terms: Terms, arrival_s: float, last: Timed | None) -> list[PassedRun] | None:
        """Runs of all sections as planned; None where one keeps no windows."""
        runs = []
        for number, parts in enumerate(self.windows.sections):
            own, departure_s = slice(parts[0], parts[-1] + 1), float(plan.departure_s[parts[0]])
            if len(parts) == 1:
                free, supplement_s = self.free[number], float(plan.supplement_s[own][0])
                free.reach(np.array([supplement_s]), terms.tolerance_s)
                if not slow_down(free, supplement_s, terms.tolerance_s):
                    return None
                run = int(free.slowest_within(np.array([supplement_s]))[0])
                multiplier = free.multiplier_j_per_s[[run]]
                runs.append(run_of_parts(self.sections[number].trip, [free], np.array([supplement_s]), multiplier))
                continue
            time_s = float(np.sum(self._fastest_s[own] + plan.supplement_s[own]))
            until_s = arrival_s - departure_s if number == len(self.sections) - 1 else None
            multiplier = last.runs[number].multiplier_j_per_s if last else plan.multiplier_j_per_s[own]
            points = points_since(self.windows, number, departure_s)
            found = in_one_piece(self.sections[number], points, time_s, until_s, multiplier, terms)
            if found is None or not found.is_met:
                return None
            runs.append(found.run)
        return runs


class Found(NamedTuple):
    """A run in one piece, whether it keeps its windows, and what is drawn in waiting that its energy counts not, W."""

    run: PassedRun
    is_met: bool
    spared_w: float


def in_one_piece(
    section: SectionRuns,
    points: Sequence[TimingPoint],
    time_s: float,
    until_s: float | None,
    multiplier_j_per_s: _Floats,
    terms: Terms,
) -> Found | None:
    """The run of a section with points in one piece, in a planned time, s; None where there is none.

    The last one may take until a time since its departure, s, where running as long as planned saves nothing any more.
    """
    ways = [(waiting_for_free(section.trip), terms.waiting_w, time_s)]
    if until_s is not None:  # who is there has not to wait, unless the last window opens later
        ways.insert(0, (section.trip, 0.0, until_s))
    found = None
    for trip, spared_w, own_s in ways:
        whole = whole_run(section, trip, points, own_s, multiplier_j_per_s, terms.tolerance_s)
        if whole is None:
            break
        run, is_met = whole
        multiplier_j_per_s = run.multiplier_j_per_s + (terms.waiting_w - spared_w)
        found = Found(run._replace(multiplier_j_per_s=multiplier_j_per_s), is_met, spared_w)
        if is_met or run.ends_s[-1] >= points[-1].earliest_s - terms.tolerance_s:
            break
    return found


def points_since(windows: Windows, number: int, departure_s: float) -> list[TimingPoint]:
    """Where a section passes and ends, with windows counted from its departure, s."""
    return [
        point._replace(earliest_s=point.earliest_s - departure_s, latest_s=point.latest_s - departure_s)
        for point in (windows.arrivals[part] for part in windows.sections[number])
    ]
