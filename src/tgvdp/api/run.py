"""The search itself: it connects model, line, search and front and holds no algorithm."""

import time
from collections.abc import Sequence

from tgvdp.api.beside import compiling_beside
from tgvdp.api.budget import budget_of
from tgvdp.api.methods import Fastest, find, warnings_of
from tgvdp.api.result import SearchResult
from tgvdp.api.sense import sensible_numbers
from tgvdp.api.targets import margin_of
from tgvdp.api.trip import trip_of
from tgvdp.errors import BudgetExceededError
from tgvdp.formats.sources import Source
from tgvdp.model.energy import EnergyMap
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.options.search import SearchOptions
from tgvdp.pareto import ParetoFront
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.stepped import stepped_time_s


def search(
    train: Train | Source,
    track: Track | Source,
    *,
    origin_m: float = 0.0,
    destination_m: float | None = None,
    start_speed_mps: float = 0.0,
    end_speed_mps: float = 0.0,
    reverse: bool = False,
    speed_restrictions: Sequence[tuple[float, float, float]] = (),
    energy: str | EnergyMap = "wheel",
    convention: str = "ttobench",
    mass_model: str | None = None,
    limits: str | None = None,
    curves: str | None = None,
    tunnels: bool | None = None,
    wind_mps: float = 0.0,
    method: str = "front",
    points: int = 60,
    max_margin: float = 0.25,
    max_time_s: float | None = None,
    at_s: Sequence[float] = (),
    at_margin: Sequence[float] = (),
    clean: bool = False,
    min_phase_s: float = 1.0,
    paths: int = 100,
    heuristic: str = "ratio",
    segment_m: float | None = None,
    speeds: int | None = None,
    max_labels: int | None = None,
    time_limit_s: float | None = None,
    max_memory_b: float | None = None,
    dominance: bool = True,
    bounds: bool = True,
) -> SearchResult:
    """Find the Pareto front of delay against energy of one run.

    Parameters
    ----------
    train : Train or str or path
        A train, a name of the catalog, or a file that holds one.
    track : Track or str or path
        A line, likewise.
    origin_m, destination_m : float
        Positions on the track, m; by default its whole length. Stops in between are passed, see `journey`.
    start_speed_mps, end_speed_mps : float
        Speeds at the two ends, m/s.
    reverse : bool
        The line in the other direction: gradients change their sign, everything is mirrored, and all positions count
        from what was its end.
    speed_restrictions : sequence of (from_m, to_m, speed_mps)
        Where the speed limit is lowered, in the direction of the run.
    energy : {"wheel", "pantograph", "map"} or str or EnergyMap
        What is minimised, and what all energies of the result count: traction work at the wheel; what is drawn from the
        line by the train's efficiencies, its regeneration and its auxiliary power; or the same by a map: one of the
        catalog ("map" is short for "alstom-map"), a file, or an `EnergyMap`.
    convention : {"ttobench", "osrd", "trainruns"}
        Whose understanding of the line is followed: gravity, line resistance, where speed limits hold.
    mass_model : {"point", "strip"}, optional
        Gradients, curves and tunnels act at the train's head, or averaged over its length; default: the convention's.
    limits : {"head", "tail"}, optional
        A rise of the speed limit counts from where the head, or the tail, has passed it.
    curves : {"none", "800/R", "roeckl"}, optional
        Formula of curve resistance.
    tunnels : bool, optional
        Whether the train's additional drag in tunnels counts.
    wind_mps : float
        Head wind, negative for a tail wind, m/s: it adds to the train's speed in the quadratic term of the running
        resistance; see `tgvdp.model.variants`.
    method : {"front", "exact", "best-first"}
        ``front`` aims at the continuous optimum, ``exact`` returns all Pareto-optimal paths of an explicit grid,
        ``best-first`` searches that grid by a queue that a heuristic orders, and stops after `paths` paths.
    points : int
        Number of points of the front (method ``front``), evenly in time, the fastest run included.
    max_margin : float
        Largest running-time supplement, as a share of the fastest running time.
    max_time_s : float, optional
        Longest running time, s, in place of `max_margin`: what a timetable allows.
    at_s, at_margin : sequence of float
        Running times in s, and supplements as shares of the fastest running time, at which to find the points instead
        (method ``front``): neither `points` nor `max_margin` nor `max_time_s` matters then. Met to 0.05 s.
    clean : bool
        Whether each point is rebuilt as an extremal of few commands, as a driver would run (method ``front``; energies
        by a map and neutral sections keep their runs). It takes ten times as long; docs/extremals.md.
    min_phase_s : float
        Phases of driving that are shorter, s, are left out where that costs no more than 5·10⁻⁵ of the energy; 0 leaves
        all (method ``front``; energies by a map keep theirs). See docs/phases.md.
    paths, heuristic, dominance, bounds
        Of method ``best-first``; see `tgvdp.methods.grid.best_first`.
    segment_m, speeds
        Grid of the methods ``exact`` and ``best-first``; see `tgvdp.methods.grid.grid`.
    max_labels, time_limit_s
        Budget; see `tgvdp.methods.budget`. The time limit is 60 s by default, infinite means none.
    max_memory_b : float, optional
        Memory of the process at most, B; by default half of what the machine or its container has.

    Returns
    -------
    SearchResult
        With ``complete`` False when a budget ended the search.

    Raises
    ------
    InputError
        When an option is out of range, or set to other than its default although the method does not have it.
    InfeasibleError
        When no run obeys all limits, or none is as fast as ``at_s`` or ``max_time_s`` asks.
    BudgetExceededError
        When a budget ended before there was anything to return.
    """
    options = SearchOptions(
        origin_m=origin_m,
        destination_m=destination_m,
        start_speed_mps=start_speed_mps,
        end_speed_mps=end_speed_mps,
        reverse=reverse,
        speed_restrictions=speed_restrictions,
        energy=energy,
        convention=convention,
        mass_model=mass_model,
        limits=limits,
        curves=curves,
        tunnels=tunnels,
        wind_mps=wind_mps,
        method=method,
        points=points,
        max_margin=max_margin,
        max_time_s=max_time_s,
        at_s=at_s,
        at_margin=at_margin,
        clean=clean,
        min_phase_s=min_phase_s,
        paths=paths,
        heuristic=heuristic,
        segment_m=segment_m,
        speeds=speeds,
        max_labels=max_labels,
        time_limit_s=time_limit_s,
        max_memory_b=max_memory_b,
        dominance=dominance,
        bounds=bounds,
    )
    return run_search(train, track, options)


