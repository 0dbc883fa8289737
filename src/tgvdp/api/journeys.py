"""A journey: a train over all stops of a line, each section from stop to stop solved by the front method."""

import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tgvdp.api.budget import budget_of
from tgvdp.api.journey_result import JourneyResult, beside_windows
from tgvdp.api.section_method import SectionMethod
from tgvdp.api.sense import sensible_numbers
from tgvdp.api.targets import asked_targets, met_to_s
from tgvdp.api.trip import trip_of
from tgvdp.cores import side_by_side
from tgvdp.errors import ArgumentError, BudgetExceededError, InfeasibleError, InputError
from tgvdp.formats import load_journey
from tgvdp.formats.sources import Source
from tgvdp.journeys.front import JourneyFront, journey_front
from tgvdp.journeys.passed import PassedRuns
from tgvdp.journeys.section import SectionRuns
from tgvdp.journeys.timed import TimedJourney
from tgvdp.journeys.windows import Windows, windows_of
from tgvdp.memory import limited_memory
from tgvdp.methods.budget import Clock
from tgvdp.model.checks import require_number
from tgvdp.model.energy import EnergyMap
from tgvdp.model.journey import Journey, TimingPoint
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.model.variants import named_track
from tgvdp.options.search import JourneyOptions
from tgvdp.runs.fastest import fastest_run

_Floats = NDArray[np.float64]

#: Sections that are handed out together.
_AT_ONCE = 32
#: Without the fastest runs there is nothing to return: they may take this multiple of the time limit.
_PATIENCE = 1.5


def journey(
    train: Train | Source,
    track: Track | Source,
    journey: Journey | Source | None = None,
    *,
    dwell_s: float = 30.0,
    reverse: bool = False,
    speed_restrictions: Sequence[tuple[float, float, float]] = (),
    energy: str | EnergyMap = "wheel",
    convention: str = "ttobench",
    mass_model: str | None = None,
    limits: str | None = None,
    curves: str | None = None,
    tunnels: bool | None = None,
    wind_mps: float = 0.0,
    points: int = 60,
    max_margin: float = 0.25,
    at_s: Sequence[float] = (),
    at_margin: Sequence[float] = (),
    time_limit_s: float | None = None,
    max_memory_b: float | None = None,
) -> JourneyResult:
    """Find the front of a train over all stops of a line: least energy for each running time, and who gets the time.

    Parameters
    ----------
    train, track
        As of `tgvdp.search`.
    journey : Journey or path, optional
        A timetable, whose stops count in place of the line's own, with its windows of time and speed. With windows the
        points are least energies for arrivals evenly from the earliest possible one on, as late as the last one allows.
    dwell_s : float
        Least standstill at each stop on the way, s; no part of running times.
    reverse, speed_restrictions, energy, convention, mass_model, limits, curves, tunnels, wind_mps
        As of `tgvdp.search`.
    points : int
        Number of points of the front, evenly in time, the fastest journey included.
    max_margin : float
        Largest running-time supplement, as a share of the fastest journey's running time.
    at_s, at_margin : sequence of float
        Running times of the whole journey without dwell, s, and supplements as shares of the fastest one, at which to
        find the points instead. Met to 0.1 s. With windows times are arrivals at the end, on the timetable's clock, and
        supplements count from the earliest arrival.
    time_limit_s : float, optional
        Budget of the whole journey, s; 60 by default, infinite means none.
    max_memory_b : float, optional
        As of `tgvdp.search`.

    Returns
    -------
    JourneyResult

    Raises
    ------
    InputError
        When an option is out of range, or a stop does not lie on the line.
    InfeasibleError
        When a section has no run that obeys all limits, no journey is as fast as ``at_s`` asks, or a window cannot be
        met: the error names it, by how much it is missed, and what would meet it.
    BudgetExceededError
        When one and a half of the time has passed before every section has its fastest run.
    """
    started = time.perf_counter()
    require_number("journey", "dwell_s", dwell_s, "s", at_least=0.0)
    options = JourneyOptions(
        reverse=reverse,
        speed_restrictions=speed_restrictions,
        energy=energy,
        convention=convention,
        mass_model=mass_model,
        limits=limits,
        curves=curves,
        tunnels=tunnels,
        wind_mps=wind_mps,
        points=points,
        max_margin=max_margin,
        at_s=at_s,
        at_margin=at_margin,
        time_limit_s=time_limit_s,
        max_memory_b=max_memory_b,
    )
    line = trip_of(train, track, options)
    timetable = load_journey(journey, line.track) if isinstance(journey, str | os.PathLike) else journey
    if not isinstance(timetable, Journey | None):
        raise ArgumentError("journey", "journey", f"must be a Journey or a path, got {journey!r:.60}")
    windows = _windows(line.track, timetable, dwell_s)
    if timetable is not None:
        line = replace(line, track=named_track(line.track, timetable.places))
    stops_m = (
        *(windows.departures[parts[0]].position_m for parts in windows.sections),
        windows.arrivals[-1].position_m,
    )
    budget = budget_of(options.as_dict())
    clock = budget.start()
    solved = _solver(clock, max_memory_b)
    whole = replace(line, origin_m=stops_m[0], destination_m=stops_m[-1])
    with limited_memory(max_memory_b):
        between = tuple(_fastest(line, list(pairwise(stops_m)), solved, clock))
        sections: tuple[SectionRuns | PassedRuns, ...] = between
        if windows.are_open:
            supplement_s, tolerance_s = _supplements(between, options)
            found = journey_front(between, supplement_s, tolerance_s, dwell_s, lambda: clock.expired)
        else:
            sections, found = _timed(
                TimedJourney(between, whole, windows, solved, _solver(clock, max_memory_b, rough=True)), options
            )
    filled = {"time_limit_s": budget.time_limit_s, "dwell_s": dwell_s, "stops_m": stops_m}
    return JourneyResult(
        trip=whole,
        sections=sections,
        windows=windows,
        options={**options.as_dict(), **filled},
        elapsed_s=time.perf_counter() - started,
        found=found,
        warnings=(*_foreign(line.track, timetable), *_shortened(windows, dwell_s), *_warnings(found)),
    )


