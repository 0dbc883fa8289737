"""The seed's search: equal to the exact method when nothing stops it, and honest when something does."""

import time

import numpy as np
import pytest

from tests.helpers.grid_case import (
    FAR,
    all_paths,
    best_first_twin,
    brute_front,
    front_of,
    points_of,
    random_graph,
    toy_trip,
)
from tgvdp.constants import HEURISTICS
from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.grid.best_first import best_first, best_first_paths
from tgvdp.methods.grid.best_first_rules import Options
from tgvdp.methods.grid.exact import exact_front, exact_paths
from tgvdp.methods.grid.grid import build_grid
from tgvdp.methods.grid.layered import layered_graph
from tgvdp.methods.grid.paths import path_costs

BUDGET = SearchBudget(1_000_000, 30.0)


@pytest.mark.nojit
@pytest.mark.parametrize("heuristic", HEURISTICS)
@pytest.mark.parametrize("integer", [False, True])
def test_tiny_graphs_equal_enumeration(heuristic, integer):
    graph = random_graph(np.random.default_rng(7), layers=4, width=3, integer=integer)
    found = best_first_paths(graph, FAR, BUDGET, Options(heuristic=heuristic))
    assert points_of(found) == brute_front(graph, FAR)


def test_hundreds_of_random_graphs_equal_the_exact_method_to_the_last_bit():
    for seed in range(400):
        rng = np.random.default_rng(2000 + seed)
        graph = random_graph(rng, layers=int(rng.integers(3, 8)), width=4, integer=seed % 3 == 0, density=0.7)
        times = sorted({time for time, *_ in all_paths(graph)})
        limit = max(times[int(rng.integers(len(times)))], 1e-3)
        options = Options(heuristic=HEURISTICS[seed % 4], paths=None if seed % 2 else 0)
        found = best_first_paths(graph, limit, BUDGET, options)
        assert found.complete
        assert points_of(found) == points_of(exact_paths(graph, limit, BUDGET)), seed


@pytest.mark.parametrize("heuristic", HEURISTICS)
@pytest.mark.parametrize(("dominance", "bounds"), [(True, False), (False, True), (False, False)])
def test_no_pruning_rule_loses_a_path(heuristic, dominance, bounds):
    for seed in range(20):
        graph = random_graph(np.random.default_rng(seed), layers=6, width=3, integer=seed % 2 == 0)
        options = Options(heuristic=heuristic, dominance=dominance, bounds=bounds)
        found = best_first_paths(graph, FAR, BUDGET, options)
        assert points_of(found) == brute_front(graph, FAR), seed


