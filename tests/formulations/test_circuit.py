"""Ising forms, QAOA circuits and their simulation, against brute force and a reference simulator."""

import re

import numpy as np
import pytest
from hypothesis import given

from tests.helpers.qubo_case import qubos, random_qubo
from tgvdp.errors import InputError
from tgvdp.formulations.circuit.qaoa import (
    Angles,
    checked_angles,
    energy_scale,
    interpolated,
    qaoa_circuit,
    qasm3,
    ramp_angles,
)
from tgvdp.formulations.circuit.statevector import MAX_QUBITS, evaluate, sample, statevector
from tgvdp.formulations.circuit.walls import Walls
from tgvdp.formulations.qubo.ising import ising_of
from tgvdp.formulations.qubo.qubo import bits_of

PAULI_X = np.array([[0, 1], [1, 0]])
PAULI_Z = np.diag([1, -1])


def angles(p, seed):
    rng = np.random.default_rng(seed)
    return checked_angles(rng.normal(size=p), rng.normal(size=p))


def on_qubit(matrix, qubit, n):
    """A matrix on one of n qubits; qubit 0 is the lowest bit of the index."""
    return np.kron(np.kron(np.eye(1 << (n - 1 - qubit)), matrix), np.eye(1 << qubit))


def rotation(generator, angle):
    """exp(−i·angle·G/2) for G² = 1."""
    return np.cos(angle / 2) * np.eye(len(generator)) - 1j * np.sin(angle / 2) * generator


def run_gates(circuit):
    """Apply the gates one by one as full matrices to |0…0⟩."""
    n = circuit.n
    state = np.zeros(1 << n, dtype=complex)
    state[0] = 1.0
    for gate in circuit.gates:
        if gate.name == "h":
            matrix = on_qubit((PAULI_X + PAULI_Z) / np.sqrt(2), gate.qubits[0], n)
        elif gate.name == "rzz":
            z, other = (on_qubit(PAULI_Z, qubit, n) for qubit in gate.qubits)
            matrix = rotation(z @ other, gate.angle)
        else:
            pauli = {"rz": PAULI_Z, "rx": PAULI_X}[gate.name]
            matrix = rotation(on_qubit(pauli, gate.qubits[0], n), gate.angle)
        state = matrix @ state
    return state


@pytest.mark.parametrize("sign", [1, -1])
@given(qubo=qubos())
def test_ising_equals_qubo_on_all_strings(sign, qubo):
    ising = ising_of(qubo, sign)
    bits = bits_of(np.arange(1 << qubo.n), qubo.n)
    spins = ising.spins(bits)
    assert np.array_equal(2 * bits, 1 + sign * spins)
    assert np.array_equal(ising.energy(spins), qubo.all_energies())  # quarters of integers are exact
    assert ising.labels == qubo.labels


@given(qubos())
def test_energy_scale_is_the_spread_over_all_strings(qubo):
    assert energy_scale(ising_of(qubo, -1)) == pytest.approx(np.std(qubo.all_energies()), abs=1e-12)


@pytest.mark.parametrize(("n", "p"), [(1, 1), (3, 2), (6, 3), (7, 1)])
def test_statevector_equals_the_gates_up_to_the_phase_of_the_offset(n, p):
    qubo, turns = random_qubo(n, n), angles(p, p)
    ising = ising_of(qubo, -1)
    state = statevector(qubo.all_energies(), turns)
    reference = run_gates(qaoa_circuit(ising, turns)) * np.exp(-1j * ising.offset * turns.gamma.sum())
    assert np.abs(state - reference).max() < 1e-12


def test_statevector_equals_a_reference_circuit():
    quantum_info = pytest.importorskip("qiskit.quantum_info")
    from tgvdp.solvers.circuit.qiskit import qiskit_circuit

    qubo, turns = random_qubo(11, 5), angles(3, 7)
    ising = ising_of(qubo, -1)
    reference = quantum_info.Statevector(qiskit_circuit(qaoa_circuit(ising, turns), measure=False)).data
    state = statevector(qubo.all_energies() - ising.offset, turns)
    assert np.abs(state - reference).max() < 1e-10


@pytest.mark.parametrize("n", [2, 6])
def test_gradient_equals_differences(n):
    energies, turns = random_qubo(n, 3).all_energies(), angles(2, 4)
    value = evaluate(energies, turns)
    assert value.energy == pytest.approx(np.sum(np.abs(statevector(energies, turns)) ** 2 * energies))
    step = 1e-6
    for name in ("gamma", "beta"):
        for layer in range(2):
            shift = np.where(np.arange(2) == layer, step, 0.0)
            up, down = (
                evaluate(energies, turns._replace(**{name: getattr(turns, name) + sign * shift})).energy
                for sign in (1, -1)
            )
            assert getattr(value, name)[layer] == pytest.approx((up - down) / (2 * step), rel=1e-6, abs=1e-7)


