"""Trains at one substation as a QUBO: the unary registers of every train, and a register per step for the power.

Speeds are domain walls as in `tgvdp.formulations.qubo.unary`. What a step draws is a product, a rise to level j being r
= t_{i+1,j}·(1 − t_ij), and enters the power of the step, which is squared; so each rise is a bit of its own, tied to
the product as Rosenberg (1975) does. With n_i and s_i whole registers,

    q·n_i = Σ_k m_k·Σ_j (2j − 1)·[(q − p)·r_kij + p·(t_k,i+1,j − t_kij)] + s_i,   0 ≤ q·n_i ≤ q·P,   s_i ≥ 0,

and the objective is Σ n_i: s_i takes up what braking offers beyond what anybody draws.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tgvdp.formulations.problem.instances import SharedTrip, SubstationInstance
from tgvdp.formulations.problem.schedule import Check, Schedule
from tgvdp.formulations.problem.substation import shares, substation_schedule, to_j_per_kg
from tgvdp.formulations.qubo.encoded import Bits, Encoded
from tgvdp.formulations.qubo.names import Weights
from tgvdp.formulations.qubo.parts import Builder, joined, register_coefficients
from tgvdp.formulations.qubo.unary import add_registers

_Columns = list[list[int]]


class _Step(NamedTuple):
    """What the power of one step is made of.

    Attributes
    ----------
    terms : dict of bit to whole number
        q times what the trains draw less what reaches others.
    most_drawn, most_offered : int
        Largest q·drawn and p·offered that any plan has there.
    """

    terms: dict[int, float]
    most_drawn: list[int]
    most_offered: list[int]


def encode_substation(instance: SubstationInstance, penalty: float, weights: Weights | None = None) -> Encoded:
    """Write the trains of a substation as a QUBO; all constraints are in it.

    Parameters
    ----------
    instance : SubstationInstance
    penalty : float
        λ, in J/kg per squared unit of violation.
    weights : Weights, optional
        Relative weights of violations; that of a step's power counts as limit. Equal by default.
    """
    parts = Builder(weights or Weights())
    trains = [add_registers(parts, train.trip, f"t{number}_") for number, train in enumerate(instance.trains, start=1)]
    steps = [_Step({}, [0], [0]) for _ in range(instance.steps)]
    for number, (train, columns) in enumerate(zip(instance.trains, trains, strict=True), start=1):
        distance = train.trip.distance_range[0]
        parts.require({bit: 1.0 for column in columns for bit in column}, distance, parts.weights.distance)
        for i, (before, after) in enumerate(pairwise(columns)):
            _add_power(parts, instance, train, steps[train.start + i], before, after, f"r{number}_{i}_")
    for i, step in enumerate(steps):
        _add_delivery(parts, instance, step, i)
    objective, violation = parts.build()

    def decode(bits: Bits) -> Schedule:
        bits = np.asarray(bits)
        speeds = [np.array([sum(int(bits[bit]) for bit in column) for column in columns]) for columns in trains]
        broken = sum(
            int(bits[upper]) > int(bits[lower])
            for columns in trains
            for column in columns
            for lower, upper in pairwise(column)
        )
        return substation_schedule(instance, speeds, (Check("unary registers in order", float(broken), "bits"),))

    registers = tuple(tuple(column) for columns in trains for column in columns if column)
    walls = {bit for register in registers for bit in register}
    alone = tuple((bit,) for bit in range(objective.n) if bit not in walls)
    return Encoded(
        joined(objective, violation, penalty), instance, "unary", penalty, decode, objective, violation, parts.weights,
        registers=(*registers, *alone),
    )  # fmt: skip


def _add_power(
    parts: Builder,
    instance: SubstationInstance,
    train: SharedTrip,
    step: _Step,
    before: list[int],
    after: list[int],
    label: str,
) -> None:
    """Add what one train draws and offers in one step."""
    p, q = shares(instance)
    for j in range(1, max(len(before), len(after)) + 1):
        energy = train.mass_units * (2 * j - 1)
        lower = before[j - 1] if j <= len(before) else None
        upper = after[j - 1] if j <= len(after) else None
        if upper is not None:
            _add(step.terms, upper, p * energy)
            _add(step.terms, _rise(parts, lower, upper, f"{label}{j}"), (q - p) * energy)
        if lower is not None:
            _add(step.terms, lower, -p * energy)
    step.most_drawn.append(q * train.mass_units * max(0, 2 * len(after) - 1))
    step.most_offered.append(p * train.mass_units * max(0, 2 * len(before) - 1))


def _rise(parts: Builder, lower: int | None, upper: int, label: str) -> int:
    """Bit r = upper·(1 − lower); the violation upper·(1 − lower) − 2r·(upper + 1 − lower) + 3r is 0 only there."""
    if lower is None:
        return upper
    rise = parts.add_variable(label)
    weight = parts.weights.logic
    parts.violation.add_linear(upper, weight)
    parts.violation.add_linear(rise, weight)
    for first, second, sign in ((upper, lower, -1.0), (rise, upper, -2.0), (rise, lower, 2.0)):
        parts.violation.add_quadratic(first, second, sign * weight)
    return rise


def _add_delivery(parts: Builder, instance: SubstationInstance, step: _Step, number: int) -> None:
    """The registers q·n_i and s_i, the equation between them, and n_i in the objective."""
    q = shares(instance).q
    largest = min(q * instance.power_units, sum(step.most_drawn))
    net = [(parts.add_variable(f"n{number}_{b}"), c) for b, c in enumerate(register_coefficients(largest))]
    lost = [
        (parts.add_variable(f"s{number}_{b}"), c) for b, c in enumerate(register_coefficients(sum(step.most_offered)))
    ]
    unit = to_j_per_kg(instance, 1)
    for bit, coefficient in net:
        parts.objective.add_linear(bit, unit * coefficient)
    terms = dict(step.terms)
    for register, sign in ((net, -1.0), (lost, 1.0)):
        for bit, coefficient in register:
            terms[bit] = sign * coefficient
    parts.require(terms, 0.0, parts.weights.limit)


def _add(terms: dict[int, float], bit: int, weight: float) -> None:
    terms[bit] = terms.get(bit, 0.0) + weight
