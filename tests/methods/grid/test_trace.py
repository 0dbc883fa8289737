"""A search written down: it is the search, and what it says of each step adds up to what the kernel counted."""

import math

import networkx
import pytest

import tgvdp
from tgvdp.errors import InputError
from tgvdp.methods.grid.trace import effective_branching

SMALL = {"method": "best-first", "destination_m": 10_000.0, "segment_m": 2500.0, "speeds": 8}


@pytest.fixture(scope="module", params=["ratio", "time", "energy", "weighted"])
def case(request):
    result = tgvdp.search("tgv", "flat-100km", heuristic=request.param, paths=4, **SMALL)
    return result, result.trace()


def test_it_is_the_search(case):
    result, trace = case
    assert trace.complete
    assert trace.duration_s[trace.found].tolist() == result.path_time_s.tolist()
    assert {name: result.counters[name] for name in trace.counters if name != "bytes"} == {
        name: count for name, count in trace.counters.items() if name != "bytes"
    }


def count(trace, *, became=None, reason=None):
    if became is not None:
        return sum(step.became == became for step in trace.steps)
    return sum(why == reason for step in trace.steps for _, why in step.pruned)


def test_steps_add_up_to_the_counters(case):
    _, trace = case
    counters = trace.counters
    assert count(trace, became="expanded") == counters["expanded"]
    assert sum(len(step.children) + len(step.pruned) for step in trace.steps) == counters["generated"]
    assert 1 + sum(len(step.children) for step in trace.steps) == counters["labels"]
    assert sum(step.blocked for step in trace.steps) == counters["pruned_constraint"]
    assert count(trace, reason="delay") == counters["pruned_delay"]
    assert count(trace, reason="bound") + count(trace, became="no better") == counters["pruned_bound"]
    displaced = sum(len(step.displaced) for step in trace.steps)
    assert count(trace, reason="dominance") + displaced == counters["pruned_dominance"]
    assert count(trace, became="near copy") == counters["near_copies"]


def test_what_is_taken_is_what_stood_at_the_head(case):
    _, trace = case
    for before, after in zip(trace.steps, trace.steps[1:], strict=False):
        assert after.label == before.head[0]
        assert before.queued >= len(before.head)
        keys = trace.priority[before.head].tolist()
        assert keys == sorted(keys)


@pytest.mark.parametrize("switches", [{"bounds": False}, {"dominance": False}, {"paths": 0}])
def test_other_rules_add_up_too(switches):
    options = SMALL | {"paths": 3, "speeds": 6, "max_margin": 0.7} | switches
    result = tgvdp.search("tgv", "flat-100km", **options)
    test_steps_add_up_to_the_counters((result, result.trace(100_000)))


def test_a_long_search_is_cut_off_and_says_so():
    trace = tgvdp.search("tgv", "flat-100km", **SMALL).trace(5)
    assert not trace.complete
    assert len(trace.steps) == 5


def test_only_a_search_with_a_queue_has_a_trace():
    with pytest.raises(InputError, match="method front has no queue"):
        tgvdp.search("tgv", "flat-100km", destination_m=3000.0, points=2).trace()


def test_the_tree_in_networkx(case, tmp_path):
    _, trace = case
    tree = trace.to_networkx()
    assert networkx.is_arborescence(tree)
    assert networkx.dag_longest_path_length(tree) <= trace.depth
    (tmp_path / "a.graphml").write_bytes(trace.to_graphml())
    again = networkx.read_graphml(tmp_path / "a.graphml", node_type=int)
    assert dict(again.nodes(data="became")) == dict(tree.nodes(data="became"))
    assert again.graph["effective_branching_factor"] == pytest.approx(trace.branching)


@pytest.mark.parametrize(("branching", "depth"), [(1.0, 7), (2.0, 5), (3.5, 4), (10.0, 1)])
def test_the_effective_branching_factor_of_a_uniform_tree_is_its_own(branching, depth):
    nodes = sum(branching**power for power in range(1, depth + 1))
    assert effective_branching(nodes, depth) == pytest.approx(branching, rel=1e-12)
    assert math.isclose(effective_branching(0, 3), 0.0, abs_tol=1e-12)


def test_the_files_and_the_picture(case, tmp_path):
    result, trace = case
    result.save(tmp_path, certify=False, trace=trace, pictures=("png",))
    assert {"trace.json", "trace.graphml", "trace.png"} <= {file.name for file in tmp_path.iterdir()}
