"""The binary model as a mixed-integer program, quadratic or linear, for HiGHS and SCIP and for LP and MPS files.

Beside the bits x_i, y_i the speeds v_k stand as variables, which keeps every row short:

    v_{k+1} = v_k + a·x_k − b·y_k,   x_k + y_k ≤ 1,   0 ≤ v_k ≤ h_k,   v_0 = v_N = 0,   Σ v_k within D ± tol.

The binary formulation writes x·y = 0 by McCormick's z; with z = 0 that is x + y ≤ 1. The kinetic and the efficiency
objective hold products. The quadratic form leaves them as they are. The linear form writes squares of speeds by levels,
t_kj = [v_k ≥ j], v_k = Σ_j t_kj and v_k² = Σ_j (2j − 1)·t_kj, and the energy of a rise by the levels that it passes.
Levels imply each other like the nodes of a closure problem, so that the relaxation is nearly tight: HiGHS proves the
kinetic optimum of N = 40 within a second; with McCormick products of bits and speeds it took minutes.

Objectives are scaled to whole numbers, so that a bound less than 1 below an objective proves it.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import inf, lcm
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import BudgetExceededError, InfeasibleError
from tgvdp.formulations.problem.binary import features, in_model_units, schedule_of
from tgvdp.formulations.problem.instances import BinaryInstance
from tgvdp.formulations.problem.schedule import Schedule

Form: TypeAlias = Literal["linear", "quadratic"]
Terms: TypeAlias = Mapping[int, float]
Products: TypeAlias = Mapping[tuple[int, int], float]


class Variable(NamedTuple):
    """A variable with its bounds."""

    name: str
    lower: float
    upper: float
    integer: bool


class Row(NamedTuple):
    """lower ≤ Σ linear + Σ products ≤ upper, by indices of variables."""

    name: str
    linear: Terms
    products: Products
    lower: float
    upper: float


@dataclass(frozen=True)
class Program:
    """Minimise unit · (Σ linear + Σ products) subject to rows.

    Attributes
    ----------
    name : str
    variables : tuple of Variable
    linear, products : mapping
        Objective, of whole numbers.
    unit : float
        Objective of the model per unit of the program's.
    rows : tuple of Row
    """

    name: str
    variables: tuple[Variable, ...]
    linear: Terms
    products: Products
    unit: float
    rows: tuple[Row, ...]

    @property
    def binaries(self) -> int:
        """Variables that are 0 or 1."""
        return sum(one.integer and (one.lower, one.upper) == (0.0, 1.0) for one in self.variables)

    @property
    def integers(self) -> int:
        """Whole variables that are no bits."""
        return sum(one.integer for one in self.variables) - self.binaries

    @property
    def nonzeros(self) -> int:
        """Coefficients of the rows."""
        return sum(len(row.linear) + len(row.products) for row in self.rows)


class Written(NamedTuple):
    """A program and how to read its solution.

    Attributes
    ----------
    program : Program
    schedule : callable
        (n,) values of the variables, whole up to a solver's tolerance → `Schedule`.
    """

    program: Program
    schedule: Callable[[NDArray[np.float64]], Schedule]


class ProgramBuilder:
    """Collects variables, rows and the objective.

    Parameters
    ----------
    deadline_s : float
        By `time.perf_counter`; a row that is added later raises `BudgetExceededError`.
    """

    def __init__(self, deadline_s: float = inf) -> None:
        self._deadline_s = deadline_s
        self.variables: list[Variable] = []
        self.rows: list[Row] = []
        self.linear: dict[int, Fraction] = {}
        self.products: dict[tuple[int, int], Fraction] = {}

    def add_variable(self, name: str, upper: float, lower: float = 0.0, *, integer: bool = False) -> int:
        """Append a variable and return its index."""
        self.variables.append(Variable(name, lower, upper, integer))
        return len(self.variables) - 1

    def add_row(
        self, name: str, linear: Terms, lower: float = -inf, upper: float = inf, products: Products | None = None
    ) -> None:
        """Append lower ≤ Σ linear + Σ products ≤ upper; terms of weight 0 are left out."""
        if time.perf_counter() > self._deadline_s:
            raise BudgetExceededError(f"program: the time limit ended after {len(self.rows)} rows were written")
        kept = {variable: weight for variable, weight in linear.items() if weight}
        self.rows.append(Row(name, kept, dict(products or {}), lower, upper))

    def add_cost(self, first: int, weight: Fraction, second: int | None = None) -> None:
        """Add weight·variable, or weight·first·second, to the objective."""
        if not weight:
            return
        if second is None:
            self.linear[first] = self.linear.get(first, Fraction(0)) + weight
        else:
            pair = (min(first, second), max(first, second))
            self.products[pair] = self.products.get(pair, Fraction(0)) + weight

    def build(self, name: str, to_unit: Callable[[Fraction], float]) -> Program:
        """Scale the objective to whole numbers and return the program; ``to_unit`` turns it into the model's unit."""
        costs = (*self.linear.values(), *self.products.values())
        scale = lcm(*(cost.denominator for cost in costs))
        return Program(
            name,
            tuple(self.variables),
            {variable: float(cost * scale) for variable, cost in self.linear.items()},
            {pair: float(cost * scale) for pair, cost in self.products.items()},
            to_unit(Fraction(1, scale)),
            tuple(self.rows),
        )


class _Run(NamedTuple):
    """Indices of the variables of a binary program; the speeds v_0 and v_N are none, because they are 0."""

    x: range
    y: range
    v: dict[int, int]


