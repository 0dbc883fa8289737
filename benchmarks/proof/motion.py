"""Motion between stations, for the polish: durations, energies and limits of rows of constant acceleration.

Computed anew from the model: forces, means over a row, and the sums that these need.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import allocating, kernel, leaf
from tgvdp.constants import GRAVITY_MPS2
from tgvdp.model.track import NeutralSection, Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip

Floats = NDArray[np.float64]

#: Slack of limits: rounding.
_SLACK = 1.0 + 1e-7
#: Brakes follow the limit of the dynamic one where it changes by less than this share, unless a rate is kept.
_FOLLOWED, _KEPT = 0.05, 0.999
#: Columns of the values at a squared speed.
_V, _PULL, _PULL_SUM, _PULL_STEPS, _BRAKE, _BRAKE_SUM, _BRAKE_STEPS, _RATE = range(8)


class Laws(NamedTuple):
    """What the train can do: pieces (from, power/v, 1, v, v², v³) with the sums of their effort over v² up to each."""

    inertia_kg: float
    davis_a: float
    davis_b: float
    davis_c: float
    traction: Floats
    braking: Floats
    friction_n: float
    rates: Floats
    most_mps2: float
    least_mps2: float
    pull_price: float
    return_price: float
    auxiliary_w: float


class Road(NamedTuple):
    """Stations x in m with the largest squared speed at each; grade force in N and current between them."""

    x: Floats
    top_w: Floats
    grade_n: Floats
    current: Floats
    auxiliary: Floats


def _summed(pieces: NDArray[np.float64]) -> Floats:
    """Pieces of an effort curve with ∫F dw up to the start of each, and the number of its steps up to there."""
    rows = np.zeros((len(pieces), 8))
    rows[:, :6] = pieces
    for i in range(1, len(rows)):
        low, high = rows[i - 1, 0], rows[i, 0]
        rows[i, 6] = rows[i - 1, 6] + _piece_sum(rows[i - 1], low, high)
        before, after = _piece_effort(rows[i - 1], high), _piece_effort(rows[i], high)
        rows[i, 7] = rows[i - 1, 7] + (abs(before - after) > 1e-9 * abs(before))
    return rows


@leaf
def _piece_effort(piece, v):
    power = piece[1] / v if piece[1] != 0.0 else 0.0
    return power + piece[2] + v * (piece[3] + v * (piece[4] + v * piece[5]))


@leaf
def _piece_sum(piece, low, high):
    """∫F dw = 2·∫F·v dv from one speed to another."""
    total = 0.0
    for degree in range(1, 6):
        total += piece[degree] * (high**degree - low**degree) / degree
    return 2.0 * total


@leaf
def _index(rows, v):
    i = rows.shape[0] - 1
    while i > 0 and rows[i, 0] > v:
        i -= 1
    return i


@kernel
def effort_at(rows, v):
    """Effort of a curve at a speed, N."""
    return _piece_effort(rows[_index(rows, v)], v)


@leaf
def look(laws, w, seen):
    """Values at a squared speed that all rows from and to it share."""
    v = math.sqrt(w)
    i = _index(laws.traction, v)
    j = _index(laws.braking, v)
    seen[_V] = v
    seen[_PULL] = _piece_effort(laws.traction[i], v)
    seen[_PULL_SUM] = laws.traction[i, 6] + _piece_sum(laws.traction[i], laws.traction[i, 0], v)
    seen[_PULL_STEPS] = laws.traction[i, 7]
    seen[_BRAKE] = _piece_effort(laws.braking[j], v)
    seen[_BRAKE_SUM] = laws.braking[j, 6] + _piece_sum(laws.braking[j], laws.braking[j, 0], v)
    seen[_BRAKE_STEPS] = laws.braking[j, 7]
    seen[_RATE] = laws.rates[_index(laws.rates, v), 1] if laws.rates.shape[0] > 0 else math.inf


@leaf
def _mean(one, other, value, total, steps):
    """Mean limit over a row, by distance; the lower end's where it steps between."""
    least = min(one[value], other[value])
    change = other[_V] ** 2 - one[_V] ** 2
    if one[steps] != other[steps]:
        return least
    if abs(change) <= 1e-4 * other[_V] ** 2:
        return 0.5 * (one[value] + other[value])
    return (other[total] - one[total]) / change


