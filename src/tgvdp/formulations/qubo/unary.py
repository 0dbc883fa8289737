"""The unary encoding of the speed profile, t_kj = [v_k ≥ j]: domain walls in the sense of Chancellor (2019).

With equal steps a = b the speed after step k is a staircase of bits t_k1 ≥ t_k2 ≥ …, at most min(k, N−k, h_k) of them,
since all higher speeds could not be reached or not be left in time. A step between neighbours of one level is a wall of
the staircase, so accelerations are counted by t_{k+1,j}·(1 − t_kj) and no step bits are needed; nor are slack bits, but
for a tolerance on the distance.
"""

from itertools import pairwise

import numpy as np

from tgvdp.errors import InputError
from tgvdp.formulations.problem.binary import level_counts, schedule_of_speeds
from tgvdp.formulations.problem.instances import BinaryInstance, decimal
from tgvdp.formulations.problem.schedule import Check, Schedule
from tgvdp.formulations.qubo.encoded import Bits, Encoded
from tgvdp.formulations.qubo.names import MULTIPLIER, UNARY, Weights
from tgvdp.formulations.qubo.parts import Builder, joined


def encode_unary(
    instance: BinaryInstance, penalty: float, weights: Weights | None = None, multiplier: float | None = None
) -> Encoded:
    """Write an instance as a QUBO over the bits t_kj.

    Parameters
    ----------
    instance : BinaryInstance
        With equal steps of acceleration and braking.
    penalty : float
        λ, in the objective's unit (m/s)² per squared unit of violation.
    weights : Weights, optional
        Relative weights of violations; equal by default.
    multiplier : float, optional
        μ in (m/s)² per unit of distance: add μ·(Σt − D') instead of the square of Σt − D'. The graph of couplers is
        then a strip of low treewidth, and the minimum over all strings a lower bound on the optimum. A distance with a
        tolerance counts by its end that μ favours less.

    Raises
    ------
    InputError
        When the steps are not equal.
    """
    if instance.acc_units != instance.dec_units:
        raise InputError(
            f"{instance.id}: the unary encoding needs equal steps, got acc_units {instance.acc_units} "
            f"and dec_units {instance.dec_units}; use bits"
        )
    unit = instance.acc_units
    parts = Builder(weights or Weights())
    columns = add_registers(parts, instance, "t")
    _add_distance(parts, instance, [bit for column in columns for bit in column], multiplier)
    _add_objective(parts, instance, columns)
    objective, violation = parts.build()

    def decode(bits: Bits) -> Schedule:
        bits = np.asarray(bits)
        heights = [sum(int(bits[bit]) for bit in column) for column in columns]
        broken = sum(int(bits[upper]) > int(bits[lower]) for column in columns for lower, upper in pairwise(column))
        return schedule_of_speeds(
            instance, unit * np.array(heights), (Check("unary registers in order", float(broken), "bits"),)
        )

    alone = range(sum(map(len, columns)), objective.n)  # slack bits of a tolerance
    return Encoded(
        joined(objective, violation, penalty),
        instance,
        UNARY if multiplier is None else MULTIPLIER,
        penalty,
        decode,
        objective,
        violation,
        parts.weights,
        complete=multiplier is None,
        registers=(*(tuple(column) for column in columns if column), *((bit,) for bit in alone)),
    )


def add_registers(parts: Builder, instance: BinaryInstance, label: str) -> list[list[int]]:
    """Registers of v_0..v_N, each the bits of its levels, with the penalties that keep them in order and in step.

    The bit of level j after step k is called ``{label}{k}_{j}``.
    """
    columns = [
        [parts.add_variable(f"{label}{k}_{j}") for j in range(1, height + 1)]
        for k, height in enumerate(level_counts(instance))
    ]
    for k, column in enumerate(columns):
        for lower, upper in pairwise(column):
            parts.imply(upper, lower)
        for other in columns[max(0, k - 1) : k] + columns[k + 1 : k + 2]:
            # One level per step: where level j+1 stands here, level j stands there.
            for j, upper in enumerate(column[1:], start=1):
                if j <= len(other):
                    parts.imply(upper, other[j - 1])
                else:
                    parts.require_zero(upper)
    return columns


def _add_distance(parts: Builder, instance: BinaryInstance, bits: list[int], multiplier: float | None) -> None:
    unit = instance.acc_units
    if multiplier is not None:
        for bit in bits:
            parts.objective.add_linear(bit, multiplier)
        least, most = instance.distance_range
        parts.objective.add_constant(-multiplier * (most if multiplier > 0.0 else least) / unit)
        return
    least, most = instance.distance_range
    parts.require_distance({bit: 1.0 for bit in bits}, -(-least // unit), most // unit)


def _add_objective(parts: Builder, instance: BinaryInstance, columns: list[list[int]]) -> None:
    unit = instance.acc_units
    square = float(decimal(instance.dv_mps) ** 2) * unit * unit
    add_linear, add_quadratic = parts.objective.add_linear, parts.objective.add_quadratic
    for k in range(1, len(columns)):
        before, after = columns[k - 1], columns[k]
        for j in range(1, max(len(before), len(after)) + 1):
            if instance.model == "efficiency":
                if j <= len(after):  # v² = Σ (2j − 1)·t_j
                    per_speed = square / unit * instance.eta0
                    add_linear(after[j - 1], per_speed - square * instance.deta * (2 * j - 1))
                continue
            weight = square * (1.0 if instance.model == "constant" else j - 0.5)
            if j <= len(after):
                add_linear(after[j - 1], weight)
            if j <= len(before):
                add_linear(before[j - 1], -instance.alpha * weight)
            if j <= min(len(before), len(after)):
                add_quadratic(before[j - 1], after[j - 1], -(1.0 - instance.alpha) * weight)
