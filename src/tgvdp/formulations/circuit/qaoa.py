"""The quantum approximate optimisation algorithm as plain data (Farhi, Goldstone and Gutmann 2014, arXiv 1411.4028).

With the cost H_C = Σ hᵢ·Zᵢ + Σ Jᵢⱼ·Zᵢ·Zⱼ of the convention x = (1 − Z)/2 and the mixer H_M = Σ Xᵢ, p layers make

    |ψ⟩ = Π_k exp(−i·β_k·H_M)·exp(−i·γ_k·H_C) |+⟩ⁿ,

in gates RZ(2γ·hᵢ), RZZ(2γ·Jᵢⱼ) and RX(2β), because RZ(θ) = exp(−i·θ·Z/2). |+⟩ is the *highest* state of Σ X: a ramp
that is to follow the lowest state starts from H_M = −Σ X, hence the negative β of `ramp_angles`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tgvdp.errors import InputError
from tgvdp.formulations.qubo.ising import Ising

GateName = Literal["h", "rz", "rzz", "rx"]


class Gate(NamedTuple):
    """One gate: its name, the qubits it acts on and its angle in radians (0 for h, which has none)."""

    name: GateName
    qubits: tuple[int, ...]
    angle: float = 0.0


@dataclass(frozen=True)
class Circuit:
    """Gates on qubits that start in |0⟩, measured at the end.

    Attributes
    ----------
    labels : tuple of str
        Name of the bit that each qubit means; outcome |1⟩ is x = 1.
    gates : tuple of Gate
    offset : float
        Constant of the energy, which no gate carries (it is a global phase).
    """

    labels: tuple[str, ...]
    gates: tuple[Gate, ...]
    offset: float

    @property
    def n(self) -> int:
        """Number of qubits."""
        return len(self.labels)


class Angles(NamedTuple):
    """Angles of the layers.

    Attributes
    ----------
    gamma, beta : (p,) float64
        Of the cost (per unit of energy) and of the mixer, in radians.
    """

    gamma: NDArray[np.float64]
    beta: NDArray[np.float64]


def checked_angles(gamma: ArrayLike, beta: ArrayLike) -> Angles:
    """Make angles from two sequences of the same length, one entry per layer.

    Raises
    ------
    InputError
        When their lengths differ, there is none, or one is not finite.
    """
    cost, mixer = np.atleast_1d(np.asarray(gamma, dtype=float)), np.atleast_1d(np.asarray(beta, dtype=float))
    if cost.ndim != 1 or cost.shape != mixer.shape or not cost.size:
        raise InputError(f"qaoa: as many gamma as beta, one per layer, got {cost.size} and {mixer.size}")
    if not (np.isfinite(cost).all() and np.isfinite(mixer).all()):
        raise InputError("qaoa: angles must be finite")
    return Angles(cost, mixer)


def ramp_angles(layers: int, time_step: float, energy_scale: float) -> Angles:
    """Linear ramp from the mixer to the cost: the Trotterised anneal of −Σ X into H_C.

    Parameters
    ----------
    layers : int
        p ≥ 1.
    time_step : float
        Angle of a whole layer, rad; 0.5 to 1 is usual.
    energy_scale : float
        Energy that counts as 1, in the units of the cost.

    Returns
    -------
    Angles
        γ_k = f_k·time_step/energy_scale and β_k = −(1 − f_k)·time_step with f_k = (k + ½)/p.
    """
    if layers < 1 or not energy_scale > 0.0:
        raise InputError(f"qaoa: a ramp needs layers ≥ 1 and a positive energy scale, got {layers} and {energy_scale}")
    fraction = (np.arange(layers) + 0.5) / layers
    return checked_angles(time_step * fraction / energy_scale, -time_step * (1.0 - fraction))


def interpolated(angles: Angles) -> Angles:
    """Starting angles for one more layer: INTERP (Zhou et al., Phys. Rev. X 10, 021067, 2020, eq. B1)."""
    p = len(angles.gamma)
    k = np.arange(p + 1)

    def stretched(values: NDArray[np.float64]) -> NDArray[np.float64]:
        padded = np.concatenate(([0.0], values, [0.0]))
        return k / p * padded[k] + (p - k) / p * padded[k + 1]

    return Angles(stretched(angles.gamma), stretched(angles.beta))


def energy_scale(ising: Ising) -> float:
    """Root mean square energy above the mean over all bit strings, √(Σh² + ΣJ²): what γ is measured against.

    The terms of an Ising energy are orthogonal over all strings, so that the variance is the sum of their squares.
    """
    return float(np.sqrt(np.sum(ising.fields**2) + np.sum(ising.couplings**2)))


def qaoa_circuit(ising: Ising, angles: Angles) -> Circuit:
    """Build the circuit of some angles.

    Parameters
    ----------
    ising : Ising
        In the convention of qubits, sign −1.
    angles : Angles

    Raises
    ------
    InputError
        When the convention is the other one.
    """
    if ising.sign != -1:
        raise InputError("qaoa: circuits need the convention x = (1 − Z)/2, sign -1")
    return Circuit(ising.labels, tuple(_gates(ising, angles)), ising.offset)


def _gates(ising: Ising, angles: Angles) -> Iterator[Gate]:
    qubits = range(ising.n)
    yield from (Gate("h", (qubit,)) for qubit in qubits)
    pairs = list(zip(ising.rows.tolist(), ising.cols.tolist(), strict=True))
    for gamma, beta in zip(angles.gamma.tolist(), angles.beta.tolist(), strict=True):
        yield from (
            Gate("rz", (qubit,), 2.0 * gamma * h) for qubit, h in zip(qubits, ising.fields.tolist(), strict=True) if h
        )
        yield from (
            Gate("rzz", pair, 2.0 * gamma * coupling)
            for pair, coupling in zip(pairs, ising.couplings.tolist(), strict=True)
        )
        yield from (Gate("rx", (qubit,), 2.0 * beta) for qubit in qubits)


#: RZZ is not among the standard gates of OpenQASM 3.
_RZZ = "gate rzz(theta) a, b { cx a, b; rz(theta) b; cx a, b; }"


def qasm3(circuit: Circuit, comments: Sequence[str] = ()) -> str:
    """Write a circuit in OpenQASM 3, angles with 17 digits.

    Parameters
    ----------
    circuit : Circuit
    comments : sequence of str
        Lines to put at the head.
    """
    lines = ["OPENQASM 3.0;", 'include "stdgates.inc";', *(f"// {line}" for line in comments)]
    lines += [f"// energy offset {circuit.offset!r}; bits: {' '.join(circuit.labels)}"]
    lines += [_RZZ, f"qubit[{circuit.n}] q;", f"bit[{circuit.n}] c;"]
    for gate in circuit.gates:
        angle = "" if gate.name == "h" else f"({gate.angle!r})"
        lines.append(f"{gate.name}{angle} {', '.join(f'q[{qubit}]' for qubit in gate.qubits)};")
    return "\n".join([*lines, "c = measure q;", ""])
