"""SCIP, through pyscipopt: programs with products, exactly for the binary model, approximately for the demand model."""

import time
from collections.abc import Callable, Mapping
from math import isinf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import BudgetExceededError, InfeasibleError, TgvdpError
from tgvdp.formulations.problem.instances import DemandInstance, Instance
from tgvdp.formulations.problem.replay import replay
from tgvdp.formulations.problem.schedule import Schedule, Solution
from tgvdp.formulations.program.binary import Products, Program, Terms, binary_program
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.extras import extra
from tgvdp.solvers.programs.milp import program_solution


class Solved(NamedTuple):
    """What SCIP found.

    Attributes
    ----------
    values : (n,) float64
        Of the program's variables.
    bound : float
        Proved lower bound of the objective, in the program's unit.
    proved : bool
        Whether it is the objective, within SCIP's tolerances.
    details : mapping
    """

    values: NDArray[np.float64]
    bound: float
    proved: bool
    details: Mapping[str, Any]


def solve_scip(instance: Instance, allowance: Allowance) -> Solution:
    """Solve the quadratic program of an instance; uses ``form`` and ``time_limit_s``.

    The optimum of a binary instance is one of the model. That of a demand instance is one of its quadratic
    approximation, so it is never called optimal: its demands are driven on the true curves, and may miss a constraint.

    Raises
    ------
    InfeasibleError
        When no plan obeys all constraints; of a binary instance only.
    BudgetExceededError
        When the time limit ends before there is a plan, or the approximation of a demand instance has none.
    """
    start = time.perf_counter()
    if isinstance(instance, DemandInstance):
        return _solve_demand(instance, allowance, start)
    program = binary_program(instance, "quadratic")
    solved = optimise(program, allowance.time_limit_s)
    elapsed_s = time.perf_counter() - start
    return program_solution("scip", instance, program, solved.values, solved.bound, elapsed_s, solved.details)


def _solve_demand(instance: DemandInstance, allowance: Allowance, start: float) -> Solution:
    from tgvdp.formulations.problem.demand import demand_schedule
    from tgvdp.formulations.program.demand import demand_program

    written = demand_program(instance, allowance.form or "split")

    def schedule(values: NDArray[np.float64]) -> Schedule:
        return demand_schedule(instance, written.demands(values))

    return approximate_solution("scip", instance, written.program, schedule, allowance, start)


def approximate_solution(
    solver: str,
    instance: DemandInstance,
    program: Program,
    decode: Callable[[NDArray[np.float64]], Schedule],
    allowance: Allowance,
    start: float,
) -> Solution:
    """Solve an approximation of a demand instance; ``decode`` drives its demands on the true curves.

    Raises
    ------
    BudgetExceededError
        When the time limit ends before there is a plan, or the approximation has none.
    """
    try:
        solved = optimise(program, allowance.time_limit_s)
    except InfeasibleError:
        raise BudgetExceededError(
            f"{instance.id}: SCIP found no plan: its quadratic approximation has none, which proves nothing about the "
            "demand model itself (solver dp searches that)"
        ) from None
    elapsed_s = time.perf_counter() - start
    schedule = decode(solved.values)
    return Solution(
        solver=solver,
        schedule=schedule,
        optimal=False,
        n_optimal=None,
        replay=replay(instance, schedule),
        elapsed_s=elapsed_s,
        details={
            "approximation": allowance.form or "split",
            "approximate_objective_j": _objective(program, solved.values),
            "approximate_bound_j": solved.bound,
            "approximate_optimum_proved": solved.proved,
            **solved.details,
        },
    )


def optimise(program: Program, time_limit_s: float | None) -> Solved:
    """Solve a program to a gap of zero, or until the time limit.

    Raises
    ------
    InfeasibleError
        When SCIP proves that no plan obeys all rows.
    BudgetExceededError
        When the time limit ends before there is a plan.
    """
    scip = extra("pyscipopt", "solver scip")
    model = scip.Model(program.name)
    model.hideOutput()
    if time_limit_s is not None:
        model.setParam("limits/time", time_limit_s)
    variables = [model.addVar(one.name, "I" if one.integer else "C", one.lower, one.upper) for one in program.variables]
    for row in program.rows:
        body = _sum(scip, variables, row.linear, row.products)
        if row.lower == row.upper:
            model.addCons(body == row.lower, row.name)
            continue
        if not isinf(row.lower):
            model.addCons(body >= row.lower, f"{row.name}_least")
        if not isinf(row.upper):
            model.addCons(body <= row.upper, f"{row.name}_most")
    # SCIP's objectives are linear: a variable below which the true one cannot lie.
    cost = model.addVar("cost", "C", None, None)
    model.addCons(cost >= _sum(scip, variables, program.linear, program.products))
    model.setObjective(cost, "minimize")
    model.optimize()
    return _solved(model, variables, program, time_limit_s)


def _solved(model: Any, variables: list[Any], program: Program, time_limit_s: float | None) -> Solved:
    status = model.getStatus()
    if status == "infeasible":
        raise InfeasibleError(f"{program.name}: no plan obeys all constraints (proved by SCIP)")
    if model.getNSols() == 0:
        if status == "timelimit":
            raise BudgetExceededError(f"{program.name}: SCIP found no plan within {time_limit_s:g} s")
        raise TgvdpError(f"{program.name}: SCIP ended without a plan: {status}")
    values = np.array([model.getVal(variable) for variable in variables])
    details = {
        "nodes": int(model.getNTotalNodes()),
        "time_limit_s": time_limit_s,
        "variables": len(program.variables),
        "rows": len(program.rows),
        "nonzeros": program.nonzeros,
        "binaries": program.binaries,
        "integers": program.integers,
    }
    return Solved(values, float(model.getDualbound()), status == "optimal", details)


def _sum(scip: Any, variables: list[Any], linear: Terms, products: Products) -> Any:
    terms = [weight * variables[i] for i, weight in linear.items()]
    terms += [weight * variables[i] * variables[j] for (i, j), weight in products.items()]
    return scip.quicksum(terms) if terms else 0.0 * variables[0]


def _objective(program: Program, values: NDArray[np.float64]) -> float:
    linear = sum(weight * values[i] for i, weight in program.linear.items())
    products = sum(weight * values[i] * values[j] for (i, j), weight in program.products.items())
    return float(program.unit * (linear + products))
