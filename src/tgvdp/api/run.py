"""The search itself: it connects model, line, search and front and holds no algorithm."""

import inspect
import time
from collections.abc import Sequence

from tgvdp.api.methods import Fastest, find, warnings_of
from tgvdp.api.options import check_effect, check_options, energy_model, margin_of
from tgvdp.api.result import SearchResult
from tgvdp.api.targets import check_targets
from tgvdp.errors import BudgetExceededError
from tgvdp.methods.budget import DEFAULT_TIME_S, SearchBudget
from tgvdp.model.convention import TTOBENCH, convention_of
from tgvdp.model.energy import EnergyMap
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.pareto import ParetoFront
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.stepped import stepped_time_s


def search(
    train: Train,
    track: Track,
    *,
    origin_m: float = 0.0,
    destination_m: float | None = None,
    start_speed_mps: float = 0.0,
    end_speed_mps: float = 0.0,
    energy: str | EnergyMap = "wheel",
    convention: str = TTOBENCH.name,
    mass_model: str | None = None,
    limits: str | None = None,
    curves: str | None = None,
    tunnels: bool | None = None,
    method: str = "front",
    points: int = 60,
    max_margin: float = 0.25,
    max_time_s: float | None = None,
    at_s: Sequence[float] = (),
    at_margin: Sequence[float] = (),
    paths: int = 100,
    heuristic: str = "ratio",
    segment_m: float | None = None,
    speeds: int | None = None,
    max_labels: int | None = None,
    time_limit_s: float | None = None,
    dominance: bool = True,
    bounds: bool = True,
) -> SearchResult:
    """Find the Pareto front of delay against energy of one run.

    Parameters
    ----------
    train : Train
    track : Track
    origin_m, destination_m : float
        Positions on the track, m; by default its whole length. Stops in between are passed.
    start_speed_mps, end_speed_mps : float
        Speeds at the two ends, m/s.
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
    method : {"front", "exact", "best-first"}
        ``front`` aims at the continuous optimum, ``exact`` returns all Pareto-optimal paths of an explicit grid,
        ``best-first`` is the graph search of the seed on that grid.
    points : int
        Number of points of the front (method ``front``), evenly in time, the fastest run included.
    max_margin : float
        Largest running-time supplement, as a share of the fastest running time.
    max_time_s : float, optional
        Longest running time, s, in place of `max_margin`: what a timetable allows.
    at_s, at_margin : sequence of float
        Running times in s, and supplements as shares of the fastest running time, at which to find the points instead
        (method ``front``): neither `points` nor `max_margin` nor `max_time_s` matters then. Met to 0.05 s.
    paths, heuristic, dominance, bounds
        Of method ``best-first``; see `tgvdp.methods.grid.best_first`.
    segment_m, speeds
        Grid of the methods ``exact`` and ``best-first``; see `tgvdp.methods.grid.grid`.
    max_labels, time_limit_s
        Budget; see `tgvdp.methods.budget`.

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
    options = {key: value for key, value in locals().items() if key not in ("train", "track")}
    model = energy_model(energy)
    started = time.perf_counter()
    check_options(method, points, max_margin, paths, heuristic)
    at_s, at_margin = check_targets(method, at_s, at_margin)
    check_effect(options | {"at_s": at_s, "at_margin": at_margin}, _DEFAULTS)
    budget = SearchBudget(
        max_labels=max_labels,
        time_limit_s=DEFAULT_TIME_S if time_limit_s is None else time_limit_s,
    )
    trip = Trip(
        train=train,
        track=track,
        origin_m=origin_m,
        destination_m=track.length_m if destination_m is None else destination_m,
        start_speed_mps=start_speed_mps,
        end_speed_mps=end_speed_mps,
        energy=model,
        convention=convention_of(convention, mass_model=mass_model, limits=limits, curves=curves, tunnels=tunnels),
    )
    profile = fastest_run(trip)
    step_m = trip.convention.step_m
    stepped_s = None if step_m is None else stepped_time_s(trip, step_m)
    fastest = Fastest(profile.duration_s, profile.total_energy_j, profile, stepped_s)
    options |= {
        "max_margin": margin_of(fastest.time_s, max_margin, max_time_s),
        "destination_m": trip.destination_m,
        "energy": model.kind if model.map is None else model.map.name,
        "mass_model": trip.convention.mass_model,
        "limits": trip.convention.limits,
        "curves": trip.convention.curves,
        "tunnels": trip.convention.tunnels,
        "time_limit_s": budget.time_limit_s,
        "at_s": at_s,
        "at_margin": at_margin,
    }
    found = find(trip, fastest, budget, options)
    if len(found.duration_s) == 0:
        raise BudgetExceededError("the budget ended before the first path was found: raise the label or time limit")
    return SearchResult(
        trip=trip,
        method=method,
        fastest=fastest,
        front=ParetoFront.of(found.duration_s, found.energy_j),
        counters=found.counters,
        complete=found.complete,
        options=options,
        elapsed_s=time.perf_counter() - started,
        _found=found,
        warnings=warnings_of(found),
    )


_DEFAULTS = {name: parameter.default for name, parameter in inspect.signature(search).parameters.items()}
