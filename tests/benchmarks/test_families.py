"""Random families: the same bytes every time, wide enough, and certified optima that other solvers find again."""

import csv
import json
from pathlib import Path

import pytest

from benchmarks.entry import Draw, farthest
from benchmarks.families import COUNTS, FAMILIES, OPTIMA, SIZES, Member, certify, members, write
from benchmarks.quantum_tuning import TUNABLES, TUNING, chosen_words
from tgvdp.cli import main
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.trials.reference import read_cases, reference_of
from tgvdp.trials.spec import parse_spec

RUNS = OPTIMA.parent / "runs.csv"

pytestmark = pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("families")
    write(found)
    return found


def test_draws_are_the_same_on_every_machine():
    draw = Draw("easy-n020-s07")
    assert [draw.whole(0, 999) for _ in range(4)] == [188, 864, 784, 788]


def test_instances_are_those_whose_optima_are_known(folder):
    """`write` compares the digests."""
    assert len(list(folder.glob("*.json"))) == len(FAMILIES) * len(SIZES) * sum(COUNTS.values())
    assert COUNTS["sample"] >= 30 and len(SIZES) >= 8
    case = next(case for case in read_cases([folder], 6) if case.instance.id == "zones-n006-s03")
    assert reference_of(case)["source"] == "optima.csv"


def test_an_instance_that_is_not_listed_is_refused(tmp_path, monkeypatch):
    wrong = [row | {"sha256": "0"} for row in rows(OPTIMA)]
    copy = tmp_path / "families.csv"
    with copy.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(wrong[0]))
        writer.writeheader()
        writer.writerows(wrong)
    monkeypatch.setattr("benchmarks.families.OPTIMA", copy)
    with pytest.raises(ValueError, match="is not the instance"):
        write(tmp_path / "out")


@pytest.mark.parametrize("family", FAMILIES)
def test_members_differ_and_can_be_driven(family, folder):
    for steps in SIZES:
        contents = {json.dumps(member.entry.params) for member in members(family, steps, "sample")}
        assert len(contents) > 0.8 * COUNTS["sample"]
        for member in members(family, steps, "sample"):
            instance = read_instance(folder / f"{member.name}.json")
            low, high = instance.distance_range
            assert 0 < low == high <= farthest(steps, list(instance.cap_units))


def test_small_members_are_certified_again(capsys):
    known = {row["id"]: row for row in rows(OPTIMA)}
    pytest.importorskip("scipy")
    for row in certify([Member(family, steps, "sample", 3) for family in FAMILIES for steps in (6, 8)]):
        assert {key: "" if value is None else str(value) for key, value in row.items()} == known[row["id"]]
    assert capsys.readouterr().out


def test_every_solver_was_tuned_with_the_same_budget_on_instances_that_are_not_reported():
    found = rows(TUNING)
    for tunable in TUNABLES:
        for family in FAMILIES:
            own = [row for row in found if (row["solver"], row["family"]) == (tunable.word, family)]
            settings = 28 if family == "efficiency" else 16
            for tuned_at, sizes in tunable.groups().items():
                assert sum(row["stage"] == "setting" and row["N"] == str(tuned_at) for row in own) == settings
                assert len(list(tunable.words(family))) == settings
                for steps in sizes:
                    assert sum(row["stage"] == "effort" and row["N"] == str(steps) for row in own) == 4
    for words in chosen_words(TUNING).values():
        assert len({parse_spec(word).label for word in words}) == len(words)


@pytest.mark.slow
@pytest.mark.parametrize("solver", ["dp", "sa:unary", "pt:unary", "tabu:bits", "qaoa:unary:mixer=walls"])
def test_a_published_row_is_found_again_from_its_line(solver, folder, tmp_path):
    pytest.importorskip("dwave.samplers")
    published = next(
        row
        for row in rows(RUNS)
        if set(solver.split(":")) <= set(row["Workflow"].split(":")) and row["Problem"].startswith("kinetic-n008")
    )
    word, seed = published["Workflow"], published["seed"] or "1"
    place = folder / f"{published['Problem']}.json"
    out = tmp_path / "out"
    assert main(["bench", str(place), "--solvers", word, "--runs", "1", "--seed", seed, "--out", str(out)]) == 0
    (again,) = rows(out / "runs.csv")
    kept = ("status", "objective", "feasible", "attempts", "feasible_attempts", "best_attempts")
    assert {name: again[name] for name in kept} == {name: published[name] for name in kept}
