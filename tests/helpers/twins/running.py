"""Twins of the physics: forces from the model, means by quadrature, motion by small steps of the equation of motion."""

import itertools
import math

from scipy.integrate import quad, solve_ivp

GRAVITY_MPS2 = 9.81


def grade_n(train, permil):
    """Grade force, N, of the static mass."""
    return train.mass_kg * GRAVITY_MPS2 * permil / 1000.0


def brake_n(train, v):
    return train.braking.effort_n(v) + train.friction_brake_n


def mean_over_distance(function, v0, v1, breaks=()):
    """Mean of a function of speed where v² is linear in distance: ∫ f(v)·2v dv / (v1² − v0²)."""
    if v0 == v1:
        return function(v0)
    lo, hi = min(v0, v1), max(v0, v1)
    inside = sorted({lo, hi, *(v for v in breaks if lo < v < hi)})
    total = 0.0
    for a, b in itertools.pairwise(inside):
        total += quad(lambda v: function(v) * 2.0 * v, a, b, epsabs=0.0, epsrel=1e-13)[0]
    return total / (hi * hi - lo * lo)


def breaks_of(curve):
    return [piece.from_mps for piece in curve.pieces]


def arc(train, length_m, permil, v0, v1):
    """Duration and work at the wheel of a segment of constant acceleration, straight from the definitions."""
    resistance = mean_over_distance(train.resistance_n, v0, v1)
    acceleration = (v1 * v1 - v0 * v0) / (2.0 * length_m)
    duration = (v1 - v0) / acceleration if v1 != v0 else length_m / v0
    return duration, length_m * (train.inertia_kg * acceleration + resistance + grade_n(train, permil))


def arc_fits(train, length_m, permil, v0, v1):
    """Whether the mean effort and the acceleration of a segment are within the limits."""
    acceleration = (v1 * v1 - v0 * v0) / (2.0 * length_m)
    effort = arc(train, length_m, permil, v0, v1)[1] / length_m
    if (effort > 0.0 and acceleration > train.max_acceleration_mps2) or (
        effort < 0.0 and -acceleration > train.max_deceleration_mps2
    ):
        return False
    if effort >= 0.0:
        return effort <= mean_over_distance(train.traction.effort_n, v0, v1, breaks_of(train.traction))
    return -effort <= mean_over_distance(lambda v: brake_n(train, v), v0, v1, breaks_of(train.braking))


def acceleration_mps2(train, regime, permil, v):
    """dv/dt under full traction, coasting or full braking, with no effort beyond the comfort limits."""
    load = train.resistance_n(v) + grade_n(train, permil)
    effort = 0.0
    if regime == "traction":
        effort = min(train.traction.effort_n(v), max(train.inertia_kg * train.max_acceleration_mps2 + load, 0.0))
    if regime == "braking":
        effort = -min(brake_n(train, v), max(train.inertia_kg * train.max_deceleration_mps2 - load, 0.0))
    return (effort - load) / train.inertia_kg


def follow(train, regime, length_m, permil, v0, rtol=1e-10):
    """Speed and time after a uniform stretch, by integrating over time; (0, time) if the train stops on the way."""

    def rates(_, state):
        return [state[1], acceleration_mps2(train, regime, permil, max(state[1], 0.0))]

    def arrived(_, state):
        return state[0] - length_m

    def stopped(_, state):
        return state[1] - (0.0 if v0 > 0.0 else -1.0)

    arrived.terminal = stopped.terminal = True
    horizon = 1e3 * length_m / max(v0, 0.1)
    run = solve_ivp(rates, (0.0, horizon), [0.0, v0], events=(arrived, stopped), rtol=rtol, atol=1e-12)
    if len(run.t_events[0]):
        return float(run.y[1, -1]), float(run.t[-1])
    return 0.0, float(run.t[-1])


def fastest_s(trip, step_m):
    """Running time of the fastest run by a plain simulation in v(x) on a fine mesh: braking curves, then driving.

    Fixed steps of w = v², fourth order (Runge–Kutta): shares no code and no idea of rows with the package.
    """
    train, track = trip.train, trip.track
    breaks = {row.position_m for row in (*track.speed_limits, *track.gradients)}
    inside = sorted({x for x in breaks if trip.origin_m < x < trip.destination_m} | {trip.origin_m, trip.destination_m})
    x = [inside[0]]
    for a, b in itertools.pairwise(inside):
        parts = max(1, math.ceil((b - a) / step_m))
        x += [a + (b - a) * (i + 1) / parts for i in range(parts)]

    def value(rows, at, default):
        found = default
        for position, level in rows:
            if position <= at:
                found = level
        return found

    cells = [0.5 * (a + b) for a, b in itertools.pairwise(x)]
    limit = [min(value(track.speed_limits, m, math.inf), train.max_speed_mps) ** 2 for m in cells]
    permil = [value(track.gradients, m, 0.0) for m in cells]

    def step(regime, k, w, sign):
        h = sign * (x[k + 1] - x[k])

        def slope(at):
            return 2.0 * acceleration_mps2(train, regime, permil[k], math.sqrt(max(at, 0.0)))

        k1 = slope(w)
        k2 = slope(w + 0.5 * h * k1)
        k3 = slope(w + 0.5 * h * k2)
        return w + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + slope(w + h * k3))

    cap = [0.0] * len(x)
    cap[-1] = trip.end_speed_mps**2
    for k in range(len(cells) - 1, -1, -1):
        cap[k] = min(step("braking", k, min(cap[k + 1], limit[k]), -1.0), limit[k])
    seconds = 0.0
    w = trip.start_speed_mps**2
    for k in range(len(cells)):
        after = min(step("traction", k, w, 1.0), limit[k], cap[k + 1])
        seconds += 2.0 * (x[k + 1] - x[k]) / (math.sqrt(w) + math.sqrt(after))
        w = after
    return seconds
