"""What a journey returns."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tgvdp.api.budget import budget_of
from tgvdp.api.margins import Margins, margins_of
from tgvdp.api.section_method import SectionMethod
from tgvdp.api.sense import sensible_numbers
from tgvdp.certificate.front import Certificate, certify_front
from tgvdp.cores import side_by_side
from tgvdp.errors import InputError
from tgvdp.journeys.bound import JourneyBound, journey_bound
from tgvdp.journeys.delays import Delays, Robustness, robustness, standard_delays
from tgvdp.journeys.front import JourneyFront
from tgvdp.journeys.passed import PassedRuns
from tgvdp.journeys.section import SectionRuns
from tgvdp.journeys.timed_bound import timed_bound
from tgvdp.journeys.windows import Windows
from tgvdp.margins.linear import scaled_run
from tgvdp.model.checks import require_index
from tgvdp.model.margin import MarginRange
from tgvdp.model.trip import Trip
from tgvdp.options.texts import parse_margins
from tgvdp.pareto import ParetoFront
from tgvdp.referee.replay import NOT_REPLAYED, Verdict, replay
from tgvdp.runs.instructions import instructions_of
from tgvdp.runs.profile import Profile, joined
from tgvdp.units import JOULE_PER_KWH, SECONDS_PER_MINUTE, counted

if TYPE_CHECKING:
    from tgvdp.report.style import Picture

_Floats = NDArray[np.float64]


def beside_windows(what: str) -> InputError:
    """Error of what is done without windows only."""
    return InputError(f"journey: {what} without windows only")


@dataclass(frozen=True, eq=False, repr=False)
class JourneyResult:
    """The front of a journey, and how each of its points splits the time among the sections.

    Attributes
    ----------
    trip : Trip
        From the first stop to the last one.
    sections : tuple of SectionRuns or PassedRuns
        From stop to stop: ``trip``, ``fastest`` run, and the runs found.
    windows : Windows
        When the train may arrive, depart and pass, and how long it stands at least.
    options : dict
        As asked for, defaults filled in.
    elapsed_s : float
        Wall time, s.
    warnings : tuple of str
        Where the result is less than was asked for, and why.
    """

    trip: Trip
    sections: tuple[SectionRuns | PassedRuns, ...]
    windows: Windows
    options: dict[str, Any]
    elapsed_s: float
    found: JourneyFront
    warnings: tuple[str, ...] = ()

    @property
    def front(self) -> ParetoFront:
        """Running times of the whole journey without dwell, s, and energies, J; the fastest journey first.

        With windows energies have what is drawn in waiting for them: ``found.waiting_s`` at ``found.waiting_w``.
        """
        return self.found.front

    @property
    def fastest_time_s(self) -> float:
        """Running time of the fastest journey, s."""
        return sum(section.fastest.duration_s for section in self.sections)

    @property
    def fastest_energy_j(self) -> float:
        """Energy of the fastest journey, J."""
        return sum(section.fastest.total_energy_j for section in self.sections)

    @property
    def section_time_s(self) -> _Floats:
        """Running time of each section at each point, s, (n, sections) float64."""
        return np.column_stack(
            [section.time_s[run] for section, run in zip(self.sections, self.found.run.T, strict=True)]
        )

    @property
    def section_energy_j(self) -> _Floats:
        """Energy of each section at each point, J, (n, sections) float64."""
        return np.column_stack(
            [section.energy_j[run] for section, run in zip(self.sections, self.found.run.T, strict=True)]
        )

    @property
    def price_kwh_per_min(self) -> _Floats:
        """Price of a minute at each point, kWh/min: the multiplier of the section that ends the journey.

        That is the one of all sections, unless windows part them (``found.multiplier_j_per_s``).
        """
        return self.found.multiplier_j_per_s[:, -1] * (SECONDS_PER_MINUTE / JOULE_PER_KWH)

    def at(self, index: int) -> int:
        """Index of a point of the front, from its beginning.

        Raises
        ------
        ArgumentError
            When the front has no point of that index, here and wherever else one is meant.
        """
        return require_index("journey", "index", index, len(self.front))

    def linear_margin(self, index: int) -> Profile:
        """Speed profile of the fastest journey with all speeds scaled to the running time of one point of the front."""
        ratio = float(self.front.time_s[self.at(index)]) / self.fastest_time_s
        runs = [scaled_run(section.trip, section.fastest, ratio) for section in self.sections]
        until_next_s = [run.duration_s + self.options["dwell_s"] for run in runs]
        return joined(runs, np.cumsum([0.0, *until_next_s[:-1]]))

    @cached_property
    def linear_margin_j(self) -> _Floats:
        """Energy of `linear_margin` at each point, J, (n,) float64."""
        ratios = (self.front.time_s / self.fastest_time_s).tolist()
        # Section by section: the line of a section is resolved once for all of its runs.
        energy_j = [
            [scaled_run(one.trip, one.fastest, ratio).total_energy_j for ratio in ratios] for one in self.sections
        ]
        return np.asarray(np.sum(energy_j, axis=0))

    def section_profiles(self, index: int) -> list[Profile]:
        """Speed profile of each section at one point of the front, each from its own departure."""
        return [
            section.profile(run)
            for section, run in zip(self.sections, self.found.run[self.at(index)].tolist(), strict=True)
        ]

    def advice(self, index: int) -> list[str]:
        """What a driver does in each section at one point of the front, a sentence each."""
        from tgvdp.report.advice import sentence

        return [sentence(self.trip.track, instructions_of(profile)) for profile in self.section_profiles(index)]

    def profile(self, index: int) -> Profile:
        """Speed profile of the whole journey at one point of the front.

        A stop on the way is two rows at its position, arrival and departure. Times count from the first departure.
        """
        departure_s = self.found.departure_s[self.at(index)]
        return joined(self.section_profiles(index), departure_s - departure_s[0])

    def verify(self, time_limit_s: float | None = None) -> list[list[Verdict]]:
        """Replay every section of every point by the independent referee.

        Parameters
        ----------
        time_limit_s : float, optional
            Time for it, s; by default as much as the search had. ``ok`` of runs that are not reached is None.
        """
        clock = budget_of(self.options, time_limit_s).start()
        known: dict[tuple[int, int], Verdict] = {}
        for number, section in enumerate(self.sections):
            for run in np.unique(self.found.run[:, number]).tolist():
                if clock.expired:
                    known[number, run] = NOT_REPLAYED
                    continue
                with sensible_numbers(section.trip, self.options["max_memory_b"]):
                    known[number, run] = replay(section.trip, section.profile(run), lambda: clock.expired)
        return [[known[number, run] for number, run in enumerate(runs)] for runs in self.found.run.tolist()]

    def certify(self, time_limit_s: float | None = None) -> JourneyBound:
        """Bound the least energy of every journey, however it splits the time, at the running time of each point.

        With windows: of every journey that keeps them and ends no later.

        Parameters
        ----------
        time_limit_s : float, optional
            Time for it, s; by default as much as the search had.
        """
        clock = budget_of(self.options, time_limit_s).start()
        passed = [section for section in self.sections if isinstance(section, PassedRuns)]
        if passed and self.trip.energy.map is None:
            with sensible_numbers(self.trip, self.options["max_memory_b"]):
                return timed_bound(
                    passed, self.windows, self.found.waiting_w, self.found.run, self.found.departure_s, clock
                )

        def certificate(section: SectionRuns | PassedRuns, run: NDArray[np.int64]) -> Certificate | None:
            if clock.expired:
                return None
            own = np.unique(run)
            with sensible_numbers(section.trip, self.options["max_memory_b"]):
                return certify_front(
                    section.trip, section.fastest, section.time_s[own], section.energy_j[own], section.energy_j[own],
                    np.unique(self.found.multiplier_j_per_s.clip(0.0)), clock,
                )  # fmt: skip

        made = side_by_side(certificate, self.sections, self.found.run.T)
        certificates = [one for one in made if one is not None]
        if len(certificates) < len(made):
            return JourneyBound(np.full(len(self.front), np.nan), False)
        # Who waits less may run longer, and waiting takes no less than nothing.
        return journey_bound(certificates, self.front.time_s + self.found.waiting_s)

    def robustness(
        self, index: int | None = None, mean_delay_s: float = 20.0, delays: Delays | None = None
    ) -> Robustness:
        """Simulate delays: what the optimum, today's practices and mixtures of them take and how late they are.

        Parameters
        ----------
        index : int, optional
            Point of the front whose running time all of them have; by default the middle one.
        mean_delay_s : float
            Mean delay of departures, s, of the standard delays.
        delays : Delays, optional
            Others in their place.

        Raises
        ------
        InputError
            With windows, which the simulation does not know, and when delays are out of range.
        """
        at = self.at(len(self.front) // 2 if index is None else index)
        between = self._without_windows("delays are simulated")
        allocations_s = {"optimum": self.section_time_s[at]}
        for name, practice in self.found.practices.items():
            own_s = [section.time_s[run] for section, run in zip(between, practice.run[at], strict=True)]
            allocations_s[name] = np.array(own_s)
        if delays is None:
            delays = standard_delays([section.fastest.duration_s for section in between], mean_delay_s)
        return robustness(between, allocations_s, self.options["dwell_s"], delays)

    def margins(
        self, ranges: str | Sequence[MarginRange], within: float = 0.02, time_limit_s: float | None = None
    ) -> Margins:
        """Take a running-time supplement as railways define it, beside the optimum of the same time.

        Parameters
        ----------
        ranges : str or sequence of MarginRange
            The supplement: ``"5%"``, ``"4.5min/100km"`` or ``"90s"`` of the whole journey, or by ranges of the line:
            ``"0:10km:5%,10km::4.5min/100km"``.
        within : float
            Of the uniform margin: how far times between any two points may be from the linear ones, as a share.
        time_limit_s : float, optional
            Time for it, s; by default as much as the search had.

        Raises
        ------
        InputError
            With windows, which margins do not know, and when ranges are none, overlap, or do not lie on the line.
        InfeasibleError
            When a range is too short for its supplement.
        BudgetExceededError
            When the time is up.
        """
        between = self._without_windows("margins are taken")
        asked = parse_margins(ranges) if isinstance(ranges, str) else ranges
        clock = budget_of(self.options, time_limit_s).start()
        with sensible_numbers(self.trip, self.options["max_memory_b"]):
            unknown = [
                SectionRuns(one.trip, one.fastest, SectionMethod(one.trip, clock, self.options["max_memory_b"]))
                for one in between
            ]
            return margins_of(unknown, asked, within, self.options["dwell_s"], clock)

    def _without_windows(self, what: str) -> list[SectionRuns]:
        """Sections of a journey without windows."""
        between = [section for section in self.sections if isinstance(section, SectionRuns)]
        if not self.windows.are_open or len(between) < len(self.sections):
            raise beside_windows(what)
        return between

    def plot(self, picture: str = "front", index: int | None = None) -> "Picture":
        """Draw a picture; notebooks show it, and its ``savefig`` writes it.

        Parameters
        ----------
        picture : {"front", "time_distance", "profile", "allocation", "price"}
            Energy over running time with today's practices; time over distance; speed over distance; what each section
            gets; what a minute more saves in each section.
        index : int, optional
            Point of the front that the last three show; by default the middle one.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from tgvdp.report.journey_plots import draw

        return draw(self, picture, index)

    def save(self, folder: str | os.PathLike[str]) -> list[str]:
        """Write all files of ``tgvdp journey`` into a folder, all or none, and return their names."""
        from tgvdp.report.files import check_writable
        from tgvdp.report.journeys import write_journey

        check_writable(folder)  # before what may take minutes
        return [file.name for file in write_journey(self, folder).files]

    def __repr__(self) -> str:
        name = f"{self.trip.train.name} on {self.trip.track.name}"
        return (
            f"<JourneyResult: {name}, {counted(len(self.sections), 'section')},"
            f" {counted(len(self.front), 'point')} from {self.fastest_time_s:.1f} s>"
        )

    def _repr_html_(self) -> str:
        """Show a small picture and a table, in notebooks."""
        from tgvdp.report.notebook import journey_html

        return journey_html(self)
