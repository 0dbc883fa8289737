"""QAOA as a solver, without noise and on a simulated machine."""

import math

import numpy as np
import pytest

from tests.helpers.instance_case import binary_instance
from tgvdp.errors import InputError
from tgvdp.formulations.circuit.statevector import evaluate
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.circuit.angles import RAMP_STEPS, space_of
from tgvdp.solvers.registry import solve


def details(instance, encoding="unary", **allowance):
    return solve(instance, "qaoa", encoding, allowance=Allowance(**allowance)).details


def test_optimised_angles_are_stationary_and_better_with_more_layers():
    pytest.importorskip("scipy")
    from tgvdp.solvers.circuit.angles import optimised_angles

    space = space_of(encode(binary_instance(4), "unary"), "x")
    expected = []
    for layers in (1, 2, 3):
        found = optimised_angles(space, layers, 2, seed=1)
        value = evaluate(space.energies, found.angles)
        assert np.abs(value.gamma).max() / space.scale < 1e-3 * space.scale
        assert np.abs(value.beta).max() < 1e-3 * space.scale
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


def test_a_fixed_ramp_is_one_of_those_that_are_tried():
    instance = binary_instance(4)
    best = details(instance, angles="ramp", layers=5)
    fixed = [details(instance, angles="ramp", layers=5, step=step) for step in RAMP_STEPS]
    assert min(one["expected_energy"] for one in fixed) == best["expected_energy"]
    assert all(one["evaluations"] == 0 for one in fixed)


def test_walls_never_break_a_register_and_find_more():
    instance = binary_instance(6, distance_units=6.0)
    turned, moved = (details(instance, angles="ramp", layers=10, mixer=mixer) for mixer in ("x", "walls"))
    assert moved["success_probability"] > turned["success_probability"]
    assert moved["random_probability"] == turned["random_probability"]
    space = space_of(encode(instance, "unary"), "walls")
    registers = [
        check
        for z in range(space.energies.size)
        for check in encode(instance, "unary").decode(space.bits(z)).checks
        if "registers" in check.name
    ]
    assert all(check.satisfied for check in registers) and registers


def test_walls_need_registers():
    with pytest.raises(InputError, match="strings in order, as unary has"):
        details(binary_instance(4), "bits", angles="ramp", mixer="walls")


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
    ideal = details(binary_instance(4), reads=2000, layers=1)
    assert found["success_probability"] == found["best_reads"] / 2000  # of the shots, with their noise
    assert found["random_probability"] < found["success_probability"] < ideal["success_probability"]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize(
    ("backend", "message"), [("fake_nowhere", "no machine is called"), ("fake_manila", "5 qubits, the circuit 8")]
)
def test_machines_that_do_not_fit_are_refused(backend, message):
    pytest.importorskip("qiskit_aer")
    with pytest.raises(InputError, match=message):
        details(binary_instance(4), "bits", layers=1, backend=backend)
