"""Exact simulation of QAOA: the cost is a diagonal, the mixer a product, so a layer is one multiplication and n turns.

The state of n qubits is a vector of 2ⁿ amplitudes; entry z holds the bits xᵢ = (z >> i) & 1, as `Qubo.all_energies`
counts them and as registers of qubits do. The mixer turns `_GROUP` qubits at a time: their 32 × 32 matrix meets the
state as a matrix product, and the transposition that follows brings the next qubits to the fast end; after all groups
the order is the old one. At 20 qubits this takes less than half the time of one pass per qubit. Products come in
blocks that are too small for a threaded library to divide: results depend on no number of threads, and threads would
wait for each other longer than they work.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.formulations.circuit.qaoa import Angles

#: Most qubits that are simulated: 16 MiB of amplitudes, a quarter of a second per layer of an evaluation with gradient.
MAX_QUBITS = 20

#: Qubits that one product turns, and rows of a block: together under the size from which OpenBLAS divides a product.
_GROUP = 5
_ROWS = 16

_State = NDArray[np.complex128]


class Evaluation(NamedTuple):
    """Expected energy of a state and its gradient.

    Attributes
    ----------
    energy : float
    gamma, beta : (p,) float64
        Derivatives by the angles, per radian.
    """

    energy: float
    gamma: NDArray[np.float64]
    beta: NDArray[np.float64]


def statevector(energies: NDArray[np.float64], angles: Angles) -> _State:
    """Simulate the circuit.

    Parameters
    ----------
    energies : (2**n,) float64
        Energy of each bit string. A constant in it is a global phase.
    angles : Angles

    Returns
    -------
    (2**n,) complex128

    Raises
    ------
    InputError
        When there are more than `MAX_QUBITS` qubits, or the length is no power of two.
    """
    n = _qubits(energies)
    state = np.full(len(energies), 2.0 ** (-n / 2), dtype=np.complex128)
    for gamma, beta in zip(angles.gamma, angles.beta, strict=True):
        state *= np.exp(-1j * gamma * energies)
        for size in _groups(n):
            state = _rotated(_turned(state, _mixer(size, beta)), size)
    return state


def evaluate(energies: NDArray[np.float64], angles: Angles) -> Evaluation:
    """Expected energy and its exact gradient, by the adjoint of the circuit.

    The circuit is undone layer by layer on |ψ⟩ and on |λ⟩ = E·|ψ⟩; at each generator G the derivative is 2·Im⟨λ|G|ψ⟩.
    """
    n = _qubits(energies)
    state = statevector(energies, angles)
    adjoint = energies * state
    energy = float(np.sum(np.abs(state) ** 2 * energies))
    by_gamma, by_beta = np.empty_like(angles.gamma), np.empty_like(angles.beta)
    for layer in reversed(range(len(angles.gamma))):
        slope = 0.0
        for size in _groups(n):
            slope += _imaginary(adjoint, _turned(state, _sum_of_x(size)))
            undo = _mixer(size, -angles.beta[layer])
            state, adjoint = (_rotated(_turned(one, undo), size) for one in (state, adjoint))
        by_beta[layer] = 2.0 * slope
        by_gamma[layer] = 2.0 * _imaginary(adjoint, energies * state)
        phase = np.exp(1j * angles.gamma[layer] * energies)
        state *= phase
        adjoint *= phase
    return Evaluation(energy, by_gamma, by_beta)


def sample(state: _State, shots: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Measure a state: numbers of bit strings, (shots,) int64."""
    chances = np.cumsum(np.abs(state) ** 2)
    found = np.searchsorted(chances, rng.random(shots) * chances[-1], side="right")
    return np.asarray(found, dtype=np.int64)


def _qubits(energies: NDArray[np.float64]) -> int:
    n = len(energies).bit_length() - 1
    if len(energies) != 1 << max(n, 0):
        raise InputError(f"qaoa: the number of energies must be a power of two, got {len(energies)}")
    if n > MAX_QUBITS:
        raise InputError(f"qaoa: {n} qubits are more than the {MAX_QUBITS} that are simulated")
    return n


def _groups(n: int) -> list[int]:
    """Sizes of the groups of qubits, from the fast end of the state."""
    return [min(_GROUP, n - start) for start in range(0, n, _GROUP)]


def _turned(state: _State, matrix: _State) -> _State:
    """Apply a symmetric matrix to the qubits at the fast end."""
    rows = len(state) // len(matrix)
    blocks = state.reshape(-1, min(rows, _ROWS), len(matrix))
    return np.asarray(blocks @ matrix).reshape(-1)


def _rotated(state: _State, size: int) -> _State:
    """Bring the qubits of the next group to the fast end."""
    return np.ascontiguousarray(state.reshape(-1, 1 << size).T).reshape(-1)


def _imaginary(first: _State, second: _State) -> float:
    """Im⟨first|second⟩."""
    return float(np.sum(first.real * second.imag) - np.sum(first.imag * second.real))


def _mixer(size: int, beta: float) -> _State:
    """exp(−i·β·ΣX) of some qubits; the matrix is symmetric."""
    one = np.array([[np.cos(beta), -1j * np.sin(beta)], [-1j * np.sin(beta), np.cos(beta)]])
    all_of_them = np.ones((1, 1), dtype=np.complex128)
    for _ in range(size):
        all_of_them = np.kron(all_of_them, one)
    return all_of_them


def _sum_of_x(size: int) -> _State:
    """ΣX of some qubits: 1 between strings that differ in one bit."""
    z = np.arange(1 << size)
    differ = z[:, None] ^ z[None, :]
    return np.asarray((differ > 0) & (differ & (differ - 1) == 0), dtype=np.complex128)
