"""Stations and speeds of the explicit grid of a trip; see `grid`."""

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from tgvdp.constants import FEASIBILITY_RTOL
from tgvdp.errors import InputError
from tgvdp.line.cells import breaks_of
from tgvdp.model.checks import require_number
from tgvdp.model.trip import Trip
from tgvdp.runs.fastest import fastest_run

#: Segments of a trip, and speeds, unless the caller says otherwise.
DEFAULT_SEGMENTS = 40
DEFAULT_SPEEDS = 40
#: More would be a slip of units rather than a grid.
MOST_STATIONS = 100_000
MOST_SPEEDS = 2_000


def grid_stations(trip: Trip, segment_m: float | None, end_cuts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Anchors at the breaks of the limit that leave room for half a segment, even pieces, and finer ones at stops."""
    if segment_m is None:
        segment_m = trip.distance_m / DEFAULT_SEGMENTS
    require_number("grid", "segment_m", segment_m, "m", above=0.0)
    if trip.distance_m / segment_m > MOST_STATIONS:
        raise InputError(
            f"grid: segment_m must be at least {trip.distance_m / MOST_STATIONS:g} m on a trip of "
            f"{trip.distance_m:g} m, got {segment_m:g} m"
        )
    anchors = [0.0]
    for limit in trip.track.speed_limits:
        x_m = limit.position_m - trip.origin_m
        if x_m - anchors[-1] >= 0.5 * segment_m and trip.distance_m - x_m >= 0.5 * segment_m:
            anchors.append(x_m)
    anchors.append(trip.distance_m)
    pieces = []
    for start_m, end_m in itertools.pairwise(anchors):
        parts = max(1, math.ceil((end_m - start_m) / segment_m * (1.0 - FEASIBILITY_RTOL)))
        pieces.append(start_m + (end_m - start_m) * np.arange(parts) / parts)
    station_m = np.concatenate([*pieces, [trip.distance_m]])
    end_cuts_m = []
    if trip.start_speed_mps == 0.0:
        end_cuts_m.append(station_m[1] * end_cuts)
    if trip.end_speed_mps == 0.0:
        end_cuts_m.append(trip.distance_m - (trip.distance_m - station_m[-2]) * end_cuts)
    station_m = np.unique(np.concatenate([station_m, *end_cuts_m]))
    # A station within rounding of a break of the line is that break: cells need some length.
    break_m = _nearest(breaks_of(trip), station_m)
    return np.where(np.abs(station_m - break_m) <= FEASIBILITY_RTOL * trip.distance_m, break_m, station_m)


def grid_levels(trip: Trip, speeds: int) -> NDArray[np.float64]:
    """Even speeds up to the fastest run's largest, and exactly those of the limits and of the trip's ends."""
    if isinstance(speeds, bool) or not isinstance(speeds, int) or not 1 <= speeds <= MOST_SPEEDS:
        raise InputError(f"grid: speeds must be a whole number from 1 to {MOST_SPEEDS}, got {speeds!r}")
    limits = np.array([min(row.speed_mps, trip.train.max_speed_mps) for row in trip.track.speed_limits])
    top_mps = float(np.max(fastest_run(trip).speed_mps))
    limits = limits[limits <= top_mps * (1.0 + FEASIBILITY_RTOL)]
    special = np.unique([*limits, trip.start_speed_mps, trip.end_speed_mps])
    even = top_mps * np.arange(1, speeds + 1) / speeds
    apart = np.abs(even - _nearest(special, even)) > FEASIBILITY_RTOL * top_mps
    return np.union1d(special, even[apart])


def _nearest(points: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """For each value the nearest of some points, which increase."""
    after = np.minimum(np.searchsorted(points, values), len(points) - 1)
    before = np.maximum(after - 1, 0)
    return np.where(values - points[before] <= points[after] - values, points[before], points[after])
