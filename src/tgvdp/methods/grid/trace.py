"""A best-first search written down label by label: what was expanded, what was pruned and why, what waited.

The search itself runs, by its own kernel, one label at a time; what happens in between is read off its columns. Only
why an arc brought no label is found by asking the same questions once more, and the counters of the kernel say whether
the answers are right.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.grid.best_first import Search
from tgvdp.methods.grid.best_first_kernel import CHUNK_DONE, COPIES, EXPANDED, FOUND, FULL, LABELS, QUEUED
from tgvdp.methods.grid.best_first_rules import Options
from tgvdp.methods.grid.grid import Grid
from tgvdp.methods.grid.to_go import ROUNDING

#: What becomes of a label that is taken from the queue.
EXPANDED_LABEL, PATH, NEAR_COPY, NO_BETTER, DISPLACED = "expanded", "path", "near copy", "no better", "displaced"
#: Why an arc brings no label.
BY_DELAY, BY_BOUND, BY_DOMINANCE = "delay", "bound", "dominance"
#: Labels at the head of the queue that are written down.
_SHOWN_QUEUE = 8
#: Steps unless the caller says otherwise: more cannot be watched.
MOST_STEPS = 2000
_SPACE = 1 << 12


class Step(NamedTuple):
    """One label taken from the queue.

    Attributes
    ----------
    label : int
    became : str
        "expanded", "path", "near copy" (of a path found), "no better" (than a path found) or "displaced" (by a better
        label before).
    children : list of int
        New labels.
    pruned : list of (node, reason)
        Ends of arcs that brought none, and why: "delay", "bound" or "dominance".
    displaced : list of int
        Labels that the new ones displaced.
    blocked : int
        Arcs that the grid lacks because they break a constraint.
    queued : int
        Labels that wait afterwards, displaced ones among them.
    head : list of int
        The first of these, the best one first.
    """

    label: int
    became: str
    children: list[int]
    pruned: list[tuple[int, str]]
    displaced: list[int]
    blocked: int
    queued: int
    head: list[int]


@dataclass(frozen=True, eq=False)
class Trace:
    """A search, written down.

    Attributes
    ----------
    grid : Grid
    node, parent : (n,) int32
        Of each label: the node where it ends, and the label before it; -1 for the root.
    duration_s, energy_j, priority : (n,) float64
        Of each label, since the root; its priority in the queue, smaller first.
    steps : list of Step
    found : list of int
        Labels of the paths found, by time.
    counters : dict of str to int
        Of the search.
    complete : bool
        False where it had more steps than are written down.
    """

    grid: Grid
    node: NDArray[np.int32]
    parent: NDArray[np.int32]
    duration_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]
    priority: NDArray[np.float64]
    steps: list[Step]
    found: list[int]
    counters: dict[str, int]
    complete: bool

    @property
    def depth(self) -> int:
        """Arcs of a path."""
        return self.grid.graph.n_layers - 1

    @property
    def branching(self) -> float:
        """Effective branching factor; see `effective_branching`."""
        return effective_branching(self.counters["generated"], self.depth)

    def path(self, label: int) -> list[int]:
        """Labels from the root to one."""
        path = [label]
        while self.parent[path[-1]] >= 0:
            path.append(int(self.parent[path[-1]]))
        return path[::-1]

    def to_object(self) -> dict[str, Any]:
        """Build the object that trace.json holds and the page draws; docs/grid-search.md says what it holds."""
        layer = self.grid.graph.layer
        priority = [value if np.isfinite(value) else None for value in self.priority.tolist()]
        return {
            "schema": "tgvdp.trace/1",
            "nodes": {
                "position_m": self.grid.station_m[layer].tolist(),
                "speed_mps": self.grid.level_mps[self.grid.level].tolist(),
            },
            "labels": {
                "node": self.node.tolist(), "parent": self.parent.tolist(), "duration_s": self.duration_s.tolist(),
                "energy_j": self.energy_j.tolist(), "priority": priority,
            },
            "steps": [step._asdict() for step in self.steps],
            "found": self.found,
            "counters": self.counters,
            "depth": self.depth,
            "effective_branching_factor": self.branching,
            "complete": self.complete,
        }  # fmt: skip

    def to_networkx(self) -> Any:
        """Copy the tree of labels into networkx; see `tgvdp.methods.grid.networkx_view.search_tree`."""
        from tgvdp.methods.grid.networkx_view import search_tree

        return search_tree(self)

    def to_graphml(self) -> bytes:
        """The same as GraphML, which most programs that draw graphs read."""
        from tgvdp.methods.grid.networkx_view import graphml

        return graphml(self.to_networkx())


def effective_branching(generated: int, depth: int) -> float:
    """Branching factor b of a uniform tree of a depth with as many nodes: N + 1 = 1 + b + b² + … + b^depth.

    Parameters
    ----------
    generated : int
        Nodes generated, N.
    depth : int
        Of the solution, at least 1.

    Notes
    -----
    Russell & Norvig, Artificial Intelligence: A Modern Approach, section on heuristic functions.
    """
    low, high = 0.0, max(1.0, float(generated))
    for _ in range(100):  # halvings of a float64
        middle = 0.5 * (low + high)
        terms = sum(middle**power for power in range(1, depth + 1))
        low, high = (middle, high) if terms < generated else (low, middle)
    return 0.5 * (low + high)


def trace_best_first(grid: Grid, max_time_s: float, options: Options, most_steps: int = MOST_STEPS) -> Trace:
    """Search a grid best first, and write down each step.

    Parameters
    ----------
    grid : Grid
    max_time_s : float
        Longest running time, s.
    options : Options
    most_steps : int
        The trace ends there.

    Raises
    ------
    InfeasibleError
        When no path keeps the time limit.
    """
    search = Search(grid.graph, max_time_s, options, grid.blocked, _SPACE)
    priority = [float(search.pool.heap_key[0])]
    steps: list[Step] = []
    status = CHUNK_DONE
    while status == CHUNK_DONE and len(steps) < most_steps and search.state[QUEUED] > 0:
        before = _Before(search)
        status = search.go_on(1)
        if status == FULL:
            search.grow(2 * search.space)
            status = CHUNK_DONE
            continue
        steps.append(_step(search, before))
        keys = dict(zip(search.pool.heap.tolist(), search.pool.heap_key.tolist(), strict=True))
        priority += [keys[label] for label in range(len(priority), int(search.state[LABELS]))]
    pool, count = search.pool, int(search.state[LABELS])
    return Trace(
        grid, pool.node[:count].copy(), pool.parent[:count].copy(), pool.duration_s[:count].copy(),
        pool.energy_j[:count].copy(), np.array(priority), steps, pool.found[: int(search.state[FOUND])].tolist(),
        search.counters(), status != CHUNK_DONE or search.state[QUEUED] == 0,
    )  # fmt: skip


class _Before:
    """What a search looks like before a step."""

    def __init__(self, search: Search) -> None:
        pool, state = search.pool, search.state
        self.label = int(pool.heap[0])
        self.was_displaced = bool(pool.next[self.label] == -2)
        self.labels = int(state[LABELS])
        self.displaced = set(np.flatnonzero(pool.next[: self.labels] == -2).tolist())
        self.counts = {entry: int(state[entry]) for entry in (EXPANDED, COPIES)}
        found = pool.found[: int(state[FOUND])]
        self.found = list(zip(pool.duration_s[found].tolist(), pool.energy_j[found].tolist(), strict=True))


def _step(search: Search, before: _Before) -> Step:
    pool, state, label = search.pool, search.state, before.label
    children = list(range(before.labels, int(state[LABELS])))
    displaced = sorted(set(np.flatnonzero(pool.next[: int(state[LABELS])] == -2).tolist()) - before.displaced)
    queued = int(state[QUEUED])
    heap = sorted(zip(pool.heap_key[:queued].tolist(), (-pool.heap[:queued]).tolist(), strict=True))
    head = [-number for _, number in heap[:_SHOWN_QUEUE]]
    if state[EXPANDED] > before.counts[EXPANDED]:
        pruned = _pruned(search, before, [int(pool.node[child]) for child in children])
        blocked = int(search.rules.blocked[pool.node[label]])
        return Step(label, EXPANDED_LABEL, children, pruned, displaced, blocked, queued, head)
    if before.was_displaced:
        became = DISPLACED
    elif state[COPIES] > before.counts[COPIES]:
        became = NEAR_COPY
    else:
        became = PATH if label in pool.found[: int(state[FOUND])] else NO_BETTER
    return Step(label, became, [], [], displaced, 0, queued, head)


def _pruned(search: Search, before: _Before, new_nodes: list[int]) -> list[tuple[int, str]]:
    """Ends of the arcs that brought no label, and why; labels are made in the order of their arcs."""
    graph, rules, pool, label = search.graph, search.rules, search.pool, before.label
    node, waiting, pruned = int(pool.node[label]), new_nodes[::-1], []
    for arc in range(int(graph.arc_ptr[node]), int(graph.arc_ptr[node + 1])):
        child = int(graph.arc_to[arc])
        if waiting and waiting[-1] == child:
            waiting.pop()
            continue
        time_s = pool.duration_s[label] + graph.duration_s[arc]
        ideal_s = (time_s + rules.to_go_s[child]) * (1.0 - ROUNDING)
        ideal_j = (pool.energy_j[label] + graph.energy_j[arc] + rules.to_go_j[child]) * (1.0 - ROUNDING)
        if ideal_s > rules.max_time_s or (child == graph.n_nodes - 1 and time_s > rules.max_time_s):
            pruned.append((child, BY_DELAY))
        elif rules.bounds and any(known_s <= ideal_s and known_j <= ideal_j for known_s, known_j in before.found):
            pruned.append((child, BY_BOUND))
        else:
            pruned.append((child, BY_DOMINANCE))
    return pruned
