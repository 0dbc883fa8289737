"""The demand model: in each step a part of the available traction or braking force, on the true curves.

The demand formulation, corrected (docs/formulations.md). One step from speed v, all forces taken at its start:

    γ = (F(v, d) − A − B·v − C·v² − M·g·i(s)/1000)/(k·M),   v' = max(0, v + γ·Δt),   s' = s + Δt·(v + v')/2.

i holds gradient and curve, i + 800/ρ, at the place where the step starts. The resistance slows the train when it
brakes, too (the formulation adds it there). The speed limit is a constraint;
v' = min(v_max, …), as printed, would be a brake that costs nothing. The cost of a step is the map at its mean speed,
times Δt.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tgvdp.constants import GRAVITY_MPS2
from tgvdp.formulations.problem.alstom import Floats, force_n, power_w
from tgvdp.formulations.problem.instances import DemandInstance
from tgvdp.formulations.problem.schedule import Check, Schedule

#: Rounding that a speed or a distance may exceed its limit by, relative to the limit.
_ROUNDING = 1e-9


class Step(NamedTuple):
    """What one step leads to: (...) speed in m/s, distance gone in m, cost in J."""

    speed_mps: Floats
    distance_m: Floats
    cost_j: Floats


def slope_permil(instance: DemandInstance, distance_m: ArrayLike) -> Floats:
    """Gradient and curve at (...) distances gone: (...) ‰; the last one goes on beyond the end."""
    s = np.asarray(distance_m, dtype=np.float64)
    if not instance.slopes:
        return np.zeros(s.shape)
    starts, values = np.array(instance.slopes).T
    found: Floats = values[np.searchsorted(starts[1:], s, side="right")]
    return found


def slope_range_permil(instance: DemandInstance) -> tuple[float, float]:
    """Least and largest slope of the line."""
    values = [slope.permil for slope in instance.slopes] or [0.0]
    return min(values), max(values)


def slope_force_n(instance: DemandInstance, slope: ArrayLike) -> Floats:
    """M·g·i/1000: (...) ‰ → (...) N, against the train where positive."""
    return instance.mass_kg * GRAVITY_MPS2 / 1000.0 * np.asarray(slope, dtype=np.float64)


def acceleration_mps2(
    instance: DemandInstance, speed_mps: ArrayLike, demand: ArrayLike, slope: ArrayLike = 0.0
) -> Floats:
    """γ(v, d, i): (...) → (...) m/s²; at standstill the resistance is not yet subtracted away."""
    v = np.asarray(speed_mps, dtype=np.float64)
    a, b, c = instance.davis
    against = a + b * v + c * v * v + slope_force_n(instance, slope)
    gamma: Floats = (force_n(v, demand) - against) / (instance.rotating_factor * instance.mass_kg)
    return gamma


def step(instance: DemandInstance, speed_mps: ArrayLike, demand: ArrayLike, slope: ArrayLike = 0.0) -> Step:
    """One step of the discrete model from (...) speeds with (...) demands, on (...) slopes in ‰."""
    v = np.asarray(speed_mps, dtype=np.float64)
    after = np.maximum(0.0, v + acceleration_mps2(instance, v, demand, slope) * instance.dt_s)
    mean = 0.5 * (v + after)
    power = power_w(mean, demand, instance.p_max_w, instance.cost_ref_mps, instance.alpha)
    return Step(after, mean * instance.dt_s, power * instance.dt_s)


class Motion(NamedTuple):
    """A plan's motion: (..., N+1) speeds in m/s, (...) distance in m, (...) cost in J."""

    speed_mps: Floats
    distance_m: Floats
    cost_j: Floats


def drive(instance: DemandInstance, demand: ArrayLike) -> Motion:
    """Drive (..., N) demands from standstill by the discrete model."""
    d = np.asarray(demand, dtype=np.float64)
    speeds = np.zeros((*d.shape[:-1], d.shape[-1] + 1))
    distance, cost = np.zeros(d.shape[:-1]), np.zeros(d.shape[:-1])
    for i in range(d.shape[-1]):
        done = step(instance, speeds[..., i], d[..., i], slope_permil(instance, distance))
        speeds[..., i + 1] = done.speed_mps
        distance = distance + done.distance_m
        cost = cost + done.cost_j
    return Motion(speeds, distance, cost)


def demand_schedule(instance: DemandInstance, demand: ArrayLike) -> Schedule:
    """Schedule of (N,) demands: speeds, distance, cost, and the violation of each constraint."""
    d = np.asarray(demand, dtype=np.float64)
    motion = drive(instance, d)
    off = abs(float(motion.distance_m) - instance.distance_m) - instance.tol_m
    end = float(motion.speed_mps[-1]) - instance.end_speed_max_mps
    over = float(motion.speed_mps.max()) - instance.vmax_mps
    checks = (
        Check("demand allowed", float(count_forbidden(instance, d)), "steps"),
        Check("distance", _beyond(off, instance.distance_m), "m"),
        Check("end speed", _beyond(end, instance.vmax_mps), "m/s"),
        Check("speed limit", _beyond(over, instance.vmax_mps), "m/s"),
    )
    return Schedule(
        speeds=tuple(motion.speed_mps.tolist()),
        controls=tuple(d.tolist()),
        distance=float(motion.distance_m),
        objective=float(motion.cost_j),
        checks=checks,
    )


def count_forbidden(instance: DemandInstance, demand: Floats) -> int:
    """Number of demands that are no allowed level, or beyond full traction or braking."""
    if instance.levels is None:
        return int(np.count_nonzero(np.abs(demand) > 1.0 + _ROUNDING))
    nearest = np.abs(demand[:, None] - np.array(instance.levels)).min(axis=1)
    return int(np.count_nonzero(nearest > _ROUNDING))


def _beyond(excess: float, scale: float) -> float:
    return excess if excess > _ROUNDING * scale else 0.0
