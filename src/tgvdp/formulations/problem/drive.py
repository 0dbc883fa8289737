"""Drive the controls of a binary plan in SI: constant acceleration in each step, and nothing else is trusted."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from tgvdp.formulations.problem.instances import BinaryInstance

#: Rounding of sums of a few thousand steps, relative to the largest speed or distance.
_ROUNDING = 1e-9


class Driven(NamedTuple):
    """What controls really do.

    Attributes
    ----------
    speeds : list of float
        v_0..v_N, m/s.
    gains : list of float
        Kinetic energy that each step adds, J/kg.
    distance_m, distance_error_m, overspeed_mps : float
    feasible : bool
    """

    speeds: list[float]
    gains: list[float]
    distance_m: float
    distance_error_m: float
    overspeed_mps: float
    feasible: bool


def drive(instance: BinaryInstance, controls: Sequence[float]) -> Driven:
    """Drive the controls u of a plan with constant acceleration u·Δv/Δt in each step."""
    dt_s, dv_mps = instance.dt_s, instance.dv_mps
    time_speed_distance = [(0.0, 0.0)]
    for u in controls:
        v, s = time_speed_distance[-1]
        acceleration = u * dv_mps / dt_s
        time_speed_distance.append((v + acceleration * dt_s, s + v * dt_s + 0.5 * acceleration * dt_s**2))
    speeds = [v for v, _ in time_speed_distance]
    top = max(map(abs, speeds)) + dv_mps
    distance_m = time_speed_distance[-1][1]
    distance_error_m = distance_m - instance.distance_units * dv_mps * dt_s
    overspeed_mps = max(v - cap * dv_mps for v, cap in zip(speeds[1:], instance.cap_units, strict=True))
    allowed = {instance.acc_units, 0, -instance.dec_units}
    feasible = (
        abs(distance_error_m) <= instance.tol_units * dv_mps * dt_s + _ROUNDING * (abs(distance_m) + top * dt_s)
        and abs(speeds[-1]) <= _ROUNDING * top
        and min(speeds) >= -_ROUNDING * top
        and overspeed_mps <= _ROUNDING * top
        and all(u in allowed for u in controls)
    )
    gains = [0.5 * (after**2 - before**2) for before, after in pairwise(speeds)]
    return Driven(speeds, gains, distance_m, distance_error_m, max(0.0, overspeed_mps), feasible)
