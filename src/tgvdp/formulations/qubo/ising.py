"""Ising form of a QUBO, in both conventions: spins sᵢ = ±1 with xᵢ = (1 + ε·sᵢ)/2.

With E(x) = c + Σ aᵢ·xᵢ + Σ_{i<j} qᵢⱼ·xᵢ·xⱼ the substitution gives E(s) = offset + Σ hᵢ·sᵢ + Σ_{i<j} Jᵢⱼ·sᵢ·sⱼ with

    hᵢ = ε·(aᵢ/2 + ¼·Σ_{j≠i} qᵢⱼ),   Jᵢⱼ = qᵢⱼ/4,   offset = c + ½·Σ aᵢ + ¼·Σ_{i<j} qᵢⱼ.

ε = +1 is dimod's convention, ε = −1 that of qubits, where x = (1 − Z)/2 and |1⟩ means x = 1. (The binary formulation
says x = (σ + 1)/2 but prints the sign of −1 for h, and its h and offset count the diagonal in the sum over j as well.)
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tgvdp.errors import InputError
from tgvdp.formulations.qubo.qubo import Qubo

Sign = Literal[1, -1]


@dataclass(frozen=True, eq=False)
class Ising:
    """Energy of spins: offset + Σ hᵢ·sᵢ + Σ_{i<j} Jᵢⱼ·sᵢ·sⱼ.

    Attributes
    ----------
    fields : (n,) float64
        hᵢ.
    rows, cols : (m,) int32
        Pairs of spins, rows < cols.
    couplings : (m,) float64
        Jᵢⱼ.
    offset : float
    sign : {1, -1}
        ε of the convention.
    labels : tuple of str
        Names of the spins.
    """

    fields: NDArray[np.float64]
    rows: NDArray[np.int32]
    cols: NDArray[np.int32]
    couplings: NDArray[np.float64]
    offset: float
    sign: Sign
    labels: tuple[str, ...]

    @property
    def n(self) -> int:
        """Number of spins."""
        return len(self.labels)

    def spins(self, bits: ArrayLike) -> NDArray[np.int8]:
        """Spins of bits: s = ε·(2·x − 1), (..., n) int8."""
        return np.asarray(self.sign * (2 * np.asarray(bits, dtype=np.int8) - 1), dtype=np.int8)

    def energy(self, spins: ArrayLike) -> NDArray[np.float64]:
        """Evaluate spins, (..., n) of −1 and 1, in (...) float64.

        Raises
        ------
        InputError
            When the last axis has not n entries, or an entry is neither −1 nor 1.
        """
        s = np.asarray(spins)
        if s.ndim == 0 or s.shape[-1] != self.n or not np.all(np.abs(s) == 1):
            raise InputError(f"ising: expected {self.n} spins of -1 or 1, got shape {s.shape}")
        s = s.astype(np.float64)
        return np.asarray(self.offset + s @ self.fields + (s[..., self.rows] * s[..., self.cols]) @ self.couplings)


def ising_of(qubo: Qubo, sign: Sign) -> Ising:
    """Rewrite a QUBO in spins.

    Parameters
    ----------
    qubo : Qubo
    sign : {1, -1}
        ε: 1 for x = (1 + s)/2, −1 for x = (1 − s)/2.

    Raises
    ------
    InputError
        When the sign is neither.
    """
    if sign not in (1, -1):
        raise InputError(f"ising: sign must be 1 or -1, got {sign!r}")
    coupled = _sum_per_bit(qubo.n, qubo.rows, qubo.cols, qubo.values)
    return Ising(
        sign * (0.5 * qubo.linear + 0.25 * coupled),
        qubo.rows,
        qubo.cols,
        0.25 * qubo.values,
        qubo.offset + 0.5 * float(qubo.linear.sum()) + 0.25 * float(qubo.values.sum()),
        sign,
        qubo.labels,
    )


def _sum_per_bit(
    n: int, rows: NDArray[np.int32], cols: NDArray[np.int32], values: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Σ_{j≠i} of the values of the pairs that hold i, (n,)."""
    # Without pairs bincount forgets the weights and counts in integers.
    total = np.bincount(rows, values, minlength=n) + np.bincount(cols, values, minlength=n)
    return total.astype(np.float64)
