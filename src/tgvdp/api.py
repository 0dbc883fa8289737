"""The façade: what `import tgvdp` offers. It connects model, line, search and front and holds no algorithm."""

import inspect
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tgvdp.constants import HEURISTICS, METHOD_OPTIONS, METHODS
from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.formats import load_energy_map
from tgvdp.front.certificate import Certificate, certify_front
from tgvdp.front.pareto import ParetoFront
from tgvdp.front.targets import asked_targets, check_targets
from tgvdp.line.fastest import fastest_run
from tgvdp.line.stepped import stepped_time_s
from tgvdp.model.checks import require_number
from tgvdp.model.convention import TTOBENCH, convention_of
from tgvdp.model.energy import BUILT_IN_MAP, ENERGY_KINDS, EnergyMap, EnergyModel
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.physics.profile import Profile, profile_of
from tgvdp.physics.replay import Verdict, replay
from tgvdp.physics.resolved import POWERED, resolve
from tgvdp.search.best_first import DEFAULT_SEGMENTS, DEFAULT_SPEEDS, best_first
from tgvdp.search.budget import DEFAULT_TIME_S, SearchBudget
from tgvdp.search.grid import build_grid
from tgvdp.search.labels import exact_front
from tgvdp.search.optimal import OptimalRuns, optimal_front
from tgvdp.search.paths import GridPaths
from tgvdp.search.refine import refine_front
from tgvdp.units import JOULE_PER_KWH, SECONDS_PER_MINUTE

#: What a search on a grid has left when building the grid took all the time, s.
_LEAST_TIME_S = 1e-3
#: Running times at which a front on a grid is compared with the continuous optimum.
_CERTIFIED_TIMES = 32


@dataclass(frozen=True)
class Fastest:
    """The fastest run, the reference with zero delay: running time in s, energy in J, profile.

    ``stepped_time_s`` is its running time by the explicit steps of a convention that has any, s; None for the others.
    """

    time_s: float
    energy_j: float
    profile: Profile
    stepped_time_s: float | None = None


@dataclass(frozen=True, eq=False)
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
        price_j_per_s = self._found.price_j_per_s[self.front.source]
        return np.asarray(price_j_per_s * (SECONDS_PER_MINUTE / JOULE_PER_KWH))

    def profile(self, index: int) -> Profile:
        """Speed profile of one point of the front."""
        return profile_of(self.trip, *self._found.rows(int(self.front.source[index])))

    def verify(self) -> list[Verdict]:
        """Replay every point of the front by the independent referee."""
        return [replay(self.trip, self.profile(index)) for index in range(len(self.front))]

    def certify(self, time_limit_s: float | None = None) -> Certificate:
        """Bound the least energy of the continuous problem at the running time of every point of the front.

        For the methods on a grid the gap holds the error of the grid: multipliers come from method ``front``.

        Parameters
        ----------
        time_limit_s : float, optional
            Time for it, s; by default as much as the search had. Points that are not reached have no bound.
        """
        budget = SearchBudget(time_limit_s=self.options["time_limit_s"] if time_limit_s is None else time_limit_s)
        clock = budget.start()
        found = self._found
        if not isinstance(found, OptimalRuns):
            first_s, last_s = self.fastest.time_s, max(float(self.front.time_s[-1]), self.fastest.time_s)
            target_s = np.linspace(first_s, first_s + max(last_s - first_s, 1e-3 * first_s), _CERTIFIED_TIMES)
            found = _continuous_front(self.trip, self.fastest.profile, target_s, budget)
        return certify_front(
            self.trip, self.fastest.profile, self.front.time_s, self.front.energy_j, found.price_j_per_s, clock
        )


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
        Of method ``best-first``; see `tgvdp.search.best_first`.
    segment_m, speeds
        Grid of the methods ``exact`` and ``best-first``; see `tgvdp.search.grid`.
    max_labels, time_limit_s
        Budget; see `tgvdp.search.budget`.

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
    model = _energy_model(energy)
    started = time.perf_counter()
    _check_options(method, points, max_margin, paths, heuristic)
    at_s, at_margin = check_targets(method, at_s, at_margin)
    _check_effect(options | {"at_s": at_s, "at_margin": at_margin})
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
        "max_margin": _margin(fastest.time_s, max_margin, max_time_s),
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
    found = _find(trip, fastest, budget, options)
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
        warnings=_warnings(found),
    )


_DEFAULTS = {name: parameter.default for name, parameter in inspect.signature(search).parameters.items()}


def _warnings(found: OptimalRuns | GridPaths) -> tuple[str, ...]:
    """Say where a front is less than was asked for."""
    if not found.complete:
        return ("the search ended by its budget: better paths than these may exist",)
    if not isinstance(found, OptimalRuns):
        return ()
    warnings = []
    if found.missed_s:
        times = ", ".join(f"{time_s:.6g} s" for time_s in found.missed_s)
        warnings.append(
            f"no run takes {times} to the tolerance: running times jump there, and a faster run stands for it"
        )
    if found.exhausted:
        warnings.append(
            f"the front ends with the thriftiest run, {found.duration_s[-1]:.6g} s: running longer saves nothing"
        )
    return tuple(warnings)


