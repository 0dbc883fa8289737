"""Dynamic programming over a plain grid of speeds: any run of it is feasible, so no optimum may cost more."""

import math

import numpy as np

from .running import brake_n


def _values(rows, at, default):
    found = np.full(len(at), default)
    for position, level in rows:
        found[at >= position] = level
    return found


def _permil(track, formula, at):
    """Gradient and curve resistance at positions, ‰, as the formulas have it; held before the line."""
    at = np.maximum(at, 1e-9)
    total = _values(track.gradients, at, 0.0)
    ends = [*(row.position_m for row in track.curves[1:]), track.length_m]
    for row, end in zip(track.curves, ends, strict=False):
        share = (at - row.position_m) / (end - row.position_m)
        bend = np.abs((1.0 - share) / row.radius_start_m + share / row.radius_end_m)
        radius = 1.0 / np.maximum(bend, 1e-12)
        permil = {
            "none": 0.0 * bend,
            "800/R": 800.0 * bend,
            "roeckl": np.where(
                radius >= 300.0, 650.0 / np.maximum(radius - 55.0, 1.0), 500.0 / np.maximum(radius - 30.0, 1.0)
            ),
        }[formula]
        total = total + np.where((at > row.position_m) & (at <= end), permil, 0.0)
    return total


def _drag(trip, at):
    """Coefficient of v² at positions."""
    known = dict(trip.train.tunnel_drag)
    total = np.full(at.shape, trip.train.davis_c_n_per_mps2)
    for start, length, area in trip.track.tunnels if trip.convention.tunnels else ():
        total += np.where((at > start) & (at <= start + length), known[area], 0.0)
    return total


def met(trip, start, end, parts=24):
    """Mean force of gradients and curves, N, and mean coefficient of v², over a stretch of the head's positions."""
    middles = (np.arange(parts) + 0.5) / parts
    at = start + (end - start) * middles
    if trip.convention.mass_model == "strip":
        at = (at[:, None] - trip.train.length_m * middles[None, :]).ravel()
    weight = trip.train.mass_kg * trip.convention.gravity_mps2
    return float(_permil(trip.track, trip.convention.curves, at).mean()) / 1000.0 * weight, float(
        _drag(trip, at).mean()
    )


def least_costs(trip, fastest, prices, stations=80, levels=90):
    """Least E + λT of a grid for each λ: time and energy of the best grid run, (n, 2).

    Between two stations the acceleration is constant; the effort must be within its curves at both ends. Energy at the
    pantograph counts the train's efficiencies, but no auxiliaries. The line is met as the convention says.
    """
    track = trip.track
    breaks = {row.position_m for row in (*track.speed_limits, *track.gradients)}
    for start, length, _ in (*track.tunnels, *track.neutral_sections):
        breaks |= {start, start + length}
    reach = trip.train.length_m if trip.convention.limits == "tail" else 0.0
    breaks |= {row.position_m + reach for row in track.speed_limits}
    x = {trip.origin_m, trip.destination_m, *(b for b in breaks if trip.origin_m < b < trip.destination_m)}
    x = np.array(sorted(x | set(np.linspace(trip.origin_m, trip.destination_m, stations + 1))))
    x = x[np.concatenate(([True], np.diff(x) > 1e-9 * trip.distance_m))]
    top = np.interp(x, fastest.position_m, fastest.speed_mps**2)
    share = (np.arange(levels) / (levels - 1)) ** 2
    w = top[:, None] * share
    w[0], w[-1] = trip.start_speed_mps**2, trip.end_speed_mps**2
    costs = []
    for k in range(len(x) - 1):
        middle = 0.5 * (x[k] + x[k + 1])
        dark = any(start < middle < start + length for start, length, _ in track.neutral_sections)
        costs.append(_arcs(trip, x[k], x[k + 1], dark, w[k][:, None], w[k + 1][None, :]))
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


def _arcs(trip, start, end, dark, w0, w1):
    """Time and energy of all arcs between two stations, in the ``dark`` without current; infinite where infeasible."""
    train = trip.train
    length = end - start
    grade, drag = met(trip, start, end)
    v0, v1 = np.sqrt(w0), np.sqrt(w1)
    total = v0 + v1
    acceleration = (w1 - w0) / (2.0 * length)
    effort = np.vectorize(lambda v: 0.0 if dark else train.traction.effort_n(v))
    brakes = np.vectorize(lambda v: train.friction_brake_n if dark else brake_n(train, v))
    rates = np.array(train.braking_rates).reshape(-1, 2)
    fits = total > 0
    # Next to nothing counts as coasting.
    none = 1e-5 * train.traction.effort_n(0.0)
    for v in (v0, v1):
        load = train.davis_a_n + v * (train.davis_b_n_per_mps + v * drag) + grade
        force = train.inertia_kg * acceleration + load
        most = brakes(v)
        if len(rates):
            rate = rates[np.searchsorted(rates[:, 0], v, side="right") - 1, 1]
            most = np.maximum(train.inertia_kg * rate - load, 0.0)
        fits &= (acceleration <= train.max_acceleration_mps2) | (force <= none)
        fits &= (-acceleration <= train.max_deceleration_mps2) | (-force <= none)
        fits &= (force <= effort(v) * (1.0 + 1e-9) + none) & (-force <= most * (1.0 + 1e-9) + none)
    with np.errstate(divide="ignore", invalid="ignore"):
        seconds = np.where(fits, 2.0 * length / total, np.inf)
        linear = train.davis_b_n_per_mps * (2.0 / 3.0) * (w0 + v0 * v1 + w1) / total
    mean = train.davis_a_n + linear + 0.5 * drag * (w0 + w1)
    work = 0.5 * train.inertia_kg * (w1 - w0) + length * (mean + grade)
    joules = np.maximum(work, 0.0)
    if trip.energy.kind == "pantograph":
        joules = joules / train.traction_efficiency
        # The dynamic brake takes a constant effort where it can: by Simpson's rule over the distance.
        dynamic = np.vectorize(lambda v: 0.0 if dark else train.braking.effort_n(v))
        taken = [
            np.minimum(np.maximum(-work, 0.0), length * dynamic(np.sqrt((1.0 - at) * w0 + at * w1)))
            for at in (0.0, 0.5, 1.0)
        ]
        joules = joules - train.regeneration_efficiency * (taken[0] + 4.0 * taken[1] + taken[2]) / 6.0
    return seconds, np.where(fits, joules, np.inf)