@leaf
def row(laws, one, other, d, grade, current, auxiliary):
    """(allowed, duration, energy) of a row between two speeds."""
    speeds = one[_V] + other[_V]
    if speeds <= 0.0:
        return False, 0.0, 0.0
    duration = 2.0 * d / speeds
    w_sum = one[_V] ** 2 + other[_V] ** 2
    acceleration = 0.5 * (other[_V] ** 2 - one[_V] ** 2) / d
    mean_v = (2.0 / 3.0) * (w_sum + one[_V] * other[_V]) / speeds
    effort = laws.inertia_kg * acceleration + grade + laws.davis_a + laws.davis_b * mean_v + 0.5 * laws.davis_c * w_sum
    energy = laws.auxiliary_w * auxiliary * duration
    allowed = -laws.least_mps2 * _SLACK <= acceleration <= laws.most_mps2 * _SLACK
    if effort >= 0.0:
        limit = current * _mean(one, other, _PULL, _PULL_SUM, _PULL_STEPS)
        return allowed and effort <= limit * _SLACK, duration, energy + laws.pull_price * effort * d
    rate = min(laws.least_mps2, one[_RATE], other[_RATE])
    if laws.rates.shape[0] > 0:
        allowed = allowed and -acceleration <= rate * _SLACK
    else:
        dynamic = current * _mean(one, other, _BRAKE, _BRAKE_SUM, _BRAKE_STEPS)
        allowed = allowed and -effort <= (dynamic + laws.friction_n) * _SLACK
    if laws.return_price > 0.0:
        energy -= laws.return_price * current * _returned(laws, one, other, -effort, -acceleration < _KEPT * rate) * d
    return allowed, duration, energy


@leaf
def _returned(laws, one, other, effort, free):
    """Mean of the dynamic brake's part of a braking effort (Simpson), which is constant unless it is free."""
    w = 0.5 * (one[_V] ** 2 + other[_V] ** 2)
    v = math.sqrt(w)
    middle = _piece_effort(laws.braking[_index(laws.braking, v)], v)
    mean = (one[_BRAKE] + 4.0 * middle + other[_BRAKE]) / 6.0
    if free and abs(one[_BRAKE] - other[_BRAKE]) <= _FOLLOWED * mean:
        return min(effort, mean)
    return (min(effort, one[_BRAKE]) + 4.0 * min(effort, middle) + min(effort, other[_BRAKE])) / 6.0


@allocating
def measure(laws, road, w):
    """(seconds, joules) of a run."""
    seen = np.empty((2, 8))
    seconds, joules = 0.0, 0.0
    look(laws, w[0], seen[0])
    for k in range(w.shape[0] - 1):
        one, other = seen[k % 2], seen[(k + 1) % 2]
        look(laws, w[k + 1], other)
        d = road.x[k + 1] - road.x[k]
        _, t, e = row(laws, one, other, d, road.grade_n[k], road.current[k], road.auxiliary[k])
        seconds += t
        joules += e
    return seconds, joules


def laws_of(trip: Trip) -> Laws:
    """What the train of a trip can do, and what its energy model charges."""
    train: Train = trip.train
    at_wheel = trip.energy.kind == "wheel"
    return Laws(
        inertia_kg=train.inertia_kg,
        davis_a=train.davis_a_n,
        davis_b=train.davis_b_n_per_mps,
        davis_c=train.davis_c_n_per_mps2,
        traction=_summed(train.traction.table),
        braking=_summed(train.braking.table),
        friction_n=train.friction_brake_n,
        rates=np.array(train.braking_rates, dtype=np.float64).reshape(-1, 2),
        most_mps2=train.max_acceleration_mps2,
        least_mps2=train.max_deceleration_mps2,
        pull_price=1.0 if at_wheel else 1.0 / train.traction_efficiency,
        return_price=0.0 if at_wheel else train.regeneration_efficiency,
        auxiliary_w=0.0 if at_wheel else train.auxiliary_power_w,
    )


def road_of(trip: Trip, x: Floats) -> Road:
    """Line between stations x on the track, m."""
    middle = 0.5 * (x[1:] + x[:-1])
    track: Track = trip.track
    top = np.minimum(_value_at(track.speed_limits, middle), trip.train.max_speed_mps) ** 2
    top_w = np.minimum(np.append(top, math.inf), np.append(math.inf, top))
    grade_n = trip.train.mass_kg * GRAVITY_MPS2 / 1e3 * _value_at(track.gradients or ((0.0, 0.0),), middle)
    auxiliary = np.ones_like(middle)
    for section in track.neutral_sections:
        if section.lowered_pantograph:
            auxiliary[_inside(section, middle)] = 0.0
    return Road(x, top_w, grade_n, current_at(track, middle), auxiliary)


def _value_at(rows: tuple[tuple[float, float], ...], x: Floats) -> Floats:
    """Values of a list of (position, value) that each hold until the next."""
    table = np.array(rows)
    return np.asarray(table[np.searchsorted(table[:, 0], x, side="right") - 1, 1])


def _inside(section: NeutralSection, x: Floats) -> NDArray[np.bool_]:
    return (x > section.position_m) & (x < section.position_m + section.length_m)


def current_at(track: Track, x: Floats) -> Floats:
    """1 where there is current, 0 in neutral sections."""
    current = np.ones_like(x)
    for section in track.neutral_sections:
        current[_inside(section, x)] = 0.0
    return current
