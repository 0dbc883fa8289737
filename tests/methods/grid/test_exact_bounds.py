"""Bounds of the exact search: never wrong, by enumeration, and worth their while."""

import itertools

import numpy as np
import pytest

from tests.helpers.grid_case import FAR, all_paths, brute_front, random_graph
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.grid.exact import exact_paths
from tgvdp.methods.grid.exact_bounds import CELLS, find_bounds
from tgvdp.methods.grid.exact_ceiling import cell_of, fill_ceiling
from tgvdp.methods.grid.paths import path_costs

BUDGET = SearchBudget(1_000_000, 30.0)
NO_MATTER = 1e-9


def case(seed, layers=5, width=4):
    """A graph, a limit in the middle of its running times, and its bounds."""
    rng = np.random.default_rng(seed)
    graph = random_graph(rng, layers, width, integer=seed % 3 == 0)
    times = sorted({time for time, *_ in all_paths(graph)})
    limit = max(times[int(rng.integers(len(times) // 4, len(times)))], 1e-3)
    return graph, limit, find_bounds(graph, graph.incoming(), limit, BUDGET.start())


def ceiling_of(bounds, node):
    """Z by cell; minus infinity where nothing is promising."""
    ceiling_j = np.full(CELLS, np.inf)
    if not fill_ceiling(bounds, node, np.empty(CELLS), np.zeros(CELLS, dtype=np.int32), ceiling_j):
        ceiling_j[:] = -np.inf
    return ceiling_j


@pytest.mark.parametrize("seed", range(40))
def test_bounds_hold_for_every_path(seed):
    graph, _, bounds = case(seed)
    begin_s = bounds.arrivals.begin_s + bounds.arrivals.cell_s * np.arange(CELLS)
    paths = all_paths(graph)
    for cell in np.flatnonzero(np.isfinite(bounds.known_j)):
        assert bounds.known_j[cell] >= min(energy for time, energy, _ in paths if time <= begin_s[cell])
    for time, energy, nodes in paths:
        course_s, course_j = path_costs(graph, np.array(nodes))
        for node, passed_s, passed_j in zip(nodes, course_s, course_j, strict=True):
            rest = energy - passed_j + bounds.multiplier_j_per_s * (time - passed_s)
            assert np.all(bounds.least_cost_j[:, node] <= rest + NO_MATTER)
            assert np.all(bounds.through_cost_j[:, node] <= energy + bounds.multiplier_j_per_s * time + NO_MATTER)
            assert bounds.earliest_s[node] <= passed_s + NO_MATTER
            assert bounds.to_go_s[node] <= time - passed_s + NO_MATTER


@pytest.mark.parametrize("seed", range(40))
def test_no_label_of_a_pareto_optimal_path_is_cut_off(seed):
    graph, limit, bounds = case(seed)
    front = set(brute_front(graph, limit))
    for time, energy, nodes in all_paths(graph):
        if (time, energy) in front:
            course_s, course_j = path_costs(graph, np.array(nodes))
            for node, passed_s, passed_j in zip(nodes[1:], course_s[1:], course_j[1:], strict=True):
                assert passed_j < ceiling_of(bounds, node)[cell_of(bounds, node, passed_s)]
                assert passed_s <= bounds.latest_s[node]


@pytest.mark.parametrize("seed", range(12))
def test_the_ceiling_equals_its_definition(seed):
    """Z = max of U - H over the arrivals from the first to the last at which a path through the node is promising."""
    _, _, bounds = case(seed, layers=6)
    multiplier, end_s = bounds.multiplier_j_per_s[:, None], bounds.arrivals.cell_s * np.arange(1, CELLS + 1)
    compared = 0
    for node in np.flatnonzero(np.isfinite(bounds.to_go_s + bounds.earliest_s)[:-1]):
        through_j = np.max(
            bounds.through_cost_j[:, node, None] - multiplier * (bounds.arrivals.begin_s + end_s), axis=0
        )
        hull_j = np.max(bounds.least_cost_j[:, node, None] - multiplier * (bounds.to_go_s[node] + end_s), axis=0)
        first = cell_of(bounds, node, bounds.earliest_s[node])
        promising = first + np.flatnonzero(through_j[first:] < bounds.known_j[first:])
        found = ceiling_of(bounds, node)
        for cell in range(first, CELLS, 3):
            arrivals = np.arange(max(cell, promising[0]), promising[-1] + 1) if len(promising) else np.arange(0)
            expected = np.max(bounds.known_j[arrivals] - hull_j[arrivals - cell], initial=-np.inf)
            assert found[cell] == pytest.approx(expected, rel=1e-9, abs=1e-9)
            compared += np.isfinite(expected)
    assert compared > 0 or seed % 3 == 0  # of whole costs a few graphs have one point


def test_an_empty_range_of_times_bounds_no_energy():
    graph = random_graph(np.random.default_rng(4), layers=5, width=4)
    fastest_s = min(time for time, *_ in all_paths(graph))
    found = exact_paths(graph, fastest_s, BUDGET)
    assert len(found.duration_s) == 1
    assert (found.duration_s[0], found.energy_j[0]) == brute_front(graph, fastest_s)[0]


def test_bounds_leave_a_fraction_of_the_labels():
    graph = random_graph(np.random.default_rng(1), layers=15, width=15)
    loose = exact_paths(graph, FAR, BUDGET)
    tight = exact_paths(graph, float(loose.duration_s[-1]), BUDGET)
    for name in ("duration_s", "energy_j"):
        assert np.array_equal(getattr(tight, name), getattr(loose, name))
    assert tight.counters["labels"] < 0.5 * loose.counters["labels"]
    counters = tight.counters
    ruled_out = counters["pruned_bound"] + counters["pruned_dominance"]
    assert counters["generated"] == counters["labels"] - 1 + ruled_out


@pytest.mark.parametrize("scale", [*itertools.product((1e-12, 1.0, 1e12), (1e-9, 1e9))])
def test_units_do_not_matter(scale):
    graph = random_graph(np.random.default_rng(2), layers=10, width=8)
    limit = float(exact_paths(graph, FAR, BUDGET).duration_s[-1])
    plain = exact_paths(graph, limit, BUDGET)
    scaled = graph._replace(duration_s=graph.duration_s * scale[0], energy_j=graph.energy_j * scale[1])
    other = exact_paths(scaled, limit * scale[0] * (1.0 + 1e-14), BUDGET)
    assert np.allclose(other.duration_s, plain.duration_s * scale[0], rtol=1e-12)
    assert other.counters["labels"] == pytest.approx(plain.counters["labels"], rel=0.01)
