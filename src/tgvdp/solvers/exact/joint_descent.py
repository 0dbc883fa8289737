"""A plan of all trains of a substation by descent: one train after the other is solved exactly while the others stay.

Each train alone is a dynamic program over (step, speed, distance); what the others draw and offer is then known, so
that each of its steps costs what it adds to what the substation delivers, and much more where it exceeds the limit.
Starting from plans under random prices, the trains take turns until none of them can save. It proves nothing.
"""

import math
import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import BudgetExceededError
from tgvdp.formulations.problem.instances import SubstationInstance
from tgvdp.formulations.problem.substation import delivered, joint_speeds, shares
from tgvdp.solvers.exact.joint_prices import NEVER, SCALE, Ints, Train, cheapest_speeds, costs_to_go, priced

#: Starts, and the cost of a unit above the limit over that of a unit delivered.
_STARTS, _EXCESS = 12, 1000
_SEED = 1


def descend(instance: SubstationInstance, trains: Sequence[Train], prices: Ints) -> list[Ints] | None:
    """Find a cheap plan.

    Parameters
    ----------
    prices : (steps,) int64
        Of energy in each step, times `SCALE`: where the descent starts from, at first as they are, then disturbed.

    Returns
    -------
    list of (N_k+1,) int64, or None
        Speeds of each train in Δv; None where every descent ends above the limit.
    """
    rng = np.random.default_rng(_SEED)
    q = shares(instance).q
    best: list[Ints] | None = None
    least = int(NEVER)
    for start in range(_STARTS):
        noise = rng.uniform(0.0, 2.0, instance.steps) if start else np.ones(instance.steps)
        plan = settled(instance, trains, np.rint(np.maximum(prices, SCALE // 8) * noise).astype(np.int64))
        net = delivered(instance, joint_speeds(instance, plan))
        if net.max() <= q * instance.power_units and int(net.sum()) < least:
            best, least = plan, int(net.sum())
    return best


def settled(
    instance: SubstationInstance, trains: Sequence[Train], prices: Ints, deadline_s: float = math.inf
) -> list[Ints]:
    """Trains take turns until a whole round saves nothing.

    Raises
    ------
    BudgetExceededError
        When it is later than ``deadline_s`` by `time.perf_counter`.
    """
    plan = [_alone(one, priced(instance, one, prices)) for one in trains]
    best = int(NEVER)
    while True:
        for k, one in enumerate(trains):
            if time.perf_counter() > deadline_s:
                raise BudgetExceededError(f"{instance.id}: the time limit ended before all trains had their turns")
            rest = [np.zeros_like(v) if i == k else v for i, v in enumerate(plan)]
            plan[k] = _alone(one, _added(instance, one, rest))
        cost = int(_charged(instance, delivered(instance, joint_speeds(instance, plan))).sum())
        if cost >= best:
            return plan
        best = cost


def _added(instance: SubstationInstance, one: Train, rest: Sequence[Ints]) -> NDArray[np.int64]:
    """Cost (N, 3, levels) of each action beside the other trains, whose speeds are given."""
    p, q = shares(instance)
    table = joint_speeds(instance, rest)
    mass = np.array([[train.mass_units] for train in instance.trains])
    gained = (mass * np.diff(table * table, axis=1))[:, one.train.start : one.train.start + one.train.trip.steps]
    other = (q * np.maximum(gained, 0) - p * np.maximum(-gained, 0)).sum(0)[:, None]
    cost = np.zeros((one.train.trip.steps, 3, one.levels), dtype=np.int64)
    for action, own in enumerate((-p * one.offered, np.zeros(one.levels, dtype=np.int64), q * one.drawn)):
        cost[:, action] = _charged(instance, np.maximum(other + own, 0))
    return cost


def _charged(instance: SubstationInstance, net: Ints) -> Ints:
    over: Ints = net + _EXCESS * np.maximum(net - shares(instance).q * instance.power_units, 0)
    return over


def _alone(one: Train, cost: Ints) -> Ints:
    """Cheapest speeds (N+1,) of one train for given costs of its actions."""
    return cheapest_speeds(one, cost, costs_to_go(one, cost))
