"""Samplers with a weight for each kind on trains at one substation: the published rows come from what is drawn."""

import csv

import pytest

from benchmarks.quantum_shared import compared_table, substations
from benchmarks.substation_weights import DRAWN, READS, Outcome, outcome, trials
from benchmarks.timing import ROOT

pytestmark = pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")

FOLDER = ROOT / "results" / "quantum" / "substations"


def rows(name):
    with (FOLDER / name).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_both_arms_draw_the_same_number_of_settings_and_the_published_ones_are_among_them():
    published = {(row["instance"], row["solver"], row["weights"]): row["setting"] for row in rows("weights.csv")}
    tried = list(trials())
    assert {(trial.name, trial.solver, arm) for trial in tried for arm in ("one", "each")} == set(published)
    for trial in tried:
        for arm, slashes in (("one", 0), ("each", 2)):
            drawn = trial.settings(arm)
            assert len(drawn) == DRAWN and drawn == trial.settings(arm)
            assert {setting.split("penalty=")[1].split(":")[0].count("/") for setting in drawn} == {slashes}
            assert published[trial.name, trial.solver, arm] in drawn


def test_published_rows_are_found_again():
    pytest.importorskip("dwave.samplers")
    known = {(trial.name, trial.solver): trial for trial in trials() if trial.name == "substation-k2-n012"}
    for row in rows("weights.csv"):
        if trial := known.get((row["instance"], row["solver"])):
            found = outcome(trial, row["setting"], READS, 3)
            assert found == Outcome(int(row["successful"]), int(row["feasible"])), row


def test_the_page_tells_what_one_weight_misses():
    weights = rows("weights.csv")
    shared = [rows("benchmark.csv"), rows("large/benchmark.csv")]
    for row in weights:
        row["successful"] = "25" if row["weights"] == "each" and row["instance"] == "substation-k2-n012" else "0"
    text = next(substations(*shared, weights))
    assert "with one weight of: `sa` 0, `pt` 0, `tabu` 0; with a weight each" in text
    assert "of: `sa` 1, `pt` 1, `tabu` 1." in text
    line = next(line for line in compared_table(shared[0], weights).splitlines() if "k2-n012" in line)
    assert "0 %; 0 %; 50 %" in line
