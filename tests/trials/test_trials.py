"""The benchmark: what is to run, what is kept, how success is judged, and the command."""

import csv
import itertools
import json
import math
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.instance_case import binary_instance
from tgvdp.cli import main
from tgvdp.errors import InputError
from tgvdp.formulations.problem.instances import DemandInstance
from tgvdp.trials.execute import one_run
from tgvdp.trials.reference import Case, Reference
from tgvdp.trials.rows import random_chance, succeeded
from tgvdp.trials.spec import parse_spec, parse_specs
from tgvdp.trials.statistics import attempts_to_success, proportion_interval

PARAMS = {
    "kind": "binary", "model": "constant", "N": 6, "dt_s": 10.0, "dv_mps": 1.0, "acc_units": 1, "dec_units": 1,
    "cap_units": 3, "D_units": 6, "alpha": 0.3,
}  # fmt: skip


def write_trip(folder, name="trip", **changes):
    path = folder / f"{name}.json"
    path.write_text(json.dumps({"id": name, "params": PARAMS | changes}))
    return path


def bench(out, *places, solvers="dp,random:unary:reads=200", runs=2, more=()):
    return main(["bench", *map(str, places), "--solvers", solvers, "--runs", str(runs), "--out", str(out), *more])


def table(out):
    with (out / "benchmark.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize(
    ("text", "label"),
    [
        ("dp", "dp"),
        ("sa", "sa:unary"),
        (" sa:bits:sweeps=10:penalty=0.5 ", "sa:bits:penalty=0.5:sweeps=10"),
        ("qaoa:bits+slack:layers=2:runs=1", "qaoa:bits+slack:layers=2"),
        ("milp:time-limit=5", "milp:time-limit=5"),
        ("sa:unary:sweeps=9:beta=0.5..20", "sa:unary:beta=0.5..20:sweeps=9"),
        ("qaoa:unary:angles=ramp:step=0.7:mixer=walls", "qaoa:unary:angles=ramp:mixer=walls:step=0.7"),
        ("tabu:unary:penalty=tenfold", "tabu:unary:penalty=tenfold"),
    ],
)
def test_words_of_solvers(text, label):
    spec = parse_spec(text)
    assert spec.label == label
    assert parse_spec(label) == spec or "runs" in text


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("guess", "no 'guess'; there are dp"),
        ("dp:unary", "dp takes runs=…, not 'unary'"),
        ("dp:reads=3", "not 'reads=3'"),
        ("sa:sweeps=many", "'many' is no value of sweeps"),
        ("sa:beta=3", "'3' is no value of beta"),
        ("sa:penalty=-1", "'-1' is no value of penalty"),
        ("sa:runs=0", "'0' is no value of runs"),
        ("sa:reads=0", "reads must be"),
        ("dp,dp", "'dp' is given twice"),
        (" , ", "none is given"),
    ],
)
def test_wrong_words_are_refused(text, part):
    with pytest.raises(InputError, match=part.replace("(", r"\(")):
        parse_specs(text)


@pytest.mark.parametrize("attempts", [1, 7, 60])
def test_intervals_cover_as_often_as_they_say(attempts):
    """Exact coverage, over all outcomes, of intervals at 95 %."""
    ends = [proportion_interval(k, attempts) for k in range(attempts + 1)]
    assert ends[0][0] == 0.0 and ends[-1][1] == 1.0
    assert all(one[0] < two[0] and one[1] < two[1] for one, two in itertools.pairwise(ends))
    for p in (0.003, 0.2, 0.5, 0.91):
        covered = sum(
            math.comb(attempts, k) * p**k * (1 - p) ** (attempts - k)
            for k, (low, high) in enumerate(ends)
            if low <= p <= high
        )
        assert covered >= 0.95


def test_intervals_equal_the_incomplete_beta_function():
    beta = pytest.importorskip("scipy.stats").beta
    for successes, attempts in ((0, 10), (3, 50), (1, 100_000), (5000, 100_000), (10, 10)):
        low, high = proportion_interval(successes, attempts)
        if successes:
            assert low == pytest.approx(beta.ppf(0.025, successes, attempts - successes + 1), rel=1e-9)
        if successes < attempts:
            assert high == pytest.approx(beta.ppf(0.975, successes + 1, attempts - successes), rel=1e-9)


