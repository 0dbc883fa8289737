"""Stations of the front method: every break of the line, the switch points of the fastest run, and graded cells.

The cell size is ``h`` along the line and falls linearly to ``h / 10`` at the two ends, where the speed changes fast.
"""

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.cells import breaks_of
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile

_END_SHARE = 0.1
_GRADING = 0.2
#: Stations closer than this share of the distance are one.
_SAME = 1e-7


class _Grading:
    """Cell count C(x) = ∫ dx / size(x) from an end of the line, and its inverse, in closed form."""

    def __init__(self, distance_m: float, cell_m: float) -> None:
        self.half_m = 0.5 * distance_m
        self.end_m = _END_SHARE * cell_m
        self.cell_m = cell_m
        self.graded_m = min((cell_m - self.end_m) / _GRADING, self.half_m)
        self.graded_count = float(np.log1p(_GRADING * self.graded_m / self.end_m)) / _GRADING
        self.half_count = self.graded_count + (self.half_m - self.graded_m) / cell_m

    def count(self, x_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Cells between the start and x."""
        from_end = np.minimum(x_m, 2.0 * self.half_m - x_m)
        graded = np.log1p(_GRADING * np.minimum(from_end, self.graded_m) / self.end_m) / _GRADING
        count = graded + np.maximum(from_end - self.graded_m, 0.0) / self.cell_m
        return np.where(x_m <= self.half_m, count, 2.0 * self.half_count - count)

    def position(self, count: NDArray[np.float64]) -> NDArray[np.float64]:
        """Inverse of `count`."""
        from_end = np.minimum(count, 2.0 * self.half_count - count)
        graded = self.end_m * np.expm1(_GRADING * np.minimum(from_end, self.graded_count)) / _GRADING
        x_m = graded + np.maximum(from_end - self.graded_count, 0.0) * self.cell_m
        return np.where(count <= self.half_count, x_m, 2.0 * self.half_m - x_m)


def switch_points(profile: Profile) -> NDArray[np.float64]:
    """Positions from the origin at which the regime of a profile changes, m."""
    changes = np.flatnonzero(np.diff(profile.regime)) + 1
    return np.asarray(profile.position_m[changes] - profile.position_m[0])


def graded_stations(trip: Trip, fastest: Profile, cell_m: float) -> NDArray[np.float64]:
    """Stations from the origin for cells of about ``cell_m``.

    Parameters
    ----------
    trip : Trip
    fastest : Profile
        The fastest run; its switch points become stations.
    cell_m : float
        Cell size away from the ends, m.

    Returns
    -------
    (n,) float64
        Increasing, from 0 to the trip's distance, m.
    """
    breaks_m = breaks_of(trip)
    soft_m = switch_points(fastest)
    gap_m = _SAME * trip.distance_m
    near = np.searchsorted(breaks_m, soft_m).clip(1, len(breaks_m) - 1)
    apart = np.minimum(soft_m - breaks_m[near - 1], breaks_m[near] - soft_m) > gap_m
    soft_m = soft_m[apart & (np.diff(soft_m, prepend=-np.inf) > gap_m)]
    fixed_m = np.sort(np.concatenate((breaks_m, soft_m)))
    grading = _Grading(trip.distance_m, cell_m)
    at = grading.count(fixed_m)
    counts = np.maximum(np.ceil(np.diff(at) - 1e-9), 1.0).astype(np.int64)
    inner = counts - 1
    start = np.repeat(at[:-1], inner)
    step = np.repeat(np.diff(at) / counts, inner)
    which = np.arange(1, len(start) + 1) - np.repeat(np.cumsum(inner) - inner, inner)
    inner_m = grading.position(start + which * step)
    station_m = np.sort(np.concatenate((fixed_m, inner_m)))
    return station_m[np.diff(station_m, prepend=-np.inf) > 0.0]
