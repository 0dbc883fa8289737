"""The published instances: reproducible files, and an index whose optima other solvers find again."""

import hashlib
import json
import warnings

import pytest

from benchmarks.library import certified, entries
from benchmarks.substations import LIMITS, limit
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.formulations.problem.instances import BinaryInstance
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.instances import FOLDER, INDEX, find
from tgvdp.instances import index as listed
from tgvdp.solvers.registry import solve
from tgvdp.trials.reference import read_cases, reference_of

ENTRIES = {entry.name: entry for entry in entries()}
SMALL = [name for name, entry in ENTRIES.items() if entry.params["kind"] == "binary" and entry.params["N"] <= 10]


@pytest.fixture(scope="module")
def index():
    return listed()


def test_files_are_what_the_script_makes_and_the_index_lists_all(index):
    assert list(next(iter(index.values()))) == [
        "file", "sha256", "id", "family", "kind", "model", "N", "objective", "unit", "n_optimal", "closed_form",
        "certified_by", "confirmed_by", "best_known", "bound",
    ]  # fmt: skip
    assert {path.stem for path in FOLDER.glob("*.json")} == set(ENTRIES) == set(index)
    for name, entry in ENTRIES.items():
        assert (FOLDER / f"{name}.json").read_bytes() == entry.content
        assert index[name]["sha256"] == hashlib.sha256(entry.content).hexdigest()


def test_the_library_is_as_wide_as_it_says(index):
    sizes = {int(row["N"]) for row in index.values()}
    assert len(index) >= 60
    assert min(sizes) == 4 and max(sizes) == 200
    assert {row["family"] for row in index.values()} == {
        "easy", "tight", "degenerate", "kinetic", "efficiency", "zones", "unequal", "tolerance", "fine", "penalised",
        "demand", "substation",
    }  # fmt: skip
    assert {row["model"] for row in index.values() if row["model"]} == {"constant", "kinetic", "efficiency"}


def test_instances_hold_the_published_fields_only():
    binary = {
        "kind", "model", "N", "dt_s", "dv_mps", "acc_units", "dec_units", "cap_units", "D_units", "alpha", "eta0",
        "deta", "tol_units", "lambda_uniform",
    }  # fmt: skip
    demand = {
        "kind", "N", "dt_s", "notches", "mass_kg", "rot", "davis_SI", "vmax_kmh", "D_m", "tol_m", "v_end_max_mps",
        "P_max_W", "cost_ref_kmh", "alpha",
    }  # fmt: skip
    substation = {"kind", "dt_s", "dv_mps", "power_units", "alpha", "trains"}
    fields = {"binary": binary, "demand": demand, "substation": substation}
    for path in FOLDER.glob("*.json"):
        content = json.loads(path.read_text())
        assert set(content) == {"id", "params"}
        assert set(content["params"]) <= fields[content["params"]["kind"]]


@pytest.mark.parametrize("name", SMALL)
def test_small_instances_are_certified_again(name, index):
    pytest.importorskip("pyscipopt")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormulationWarning)
        row = certified(ENTRIES[name])
    assert {key: "" if value is None else str(value) for key, value in row.items()} == index[name]


@pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")
def test_large_instances_keep_their_optimum_and_its_number(index):
    for name, entry in ENTRIES.items():
        instance = entry.instance
        if isinstance(instance, BinaryInstance) and instance.steps > 10:
            found = solve(instance, "dp")
            assert repr(found.objective) == index[name]["objective"], name
            assert str(found.n_optimal) == index[name]["n_optimal"], name


def test_small_substations_are_certified_again(index):
    pytest.importorskip("scipy")
    for name in ("substation-k2-n006", "substation-k2-n008", "substation-k3-n008"):
        row = certified(ENTRIES[name])
        assert {key: "" if value is None else str(value) for key, value in row.items()} == index[name]


def test_limits_of_substations_are_found_as_they_say():
    for size in ((2, 6), (2, 8), (3, 8)):
        assert limit(*size) == LIMITS[size]


def test_open_instances_have_a_best_known_objective_and_a_bound_below(index):
    rows = [row for row in index.values() if not row["objective"]]
    assert rows
    for row in rows:
        assert row["family"] == "substation"
        assert 0.0 < float(row["bound"]) < float(row["best_known"])
        (case,) = read_cases([find(row["id"])])
        assert not reference_of(case)["objective"]


def test_closed_forms_and_other_proofs_are_in_the_index(index):
    for row in index.values():
        if row["closed_form"]:
            assert float(row["closed_form"]) == pytest.approx(float(row["objective"]), rel=1e-12)
    assert sum(bool(row["closed_form"]) for row in index.values()) >= 30
    assert sum(bool(row["confirmed_by"]) for row in index.values()) >= 60
    assert sum("milp" in row["confirmed_by"] for row in index.values()) >= 50


@pytest.mark.slow
def test_demand_instances_are_certified_again(index):
    for name in ("demand-n004", "demand-n005", "demand-n006", "demand-n010"):
        assert float(certified(ENTRIES[name])["objective"]) == pytest.approx(float(index[name]["objective"]), rel=1e-12)


def test_the_benchmark_takes_its_optima_from_the_index():
    cases = read_cases([FOLDER])
    assert [case.instance.steps for case in cases] == sorted(case.instance.steps for case in cases)
    assert all(reference_of(case)["source"] == INDEX for case in cases)
    assert read_instance(find("zones-n008")).cap_units[5] == 1  # 1.5 is rounded down
