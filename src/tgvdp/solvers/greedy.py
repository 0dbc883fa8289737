"""A plan without search: what every solver that searches has to beat.

One train of equal steps: from standing still, single levels are moved, each time the one that costs least, until the
distance is right. Trains of a substation: each drives its own cheapest plan, then they take turns beside the others'.
"""

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.formulations.problem.binary import features_of_speeds, schedule_of_speeds
from tgvdp.formulations.problem.instances import BinaryInstance, SubstationInstance
from tgvdp.formulations.problem.replay import replay
from tgvdp.formulations.problem.schedule import Schedule, Solution
from tgvdp.formulations.problem.substation import substation_schedule
from tgvdp.solvers.allowance import Allowance

Ints = NDArray[np.int64]


def solve_greedy(instance: BinaryInstance | SubstationInstance, _: Allowance) -> Solution:
    """Find a plan without search; it proves nothing, and of one train the distance may stay wrong.

    Raises
    ------
    InputError
        When the steps are not equal.
    InfeasibleError
        When no distance of one train lies within the tolerance, or a train of a substation cannot cover its own.
    BudgetExceededError
        When the trains of a substation end above its limit.
    """
    start = time.perf_counter()
    schedule = _of_trains(instance) if isinstance(instance, SubstationInstance) else _of_one_train(instance)
    elapsed_s = time.perf_counter() - start
    return Solution("greedy", schedule, False, None, replay(instance, schedule), elapsed_s)


def _of_one_train(instance: BinaryInstance) -> Schedule:
    require_unit_steps(instance, "greedy")
    require_distance(instance)
    limits = unit_limits(instance)
    return schedule_of_speeds(instance, instance.acc_units * repaired(instance, np.zeros_like(limits), limits))


def _of_trains(instance: SubstationInstance) -> Schedule:
    from tgvdp.solvers.exact.joint_descent import settled
    from tgvdp.solvers.exact.joint_prices import SCALE, train_of

    trains = [train_of(train) for train in instance.trains]
    plan = settled(instance, trains, np.full(instance.steps, SCALE, dtype=np.int64))
    for number, (train, speeds) in enumerate(zip(instance.trains, plan, strict=True), start=1):
        # Each is driven exactly, at any cost: what does not arrive cannot.
        if not schedule_of_speeds(train.trip, speeds).feasible:
            raise InfeasibleError(f"{instance.id}: train {number} alone cannot cover its distance in its time")
    schedule = substation_schedule(instance, plan)
    if not schedule.feasible:
        raise BudgetExceededError(f"{instance.id}: the trains took turns, and end above the limit of the substation")
    return schedule


def require_unit_steps(instance: BinaryInstance, solver: str) -> None:
    """Refuse an instance that brakes by other steps than it accelerates."""
    if instance.acc_units != instance.dec_units:
        raise InputError(f"{instance.id}: solver {solver} needs equal steps")


def require_distance(instance: BinaryInstance) -> None:
    """Refuse an instance whose tolerance holds no distance of equal steps: no plan has one, however levels move."""
    low, high = unit_distances(instance)
    if low > high:
        raise InfeasibleError(f"{instance.id}: no distance of whole steps lies within the tolerance")


def unit_distances(instance: BinaryInstance) -> tuple[int, int]:
    """Least and largest distance in steps of the speed."""
    least, most = instance.distance_range
    return -(-least // instance.acc_units), most // instance.acc_units


def unit_limits(instance: BinaryInstance) -> Ints:
    """Highest level after each step 0..N that can be reached and left again."""
    steps, unit = instance.steps, instance.acc_units
    caps = [0, *(cap // unit for cap in instance.cap_units[:-1]), 0]
    return np.array([min(k, steps - k, caps[k]) for k in range(steps + 1)], dtype=np.int64)


def repaired(instance: BinaryInstance, heights: Ints, limits: Ints) -> Ints:
    """Move single levels of (N+1,) heights of unit steps until the distance is right or nothing can move.

    Each time the move that raises the objective least, and of equals the earliest.
    """
    v = heights.copy()
    low, high = unit_distances(instance)
    while not low <= (total := int(v.sum())) <= high:
        sign = 1 if total < low else -1
        moved = v[1:-1] + sign
        fits = (moved <= limits[1:-1]) & (moved >= 0)
        fits &= (np.abs(moved - v[:-2]) <= 1) & (np.abs(moved - v[2:]) <= 1)
        places = np.flatnonzero(fits) + 1
        if not places.size:
            break
        plans = np.repeat(v[None], places.size, axis=0)
        plans[np.arange(places.size), places] += sign
        v = plans[int(np.argmin([_exact(instance, plan) for plan in plans]))]
    return v


def _exact(instance: BinaryInstance, heights: Ints) -> Any:
    return features_of_speeds(instance, instance.acc_units * heights).exact()
