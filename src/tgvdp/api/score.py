"""A recorded run against the front: what it cost, what the optimum at the same time costs, and where they differ."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tgvdp.api.result import SearchResult
from tgvdp.api.run import search
from tgvdp.api.trip import trip_of
from tgvdp.errors import ArgumentError, InputError
from tgvdp.formats.recorded_run import RecordedRun
from tgvdp.formats.sources import Source
from tgvdp.formats.syntax.reading import errors_named
from tgvdp.line.resolved import resolve
from tgvdp.model.checks import require_number
from tgvdp.model.track import POWERED, Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.options.search import SearchOptions
from tgvdp.runs.profile import Profile, profile_of
from tgvdp.runs.recorded import placed, recorded_profile, sections_of
from tgvdp.runs.recorded_means import Motion
from tgvdp.units import joule_to_kwh, mps_to_kmh

if TYPE_CHECKING:
    from tgvdp.report.style import Picture

#: Margin up to which the front is searched, unless the run took longer.
_MARGIN = 0.25
#: Room beyond the recorded time, so that the front does not end there.
_BEYOND = 1.02
#: A word is due where the traction limit is exceeded by this factor for this share of the time, where durations differ
#: by this share, and where a speed limit is exceeded, or a speed at an end uncertain, by so much, m/s.
_EFFORT_FACTOR, _EFFORT_SHARE, _TIME_SHARE, _OVERSPEED_MPS, _END_SPEED_MPS = 1.05, 0.05, 0.01, 0.3, 0.5
#: ... and where so much of the work of traction is done without current.
_DARK_SHARE = 0.01
#: Times as near as this are one, s.
_SAME_S = 1e-6


@dataclass(frozen=True, eq=False, repr=False)
class Score:
    """A recorded run, judged.

    Attributes
    ----------
    name : str
        Of the record.
    result : SearchResult
        The front of the trip that was recorded.
    time_s : float
        Recorded running time, s.
    recorded : Profile
        The run with the recorded speeds; its efforts and energy are the model's.
    optimum : Profile
        The thriftiest run that takes no longer than recorded, or the fastest one where that takes longer. Its regimes
        are told by its efforts, as those of a record are, not by what its search meant them to be.
    warnings : tuple of str
        Where record and model do not fit.
    """

    name: str
    result: SearchResult
    time_s: float
    recorded: Profile
    optimum: Profile
    warnings: tuple[str, ...]

    def __repr__(self) -> str:
        recorded, optimum = (joule_to_kwh(run.total_energy_j) for run in (self.recorded, self.optimum))
        return f"<Score: {self.name} in {self.time_s:.1f} s, {recorded:.2f} kWh, optimum {optimum:.2f} kWh>"

    @property
    def saving_j(self) -> float:
        """Energy that the optimum saves in the recorded time, J."""
        return self.recorded.total_energy_j - self.optimum.total_energy_j

    @property
    def time_for_energy_s(self) -> float | None:
        """Shortest time in which the recorded energy suffices, s; None where that is no less than recorded.

        Between two points of the front a straight line is taken, which is not below it.
        """
        front, energy_j = self.result.front, self.recorded.total_energy_j
        time_s = float(np.interp(-energy_j, -front.energy_j, front.time_s))
        return time_s if energy_j >= front.energy_j[-1] and time_s <= self.time_s else None

    @property
    def saving_in_brakes_j(self) -> float:
        """Part of the difference of the traction work that the recorded run braked away, J."""
        return _braked_j(self.recorded) - _braked_j(self.optimum)

    @property
    def saving_in_resistance_j(self) -> float:
        """Part that its higher speeds cost against the resistance, J: work at the wheel ends here or in brakes."""
        return self.recorded.balance.wheel_j - self.optimum.balance.wheel_j - self.saving_in_brakes_j

    def plot(self) -> "Picture":
        """Draw both runs, their energies along the line, and the way from the record to the front."""
        from tgvdp.report.scores import plot_score

        return plot_score(self)


def _braked_j(profile: Profile) -> float:
    return profile.balance.braking_losses_j + profile.balance.regenerated_j


def score_run(
    run: RecordedRun,
    train: Train | Source,
    track: Track | Source,
    *,
    start_m: float | None = None,
    end_m: float | None = None,
    section: int | None = None,
    window_s: float | None = None,
    **options: Any,
) -> Score:
    """Hold a recorded run against the front of the same trip.

    Parameters
    ----------
    run : RecordedRun
        As `load_run` returns it.
    train : Train or str or path
    track : Track or str or path
    start_m, end_m : float, optional
        Positions on the track at which the section starts and ends: its own are shifted and stretched to them. By
        default positions are those recorded, and 0 m at the start where none are.
    section : int, optional
        Section between two stands, from 1; needed where there are several.
    window_s : float, optional
        Speeds are means over so many seconds, which takes away noise; by default as recorded, or over 10 s where no
        speed is.
    **options
        Of `tgvdp.search`: ``energy``, ``convention`` and its switches.

    Raises
    ------
    InputError
        When the record does not fit on the line, or a section is to be chosen.
    """
    if not isinstance(run, RecordedRun):
        raise ArgumentError("recorded run", "run", f"must be a RecordedRun, as of load_run, got {run!r:.60}")
    if window_s is not None:
        require_number("recorded run", "window_s", window_s, "s", at_least=0.0)
    with errors_named(Path(run.name)):
        sections = sections_of(run.position_m, run.speed_mps, run.time_s, window_s)
    motion = placed(_chosen(sections, section), start_m, end_m)
    time_s = float(motion.time_s[-1] - motion.time_s[0])
    ends: dict[str, Any] = {
        "origin_m": float(motion.position_m[0]),
        "destination_m": float(motion.position_m[-1]),
        "start_speed_mps": float(motion.speed_mps[0]),
        "end_speed_mps": float(motion.speed_mps[-1]),
    }
    length_m = trip_of(train, track, SearchOptions(**options)).track.length_m
    if ends["origin_m"] < 0.0 or ends["destination_m"] > length_m:
        raise InputError(
            f"{run.name}: goes from {ends['origin_m']:.6g} m to {ends['destination_m']:.6g} m, the line from 0 m to"
            f" {length_m:.6g} m: say where the record starts and ends"
        )
    result = search(train, track, **ends, **options)
    fastest_s = result.fastest.time_s
    if time_s > fastest_s * (1.0 + _MARGIN):
        result = search(train, track, **ends, max_time_s=_BEYOND * time_s, **options)
    optimum = result.fastest.profile
    if time_s > fastest_s:
        at_time = search(train, track, **ends, at_s=(time_s,), **options)
        optimum = at_time.profile(len(at_time.front) - 1)
    recorded = recorded_profile(result.trip, motion)
    optimum = replace(optimum, regime=_told_regime(result.trip, optimum))
    return Score(run.name, result, time_s, recorded, optimum, _doubts(result.trip, recorded, motion, fastest_s))


def _told_regime(trip: Trip, profile: Profile) -> NDArray[np.int8]:
    """Regime of each row of a run by its effort, whatever is known of it."""
    return profile_of(trip, profile.position_m - trip.origin_m, profile.speed_mps**2).regime


def _chosen(sections: list[Motion], section: int | None) -> Motion:
    if section is None and len(sections) > 1:
        spans = ", ".join(f"{one.position_m[0]:.0f}–{one.position_m[-1]:.0f} m" for one in sections[:6])
        raise InputError(f"recorded run: has {len(sections)} sections between stands ({spans}): choose one of them")
    if section is not None and not 1 <= section <= len(sections):
        raise InputError(f"recorded run: section must be from 1 to {len(sections)}, got {section}")
    return sections[(section or 1) - 1]


def _overspeed_mps(trip: Trip, motion: Motion) -> float:
    """By how much a record exceeds the limit most, m/s, at its rows: what lies between them is the model's.

    Where speeds are means, that is the highest one that holds within what they are means of, from row to row: they
    round the corner where a train has braked to a limit.
    """
    t, x = motion.time_s, motion.position_m
    blurred_s = motion.blurred_s() - _SAME_S
    first = np.searchsorted(t, t - blurred_s, side="right") - 1
    last = np.searchsorted(t, t + blurred_s)
    first_m, last_m = x[first.clip(0)], x[last.clip(max=len(t) - 1)]
    return float((motion.speed_mps - _highest_limit(trip, first_m, last_m)).max())


def _highest_limit(trip: Trip, from_m: NDArray[np.float64], to_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Highest speed limit of line and train on each of several stretches, m/s."""
    line = resolve(trip)
    steps = np.stack((line.step_at(from_m - trip.origin_m), line.step_at(to_m - trip.origin_m) + 1), axis=1)
    # Every second one is of what lies between two stretches; the last of all needs an end to begin at.
    return np.maximum.reduceat(np.append(line.limit_mps, 0.0), steps.ravel())[::2]


