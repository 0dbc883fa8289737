"""Forces on the train, pointwise and averaged over a segment of constant acceleration.

Within a segment v² is linear in position. The mean over distance of any power of v is then exact: with ds ∝ d(v²),

    mean(v)  = 2/3·(v0² + v0·v1 + v1²)/(v0 + v1)      mean(v²) = (v0² + v1²)/2      mean(1/v) = 2/(v0 + v1)

and so are the mean Davis resistance and the mean of an effort curve. None of these forms cancels as v0 → v1.
Gravity acts on the static mass, acceleration on the inertia (Davis 1926; Brünger & Dahlhaus, in Hansen & Pachl,
Railway Timetabling & Operations, 2014, ch. 4).
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part
from tgvdp.constants import GRAVITY_MPS2
from tgvdp.model.train import Train
from tgvdp.physics.brake_shape import begins_mps, last_jump_mps, ramps_to_mps


class KernelTrain(NamedTuple):
    """What kernels know of a train, SI. Its drag C is a property of the cell (tunnels add to it)."""

    inertia_kg: float
    davis_a_n: float
    davis_b: float
    max_acceleration: float
    max_deceleration: float
    traction: NDArray[np.float64]  # (n, 6), rows of an EffortCurve table
    braking: NDArray[np.float64]  # (n, 6), dynamic brake
    friction_n: float
    rates: NDArray[np.float64]  # (n, 6), full braking as inertia times deceleration; no rows: it is brake effort
    no_effort: NDArray[np.float64]  # (1, 6), the curve of 0 N, for stretches without current
    last_drop_mps: float  # highest speed at which the dynamic brake drops, 0 if it does at none
    last_rise_mps: float  # ... and from which on it has much more than below
    brakes_from_mps: float  # speed at which it rises from nothing, 0 if it does at none
    ramps_to_mps: float  # speed up to which it rises steadily, if anywhere, as much as a jump
    rows: float = 1.0  # how many times more rows than usual `physics.motion` makes
    other_rows: float = 1.0  # ... times as many under other regimes than full traction


def read_only(table: NDArray[np.float64]) -> NDArray[np.float64]:
    """A table of one's own, (n, 6), made read-only as those of effort curves are: kernels know one type of train."""
    table.setflags(write=False)
    return table


#: Above the acceleration of any line that is not vertical.
_STEEPEST_MPS2 = 2.0 * GRAVITY_MPS2
_NO_RATES = read_only(np.empty((0, 6)))
_NO_EFFORT = read_only(np.zeros((1, 6)))
#: An effort curve of more pieces is gone through in strides of so many, on the way to that of a speed.
_MANY_PIECES = 12
_SKIPPED = 8


@lru_cache(maxsize=16)
def kernel_train(train: Train) -> KernelTrain:
    """Reduce a `Train` to what kernels need."""
    brake = train.dynamic_brake_limit
    brakes_from_mps = begins_mps(brake)
    return KernelTrain(
        float(train.inertia_kg),
        float(train.davis_a_n),
        float(train.davis_b_n_per_mps),
        float(train.max_acceleration_mps2),
        float(train.max_deceleration_mps2),
        train.traction_limit.table,
        brake.table,
        _friction_n(train),
        _rate_table(train),
        _NO_EFFORT,
        last_jump_mps(brake, rises=False),
        max(last_jump_mps(brake, rises=True), brakes_from_mps),
        brakes_from_mps,
        ramps_to_mps(brake),
    )


def per_kilogram(train: KernelTrain) -> KernelTrain:
    """The same train with all forces per unit of inertia."""
    per_kg = 1.0 / train.inertia_kg
    scale = np.array([1.0, *(per_kg,) * 5])
    return train._replace(
        inertia_kg=1.0,
        davis_a_n=train.davis_a_n * per_kg,
        davis_b=train.davis_b * per_kg,
        traction=read_only(train.traction * scale),
        braking=read_only(train.braking * scale),
        friction_n=train.friction_n * per_kg,
        rates=read_only(train.rates * scale),
    )


def _friction_n(train: Train) -> float:
    """Effort of the friction brake: where rates are given, enough to keep them on any line that is not vertical."""
    if not train.braking_rates:
        return float(train.friction_brake_n)
    return (
        train.inertia_kg * max(rate.deceleration_mps2 for rate in train.braking_rates) + train.mass_kg * _STEEPEST_MPS2
    )


def _rate_table(train: Train) -> NDArray[np.float64]:
    """Braking rates, no larger than comfort allows, as a table of net forces in the form of an effort curve."""
    if not train.braking_rates:
        return _NO_RATES
    table = np.zeros((len(train.braking_rates), 6))
    table[:, 0] = [rate.from_mps for rate in train.braking_rates]
    rates_mps2 = [min(rate.deceleration_mps2, train.max_deceleration_mps2) for rate in train.braking_rates]
    table[:, 2] = train.inertia_kg * np.array(rates_mps2)
    return read_only(table)


@leaf
def unpowered(train):
    """The train without current: neither traction nor dynamic brake."""
    return KernelTrain(
        train.inertia_kg, train.davis_a_n, train.davis_b, train.max_acceleration, train.max_deceleration,
        train.no_effort, train.no_effort, train.friction_n, train.rates, train.no_effort, train.last_drop_mps,
        train.last_rise_mps, train.brakes_from_mps, train.ramps_to_mps, train.rows, train.other_rows,
    )  # fmt: skip


@leaf
def piece_at(table, v):
    """Index of the piece of an effort curve that holds at a speed: the last one that begins at or below it."""
    i = table.shape[0] - 1
    if i > _MANY_PIECES:
        i = _nearly_piece_at(table, v)
    while i > 0 and table[i, 0] > v:
        i -= 1
    return i


