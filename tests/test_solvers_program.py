"""Programs: HiGHS and SCIP against the dynamic program, and LP and MPS files read again by SCIP."""

import numpy as np
import pytest

from instance_case import binary_instance, random_instance
from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.formulations.program import Row, binary_program
from tgvdp.formulations.program_files import lp_text, mps_text
from tgvdp.solvers.options import Options
from tgvdp.solvers.registry import solve

pytestmark = pytest.mark.filterwarnings("ignore::tgvdp.formulations.binary.FormulationWarning")

MODELS = ("constant", "kinetic", "efficiency")


def optimum(instance, solver, **options):
    """Objective of a proved optimum, or None where the solver proves that there is none."""
    try:
        solution = solve(instance, solver, options=Options(**options))
    except InfeasibleError:
        return None
    assert solution.optimal
    assert solution.feasible
    assert solution.replay["feasible"]
    return solution.objective


@pytest.mark.parametrize("seed", range(8))
def test_milp_equals_dynamic_program(seed):
    pytest.importorskip("scipy")
    rng = np.random.default_rng(seed)
    found = 0
    for _ in range(30):
        instance = random_instance(rng)
        best = optimum(instance, "dp")
        assert optimum(instance, "milp") == best, instance
        found += best is not None
    assert 5 <= found <= 28


@pytest.mark.parametrize("model", MODELS)
def test_scip_equals_dynamic_program(model):
    pytest.importorskip("pyscipopt")
    rng = np.random.default_rng(len(model))
    for _ in range(6):
        instance = random_instance(rng, 7)
        assert optimum(instance, "scip") == optimum(instance, "dp"), instance


def test_milp_tells_what_it_proved():
    pytest.importorskip("scipy")
    solution = solve(binary_instance(20, dv_mps=0.1, alpha=0.6, distance_units=60.0), "milp")
    assert solution.optimal
    assert solution.details["bound"] == pytest.approx(solution.objective, rel=1e-12)
    assert solution.details["variables"] == 59


def test_milp_ends_at_its_time_limit():
    pytest.importorskip("scipy")
    instance = binary_instance(60, model="efficiency", cap_units=20, distance_units=450.0, deta=0.01)
    try:
        solution = solve(instance, "milp", options=Options(time_limit_s=0.2))
    except BudgetExceededError as error:
        assert "within 0.2 s" in str(error)
    else:
        assert not solution.optimal
        assert solution.details["bound"] is None or solution.details["bound"] < solution.objective


def test_a_fractional_distance_without_tolerance_is_infeasible_at_once():
    with pytest.raises(InfeasibleError, match="no whole distance"):
        binary_program(binary_instance(6, distance_units=4.5))


def scip_optimum(path):
    pyscipopt = pytest.importorskip("pyscipopt")
    model = pyscipopt.Model()
    model.hideOutput()
    model.readProblem(str(path))
    sizes = (model.getNVars(), model.getNIntVars() + model.getNBinVars())
    model.optimize()
    assert model.getStatus() == "optimal"
    values = {variable.name: model.getVal(variable) for variable in model.getVars()}
    return model.getObjVal(), sizes, values


@pytest.mark.parametrize(("suffix", "write"), [("lp", lp_text), ("mps", mps_text)])
@pytest.mark.parametrize("model", MODELS)
def test_files_hold_the_program(suffix, write, model, tmp_path):
    instance = binary_instance(7, model=model, dv_mps=0.3, alpha=0.4, distance_units=7.0, tol_units=1.0)
    program = binary_program(instance)
    path = tmp_path / f"program.{suffix}"
    path.write_text(write(program))
    objective, sizes, values = scip_optimum(path)
    assert objective == pytest.approx(solve(instance, "dp").objective, abs=1e-9)
    assert sizes == (len(program.variables), sum(variable.integer for variable in program.variables))
    for row in program.rows:
        names = {program.variables[i].name: weight for i, weight in row.linear.items()}
        total = sum(weight * values[name] for name, weight in names.items())
        assert row.lower - 1e-6 <= total <= row.upper + 1e-6


def test_files_refuse_products():
    program = binary_program(binary_instance(4, model="kinetic"), "quadratic")
    assert program.products
    for write in (lp_text, mps_text):
        with pytest.raises(InputError, match="only linear programs"):
            write(program)


def test_rows_of_one_variable_and_of_none_are_written():
    pytest.importorskip("pyscipopt")
    program = binary_program(binary_instance(1, distance_units=0.0))
    assert Row("distance", {}, {}, 0.0, 0.0) in program.rows
    assert " distance: 0 x_0 = 0.0" in lp_text(program).splitlines()
