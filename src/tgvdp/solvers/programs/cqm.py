"""Constrained quadratic models of dimod: constraints stay constraints, no penalty is needed.

Of a binary instance the variables are the bits x_i, y_i; speeds are sums of them, and each limit is one row: the five
constraints of the binary formulation, in the corrected form per step. Of a demand instance it is the quadratic program
with δ (`tgvdp.formulations.program.demand`). dimod has no products of real variables, so that speeds there are whole
multiples of `SPEED_STEP_MPS`, and the equation of motion holds to half a step.
"""

import time
from dataclasses import replace
from functools import partial
from math import inf, isinf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError, InputError
from tgvdp.formulations.problem.binary import schedule_of
from tgvdp.formulations.problem.demand import demand_schedule
from tgvdp.formulations.problem.instances import BinaryInstance, DemandInstance, Instance
from tgvdp.formulations.problem.replay import replay
from tgvdp.formulations.problem.schedule import Schedule, Solution
from tgvdp.formulations.program.binary import Program, Row, Variable
from tgvdp.formulations.program.demand import DemandForm, DemandProgram, demand_program
from tgvdp.formulations.qubo.bits import encode_bits
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.extras import extra
from tgvdp.solvers.programs.scip import approximate_solution
from tgvdp.solvers.samplers.bqm import bqm_of
from tgvdp.solvers.samplers.cloud import connected, qpu_time_s

#: Most bits that dimod's ExactCQMSolver enumerates here, in a few seconds.
MAX_EXACT_BITS = 16

#: Resolution of speeds in the CQM of the demand model.
SPEED_STEP_MPS = 0.01


class Written(NamedTuple):
    """A CQM and how to read it.

    Attributes
    ----------
    cqm : dimod.ConstrainedQuadraticModel
    names : tuple of str
        Variables in the order in which ``program`` or the instance has them.
    program : DemandProgram or None
        Of a demand instance.
    """

    cqm: Any
    names: tuple[str, ...]
    program: DemandProgram | None

    def schedule(self, instance: Instance, values: NDArray[np.float64]) -> Schedule:
        """Decode (n,) values of the variables; those of a demand instance are driven on the true curves."""
        if isinstance(instance, DemandInstance):
            assert self.program is not None
            return demand_schedule(instance, self.program.demands(values))
        bits = np.rint(values).astype(np.int8)
        return schedule_of(instance, bits[: instance.steps], bits[instance.steps :])


def cqm_of(instance: Instance, form: DemandForm = "split") -> Written:
    """Write an instance as a CQM, in the model's own unit; ``form`` is that of the program of a demand instance.

    Raises
    ------
    InfeasibleError
        When no whole distance lies within the tolerance.
    """
    return _of_demand(instance, form) if isinstance(instance, DemandInstance) else _of_binary(instance)


def _of_binary(instance: BinaryInstance) -> Written:
    low, high = instance.distance_range
    if low > high:
        raise InfeasibleError(f"{instance.id}: no whole distance lies within the tolerance")
    cqm = extra("dimod", "a constrained quadratic model").ConstrainedQuadraticModel()
    objective = encode_bits(instance, 1.0).objective
    bits = 2 * instance.steps  # after them comes the register of a tolerance, which is a constraint here
    cqm.set_objective(bqm_of(replace(objective, linear=objective.linear[:bits], labels=objective.labels[:bits])))
    x, y = (tuple(f"{letter}{i}" for i in range(instance.steps)) for letter in "xy")
    a, b, steps = instance.acc_units, instance.dec_units, instance.steps
    for i in range(steps):
        cqm.add_constraint_from_iterable([(x[i], 1), (y[i], 1)], "<=", 1, label=f"one_action_{i}")
    for k in range(1, steps):
        speed = [(bit, a) for bit in x[:k]] + [(bit, -b) for bit in y[:k]]
        cqm.add_constraint_from_iterable(speed, ">=", 0, label=f"speed_{k}_not_negative")
        cqm.add_constraint_from_iterable(speed, "<=", instance.cap_units[k - 1], label=f"speed_{k}_limit")
    stop = [(bit, a) for bit in x] + [(bit, -b) for bit in y]
    cqm.add_constraint_from_iterable(stop, "==", 0, label="stop")
    # Σ v_k: from stop to stop all distance rules agree.
    travelled = [(x[i], a * (steps - i)) for i in range(steps)] + [(y[i], -b * (steps - i)) for i in range(steps)]
    if low == high:
        cqm.add_constraint_from_iterable(travelled, "==", low, label="distance")
    else:
        cqm.add_constraint_from_iterable(travelled, ">=", low, label="distance_least")
        cqm.add_constraint_from_iterable(travelled, "<=", high, label="distance_most")
    return Written(cqm, (*x, *y), None)