@part
def _nearly_piece_at(table, v):
    """`piece_at`, or a piece soon after it."""
    i = table.shape[0] - 1
    while i >= _SKIPPED and table[i - _SKIPPED, 0] > v:
        i -= _SKIPPED
    return i


@leaf
def piece_effort(table, i, v):
    """Effort in N at speed v by the piece i of a curve."""
    hyperbolic = 0.0
    if table[i, 1] != 0.0:
        hyperbolic = table[i, 1] / v
    return hyperbolic + table[i, 2] + v * (table[i, 3] + v * (table[i, 4] + v * table[i, 5]))


@leaf
def effort_at(table, v):
    """Effort in N at speed v, of a curve table of shape (n, 6)."""
    return piece_effort(table, piece_at(table, v), v)


@leaf
def effort_and_slope(table, i, v):
    """Effort F in N and its derivative dF/dv in N/(m/s) at speed v, by the piece i of a curve."""
    effort = table[i, 2] + v * (table[i, 3] + v * (table[i, 4] + v * table[i, 5]))
    slope = table[i, 3] + v * (2.0 * table[i, 4] + v * 3.0 * table[i, 5])
    if table[i, 1] != 0.0:
        hyperbolic = table[i, 1] / v
        effort += hyperbolic
        slope -= hyperbolic / v
    return effort, slope


@leaf
def piece_mean(table, i, u0, u1):
    """`mean_effort` between two speeds on the piece i of a curve, the lower one first."""
    s = u0 + u1
    if s <= 0.0:
        return table[i, 2]
    q0 = u0 * u0
    q1 = u1 * u1
    p = u0 * u1
    return (
        2.0 * table[i, 1] / s
        + table[i, 2]
        + table[i, 3] * (2.0 / 3.0) * (q0 + p + q1) / s
        + table[i, 4] * 0.5 * (q0 + q1)
        + table[i, 5] * 0.4 * (q0 * q0 + p * (q0 + p + q1) + q1 * q1) / s
    )


@leaf
def mean_effort(table, v0, v1):
    """Mean over distance, in N, of an effort curve on a segment of constant acceleration between v0 and v1."""
    lo = min(v0, v1)
    hi = max(v0, v1)
    i = piece_at(table, lo)
    if i == table.shape[0] - 1 or table[i + 1, 0] >= hi:
        return piece_mean(table, i, lo, hi)
    return _mean_of_pieces(table, i, lo, hi)


@part
def _mean_of_pieces(table, i, lo, hi):
    """`mean_effort` from a speed on the piece ``i`` to one beyond it; few rows do that."""
    total = 0.0
    u0 = lo
    while u0 < hi:
        u1 = hi
        if i + 1 < table.shape[0] and table[i + 1, 0] < hi:
            u1 = table[i + 1, 0]
        total += piece_mean(table, i, u0, u1) * (u1 - u0) * (u1 + u0)
        u0 = u1
        i += 1
    return total / ((hi - lo) * (hi + lo))


@leaf
def least_effort(table, v0, v1):
    """Least effort in N of a curve between two speeds, of those at both and at its breaks: curves may dip between."""
    lo = min(v0, v1)
    hi = max(v0, v1)
    i = piece_at(table, lo)
    least = min(piece_effort(table, i, lo), effort_at(table, hi))
    while i + 1 < table.shape[0] and table[i + 1, 0] < hi:
        v = table[i + 1, 0]
        least = min(least, piece_effort(table, i, v), piece_effort(table, i + 1, v))
        i += 1
    return least


@leaf
def resistance_at(train, air, v):
    """Running resistance A + B·v + C·v² in N; ``air`` is the cell's C."""
    return train.davis_a_n + v * (train.davis_b + v * air)


@leaf
def mean_resistance(train, air, v0, v1):
    """Mean over distance, in N, of the running resistance on a segment of constant acceleration."""
    s = v0 + v1
    linear = 0.0
    if s > 0.0:
        linear = train.davis_b * (2.0 / 3.0) * (v0 * v0 + v0 * v1 + v1 * v1) / s
    return train.davis_a_n + linear + air * 0.5 * (v0 * v0 + v1 * v1)


@part
def mean_rate(rates, v0, v1):
    """Net force in N that braking rates give on average between two speeds: the one that takes as long a distance.

    A rate r is kept over ½·Δw/r, so that it is the harmonic mean over w = v².
    """
    hi = max(v0, v1) ** 2
    w = min(v0, v1) ** 2
    span = hi - w
    i = rates.shape[0] - 1
    while i > 0 and rates[i, 0] * rates[i, 0] > w:
        i -= 1
    if i == rates.shape[0] - 1 or rates[i + 1, 0] * rates[i + 1, 0] >= hi:
        return rates[i, 2]
    distance = 0.0
    while w < hi:
        end = hi
        if i + 1 < rates.shape[0]:
            end = min(rates[i + 1, 0] * rates[i + 1, 0], hi)
        distance += (end - w) / rates[i, 2]
        w = end
        i += 1
    return span / distance


@leaf
def mean_brake(train, load, v0, v1):
    """Mean over distance, in N, of the largest braking effort (dynamic and friction), positive or 0.

    Braking rates are kept whatever the ``load`` (mean resistance and grade force, N): the brakes do the rest.
    """
    if train.rates.shape[0] > 0:
        return max(mean_rate(train.rates, v0, v1) - load, 0.0)
    return mean_effort(train.braking, v0, v1) + train.friction_n


@leaf
def brake_at(train, load, v):
    """Largest braking effort (dynamic and friction) in N at speed v under a ``load`` in N, positive or 0."""
    if train.rates.shape[0] > 0:
        return max(effort_at(train.rates, v) - load, 0.0)
    return effort_at(train.braking, v) + train.friction_n
