"""From a run on steps of the resistance to a run under the true one (see `physics.resolved`).

With the same effort at each position, the true run differs inside a step by

    w_true(x) = w_step(x) + 2/m_eff·∫(G_step − G + (C_step − C)·w) ds,    zero at both ends of the step.

Where something else than the effort is given, that is kept instead: a speed that is held, a comfort limit, a braking
rate. Rows are cut until the difference is nearly linear along each of them.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel
from tgvdp.model.train import Train
from tgvdp.physics.energy import FULL_EFFORT
from tgvdp.physics.forces import kernel_train, mean_brake, mean_effort, mean_resistance
from tgvdp.physics.motion import BELOW_DROP
from tgvdp.physics.piecewise import Floats
from tgvdp.physics.resolved import ResolvedLine

#: No more than this share of w is taken from a run: it is next to standstill there.
_MOST_TAKEN = 0.75
#: An acceleration within this share of its limit is at the limit.
_AT_LIMIT = 1e-6
#: A speed is held by choice where the effort is below this share of its limit.
_SPARE_EFFORT = 0.98
#: ... and above this share of the starting effort: less is coasting at the balancing speed.
_COASTING_SHARE = 1e-4
#: Below this share of it an effort may neither grow nor change its sign.
_SMALL_SHARE = 1e-2
#: Relative difference of squared speeds that are one.
_SAME_W = 1e-8
#: Largest bend of the difference along a row, as a share of w, and the rows that one is cut into at most.
_BEND = 1e-5
_MOST_PARTS = 64
#: Share of the effort by which a run may exceed that of the run on steps.
_SPARE = 3e-4


def follow(train: Train, line: ResolvedLine, x_m: Floats, w: Floats) -> tuple[Floats, Floats]:
    """Follow the true resistance with a run that was found on steps.

    Parameters
    ----------
    train : Train
    line : ResolvedLine
    x_m, w : (n,) float64
        Rows of the run: positions from the origin, m, with all breaks among them, and squared speeds, m²/s².

    Returns
    -------
    x_m, w : (m,) float64
        Rows of the run with the same effort, or the same acceleration or speed where that is what is kept; at most
        the speed limit.
    """
    if line.even:
        return x_m, w
    x_m, w = _cut(train, line, x_m, w)
    effort_n = _efforts_n(train, line, x_m, w)
    same_effort = line.gain(x_m, w)
    bound, held, fixed = _kept(train, x_m, w, effort_n)
    kept = bound | held
    free = np.concatenate(([True], ~(kept[:-1] & kept[1:]), [True])) | fixed
    gain = np.where(fixed, 0.0, same_effort)
    gain[~free] = np.interp(x_m[~free], x_m[free], gain[free])
    limit_mps = line.limit_mps[line.step_at(x_m)]
    limit_w = np.maximum(np.minimum(limit_mps, np.roll(limit_mps, 1)) ** 2, w)
    followed = np.clip(w + gain, (1.0 - _MOST_TAKEN) * w, limit_w)
    _cap_at_drops(train, w, effort_n, followed)
    change_w = np.where(bound, np.diff(w), np.diff(w + same_effort))
    spare_w = 2.0 * _SPARE / train.inertia_kg * np.abs(effort_n) * np.diff(x_m)
    least_n = _SMALL_SHARE * train.traction_limit.effort_n(0.0)
    rise_w = np.where((effort_n > -least_n) & ~held, change_w + spare_w, np.inf)
    fall_w = np.where((effort_n < least_n) & ~held, spare_w - change_w, np.inf)
    _keep_within_effort(followed, rise_w, fall_w)
    return x_m, followed


def _cut(train: Train, line: ResolvedLine, x_m: Floats, w: Floats) -> tuple[Floats, Floats]:
    """Cut rows along which the difference to the true run bends."""
    ends = line.gain(x_m, w)
    shares = np.array([0.25, 0.5, 0.75])[:, None]
    middle_m = x_m[:-1] + shares * np.diff(x_m)
    middle_w = w[:-1] + shares * np.diff(w)
    gain = line.gain(middle_m.ravel(), middle_w.ravel()).reshape(middle_m.shape)
    bend = np.abs(gain - ends[:-1] - shares * np.diff(ends)) / middle_w
    parts = np.ceil(np.sqrt(bend.max(axis=0) / _BEND)).clip(1, _MOST_PARTS).astype(np.int64)
    row = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(row)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[row]
    step = line.step_at(0.5 * (x_m[:-1] + x_m[1:]))
    cut_w = np.append(np.empty(len(row)), w[-1])
    _cut_evenly(kernel_train(train), np.diff(x_m), line.grade_n[step], line.air[step], w, row, share, cut_w)
    return np.append(x_m[row] + share * np.diff(x_m)[row], x_m[-1]), cut_w


@kernel
def _cut_evenly(train, length_m, grade_n, air, w, row, share, cut_w):
    """Squared speeds at shares of rows: the effort keeps its share of the limit if it is full, its value if not."""
    for i in range(row.shape[0]):
        k = row[i]
        cut_w[i] = w[k] + share[i] * (w[k + 1] - w[k])
        acceleration = 0.5 * (w[k + 1] - w[k]) / length_m[k]
        v0 = math.sqrt(w[k])
        v1 = math.sqrt(w[k + 1])
        v = math.sqrt(cut_w[i])
        resistance = mean_resistance(train, air[k], v0, v1)
        effort = train.inertia_kg * acceleration + resistance + grade_n[k]
        if (effort < 0.0 and train.rates.shape[0] > 0) or share[i] == 0.0:
            continue
        if acceleration >= (1.0 - _AT_LIMIT) * train.max_acceleration:
            continue
        if -acceleration >= (1.0 - _AT_LIMIT) * train.max_deceleration:
            continue
        change = resistance - mean_resistance(train, air[k], v0, v)
        limit = mean_effort(train.traction, v0, v1) if effort >= 0.0 else mean_brake(train, 0.0, v0, v1)
        if abs(effort) >= FULL_EFFORT * limit and limit > 0.0:
            limit_before = mean_effort(train.traction, v0, v) if effort >= 0.0 else mean_brake(train, 0.0, v0, v)
            change += effort * (limit_before / limit - 1.0)
        cut_w[i] += 2.0 / train.inertia_kg * share[i] * length_m[k] * change


def _efforts_n(train: Train, line: ResolvedLine, x_m: Floats, w: Floats) -> Floats:
    """Mean effort between rows on the steps, N, (n − 1,)."""
    step = line.step_at(0.5 * (x_m[:-1] + x_m[1:]))
    mean_w = 0.5 * (w[:-1] + w[1:])
    resistance_n = train.davis_a_n + train.davis_b_n_per_mps * np.sqrt(mean_w) + line.air[step] * mean_w
    return np.asarray(train.inertia_kg * 0.5 * np.diff(w) / np.diff(x_m) + resistance_n + line.grade_n[step])


def _kept(
    train: Train, x_m: Floats, w: Floats, effort_n: Floats
) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether acceleration or speed is kept between rows, (n − 1,) each, and the rows whose speed stays, (n,)."""
    gain_mps2 = 0.5 * np.diff(w) / np.diff(x_m)
    mean_mps = np.sqrt(0.5 * (w[:-1] + w[1:]))
    bound = np.abs(gain_mps2 / train.max_acceleration_mps2 - 1.0) <= _AT_LIMIT
    bound |= np.abs(gain_mps2 / train.max_deceleration_mps2 + 1.0) <= _AT_LIMIT
    fixed = np.zeros(len(w), dtype=bool)
    if train.braking_rates:
        rates = np.array(train.braking_rates)
        rate = np.searchsorted(rates[:, 0], mean_mps, side="right") - 1
        bound |= np.abs(gain_mps2 / rates[rate, 1] + 1.0) <= _AT_LIMIT
        for break_w in rates[1:, 0] ** 2:
            fixed |= np.abs(w - break_w) <= _SAME_W * break_w
    fixed[1:-1] &= bound[:-1] & bound[1:]
    held = np.abs(np.diff(w)) <= _SAME_W * w[1:]
    limits_n = np.array([_limit_n(train, *row) for row in zip(mean_mps[held], effort_n[held], strict=True)])
    least_n = _COASTING_SHARE * train.traction_limit.effort_n(0.0)
    held[held] = (np.abs(effort_n[held]) <= _SPARE_EFFORT * limits_n) & (np.abs(effort_n[held]) > least_n)
    return bound, held, fixed