def test_slow_ramp_ends_in_the_lowest_state_and_the_opposite_mixer_in_the_highest():
    qubo = random_qubo(4, 11)
    energies = qubo.all_energies()
    ramp = ramp_angles(3000, 0.3, energy_scale(ising_of(qubo, -1)))
    chance = np.abs(statevector(energies, ramp)) ** 2
    assert chance[np.argmin(energies)] > 0.95
    wrong = np.abs(statevector(energies, Angles(ramp.gamma, -ramp.beta))) ** 2
    assert wrong[np.argmax(energies)] > 0.95


def test_interpolation_keeps_a_ramp_and_its_ends():
    line = Angles(np.arange(1.0, 5.0), np.arange(4.0, 0.0, -1.0))
    more = interpolated(line)
    assert more.gamma == pytest.approx([1.0, 1.75, 2.5, 3.25, 4.0])
    assert more.beta == pytest.approx([4.0, 3.25, 2.5, 1.75, 1.0])


def test_samples_follow_the_state():
    chance = np.array([0.5, 0.0, 0.2, 0.3])
    drawn = sample(np.sqrt(chance).astype(complex), 20_000, np.random.default_rng(1))
    assert np.bincount(drawn, minlength=4) / 20_000 == pytest.approx(chance, abs=0.015)
    assert not np.any(drawn == 1)


def test_qasm_declares_what_it_uses_and_keeps_all_digits():
    qubo, turns = random_qubo(3, 2), angles(1, 1)
    circuit = qaoa_circuit(ising_of(qubo, -1), turns)
    text = qasm3(circuit, ["a comment"])
    assert text.startswith('OPENQASM 3.0;\ninclude "stdgates.inc";\n// a comment\n')
    angle = [float(found) for found in re.findall(r"^r\w+\((.*?)\)", text, re.MULTILINE)]
    assert angle == [gate.angle for gate in circuit.gates if gate.name != "h"]
    assert repr(circuit.offset) in text


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: checked_angles([1.0], [1.0, 2.0]), "as many gamma as beta"),
        (lambda: checked_angles([], []), "one per layer"),
        (lambda: checked_angles([np.nan], [1.0]), "finite"),
        (lambda: ramp_angles(0, 0.5, 1.0), "layers"),
        (lambda: ramp_angles(2, 0.5, 0.0), "energy scale"),
        (lambda: qaoa_circuit(ising_of(random_qubo(2, 0), 1), angles(1, 0)), "convention"),
        (lambda: ising_of(random_qubo(2, 0), 0), "sign"),
        (lambda: ising_of(random_qubo(2, 0), 1).energy([0, 1]), "spins"),
        (lambda: statevector(np.zeros(3), angles(1, 0)), "power of two"),
        (lambda: statevector(np.zeros(2 << MAX_QUBITS), angles(1, 0)), "more than"),
    ],
)
def test_wrong_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_walls_are_the_full_circuit_within_its_strings_in_order():
    """Against matrices over all strings, the moves as X between projectors on the neighbours, and the start's sines."""
    qubo, registers = random_qubo(5, 3), ((0, 1, 2), (3, 4))
    walls, chosen = Walls(registers), angles(3, 2)
    bits = walls.bits(np.arange(12))
    index = bits @ (1 << np.arange(5))
    assert np.allclose(walls.energies(qubo), qubo.all_energies()[index])
    one, zero = np.diag([0, 1]), np.diag([1, 0])
    state = np.zeros(32, dtype=complex)
    state[index] = np.outer(*(np.sin(np.pi * np.arange(1, h + 2) / (h + 2)) for h in (3, 2))).ravel()
    state /= np.linalg.norm(state)
    for gamma, beta in zip(*chosen, strict=True):
        state = np.exp(-1j * gamma * qubo.all_energies()) * state
        for first in (0, 1):
            for register in registers:
                for j in range(first, len(register), 2):
                    below = on_qubit(one, register[j - 1], 5) if j else np.eye(32)
                    above = on_qubit(zero, register[j + 1], 5) if j + 1 < len(register) else np.eye(32)
                    there = below @ above
                    move = there @ on_qubit(PAULI_X, register[j], 5)
                    state = state + there @ ((np.cos(beta) - 1.0) * state) - 1j * np.sin(beta) * (move @ state)
    found = walls.state(walls.energies(qubo), chosen)
    assert np.allclose(found, state[index]) and np.linalg.norm(found) == pytest.approx(1.0)


def test_a_slow_ramp_of_walls_ends_in_the_lowest_string_in_order():
    qubo = random_qubo(5, 8)
    walls = Walls(((0, 1, 2), (3, 4)))
    energies = walls.energies(qubo)
    state = walls.state(energies, ramp_angles(2000, 0.3, float(energies.std())))
    assert np.argmax(np.abs(state)) == np.argmin(energies) and np.abs(state).max() ** 2 > 0.9
