"""Samplers and exact solvers of a QUBO, against the dynamic program."""

import importlib.abc
import sys
from dataclasses import fields

import numpy as np
import pytest

from tests.helpers.instance_case import binary_instance, random_instance
from tgvdp.errors import InfeasibleError, InputError, MissingExtraError
from tgvdp.formulations.qubo.bits import encode_bits
from tgvdp.formulations.qubo.names import BitsForm
from tgvdp.formulations.qubo.qubo import QuboBuilder
from tgvdp.solvers.allowance import ITEMS, Allowance, BetaRange
from tgvdp.solvers.registry import SOLVERS, solve
from tgvdp.solvers.tempering.kernel import temper

pytestmark = pytest.mark.filterwarnings("ignore::tgvdp.formulations.problem.binary.FormulationWarning")

SAMPLERS = ("sa", "pt", "tabu", "descent")
#: Modules of solvers that need no extra.
OWN = ("exact.solve", "greedy", "samplers.coin_tosses", "tempering.solve")


@pytest.mark.parametrize("encoding", ["bits", "bits+slack", "unary"])
@pytest.mark.parametrize("solver", SAMPLERS)
def test_samplers_find_a_small_optimum_and_repeat_it(solver, encoding):
    pytest.importorskip("dwave.samplers")
    instance = binary_instance(4)
    found, again = (solve(instance, solver, encoding, allowance=Allowance(reads=50, sweeps=200)) for _ in range(2))
    assert found.objective == solve(instance, "dp").objective
    assert found.feasible
    assert not found.optimal  # a heuristic proves nothing
    assert found.n_optimal is None
    assert found.qubo["minimum"] == pytest.approx(found.objective)
    assert found.details["reads"] == 50
    assert 0 < found.details["best_reads"] <= found.details["feasible_reads"] <= 50
    assert (found.schedule, found.details) == (again.schedule, again.details)


@pytest.mark.parametrize("solver", SAMPLERS)
def test_seeds_and_budgets_change_what_is_drawn(solver):
    pytest.importorskip("dwave.samplers")
    instance = binary_instance(8)

    def drawn(**changes):
        details = solve(instance, solver, "bits", allowance=Allowance(**{"reads": 200, "sweeps": 20} | changes)).details
        return details["best_reads"], details["feasible_reads"]

    assert drawn(seed=1) != drawn(seed=2)
    if solver != "descent":
        assert drawn(sweeps=1) < drawn(sweeps=2000)


def test_a_longer_tenure_makes_tabu_search_find_what_a_short_one_misses():
    pytest.importorskip("dwave.samplers")
    instance = binary_instance(8, distance_units=10.0)

    def drawn(tenure):
        return solve(instance, "tabu", "bits", allowance=Allowance(reads=50, tenure=tenure)).details

    assert drawn(0.5)["tenure"] == 8 and drawn(1e-3)["tenure"] == 1
    assert drawn(0.5)["best_reads"] > 2 * drawn(1e-3)["best_reads"]


@pytest.mark.parametrize("sweeps", [1, 100, 199, 200, 201, 300, 1000, 3000])
def test_tabu_search_makes_the_sweeps_that_it_was_given(sweeps, monkeypatch):
    """Two stages of 200 for 300 sweeps were a third more work than the other samplers got."""
    samplers = pytest.importorskip("dwave.samplers")
    given, search = {}, samplers.TabuSampler.sample
    monkeypatch.setattr(
        samplers.TabuSampler, "sample", lambda self, bqm, **budget: given.update(budget) or search(self, bqm, **budget)
    )
    details = solve(binary_instance(4), "tabu", "unary", allowance=Allowance(reads=1, sweeps=sweeps)).details
    made = given["coefficient_z_first"] + given["num_restarts"] * given["coefficient_z_restart"]
    assert details["sweeps"] == made
    assert sweeps <= made <= sweeps + given["num_restarts"]
    assert given["coefficient_z_first"] == given["coefficient_z_restart"] <= 200