def test_attempts_until_success():
    assert attempts_to_success(0.0) == math.inf
    assert attempts_to_success(1.0) == attempts_to_success(0.995) == 1.0
    assert 1.0 - (1.0 - 0.2) ** attempts_to_success(0.2) == pytest.approx(0.99)


def test_success_is_the_certified_optimum_and_feasible():
    reference = Reference(2.8, 1, True, "dp")
    run = {"status": "ok", "feasible": True, "objective": 2.8}
    assert succeeded(run, reference)
    assert not succeeded(run | {"feasible": False}, reference)
    assert not succeeded(run | {"objective": 2.8000001}, reference)
    assert not succeeded(run | {"objective": 2.1}, reference)  # too good is no success
    assert not succeeded({"status": "budget"}, reference)
    none = Reference(None, None, False, "dp")
    assert succeeded({"status": "infeasible"}, none)
    assert not succeeded(run, none)


def test_random_chance_is_degeneracy_over_all_strings(tmp_path):
    """Against a count over all strings of the instance."""
    pytest.importorskip("scipy")
    instance = binary_instance(6, distance_units=6.0)
    case = Case(instance, tmp_path, "")
    record = one_run(case, parse_spec("qaoa:unary:layers=1:starts=0"), 1)
    counted = one_run(case, parse_spec("dp"), 1)["n_optimal"]
    chance = random_chance("unary", case, Reference(record["objective"], counted, True, "dp"), 9)
    assert chance == pytest.approx(record["details"]["random_probability"])
    assert random_chance("bits+slack", case, Reference(1.0, 1, True, "dp"), 9) is None


def test_files_and_figures_of_a_benchmark(tmp_path, capsys):
    trip = write_trip(tmp_path)
    longer = write_trip(tmp_path, "longer", N=8, D_units=10, cap_units=4)
    out = tmp_path / "out"
    assert bench(out, trip, longer, solvers="dp,closed,random:unary:reads=3000,random:bits:reads=50", runs=3) == 0
    assert "random:unary" in capsys.readouterr().out
    assert {path.name for path in out.iterdir()} == {
        "benchmark.csv", "benchmark.json", "benchmark.md", "ensembles.csv", "runs.csv", "runs", "success.png",
        "sizes.png", "landscape.png", "pareto.csv", "pareto.png",
    }  # fmt: skip
    rows = {(row["Problem"], row["Workflow"]): row for row in table(out)}
    exact = rows["trip", "dp"]
    assert exact["# Runs"] == exact["# Successful Runs"] == exact["attempts"] == "3"
    assert float(exact["Best Objective Value"]) == float(exact["Optimality Bound"]) == pytest.approx(1.4)
    assert float(exact["TTS99 s"]) == float(exact["elapsed_s median"])
    assert rows["trip", "closed"]["p_success"] == "1.0"
    drawn = rows["trip", "random:unary:reads=3000"]
    assert drawn["attempts"] == "9000" and drawn["# Decision Variables"] == "9"
    assert float(drawn["p low"]) < float(drawn["random p_success"]) < float(drawn["p high"])
    assert float(drawn["TTS99 low s"]) < float(drawn["TTS99 s"]) < float(drawn["TTS99 high s"])
    content = json.loads((out / "benchmark.json").read_text())
    assert content["schema"] == "tgvdp.bench/2"
    assert "rows" not in content  # they stand in the tables
    assert content["provenance"]["options"]["runs"] == 3
    assert "| `closed` | 100 %" in (out / "benchmark.md").read_text()


def test_finished_runs_are_found_again_and_changes_made_anew(tmp_path, monkeypatch):
    import tgvdp.trials.execute as module

    made = []

    def counted(case, spec, seed):
        made.append((case.instance.id, spec.label, seed))
        return one_run(case, spec, seed)

    monkeypatch.setattr(module, "one_run", counted)
    trip, out = write_trip(tmp_path), tmp_path / "out"
    assert bench(out, trip) == 0
    assert made == [("trip", "dp", 1), ("trip", "dp", 2), *(("trip", "random:unary:reads=200", s) for s in (1, 2))]
    before = table(out)
    made.clear()
    assert bench(out, trip) == 0
    assert made == [] and table(out) == before
    assert bench(out, trip, runs=3) == 0
    assert made == [("trip", "dp", 3), ("trip", "random:unary:reads=200", 3)]
    made.clear()
    write_trip(tmp_path, D_units=7)
    assert bench(out, trip, runs=1) == 0
    assert [label for _, label, _ in made] == ["dp", "random:unary:reads=200"]


