"""The standalone checker: what it says of certified plans, and of wrong ones; it shares no code with the package."""

import json
import subprocess
import sys

import pytest

from tgvdp.formulations.problem.reading import read_instance
from tgvdp.formulations.problem.replay import replay
from tgvdp.instances import CHECKER, find, index
from tgvdp.instances.check import check_binary, check_demand, check_substation
from tgvdp.solvers.registry import solve

SMALL = [name for name, row in index().items() if int(row["N"]) <= 12]
CHECKS = {"binary": check_binary, "demand": check_demand, "substation": check_substation}


@pytest.mark.parametrize("name", SMALL)
@pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")
def test_certified_plans_are_feasible_and_cost_what_the_index_says(name):
    params = json.loads(find(name).read_text())["params"]
    plan = list(solve(read_instance(find(name)), "dp").schedule.controls)
    check = CHECKS[params["kind"]]
    objective, broken = check(params, plan)
    assert broken == []
    assert objective == pytest.approx(float(index()[name]["objective"]), rel=1e-12)
    objective, broken = check(params, [plan[1], plan[0], *plan[2:-1], 1])
    assert broken


def test_trains_that_together_draw_too_much_are_told_of():
    params = json.loads(find("substation-k2-n006").read_text())["params"]
    assert params["power_units"] == 2
    alone = [1, 0, 0, 0, -1, 0]  # both depart at once: 1 + 2 units of ½·Δv²
    objective, broken = check_substation(params, alone * 2)
    assert objective == 1.5
    assert broken == ["step 1: the substation gives 3.0"]


def test_slopes_count_as_in_the_replay():
    one = json.loads(find("demand-n008").read_text())
    one["params"] |= {"gradients_permil": [[0, 2], [900, -6]], "curves_m": [[0, None], [400, 500]]}
    from pathlib import Path

    from tgvdp.formulations.problem.demand import demand_schedule
    from tgvdp.formulations.problem.reading import parse_instance

    instance = parse_instance(Path("x.json"), one)
    plan = [1, 1, 0.5, 0, 0, -0.5, -1, -1]
    driven = replay(instance, demand_schedule(instance, plan))
    objective, broken = check_demand(one["params"], plan)
    assert objective == pytest.approx(driven["objective"], rel=1e-12)
    assert bool(broken) != driven["feasible"]


def test_it_runs_without_the_package_and_is_short(tmp_path):
    assert len(CHECKER.read_text().splitlines()) < 100
    (tmp_path / "check.py").write_bytes(CHECKER.read_bytes())
    (tmp_path / "plan.sol").write_text("1\n0\n-1\n0\n")
    words = [sys.executable, "-I", str(tmp_path / "check.py"), str(find("easy-n004")), str(tmp_path / "plan.sol")]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "objective 0.7\nfeasible\n")
    (tmp_path / "plan.sol").write_text("1\n0\n0\n")
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and done.stdout.endswith("3 controls, not 4\ninfeasible\n")
    (tmp_path / "plan.sol").write_text("1\n0.5\n-1.5\n0\n")
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "step 2: 1/2 is neither 1, 0 nor -1" in done.stdout
