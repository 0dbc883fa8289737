"""Trains at one substation as a mixed-integer linear program, for HiGHS and SCIP, for LP and MPS files and as a CQM.

Levels t_kij = [v_ki ≥ j] of each train k imply each other as in `tgvdp.formulations.program.binary`, and v² = Σ (2j −
1)·t_j makes all energies linear. A rise r_kij ≥ t_k,i+1,j − t_kij counts what a step draws. What it offers to others is
what it draws less what it gains, so that

    n_i ≥ Σ_k m_k·Σ_j (2j − 1)·[(1 − α)·r_kij + α·(t_k,i+1,j − t_kij)],   0 ≤ n_i ≤ P,

and the objective is Σ n_i. As 1 − α ≥ 0, rises are never larger than they must be where that would matter.
"""

from fractions import Fraction
from math import inf
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tgvdp.formulations.problem.binary import level_counts
from tgvdp.formulations.problem.instances import BinaryInstance, SharedTrip, SubstationInstance, decimal
from tgvdp.formulations.problem.schedule import Schedule
from tgvdp.formulations.problem.substation import substation_schedule
from tgvdp.formulations.program.binary import ProgramBuilder, Written, binary_form

_Levels: TypeAlias = dict[tuple[int, int], int]


def linear_program(instance: BinaryInstance | SubstationInstance, deadline_s: float = inf) -> Written:
    """The linear program of one train, or of those of a substation; ``deadline_s`` as of `ProgramBuilder`."""
    if isinstance(instance, SubstationInstance):
        return substation_program(instance, deadline_s)
    return binary_form(instance, "linear", deadline_s)


def substation_program(instance: SubstationInstance, deadline_s: float = inf) -> Written:
    """Write the trains of a substation as a linear program; ``deadline_s`` as of `ProgramBuilder`."""
    builder = ProgramBuilder(deadline_s)
    all_levels = [_add_train(builder, number, train) for number, train in enumerate(instance.trains)]
    net = [builder.add_variable(f"n_{i}", float(instance.power_units)) for i in range(instance.steps)]
    alpha = decimal(instance.alpha)
    rows: list[dict[int, Fraction]] = [{} for _ in net]
    for number, (train, level) in enumerate(zip(instance.trains, all_levels, strict=True)):
        for i in range(train.trip.steps):
            row = rows[train.start + i]
            for (k, j), bit in level.items():
                worth = alpha * train.mass_units * (2 * j - 1)
                if k == i + 1:
                    row[bit] = row.get(bit, Fraction(0)) + worth
                    rise = _add_rise(builder, f"r_{number}_{i}_{j}", bit, level.get((i, j)))
                    row[rise] = row.get(rise, Fraction(0)) + (1 - alpha) * train.mass_units * (2 * j - 1)
                elif k == i:
                    row[bit] = row.get(bit, Fraction(0)) - worth
    for i, (variable, row) in enumerate(zip(net, rows, strict=True)):
        terms = {bit: float(weight * alpha.denominator) for bit, weight in row.items()}
        builder.add_row(f"power_{i}", {**terms, variable: -float(alpha.denominator)}, upper=0.0)
        builder.add_cost(variable, Fraction(alpha.denominator))
    square = decimal(instance.dv_mps) ** 2 / (2 * alpha.denominator)
    program = builder.build(instance.id, lambda exact: float(exact * square))

    def schedule(values: NDArray[np.float64]) -> Schedule:
        speeds = []
        for train, level in zip(instance.trains, all_levels, strict=True):
            own = np.zeros(train.trip.steps + 1, dtype=np.int64)
            for (k, _), bit in level.items():
                own[k] += round(float(values[bit]))
            speeds.append(own)
        return substation_schedule(instance, speeds)

    return Written(program, schedule)


def _add_train(builder: ProgramBuilder, number: int, train: SharedTrip) -> _Levels:
    """Levels of one train, in order, one step apart at most, and its distance."""
    level = {
        (k, j): builder.add_variable(f"t_{number}_{k}_{j}", 1.0, integer=True)
        for k, height in enumerate(level_counts(train.trip))
        for j in range(1, height + 1)
    }
    for (k, j), bit in level.items():
        for name, below in (("below", (k, j - 1)), ("before", (k - 1, j - 1)), ("after", (k + 1, j - 1))):
            if below in level:
                builder.add_row(f"{name}_{number}_{k}_{j}", {bit: 1.0, level[below]: -1.0}, upper=0.0)
            elif j > 1:
                builder.add_row(f"{name}_{number}_{k}_{j}", {bit: 1.0}, upper=0.0)
    low, high = train.trip.distance_range
    builder.add_row(f"distance_{number}", dict.fromkeys(level.values(), 1.0), float(low), float(high))
    return level


def _add_rise(builder: ProgramBuilder, name: str, after: int, before: int | None) -> int:
    rise = builder.add_variable(name, 1.0)
    change = {rise: 1.0, after: -1.0} | ({} if before is None else {before: 1.0})
    builder.add_row(f"rise{name[1:]}", change, lower=0.0)
    return rise
