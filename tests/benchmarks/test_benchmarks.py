"""The benchmarks run and their peers agree with tgvdp; how long anything takes is not tested."""

import json
import math

import numpy as np
import pytest

import tgvdp
from benchmarks import accuracy, peer_boa, peer_ipopt, phases, scaling, summary
from benchmarks.__main__ import BENCHMARKS
from benchmarks.inside import finer_cells, mesh_of, phases_of
from benchmarks.instances import reference_instances, synthetic_instance
from benchmarks.ipopt_nlp import caps_of
from benchmarks.output import Report, read_reports, write_report
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate import backward, mesh
from tgvdp.methods.grid.exact import exact_paths
from tgvdp.model.effort import EffortCurve
from tgvdp.report.style import new_figure

TOY = synthetic_instance(12e3)


@pytest.fixture(scope="module")
def result():
    return tgvdp.search(**TOY.arguments, points=6)


@pytest.fixture(scope="module")
def peer():
    compiler = peer_boa.compiler()
    if compiler is None:
        pytest.skip("no C compiler")
    return peer_boa.Peer(compiler)


def test_synthetic_lines_are_the_same_every_time():
    assert synthetic_instance(50e3).track == synthetic_instance(50e3).track
    assert synthetic_instance(50e3).track != synthetic_instance(51e3).track


def test_no_reference_data_no_reference_instances(tmp_path):
    assert reference_instances(tmp_path) == []
    assert accuracy.run(tmp_path, quick=True) is None


def test_reference_instances(shared):
    instances = reference_instances(shared)
    assert {instance.kind for instance in instances} == {"main line", "metro"}
    assert all([one.margin_pct for one in instance.references] == [3, 5, 10, 15, 20] for instance in instances)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("ties", [False, True])
def test_label_peers_find_the_same_fronts(peer, seed, ties):
    graph = peer_boa.exact_graph(peer_boa.random_graph(layers=3 + seed % 4, width=2 + seed, seed=seed))
    if ties:
        graph = graph._replace(duration_s=np.round(graph.duration_s), energy_j=np.round(graph.energy_j))
    for limit_s in (5.5 * graph.n_layers, 1e6):
        ours = exact_paths(graph, limit_s, SearchBudget())
        for name in peer_boa.PEERS:
            front_s, front_j, counters = peer.search(graph, limit_s, name)
            assert np.array_equal(front_s, ours.duration_s)
            assert np.array_equal(front_j, ours.energy_j)
            assert counters["labels"] >= counters["expanded"] > 0


def test_label_peer_says_when_its_room_ends(peer):
    graph = peer_boa.exact_graph(peer_boa.random_graph(6, 8, seed=1))
    with pytest.raises(RuntimeError, match="status -2"):
        peer.search(graph, 1e6, "BOA*", room=1)


def test_quantised_costs_add_up_without_rounding():
    graph = peer_boa.exact_graph(peer_boa.random_graph(5, 5, seed=3))
    for costs, quantum in ((graph.duration_s, 2.0**30), (graph.energy_j, 2.0**8)):
        assert math.fsum(costs) == sum(costs.tolist()) == float(sum(int(cost * quantum) for cost in costs)) / quantum


def test_ipopt_agrees_on_a_rolling_line():
    pytest.importorskip("casadi", reason="the extra `peers` is not installed")
    report = peer_ipopt.run(quick=True)
    (row,) = report.rows
    assert row["converged"] == 1.0
    assert row["error %, ours"] < 0.1
    assert row["replay ok, ours"] == 1.0


def test_ipopt_peer_refuses_efforts_that_it_does_not_model():
    assert caps_of(EffortCurve.from_caps(2.0, 10.0)) == (2.0, 10.0)
    assert caps_of(EffortCurve.from_caps(0.0)) == (0.0, math.inf)
    with pytest.raises(ValueError, match="min"):
        caps_of(EffortCurve.from_points([(0.0, 2.0), (5.0, 1.0)]))


def test_every_phase_is_seen_and_nothing_stays_patched(result):
    before = vars(mesh.Mesh)["of"], mesh.drive, backward.switching_speeds
    spent_s = phases_of(lambda: tgvdp.search(**TOY.arguments, points=6))
    assert all(value > 0.0 for value in spent_s.values())
    assert (vars(mesh.Mesh)["of"], mesh.drive, backward.switching_speeds) == before


def test_finer_cells_are_finer_and_only_within_the_context(result):
    def cells():
        return len(mesh.Mesh.of(result.trip, result.fastest.profile).cells.length_m)

    before = cells()
    assert len(mesh_of(result).cells.length_m) == result.counters["cells"]
    with finer_cells(2.0):
        assert cells() > 1.3 * before
    assert cells() == before


def test_energy_between_two_points_follows_the_front(result):
    times, energies = result.front.time_s, result.front.energy_j
    assert accuracy.energy_at(result, times[3]) == pytest.approx(energies[3], rel=1e-12)
    middle = accuracy.energy_at(result, 0.5 * (times[3] + times[4]))
    assert energies[4] < middle < 0.5 * (energies[3] + energies[4])  # convex


def test_report_files_and_summary(tmp_path):
    report = Report("scaling", "Scaling", options={"quick": True}, inputs={"track": TOY.track}, plot=new_figure())
    report.rows = [{"what": "a", "value": 1.5, "none": None}, {"what": "b", "value": 2.0, "none": float("nan")}]
    report.figures = {"length km": {"500": 123.4}}
    write_report(report, tmp_path, 1.0)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        f"scaling.{kind}" for kind in ("csv", "json", "md", "png")
    ]
    assert json.loads((tmp_path / "scaling.json").read_text())["provenance"]["inputs"]["track"]["sha256"]
    assert (tmp_path / "scaling.csv").read_text().splitlines()[0] == "what,value,none"
    readme = tmp_path / "README.md"
    readme.write_text(f"before\n{summary.BEGIN}\nold\n{summary.END}\nafter\n")
    text = summary.summarise(tmp_path, readme)
    assert "| front of 60 points, 500 km | 123.4 ms | ≤ 150 ms | ≤ 150 ms | meets the aim |" in text
    assert "not measured" in text
    assert "quick runs of scaling" in text
    assert readme.read_text() == f"before\n{summary.BEGIN}\n{text}{summary.END}\nafter\n"
    readme.write_text("no marks")
    with pytest.raises(SystemExit, match="between"):
        summary.summarise(tmp_path, readme)


def test_summary_without_results_says_so(tmp_path):
    assert "no results" in summary.summarise(tmp_path, None)


def test_bars_read_figures_that_benchmarks_write():
    assert {bar.report for bar in summary.BARS} <= set(BENCHMARKS)


@pytest.mark.slow
@pytest.mark.parametrize("module", [phases, scaling])
def test_quick_runs(module, tmp_path):
    report = module.run(tmp_path, quick=True)
    write_report(report, tmp_path, 0.0)
    assert read_reports(tmp_path)[report.name]["figures"]