def _doubts(trip: Trip, recorded: Profile, motion: Motion, fastest_s: float) -> tuple[str, ...]:
    """Say where record and model do not fit."""
    found = []
    time_s = float(motion.time_s[-1] - motion.time_s[0])
    if motion.doubt_mps > _END_SPEED_MPS:
        start_mps, end_mps = (float(motion.speed_mps[row]) for row in (0, -1))
        found.append(
            f"no speeds are recorded: those at its ends, {start_mps:.3g} and {end_mps:.3g} m/s, are told by positions"
            f" near them, and uncertain by {motion.doubt_mps:.2g} m/s"
        )
    if time_s < fastest_s:
        found.append(
            f"the run took {time_s:.6g} s, less than the fastest run of the model, {fastest_s:.6g} s, to which it is"
            " compared: train, limits or positions differ from what was driven"
        )
    if abs(recorded.duration_s - time_s) > _TIME_SHARE * time_s:
        found.append(f"by speeds and positions the run takes {recorded.duration_s:.6g} s, by its times {time_s:.6g} s")
    over_mps = _overspeed_mps(trip, motion)
    if over_mps > _OVERSPEED_MPS:
        found.append(f"the run exceeds a speed limit by {mps_to_kmh(over_mps):.3g} km/h")
    duration_s = np.diff(recorded.time_s)
    middle_mps = 0.5 * (recorded.speed_mps[:-1] + recorded.speed_mps[1:])
    limit_n = np.array([trip.train.traction_limit.effort_n(speed) for speed in middle_mps.tolist()])
    beyond = recorded.force_n[:-1] > _EFFORT_FACTOR * limit_n
    share = float(duration_s[beyond].sum() / duration_s.sum())
    if share > _EFFORT_SHARE:
        found.append(
            f"in {100.0 * share:.0f} % of the time the recorded speeds ask for more traction than the train has: noise,"
            " which a mean over some seconds takes away, or another train"
        )
    dark_j = _dark_j(trip, recorded)
    if dark_j > _DARK_SHARE * recorded.balance.wheel_j:
        found.append(
            f"the recorded speeds ask for {joule_to_kwh(dark_j):.3g} kWh of traction at the wheel where the line has no"
            " current: positions or neutral sections differ from what was driven"
        )
    return tuple(found)


def _dark_j(trip: Trip, recorded: Profile) -> float:
    """Work of traction at the wheel where a line has no current, J."""
    position_m = recorded.position_m - trip.origin_m
    supply = resolve(trip).supply_between(position_m)
    work_j = np.maximum(recorded.force_n[:-1], 0.0) * np.diff(position_m)
    return float(work_j[supply != POWERED].sum())
