"""Embeddings into graphs of annealers: the smaller of two ways, in a process that may die."""

import subprocess

import pytest

from tests.helpers.instance_case import binary_instance
from tgvdp.errors import InputError
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.solvers.samplers import embedding
from tgvdp.solvers.samplers.embedding import embedding_of, fineness

pytest.importorskip("minorminer")
pytest.importorskip("dwave.graphs")

pytestmark = pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")


def test_a_complete_graph_takes_the_clique_and_a_strip_takes_short_chains():
    dense, strip = (encode(binary_instance(12), word, 1.0).qubo for word in ("unary", "unary+multiplier"))
    clique = embedding_of(dense, "zephyr", 1, 0.01)  # no time for minorminer
    sparse = embedding_of(strip, "zephyr", 1, 20.0)
    assert clique.method == "clique"
    assert clique.longest_chain <= 5
    assert sparse.method == "minorminer"
    assert strip.n <= sparse.qubits < 0.5 * clique.qubits


def test_bits_without_couplers_take_a_qubit_each():
    found = embedding_of(encode(binary_instance(2, distance_units=1.0), "unary", 1.0).qubo, "pegasus", 1, 5.0)
    assert (found.qubits, found.longest_chain) == (1, 1)


def test_a_process_that_dies_found_none(monkeypatch):
    def dies(*_, **__):
        raise subprocess.CalledProcessError(-11, "python")

    monkeypatch.setattr(embedding.subprocess, "run", dies)
    found = embedding_of(encode(binary_instance(4), "unary", 1.0).qubo, "zephyr", 1, 5.0)
    assert (found.qubits, found.longest_chain, found.method) == (None, None, None)


def test_unknown_graphs_are_refused():
    with pytest.raises(InputError, match="there is no 'chimera'"):
        embedding_of(encode(binary_instance(4), "unary", 1.0).qubo, "chimera", 1, 5.0)


def test_fineness_is_relative_to_what_fills_the_range():
    qubo = encode(binary_instance(8), "unary", 1.0).qubo
    fine = fineness(qubo)
    assert 0.0 < fine.finest_coupling < 1.0
    scaled = fineness(encode(binary_instance(8, dv_mps=2.0), "unary", 4.0).qubo)  # all energies times four
    assert scaled == pytest.approx(fine)