def test_an_interruption_keeps_what_is_finished(tmp_path, monkeypatch, capsys):
    import tgvdp.trials.execute as module

    trip, out = write_trip(tmp_path), tmp_path / "out"

    def stopped(case, spec, seed):
        if spec.solver != "dp":
            raise KeyboardInterrupt
        return one_run(case, spec, seed)

    monkeypatch.setattr(module, "one_run", stopped)
    assert bench(out, trip) == 130
    assert capsys.readouterr().err == "tgvdp: error: interrupted\n"
    kept = {path.name.split("--")[1]: json.loads(path.read_text()) for path in (out / "runs").iterdir()}
    assert set(kept) == {"certified-optimum", "dp"}
    assert set(kept["dp"]["runs"]) == {"0", "1"}
    assert [path.name for path in out.iterdir()] == ["runs"]
    monkeypatch.undo()
    assert bench(out, trip) == 0
    assert len(table(out)) == 2


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_control_c_and_kill_leave_whole_files(tmp_path):
    trip, out = write_trip(tmp_path, N=200, D_units=6000, cap_units=100), tmp_path / "out"
    words = [sys.executable, "-m", "tgvdp", "bench", str(trip), "--solvers", "dp", "--runs", "5000", "--out", str(out)]

    def kept():
        return {path: len(json.loads(path.read_text())["runs"]) for path in (out / "runs").glob("*--dp--*.json")}

    before = {}
    for number, code in ((signal.SIGINT, 130), (signal.SIGINT, 130), (signal.SIGKILL, -signal.SIGKILL)):
        process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
        deadline = time.monotonic() + 120.0
        while kept() == before:  # a file that is not whole fails here
            assert time.monotonic() < deadline and process.poll() is None
            time.sleep(0.05)
        process.send_signal(number)
        _, error = process.communicate(timeout=60)
        assert process.returncode == code, error
        after = kept()
        assert sum(after.values()) > sum(before.values())
        before = after


def test_what_a_solver_refuses_is_a_row_with_its_reason(tmp_path):
    pytest.importorskip("scipy")
    trip, out = write_trip(tmp_path, acc_units=2, dec_units=1), tmp_path / "out"
    assert bench(out, trip, solvers="dp,closed,random:unary", runs=1) == 0
    rows = {row["Workflow"]: row for row in table(out)}
    assert rows["closed"]["status"] == rows["random:unary"]["status"] == "refused"
    assert "no closed form" in rows["closed"]["Remarks"]
    assert rows["random:unary"]["p_success"] == rows["closed"]["p_success"] == ""


