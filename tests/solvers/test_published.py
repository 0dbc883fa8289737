"""Every cheap solver on every small published instance: none contradicts the certified optimum, nor denies a plan."""

import json

import pytest

from tgvdp.cli import main
from tgvdp.errors import BudgetExceededError, InputError
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.instances import find, index
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.registry import SOLVERS, solve

pytestmark = pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")

SMALL = {name: row for name, row in index().items() if int(row["N"]) <= 8}
BUDGET = {"reads": 20, "sweeps": 100, "time_limit_s": 5.0}
PACKAGES = {"milp": "scipy", "scip": "pyscipopt", "cqm": "dimod", "exact-qubo": "dimod"}
SAMPLERS = ("sa", "pt", "tabu", "descent", "tree")


@pytest.mark.parametrize("solver", ["dp", "brute", "closed", "random", *PACKAGES, *SAMPLERS])
def test_no_solver_contradicts_a_certified_optimum(solver):
    pytest.importorskip(PACKAGES.get(solver, "dwave.samplers" if solver in SAMPLERS else "numpy"))
    tried = 0
    for name, row in SMALL.items():
        if solver == "cqm" and int(row["N"]) > 6:
            continue  # seconds each
        spent = {key: value for key, value in BUDGET.items() if key in SOLVERS[solver].uses}
        if solver == "cqm" and row["kind"] == "binary":
            del spent["time_limit_s"]  # it lists all strings
        allowance = Allowance(**spent)
        try:
            found = solve(read_instance(find(name)), solver, allowance=allowance)
        except (InputError, BudgetExceededError):
            continue  # not for such instances, or nothing found; that it were infeasible would be wrong
        tried += 1
        best = float(row["objective"])
        if found.optimal:
            assert found.objective == pytest.approx(best, rel=1e-12), name
            assert found.n_optimal in (None, int(row["n_optimal"])) or SOLVERS[solver].qubo, name
        if found.feasible:
            assert found.objective >= best * (1.0 - 1e-12), name
    assert tried >= 4


def test_an_infeasible_approximation_is_no_proof(capsys):
    pytest.importorskip("pyscipopt")
    assert main(["solve", "demand-n004", "--solver", "scip"]) == 5
    assert "SCIP found no plan: its quadratic approximation has none" in capsys.readouterr().err
    assert main(["solve", "demand-n004", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["optimal"]


@pytest.mark.parametrize("name", [name for name, row in SMALL.items() if row["kind"] == "binary"])
def test_an_objective_is_called_an_energy_only_where_it_is_that_of_the_replay(name, capsys):
    assert main(["solve", name, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    is_energy = found["objective_unit"] == found["replay"]["energy_unit"] == "J/kg"
    assert is_energy == (index()[name]["model"] == "kinetic")
    if is_energy:
        assert found["replay"]["energy"] == pytest.approx(found["objective"], rel=1e-12)
    assert main(["solve", name]) == 0
    lines = dict(line.split("  ", 1) for line in capsys.readouterr().out.splitlines())
    assert ("not an energy" in lines["objective"]) == (not is_energy)
    assert lines["energy by replay"].strip() == f"{found['replay']['energy']:.6g} J/kg"


def test_the_constant_model_counts_accelerations_and_not_energy(capsys):
    """One step up to 1 m/s and down again, 0.3 of it given back: 0.7 (m/s)², but ½·1² − 0.3·½·1² = 0.35 J/kg."""
    assert main(["solve", "easy-n004"]) == 0
    out = capsys.readouterr().out
    assert "0.7 (m/s)² of the constant model, not an energy" in out
    assert "energy by replay     0.35 J/kg" in out
