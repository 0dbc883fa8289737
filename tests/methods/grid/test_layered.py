"""The layered graph and its networkx view."""

import networkx
import numpy as np
import pytest

from tests.helpers.grid_case import all_paths, random_graph, toy_trip
from tgvdp.errors import InputError
from tgvdp.methods.grid.grid import build_grid
from tgvdp.methods.grid.layered import layered_graph
from tgvdp.methods.grid.networkx_view import networkx_view
from tgvdp.methods.grid.to_go import fastest_path, least_to_go


def test_arcs_in_any_order_make_the_same_graph():
    graph = layered_graph([1, 2, 1], [2, 0, 1, 0], [3, 2, 3, 1], [1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0])
    assert graph.arc_ptr.tolist() == [0, 2, 3, 4, 4]
    assert graph.arc_to.tolist() == [1, 2, 3, 3]
    assert graph.duration_s.tolist() == [4.0, 2.0, 3.0, 1.0]
    assert graph.layer.tolist() == [0, 1, 1, 2]
    incoming = graph.incoming()
    assert incoming.arc_ptr.tolist() == [0, 0, 1, 2, 4]
    assert incoming.arc_from.tolist() == [0, 0, 1, 2]
    assert incoming.energy_j.tolist() == [8.0, 6.0, 7.0, 5.0]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([2, 1], [0], [2], [1], [1]), "one node"),
        (([1], [], [], [], []), "two or more layers"),
        (([1, 1, 1], [0], [2], [1], [1]), "next layer"),
        (([1, 1], [0], [5], [1], [1]), "nodes 0 .. 1"),
        (([1, 1], [0], [1], [-1], [1]), "duration_s"),
        (([1, 1], [0], [1], [1], [np.nan]), "energy_j"),
        (([1, 1], [0, 0], [1, 1], [1, 1], [1, 1]), "twice"),
    ],
)
def test_wrong_graphs_are_refused(arguments, words):
    with pytest.raises(InputError, match=words):
        layered_graph(*arguments)


@pytest.mark.parametrize("seed", range(5))
def test_networkx_finds_the_same_paths(seed):
    graph = random_graph(np.random.default_rng(seed), layers=5, width=3)
    view = networkx_view(graph)
    names = list(view.nodes)
    ours = {tuple(names[node] for node in nodes) for *_, nodes in all_paths(graph)}
    theirs = {tuple(path) for path in networkx.all_simple_paths(view, names[0], names[-1])}
    assert ours == theirs


@pytest.mark.parametrize("seed", range(20))
def test_cost_to_go_is_networkx_shortest_path(seed):
    graph = random_graph(np.random.default_rng(seed), layers=6, width=4, integer=seed % 2 == 0)
    view = networkx_view(graph).reverse()
    names = list(view.nodes)
    for weight, weights in (("duration_s", (1.0, 0.0)), ("energy_j", (0.0, 1.0))):
        theirs = networkx.single_source_dijkstra_path_length(view, names[-1], weight=weight)
        ours = least_to_go(graph, *weights)
        assert ours == pytest.approx([theirs.get(name, np.inf) for name in names], rel=1e-12)


def test_view_of_a_grid_carries_positions_and_speeds():
    grid = build_grid(toy_trip(), segment_m=0.5, speeds=4)
    view = networkx_view(grid.graph, grid.level, grid.station_m, grid.level_mps)
    assert view.nodes[(0, 0)] == {"position_m": 0.0, "speed_mps": 0.0}
    for (station, level), data in view.nodes.items():
        assert data == {"position_m": grid.station_m[station], "speed_mps": grid.level_mps[level]}
    last = len(grid.station_m) - 1
    shortest_s = networkx.dijkstra_path_length(view, (0, 0), (last, 0), weight="duration_s")
    to_go_s = least_to_go(grid.graph, 1.0, 0.0)
    assert to_go_s[0] == pytest.approx(shortest_s, rel=1e-12)
    assert fastest_path(grid.graph, to_go_s)[0][-1] == pytest.approx(shortest_s, rel=1e-12)
