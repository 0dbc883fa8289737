"""Replay of demands on the true curves: by the model's own time step, and by fine ones beside it."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from tgvdp.formulations.problem.alstom import force_n, power_w
from tgvdp.formulations.problem.demand import acceleration_mps2, count_forbidden, slope_permil
from tgvdp.formulations.problem.instances import DemandInstance

#: Steps of the fine replay for each step of the model.
FINE_STEPS = 200
_ROUNDING = 1e-9


def replay_demand(instance: DemandInstance, demand: Sequence[float]) -> dict[str, Any]:
    """Drive demands; see `tgvdp.formulations.problem.replay.replay`.

    The figures of the model's own step are those that its constraints speak of. ``fine`` holds the same demands driven
    by steps 200 times as fine, with forces that follow the speed: how far the model is from the train. There the train
    may stop early, or not at all. ``mechanical_j`` is the work of traction at the wheel, which a cost map that
    conserves energy cannot be below.
    """
    result = _drive(instance, demand, 1)
    result["fine"] = _drive(instance, demand, FINE_STEPS)
    return result


def _drive(instance: DemandInstance, demand: Sequence[float], parts: int) -> dict[str, Any]:
    dt = instance.dt_s / parts
    v, s, cost, work, top = 0.0, 0.0, 0.0, 0.0, 0.0
    for d in demand:
        for _ in range(parts):
            after = max(0.0, v + float(acceleration_mps2(instance, v, d, slope_permil(instance, s))) * dt)
            mean = 0.5 * (v + after)
            s += mean * dt
            cost += float(power_w(mean, d, instance.p_max_w, instance.cost_ref_mps, instance.alpha)) * dt
            work += max(0.0, float(force_n(v, d))) * mean * dt
            v = after
            top = max(top, v)
    error_m = s - instance.distance_m
    feasible = (
        abs(error_m) <= instance.tol_m + _ROUNDING * instance.distance_m
        and v <= instance.end_speed_max_mps + _ROUNDING * instance.vmax_mps
        and top <= instance.vmax_mps * (1.0 + _ROUNDING)
        and count_forbidden(instance, np.asarray(demand, dtype=np.float64)) == 0
    )
    return {
        "feasible": feasible,
        "objective": cost,
        "energy": cost,
        "energy_unit": "J",
        "mechanical_j": work,
        "distance_m": s,
        "distance_error_m": error_m,
        "end_speed_error_mps": v,
        "overspeed_mps": max(0.0, top - instance.vmax_mps),
    }