@pytest.mark.parametrize("solver", ["sa", "pt"])
def test_temperatures_decide_what_annealing_finds(solver):
    """Far too hot is tossing coins."""
    pytest.importorskip("dwave.samplers")
    instance = binary_instance(16, distance_units=40.0)
    best = solve(instance, "dp").objective

    def successes(beta):
        found = solve(instance, solver, "unary", 0.3, Allowance(beta=beta, sweeps=300))
        return found.details["best_reads"] if found.feasible and found.objective == best else 0

    assert successes(BetaRange(1e-6, 2e-6)) == 0
    assert successes(BetaRange(1.0, 20.0)) > 20


def test_tempering_returns_the_lowest_string_that_it_met():
    rng = np.random.default_rng(5)
    linear = rng.normal(size=10)
    upper = np.triu(rng.normal(size=(10, 10)), 1)
    strings = (np.arange(1 << 10)[:, None] >> np.arange(10)) & 1
    energies = strings @ linear + np.einsum("ki,ij,kj->k", strings, upper, strings)
    bits = temper(linear, upper + upper.T, np.geomspace(0.1, 10.0, 4), 50, 20, 7)
    assert (bits == strings[energies.argmin()]).all(axis=1).mean() > 0.9
    assert np.array_equal(bits, temper(linear, upper + upper.T, np.geomspace(0.1, 10.0, 4), 50, 20, 7))


@pytest.mark.parametrize("seed", range(3))
def test_exact_qubo_and_tree_equal_the_dynamic_program(seed):
    pytest.importorskip("dwave.samplers")
    rng = np.random.default_rng(seed)
    for _ in range(8):
        instance = random_instance(rng, 5)
        encoding = "unary" if instance.acc_units == instance.dec_units else "bits"
        try:
            best = solve(instance, "dp")
        except InfeasibleError:
            best = None
        for solver in ("exact-qubo", "tree"):
            found = solve(instance, solver, encoding)
            if best is None or (encoding == "bits" and not found.feasible):
                assert not found.optimal
                continue
            assert found.optimal
            assert found.objective == pytest.approx(best.objective, rel=1e-12)
            if solver == "exact-qubo":
                assert found.n_optimal == best.n_optimal


@pytest.mark.parametrize(
    ("encoding", "changes"),
    [
        ("bits", {"model": "kinetic", "cap_units": [4, 4, 1, 3, 2], "distance_units": 5.0}),  # one above the limit
        ("bits+slack", {"cap_units": 3, "distance_units": 3.0}),  # a limit of 2 in the middle has two codes for 1
        ("unary", {"distance_units": 3.0, "tol_units": 1.0, "alpha": 1.0}),  # and so has a tolerance
    ],
)
def test_strings_of_one_schedule_count_once_and_those_that_break_a_limit_not_at_all(encoding, changes):
    pytest.importorskip("dimod")
    instance = binary_instance(5, **changes)
    found = solve(instance, "exact-qubo", encoding)
    assert found.optimal
    assert found.n_optimal == solve(instance, "dp").n_optimal < found.details["ground_states"]


def test_a_ground_state_that_breaks_a_constraint_is_no_optimum():
    pytest.importorskip("dimod")
    found = solve(binary_instance(6), "exact-qubo", "bits", penalty=1e-3)
    assert not found.optimal
    assert not found.feasible
    assert found.n_optimal is None


def test_a_limit_on_the_total_proves_nothing_about_what_it_forbids():
    pytest.importorskip("dimod")
    from tgvdp.solvers.samplers.annealing import solve_exact_qubo

    # 1 0 1 0: two accelerations below a cap of 1, which Σx ≤ 1 forbids.
    instance = binary_instance(4, cap_units=1, distance_units=2.0)
    encoded = encode_bits(instance, 10.0, BitsForm(limits="total"))
    found = solve_exact_qubo(encoded, Allowance())
    assert not encoded.complete
    assert found.feasible
    assert not found.optimal


