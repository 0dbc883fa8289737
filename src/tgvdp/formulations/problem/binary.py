"""The binary model itself: motion, distance, objective and constraints of a plan of accelerations and brakings.

The binary formulation, corrected (docs/formulations.md). With bits x_i (accelerate) and y_i (brake), i = 0..N−1,
acceleration step a and braking step b in units of Δv:

    v_0 = 0,  v_{i+1} = v_i + a·x_i − b·y_i,   0 ≤ v_k ≤ h_k,   v_N = 0,   x_i·y_i = 0,   |Σ distance − D| ≤ tol.

Everything is a whole number in units of Δv and Δv·Δt, so that feasibility and ties are exact; SI comes in at the end.
The formulation sums to N_c inclusive in places, which describes a model of one step more; here N controls make N steps.
"""

import warnings
from fractions import Fraction
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tgvdp.formulations.problem.instances import BinaryInstance, decimal
from tgvdp.formulations.problem.schedule import Check, Schedule

Ints: TypeAlias = NDArray[np.int64]
DistanceRule: TypeAlias = Literal["trapezoid", "left", "right"]

#: What the train moves in the step that starts at control i, per unit of control, in units of half a Δv·Δt:
#: left counts v_i, right v_{i+1} (method 1 of the formulation), trapezoid their mean (method 2, "trapeze").
_HALF_STEPS_LATER: dict[str, int] = {"left": -2, "trapezoid": -1, "right": 0}

SPEED_UNIT, DISTANCE_UNIT = "Δv", "Δv·Δt"


class FormulationWarning(UserWarning):
    """The model is well defined, but not what its author will have had in mind."""


def changes(instance: BinaryInstance, x: ArrayLike, y: ArrayLike) -> Ints:
    """Change of speed u = a·x − b·y of each step: (..., N) bits → (..., N) int64, in Δv."""
    x, y = np.asarray(x, dtype=np.int64), np.asarray(y, dtype=np.int64)
    u: Ints = instance.acc_units * x - instance.dec_units * y
    return u


def speeds(instance: BinaryInstance, x: ArrayLike, y: ArrayLike) -> Ints:
    """Speeds v_0..v_N: (..., N) bits → (..., N+1) int64, in Δv."""
    u = changes(instance, x, y)
    start = np.zeros((*u.shape[:-1], 1), dtype=np.int64)
    return np.concatenate((start, np.cumsum(u, axis=-1)), axis=-1)