def _fastest(
    line: Trip, ends_m: Sequence[tuple[float, float]], solved: Callable[[Trip], SectionRuns], clock: Clock
) -> Iterator[SectionRuns]:
    """Sections with their fastest runs, side by side, and a look at the clock before each."""

    def in_time(trip: Trip) -> SectionRuns:
        if clock.elapsed_s > _PATIENCE * clock.limit_s:
            raise BudgetExceededError("journey: the time limit passed before every section had its fastest run")
        return solved(trip)

    trips = [replace(line, origin_m=from_m, destination_m=to_m) for from_m, to_m in ends_m]
    for first in range(0, len(trips), _AT_ONCE):
        yield from side_by_side(in_time, trips[first : first + _AT_ONCE])


def _foreign(track: Track, timetable: Journey | None) -> Iterator[str]:
    """Say where a timetable names another track than the one it is run on, or its places otherwise."""
    if timetable is None:
        return
    if timetable.track not in (None, track.name):
        yield f"journey {timetable.name} belongs to track {timetable.track}, not to {track.name}"
    both = [(place, track.name_at(place.position_m)) for place in timetable.places]
    others = [(place, own) for place, own in both if own and own.casefold() != place.name.casefold()]
    if others:
        place, own = others[0]
        called = f"calls {place.position_m:.9g} m {place.name}, track {track.name} calls it {own}"
        yield f"journey {timetable.name} {called}: is the line to be reversed?"


def _shortened(windows: Windows, dwell_s: float) -> Iterator[str]:
    """Say where the windows of a timetable leave less time to stand than is asked for."""
    for departure, own_s in zip(windows.departures[1:], windows.dwells_s, strict=True):
        if own_s is not None and own_s < dwell_s:
            yield f"stop at {departure.position_m:.6g} m: {own_s:.6g} s of its timetable, not {dwell_s:.6g} s"


