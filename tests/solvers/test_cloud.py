"""The annealer's adapter on a machine that is simulated offline."""

import pytest

from tests.helpers.instance_case import binary_instance
from tgvdp.errors import InputError
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.formulations.qubo.ising import ising_of
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.registry import solve


def test_a_mock_machine_finds_a_small_optimum():
    testing = pytest.importorskip("dwave.system.testing")
    from tgvdp.solvers.samplers.cloud import embedded_solution

    instance = binary_instance(4)
    encoded = encode(instance, "unary")
    found = embedded_solution(testing.MockDWaveSampler(), encoded, Allowance(reads=50))
    assert found.objective == solve(instance, "dp").objective
    assert found.feasible
    assert not found.optimal
    assert found.details["reads"] == 50
    assert found.details["qubits"] >= encoded.qubo.n


def test_chain_strength_is_relative_and_the_anneal_time_reaches_the_machine(monkeypatch):
    testing = pytest.importorskip("dwave.system.testing")
    from tgvdp.solvers.samplers.cloud import embedded_solution

    machine = testing.MockDWaveSampler()
    asked, sample = {}, machine.sample
    monkeypatch.setattr(machine, "sample", lambda bqm, **given: asked.update(given) or sample(bqm, **given))
    encoded = encode(binary_instance(4), "unary")
    found = embedded_solution(machine, encoded, Allowance(reads=5, chain_strength=2.0, anneal_us=50.0))
    ising = ising_of(encoded.qubo, 1)
    assert found.details["chain_strength"] == 2.0 * max(abs(ising.fields).max(), abs(ising.couplings).max())
    assert asked["annealing_time"] == found.details["anneal_us"] == 50.0
    assert 0.0 <= found.details["broken_chains"] <= 1.0


def test_what_does_not_fit_is_said():
    testing = pytest.importorskip("dwave.system.testing")
    from tgvdp.solvers.samplers.cloud import embedded_solution

    machine = testing.MockDWaveSampler(topology_type="chimera", topology_shape=[1, 1, 4])
    with pytest.raises(InputError, match="16 bits do not fit"):
        embedded_solution(machine, encode(binary_instance(8), "bits"), Allowance())


def test_without_an_account_one_line_says_so(monkeypatch, tmp_path):
    pytest.importorskip("dwave.system")
    for name in ("DWAVE_API_TOKEN", "DWAVE_CONFIG_FILE", "DWAVE_PROFILE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    with pytest.raises(InputError, match="dwave config create"):
        solve(binary_instance(4), "dwave")
