"""Dynamic programming over a plain grid of speeds: any run of it is feasible, so no optimum may cost more."""

import math

import numpy as np

from .running import GRAVITY_MPS2, brake_n


def _values(rows, at, default):
    found = np.full(len(at), default)
    for position, level in rows:
        found[at >= position] = level
    return found


def least_costs(trip, fastest, prices, stations=80, levels=90):
    """Least E + λT of a grid for each λ: time and energy of the best grid run, (n, 2).

    Between two stations the acceleration is constant; the effort must be within its curves at both ends. Energy at the
    pantograph counts the train's efficiencies, but no auxiliaries.
    """
    train, track = trip.train, trip.track
    breaks = {row.position_m for row in (*track.speed_limits, *track.gradients)}
    x = {trip.origin_m, trip.destination_m, *(b for b in breaks if trip.origin_m < b < trip.destination_m)}
    x = np.array(sorted(x | set(np.linspace(trip.origin_m, trip.destination_m, stations + 1))))
    x = x[np.concatenate(([True], np.diff(x) > 1e-9 * trip.distance_m))]
    middle = 0.5 * (x[1:] + x[:-1])
    grade = train.mass_kg * GRAVITY_MPS2 / 1000.0 * _values(track.gradients, middle, 0.0)
    top = np.interp(x, fastest.position_m, fastest.speed_mps**2)
    share = (np.arange(levels) / (levels - 1)) ** 2
    w = top[:, None] * share
    w[0], w[-1] = trip.start_speed_mps**2, trip.end_speed_mps**2
    costs = []
    for k in range(len(x) - 1):
        costs.append(_arcs(trip, x[k + 1] - x[k], grade[k], w[k][:, None], w[k + 1][None, :]))
    found = []
    for price in prices:
        to_go = np.where(np.isclose(w[-1], trip.end_speed_mps**2), 0.0, np.inf)
        choice = []
        for seconds, joules in reversed(costs):
            total = joules + price * seconds + to_go[None, :]
            choice.append(np.argmin(total, axis=1))
            to_go = np.min(total, axis=1)
        if not math.isfinite(to_go[-1]):
            found.append((math.inf, math.inf))
            continue
        state, time, energy = levels - 1, 0.0, 0.0
        for (seconds, joules), best in zip(costs, reversed(choice), strict=True):
            time += seconds[state, best[state]]
            energy += joules[state, best[state]]
            state = best[state]
        found.append((time, energy))
    return np.array(found)


def _arcs(trip, length, grade, w0, w1):
    """Time and energy of all arcs between two stations; infinite where infeasible."""
    train = trip.train
    v0, v1 = np.sqrt(w0), np.sqrt(w1)
    total = v0 + v1
    acceleration = (w1 - w0) / (2.0 * length)
    effort = np.vectorize(train.traction.effort_n)
    brakes = np.vectorize(lambda v: brake_n(train, v))
    fits = (acceleration <= train.max_acceleration_mps2) & (-acceleration <= train.max_deceleration_mps2) & (total > 0)
    for v in (v0, v1):
        force = train.inertia_kg * acceleration + train.resistance_n(v) + grade
        fits &= (force <= effort(v) * (1.0 + 1e-9)) & (-force <= brakes(v) * (1.0 + 1e-9))
    with np.errstate(divide="ignore", invalid="ignore"):
        seconds = np.where(fits, 2.0 * length / total, np.inf)
        linear = train.davis_b_n_per_mps * (2.0 / 3.0) * (w0 + v0 * v1 + w1) / total
    mean = train.davis_a_n + linear + 0.5 * train.davis_c_n_per_mps2 * (w0 + w1)
    work = 0.5 * train.inertia_kg * (w1 - w0) + length * (mean + grade)
    joules = np.maximum(work, 0.0)
    if trip.energy.kind == "pantograph":
        joules = joules / train.traction_efficiency
        # The dynamic brake takes a constant effort where it can: by Simpson's rule over the distance.
        dynamic = np.vectorize(train.braking.effort_n)
        taken = [
            np.minimum(np.maximum(-work, 0.0), length * dynamic(np.sqrt((1.0 - at) * w0 + at * w1)))
            for at in (0.0, 0.5, 1.0)
        ]
        joules = joules - train.regeneration_efficiency * (taken[0] + 4.0 * taken[1] + taken[2]) / 6.0
    return seconds, np.where(fits, joules, np.inf)