def _windows(track: Track, timetable: Journey | None, dwell_s: float) -> Windows:
    """Stops with their windows: those of a timetable, or those of the line, at any time."""
    if timetable is None:
        if len(track.stops_m) < 2:
            raise InputError(f"journey: track {track.name} has no two stops")
        stops = tuple(map(TimingPoint, track.stops_m))
        return Windows(stops[:-1], stops[1:], (dwell_s,) * (len(stops) - 2))
    timetable.require_on(track)
    return windows_of(timetable, dwell_s)


def require_without_windows(timetable: Journey, dwell_s: float, what: str) -> None:
    """Refuse what a `JourneyResult` refuses beside windows before a search that may take minutes.

    Parameters
    ----------
    timetable : Journey
    dwell_s : float
        Standstill at each stop on the way, s.
    what : str
        Done without windows only, such as ``"delays are simulated"``.

    Raises
    ------
    InputError
        When the timetable has a window.
    """
    if not windows_of(timetable, dwell_s).are_open:
        raise beside_windows(what)


def _supplements(sections: Sequence[SectionRuns], options: JourneyOptions) -> tuple[_Floats, float]:
    """Increasing supplements over the fastest runs that are asked for, s, and how well they have to be met, s."""
    fastest_s = sum(section.fastest.duration_s for section in sections)
    if options.at_s or options.at_margin:
        target_s, tolerance_s = asked_targets(fastest_s, options)
        return target_s - fastest_s, tolerance_s
    return fastest_s * np.linspace(0.0, options.max_margin, options.points), met_to_s(fastest_s)


def _timed(journey: TimedJourney, options: JourneyOptions) -> tuple[tuple[PassedRuns, ...], JourneyFront]:
    """With windows arrivals count: on the timetable's clock, or over the earliest one, until the last window closes."""
    fastest_s = sum(section.fastest.duration_s for section in journey.sections)
    tolerance_s = met_to_s(fastest_s)
    earliest_s, latest_s = journey.earliest_s(tolerance_s), journey.windows.arrivals[-1].latest_s
    if options.at_s or options.at_margin:
        arrival_s = np.unique([*options.at_s, *(earliest_s + fastest_s * margin for margin in options.at_margin)])
        if arrival_s[0] < earliest_s - tolerance_s:
            raise InfeasibleError(
                f"journey: it cannot arrive at {arrival_s[0]:.6g} s: the earliest arrival is {earliest_s:.6g} s"
            )
        if arrival_s[-1] > latest_s:
            raise InfeasibleError(
                f"journey: an arrival at {arrival_s[-1]:.6g} s is later than the last window allows, {latest_s:.6g} s"
            )
    else:
        last_s = min(earliest_s + fastest_s * options.max_margin, latest_s)
        arrival_s = np.linspace(earliest_s, last_s, options.points)
    return journey.front(np.maximum(arrival_s, earliest_s), tolerance_s)


def _solver(clock: Clock, max_memory_b: float | None, *, rough: bool = False) -> Callable[[Trip], SectionRuns]:
    """What makes the runs of a trip within the time and the memory that are left: by the front method."""

    def solved(trip: Trip) -> SectionRuns:
        with sensible_numbers(trip, max_memory_b):
            return SectionRuns(trip, fastest_run(trip), SectionMethod(trip, clock, max_memory_b, rough))

    return solved


def _warnings(found: JourneyFront) -> Iterator[str]:
    """Say where the result is less than was asked for."""
    if not found.complete:
        yield "the time limit ended the search: better splits than these may exist"
    yield from found.left
    if found.complete and found.exhausted:
        last_s = found.front.time_s[-1]
        yield f"the front ends with the thriftiest journey, {last_s:.6g} s: running longer saves nothing"