@pytest.mark.parametrize("solver", ["leap", "dwave"])
def test_a_missing_account_ends_the_benchmark_and_leaves_no_record(tmp_path, capsys, monkeypatch, solver):
    pytest.importorskip("dwave.system")
    for name in ("DWAVE_API_TOKEN", "DWAVE_CONFIG_FILE", "DWAVE_PROFILE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    out = tmp_path / "out"
    assert bench(out, write_trip(tmp_path), solvers=f"dp,{solver}", runs=1) == 3
    assert "dwave config create" in capsys.readouterr().err
    assert {path.name.split("--")[1] for path in (out / "runs").iterdir()} == {"certified-optimum", "dp"}


def test_an_infeasible_instance_is_solved_by_proving_it(tmp_path):
    out = tmp_path / "out"
    assert bench(out, write_trip(tmp_path, D_units=100), solvers="dp,random:unary", runs=2) == 0
    rows = {row["Workflow"]: row for row in table(out)}
    assert rows["dp"]["status"] == "infeasible" and rows["dp"]["# Successful Runs"] == "2"
    assert rows["random:unary"]["# Successful Runs"] == "0"


def test_json_and_folders(tmp_path, capsys):
    library = tmp_path / "library"
    library.mkdir()
    write_trip(library)
    write_trip(library, "other", N=5, D_units=4)
    assert bench(tmp_path / "out", library, solvers="dp", runs=1, more=["--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert [row["Problem"] for row in content["rows"]] == ["other", "trip"]
    assert bench(tmp_path / "out", library, solvers="dp", runs=1, more=["--json", "--up-to", "5"]) == 0
    assert [row["Problem"] for row in json.loads(capsys.readouterr().out)["rows"]] == ["other"]
    assert bench(tmp_path / "out", library, solvers="dp", runs=1, more=["--up-to", "4"]) == 3
    assert "no instance of at most 4 steps, the shortest has " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "code", "part"),
    [
        (["--solvers", "guess"], 2, "no 'guess'"),
        (["--embed", "chimera"], 2, "no 'chimera'; there are pegasus, zephyr"),
        (["--runs", "0"], 2, "1<=x"),
        (["absent.json"], 3, "absent.json"),
    ],
)
def test_wrong_usage(tmp_path, capsys, arguments, code, part):
    places = [] if arguments[0] == "absent.json" else [str(write_trip(tmp_path))]
    assert main(["bench", *places, *arguments, "--out", str(tmp_path / "out")]) == code
    err = capsys.readouterr().err
    assert part in err and err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_equal_ids_no_instances_and_damaged_files_are_one_line(tmp_path, capsys):
    trip = write_trip(tmp_path)
    twin = tmp_path / "twin.json"
    twin.write_text(trip.read_text())
    assert bench(tmp_path / "out", trip, twin) == 3
    assert "the id 'trip' is also that of" in capsys.readouterr().err
    (tmp_path / "empty").mkdir()
    assert bench(tmp_path / "out", tmp_path / "empty") == 3
    assert "no instance" in capsys.readouterr().err
    assert bench(tmp_path / "out", trip, solvers="dp", runs=1) == 0
    capsys.readouterr()
    next((tmp_path / "out" / "runs").glob("*--dp--*")).write_text('{"runs"')
    assert bench(tmp_path / "out", trip, solvers="dp", runs=1) == 3
    assert "is damaged" in capsys.readouterr().err


@pytest.mark.slow
def test_embeddings_of_a_small_instance(tmp_path):
    pytest.importorskip("minorminer")
    pytest.importorskip("dwave.graphs")
    out = tmp_path / "out"
    assert (
        bench(out, write_trip(tmp_path), solvers="random:bits,random:unary", runs=1, more=["--embed", "pegasus"]) == 0
    )
    with (out / "embeddings.csv").open(encoding="utf-8", newline="") as file:
        rows = {row["encoding"]: row for row in csv.DictReader(file)}
    for encoding, bits in (("bits", 12), ("unary", 9)):
        assert int(rows[encoding]["variables"]) == bits
        assert bits <= int(rows[encoding]["qubits"]) <= 4 * bits
        assert rows[encoding]["status"] == "ok"


def test_the_front_of_the_comparison_is_the_closed_form_and_a_lower_bound():
    from tgvdp.trials.trip_points import compare

    found = compare(binary_instance(10, dt_s=10.0, distance_units=16.0))
    times = found.front.time_s
    for time_s, energy in zip(found.closed.time_s, found.closed.energy_j_per_kg, strict=True):
        after = max(1, int(np.searchsorted(times, time_s - 0.1)))  # the fastest run has none before it
        assert after < times.size
        least, most = found.front.energy_j_per_kg[[after, after - 1]]
        assert 0.998 * least <= energy <= most  # the search meets its times to 0.1 s
    for points in found.points:
        assert points.time_s.size
        for time_s, energy in zip(points.time_s, points.energy_j_per_kg, strict=True):
            assert energy >= found.closed.energy_j_per_kg[found.closed.time_s == time_s] * (1 - 1e-12)


def test_demands_never_need_less_than_the_optimum_of_what_they_drive():
    from tgvdp.trials.demand_points import compare_demand, demand_comparison

    instance = DemandInstance(
        id="d", steps=6, dt_s=20.0, levels=(-1.0, -0.5, 0.0, 0.5, 1.0), mass_kg=3e5, rotating_factor=1.08,
        davis=(1770.0, 35.4, 6.6), vmax_mps=160 / 3.6, distance_m=1790.0, tol_m=40.0, end_speed_max_mps=1.5,
        p_max_w=9.8e6, cost_ref_mps=220 / 3.6, alpha=0.3,
    )  # fmt: skip
    found = compare_demand(instance)
    assert found.time_s.size >= 3
    assert np.all(found.driven_j >= 0.998 * found.optimal_j)  # the search meets its times to 0.05 s
    assert np.any(np.abs(found.distance_off) > 0.01)
    assert demand_comparison([replace(instance, levels=None), replace(instance, steps=13)]) is None
    assert compare_demand(replace(instance, distance_m=1e5)) is None