def level_counts(instance: BinaryInstance) -> tuple[int, ...]:
    """Most levels of v_0..v_N, in steps of acceleration, that equal steps can reach and leave in time."""
    unit, steps = instance.acc_units, instance.steps
    return (0, *(min(k, steps - k, cap // unit) for k, cap in enumerate(instance.cap_units[:-1], start=1)), 0)


def distance_weights(steps: int, rule: DistanceRule = "trapezoid") -> Ints:
    """Twice the distance, in Δv·Δt, that a change of speed of one Δv in step i adds until the end: (N,) int64.

    left 2(N−1−i), trapezoid 2(N−i)−1, right 2(N−i). The printed N−i+½ of the trapezoid counts Δt·v_N too much.
    """
    return 2 * (steps - np.arange(steps, dtype=np.int64)) + _HALF_STEPS_LATER[rule]


def half_distance(instance: BinaryInstance, x: ArrayLike, y: ArrayLike, rule: DistanceRule = "trapezoid") -> Ints:
    """Twice the distance: (..., N) bits → (...) int64, in Δv·Δt. All rules agree where the train ends at standstill."""
    total: Ints = changes(instance, x, y) @ distance_weights(instance.steps, rule)
    return total


class Features(NamedTuple):
    """An objective as p·first − q·second of two whole numbers, so that equal objectives compare equal.

    Attributes
    ----------
    first, second : (...) int64
    p, q : Fraction
        The objective is Δv²·(p·first − q·second), in (m/s)².
    """

    first: Ints
    second: Ints
    p: Fraction
    q: Fraction

    def exact(self, index: Any = ()) -> Fraction:
        """Objective in Δv² of one entry."""
        return self.p * int(self.first[index]) - self.q * int(self.second[index])


def features(instance: BinaryInstance, x: ArrayLike, y: ArrayLike) -> Features:
    """Objective of bit strings (..., N), feasible or not.

    constant: a²·Σx − α·b²·Σy. kinetic: Σ x·a·(v + a/2) − α·Σ y·b·(v − b/2), the kinetic energy that traction puts in
    and braking takes out. efficiency: η0·Σs − Δη·Σs² with s_i = v_{i+1}.
    """
    x, y = np.asarray(x, dtype=np.int64), np.asarray(y, dtype=np.int64)
    a, b, alpha = instance.acc_units, instance.dec_units, decimal(instance.alpha)
    if instance.model == "constant":
        return Features(x.sum(-1), y.sum(-1), Fraction(a * a), alpha * b * b)
    v = speeds(instance, x, y)
    if instance.model == "kinetic":
        drawn = (x * a * (2 * v[..., :-1] + a)).sum(-1)
        returned = (y * b * (2 * v[..., :-1] - b)).sum(-1)
        return Features(drawn, returned, Fraction(1, 2), alpha / 2)
    s = v[..., 1:]
    return Features(s.sum(-1), (s * s).sum(-1), decimal(instance.eta0), decimal(instance.deta))


def in_model_units(instance: BinaryInstance, exact: Fraction) -> float:
    """Turn an objective in Δv² into (m/s)², rounded once."""
    return float(exact * decimal(instance.dv_mps) ** 2)


def features_of_speeds(instance: BinaryInstance, v: Ints) -> Features:
    """Objective of speeds (N+1,): as `features` where they follow from steps, and steps of several levels elsewhere."""
    if instance.model == "efficiency":
        return Features(v[1:].sum(), (v[1:] * v[1:]).sum(), decimal(instance.eta0), decimal(instance.deta))
    a, b, alpha = instance.acc_units, instance.dec_units, decimal(instance.alpha)
    gain = np.diff(v if instance.model == "constant" else v * v)
    up, down = np.maximum(gain, 0).sum(), np.maximum(-gain, 0).sum()
    if instance.model == "constant":
        return Features(up, down, Fraction(a), alpha * b)
    return Features(up, down, Fraction(1, 2), alpha / 2)


def schedule_of_speeds(instance: BinaryInstance, speeds: ArrayLike, extra: tuple[Check, ...] = ()) -> Schedule:
    """Schedule of (N+1,) speeds in Δv, whether or not single steps connect them."""
    v = np.asarray(speeds, dtype=np.int64)
    u = np.diff(v)
    odd = np.count_nonzero((u != 0) & (u != instance.acc_units) & (u != -instance.dec_units))
    actions = Check("one action per step", float(odd), "steps")
    objective = in_model_units(instance, features_of_speeds(instance, v).exact())
    return _schedule(instance, v, u, int((v[:-1] + v[1:]).sum()), objective, (actions, *extra))


def schedule_of(instance: BinaryInstance, x: ArrayLike, y: ArrayLike, extra: tuple[Check, ...] = ()) -> Schedule:
    """Decode bits into speeds, distance, objective, and the violation of each constraint.

    Parameters
    ----------
    instance : BinaryInstance
    x, y : (N,) of 0 and 1
    extra : tuple of Check
        What an encoding asks of its bits besides the constraints of the instance.
    """
    x, y = np.asarray(x, dtype=np.int64), np.asarray(y, dtype=np.int64)
    actions = Check("one action per step", float((x & y).sum()), "steps")
    objective = in_model_units(instance, features(instance, x, y).exact())
    half = int(half_distance(instance, x, y))
    v = speeds(instance, x, y)
    return _schedule(instance, v, changes(instance, x, y), half, objective, (actions, *extra))


def _schedule(
    instance: BinaryInstance, v: Ints, u: Ints, half: int, objective: float, first: tuple[Check, ...]
) -> Schedule:
    checks = (
        *first,
        Check("distance", _distance_violation(instance, half), DISTANCE_UNIT),
        Check("stop at the end", float(abs(v[-1])), SPEED_UNIT),
        Check("speed not negative", float(max(0, -int(v.min()))), SPEED_UNIT),
        Check("speed limit", float(max(0, int((v[1:] - np.array(instance.cap_units)).max()))), SPEED_UNIT),
    )
    return Schedule(
        speeds=tuple(v.tolist()),
        controls=tuple(u.tolist()),
        distance=half / 2,
        objective=objective,
        checks=checks,
    )


def schedule_of_controls(instance: BinaryInstance, signs: ArrayLike) -> Schedule:
    """Schedule of (N,) signs: +1 accelerates, 0 holds, −1 brakes."""
    signs = np.asarray(signs)
    return schedule_of(instance, signs > 0, signs < 0)


def _distance_violation(instance: BinaryInstance, half: int) -> float:
    off = abs(Fraction(half, 2) - decimal(instance.distance_units)) - decimal(instance.tol_units)
    return float(max(off, Fraction(0)))


def warn_of_oddities(instance: BinaryInstance) -> None:
    """Warn where the instance's objective is not what it looks like."""
    a, b = instance.acc_units, instance.dec_units
    if instance.model == "constant" and a != b and decimal(instance.alpha) * b > a:
        _warn(instance, f"braking gives back more than traction takes (alpha·{b} > {a}): use the kinetic model")
    if instance.model == "efficiency":
        _warn_of_efficiency(instance)


def _warn_of_efficiency(instance: BinaryInstance) -> None:
    top = max(instance.cap_units[:-1], default=0)
    least = decimal(instance.eta0) - decimal(instance.deta) * top
    if not (0 <= least <= 1 and 0 <= instance.eta0 <= 1):
        _warn(instance, f"the efficiency factor leaves [0, 1]: {instance.eta0:g} at rest, {float(least):g} at {top} Δv")
    if instance.alpha:
        _warn(instance, "alpha has no part in the efficiency model")
    if not instance.tol_units:
        _warn(instance, "distance and end speed are fixed, so the efficiency model only maximises Σv²")


def _warn(instance: BinaryInstance, message: str) -> None:
    warnings.warn(f"{instance.id}: {message}", FormulationWarning, stacklevel=4)
