"""An encoding in two parts, objective and squared violation, which a penalty weight joins to one QUBO.

Violations are whole numbers of units (Δv, Δv·Δt, steps), so that a string that breaks anything has a violation of at
least 1. The binary formulation writes its penalties in m/s instead, with time in steps, so that a unit of violation
counts Δv²: `si_weights` reproduces that.
"""

from collections.abc import Mapping

import numpy as np

from tgvdp.formulations.problem.instances import BinaryInstance
from tgvdp.formulations.qubo.names import Encoding, Weights
from tgvdp.formulations.qubo.qubo import Qubo, QuboBuilder


def si_weights(instance: BinaryInstance, encoding: Encoding) -> Weights:
    """Weights of speeds in m/s and distances in m/s times steps; unary levels are whole steps."""
    square = (instance.dv_mps * (instance.acc_units if encoding == "unary" else 1)) ** 2
    return Weights(1.0, square, square, square)


class Builder:
    """Collects objective and violation over the same bits.

    Attributes
    ----------
    objective, violation : QuboBuilder
    """

    def __init__(self, weights: Weights) -> None:
        self.objective = QuboBuilder()
        self.violation = QuboBuilder()
        self.weights = weights

    def add_variable(self, label: str) -> int:
        """Append a bit to both parts and return its index."""
        self.objective.add_variable(label)
        return self.violation.add_variable(label)

    def forbid(self, first: int, second: int) -> None:
        """Two bits may not be 1 at once."""
        self.violation.add_quadratic(first, second, self.weights.logic)

    def imply(self, first: int, second: int) -> None:
        """Where the first bit is 1, the second must be."""
        self.violation.add_linear(first, self.weights.logic)
        self.violation.add_quadratic(first, second, -self.weights.logic)

    def require_zero(self, bit: int) -> None:
        """A bit must be 0."""
        self.violation.add_linear(bit, self.weights.logic)

    def require(self, terms: Mapping[int, float], value: float, weight: float) -> None:
        """Σ aᵢ·xᵢ = value."""
        self.violation.add_square(terms, -value, weight)

    def require_range(
        self, terms: Mapping[int, float], low: int, high: int, label: str, weight: float
    ) -> list[tuple[int, int]]:
        """Low ≤ Σ aᵢ·xᵢ ≤ high, by one slack register: Σ aᵢ·xᵢ + s = high, 0 ≤ s ≤ high − low.

        Returns
        -------
        list of (bit, coefficient)
            The register.
        """
        register = [(self.add_variable(f"{label}{j}"), c) for j, c in enumerate(register_coefficients(high - low))]
        self.require({**terms, **dict(register)}, high, weight)
        return register

    def require_distance(self, terms: Mapping[int, float], low: int, high: int) -> None:
        """Low ≤ Σ aᵢ·xᵢ ≤ high; where no whole number lies between, every string has a violation of 1 at least."""
        if low > high:
            self.violation.add_constant(self.weights.distance)
        self.require_range(terms, min(low, high), high, "d", self.weights.distance)

    def build(self) -> tuple[Qubo, Qubo]:
        """Objective and violation."""
        return self.objective.build(), self.violation.build()


def register_coefficients(largest: int) -> tuple[int, ...]:
    """Coefficients of a register of bits that holds exactly 0..largest: 1, 2, 4, …, and what is missing at the end.

    (Lucas 2014.) With m bits for h, c = 1, 2, .., 2^(m−2), h − (2^(m−1) − 1). Unless h = 2^m − 1 some values have two
    codes, which multiplies the number of ground states.
    """
    if largest < 1:
        return ()
    bits = largest.bit_length()
    return (*(1 << j for j in range(bits - 1)), largest - ((1 << (bits - 1)) - 1))


def joined(objective: Qubo, violation: Qubo, penalty: float) -> Qubo:
    """Objective + penalty · violation."""
    rows = np.concatenate((objective.rows, violation.rows)).astype(np.int64)
    cols = np.concatenate((objective.cols, violation.cols)).astype(np.int64)
    values = np.concatenate((objective.values, penalty * violation.values))
    key, where = np.unique(rows * objective.n + cols, return_inverse=True)
    total = np.bincount(where, values, minlength=key.size)
    kept = total != 0.0
    pair_rows, pair_cols = np.divmod(key[kept], max(1, objective.n))
    return Qubo(
        objective.linear + penalty * violation.linear,
        pair_rows.astype(np.int32),
        pair_cols.astype(np.int32),
        total[kept],
        objective.offset + penalty * violation.offset,
        objective.labels,
    )