def _limit_n(train: Train, speed_mps: float, effort_n: float) -> float:
    """Largest effort of the sign of a given one, N."""
    if effort_n >= 0.0:
        return train.traction_limit.effort_n(speed_mps)
    return np.inf if train.braking_rates else train.dynamic_brake_limit.effort_n(speed_mps) + train.friction_brake_n


def _cap_at_drops(train: Train, w: Floats, effort_n: Floats, followed: Floats) -> None:
    """Carry no run under traction past a drop of the effort curve; ``followed`` in place."""
    pulls = effort_n > 0.0
    near_traction = np.concatenate(([False], pulls)) | np.concatenate((pulls, [False]))
    for drop_mps in train.traction_limit.jumps_mps:
        drop_w = drop_mps**2
        past = near_traction & (w <= drop_w * (1.0 + _SAME_W)) & (followed > drop_w)
        followed[past] = np.maximum(w[past], drop_w * (1.0 - BELOW_DROP))


def _keep_within_effort(w: Floats, rise_w: Floats, fall_w: Floats) -> None:
    """Lower speeds, in place, where w would rise or fall by more than the effort allows along a row."""
    if (np.diff(w) <= rise_w).all() and (-np.diff(w) <= fall_w).all():
        return
    for i in range(len(rise_w) - 1):  # the ends of the run stay
        w[i + 1] = min(w[i + 1], w[i] + rise_w[i])
    for i in range(len(fall_w) - 1, 0, -1):
        w[i] = min(w[i], w[i + 1] + fall_w[i])
