"""The two-bit encoding as a QUBO: x_i accelerates, y_i brakes.

The binary formulation, and its constraints as squared penalties (Glover, Kochenberger and Du 2019), in their printed
and in their corrected forms, which are options of a `BitsForm`:

1. not both at once: λ·x_i·y_i, or the variable z_i = x_i·y_i of McCormick (1976) that must be 0;
2. distance by the left, right (method 1) or trapezoid rule (method 2), with a slack register where it has a tolerance;
3. v_N = 0;
4./5. speed limits: none; per step, where one register v_k + s_k = h_k enforces both 0 ≤ v_k and v_k ≤ h_k; a·Σx ≤ h
   as printed, which is sufficient but forbids to accelerate again; or the same as an equality, as P4 of the three-phase
   formulation prints it, which fixes the number of accelerations and so makes the constant objective constant.
"""

import numpy as np

from tgvdp.formulations.problem.binary import DistanceRule, distance_weights, schedule_of
from tgvdp.formulations.problem.instances import BinaryInstance, decimal
from tgvdp.formulations.problem.schedule import Schedule
from tgvdp.formulations.qubo.encoded import Bits, Encoded
from tgvdp.formulations.qubo.hobo import add_reduced, cubic_efficiency
from tgvdp.formulations.qubo.names import BitsForm, SpeedLimits, Weights
from tgvdp.formulations.qubo.parts import Builder, joined


def encode_bits(
    instance: BinaryInstance, penalty: float, form: BitsForm | None = None, weights: Weights | None = None
) -> Encoded:
    """Write an instance as a QUBO over x_0..x_{N−1}, y_0..y_{N−1} and what registers the form needs.

    Parameters
    ----------
    instance : BinaryInstance
    penalty : float
        λ, in the objective's unit (m/s)² per squared unit of violation.
    form : BitsForm, optional
        The 2N bits alone by default.
    weights : Weights, optional
        Relative weights of violations; equal by default.
    """
    form = form or BitsForm()
    parts = Builder(weights or Weights())
    steps = instance.steps
    x = [parts.add_variable(f"x{i}") for i in range(steps)]
    y = [parts.add_variable(f"y{i}") for i in range(steps)]
    _add_exclusion(parts, x, y, form.mccormick)
    _add_distance(parts, instance, x, y, form.distance)
    parts.require(_speed_terms(instance, x, y, steps), 0, parts.weights.stop)
    _add_limits(parts, instance, x, y, form.limits)
    if form.cubic:
        add_reduced(parts, cubic_efficiency(instance, x, y))
    else:
        _add_objective(parts, instance, x, y)
    objective, violation = parts.build()

    def decode(bits: Bits) -> Schedule:
        bits = np.asarray(bits)
        return schedule_of(instance, bits[:steps], bits[steps : 2 * steps])

    # A limit on Σx forbids some schedules, and the cubic objective is not the instance's.
    complete = form.limits in ("none", "slack") and not form.cubic
    qubo = joined(objective, violation, penalty)
    return Encoded(qubo, instance, form.word, penalty, decode, objective, violation, parts.weights, complete)


def _speed_terms(instance: BinaryInstance, x: list[int], y: list[int], k: int) -> dict[int, float]:
    """v_k as a sum over bits, in Δv."""
    return {bit: float(instance.acc_units) for bit in x[:k]} | {bit: -float(instance.dec_units) for bit in y[:k]}


def _add_exclusion(parts: Builder, x: list[int], y: list[int], mccormick: bool) -> None:
    for i, (accelerate, brake) in enumerate(zip(x, y, strict=True)):
        if not mccormick:
            parts.forbid(accelerate, brake)
            continue
        # z = x·y by the penalty x·y − 2x·z − 2y·z + 3z, which is 0 where z ≤ x, z ≤ y, z ≥ x + y − 1 and ≥ 1 elsewhere.
        z = parts.add_variable(f"z{i}")
        for first, second, weight in ((accelerate, brake, 1.0), (accelerate, z, -2.0), (brake, z, -2.0), (z, z, 3.0)):
            parts.violation.add_quadratic(first, second, parts.weights.logic * weight)
        parts.require_zero(z)


def _add_distance(parts: Builder, instance: BinaryInstance, x: list[int], y: list[int], rule: DistanceRule) -> None:
    weights = distance_weights(instance.steps, rule) / 2.0
    terms = {bit: instance.acc_units * float(weight) for bit, weight in zip(x, weights, strict=True)}
    terms |= {bit: -instance.dec_units * float(weight) for bit, weight in zip(y, weights, strict=True)}
    low, high = instance.distance_range
    parts.require_distance(terms, low, high)


def _add_limits(parts: Builder, instance: BinaryInstance, x: list[int], y: list[int], limits: SpeedLimits) -> None:
    a, b, steps = instance.acc_units, instance.dec_units, instance.steps
    limit = parts.weights.limit
    if limits == "slack":
        for k in range(1, steps):
            # A lower cap that every plan from stop to stop keeps anyway saves bits.
            cap = min(instance.cap_units[k - 1], a * k, b * (steps - k))
            parts.require_range(_speed_terms(instance, x, y, k), 0, cap, f"s{k}_", limit)
    elif limits != "none":
        cap = min(instance.cap_units[:-1], default=0)
        terms = {bit: 1.0 for bit in x}
        if limits == "total":
            parts.require_range(terms, 0, min(cap // a, steps), "s", limit)
        else:
            parts.require({bit: float(a) for bit in x}, cap, limit)


def _add_objective(parts: Builder, instance: BinaryInstance, x: list[int], y: list[int]) -> None:
    a, b = instance.acc_units, instance.dec_units
    square = float(decimal(instance.dv_mps) ** 2)
    add_linear, add_quadratic = parts.objective.add_linear, parts.objective.add_quadratic
    for i, (accelerate, brake) in enumerate(zip(x, y, strict=True)):
        if instance.model == "constant":
            add_linear(accelerate, square * a * a)
            add_linear(brake, -square * instance.alpha * b * b)
        elif instance.model == "kinetic":
            add_linear(accelerate, square * a * a / 2)
            add_linear(brake, square * instance.alpha * b * b / 2)
            for bit, weight in _speed_terms(instance, x, y, i).items():
                add_quadratic(accelerate, bit, square * a * weight)
                add_quadratic(brake, bit, -square * instance.alpha * b * weight)
        else:
            arrival = _speed_terms(instance, x, y, i + 1)
            parts.objective.add_square(arrival, 0.0, -square * instance.deta)
            for bit, weight in arrival.items():
                add_linear(bit, square * instance.eta0 * weight)
