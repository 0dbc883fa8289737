"""What a search returns."""

import os
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tgvdp.api.budget import budget_of
from tgvdp.api.methods import Fastest, continuous_front
from tgvdp.api.sense import sensible_numbers
from tgvdp.certificate.front import Certificate, certify_front
from tgvdp.errors import ArgumentError, InputError
from tgvdp.margins.linear import scaled_run
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.methods.costate.front import OptimalRuns
from tgvdp.methods.grid.best_first_rules import Options, counted_j
from tgvdp.methods.grid.paths import GridPaths
from tgvdp.methods.grid.trace import MOST_STEPS, Trace, trace_best_first
from tgvdp.model.checks import require_index
from tgvdp.model.trip import Trip
from tgvdp.pareto import ParetoFront
from tgvdp.progress import tell
from tgvdp.referee.replay import NOT_REPLAYED, Verdict, replay
from tgvdp.runs.instructions import Instruction, instructions_of
from tgvdp.runs.profile import Profile, drawn_energy_j, profile_of
from tgvdp.runs.samples import rows_of, sampled
from tgvdp.units import JOULE_PER_KWH, SECONDS_PER_MINUTE, counted

if TYPE_CHECKING:
    from tgvdp.report.style import Picture

#: Running times at which a front on a grid is compared with the continuous optimum.
_CERTIFIED_TIMES = 32


