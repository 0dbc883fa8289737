"""QAOA whose mixer moves the walls of unary registers, and so never leaves the strings in order.

A register t_1 ≥ t_2 ≥ … of h bits has h + 1 such strings, its levels. Moving its wall by one level is an X on bit j
while the bit below is 1 and the bit above is 0 (walls: Chancellor 2019; mixers that keep constraints: Hadfield et al.,
Algorithms 12, 34, 2019). With A the sum of these moves, a layer turns by exp(−i·β·A) in two Trotter steps, those of the
even and those of the odd bits, which commute among themselves; each turn is an RX with two controls. The registers
start in the highest state of A, whose amplitudes are a half wave of the sine: a ramp follows it as it follows |+⟩.

Only the strings in order are simulated, Π (h + 1) of them in place of 2^Σh: 86 400 of 2²⁵ at N = 10.
"""

from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tgvdp.errors import InputError
from tgvdp.formulations.circuit.qaoa import Angles
from tgvdp.formulations.qubo.qubo import Qubo

#: Most strings in order that are simulated.
MAX_STATES = 1 << 20

_State = NDArray[np.complex128]


@dataclass(frozen=True)
class Walls:
    """The strings in order of some registers, counted with the last register fastest.

    Attributes
    ----------
    registers : tuple of tuple of int
        Bits of each register, the lowest level first; together all bits.

    Raises
    ------
    InputError
        When there are more than `MAX_STATES` of them.
    """

    registers: tuple[tuple[int, ...], ...]

    def __post_init__(self) -> None:
        if not self.registers or prod(self.shape) > MAX_STATES:
            raise InputError(
                f"qaoa: mixer walls needs 2 to {MAX_STATES} strings in order, as unary has, got {prod(self.shape)}"
            )

    @property
    def shape(self) -> tuple[int, ...]:
        """Levels of each register."""
        return tuple(len(register) + 1 for register in self.registers)

    def energies(self, qubo: Qubo) -> NDArray[np.float64]:
        """Energy of every string in order: sums over pairs of registers of what their levels cost together."""
        weights = np.zeros((qubo.n, qubo.n))
        weights[qubo.rows, qubo.cols] = qubo.values
        weights += weights.T
        total = np.full(self.shape, qubo.offset)
        for r, own in enumerate(self.registers):
            alone = np.concatenate(([0.0], np.cumsum(qubo.linear[list(own)])))
            alone += 0.5 * np.diagonal(_of_levels(weights[np.ix_(own, own)]))
            total += self._along(alone, r)
            for s in range(r + 1, len(self.registers)):
                total += self._along(_of_levels(weights[np.ix_(own, self.registers[s])]), r, s)
        return total.reshape(-1)

    def _along(self, table: NDArray[np.float64], *axes: int) -> NDArray[np.float64]:
        """A table over some registers, in a shape that adds to the whole."""
        return table.reshape([size if axis in axes else 1 for axis, size in enumerate(self.shape)])

    def bits(self, index: ArrayLike) -> NDArray[np.int8]:
        """Bit strings of numbers: (...) → (..., n) int8."""
        levels = np.unravel_index(np.asarray(index, dtype=np.int64), self.shape)
        strings = np.zeros((*np.shape(index), sum(map(len, self.registers))), dtype=np.int8)
        for register, level in zip(self.registers, levels, strict=True):
            for j, bit in enumerate(register):
                strings[..., bit] = level > j
        return strings

    def state(self, energies: NDArray[np.float64], angles: Angles) -> _State:
        """Simulate the circuit: (Π (h + 1),) complex128."""
        state = np.ones(1, dtype=np.complex128)
        for size in self.shape:
            wave = np.sin(np.pi * np.arange(1, size + 1) / (size + 1))
            state = np.kron(state, wave / np.linalg.norm(wave))
        for gamma, beta in zip(angles.gamma.tolist(), angles.beta.tolist(), strict=True):
            state *= np.exp(-1j * gamma * energies)
            inner = state.size
            for size in self.shape:
                inner //= size
                register = state.reshape(-1, size, inner)
                for first in (0, 1):
                    _turn(register[:, first : size - 1 : 2], register[:, first + 1 :: 2], beta)
        return state


def _turn(lower: _State, upper: _State, beta: float) -> None:
    """exp(−i·β·X) between neighbouring levels, in place."""
    before = lower.copy()
    lower *= np.cos(beta)
    lower -= 1j * np.sin(beta) * upper
    upper *= np.cos(beta)
    upper -= 1j * np.sin(beta) * before


def _of_levels(block: NDArray[np.float64]) -> NDArray[np.float64]:
    """Couplings of bits (h, g) summed below each pair of levels: (h + 1, g + 1)."""
    table = np.zeros((block.shape[0] + 1, block.shape[1] + 1))
    table[1:, 1:] = block.cumsum(axis=0).cumsum(axis=1)
    return table
