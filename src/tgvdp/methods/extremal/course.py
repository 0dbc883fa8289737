"""What the kernels of extremals know of a trip, and the speeds that a multiplier holds. All per unit of inertia."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.line.cells import cells_of
from tgvdp.methods.costate.characteristics import holding_w
from tgvdp.model.trip import Trip
from tgvdp.physics.arc import duration_and_work
from tgvdp.physics.energy import energy_tables, regenerated
from tgvdp.physics.forces import (
    KernelTrain,
    effort_at,
    kernel_train,
    per_kilogram,
)
from tgvdp.runs.fastest import envelope_of

#: Rows of a run, per usual one: time and energy of a row to 1e-6.
_ROWS = 8.0
#: ... and of the envelope, which runs join and leave within a row: the effort on a part of it is within 0.1 % then.
_ENVELOPE_ROWS = 16.0
#: Rows of the envelope that are shorter than this share of the distance are rounding.
_SLIVER = 1e-12
#: Share of the greatest squared speed below which a train creeps.
_CREEPS = 1e-4
#: An effort below this share of the starting effort is none.
_NO_EFFORT = 1e-6


class Course(NamedTuple):
    """K cells of a line, its own breaks only, and the envelope of feasible speeds, float64 where not said otherwise.

    Attributes
    ----------
    station_m : (K + 1,)
        Positions from the origin.
    grade, air : (K,)
        Gradient's force and coefficient of v², per unit of inertia.
    low : (K + 1,)
        Squared speed of the slowest run that reaches the end.
    x_m, w : (n,)
        Rows of the fastest run.
    effort : (n,)
        Mean effort of the row that starts at each, per unit of inertia; the last is 0.
    duration, energy : (n,)
        Its duration, and its energy in that of traction, per unit of inertia.
    returned : float
        What a joule of the dynamic brake is worth, in joules of traction; 0 without regeneration.
    corner_m : (c,)
        Where the envelope turns from braking to traction: at the ends of braking curves.
    least_w : float
        Squared speed at which traction takes over from whatever slows the train down: no extremal creeps.
    """

    station_m: NDArray[np.float64]
    grade: NDArray[np.float64]
    air: NDArray[np.float64]
    low: NDArray[np.float64]
    x_m: NDArray[np.float64]
    w: NDArray[np.float64]
    effort: NDArray[np.float64]
    duration: NDArray[np.float64]
    energy: NDArray[np.float64]
    returned: float
    corner_m: NDArray[np.float64]
    least_w: float


def course_of(trip: Trip) -> tuple[KernelTrain, Course]:
    """The train per unit of inertia, and its course."""
    train = kernel_train(trip.train)._replace(rows=_ROWS)
    cells = cells_of(trip)
    envelope = envelope_of(trip, cells, train._replace(rows=_ENVELOPE_ROWS))
    keep = np.concatenate(([True], np.diff(envelope.x_m) > _SLIVER * trip.distance_m))
    x_m, w = envelope.x_m[keep], envelope.w[keep]
    x_m[-1], w[-1] = cells.station_m[-1], envelope.w[-1]  # a standstill is one to the end
    unit = per_kilogram(train)
    grade, air = cells.grade_n / train.inertia_kg, cells.air / train.inertia_kg
    cell = np.searchsorted(cells.station_m, 0.5 * (x_m[1:] + x_m[:-1]), side="right") - 1
    tables = energy_tables(trip.train, trip.energy)
    brakes = bool(train.braking[:, 1:].any())
    returned = tables.regeneration / tables.traction if brakes else 0.0
    effort, duration, energy = np.zeros((3, len(x_m)))
    _account(unit, returned, grade, air, cell, x_m, w, effort, duration, energy)
    starting = trip.train.traction_limit.effort_n(0.0) / train.inertia_kg
    effort[np.abs(effort) < _NO_EFFORT * starting] = 0.0
    corners_m = x_m[1:-1][(effort[:-2] < 0.0) & (effort[1:-1] > 0.0)]
    return unit, Course(
        cells.station_m, grade, air, envelope.low, x_m, w, effort, duration, energy, returned, corners_m,
        _CREEPS * float(w.max()),
    )  # fmt: skip


@kernel
def _account(train, returned, grade, air, cell, x, w, effort, duration, energy):
    for i in range(cell.shape[0]):
        k = cell[i]
        d = x[i + 1] - x[i]
        duration[i], energy[i], effort[i] = account(train, returned, grade[k], air[k], d, w[i], w[i + 1])


@leaf
def account(train, returned, grade, air, d, w0, w1):
    """Duration, energy and mean effort of a row, the latter two per unit of inertia."""
    duration, work, _, _ = duration_and_work(train, d, grade, air, w0, w1)
    energy = work
    if work < 0.0:
        energy = 0.0
        if returned > 0.0:
            energy = -returned * d * regenerated(train, d, -work / d, math.sqrt(w0), math.sqrt(w1))
    return duration, energy, work / d


@kernel
def held_speeds(train, air, returned, price, levels):
    """Squared speeds that a price of time holds in each cell; ``levels`` (K, 3) in place.

    By traction, V²·R'(V) = λ; by the dynamic brake, r·V²·R'(V) = λ; and beside the friction brake, where λ/v − r·D(v)
    is least. Infinite where there is none.
    """
    last = -1.0
    for k in range(air.shape[0]):
        if air[k] != last or k == 0:
            last = air[k]
            pulled = holding_w(train.davis_b, air[k], price)
            retarded = holding_w(train.davis_b, air[k], price / returned) if returned > 0.0 else math.inf
        levels[k, 0] = pulled
        levels[k, 1] = retarded
    least = math.inf
    if returned > 0.0:
        least = _braked_speed(train.braking, price / returned) ** 2
    levels[:, 2] = least


@kernel
def _braked_speed(table, price):
    """Speed at which λ/(r·v) − D(v) is least, over the pieces of the dynamic brake's curve; infinite at no speed."""
    best = 0.0  # at high speeds the effort fades: what tends to 0 from above
    best_v = math.inf
    for i in range(table.shape[0]):
        low = table[i, 0]
        high = table[i + 1, 0] if i + 1 < table.shape[0] else 2.0 * max(low, 50.0)
        for j in range(17):
            v = low + (high - low) * j / 16.0
            if v <= 0.0:
                continue
            value = price / v - effort_at(table, v * (1.0 - 1e-12))
            if value < best:
                best = value
                best_v = v
    return best_v
