"""Method ``best-first``: search with a priority queue of partial paths, made to end.

A label is a partial path. The search takes the label with the best priority from a heap, and adds one child for each
arc of the grid that leaves its node. With ``bounds``, priorities and pruning use the least time and least energy from
the node to the terminal. Heuristics, smaller is better, of a label with time t and energy E at a node with least time
to go T', least energy to go E' (both 0 without bounds):

    time      t + T'
    energy    E + E'
    weighted  E + λ·t + least (energy + λ·time) to go
    ratio     delay / energy saved = (t + T' - T_ref) / (E_ref - E - E'), relative to the fastest run; without bounds,
              relative to the fastest run's time and energy at the label's station

Pruned are: children later than the time limit (`pruned_delay`); with ``bounds``, labels whose ideal end (t + T',
E + E') is no better than a path found (`pruned_bound`); with ``dominance``, children no better than another label of
their node, and labels that a better child displaces (`pruned_dominance`). Arcs that break a constraint are left out of
the grid and counted (`pruned_constraint`). A label at the terminal is a path when it is taken from the heap.

Found paths form a Pareto front: a path no better than one found is dropped, and displaces those that it beats. When n
paths are asked for, near-copies do not count: a path must differ from each one found by more than 1/(2n) of the range
of time (fastest path to time limit) or of energy (fastest path to thriftiest). Along a front, which has at least one
of the two ranges as its extent, n paths of that distance still fit. With ``paths`` 0 there is no such rule: with
bounds and dominance the search is then exact.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import BudgetExceededError
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.grid.best_first_kernel import (
    BUCKETS,
    BY_BOUND,
    BY_CONSTRAINT,
    BY_DELAY,
    BY_DOMINANCE,
    CHUNK_DONE,
    COPIES,
    EXPANDED,
    FOUND,
    FULL,
    GENERATED,
    LABELS,
    QUEUED,
    Lists,
    Pool,
    run_chunk,
)
from tgvdp.methods.grid.best_first_rules import Options, counted_j, rules_of
from tgvdp.methods.grid.grid import Grid
from tgvdp.methods.grid.layered import LayeredGraph
from tgvdp.methods.grid.paths import GraphPaths, GridPaths, grid_paths, require_limit, too_slow
from tgvdp.methods.grid.to_go import least_to_go
from tgvdp.progress import tell

#: Grid on which every heuristic ends within seconds; that of the exact method takes `ratio` minutes.
DEFAULT_SEGMENTS = 20
DEFAULT_SPEEDS = 20

#: Labels that may be stored unless the budget says otherwise; a label takes 44 bytes.
DEFAULT_LABELS = 5_000_000
_FIRST_SPACE = 1 << 14
#: Steps along arcs and lists in one kernel call, about a tenth of a second.
_CHUNK = 400_000

_COUNTERS = {
    "expanded": EXPANDED,
    "generated": GENERATED,
    "pruned_constraint": BY_CONSTRAINT,
    "pruned_delay": BY_DELAY,
    "pruned_bound": BY_BOUND,
    "pruned_dominance": BY_DOMINANCE,
    "near_copies": COPIES,
    "labels": LABELS,
}


def _pool(size: int, old: Pool | None = None) -> Pool:
    """Columns of a size, with the contents of an old, smaller pool."""
    floats = ("duration_s", "energy_j", "heap_key")
    columns: list[NDArray[Any]] = []
    for name in Pool._fields:
        column = np.full(size, -1, dtype=np.float64 if name in floats else np.int32)
        if old is not None:
            column[: len(old.node)] = getattr(old, name)
        columns.append(column)
    return Pool(*columns)


class Search:
    """A search that goes on step by step.

    Parameters
    ----------
    graph : LayeredGraph
    max_time_s : float
        Longest running time, s.
    options : Options
    blocked : (n_nodes,) int32, optional
        As of `best_first_paths`.
    space : int
        Labels that there is room for at first.

    Raises
    ------
    InfeasibleError
        When no path keeps the time limit.
    """

    def __init__(
        self, graph: LayeredGraph, max_time_s: float, options: Options, blocked: NDArray[np.int32] | None, space: int
    ) -> None:
        require_limit(max_time_s)
        if blocked is None:
            blocked = np.zeros(graph.n_nodes, dtype=np.int32)
        self.graph, self.rules = graph, rules_of(graph, blocked, max_time_s, options)
        self.pool = _pool(space)
        root = (self.pool.node, self.pool.duration_s, self.pool.energy_j, self.pool.heap_key, self.pool.heap)
        for column in root:
            column[0] = 0
        self.lists = Lists(np.full(graph.n_nodes, -1, np.int32), np.full((graph.n_nodes, BUCKETS), -1, np.int32))
        self.state = np.zeros(11, dtype=np.int64)
        self.state[LABELS] = self.state[QUEUED] = 1
        self._most_children = int(np.max(np.diff(graph.arc_ptr)))

    @property
    def space(self) -> int:
        """Labels that there is room for."""
        return len(self.pool.node)

    def grow(self, most: int) -> None:
        """Make room for twice as many labels, at most for so many."""
        self.pool = _pool(min(most, 2 * self.space), self.pool)

    def go_on(self, chunk: int) -> int:
        """Search until so many steps are done, or for another reason; see `run_chunk`."""
        return int(run_chunk(self.graph, self.rules, self.pool, self.state, self.lists, self._most_children, chunk))

    def counters(self) -> dict[str, int]:
        """Work done until now, by kind."""
        counters = {name: int(self.state[entry]) for name, entry in _COUNTERS.items()}
        counters["bytes"] = sum(column.nbytes for column in (*self.pool, *self.lists))
        counters["terminals"] = int(self.state[FOUND])
        return counters


def best_first_paths(
    graph: LayeredGraph,
    max_time_s: float,
    budget: SearchBudget,
    options: Options,
    blocked: NDArray[np.int32] | None = None,
) -> GraphPaths:
    """Search a layered graph best first.

    Parameters
    ----------
    graph : LayeredGraph
    max_time_s : float
        Longest running time, s.
    budget : SearchBudget
    options : Options
    blocked : (n_nodes,) int32, optional
        Arcs from each node that the graph lacks because they break a constraint, to be counted.

    Returns
    -------
    GraphPaths
        Paths found, a Pareto front sorted by time; ``complete`` is False when the budget ended first.

    Raises
    ------
    InfeasibleError
        When no path keeps the time limit.
    BudgetExceededError
        When the budget ends before the first path.
    """
    clock = budget.start()
    most_labels = budget.max_labels or DEFAULT_LABELS
    search = Search(graph, max_time_s, options, blocked, min(most_labels, _FIRST_SPACE))
    status = CHUNK_DONE
    while status == CHUNK_DONE and not clock.expired:
        status = search.go_on(_CHUNK)
        if status == FULL and search.space < most_labels:
            search.grow(most_labels)
            status = CHUNK_DONE
        counters = search.counters()
        tell("searching", counters["terminals"], options.paths or None, **counters)
    complete = status not in (FULL, CHUNK_DONE)
    ended_by = "" if complete else budget.text(full=status == FULL, most_labels=most_labels)
    counters = search.counters()
    if counters["terminals"] == 0:
        if complete:
            raise too_slow(float(least_to_go(graph, 1.0, 0.0)[0]), max_time_s)
        raise _nothing_found(options, ended_by, counters)
    pool = search.pool
    found = pool.found[: counters["terminals"]].astype(np.int64)
    nodes = np.empty((len(found), graph.n_layers), dtype=np.int32)
    label = found
    for k in range(graph.n_layers - 1, -1, -1):
        nodes[:, k] = pool.node[label]
        label = pool.parent[label].astype(np.int64)
    return GraphPaths(pool.duration_s[found], pool.energy_j[found], nodes, complete, counters, ended_by)


def _nothing_found(options: Options, ended_by: str, counters: dict[str, int]) -> BudgetExceededError:
    lacking = [name for name in ("bounds", "dominance") if not getattr(options, name)]
    advice = f"switch on {' and '.join(lacking)}" if lacking else "use fewer speeds, longer segments or a larger budget"
    return BudgetExceededError(
        f"best-first: {ended_by} ended the search "
        f"before the first path was found ({counters['labels']:,} labels, {counters['expanded']:,} expanded); {advice}"
    )


def best_first(
    grid: Grid,
    max_time_s: float,
    budget: SearchBudget,
    heuristic: str = "ratio",
    paths: int | None = None,
    dominance: bool = True,
    bounds: bool = True,
    weight: float | None = None,
    reference_time_s: float | None = None,
    reference_energy_j: float | None = None,
) -> GridPaths:
    """Search a grid best first; see `Options` and `best_first_paths`. The reference energy is that of a real run."""
    if reference_energy_j is not None:
        reference_energy_j = counted_j(grid, reference_energy_j)
    options = Options(
        heuristic=heuristic,
        paths=paths,
        dominance=dominance,
        bounds=bounds,
        weight=weight,
        reference_time_s=reference_time_s,
        reference_energy_j=reference_energy_j,
    )
    return grid_paths(grid, best_first_paths(grid.graph, max_time_s, budget, options, grid.blocked))
