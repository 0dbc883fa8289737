"""Dispatch to the methods, and what a search of each is told about its result."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tgvdp.api.targets import asked_targets
from tgvdp.line.resolved import resolve
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate.front import OptimalRuns, optimal_front
from tgvdp.methods.extremal.front import extremal_front
from tgvdp.methods.grid.best_first import DEFAULT_SEGMENTS, DEFAULT_SPEEDS, best_first
from tgvdp.methods.grid.exact import exact_front
from tgvdp.methods.grid.grid import build_grid
from tgvdp.methods.grid.paths import GridPaths
from tgvdp.methods.refine.extremals import Extremals
from tgvdp.methods.refine.front import refine_front
from tgvdp.model.track import POWERED
from tgvdp.model.trip import Trip
from tgvdp.options.search import SearchOptions
from tgvdp.runs.profile import Profile

#: Running times that a warning spells out.
_SHOWN = 5
#: A run that costs this share more than a faster one is worth a warning; less is what points are known to.
_DEARER = 1e-4


@dataclass(frozen=True)
class Fastest:
    """The fastest run, the reference with zero delay: running time in s, energy in J, profile.

    ``stepped_time_s`` is its running time by the explicit steps of a convention that has any, s; None for the others.
    """

    time_s: float
    energy_j: float
    profile: Profile
    stepped_time_s: float | None = None


def continuous_front(
    trip: Trip,
    fastest: Profile,
    target_s: NDArray[np.float64],
    budget: SearchBudget,
    tolerance_s: float | None = None,
    clean: bool = False,
    min_phase_s: float = 0.0,
    rough: bool = False,
    known: list[Extremals] | None = None,
) -> OptimalRuns:
    """Method ``front``: the costate program, or for an energy by a map the generic refinement.

    With ``clean`` its points become extremals of few commands (`methods.extremal`), which takes much longer, where the
    line has current throughout. Phases shorter than ``min_phase_s`` are left out of the costate program's runs; a
    ``rough`` one takes its cells as they come. By a map, calls for other times of a trip hand on what is ``known``.
    """
    if trip.energy.kind == "map":
        return refine_front(trip, fastest, target_s, budget, tolerance_s, known)
    if clean and (resolve(trip).supply == POWERED).all():
        return extremal_front(trip, fastest, target_s, budget, tolerance_s, min_phase_s)
    return optimal_front(trip, fastest, target_s, budget, tolerance_s, min_phase_s, rough=rough)


def find(
    trip: Trip, fastest: Fastest, budget: SearchBudget, options: SearchOptions, max_margin: float
) -> OptimalRuns | GridPaths:
    """Dispatch to the method; the margin is that of the options, or what their longest time leaves."""
    if options.method == "front":
        driven = options.clean, options.min_phase_s
        if options.at_s or options.at_margin:
            target_s, tolerance_s = asked_targets(fastest.time_s, options)
            return continuous_front(trip, fastest.profile, target_s, budget, tolerance_s, *driven)
        target_s = fastest.time_s * np.linspace(1.0, 1.0 + max_margin, options.points)
        return continuous_front(trip, fastest.profile, target_s, budget, None, *driven)
    max_time_s = fastest.time_s * (1.0 + max_margin)
    segment_m, speeds = options.segment_m, options.speeds
    exact = options.method == "exact"
    if not exact:
        segment_m = trip.distance_m / DEFAULT_SEGMENTS if segment_m is None else segment_m
        speeds = DEFAULT_SPEEDS if speeds is None else speeds
    clock = budget.start()
    grid = build_grid(trip, segment_m, speeds, budget)
    budget = budget.after(clock)
    if exact:
        return exact_front(grid, max_time_s, budget)
    return best_first(
        grid,
        max_time_s,
        budget,
        heuristic=options.heuristic,
        paths=options.paths,
        dominance=options.dominance,
        bounds=options.bounds,
        reference_time_s=fastest.time_s,
        reference_energy_j=fastest.energy_j,
    )


def _told(times_s: Sequence[float]) -> str:
    """The first of some running times, and how many more there are."""
    told = ", ".join(f"{time_s:.6g} s" for time_s in times_s[:_SHOWN])
    return told if len(times_s) <= _SHOWN else f"{told} and {len(times_s) - _SHOWN} more times"


def warnings_of(found: OptimalRuns | GridPaths) -> tuple[str, ...]:
    """Say where a front is less than was asked for."""
    if not found.complete:
        what = found.ended_by if isinstance(found, GridPaths) else "the time limit"
        return (f"{what} ended the search: better paths than these may exist",)
    if not isinstance(found, OptimalRuns):
        return ()
    warnings = []
    if found.missed_s:
        warnings.append(
            f"no run was found that takes {_told(found.missed_s)}: running times jump there, and a faster run stands"
            " for it"
        )
    cheapest_j = np.minimum.accumulate(found.energy_j)
    is_dearer = found.energy_j[1:] > cheapest_j[:-1] + _DEARER * np.abs(cheapest_j[:-1])
    if is_dearer.any():
        warnings.append(
            f"runs that were found for {_told(found.duration_s[1:][is_dearer].tolist())} cost more than a faster one,"
            " which stands for them: the front may be too dear beside them"
        )
    if found.exhausted:
        warnings.append(
            f"the front ends with the thriftiest run, {found.duration_s[-1]:.6g} s: running longer saves nothing"
        )
    return tuple(warnings)
