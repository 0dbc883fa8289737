"""One case of the study: what its journey returns beside the cheapest paths of the grid, and its bounds."""

import time
from typing import Any

import numpy as np

from benchmarks.windows.case import Case
from benchmarks.windows.grid import least_energy_j
from tgvdp.api import JourneyResult
from tgvdp.errors import InfeasibleError

#: Where a journey is refused any path of the grid counts that ends by so much after the last window, s.
_AFTER_S = 200.0


def judged(seed: int, late: bool = False) -> dict[str, Any]:
    """A row of the study."""
    case = Case(seed, late)
    row: dict[str, Any] = {
        "seed": seed,
        "energy": case.energy,
        "km": 1e-3 * case.line.length_m,
        "windows": len(case.windows),
        "refused": "",
        "grid_keeps": None,
    }
    started_s = time.process_time()
    try:
        journey = case.journey()
    except InfeasibleError as error:
        ends_s = max(point.latest_s for point in case.windows.values()) + _AFTER_S
        least_j = least_energy_j(case.grid, _on_grid(case), np.array([ends_s]))
        return row | {"refused": str(error), "grid_keeps": bool(np.isfinite(least_j[0]))}
    return row | {"cpu_s": time.process_time() - started_s} | _beside_grid(case, journey)


def _on_grid(case: Case) -> dict[int, tuple[float, float]]:
    return {station: (point.earliest_s, point.latest_s) for station, point in case.windows.items()}


def _beside_grid(case: Case, journey: JourneyResult) -> dict[str, Any]:
    profiles = [journey.profile(index) for index in range(len(journey.front))]
    missed_s = [
        max(point.earliest_s - passed_s, passed_s - point.latest_s)
        for one in profiles
        for point in case.windows.values()
        for passed_s in (float(np.interp(point.position_m, one.position_m, one.time_s)),)
    ]
    energy_j, bound = journey.front.energy_j, journey.certify()
    least_j = least_energy_j(case.grid, _on_grid(case), journey.front.time_s)
    # The first arrival is the earliest one that was found, which a grid hardly has.
    gap_pct = bound.gap_pct(energy_j)[1:]
    above_pct = [
        100.0 * (own_j - best_j) / abs(best_j)  # where brakes return more than traction takes, both are negative
        for own_j, best_j in zip(energy_j[1:], least_j[1:], strict=True)
        if np.isfinite(best_j)
    ]
    return {
        "points": len(energy_j),
        "missed_s": max(missed_s),
        "not_ok": sum(not verdict.ok for point in journey.verify() for verdict in point),
        "above_grid_pct": float(max(above_pct)) if above_pct else None,
        "median_gap_pct": float(np.nanmedian(gap_pct)) if len(gap_pct) else None,
        "below_bound": bool((energy_j < bound.lower_bound_j).any() or (least_j < bound.lower_bound_j)[1:].any()),
        "warning": "; ".join(journey.warnings),
    }
