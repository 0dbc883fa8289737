"""The exact solvers against each other, and their limits."""

import json
import math
import random
from dataclasses import replace

import numpy as np
import pytest

from tgvdp.cli import main
from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.formulations.problem.binary import in_model_units, schedule_of_controls
from tgvdp.formulations.problem.instances import BinaryInstance
from tgvdp.formulations.problem.levels import ladder_of
from tgvdp.solvers.exact.brute_force import best_plans
from tgvdp.solvers.exact.closed_form import closed_form
from tgvdp.solvers.exact.dynamic_program import optimal_plan
from tgvdp.solvers.registry import solve


def instance(steps, distance, cap=None, **changes):
    base = dict(
        id="t", model="constant", steps=steps, dt_s=10.0, dv_mps=1.0, acc_units=1, dec_units=1,
        cap_units=(steps if cap is None else cap,) * steps, distance_units=float(distance), alpha=0.3, eta0=0.9,
        deta=0.001,
    )  # fmt: skip
    return BinaryInstance(**base | changes)


def random_instance(draw):
    steps, a = draw.randint(1, 8), draw.choice((1, 1, 1, 2, 2, 3))
    caps = draw.choice(([draw.randint(0, 6) for _ in range(steps)], [draw.randint(1, 8)] * steps))
    return instance(
        steps, draw.choice((draw.randint(0, 16), draw.randint(0, 40) / 2)), acc_units=a,
        dec_units=draw.choice((a, a, 1, 2, 3)), cap_units=tuple(caps), tol_units=draw.choice((0.0, 0.0, 0.5, 1.0, 2.5)),
        model=draw.choice(("constant", "kinetic", "efficiency")), alpha=draw.choice((0.0, 0.3, 1.0, 0.75)),
        eta0=draw.choice((0.9, 0.5, 0.0, 1.0)), deta=draw.choice((0.01, 0.1, 0.0, -0.05)), dv_mps=0.7,
    )  # fmt: skip


@pytest.mark.nojit
def test_dynamic_program_brute_force_and_closed_form_agree():
    draw, feasible, closed = random.Random(11), 0, 0
    for trial in range(700):
        one = random_instance(draw)
        if trial % 3 == 0:  # where a closed form is known
            one = replace(one, dec_units=one.acc_units, cap_units=one.cap_units[:1] * one.steps, tol_units=0.0)
        try:
            plans, exact = best_plans(one)
        except InfeasibleError:
            with pytest.raises(InfeasibleError):
                optimal_plan(ladder_of(one))
            continue
        ladder = ladder_of(one)
        found = optimal_plan(ladder)
        feasible += 1
        assert found.n_optimal == len(plans)
        assert ladder.objective(found.cost) == in_model_units(one, exact)
        schedule = schedule_of_controls(one, np.sign(np.diff(found.levels)))
        assert schedule.feasible
        assert schedule.objective == pytest.approx(in_model_units(one, exact), abs=1e-12)
        try:
            plan = schedule_of_controls(one, closed_form(one))
        except InputError:
            continue
        assert plan.feasible
        assert plan.objective == pytest.approx(in_model_units(one, exact), abs=1e-12)
        closed += 1
    assert feasible > 150
    assert closed > 20