def _of_demand(instance: DemandInstance, form: DemandForm) -> Written:
    dimod = extra("dimod", "a constrained quadratic model")
    written = demand_program(instance, form)
    program = written.program
    multiplied = {
        i for terms in (program.products, *(row.products for row in program.rows)) for pair in terms for i in pair
    }
    cqm = dimod.ConstrainedQuadraticModel()
    names, scale = [], np.ones(len(program.variables))
    for i, one in enumerate(program.variables):
        kind = "INTEGER" if one.integer else "REAL"
        if not one.integer and i in multiplied:
            kind, scale[i] = "INTEGER", SPEED_STEP_MPS
        kind = "BINARY" if kind == "INTEGER" and (one.lower, one.upper) == (0.0, 1.0) and scale[i] == 1.0 else kind
        bounds = {} if kind == "BINARY" else {"lower_bound": one.lower / scale[i], "upper_bound": one.upper // scale[i]}
        cqm.add_variable(kind, one.name, **bounds)
        names.append(one.name)
    objective = dimod.QuadraticModel()
    _add_terms(objective, cqm, names, scale, program.linear, program.products, program.unit)
    cqm.set_objective(objective)
    for row in program.rows:
        _add_row(dimod, cqm, names, scale, row)
    return Written(cqm, tuple(names), written)


def _add_terms(
    model: Any, cqm: Any, names: list[str], scale: NDArray[np.float64], linear: Any, products: Any, unit: float = 1.0
) -> None:
    for i in sorted({*linear, *(i for pair in products for i in pair)}):
        model.add_variable(
            cqm.vartype(names[i]), names[i],
            **({} if cqm.vartype(names[i]).name == "BINARY" else {
                "lower_bound": cqm.lower_bound(names[i]), "upper_bound": cqm.upper_bound(names[i])
            }),
        )  # fmt: skip
    for i, weight in linear.items():
        model.add_linear(names[i], unit * weight * scale[i])
    for (i, j), weight in products.items():
        model.add_quadratic(names[i], names[j], unit * weight * scale[i] * scale[j])


def _add_row(dimod: Any, cqm: Any, names: list[str], scale: NDArray[np.float64], row: Row) -> None:
    model = dimod.QuadraticModel()
    _add_terms(model, cqm, names, scale, row.linear, row.products)
    lower, upper = row.lower, row.upper
    if row.name.startswith("motion"):  # speeds are rounded
        lower, upper = lower - 0.5 * SPEED_STEP_MPS, upper + 0.5 * SPEED_STEP_MPS
    if lower == upper:
        cqm.add_constraint_from_model(model, "==", lower, label=row.name)
        return
    both = not isinf(lower) and not isinf(upper)
    if not isinf(lower):
        cqm.add_constraint_from_model(model, ">=", lower, label=f"{row.name}_least" if both else row.name)
    if not isinf(upper):
        cqm.add_constraint_from_model(model, "<=", upper, label=f"{row.name}_most" if both else row.name)


def solve_cqm(instance: Instance, allowance: Allowance) -> Solution:
    """Solve the CQM here: of a binary instance by enumeration, which counts the optima, of a demand instance by SCIP.

    Of a demand instance it uses ``form`` and ``time_limit_s``; the model is what the hybrid service would get.

    Raises
    ------
    InputError
        When a binary instance has more than `MAX_EXACT_BITS` bits, or gets a time limit.
    InfeasibleError
        When no string of a binary instance satisfies all constraints.
    BudgetExceededError
        When the time limit ends before there is a plan, or the approximation of a demand instance has none.
    """
    if isinstance(instance, DemandInstance):
        start = time.perf_counter()
        written = cqm_of(instance, allowance.form or "split")
        decode = partial(written.schedule, instance)
        return approximate_solution("cqm", instance, _program_of(written, instance.id), decode, allowance, start)
    if allowance.time_limit_s is not None:
        raise InputError(f"{instance.id}: solver cqm lists all strings of a binary instance, so it has no time limit")
    if 2 * instance.steps > MAX_EXACT_BITS:
        raise InputError(
            f"{instance.id}: solver cqm: {2 * instance.steps} bits are too many to enumerate (at most {MAX_EXACT_BITS})"
        )
    sampler = extra("dimod", "solver cqm").ExactCQMSolver()
    start = time.perf_counter()
    written = cqm_of(instance)
    sampleset = sampler.sample_cqm(written.cqm)
    feasible = np.flatnonzero(sampleset.record.is_feasible)
    if not feasible.size:
        raise InfeasibleError(f"{instance.id}: none of the {len(sampleset)} strings satisfies all constraints")
    schedules = [written.schedule(instance, _values(sampleset, written, row)) for row in _lowest(sampleset, feasible)]
    best = min(schedule.objective for schedule in schedules)
    optima = [schedule for schedule in schedules if schedule.objective == best]
    elapsed_s = time.perf_counter() - start
    return Solution("cqm", optima[0], True, len(optima), replay(instance, optima[0]), elapsed_s, details=_size(written))


def _lowest(sampleset: Any, rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """Rows whose energy equals the lowest of them, up to rounding."""
    energy = np.asarray(sampleset.record.energy)[rows]
    close: NDArray[np.int64] = rows[energy <= energy.min() + 1e-9 * max(1.0, float(np.abs(energy).max()))]
    return close


def _values(sampleset: Any, written: Written, row: int) -> NDArray[np.float64]:
    column = {name: i for i, name in enumerate(sampleset.variables)}
    values: NDArray[np.float64] = sampleset.record.sample[row][[column[name] for name in written.names]].astype(float)
    return values


def _program_of(written: Written, name: str) -> Program:
    """The CQM as a program for SCIP, speeds in the CQM's whole steps."""
    cqm, index = written.cqm, {label: i for i, label in enumerate(written.names)}

    def terms(model: Any) -> tuple[dict[int, float], dict[tuple[int, int], float]]:
        linear = {index[label]: bias for label, bias in model.iter_linear() if bias}
        pairs = ((sorted((index[u], index[v])), bias) for u, v, bias in model.iter_quadratic())
        return linear, {(first, second): bias for (first, second), bias in pairs}

    variables = tuple(
        Variable(label, cqm.lower_bound(label), cqm.upper_bound(label), cqm.vartype(label).name != "REAL")
        for label in written.names
    )
    rows = []
    for label, constraint in cqm.constraints.items():
        linear, products = terms(constraint.lhs)
        side = constraint.rhs - constraint.lhs.offset
        lower = -inf if constraint.sense.name == "Le" else side
        rows.append(Row(label, linear, products, lower, inf if constraint.sense.name == "Ge" else side))
    return Program(name, variables, *terms(cqm.objective), 1.0, tuple(rows))


def _size(written: Written) -> dict[str, Any]:
    cqm = written.cqm
    terms = sum(len(row.lhs.variables) + row.lhs.num_interactions for row in cqm.constraints.values())
    kinds = [cqm.vartype(name).name for name in cqm.variables]
    return {
        "variables": len(kinds), "binaries": kinds.count("BINARY"), "integers": kinds.count("INTEGER"),
        "rows": len(cqm.constraints), "nonzeros": terms,
    }  # fmt: skip


def solve_leap(instance: Instance, allowance: Allowance) -> Solution:
    """Sample the CQM on D-Wave's hybrid service; uses ``form`` and ``time_limit_s``.

    The clock includes network and queue.

    Raises
    ------
    UnavailableError
        When there is no account.
    InputError
        When the service refuses the problem.
    """
    sampler = connected("leap", "service", "LeapHybridCQMSampler")
    return hybrid_solution(sampler, instance, allowance)


def hybrid_solution(sampler: Any, instance: Instance, allowance: Allowance) -> Solution:
    """Solution of a sampler with the method ``sample_cqm``: the best feasible schedule of all that it returns.

    Raises
    ------
    InputError
        When the sampler refuses the problem, or returns nothing.
    """
    written = cqm_of(instance, allowance.form or "split")
    limit = {} if allowance.time_limit_s is None else {"time_limit": allowance.time_limit_s}
    start = time.perf_counter()
    try:
        sampleset = sampler.sample_cqm(written.cqm, **limit)
        count = len(sampleset)  # waits for the answer
    except ValueError as error:
        raise InputError(f"{instance.id}: solver leap: the service refuses the problem: {error}") from None
    elapsed_s = time.perf_counter() - start
    if not count:
        raise InputError(f"{instance.id}: solver leap: the service returned no sample")
    schedules = [written.schedule(instance, _values(sampleset, written, row)) for row in range(count)]
    best = min(schedules, key=lambda one: (not one.feasible, one.objective))
    feasible = [one.feasible for one in schedules]
    equal = [one for one in schedules if one.feasible and one.objective == best.objective]
    details = {
        **_size(written), "reads": count, "feasible_reads": sum(feasible), "best_reads": len(equal),
        "time_limit_s": allowance.time_limit_s,
        "qpu_s": qpu_time_s(sampleset.info),
    }  # fmt: skip
    return Solution("leap", best, False, None, replay(instance, best), elapsed_s, details=details)