def _margin(fastest_s: float, max_margin: float, max_time_s: float | None) -> float:
    """Largest supplement, as a share of the fastest running time."""
    if max_time_s is None:
        return max_margin
    require_number("search", "max_time_s", max_time_s, "s", above=0.0)
    if max_time_s < fastest_s:
        raise InfeasibleError(f"no run takes {max_time_s:.6g} s or less: the fastest one takes {fastest_s:.6g} s")
    return max_time_s / fastest_s - 1.0


def _energy_model(energy: str | EnergyMap) -> EnergyModel:
    """Make the energy model that an argument names."""
    if isinstance(energy, EnergyMap):
        return EnergyModel("map", energy)
    if not isinstance(energy, str):
        raise InputError(f"search: energy must be one of {', '.join(ENERGY_KINDS)} or a map, got {energy!r:.60}")
    if energy in ("wheel", "pantograph"):
        return EnergyModel(energy)
    return EnergyModel("map", load_energy_map(BUILT_IN_MAP if energy == "map" else energy))


def _continuous_front(
    trip: Trip,
    fastest: Profile,
    target_s: NDArray[np.float64],
    budget: SearchBudget,
    tolerance_s: float | None = None,
) -> OptimalRuns:
    """Method ``front``: the costate program, or the generic refinement for what it cannot treat.

    That is an energy by a map, and stretches without current: the program knows the same train in all cells.
    """
    whole = bool((resolve(trip).supply == POWERED).all())
    find = optimal_front if whole and trip.energy.kind != "map" else refine_front
    return find(trip, fastest, target_s, budget, tolerance_s)


def _find(trip: Trip, fastest: Fastest, budget: SearchBudget, options: dict[str, Any]) -> OptimalRuns | GridPaths:
    """Dispatch to the method."""
    if options["method"] == "front":
        if options["at_s"] or options["at_margin"]:
            target_s, tolerance_s = asked_targets(fastest.time_s, options["at_s"], options["at_margin"])
            return _continuous_front(trip, fastest.profile, target_s, budget, tolerance_s)
        target_s = fastest.time_s * np.linspace(1.0, 1.0 + options["max_margin"], options["points"])
        return _continuous_front(trip, fastest.profile, target_s, budget)
    max_time_s = fastest.time_s * (1.0 + options["max_margin"])
    segment_m, speeds = options["segment_m"], options["speeds"]
    exact = options["method"] == "exact"
    if not exact:
        segment_m = trip.distance_m / DEFAULT_SEGMENTS if segment_m is None else segment_m
        speeds = DEFAULT_SPEEDS if speeds is None else speeds
    clock = budget.start()
    grid = build_grid(trip, segment_m, speeds, budget)
    budget = replace(budget, time_limit_s=max(budget.time_limit_s - clock.elapsed_s, _LEAST_TIME_S))
    if exact:
        return exact_front(grid, max_time_s, budget)
    return best_first(
        grid,
        max_time_s,
        budget,
        heuristic=options["heuristic"],
        paths=options["paths"],
        dominance=options["dominance"],
        bounds=options["bounds"],
        reference_time_s=fastest.time_s,
        reference_energy_j=fastest.energy_j,
    )


def _check_options(method: str, points: int, max_margin: float, paths: int, heuristic: str) -> None:
    if method not in METHODS:
        raise InputError(f"search: method must be one of {', '.join(METHODS)}, got {method!r}")
    if heuristic not in HEURISTICS:
        raise InputError(f"search: heuristic must be one of {', '.join(HEURISTICS)}, got {heuristic!r}")
    for name, count, least in (("points", points, 2), ("paths", paths, 0)):
        require_number("search", name, count, name, at_least=least)
        if count != int(count):
            raise InputError(f"search: {name} must be a whole number, got {count:g}")
    require_number("search", "max_margin", max_margin, "of the fastest running time", above=0.0)


def _check_effect(options: dict[str, Any]) -> None:
    """Refuse options that would change nothing; one that is set to its default asks for nothing."""
    method = options["method"]
    changed = {name for name, value in options.items() if value != _DEFAULTS[name]}
    for name in METHOD_OPTIONS:
        if name in changed and method not in METHOD_OPTIONS[name]:
            owners = " and ".join(METHOD_OPTIONS[name])
            raise InputError(f"search: {name} belongs to method {owners}, it has no effect on {method}")
    if changed & {"at_s", "at_margin"} and changed & {"points", "max_margin"}:
        even = " and ".join(sorted(changed & {"points", "max_margin"}))
        raise InputError(f"search: at_s and at_margin say where the points are, so {even} has no effect")