@dataclass(frozen=True, eq=False, repr=False)
class SearchResult:
    """What a search found.

    Attributes
    ----------
    trip : Trip
    method : str
    fastest : Fastest
    front : ParetoFront
    counters : dict of str to int
        Work done, by kind.
    complete : bool
        False when a label or time budget ended the search: the front is then only what was found until then.
    options : dict
        The options of the search, defaults filled in.
    elapsed_s : float
        Wall time of the search, s.
    warnings : tuple of str
        Where the front is less than was asked for, and why.
    """

    trip: Trip
    method: str
    fastest: Fastest
    front: ParetoFront
    counters: dict[str, int]
    complete: bool
    options: dict[str, Any]
    elapsed_s: float
    _found: OptimalRuns | GridPaths
    warnings: tuple[str, ...] = ()

    @property
    def path_time_s(self) -> NDArray[np.float64]:
        """Running times of all paths that were found, on the front or not, s, (n,) float64."""
        return self._found.duration_s

    @property
    def path_energy_j(self) -> NDArray[np.float64]:
        """Energies of all paths that were found, J, (n,) float64."""
        return self._found.energy_j

    @property
    def price_kwh_per_min(self) -> NDArray[np.float64] | None:
        """Price of a minute at each point, kWh/min: the multiplier λ (method ``front`` only; infinite if fastest)."""
        if not isinstance(self._found, OptimalRuns):
            return None
        multiplier_j_per_s = self._found.multiplier_j_per_s[self.front.source]
        return np.asarray(multiplier_j_per_s * (SECONDS_PER_MINUTE / JOULE_PER_KWH))

    def profile(self, index: int) -> Profile:
        """Speed profile of one point of the front.

        Raises
        ------
        ArgumentError
            When the front has no point of that index, here and wherever else one is meant.
        """
        at = self._at(index)
        with self._computing():
            return self._profile(at)

    def instructions(self, index: int) -> tuple[Instruction, ...]:
        """Steps that a driver takes at one point of the front; shorter ones than 3 s are left out."""
        return instructions_of(self.profile(index))

    def advice(self, index: int) -> str:
        """The same as a sentence."""
        from tgvdp.report.advice import sentence

        return sentence(self.trip.track, self.instructions(index))

    def row_count(self, index: int) -> int:
        """Rows of `profile` of one point of the front."""
        return len(self._found.rows(int(self.front.source[self._at(index)]))[0])

    def linear_margin(self, index: int) -> Profile:
        """Speed profile of today's practice: the fastest run with all speeds scaled to the time of one point."""
        ratio = float(self.front.time_s[self._at(index)]) / self.fastest.time_s
        return scaled_run(self.trip, self.fastest.profile, ratio)

    def _at(self, index: int) -> int:
        return require_index("result", "index", index, len(self.front))

    def _profile(self, index: int) -> Profile:
        source = int(self.front.source[index])
        if not isinstance(self._found, OptimalRuns):
            return profile_of(self.trip, *self._found.rows(source))
        if self._found.duration_s[source] == self.fastest.profile.duration_s:
            return self.fastest.profile
        known = self._found.regimes(source)
        return profile_of(self.trip, *self._found.rows(source), known)

    def verify(self, time_limit_s: float | None = None) -> list[Verdict]:
        """Replay every point of the front by the independent referee.

        Parameters
        ----------
        time_limit_s : float, optional
            Time for it, s; by default as much as the search had. ``ok`` of points that are not reached is None.
        """
        clock = budget_of(self.options, time_limit_s).start()
        with self._computing():
            return [self._verdict(index, clock) for index in range(len(self.front))]

    def _verdict(self, index: int, clock: Clock) -> Verdict:
        tell("replaying", index, len(self.front))
        return NOT_REPLAYED if clock.expired else replay(self.trip, self._profile(index), lambda: clock.expired)

    def certify(self, time_limit_s: float | None = None) -> Certificate:
        """Bound the least energy of the continuous problem at the running time of every point of the front.

        For the methods on a grid the gap holds the error of the grid: multipliers come from method ``front``.

        Parameters
        ----------
        time_limit_s : float, optional
            Time for it, s; by default as much as the search had. Points that are not reached have no bound.
        """
        with self._computing():
            return self._certified(budget_of(self.options, time_limit_s))

    def _certified(self, budget: SearchBudget) -> Certificate:
        clock = budget.start()
        found = self._found
        if not isinstance(found, OptimalRuns):
            first_s, last_s = self.fastest.time_s, max(float(self.front.time_s[-1]), self.fastest.time_s)
            target_s = np.linspace(first_s, first_s + max(last_s - first_s, 1e-3 * first_s), _CERTIFIED_TIMES)
            found = continuous_front(self.trip, self.fastest.profile, target_s, budget)
        return certify_front(
            self.trip, self.fastest.profile, self.front.time_s, self.front.energy_j, self._drawn_j(),
            found.multiplier_j_per_s, clock,
        )  # fmt: skip

    def _drawn_j(self) -> NDArray[np.float64]:
        """Energy of each point before what braking returns, J."""
        if self.trip.energy.kind == "wheel":
            return self.front.energy_j
        return np.array([drawn_energy_j(self.trip, self._profile(index)) for index in range(len(self.front))])

    def trace(self, most_steps: int = MOST_STEPS) -> Trace:
        """Search again, method ``best-first``, and write down each step, for teaching; of small instances only.

        Parameters
        ----------
        most_steps : int
            The trace ends there; its ``complete`` says whether the search did before.

        Raises
        ------
        InputError
            When another method searched.
        """
        if not isinstance(self._found, GridPaths) or self.method != "best-first":
            raise InputError(f"trace: method {self.method} has no queue to watch; method best-first does")
        asked, grid = self.options, self._found.grid
        options = Options(
            heuristic=asked["heuristic"], paths=asked["paths"], dominance=asked["dominance"], bounds=asked["bounds"],
            reference_time_s=self.fastest.time_s, reference_energy_j=counted_j(grid, self.fastest.energy_j),
        )  # fmt: skip
        return trace_best_first(grid, self.fastest.time_s * (1.0 + asked["max_margin"]), options, most_steps)

    def _computing(self) -> AbstractContextManager[None]:
        return sensible_numbers(self.trip, self.options["max_memory_b"])

    def plot(self, picture: str = "front", *, certificate: Certificate | None = None) -> "Picture":
        """Draw a picture; notebooks show it, and its ``savefig`` writes it.

        Parameters
        ----------
        picture : {"front", "profile", "speed_time", "effort", "price"}
            Energy saved over delay; speed over distance, or over time, of the fastest, a middle and the thriftiest run;
            their effort and power; what a minute more saves.
        certificate : Certificate, optional
            Of `certify`: adds the proven bound to the front.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            When there is no such picture, or the certificate is none.
        """
        from tgvdp.report.gallery import draw

        if not isinstance(certificate, Certificate | None):
            raise ArgumentError("plot", "certificate", f"must be one of result.certify(), got {certificate!r:.60}")
        return draw(self, picture, certificate)

    def plot_run(self, index: int) -> "Picture":
        """Draw the speed over distance of one point of the front."""
        from tgvdp.report.profile_plots import plot_profile, run_of

        return plot_profile(self, run_of(self, index))

    def save(self, folder: str | os.PathLike[str], *, certify: bool = True, **options: Any) -> list[str]:
        """Write all files of ``tgvdp search`` into a folder, all or none, and return their names.

        Parameters
        ----------
        folder : path
            Made when absent; files of an earlier run are replaced.
        certify : bool
            Whether files and picture hold the bounds of `certify`.
        **options
            Of `tgvdp.report.write_results`: ``profiles``, ``every_m``, ``pictures``, ``tariff``, ``progress``.

        Raises
        ------
        InputError
            When the folder cannot be written, or an option is out of range.
        """
        from tgvdp.report import write_results
        from tgvdp.report.files import check_writable

        check_writable(folder)  # before what may take minutes
        certificate = self.certify() if certify else None
        return [file.name for file in write_results(self, folder, certificate=certificate, **options).files]

    def to_pandas(self) -> Any:
        """Points of the front as a `pandas.DataFrame`, with the columns of ``front.csv`` that need no replay.

        Raises
        ------
        MissingExtraError
            When pandas is not installed.
        """
        from tgvdp.report.notebook import front_frame

        return front_frame(self)

    def profile_to_pandas(self, index: int, every_m: float | None = None) -> Any:
        """Profile of one point of the front as a `pandas.DataFrame` with the columns of ``profiles.csv``.

        Parameters
        ----------
        index : int
        every_m : float, optional
            Distance between the rows, m; by default all rows of the profile.

        Raises
        ------
        MissingExtraError
            When pandas is not installed.
        """
        from tgvdp.report.notebook import samples_frame

        profile = self.profile(index)
        return samples_frame(rows_of(self.trip, profile) if every_m is None else sampled(self.trip, profile, every_m))

    def __repr__(self) -> str:
        name = f"{self.trip.train.name} on {self.trip.track.name}"
        points = counted(len(self.front), "point")
        return f"<SearchResult: {name}, method {self.method}, {points} from {self.fastest.time_s:.1f} s>"

    def _repr_html_(self) -> str:
        """Show a small picture and a table, in notebooks."""
        from tgvdp.report.notebook import result_html

        return result_html(self)