@pytest.mark.parametrize("solver", [*SAMPLERS, "tree", "exact-qubo"])
def test_no_bits_have_one_string(solver):
    pytest.importorskip("dwave.samplers")
    found = solve(binary_instance(1, distance_units=0.0), solver, "unary")
    assert found.schedule.speeds == (0, 0)
    assert found.feasible
    assert found.qubo["variables"] == 0
    assert found.optimal == (solver not in SAMPLERS)


def test_wide_and_long_problems_are_refused():
    pytest.importorskip("dwave.samplers")
    from tgvdp.solvers.samplers.annealing import elimination_order

    with pytest.raises(InputError, match="too many to enumerate"):
        solve(binary_instance(12), "exact-qubo", "bits")
    with pytest.raises(InputError, match="width above"):
        solve(binary_instance(12), "tree", "bits")
    with pytest.raises(InputError, match="bits are more than"):
        elimination_order(QuboBuilder(str(i) for i in range(5001)).build())


def test_elimination_of_a_chain_and_of_a_ring():
    from tgvdp.solvers.samplers.annealing import elimination_order

    builder = QuboBuilder(str(i) for i in range(40))
    for i in range(39):
        builder.add_quadratic(i, i + 1, 1.0)
    assert elimination_order(builder.build())[1] == 1
    builder.add_quadratic(39, 0, 1.0)
    order, width = elimination_order(builder.build())
    assert (sorted(order), width) == (list(range(40)), 2)


class Blocked(importlib.abc.MetaPathFinder):
    """Makes packages look as if they were not installed."""

    packages = ("dimod", "dwave", "minorminer", "qiskit", "qiskit_aer", "qiskit_ibm_runtime", "pyscipopt", "scipy")

    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in self.packages:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return None


@pytest.fixture
def no_extra(monkeypatch):
    """An installation without the extra."""
    for name in list(sys.modules):
        if name.partition(".")[0] in Blocked.packages:
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [Blocked(), *sys.meta_path])


@pytest.mark.parametrize("solver", [name for name, entry in SOLVERS.items() if entry.module not in OWN])
def test_a_missing_extra_is_one_line_that_says_what_to_install(solver, no_extra):
    with pytest.raises(MissingExtraError) as caught:
        solve(binary_instance(4), solver)
    message = str(caught.value)
    assert message.startswith(f"solver {solver} needs the package ")
    assert message.endswith("pip install 'tgvdp[quantum]'")
    assert "\n" not in message


@pytest.mark.parametrize("solver", [name for name, entry in SOLVERS.items() if entry.module in OWN])
def test_solvers_of_our_own_need_no_extra(solver, no_extra):
    assert solve(binary_instance(4), solver).optimal == (solver not in ("greedy", "random", "pt"))


def test_every_field_of_an_allowance_is_declared_and_used():
    names = [field.name for field in fields(Allowance)]
    assert [item.field for item in ITEMS] == names
    assert {name for entry in SOLVERS.values() for name in entry.uses} == set(names)


@pytest.mark.parametrize(
    ("changes", "part"),
    [
        ({"seed": -1}, "seed"),
        ({"reads": 0}, "reads"),
        ({"sweeps": 0}, "sweeps"),
        ({"layers": 0}, "layers"),
        ({"starts": -1}, "starts"),
        ({"angles": "best"}, "angles"),
        ({"mixer": "y"}, "mixer"),
        ({"tenure": 1.5}, "tenure must be above 0 and at most 1"),
        ({"beta": BetaRange(2.0, 1.0)}, "LOW < HIGH"),
        ({"replicas": 1}, "replicas"),
        ({"step": 0.5}, "needs angles ramp"),
        ({"mixer": "walls"}, "needs angles ramp"),
        ({"chain_strength": -1.0}, "chain-strength"),
        ({"time_limit_s": 0.0}, "time-limit"),
    ],
)
def test_wrong_options_are_refused(changes, part):
    with pytest.raises(InputError, match=part):
        Allowance(**changes)
