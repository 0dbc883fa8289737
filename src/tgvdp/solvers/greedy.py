"""A plan without search: what every solver that searches has to beat.

One train of equal steps: from standing still, single levels are moved, each time the one that costs least, until the
distance is right. Trains of a substation: each drives its own cheapest plan, then they take turns beside the others'.
"""

import math
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


def solve_greedy(instance: BinaryInstance | SubstationInstance, allowance: Allowance) -> Solution:
    """Find a plan without search; it proves nothing, and of one train the distance may stay wrong.

    Uses ``time_limit_s``.

    Raises
    ------
    InputError
        When the steps are not equal.
    InfeasibleError
        When no distance of one train lies within the tolerance, or a train of a substation cannot cover its own.
    BudgetExceededError
        When the trains of a substation end above its limit, or at the time limit.
    """
    start = time.perf_counter()
    deadline_s = allowance.deadline_s(start)
    if isinstance(instance, SubstationInstance):
        schedule = _of_trains(instance, deadline_s)
    else:
        schedule = _of_one_train(instance, deadline_s)
    elapsed_s = time.perf_counter() - start
    return Solution("greedy", schedule, False, None, replay(instance, schedule), elapsed_s)


def _of_one_train(instance: BinaryInstance, deadline_s: float) -> Schedule:
    require_unit_steps(instance, "greedy")
    require_distance(instance)
    limits = unit_limits(instance)
    heights = repaired(instance, np.zeros_like(limits), limits, deadline_s)
    return schedule_of_speeds(instance, instance.acc_units * heights)


def _of_trains(instance: SubstationInstance, deadline_s: float) -> Schedule:
    from tgvdp.solvers.exact.joint_descent import settled
    from tgvdp.solvers.exact.joint_prices import SCALE, train_of

    trains = [train_of(train) for train in instance.trains]
    plan = settled(instance, trains, np.full(instance.steps, SCALE, dtype=np.int64), deadline_s)
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


def repaired(instance: BinaryInstance, heights: Ints, limits: Ints, deadline_s: float = math.inf) -> Ints:
    """Move single levels of (N+1,) heights of unit steps until the distance is right or nothing can move.

    Each time the move that raises the objective least, and of equals the earliest.

    Raises
    ------
    BudgetExceededError
        When it is later than ``deadline_s`` by `time.perf_counter`.
    """
    v = heights.copy()
    low, high = unit_distances(instance)
    while not low <= (total := int(v.sum())) <= high:
        if time.perf_counter() > deadline_s:
            raise BudgetExceededError(
                f"{instance.id}: the time limit ended the moves at {total} of {low} steps of the distance"
            )
        sign = 1 if total < low else -1
        moved = v[1:-1] + sign
        fits = (moved <= limits[1:-1]) & (moved >= 0)
        fits &= (np.abs(moved - v[:-2]) <= 1) & (np.abs(moved - v[2:]) <= 1)
        places = np.flatnonzero(fits) + 1
        if not places.size:
            break
        v[_cheapest(instance, v, places, sign)] += sign
    return v


def _cheapest(instance: BinaryInstance, v: Ints, places: Ints, sign: int) -> int:
    """Place of the cheapest move: what it costs depends on the levels beside it alone, of which few differ."""
    base = int(v.max()) + 1
    codes = (v[places - 1] * base + v[places]) * base + v[places + 1]
    first = np.unique(codes, return_index=True)[1]  # the earliest of each
    move = np.array((0, sign, 0))
    ranked: list[tuple[Any, int]] = []
    for place in places[first].tolist():
        before = v[place - 1 : place + 2]
        ranked.append((_exact(instance, before + move) - _exact(instance, before), place))
    return min(ranked)[1]


def _exact(instance: BinaryInstance, heights: Ints) -> Any:
    return features_of_speeds(instance, instance.acc_units * heights).exact()