@pytest.mark.parametrize("model", ["constant", "kinetic"])
def test_closed_form_at_any_length(model):
    draw = random.Random(5)
    for _ in range(30):
        steps = draw.randint(10, 120)
        one = instance(steps, draw.randint(1, steps * steps // 4), model=model)
        found = optimal_plan(ladder_of(one))
        plan = schedule_of_controls(one, closed_form(one))
        assert plan.feasible
        assert ladder_of(one).objective(found.cost) == pytest.approx(plan.objective, rel=1e-12)


def test_families_of_top_speeds_change_nothing(monkeypatch):
    one = instance(60, 450, model="efficiency")
    whole = optimal_plan(ladder_of(one))
    monkeypatch.setattr("tgvdp.solvers.exact.dynamic_program._SPLIT_ABOVE", 100)
    split = optimal_plan(ladder_of(one))
    assert split.bound > whole.bound
    assert (split.cost, split.n_optimal) == (whole.cost, whole.n_optimal)


def test_splitting_at_once_changes_nothing_either(monkeypatch):
    """Every family of more than one state is split, on random instances, some with a tolerance, some infeasible."""
    draw = random.Random(7)
    solved = 0
    for _ in range(60):
        one = replace(random_instance(draw), model="efficiency")
        outcomes = []
        for most in (10**9, 0):
            monkeypatch.setattr("tgvdp.solvers.exact.dynamic_program._SPLIT_ABOVE", most)
            try:
                found = optimal_plan(ladder_of(one))
                outcomes.append((found.cost, found.n_optimal))
            except InfeasibleError:
                outcomes.append(None)
        assert outcomes[0] == outcomes[1], one
        solved += outcomes[0] is not None
    assert 10 <= solved <= 58


@pytest.mark.nojit
def test_counts_beyond_64_bits_are_exact():
    """With α = 1 every plan costs nothing: what is counted are the Motzkin paths of a given area, by an own program."""
    one = instance(60, 300, alpha=1.0)
    counts = {(0, 0): 1}
    for _ in range(60):
        after = {}
        for (v, s), paths in counts.items():
            for w in (v - 1, v, v + 1):
                if w >= 0 and s + w <= 300:
                    after[w, s + w] = after.get((w, s + w), 0) + paths
        counts = after
    assert counts[0, 300] > 2**64
    assert optimal_plan(ladder_of(one)).n_optimal == counts[0, 300]


def test_budget_is_kept_and_said():
    with pytest.raises(BudgetExceededError, match="may keep 100"):
        optimal_plan(ladder_of(instance(60, 450)), most_states=100)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["constant", "kinetic"])
def test_a_thousand_steps(model):
    one = instance(1000, 125_000, model=model)
    solution = solve(one, "dp")
    assert solution.feasible
    assert solution.replay["feasible"]
    assert solution.objective == pytest.approx(schedule_of_controls(one, closed_form(one)).objective)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "distance", "cap", "objective"),
    [
        ({"model": "efficiency", "deta": 0.005}, 60_000, 100, 25666.5),
        ({"model": "efficiency", "deta": 0.001}, 166_666, 500, 104_680.252),
        ({"acc_units": 2, "dec_units": 3}, 300_000, 1000, None),
        ({"model": "kinetic", "acc_units": 2, "dec_units": 3}, 300_000, 1000, None),
    ],
)
def test_a_thousand_steps_that_are_hard(changes, distance, cap, objective):
    """Objectives were found by an earlier edition, which filled all windows anew after each split."""
    solution = solve(instance(1000, distance, cap, **changes), "dp")
    assert solution.optimal and solution.feasible and solution.replay["feasible"]
    assert solution.details["bound"] <= solution.objective
    assert objective is None or solution.objective == pytest.approx(objective, rel=1e-6)
    assert solution.details["states"] < 1.2e9


def test_closed_form_says_where_it_does_not_apply():
    with pytest.raises(InputError, match="unequal steps"):
        closed_form(instance(8, 8, dec_units=2))
    with pytest.raises(InputError, match="efficiency"):
        closed_form(instance(8, 8, model="efficiency"))


def demand_file(tmp_path, **changes):
    params = {
        "kind": "demand", "N": 6, "dt_s": 15, "notches": 2, "mass_kg": 300000, "rot": 1.08,
        "davis_SI": [1770, 35.4, 6.6], "vmax_kmh": 160, "D_m": 900, "tol_m": 40, "v_end_max_mps": 1.5,
        "P_max_W": 9.8e6, "cost_ref_kmh": 220, "alpha": 0.3,
    } | changes  # fmt: skip
    path = tmp_path / "demand.json"
    path.write_text(json.dumps({"id": "d", "params": params}))
    return str(path)


def run(capsys, *arguments):
    code = main(["solve", *arguments, "--json"])
    return code, capsys.readouterr().out


def test_demand_layers_equal_brute_force(tmp_path, capsys):
    solved = 0
    hill = {"gradients_permil": [[0, 2], [300, -8], [700, 6]], "curves_m": [[0, None], [500, 500]]}
    cases = ((4, 500, {}), (5, 700, {}), (6, 900, {}), (6, 1200, {}), (7, 1500, {}), (6, 900, hill), (7, 1400, hill))
    for steps, distance, line in cases:
        path = demand_file(tmp_path, N=steps, D_m=distance, **line)
        codes, texts = zip(*(run(capsys, path, "--solver", name) for name in ("brute", "dp")), strict=True)
        assert codes[0] == codes[1]
        if codes[0]:
            assert codes[0] == InfeasibleError.exit_code
            continue
        brute, layers = map(json.loads, texts)
        assert layers["objective"] == pytest.approx(brute["objective"], rel=1e-12)
        assert layers["n_optimal"] == brute["n_optimal"]
        assert layers["optimal"]
        assert layers["details"]["bound"] <= layers["objective"]
        assert layers["replay"]["feasible"]
        assert abs(layers["replay"]["fine"]["distance_error_m"]) > 0.0
        solved += 1
    assert solved >= 4


