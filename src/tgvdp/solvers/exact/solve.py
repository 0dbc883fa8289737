"""The exact solvers as the registry takes them: each ends in a `Solution` that has been replayed.

Durations are those of the solver: kernels are compiled, or loaded from their cache, before the clock starts.
"""

import math
import time
from typing import Any

import numpy as np

from tgvdp.formulations.problem.binary import schedule_of_controls
from tgvdp.formulations.problem.instances import BinaryInstance, DemandInstance, Instance, SubstationInstance
from tgvdp.formulations.problem.levels import ladder_of
from tgvdp.formulations.problem.replay import replay
from tgvdp.formulations.problem.schedule import Schedule, Solution
from tgvdp.formulations.problem.substation import substation_schedule, to_j_per_kg
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.exact.brute_force import best_plans
from tgvdp.solvers.exact.closed_form import closed_form


def solve_dp(instance: Instance, _: Allowance) -> Solution:
    """Dynamic program over (step, speed, distance), of all trains at once, with the number of optima."""
    from tgvdp.solvers.exact.dynamic_program import load_kernels, optimal_plan

    if isinstance(instance, DemandInstance):
        from tgvdp.solvers.exact.demand_search import solve_demand_dp

        return solve_demand_dp(instance)
    if isinstance(instance, SubstationInstance):
        return _solve_joint(instance)
    load_kernels()
    started = time.perf_counter()
    ladder = ladder_of(instance)
    found = optimal_plan(ladder)
    schedule = schedule_of_controls(instance, np.sign(np.diff(found.levels)))
    elapsed_s = time.perf_counter() - started
    details = {"bound": ladder.objective(math.ceil(found.bound - 1e-6)), "states": found.states}
    return _proved("dp", instance, schedule, found.n_optimal, elapsed_s, details)


def _solve_joint(instance: SubstationInstance) -> Solution:
    from tgvdp.solvers.exact.joint import joint_plan

    started = time.perf_counter()
    found = joint_plan(instance)
    schedule = substation_schedule(instance, found.speeds)
    elapsed_s = time.perf_counter() - started
    details = {"bound": to_j_per_kg(instance, found.bound), "states": found.states}
    return Solution(
        "dp", schedule, found.proved, found.n_optimal, replay(instance, schedule), elapsed_s, details=details
    )


def solve_brute(instance: Instance, _: Allowance) -> Solution:
    """All plans of a small instance, with the number of optima."""
    if isinstance(instance, DemandInstance):
        from tgvdp.solvers.exact.demand_search import solve_demand_brute

        return solve_demand_brute(instance)
    assert isinstance(instance, BinaryInstance)
    started = time.perf_counter()
    plans, _objective = best_plans(instance)
    schedule = schedule_of_controls(instance, plans[-1])
    elapsed_s = time.perf_counter() - started
    return _proved("brute", instance, schedule, len(plans), elapsed_s, {"plans": 3**instance.steps})


def solve_closed(instance: Instance, _: Allowance) -> Solution:
    """The closed form, where it applies; it does not count."""
    assert isinstance(instance, BinaryInstance)
    started = time.perf_counter()
    schedule = schedule_of_controls(instance, closed_form(instance))
    elapsed_s = time.perf_counter() - started
    return _proved("closed", instance, schedule, None, elapsed_s, {})


def _proved(
    solver: str,
    instance: BinaryInstance,
    schedule: Schedule,
    n_optimal: int | None,
    elapsed_s: float,
    details: dict[str, Any],
) -> Solution:
    return Solution(solver, schedule, True, n_optimal, replay(instance, schedule), elapsed_s, details=details)
