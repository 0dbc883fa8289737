"""Margins of a journey side by side: linear, economy, uniform, and the optimum of the same running time."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tgvdp.api.targets import met_to_s
from tgvdp.errors import ArgumentError, BudgetExceededError, InputError
from tgvdp.journeys.front import journey_front
from tgvdp.journeys.section import SectionRuns
from tgvdp.margins.side_by_side import deviation_s, largest_deviation_s, margin_runs
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.model.checks import require_number
from tgvdp.model.margin import MarginRange, checked_ranges
from tgvdp.model.trip import Trip
from tgvdp.referee.replay import NOT_REPLAYED, Verdict, replay
from tgvdp.runs.profile import Profile, joined
from tgvdp.units import counted, joule_to_kwh

if TYPE_CHECKING:
    from tgvdp.report.style import Picture

_Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Margins:
    """One running-time supplement, taken in four ways.

    Attributes
    ----------
    ranges : tuple of MarginRange
        The supplement, by ranges of the line.
    within : float
        Of the uniform margin: how far times between any two points are from the linear ones at most, as a share.
    fastest_s : float
        Running time of the fastest journey without dwell, s.
    trips : tuple of Trip
        The sections.
    runs : dict of str to tuple of Profile
        Runs of the sections by ``"linear"``, ``"economy"``, ``"uniform"`` and ``"optimum"``.
    dwell_s : float
        Standstill at each stop on the way, s.
    """

    ranges: tuple[MarginRange, ...]
    within: float
    fastest_s: float
    trips: tuple[Trip, ...]
    runs: dict[str, tuple[Profile, ...]]
    dwell_s: float

    def __repr__(self) -> str:
        taken = ", ".join(f"{name} {joule_to_kwh(energy_j):.2f} kWh" for name, energy_j in self.energy_j.items())
        slowed = f"from {self.fastest_s:.1f} to {self.time_s['optimum']:.1f} s"
        return f"<Margins: {counted(len(self.trips), 'section')}, {slowed}: {taken}>"

    @property
    def time_s(self) -> dict[str, float]:
        """Running time without dwell by each, s."""
        return {name: sum(run.duration_s for run in runs) for name, runs in self.runs.items()}

    @property
    def energy_j(self) -> dict[str, float]:
        """Energy by each, J."""
        return {name: sum(run.total_energy_j for run in runs) for name, runs in self.runs.items()}

    @property
    def deviation_s(self) -> dict[str, float]:
        """Largest deviation from the linear time anywhere, by each, s."""
        return {name: largest_deviation_s(runs, self.runs["linear"]) for name, runs in self.runs.items()}

    def deviations(self, name: str) -> tuple[_Floats, _Floats]:
        """Positions, m, and how much later the train is there than by the linear margin, s; (n,) each."""
        positions_m, late_s, ahead_s = [], [], 0.0
        for run, linear in zip(self._runs(name), self.runs["linear"], strict=True):
            position_m, own_s = deviation_s(run, linear)
            positions_m.append(position_m)
            late_s.append(own_s + ahead_s)
            ahead_s += run.duration_s - linear.duration_s
        return np.concatenate(positions_m), np.concatenate(late_s)

    def profile(self, name: str) -> Profile:
        """Speed profile of the whole journey by one of them."""
        runs = self._runs(name)
        return joined(runs, np.cumsum([0.0, *(run.duration_s + self.dwell_s for run in runs[:-1])]))

    def _runs(self, name: str) -> tuple[Profile, ...]:
        if name not in self.runs:
            raise ArgumentError("margins", "name", f"must be one of {', '.join(self.runs)}, got {name!r:.60}")
        return self.runs[name]

    def verify(self, time_limit_s: float = math.inf) -> dict[str, list[Verdict]]:
        """Replay every section by the independent referee; speeds of the linear margin may ask for too much uphill.

        Parameters
        ----------
        time_limit_s : float
            Time for it, s; ``ok`` of runs that are not reached is None.
        """
        clock = SearchBudget(time_limit_s=time_limit_s).start()

        def verdict(trip: Trip, run: Profile) -> Verdict:
            return NOT_REPLAYED if clock.expired else replay(trip, run, lambda: clock.expired)

        return {name: list(map(verdict, self.trips, runs)) for name, runs in self.runs.items()}

    def plot(self) -> "Picture":
        """Draw how far each is from the linear time along the line, and what it takes."""
        from tgvdp.report.margin_plots import plot_margins

        return plot_margins([self])


def margins_of(
    sections: Sequence[SectionRuns], ranges: Sequence[MarginRange], within: float, dwell_s: float, clock: Clock
) -> Margins:
    """Slow the fastest runs of sections down in all ways.

    Parameters
    ----------
    sections : sequence of SectionRuns
        Of which no runs are known: so the optimum does not depend on what else was asked for.
    ranges, within, dwell_s
        As of `Margins`.
    clock : Clock

    Raises
    ------
    InputError
        When ranges overlap or do not lie on the line, or ``within`` is out of range.
    InfeasibleError, BudgetExceededError
        See `tgvdp.margins.side_by_side.margin_runs`; the time may be up before the optimum is found, too.
    """
    if not 0.0 < require_number("margins", "within", within, "as a share", above=0.0) < 1.0:
        raise InputError(f"margins: within must be below 1 as a share, got {within:g}")
    slowed = margin_runs([(one.trip, one.fastest) for one in sections], ranges, within, clock)
    fastest_s = sum(one.fastest.duration_s for one in sections)
    runs = {name: tuple(own) for name, own in slowed._asdict().items()}
    supplement_s = sum(run.duration_s for run in slowed.linear) - fastest_s
    wanted_s = np.array([max(supplement_s, 0.0)])
    found = journey_front(sections, wanted_s, met_to_s(fastest_s), dwell_s, lambda: clock.expired)
    if not found.complete:
        raise BudgetExceededError("margins: the time limit passed before the optimum was found")
    runs["optimum"] = tuple(one.profile(int(run)) for one, run in zip(sections, found.run[-1], strict=True))
    ordered = checked_ranges(ranges, sections[0].trip.track.length_m)
    return Margins(ordered, within, fastest_s, tuple(one.trip for one in sections), runs, dwell_s)
