"""Method exact against full enumeration, a readable twin, and networkx."""

import time

import networkx
import numpy as np
import pytest

from tests.helpers.grid_case import (
    FAR,
    all_paths,
    brute_front,
    front_of,
    labels_twin,
    points_of,
    random_graph,
    toy_trip,
)
from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.grid.exact import exact_front, exact_paths
from tgvdp.methods.grid.grid import build_grid
from tgvdp.methods.grid.layered import layered_graph
from tgvdp.methods.grid.networkx_view import networkx_view
from tgvdp.methods.grid.paths import path_costs
from tgvdp.runs.fastest import fastest_run

BUDGET = SearchBudget(1_000_000, 30.0)


@pytest.mark.nojit
@pytest.mark.parametrize("integer", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_tiny_graphs_equal_enumeration(seed, integer):
    graph = random_graph(np.random.default_rng(seed), layers=4, width=3, integer=integer)
    assert points_of(exact_paths(graph, FAR, BUDGET)) == brute_front(graph, FAR)


def test_hundreds_of_random_graphs_equal_enumeration_to_the_last_bit():
    for seed in range(300):
        rng = np.random.default_rng(1000 + seed)
        graph = random_graph(rng, layers=int(rng.integers(2, 7)), width=4, integer=seed % 3 == 0, density=0.7)
        times = sorted({time for time, *_ in all_paths(graph)})
        limit = max(times[int(rng.integers(len(times)))], 1e-3)
        assert points_of(exact_paths(graph, limit, BUDGET)) == brute_front(graph, limit)


@pytest.mark.parametrize("seed", range(10))
def test_larger_graphs_equal_the_twin(seed):
    rng = np.random.default_rng(seed)
    graph = random_graph(rng, layers=12, width=8, integer=seed % 2 == 0)
    whole = labels_twin(graph, FAR)
    assert points_of(exact_paths(graph, FAR, BUDGET)) == whole
    for limit in np.quantile([point[0] for point in whole], [0.0, 0.3, 0.7, 1.0], method="nearest"):  # bounds bite
        assert points_of(exact_paths(graph, max(limit, 1e-3), BUDGET)) == labels_twin(graph, max(limit, 1e-3))


@pytest.mark.parametrize("seed", range(5))
def test_ends_of_the_front_are_networkx_shortest_paths(seed):
    graph = random_graph(np.random.default_rng(seed), layers=10, width=6)
    view = networkx_view(graph)
    ends = (next(iter(view)), list(view)[-1])
    found = exact_paths(graph, FAR, BUDGET)
    assert found.duration_s[0] == pytest.approx(networkx.dijkstra_path_length(view, *ends, weight="duration_s"))
    assert found.energy_j[-1] == pytest.approx(networkx.dijkstra_path_length(view, *ends, weight="energy_j"))


@pytest.mark.parametrize("seed", range(5))
def test_paths_have_the_costs_that_they_claim(seed):
    graph = random_graph(np.random.default_rng(seed), layers=9, width=5)
    found = exact_paths(graph, FAR, BUDGET)
    for nodes, duration_s, energy_j in zip(found.nodes, found.duration_s, found.energy_j, strict=True):
        course_s, course_j = path_costs(graph, nodes)
        assert (course_s[-1], course_j[-1]) == (duration_s, energy_j)


def test_equal_paths_and_equal_times_leave_one():
    # Two middle nodes, four ways of equal time, two of them of equal and least energy.
    graph = layered_graph(
        [1, 2, 2, 1],
        [0, 0, 1, 1, 2, 2, 3, 4],
        [1, 2, 3, 4, 3, 4, 5, 5],
        [1.0] * 8,
        [1.0, 1.0, 2.0, 1.0, 1.0, 3.0, 1.0, 1.0],
    )
    assert points_of(exact_paths(graph, FAR, BUDGET)) == [(3.0, 3.0)]


def test_times_that_rounding_makes_equal_leave_the_cheaper_one():
    # 0 < 1e-20, but both add up to the same time after the long last arc.
    graph = layered_graph(
        [1, 2, 1, 1], [0, 0, 1, 2, 3], [1, 2, 3, 3, 4], [0.0, 1e-20, 0.0, 0.0, 1.0], [2.0, 1.0, 0.0, 0.0, 0.0]
    )
    assert points_of(exact_paths(graph, FAR, BUDGET)) == [(1.0, 1.0)]


def test_one_arc():
    graph = layered_graph([1, 1], [0], [1], [2.0], [3.0])
    found = exact_paths(graph, 2.0, BUDGET)
    assert points_of(found) == [(2.0, 3.0)]
    assert found.nodes.tolist() == [[0, 1]]


def test_a_limit_below_the_fastest_path_is_infeasible():
    graph = layered_graph([1, 1], [0], [1], [2.0], [3.0])
    with pytest.raises(InfeasibleError, match="fastest path takes 2 s"):
        exact_paths(graph, np.nextafter(2.0, 0.0), BUDGET)


@pytest.mark.parametrize("limit", [0.0, -1.0, np.nan, np.inf])
def test_limits_that_are_none_are_refused(limit):
    with pytest.raises(InputError, match="max_time_s"):
        exact_paths(layered_graph([1, 1], [0], [1], [2.0], [3.0]), limit, BUDGET)


def test_budgets_end_the_search():
    graph = random_graph(np.random.default_rng(0), layers=30, width=30)
    with pytest.raises(BudgetExceededError, match="1,000 labels"):
        exact_paths(graph, FAR, SearchBudget(1_000))
    started = time.perf_counter()
    with pytest.raises(BudgetExceededError, match="time limit ended the search"):
        exact_paths(random_graph(np.random.default_rng(0), layers=150, width=60), FAR, SearchBudget(10**9, 0.3))
    assert time.perf_counter() - started < 0.3 + 0.5 + 1.0  # the graph is built within the last second


def test_memory_stays_below_16_bytes_per_label():
    for segment_m, speeds, least in ((0.04, 40, 20_000), (0.1, 20, 2_000)):
        grid = build_grid(toy_trip(), segment_m, speeds)
        counters = exact_front(grid, 2.0 * fastest_run(grid.trip).duration_s, SearchBudget(50_000_000)).counters
        assert counters["labels"] > least
        assert counters["label_bytes"] <= 16 * counters["labels"]


def test_front_of_a_toy_grid_equals_enumeration():
    grid = build_grid(toy_trip(limits=((0.0, 1.0), (1.2, 0.6)), gradients=((0.0, 0.0), (0.7, -30.0))), 0.5, 6)
    limit = 1.5 * min(time for time, *_ in all_paths(grid.graph))
    found = exact_front(grid, limit, BUDGET)
    assert points_of(found) == brute_front(grid.graph, limit)
    assert len(found) > 10
    assert front_of(points_of(found)) == points_of(found)
