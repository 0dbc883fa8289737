"""What is published of trains at one substation that nothing proves: plans that an outsider can check."""

import json
from fractions import Fraction
from types import SimpleNamespace

import pytest

from benchmarks.substations import best_plans
from benchmarks.timing import ROOT
from tgvdp.instances import find, index
from tgvdp.instances.check import check_substation

FOLDER = ROOT / "results" / "quantum" / "substations" / "large"
PLANS = sorted(FOLDER.glob("*.sol"))
OPEN = {name: float(row["best_known"]) for name, row in index().items() if row["best_known"]}


def test_some_plans_of_open_instances_are_published():
    assert PLANS
    assert {path.stem for path in PLANS} <= set(OPEN)


@pytest.mark.parametrize("path", PLANS, ids=lambda path: path.stem)
def test_published_plans_cost_what_the_index_knows(path):
    params = json.loads(find(path.stem).read_text())["params"]
    objective, broken = check_substation(params, [Fraction(line) for line in path.read_text().split()])
    assert broken == []
    assert objective == OPEN[path.stem]


def test_only_feasible_plans_as_good_as_the_best_known_are_kept():
    name, best = next(iter(OPEN.items()))

    def run(objective, controls, feasible=True):
        return {"status": "ok", "objective": objective, "feasible": feasible, "controls": controls}

    runs = {
        (name, "worse"): [run(best + 1.0, [1])],
        (name, "as good"): [run(best, [1, 0]), run(best - 2.0, [9], feasible=False), {"status": "budget"}],
        (name, "better"): [run(best - 1.0, [1, -1])],
        ("substation-k2-n006", "proved"): [run(0.0, [2])],
    }
    assert best_plans(SimpleNamespace(runs=runs)) == {f"{name}.sol": b"1\n-1\n"}
