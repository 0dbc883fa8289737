"""A sweep from end to end: the same rows whoever solves them, and all of them."""

import csv
import hashlib
import json
import subprocess
import sys

import pytest

from tests.helpers.sweep_case import COUNT, SPEC, digests, run, write_case
from tgvdp import load_track, load_train, search

parquet = pytest.importorskip("pyarrow.parquet")
pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    spec = write_case(folder)
    done = run(spec, "--out", folder / "one", "--workers", 1, "--json")
    assert done.returncode == 0, done.stderr
    return folder, spec, json.loads(done.stdout)


def rows_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_rows_are_those_of_searches(case):
    folder, _, content = case
    assert (content["scenarios"], content["done"], content["failed"]) == (COUNT, COUNT, 0)
    scenarios = rows_of(folder / "one" / "scenarios.csv")
    assert [int(row["scenario"]) for row in scenarios] == list(range(COUNT))
    asked = scenarios[23]
    train, line = load_train(folder / "metro.toml"), load_track(folder / "lines" / f"{asked['line']}.toml")
    train = type(train)(**{**vars(train), "mass_kg": 1e3 * float(asked["train.mass_t"])})
    ends = {"origin_m": float(asked["from_m"]), "destination_m": float(asked["to_m"])}
    result = search(train, line, points=5, max_margin=0.1, wind_mps=float(asked["wind_kmh"]) / 3.6, **ends)
    front = [row for row in rows_of(folder / "one" / "fronts.csv") if row["scenario"] == "23"]
    assert [float(row["time_s"]) for row in front] == result.front.time_s.tolist()
    assert [float(row["energy_kwh"]) for row in front] == (result.front.energy_j / 3.6e6).tolist()
    assert float(asked["fastest_time_s"]) == result.fastest.time_s


def test_two_workers_write_the_same_bytes(case):
    folder, spec, _ = case
    done = run(spec, "--out", folder / "two", "--workers", 2)
    assert done.returncode == 0, done.stderr
    assert f"{COUNT} scenarios: {COUNT} done" in done.stdout
    assert digests(folder / "two") == digests(folder / "one")


def test_tables_say_their_schema_and_join_by_names(case):
    folder, _, _ = case
    fronts = parquet.read_table(folder / "one" / "fronts")
    assert fronts.schema.metadata[b"schema"] == b"tgvdp.sweep-fronts/1"
    assert set(fronts.column("line").to_pylist()) == {"east", "west"}
    assert fronts.num_rows == 5 * COUNT
    (train_sha256,) = set(parquet.read_table(folder / "one" / "scenarios.parquet").column("train_sha256").to_pylist())
    assert len(train_sha256) == 64


def test_a_longer_spec_solves_only_what_is_new(case):
    folder, spec, _ = case
    longer = folder / "longer.toml"
    longer.write_text(SPEC.replace("[0, 10, 20]", "[0, 10, 20, 30]"))
    assert run(longer, "--out", folder / "one").returncode == 3  # a sweep is there
    done = run(longer, "--out", folder / "one", "--resume", "--json")
    assert done.returncode == 0, done.stderr
    content = json.loads(done.stdout)
    assert (content["scenarios"], content["earlier"]) == (48, COUNT)
    assert run(longer, "--out", folder / "fresh", "--workers", 2).returncode == 0
    assert digests(folder / "one") == digests(folder / "fresh")
    assert run(spec, "--out", folder / "one", "--resume").returncode == 0
    assert digests(folder / "one") == digests(folder / "two")


def test_a_failing_scenario_is_reported_and_the_others_go_on(tmp_path):
    spec = write_case(tmp_path, SPEC.replace("[180, 200, 220]", "[200, 900000]"))
    done = run(spec, "--out", tmp_path / "out", "--json")
    assert done.returncode == 6
    content = json.loads(done.stdout)
    assert (content["done"], content["failed"]) == (12, 12)
    rows = rows_of(tmp_path / "out" / "scenarios.csv")
    assert {row["status"] for row in rows if row["train.mass_t"] == "200"} == {"done"}
    assert all("train metro" in row["error"] for row in rows if row["status"] == "failed")
    assert "Traceback" not in done.stderr
    assert "warning: scenario 3 failed: " in done.stderr


def test_provenance_has_the_tables_that_values_of_axes_name(tmp_path):
    spec = write_case(tmp_path, SPEC.partition("[product]")[0] + '[product]\n"train.braking" = [{ file = "b.csv" }]\n')
    (tmp_path / "b.csv").write_text("speed [km/h],force [kN]\n0,150\n80,90\n")
    assert run(spec, "--out", tmp_path / "out", "--workers", 1).returncode == 0
    inputs = json.loads((tmp_path / "out" / "provenance.json").read_text())["inputs"]
    assert inputs["set"] == {"beside": {"b.csv": hashlib.sha256((tmp_path / "b.csv").read_bytes()).hexdigest()}}


def test_the_driver_starts_without_numba():
    """Workers solve: a driver that loads numba for nothing starts them half a second later."""
    code = (
        "import sys, tgvdp.cli, tgvdp.cli.sweep, tgvdp.sweeps.run, tgvdp.sweeps.read; sys.exit('numba' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_arrow_does_not_load_pandas():
    """It looks for it with the first array: a third of a second, while no worker is there yet."""
    code = (
        "import sys; from tgvdp.start import start_fast; start_fast(False);"
        " import pyarrow; pyarrow.array([1.0]); sys.exit('pandas' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_only_texts_are_written_by_dictionaries(case):
    """Looking for equal ones among figures takes twice as long as writing them."""
    folder, _, _ = case
    group = parquet.ParquetFile(folder / "one" / "fronts" / "0000.parquet").metadata.row_group(0)
    columns = [group.column(index) for index in range(group.num_columns)]
    by_dictionary = {one.path_in_schema for one in columns if one.dictionary_page_offset is not None}
    assert by_dictionary == {"train", "line", "section"}
