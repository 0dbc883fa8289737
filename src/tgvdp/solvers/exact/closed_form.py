"""The optimum in closed form, where one is known: ground truth at any N.

Equal steps a = b, one cap h for all steps, an exact distance D' = D/a, and the constant or the kinetic objective. Plans
of n accelerations cover at least n and at most n·(N−n), and a top speed of n−1 at most (n−1)·(N−n+1). So n* = min{n : n
≤ D' ≤ n·(N−n), n ≤ min(h, ⌊N/2⌋)} accelerations are needed, and they are enough: E* = (1−α)·a²·n* for the constant
model, (1−α)·a²·n*²/2 for the kinetic one.
"""

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError, InputError
from tgvdp.formulations.problem.instances import BinaryInstance


def closed_form(instance: BinaryInstance) -> NDArray[np.int8]:
    """An optimal plan: (N,) int8, +1 accelerates, 0 holds, −1 brakes.

    Accelerate n* times, hold, brake n* times; the first braking comes earlier by what n*·(N−n*) exceeds D'. As n*−1 is
    not enough, that is at most N−2n*, the number of steps that hold.

    Raises
    ------
    InputError
        When the closed form does not apply.
    InfeasibleError
        When no plan satisfies all constraints.
    """
    _require_applicable(instance)
    steps, unit = instance.steps, instance.acc_units
    most = min(min(instance.cap_units[:-1], default=0) // unit, steps // 2)
    distance, remainder = divmod(instance.distance_range[0], unit)
    exact = remainder == 0 and instance.distance_range[0] == instance.distance_range[1]
    fits = [n for n in range(most + 1) if n <= distance <= n * (steps - n)] if exact else []
    if not fits:
        raise InfeasibleError(
            f"{instance.id}: no n ≤ {most} has n ≤ D' ≤ n·(N − n), "
            f"where D' = {instance.distance_units / unit:.9g} and N = {steps}"
        )
    n = fits[0]
    plan = np.zeros(steps, dtype=np.int8)
    plan[:n], plan[steps - n :] = 1, -1
    if n:
        excess = n * (steps - n) - distance
        plan[steps - n] = 0
        plan[steps - n - excess] = -1
    return plan


def _require_applicable(instance: BinaryInstance) -> None:
    reasons = {
        "the efficiency model": instance.model == "efficiency",
        "unequal steps of acceleration and braking": instance.acc_units != instance.dec_units,
        "speed limits that vary": len(set(instance.cap_units[:-1])) > 1,
        "a tolerance on the distance": instance.tol_units > 0.0,
    }
    for reason, holds in reasons.items():
        if holds:
            raise InputError(f"{instance.id}: no closed form is known for {reason}; use --solver dp")
