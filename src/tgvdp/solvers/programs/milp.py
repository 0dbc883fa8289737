"""HiGHS, through scipy: one train or those of a substation as a linear program with bits, to a proved optimum."""

import contextlib
import os
import time
from collections.abc import Iterator, Mapping
from math import ceil, isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import BudgetExceededError, InfeasibleError, TgvdpError
from tgvdp.formulations.problem.instances import BinaryInstance, SubstationInstance
from tgvdp.formulations.problem.replay import replay
from tgvdp.formulations.problem.schedule import Solution
from tgvdp.formulations.program.binary import Program, Written
from tgvdp.formulations.program.substation import linear_program
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.extras import extra

#: Part of a unit of the objective (whose values are whole) that rounding may take from a bound.
_BOUND_SLACK = 1e-3

#: What HiGHS has left at least, because none is no limit to it.
_LEAST_TIME_S = 1e-3

#: Status of scipy.optimize.milp.
_LIMIT, _INFEASIBLE = 1, 2


def solve_milp(instance: BinaryInstance | SubstationInstance, allowance: Allowance) -> Solution:
    """Solve the linear form; uses ``time_limit_s``.

    Raises
    ------
    InfeasibleError
        When no plan obeys all constraints.
    BudgetExceededError
        When the time limit ends before there is a plan.
    """
    scipy_optimize = extra("scipy.optimize", "solver milp")
    start = time.perf_counter()
    written = linear_program(instance, allowance.deadline_s(start))
    program = written.program
    limits = {"mip_rel_gap": 0.0, "presolve": True}
    if allowance.time_limit_s is not None:
        limits["time_limit"] = max(_LEAST_TIME_S, allowance.deadline_s(start) - time.perf_counter())
    with _stdout_kept():
        result = scipy_optimize.milp(
            c=_dense(program.linear, len(program.variables)),
            integrality=np.array([variable.integer for variable in program.variables], dtype=np.int8),
            bounds=scipy_optimize.Bounds(
                np.array([variable.lower for variable in program.variables]),
                np.array([variable.upper for variable in program.variables]),
            ),
            constraints=_rows(program, scipy_optimize.LinearConstraint),
            options=limits,
        )
    elapsed_s = time.perf_counter() - start
    if result.status == _INFEASIBLE:
        raise InfeasibleError(f"{instance.id}: no plan obeys all constraints (proved by HiGHS)")
    if result.x is None:
        if result.status == _LIMIT:
            raise BudgetExceededError(f"{instance.id}: HiGHS found no plan within {allowance.time_limit_s:g} s")
        raise TgvdpError(f"{instance.id}: HiGHS failed: {result.message}")
    bound = result.mip_dual_bound if result.mip_dual_bound is not None else result.fun
    details = {"nodes": int(result.mip_node_count or 0), "time_limit_s": allowance.time_limit_s}
    return program_solution("milp", instance, written, result.x, float(bound), elapsed_s, details)


@contextlib.contextmanager
def _stdout_kept() -> Iterator[None]:
    """Keep what HiGHS prints, told to print nothing, out of the standard output: it is no part of any answer."""
    try:
        kept = os.dup(1)
    except OSError:  # closed: nothing can be printed
        yield
        return
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.close(silent)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def program_solution(
    solver: str,
    instance: BinaryInstance | SubstationInstance,
    written: Written,
    values: NDArray[np.float64],
    bound: float,
    elapsed_s: float,
    details: Mapping[str, Any],
) -> Solution:
    """Decode a program's solution and decide whether its bound proves it.

    Objectives are whole multiples of the program's unit, so that the bound may be rounded up to the next one.

    Parameters
    ----------
    values : (n,) float64
        Of the program's variables, whole up to the solver's tolerance.
    bound : float
        Proved lower bound in the program's unit.
    """
    program, schedule = written.program, written.schedule(np.asarray(values))
    whole_bound = float(ceil(bound - _BOUND_SLACK)) if isfinite(bound) else None
    proved = whole_bound is not None and schedule.feasible and schedule.objective <= (whole_bound + 0.5) * program.unit
    return Solution(
        solver=solver,
        schedule=schedule,
        optimal=proved,
        n_optimal=None,
        replay=replay(instance, schedule),
        elapsed_s=elapsed_s,
        details={
            "bound": None if whole_bound is None else whole_bound * program.unit,
            "variables": len(program.variables),
            "rows": len(program.rows),
            "nonzeros": program.nonzeros,
            "binaries": program.binaries,
            "integers": program.integers,
            **details,
        },
    )


def _dense(terms: Mapping[int, float], n: int) -> NDArray[np.float64]:
    vector = np.zeros(n)
    vector[list(terms)] = list(terms.values())
    return vector


def _rows(program: Program, constraint: Any) -> Any:
    sparse = extra("scipy.sparse", "solver milp")
    entries = [(k, i, weight) for k, row in enumerate(program.rows) for i, weight in row.linear.items()]
    rows, columns, weights = zip(*entries, strict=True)
    matrix = sparse.csr_array((weights, (rows, columns)), shape=(len(program.rows), len(program.variables)))
    lower, upper = ([getattr(row, side) for row in program.rows] for side in ("lower", "upper"))
    return constraint(matrix, lower, upper)
