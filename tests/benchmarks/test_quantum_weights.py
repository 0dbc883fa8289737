"""What tuning leaves out: the published rows come from the settings that are drawn, and are found again."""

import csv

import pytest

from benchmarks.quantum_limits import short, weights
from benchmarks.quantum_short import SHORTER
from benchmarks.quantum_tuning import TUNING, chosen_words
from benchmarks.quantum_weights import DRAWN, Trial, outcome, trials
from benchmarks.timing import ROOT

pytestmark = pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")

RESULTS = ROOT / "results" / "quantum"


def rows(name):
    with (RESULTS / name).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_both_arms_draw_the_same_number_of_settings_and_the_published_ones_are_among_them():
    published = {(row["solver"], row["family"], int(row["N"]), row["weights"]): row for row in rows("weights.csv")}
    tried = list(trials(RESULTS / "ensembles.csv"))
    assert {(*trial, arm) for trial in tried for arm in ("one", "each")} == set(published)
    for trial in tried:
        for arm, slashes in (("one", {0}), ("each", {1, 2})):
            drawn = trial.settings(arm)
            assert len(drawn) == DRAWN and drawn == trial.settings(arm)
            assert {setting.split("penalty=")[1].split(":")[0].count("/") for setting in drawn} <= slashes
            assert published[*trial, arm]["setting"] in drawn


def test_a_published_row_is_found_again():
    pytest.importorskip("dwave.samplers")
    trial = Trial("sa:bits", "easy", 12)
    for row in rows("weights.csv"):
        if (row["solver"], row["family"], int(row["N"])) == trial:
            again = {name: str(value) for name, value in outcome(trial, row["setting"]).items()}
            assert again == {name: row[name] for name in again}


def test_shorter_attempts_are_tried_wherever_the_shortest_of_tuning_had_won():
    wanted = [
        (*key, word.split(":")[0])
        for key, words in chosen_words(TUNING).items()
        for word in words
        if key[1] < 40 and ":unary" in word and word.rsplit(":", 1)[1] in SHORTER
    ]
    found = [(row["family"], int(row["N"]), row["solver"].split(":")[0]) for row in rows("short.csv")]
    assert sorted(found) == sorted(wanted)


def test_sentences_count_medians_and_compare_growth():
    def arm(weights, median):
        return {"weights": weights, "p median": median, "TTS99 sweeps": "1000" if weights == "each" else "4000"}

    sets = [{"solver": "sa:bits", "family": "easy", "N": "12"}, {"solver": "sa:unary", "family": "easy", "N": "30"}]
    sets.append({"solver": "qaoa:bits:angles=ramp", "family": "easy", "N": "8"})
    text = weights([one | arm(name, median) for one in sets for name, median in (("each", "0.5"), ("one", "0.0"))])
    assert "of 1 of 1 sets of bits" in text and "of 0 with one for all" in text
    assert "`zones` was not tried" in text and "zones" not in {row["family"] for row in rows("weights.csv")}
    assert "`sa:unary` on easy 50 % (one weight: 0 %)" in text
    assert "by a factor of 4 " in text
    reached = [
        {"solver": "sa:unary", "family": "easy", "N": str(n), "TTS99 sweeps": str(10 ** (2 + n / 10))}
        for n in (10, 20, 30, 40)
    ]
    lower = {"solver": "sa:unary", "family": "easy", "N": "10", "TTS99 sweeps": "100", "TTS99 sweeps of tuning": "1000"}
    lower["setting"] = "sa:unary:sweeps=8"
    assert "`sa:unary` on easy 0.1 → 0.13" in short([lower], reached)
