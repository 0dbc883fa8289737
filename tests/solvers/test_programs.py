"""Programs: HiGHS and SCIP against the dynamic program, and LP and MPS files read again by SCIP."""

import itertools
import os
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.instance_case import binary_instance, random_instance
from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.formulations.problem.instances import DemandInstance
from tgvdp.formulations.program.approximations import split_fits
from tgvdp.formulations.program.binary import Row, binary_program
from tgvdp.formulations.program.files import lp_text, mps_text
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.registry import solve

pytestmark = pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")

MODELS = ("constant", "kinetic", "efficiency")


def optimum(instance, solver, **allowance):
    """Objective of a proved optimum, or None where the solver proves that there is none."""
    try:
        solution = solve(instance, solver, allowance=Allowance(**allowance))
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


def fitted_cost(instance, demand):
    """Cost of demands driven by the fitted forces, without any program; None where a constraint is broken."""
    (a0, a1), (b0, b1), (c1, c2) = (fit.coefficients for fit in split_fits(instance))
    a, b, c = instance.davis
    v, s, cost = 0.0, 0.0, 0.0
    for d in demand:
        p, q = max(d, 0.0), max(-d, 0.0)
        force = p * (a0 + a1 * v) - q * (b0 + b1 * v) - a - b * v - c * v * v
        after = max(0.0, v + instance.dt_s * force / (instance.rotating_factor * instance.mass_kg))
        mean = 0.5 * (v + after)
        s += mean * instance.dt_s
        cost += instance.dt_s * (p - instance.alpha * q) * (c1 * mean + c2)
        v = after
        if v > instance.vmax_mps:
            return None
    reached = abs(s - instance.distance_m) <= instance.tol_m and v <= instance.end_speed_max_mps
    return cost if reached else None


@pytest.mark.parametrize(("steps", "distance_m"), [(4, 700.0), (5, 900.0), (5, 1300.0)])
def test_scip_solves_the_approximated_demand_program(steps, distance_m):
    pytest.importorskip("pyscipopt")
    instance = DemandInstance(
        id="d", steps=steps, dt_s=20.0, levels=(-1.0, 0.0, 1.0), mass_kg=3e5, rotating_factor=1.08,
        davis=(1770.0, 35.4, 6.6), vmax_mps=160 / 3.6, distance_m=distance_m, tol_m=150.0, end_speed_max_mps=2.5,
        p_max_w=9.8e6, cost_ref_mps=220 / 3.6, alpha=0.3,
    )  # fmt: skip
    costs = [fitted_cost(instance, plan) for plan in itertools.product(instance.levels, repeat=steps)]
    possible = [cost for cost in costs if cost is not None]
    assert possible
    found = solve(instance, "scip", allowance=Allowance(time_limit_s=60.0))
    assert found.details["approximate_optimum_proved"]
    assert not found.optimal  # of the approximation only
    assert found.details["approximate_objective_j"] == pytest.approx(min(possible), rel=1e-5)
    assert fitted_cost(instance, found.schedule.controls) == pytest.approx(min(possible), rel=1e-5)
    assert found.objective == pytest.approx(found.replay["objective"], rel=1e-12)
    with pytest.raises(BudgetExceededError, match="proves nothing about the demand model"):
        solve(replace(instance, distance_m=9e4), "scip")


def test_milp_tells_what_it_proved():
    pytest.importorskip("scipy")
    solution = solve(binary_instance(20, dv_mps=0.1, alpha=0.6, distance_units=60.0), "milp")
    assert solution.optimal
    assert solution.details["bound"] == pytest.approx(solution.objective, rel=1e-12)
    assert solution.details["variables"] == 59


def test_what_highs_prints_is_no_answer(capfd, monkeypatch):
    """Some of its messages come whatever it is told, from below Python."""
    optimize = pytest.importorskip("scipy.optimize")
    find = optimize.milp

    def talkative(**program):
        os.write(1, b"HighsMipSolverData\n")
        return find(**program)

    monkeypatch.setattr(optimize, "milp", talkative)
    assert solve(binary_instance(8, distance_units=10.0), "milp").optimal
    print("answer")
    assert capfd.readouterr().out == "answer\n"


def test_milp_ends_at_its_time_limit():
    pytest.importorskip("scipy")
    instance = binary_instance(60, model="efficiency", cap_units=20, distance_units=450.0, deta=0.01)
    try:
        solution = solve(instance, "milp", allowance=Allowance(time_limit_s=0.2))
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


def test_integers_of_mps_stand_between_markers_as_the_format_has_them():
    """SCIP also takes a marker behind a column's name; HiGHS then reads real variables, and others nothing."""
    program = binary_program(binary_instance(6, model="kinetic", distance_units=5.0))
    markers = [line.split() for line in mps_text(program).splitlines() if "MARKER" in line]
    assert [line[-1] for line in markers] == ["'INTORG'", "'INTEND'"] * 2
    assert all(line[1] == "'MARKER'" and len(line) == 3 for line in markers)


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
