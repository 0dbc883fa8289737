"""A dynamic program over speeds on a grid: for one multiplier, by brute force, and nothing of the engine in it.

From each speed of the grid the train goes on over some metres at one of many efforts, and what it costs to go on from
the speed that it comes to is interpolated. So speeds are off by the interpolation, and efforts change every few metres
only; both errors fall with the steps.
"""

from functools import cache

import numpy as np

#: Shares of full traction, of the whole dynamic brake, and of friction besides that.
_SHARES = np.linspace(-2.0, 1.0, 25)
#: Times that the speed in the middle of a step is found anew.
_ROUNDS = 4
#: Efforts are known for speeds in steps of this.
_GRAIN_MPS = 1e-3


def least_cost_j(train, track, multiplier, step_m=5.0, step_w=0.1):
    """Least E + λT from stop to stop on a line of limits and gradients, J at the pantograph; λ in J/s.

    Squared speeds are on a grid of ``step_w``, m²/s².
    """
    middle_m = np.arange(0.5 * step_m, track.length_m, step_m)
    top_w = np.minimum(_held(track.speed_limits, middle_m), train.max_speed_mps) ** 2
    permil = _held(track.gradients, middle_m) if track.gradients else np.zeros_like(middle_m)
    w = np.arange(0.0, top_w.max() + 0.5 * step_w, step_w)
    speeds = np.arange(0.5 * _GRAIN_MPS, np.sqrt(w[-1]) + 2.0, _GRAIN_MPS)
    curves = [
        np.array([curve.effort_n(v) for v in speeds]) for curve in (train.traction_limit, train.dynamic_brake_limit)
    ]

    @cache
    def moves(slope_permil):
        return _moves(train, w, slope_permil, step_m, curves)

    cost_j = np.where(w == 0.0, 0.0, np.inf)
    for top, slope_permil in zip(top_w[::-1].tolist(), permil[::-1].tolist(), strict=True):
        next_w, energy_j, time_s = moves(slope_permil)
        rest_j = _between(w, cost_j, next_w)
        total_j = np.where(next_w <= top + 1e-9, energy_j + multiplier * time_s + rest_j, np.inf)
        cost_j = np.where(w <= top + 1e-9, total_j.min(axis=0), np.inf)
    return cost_j[0]


def _held(values, at_m):
    """Values that hold from a position to the next one."""
    positions_m, levels = np.array([tuple(value) for value in values]).T
    return levels[np.searchsorted(positions_m, at_m, side="right") - 1]


def _between(w, cost_j, at_w):
    """Costs between speeds of the grid; infinite next to one from which no run comes to the end."""
    i = np.clip(at_w / w[1], 0, len(w) - 2).astype(int)
    share = np.clip(at_w / w[1] - i, 0.0, 1.0)
    with np.errstate(invalid="ignore"):
        mixed_j = (1.0 - share) * cost_j[i] + share * cost_j[i + 1]
    return np.where(share == 0.0, cost_j[i], np.where(np.isnan(mixed_j), np.inf, mixed_j))


def _moves(train, w, slope_permil, step_m, curves):
    """Where each effort leads from each speed, what it takes, and how long; no time at all if it leads nowhere."""
    grade_n = train.mass_kg * 9.81 * slope_permil / 1000.0
    found = [_by_effort(train, w, grade_n, step_m, curves, share) for share in _SHARES]
    found += [_to_speed(train, w, target_w, grade_n, step_m, curves) for target_w in (w, np.zeros_like(w))]
    next_w, energy_j = (np.array(parts) for parts in zip(*found, strict=True))
    with np.errstate(divide="ignore"):
        time_s = 2.0 * step_m / (np.sqrt(w) + np.sqrt(np.maximum(next_w, 0.0)))
    never = (next_w < 0.0) | np.isnan(energy_j)
    return np.where(never, np.inf, next_w), np.where(never, 0.0, energy_j), np.where(np.isinf(time_s), 1e9, time_s)


def _limits_n(train, v, grade_n, curves):
    """Load, largest traction, dynamic brake and all brakes at some speeds, N."""
    traction_n, dynamic_n = (curve[(v / _GRAIN_MPS).astype(int)] for curve in curves)
    load_n = train.davis_a_n + v * (train.davis_b_n_per_mps + v * train.davis_c_n_per_mps2) + grade_n
    most_n = np.maximum(train.inertia_kg * train.max_deceleration_mps2 - load_n, 0.0)
    traction_n = np.minimum(traction_n, train.inertia_kg * train.max_acceleration_mps2 + load_n)
    return load_n, traction_n, dynamic_n, np.minimum(dynamic_n + train.friction_brake_n, most_n)


def _drawn_j(train, effort_n, dynamic_n, step_m):
    """Energy at the pantograph of an effort, below 0 of brakes, of which the dynamic one comes first."""
    returned_n = np.minimum(np.maximum(-effort_n, 0.0), dynamic_n)
    drawn_n = np.maximum(effort_n, 0.0) / train.traction_efficiency - train.regeneration_efficiency * returned_n
    return drawn_n * step_m


def _by_effort(train, w, grade_n, step_m, curves, share):
    v = middle = np.sqrt(w)
    for _ in range(_ROUNDS):
        load_n, traction_n, dynamic_n, brakes_n = _limits_n(train, middle, grade_n, curves)
        effort_n = share * traction_n
        if share < 0.0:
            friction_n = max(-share - 1.0, 0.0) * train.friction_brake_n
            effort_n = -np.minimum(min(-share, 1.0) * dynamic_n + friction_n, brakes_n)
        next_w = w + 2.0 * step_m / train.inertia_kg * (effort_n - load_n)
        middle = 0.5 * (v + np.sqrt(np.maximum(next_w, 0.0)))
    return next_w, _drawn_j(train, effort_n, dynamic_n, step_m)


def _to_speed(train, w, next_w, grade_n, step_m, curves):
    """To a speed, at the effort that this takes; no number where that is beyond limits."""
    load_n, traction_n, dynamic_n, brakes_n = _limits_n(train, 0.5 * (np.sqrt(w) + np.sqrt(next_w)), grade_n, curves)
    effort_n = load_n + train.inertia_kg * (next_w - w) / (2.0 * step_m)
    energy_j = _drawn_j(train, effort_n, dynamic_n, step_m)
    return next_w, np.where((effort_n <= traction_n) & (-effort_n <= brakes_n), energy_j, np.nan)
