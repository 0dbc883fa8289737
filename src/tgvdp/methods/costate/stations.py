"""Stations of the front method: every break of the line, the switch points of the fastest run, and graded cells.

The cell size is ``h`` along the line and falls linearly to ``h / 10`` at the two ends, where the speed changes fast.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, part
from tgvdp.line.cells import breaks_of, cells_of
from tgvdp.methods.costate.brake_jumps import AT_CUT, cut_out_w
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import energy_tables
from tgvdp.physics.forces import effort_at, kernel_train, resistance_at
from tgvdp.runs.profile import Profile

_END_SHARE = 0.1
_GRADING = 0.2
#: How often the last cell is halved, each time next to the end, where braking returns energy.
_END_HALVINGS = 3
#: Stations closer than this share of the distance are one.
_SAME = 1e-7
#: Efforts at the ends of a row are taken this share of it inside: they may jump there.
_INSIDE = 1e-6
_HALVINGS = 40


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
    """Where friction begins or ends to help the dynamic brake along a run, and where that cuts out.

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
    cut_w = cut_out_w(train)
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
        if cut_w > 0.0 and abs(w[i] - cut_w) <= AT_CUT * cut_w:
            at[count] = x[i]
            count += 1
        elif abs(w[i + 1] - cut_w) > AT_CUT * cut_w and (w[i] - cut_w) * (w[i + 1] - cut_w) < 0.0:
            at[count] = x[i] + (cut_w - w[i]) / (w[i + 1] - w[i]) * d
            count += 1
        before = last
    return count


def _braking_points(trip: Trip, fastest: Profile, cell_m: float) -> NDArray[np.float64]:
    """Where friction begins or ends to help the dynamic brake along the fastest run, or that cuts out; next to its end.

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
    soft_m = np.sort(np.concatenate((switch_points(fastest), _braking_points(trip, fastest, cell_m))))
    gap_m = _SAME * trip.distance_m
    after = np.searchsorted(breaks_m[1:-1], soft_m) + 1
    apart = np.minimum(soft_m - breaks_m[after - 1], breaks_m[after] - soft_m) > gap_m
    apart[1:] &= soft_m[1:] - soft_m[:-1] > gap_m
    soft_m = soft_m[apart]
    fixed_m = np.sort(np.concatenate((breaks_m, soft_m)))
    grading = _Grading(trip.distance_m, cell_m)
    at = grading.count(fixed_m)
    span = at[1:] - at[:-1]
    counts = np.maximum(np.ceil(span - 1e-9), 1.0).astype(np.int64)
    inner = counts - 1
    start = np.repeat(at[:-1], inner)
    step = np.repeat(span / counts, inner)
    which = np.arange(1, len(start) + 1) - np.repeat(np.cumsum(inner) - inner, inner)
    inner_m = grading.position(start + which * step)
    station_m = np.sort(np.concatenate((fixed_m, inner_m)))
    return np.concatenate((station_m[:1], station_m[1:][station_m[1:] > station_m[:-1]]))
