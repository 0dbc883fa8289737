"""QAOA as a solver, without noise and on a simulated machine."""

import math

import numpy as np
import pytest

from tests.helpers.instance_case import binary_instance
from tgvdp.errors import InputError
from tgvdp.formulations.circuit.qaoa import energy_scale
from tgvdp.formulations.circuit.statevector import evaluate
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.formulations.qubo.ising import ising_of
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.registry import solve


def details(instance, encoding="unary", **allowance):
    return solve(instance, "qaoa", encoding, allowance=Allowance(**allowance)).details


def test_optimised_angles_are_stationary_and_better_with_more_layers():
    pytest.importorskip("scipy")
    from tgvdp.solvers.circuit.angles import optimised_angles

    qubo = encode(binary_instance(4), "unary").qubo
    energies, scale = qubo.all_energies(), energy_scale(ising_of(qubo, -1))
    expected = []
    for layers in (1, 2, 3):
        found = optimised_angles(energies, scale, layers, 2, seed=1)
        value = evaluate(energies, found.angles)
        assert np.abs(value.gamma).max() / scale < 1e-3 * scale
        assert np.abs(value.beta).max() < 1e-3 * scale
        expected.append(value.energy)
    assert expected == sorted(expected, reverse=True)


def test_success_counts_the_optima_exactly():
    pytest.importorskip("scipy")
    instance = binary_instance(4)
    optimised = details(instance, reads=2000)
    ramp = details(instance, reads=2000, angles="ramp")
    assert optimised["random_probability"] == solve(instance, "dp").n_optimal / 2**4
    assert optimised["success_probability"] > ramp["success_probability"] > ramp["random_probability"]
    p = optimised["success_probability"]
    assert optimised["best_reads"] / 2000 == pytest.approx(p, abs=5 * math.sqrt(p * (1 - p) / 2000))


def test_unary_beats_bits():
    pytest.importorskip("scipy")
    instance = binary_instance(4)
    assert details(instance)["success_probability"] > 10 * details(instance, "bits")["success_probability"]


def test_too_many_and_no_qubits_are_refused():
    with pytest.raises(InputError, match="1 to 20 qubits"):
        details(binary_instance(12), "bits")
    with pytest.raises(InputError, match="1 to 20 qubits"):
        details(binary_instance(1, distance_units=0.0))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_noise_of_a_machine_lowers_the_success():
    pytest.importorskip("qiskit_aer")
    found = details(binary_instance(4), reads=2000, layers=1, backend="fake_manila")
    assert found["two_qubit_gates"] > 0
    assert found["random_probability"] < found["best_reads"] / 2000 < found["success_probability"]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize(
    ("backend", "message"), [("fake_nowhere", "no machine is called"), ("fake_manila", "5 qubits, the circuit 8")]
)
def test_machines_that_do_not_fit_are_refused(backend, message):
    pytest.importorskip("qiskit_aer")
    with pytest.raises(InputError, match=message):
        details(binary_instance(4), "bits", layers=1, backend=backend)
