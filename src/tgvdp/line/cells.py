"""Cut a trip into cells in which resistance, drag, speed limit and current are constant (see `line.resolved`)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.resolved import resolve
from tgvdp.model.track import LOWERED
from tgvdp.model.trip import Trip


class Cells(NamedTuple):
    """K cells between K + 1 stations, SI, float64 where not said otherwise; positions count from the trip's origin.

    Attributes
    ----------
    station_m : (K + 1,)
        Positions of the stations, from 0 to the trip's distance.
    length_m : (K,)
        Lengths of the cells.
    grade_n : (K,)
        Force of gradients and curves in N, positive uphill.
    air : (K,)
        Coefficient of v² in the running resistance, N/(m/s)².
    limit_w : (K,)
        Squared speed limit (line and train), m²/s²; may be infinite.
    supply : (K,) int8
        Current: one of POWERED, NEUTRAL, LOWERED of `line.resolved`.
    saved_w : (K,)
        By how much a second is cheaper there than elsewhere, W: what auxiliaries do not draw while the pantograph is
        lowered, and the credits of timing points.
    """

    station_m: NDArray[np.float64]
    length_m: NDArray[np.float64]
    grade_n: NDArray[np.float64]
    air: NDArray[np.float64]
    limit_w: NDArray[np.float64]
    supply: NDArray[np.int8]
    saved_w: NDArray[np.float64]


def breaks_of(trip: Trip) -> NDArray[np.float64]:
    """Positions at which limit, resistance or current may change, both ends included, from the origin, m, float64."""
    return resolve(trip).break_m


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
    return cells_between(trip, breaks_of(trip) if stations_m is None else np.union1d(breaks_of(trip), stations_m))


def cells_between(trip: Trip, station_m: NDArray[np.float64]) -> Cells:
    """Cells between stations, (K + 1,) from the origin, m, that rise and have all breaks of the trip among them."""
    line = resolve(trip)
    step = line.step_at(0.5 * (station_m[:-1] + station_m[1:]))
    supply = line.supply[step]
    saved_w = np.where(supply == LOWERED, trip.energy.auxiliary_w(trip.train), 0.0)
    for until_m, credit_w in trip.credits:
        saved_w[station_m[1:] <= until_m - trip.origin_m] += credit_w
    length_m = station_m[1:] - station_m[:-1]
    return Cells(station_m, length_m, line.grade_n[step], line.air[step], line.limit_mps[step] ** 2, supply, saved_w)


def halved(cells: Cells) -> Cells:
    """Cells that are each cut in two, as of `cut`."""
    station_m = cells.station_m.repeat(2)[:-1]
    station_m[1::2] += 0.5 * cells.length_m
    length_m = station_m[1:] - station_m[:-1]
    return Cells._make((station_m, length_m, *(column.repeat(2) for column in cells[2:])))


def cut(cells: Cells, parts: NDArray[np.int64]) -> Cells:
    """Cells that are each cut into so many parts, (K,), of the same length."""
    share = (np.arange(parts.sum()) - (np.cumsum(parts) - parts).repeat(parts)) / parts.repeat(parts)
    start_m = cells.station_m[:-1].repeat(parts) + share * cells.length_m.repeat(parts)
    station_m = np.append(start_m, cells.station_m[-1])
    length_m = station_m[1:] - station_m[:-1]
    return Cells._make((station_m, length_m, *(column.repeat(parts) for column in cells[2:])))