def binary_program(instance: BinaryInstance, form: Form = "linear", deadline_s: float = inf) -> Program:
    """Write the binary model as a program; its first 2N variables are x_0..x_{N−1}, y_0..y_{N−1}.

    Parameters
    ----------
    instance : BinaryInstance
    form : {"linear", "quadratic"}
        How products in the objective are written.
    deadline_s : float
        As of `ProgramBuilder`.

    Raises
    ------
    InfeasibleError
        When no whole distance lies within the tolerance.
    """
    n = instance.steps
    low, high = instance.distance_range
    if low > high:
        raise InfeasibleError(f"{instance.id}: no whole distance lies within the tolerance")
    builder = ProgramBuilder(deadline_s)
    for name in ("x", "y"):
        for i in range(n):
            builder.add_variable(f"{name}_{i}", 1.0, integer=True)
    run = _Run(range(n), range(n, 2 * n), {})
    a, b = float(instance.acc_units), float(instance.dec_units)
    for k in range(1, n):
        # No faster than traction reaches and braking can still undo.
        run.v[k] = builder.add_variable(f"v_{k}", min(float(instance.cap_units[k - 1]), k * a, (n - k) * b))
    for i in range(n):
        step = {run.x[i]: -a, run.y[i]: b}
        step |= {run.v[k]: weight for k, weight in ((i + 1, 1.0), (i, -1.0)) if k in run.v}
        builder.add_row(f"motion_{i}", step, 0.0, 0.0)
        builder.add_row(f"action_{i}", {run.x[i]: 1.0, run.y[i]: 1.0}, upper=1.0)
    builder.add_row("distance", dict.fromkeys(run.v.values(), 1.0), float(low), float(high))
    _add_objective(builder, instance, run, form)
    return builder.build(instance.id, lambda exact: in_model_units(instance, exact))


def binary_form(instance: BinaryInstance, form: Form, deadline_s: float = inf) -> Written:
    """The program of `binary_program`, and how to read it."""

    def schedule(values: NDArray[np.float64]) -> Schedule:
        bits = np.rint(values[: 2 * instance.steps]).astype(np.int8)
        return schedule_of(instance, bits[: instance.steps], bits[instance.steps :])

    return Written(binary_program(instance, form, deadline_s), schedule)


def _add_objective(builder: ProgramBuilder, instance: BinaryInstance, run: _Run, form: Form) -> None:
    """p·first − q·second of `features`."""
    none = np.zeros(instance.steps, dtype=np.int64)
    p, q = features(instance, none, none)[2:]
    if instance.model == "constant":
        for i in range(instance.steps):
            builder.add_cost(run.x[i], p)
            builder.add_cost(run.y[i], -q)
    elif form == "quadratic":
        _add_products(builder, instance, run, p, q)
    else:
        levels = _add_levels(builder, instance, run)
        if instance.model == "kinetic":
            _add_rises(builder, instance, levels, p - q)
        else:
            for v in run.v.values():
                builder.add_cost(v, p)
            for (_, j), level in levels.items():
                builder.add_cost(level, -q * (2 * j - 1))


def _add_products(builder: ProgramBuilder, instance: BinaryInstance, run: _Run, p: Fraction, q: Fraction) -> None:
    """The objective as it is defined: v², or the product of a bit and the speed at which its step starts."""
    if instance.model == "efficiency":
        for v in run.v.values():
            builder.add_cost(v, p)
            builder.add_cost(v, -q, v)
        return
    a, b = instance.acc_units, instance.dec_units
    for i in range(instance.steps):
        builder.add_cost(run.x[i], p * a * a)
        builder.add_cost(run.y[i], q * b * b)
        if i in run.v:
            builder.add_cost(run.x[i], 2 * a * p, run.v[i])
            builder.add_cost(run.y[i], -2 * b * q, run.v[i])


def _add_levels(builder: ProgramBuilder, instance: BinaryInstance, run: _Run) -> dict[tuple[int, int], int]:
    """Bits t_kj = [v_k ≥ j]: each implies the level below it, and those that a step can reach or have come from."""
    level: dict[tuple[int, int], int] = {}
    for k, v in run.v.items():
        for j in range(1, int(builder.variables[v].upper) + 1):
            level[k, j] = builder.add_variable(f"t_{k}_{j}", 1.0, integer=True)
        builder.add_row(f"speed_{k}", {v: 1.0} | {level[key]: -1.0 for key in level if key[0] == k}, 0.0, 0.0)
    for (k, j), bit in level.items():
        for name, below in (
            ("below", (k, j - 1)),
            ("before", (k - 1, j - instance.acc_units)),
            ("after", (k + 1, j - instance.dec_units)),
        ):
            if below in level:
                builder.add_row(f"{name}_{k}_{j}", {bit: 1.0, level[below]: -1.0}, upper=0.0)
    return level


def _add_rises(
    builder: ProgramBuilder, instance: BinaryInstance, level: Mapping[tuple[int, int], int], weight: Fraction
) -> None:
    """Add weight · Σ (v_{i+1}² − v_i²)⁺: what traction puts in. From stop to stop, braking takes the same out."""
    for i in range(instance.steps):
        for j in sorted({key[1] for key in level if key[0] == i + 1}):
            rise = builder.add_variable(f"r_{i}_{j}", 1.0)
            change = {rise: 1.0, level[i + 1, j]: -1.0} | ({level[i, j]: 1.0} if (i, j) in level else {})
            builder.add_row(f"rise_{i}_{j}", change, lower=0.0)
            builder.add_cost(rise, weight * (2 * j - 1))
