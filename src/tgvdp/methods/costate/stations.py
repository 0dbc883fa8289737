"""Stations of the front method: every break of the line, the switch points of the fastest run, and graded cells.

The cell size is ``h`` along the line and falls linearly to ``h / 10`` at the two ends, where the speed changes fast.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import entry, kernel, leaf, part
from tgvdp.line.cells import breaks_of, cells_of
from tgvdp.methods.costate.brake_jumps import AT_RISE, rise_above
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import energy_tables
from tgvdp.physics.forces import effort_at, kernel_train, resistance_at
from tgvdp.runs.profile import Profile

_END_SHARE = 0.1
_GRADING = 0.2
#: How often the last cell is halved, each time next to the end, where braking returns energy.
_END_HALVINGS = 3
#: So many cells more are at the two ends together than there would be of the usual size.
_MORE_AT_ENDS = 2.0 * math.log(1.0 / _END_SHARE) / _GRADING
#: Stations closer than this share of the distance are one; counts of cells by which a cell is not cut.
_SAME = 1e-7
_ROUNDING = 1e-9
#: Efforts at the ends of a row are taken this share of it inside: they may jump there.
_INSIDE = 1e-6
_HALVINGS = 40


def switch_points(profile: Profile) -> NDArray[np.float64]:
    """Positions from the origin at which the regime of a profile changes, m."""
    changes = np.flatnonzero(profile.regime[1:] != profile.regime[:-1]) + 1
    return np.asarray(profile.position_m[changes] - profile.position_m[0])


@part
def _lacks(train, grade_n, air, w0, w1, d, share):
    """Braking effort that the dynamic brake lacks at a share of a row, N; negative where it has more."""
    v = math.sqrt(w0 + share * (w1 - w0))
    effort = 0.5 * train.inertia_kg * (w1 - w0) / d + resistance_at(train, air, v) + grade_n
    return -effort - effort_at(train.braking, v)


@kernel
def friction_points(train, cells, x, w, at):
    """Where friction begins or ends to help the dynamic brake along a run, and where that rises.

    Parameters
    ----------
    train : KernelTrain
    cells : Cells
    x, w : (n,) float64
        Rows: positions from the origin, m, and squared speeds, m²/s².
    at : (3·n,) float64, modified in place
        Such positions, m.

    Returns
    -------
    int
        How many they are.
    """
    count = 0
    k = 0
    before = 0.0
    for i in range(x.shape[0] - 1):
        d = x[i + 1] - x[i]
        while k + 1 < cells.length_m.shape[0] and cells.station_m[k + 1] <= x[i] + 0.5 * d:
            k += 1
        grade_n = cells.grade_n[k]
        air = cells.air[k]
        first = _lacks(train, grade_n, air, w[i], w[i + 1], d, _INSIDE)
        last = _lacks(train, grade_n, air, w[i], w[i + 1], d, 1.0 - _INSIDE)
        if before * first < 0.0:
            at[count] = x[i]
            count += 1
        if first * last < 0.0:
            lo = _INSIDE
            hi = 1.0 - _INSIDE
            for _ in range(_HALVINGS):
                middle = 0.5 * (lo + hi)
                if _lacks(train, grade_n, air, w[i], w[i + 1], d, middle) * first > 0.0:
                    lo = middle
                else:
                    hi = middle
            at[count] = x[i] + lo * d
            count += 1
        slower, faster = min(w[i], w[i + 1]), max(w[i], w[i + 1])
        rise_w = rise_above(train, slower * (1.0 - AT_RISE))  # one at most: under brakes rows end there
        if abs(w[i] - rise_w) <= AT_RISE * w[i]:
            at[count] = x[i]
            count += 1
        elif slower < rise_w < faster * (1.0 - AT_RISE):
            at[count] = x[i] + (rise_w - w[i]) / (w[i + 1] - w[i]) * d
            count += 1
        before = last
    return count


def _braking_points(trip: Trip, fastest: Profile, cell_m: float) -> NDArray[np.float64]:
    """Where friction begins or ends to help the dynamic brake along the fastest run, or that rises; next to its end.

    From the origin, m. The costate below the braking curve is another one there. It matters only where the dynamic
    brake returns energy. In the last cell that one alone stops the train, while all brakes are best at last: what this
    takes longer falls but with the root of the cell's length.
    """
    train = kernel_train(trip.train)
    returns = energy_tables(trip.train, trip.energy).regeneration > 0.0 and train.braking[:, 1:].any()
    if not returns or (train.friction_n == 0.0 and not len(train.rates)):
        return np.empty(0)
    at_m = np.empty(3 * len(fastest.position_m))
    x_m = fastest.position_m - fastest.position_m[0]
    count = friction_points(train, cells_of(trip), x_m, fastest.speed_mps**2, at_m)
    left_m = _END_SHARE * cell_m * 0.5 ** np.arange(1, _END_HALVINGS + 1)
    return np.concatenate((at_m[:count], trip.distance_m - left_m))


class _Grading(NamedTuple):
    """Sizes of cells, m: half the line, the size away from its ends, that at them, and how far from them it grows."""

    half_m: float
    cell_m: float
    end_m: float
    graded_m: float


@leaf
def _count_from_end(grading, x):
    """Cells between an end of the line and x on that half of it: C = ∫ dx / size(x), in closed form."""
    graded = math.log1p(_GRADING * min(x, grading.graded_m) / grading.end_m) / _GRADING
    return graded + max(x - grading.graded_m, 0.0) / grading.cell_m


@leaf
def _count(grading, x):
    """Cells between the start of the line and x."""
    count = _count_from_end(grading, min(x, 2.0 * grading.half_m - x))
    return count if x <= grading.half_m else 2.0 * _count_from_end(grading, grading.half_m) - count


@leaf
def _position(grading, count):
    """Inverse of `_count`."""
    half = _count_from_end(grading, grading.half_m)
    all_graded = _count_from_end(grading, grading.graded_m)
    from_end = min(count, 2.0 * half - count)
    x = grading.end_m * math.expm1(_GRADING * min(from_end, all_graded)) / _GRADING
    x += max(from_end - all_graded, 0.0) * grading.cell_m
    return x if count <= half else 2.0 * grading.half_m - x


@part
def _fill_to(grading, x, station_m, n):
    """Append graded stations up to a position, and that; returns their number."""
    first = _count(grading, station_m[n - 1])
    span = _count(grading, x) - first
    parts = max(math.ceil(span - _ROUNDING), 1)
    for i in range(1, parts):
        at = _position(grading, first + i * (span / parts))
        if station_m[n - 1] < at < x:
            station_m[n] = at
            n += 1
    station_m[n] = x
    return n + 1


@entry
def fill_stations(break_m, soft_m, cell_m, station_m):
    """Fill in stations: all breaks, positions that are apart from these and from each other, and graded ones between.

    Parameters
    ----------
    break_m, soft_m : (m,), (l,) float64
        In order, from the origin, m.
    cell_m : float
        Cell size away from the ends, m.
    station_m : (size,) float64, modified in place
        Room for them.

    Returns
    -------
    int
        How many there are.
    """
    half_m = 0.5 * break_m[-1]
    end_m = _END_SHARE * cell_m
    grading = _Grading(half_m, cell_m, end_m, min((cell_m - end_m) / _GRADING, half_m))
    gap_m = _SAME * break_m[-1]
    station_m[0] = 0.0
    n = 1
    k = 0
    soft = -math.inf
    for i in range(1, break_m.shape[0]):
        while k < soft_m.shape[0] and soft_m[k] < break_m[i]:
            before = max(soft, break_m[i - 1])
            soft = soft_m[k]
            if soft - before > gap_m and break_m[i] - soft > gap_m:
                n = _fill_to(grading, soft, station_m, n)
            k += 1
        n = _fill_to(grading, break_m[i], station_m, n)
    return n


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
        Increasing, from 0 to the trip's distance, m; all breaks of the line are among them.
    """
    break_m, soft_m, more_m = breaks_of(trip), switch_points(fastest), _braking_points(trip, fastest, cell_m)
    if len(more_m):
        soft_m = np.sort(np.concatenate((soft_m, more_m)))
    most = len(break_m) + len(soft_m) + math.ceil(trip.distance_m / cell_m + _MORE_AT_ENDS)
    station_m = np.empty(most)
    return station_m[: fill_stations(break_m, soft_m, cell_m, station_m)]
