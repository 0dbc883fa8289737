"""Files of other programs, each read again and compared with what was written."""

import json

import numpy as np
import pytest

from tgvdp.cli import main
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.formulations.qubo.qubo import bits_of
from tgvdp.solvers.registry import solve

PARAMS = {
    "kind": "binary",
    "model": "constant",
    "N": 5,
    "dt_s": 1.0,
    "dv_mps": 0.1,
    "acc_units": 1,
    "dec_units": 1,
    "cap_units": 2,
    "D_units": 4.0,
    "alpha": 0.3,
}

DEMAND = {
    "kind": "demand", "N": 4, "dt_s": 15, "notches": 2, "mass_kg": 300000, "rot": 1.08,
    "davis_SI": [1770, 35.4, 6.6], "vmax_kmh": 160, "D_m": 500, "tol_m": 40, "v_end_max_mps": 1.5,
    "P_max_W": 9.8e6, "cost_ref_kmh": 220, "alpha": 0.3,
}  # fmt: skip


@pytest.fixture
def trip(tmp_path):
    path = tmp_path / "trip.json"
    path.write_text(json.dumps({"id": "trip", "params": PARAMS}))
    return path


def formulate(trip, target, *more):
    output = trip.with_suffix(f".{target}")
    assert main(["formulate", str(trip), "--to", target, "-o", str(output), *more]) == 0
    return output


def qubo_of_file(trip, encoding):
    return encode(read_instance(trip), encoding).qubo


@pytest.mark.parametrize("encoding", ["bits", "unary"])
def test_bqm_file(trip, encoding):
    dimod = pytest.importorskip("dimod")
    output = formulate(trip, "bqm", "--encoding", encoding)
    with output.open("rb") as file:
        bqm = dimod.BinaryQuadraticModel.from_file(file)
    qubo = qubo_of_file(trip, encoding)
    assert tuple(bqm.variables) == qubo.labels
    strings = bits_of(np.arange(1 << qubo.n), qubo.n)
    assert np.allclose(bqm.energies((strings, qubo.labels)), qubo.all_energies(), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("encoding", ["bits", "unary"])
def test_coo_file_and_its_sidecar(trip, encoding):
    pytest.importorskip("dimod")
    from dimod.serialization import coo

    output = formulate(trip, "coo", "--encoding", encoding)
    bqm = coo.loads(output.read_text())
    sidecar = json.loads(output.with_name(output.name + ".json").read_text())
    qubo = qubo_of_file(trip, encoding)
    assert sidecar == {"offset": qubo.offset, "labels": list(qubo.labels)}
    assert {i: bias for i, bias in bqm.linear.items() if bias} == {i: a for i, a in enumerate(qubo.linear) if a}
    pairs = zip(qubo.rows.tolist(), qubo.cols.tolist(), strict=True)
    assert {tuple(sorted(pair)): bias for pair, bias in bqm.quadratic.items()} == dict(
        zip(pairs, qubo.values.tolist(), strict=True)
    )


def test_coo_text_has_no_exponents(trip):
    """dimod passes over lines with one without a word: of steps of 1 mm/s nothing was left."""
    pytest.importorskip("dimod")
    from dimod.serialization import coo

    trip.write_text(json.dumps({"id": "trip", "params": PARAMS | {"dv_mps": 0.001}}))
    bqm = coo.loads(formulate(trip, "coo", "--encoding", "unary").read_text())
    qubo = qubo_of_file(trip, "unary")
    assert sorted(bqm.quadratic.values()) == sorted(qubo.values.tolist())


def test_graph_file(trip):
    networkx = pytest.importorskip("networkx")
    output = formulate(trip, "graph", "--encoding", "unary")
    graph = networkx.node_link_graph(json.loads(output.read_text()), edges="edges")
    qubo = qubo_of_file(trip, "unary")
    assert graph.graph["offset"] == qubo.offset
    assert [graph.nodes[label]["bias"] for label in qubo.labels] == qubo.linear.tolist()
    assert graph.number_of_edges() == qubo.stats.couplers
    for row, col, value in zip(qubo.rows, qubo.cols, qubo.values, strict=True):
        assert graph.edges[qubo.labels[row], qubo.labels[col]]["coupling"] == value


def test_qasm_file_is_the_circuit(trip):
    qasm3 = pytest.importorskip("qiskit.qasm3")
    pytest.importorskip("qiskit_qasm3_import")
    from qiskit.quantum_info import Statevector

    from tgvdp.formulations.circuit.qaoa import energy_scale, ramp_angles
    from tgvdp.formulations.circuit.statevector import statevector
    from tgvdp.formulations.qubo.ising import ising_of
    from tgvdp.solvers.exchange import QASM_TIME_STEP

    circuit = qasm3.loads(formulate(trip, "qasm3", "--encoding", "unary", "--layers", "2").read_text())
    circuit.remove_final_measurements()
    qubo = qubo_of_file(trip, "unary")
    ising = ising_of(qubo, -1)
    ours = statevector(qubo.all_energies() - ising.offset, ramp_angles(2, QASM_TIME_STEP, energy_scale(ising)))
    assert np.abs(Statevector(circuit).data - ours).max() < 1e-10


def test_cqm_file(trip):
    dimod = pytest.importorskip("dimod")
    with open(formulate(trip, "cqm"), "rb") as file:
        read = dimod.ConstrainedQuadraticModel.from_file(file)
    from tgvdp.solvers.programs.cqm import cqm_of

    assert read.is_equal(cqm_of(read_instance(trip)).cqm)
    sampleset = dimod.ExactCQMSolver().sample_cqm(read)
    best = sampleset.filter(lambda row: row.is_feasible).first.energy
    assert best == pytest.approx(solve(read_instance(trip), "dp").objective)


def test_cqm_file_of_demand(tmp_path, capsys):
    dimod = pytest.importorskip("dimod")
    path = tmp_path / "demand.json"
    path.write_text(json.dumps({"id": "d", "params": DEMAND}))
    with open(formulate(path, "cqm"), "rb") as file:
        read = dimod.ConstrainedQuadraticModel.from_file(file)
    from tgvdp.solvers.programs.cqm import cqm_of

    assert read.is_equal(cqm_of(read_instance(path)).cqm)
    assert {read.vartype(name).name for name in read.variables} == {"BINARY", "INTEGER", "REAL"}
    for target in ("lp", "coo"):
        assert main(["formulate", str(path), "--to", target, "-o", str(tmp_path / "no")]) == 3
        assert "write it --to cqm" in capsys.readouterr().err


@pytest.mark.parametrize("target", ["lp", "mps"])
def test_text_goes_to_stdout(trip, target, capsys):
    assert main(["formulate", str(trip), "--to", target, "-o", "-"]) == 0
    out = capsys.readouterr().out
    assert out == formulate(trip, target).read_text()
    assert out.rstrip().endswith({"lp": "End", "mps": "ENDATA"}[target])


@pytest.mark.parametrize(
    ("arguments", "code", "part"),
    [
        (["--to", "coo", "-o", "-"], 2, "sidecar"),
        (["--to", "bqm", "-o", "-"], 2, "is binary"),
        (["--to", "cqm", "-o", "-"], 2, "is binary"),
        (["--to", "cqm", "--penalty", "tenfold", "-o", "x"], 3, "neither an encoding"),
        (["--to", "lp", "--encoding", "bits", "-o", "-"], 3, "neither an encoding"),
    ],
)
def test_what_makes_no_sense_is_refused(trip, arguments, code, part, capsys):
    assert main(["formulate", str(trip), *arguments]) == code
    assert part in capsys.readouterr().err
