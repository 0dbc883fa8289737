"""Cut a trip into cells in which gradient, speed limit and drag are constant."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.constants import GRAVITY_MPS2
from tgvdp.model.trip import Trip

#: Breaks nearer to each other than this share of the distance are one: no acceleration can be told on less.
SAME_POSITION = 1e-9


class Cells(NamedTuple):
    """K cells between K + 1 stations, SI, float64; positions count from the trip's origin.

    Attributes
    ----------
    station_m : (K + 1,)
        Positions of the stations, from 0 to the trip's distance.
    length_m : (K,)
        Lengths of the cells.
    grade_n : (K,)
        Grade force in N, positive uphill.
    air : (K,)
        Coefficient of v² in the running resistance, N/(m/s)².
    limit_w : (K,)
        Squared speed limit (line and train), m²/s²; may be infinite.
    """

    station_m: NDArray[np.float64]
    length_m: NDArray[np.float64]
    grade_n: NDArray[np.float64]
    air: NDArray[np.float64]
    limit_w: NDArray[np.float64]


def _step_values(
    positions_m: NDArray[np.float64], values: NDArray[np.float64], at_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Values of a right-continuous step function."""
    return values[np.searchsorted(positions_m, at_m, side="right") - 1]


def breaks_of(trip: Trip) -> NDArray[np.float64]:
    """Positions at which limit or gradient may change, both ends included, from the origin, m, float64."""
    rows = (*trip.track.speed_limits, *trip.track.gradients)
    inside = {row[0] - trip.origin_m for row in rows if trip.origin_m < row[0] < trip.destination_m}
    breaks_m = np.array(sorted({0.0, *inside}))
    gap_m = SAME_POSITION * trip.distance_m
    apart = np.diff(breaks_m, prepend=-np.inf) > gap_m
    return np.append(breaks_m[apart & (breaks_m < trip.distance_m - gap_m)], trip.distance_m)


def cells_of(trip: Trip, stations_m: NDArray[np.float64] | None = None) -> Cells:
    """Cells between the trip's breaks, cut further at any given stations.

    Parameters
    ----------
    trip : Trip
    stations_m : (n,) float64, optional
        More stations, from the origin, m. Breaks are always stations, so that each cell is uniform.

    Returns
    -------
    Cells
    """
    station_m = breaks_of(trip)
    if stations_m is not None:
        station_m = np.union1d(station_m, stations_m)
    middle_m = trip.origin_m + 0.5 * (station_m[:-1] + station_m[1:])
    limits = np.array(trip.track.speed_limits, dtype=np.float64)
    speed = np.minimum(_step_values(limits[:, 0], limits[:, 1], middle_m), trip.train.max_speed_mps)
    permil = np.zeros_like(middle_m)
    if trip.track.gradients:
        gradients = np.array(trip.track.gradients, dtype=np.float64)
        permil = _step_values(gradients[:, 0], gradients[:, 1], middle_m)
    return Cells(
        station_m,
        np.diff(station_m),
        trip.train.mass_kg * GRAVITY_MPS2 / 1000.0 * permil,
        np.full_like(middle_m, trip.train.davis_c_n_per_mps2),
        speed * speed,
    )