def run_search(train: Train | Source, track: Track | Source, options: SearchOptions) -> SearchResult:
    """Do what `search` is asked for."""
    started = time.perf_counter()
    given = options.as_dict()
    budget = budget_of(given)
    trip, clock = trip_of(train, track, options), budget.start()
    with sensible_numbers(trip, options.max_memory_b), compiling_beside(options):
        profile = fastest_run(trip)
        step_m = trip.convention.step_m
        stepped_s = None if step_m is None else stepped_time_s(trip, step_m, expired=lambda: clock.expired)
        fastest = Fastest(profile.duration_s, profile.total_energy_j, profile, stepped_s)
        max_margin = margin_of(fastest.time_s, options.max_margin, options.max_time_s)
        found = find(trip, fastest, budget.after(clock), options, max_margin)
    if len(found.duration_s) == 0:
        raise BudgetExceededError("the budget ended before the first path was found: raise the label or time limit")
    return SearchResult(
        trip=trip,
        method=options.method,
        fastest=fastest,
        front=ParetoFront.of(found.duration_s, found.energy_j),
        counters=found.counters,
        complete=found.complete,
        options=given
        | {
            "max_margin": max_margin,
            "destination_m": trip.destination_m,
            "energy": trip.energy.kind if trip.energy.map is None else trip.energy.map.name,
            "mass_model": trip.convention.mass_model,
            "limits": trip.convention.limits,
            "curves": trip.convention.curves,
            "tunnels": trip.convention.tunnels,
            "time_limit_s": budget.time_limit_s,
        },
        elapsed_s=time.perf_counter() - started,
        _found=found,
        warnings=warnings_of(found),
    )