@pytest.mark.parametrize("seed", range(8))
def test_long_lists_equal_the_twin(seed):
    """Lists longer than one time bucket: enough labels per node to fill and displace buckets."""
    graph = random_graph(np.random.default_rng(seed), layers=9, width=7, integer=seed % 4 == 3)
    found = best_first_paths(graph, FAR, BUDGET, Options(heuristic="energy"))
    assert points_of(found) == best_first_twin(graph, FAR, 0.0)
    limit = float(found.duration_s[len(found.duration_s) // 2])
    inside = best_first_paths(graph, limit, BUDGET, Options(heuristic="weighted", bounds=False, weight=0.7))
    assert points_of(inside) == best_first_twin(graph, limit, 0.7)


@pytest.mark.parametrize("bounds", [True, False])
def test_first_path_is_best_for_its_heuristic(bounds):
    for seed in range(20):
        graph = random_graph(np.random.default_rng(seed), layers=6, width=4)
        paths = all_paths(graph)
        for heuristic, cost in (
            ("time", lambda t, e: t),
            ("energy", lambda t, e: e),
            ("weighted", lambda t, e: e + 0.5 * t),
        ):
            weight = 0.5 if heuristic == "weighted" else None
            options = Options(heuristic=heuristic, paths=1, bounds=bounds, weight=weight)
            found = best_first_paths(graph, FAR, BUDGET, options)
            assert len(found.duration_s) == 1
            best = min(cost(t, e) for t, e, _ in paths)
            assert cost(found.duration_s[0], found.energy_j[0]) == pytest.approx(best, rel=1e-12)


def test_paths_asked_for_are_no_copies_and_lie_on_no_worse_front():
    grid = build_grid(toy_trip(), segment_m=0.2, speeds=12)
    limit = 2.0 * exact_front(grid, FAR, BUDGET).duration_s[0]
    exact = exact_front(grid, limit, BUDGET)
    range_s, range_j = limit - exact.duration_s[0], exact.energy_j[0] - exact.energy_j[-1]
    for heuristic in HEURISTICS:
        for count in (1, 2, 5, 12):
            found = best_first(grid, limit, BUDGET, heuristic, count)
            assert found.complete
            assert len(found) == count, heuristic
            assert front_of(points_of(found)) == points_of(found)
            away = np.abs(np.diff(found.duration_s)) > 0.5 / count * range_s
            away |= np.abs(np.diff(found.energy_j)) > 0.5 / count * range_j
            assert np.all(away)
    assert best_first(grid, limit, BUDGET, "time", 12).counters["near_copies"] > 0


def test_counters_balance_and_every_rule_works():
    grid = build_grid(toy_trip(limits=((0.0, 1.0), (1.0, 0.7))), segment_m=0.25, speeds=10)
    limit = 1.4 * exact_front(grid, FAR, BUDGET).duration_s[0]
    found = best_first(grid, limit, BUDGET, "energy")
    counters = found.counters
    for name in ("expanded", "generated", "pruned_constraint", "pruned_delay", "pruned_bound", "pruned_dominance"):
        assert counters[name] > 0, name
    assert counters["terminals"] == len(found)
    assert counters["bytes"] > 44 * counters["labels"]
    free = best_first(grid, limit, BUDGET, "energy", bounds=False)
    assert free.counters["pruned_bound"] == 0
    assert free.counters["expanded"] > counters["expanded"]
    assert points_of(free) == points_of(found) == points_of(exact_front(grid, limit, BUDGET))


def test_the_naive_search_ends_by_its_budget_and_says_what_to_do():
    grid = build_grid(toy_trip(), segment_m=0.1, speeds=20)
    with pytest.raises(BudgetExceededError, match="switch on bounds and dominance"):
        best_first(grid, FAR, SearchBudget(50_000, 10.0), "time", dominance=False, bounds=False)


def test_a_budget_that_ends_later_leaves_a_partial_answer():
    grid = build_grid(toy_trip(), segment_m=0.1, speeds=20)
    limit = 1.3 * exact_front(grid, 100.0, BUDGET).duration_s[0]
    found = best_first(grid, limit, SearchBudget(5_000), "time")
    assert not found.complete
    assert 1 <= len(found) < len(exact_front(grid, limit, BUDGET))
    assert found.counters["labels"] <= 5_000


def test_the_time_limit_holds_within_half_a_second():
    grid = build_grid(toy_trip(), segment_m=0.05, speeds=40)
    best_first(grid, FAR, BUDGET, "time", 1)
    started = time.perf_counter()
    with pytest.raises(BudgetExceededError, match="time limit ended the search"):
        best_first(grid, FAR, SearchBudget(20_000_000, 0.2), "energy", dominance=False, bounds=False)
    assert time.perf_counter() - started < 0.2 + 0.5


def test_nodes_walk_their_history():
    grid = build_grid(toy_trip(), segment_m=0.5, speeds=5)
    found = best_first(grid, 20.0, BUDGET, "weighted", 3)
    for index in range(len(found)):
        node = found.node(index)
        assert (node.distance_m, node.speed_mps) == (2.0, 0.0)
        assert (node.duration_s, node.energy_j) == (found.duration_s[index], found.energy_j[index])
        assert node.history == tuple(grid.level_mps[found.path_levels[index][:-1]])
        ancestors = list(node.ancestors())
        assert [a.distance_m for a in ancestors] == grid.station_m[:-1][::-1].tolist()
        course_s, _ = path_costs(grid.graph, grid.nodes(found.path_levels[index]))
        assert [a.duration_s for a in ancestors] == course_s[:-1][::-1].tolist()
        root = ancestors[-1]
        assert (root.parent, root.history, root.duration_s, root.energy_j) == (None, (), 0.0, 0.0)


def test_reference_and_weight_steer_the_search():
    grid = build_grid(toy_trip(), segment_m=0.2, speeds=12)
    cheap, dear = (best_first(grid, 20.0, BUDGET, "weighted", 1, weight=weight) for weight in (1e-3, 1e3))
    assert cheap.duration_s[0] > dear.duration_s[0]
    exact = exact_front(grid, 20.0, BUDGET)
    near = best_first(grid, 20.0, BUDGET, "ratio", 1, reference_time_s=float(exact.duration_s[0]))
    far = best_first(grid, 20.0, BUDGET, "ratio", 1, reference_time_s=float(exact.duration_s[0]) * 0.5)
    assert near.duration_s[0] < far.duration_s[0]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"heuristic": "speed"}, "heuristic must be one of"),
        ({"paths": -1}, "paths"),
        ({"paths": 2.5}, "paths"),
        ({"weight": 1.0}, "weight belongs to"),
        ({"heuristic": "weighted", "weight": -1.0}, "weight"),
        ({"reference_time_s": float("nan")}, "reference_time_s"),
    ],
)
def test_wrong_options_are_refused(options, words):
    with pytest.raises(InputError, match=words):
        Options(**options)


def test_a_limit_below_the_fastest_path_is_infeasible():
    graph = layered_graph([1, 1], [0], [1], [2.0], [3.0])
    for bounds in (True, False):
        with pytest.raises(InfeasibleError, match="fastest path takes 2 s"):
            best_first_paths(graph, np.nextafter(2.0, 0.0), BUDGET, Options(bounds=bounds))


@pytest.mark.parametrize(
    "limits", [{"max_labels": 0}, {"max_labels": 1.5}, {"max_labels": 2**31}, {"time_limit_s": 0.0}]
)
def test_wrong_budgets_are_refused(limits):
    with pytest.raises(InputError, match=next(iter(limits))):
        SearchBudget(**limits)