@pytest.mark.parametrize(("steps", "count"), [(33, 3**33), (34, None)])
def test_as_many_plans_are_counted_as_doubles_tell_apart(tmp_path, capsys, steps, count):
    """A standing train may brake, or not."""
    path = demand_file(tmp_path, N=steps, notches=2, D_m=0, tol_m=0, v_end_max_mps=0)
    code, text = run(capsys, path, "--solver", "dp")
    assert code == 0
    assert json.loads(text)["n_optimal"] == count


def binary_file(tmp_path, **changes):
    params = {
        "kind": "binary", "model": "constant", "N": 8, "dt_s": 10, "dv_mps": 0.5, "acc_units": 1, "dec_units": 1,
        "cap_units": 3, "D_units": 12,
    } | changes  # fmt: skip
    path = tmp_path / "binary.json"
    path.write_text(json.dumps({"id": "b", "params": params}))
    return str(path)


@pytest.mark.parametrize("solver", ["dp", "brute", "closed"])
def test_command_prints_the_schema(tmp_path, capsys, solver):
    code, text = run(capsys, binary_file(tmp_path), "--solver", solver)
    content = json.loads(text)
    assert code == 0
    assert content["schema"] == "tgvdp.solve/2"
    assert content["solver"] == solver
    assert content["objective"] == pytest.approx(0.5)
    assert content["optimal"] and content["feasible"] and content["replay"]["feasible"]
    assert len(content["speeds_dv"]) == 9
    assert content["distance_dv_dt"] == 12.0
    assert main(["solve", binary_file(tmp_path), "--solver", solver]) == 0
    assert "optimal, proved" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("solver", "flag"),
    [
        ("dp", "--reads=5"),
        ("closed", "--seed=1"),
        ("milp", "--sweeps=5"),
        ("sa", "--time-limit=3"),
        ("sa", "--layers=2"),
        ("descent", "--sweeps=3"),
        ("qaoa", "--sweeps=3"),
        ("tabu", "--backend=fake_manila"),
        ("scip", "--angles=ramp"),
    ],
)
def test_budgets_that_a_solver_does_not_use_are_wrong_usage(tmp_path, capsys, solver, flag):
    assert main(["solve", binary_file(tmp_path), "--solver", solver, flag]) == 2
    err = capsys.readouterr().err
    assert err.startswith(f"tgvdp: error: solver {solver} does not use {flag.partition('=')[0]}; ")
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--sweeps=5", "--reads=5"], "does not use --reads, --sweeps; sa, "),
        (["--layers=2", "--tenure=0.1"], "does not use --tenure, --layers; no solver uses all of them"),
        (["--penalty=3", "--encoding=unary"], "makes no QUBO: --encoding and --penalty have no effect"),
    ],
)
def test_all_that_a_solver_does_not_use_is_named(tmp_path, capsys, flags, said):
    assert main(["solve", binary_file(tmp_path), "--solver", "dp", *flags]) == 2
    assert f"solver dp {said}" in capsys.readouterr().err


def test_command_exits_4_where_nothing_is_feasible_and_3_on_misuse(tmp_path, capsys):
    assert main(["solve", binary_file(tmp_path, D_units=1000)]) == 4
    assert main(["solve", binary_file(tmp_path, N=30), "--solver", "brute"]) == 3
    assert main(["solve", binary_file(tmp_path, N=50_000, cap_units=50_000)]) == BudgetExceededError.exit_code
    assert main(["solve", binary_file(tmp_path, model="efficiency", eta0=1e308, deta=1.0)]) == 3
    assert main(["solve", binary_file(tmp_path), "--solver", "dp", "--penalty", "tenfold"]) == 2
    assert main(["solve", demand_file(tmp_path), "--solver", "closed"]) == 3
    assert main(["solve", binary_file(tmp_path), "--solver", "scip", "--form", "joint"]) == 3
    assert main(["solve", binary_file(tmp_path), "--penalty", "nan", "--solver", "dp"]) == 2
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 8
    assert math.prod(line.startswith("tgvdp: error: ") for line in errors)
