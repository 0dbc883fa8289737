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

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tgvdp.constants import HEURISTICS
from tgvdp.errors import BudgetExceededError, InputError
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
    Rules,
    run_chunk,
)
from tgvdp.methods.grid.grid import Grid
from tgvdp.methods.grid.layered import LayeredGraph
from tgvdp.methods.grid.paths import GraphPaths, GridPaths, grid_paths, require_limit, too_slow
from tgvdp.methods.grid.to_go import ROUNDING, fastest_path, least_to_go
from tgvdp.model.checks import require_number

#: Grid on which every heuristic ends within seconds; that of the exact method takes `ratio` minutes.
DEFAULT_SEGMENTS = 20
DEFAULT_SPEEDS = 20

#: Labels that may be stored unless the budget says otherwise; a label takes 44 bytes.
DEFAULT_LABELS = 5_000_000
_FIRST_SPACE = 1 << 14

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


@dataclass(frozen=True, kw_only=True)
class Options:
    """Frozen options of the best-first search, checked when they are made.

    Parameters
    ----------
    heuristic : {"ratio", "time", "energy", "weighted"}
        Priority of a label.
    paths : int or None
        Stop after this many different paths; None or 0: all.
    dominance, bounds : bool
        Pruning rules.
    weight : float, optional
        λ of ``weighted``, the price of time, J/s; default: energy range over time range of the problem.
    reference_time_s, reference_energy_j : float, optional
        Reference run of ``ratio``, s and J; default: the fastest path of the graph.

    Raises
    ------
    InputError
        When an option is unknown, out of range, or without effect on the heuristic.
    """

    heuristic: str = "ratio"
    paths: int | None = None
    dominance: bool = True
    bounds: bool = True
    weight: float | None = None
    reference_time_s: float | None = None
    reference_energy_j: float | None = None

    def __post_init__(self) -> None:
        if self.heuristic not in HEURISTICS:
            raise InputError(f"best-first: heuristic must be one of {', '.join(HEURISTICS)}, got {self.heuristic!r}")
        paths = 0 if self.paths is None else self.paths
        if isinstance(paths, bool) or not isinstance(paths, int) or paths < 0:
            raise InputError(f"best-first: paths must be a whole number, at least 0, got {self.paths!r}")
        if self.weight is not None:
            require_number("best-first", "weight", self.weight, "J/s", at_least=0.0)
            if self.heuristic != "weighted":
                raise InputError(f"best-first: weight belongs to heuristic 'weighted', got {self.heuristic!r}")
        for name, unit in (("reference_time_s", "s"), ("reference_energy_j", "J")):
            value = getattr(self, name)
            if value is not None:
                require_number("best-first", name, value, unit, at_least=0.0)


def _rules(graph: LayeredGraph, blocked: NDArray[np.int32], max_time_s: float, options: Options) -> Rules:
    """Work out bounds, reference and ranges."""
    time_s = least_to_go(graph, 1.0, 0.0)
    energy_j = least_to_go(graph, 0.0, 1.0)
    if not np.isfinite(time_s[0]) or time_s[0] * (1.0 - ROUNDING) > max_time_s:
        raise too_slow(float(time_s[0]), max_time_s)
    fastest_s, fastest_j = fastest_path(graph, time_s)
    range_s = max(0.0, max_time_s - float(fastest_s[-1]))
    range_j = max(0.0, float(fastest_j[-1] - energy_j[0]))
    none = np.zeros(graph.n_nodes)
    to_go_s, to_go_j = (time_s, energy_j) if options.bounds else (none, none)
    time_weight, energy_weight = 1.0, 1.0
    base_s, base_j = none, none
    if options.heuristic == "ratio":
        end_s = float(fastest_s[-1]) if options.reference_time_s is None else options.reference_time_s
        end_j = float(fastest_j[-1]) if options.reference_energy_j is None else options.reference_energy_j
        if options.bounds:
            base_s, base_j = end_s - time_s, end_j - energy_j
        else:
            base_s = _ending_at(fastest_s, end_s)[graph.layer]
            base_j = _ending_at(fastest_j, end_j)[graph.layer]
    else:
        if options.heuristic == "energy":
            time_weight = 0.0
        elif options.weight is not None:
            time_weight = options.weight
        elif options.heuristic == "weighted" and range_s > 0.0:
            time_weight = range_j / range_s
        energy_weight = 0.0 if options.heuristic == "time" else 1.0
        if options.bounds:
            base_s = least_to_go(graph, time_weight, energy_weight)
    most = options.paths or 0
    share = 0.5 / max(1, most)
    return Rules(
        options.heuristic == "ratio", time_weight, energy_weight, base_s, base_j, to_go_s, to_go_j, options.bounds,
        options.dominance, max_time_s, most, share * range_s, share * range_j, blocked,
        time_s, BUCKETS / range_s if range_s > 0.0 else 0.0,
    )  # fmt: skip


def _ending_at(course: NDArray[np.float64], end: float) -> NDArray[np.float64]:
    """Stretch a course from 0 so that it ends at a value."""
    return course * (end / course[-1]) if course[-1] > 0.0 else course


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
    require_limit(max_time_s)
    clock = budget.start()
    if blocked is None:
        blocked = np.zeros(graph.n_nodes, dtype=np.int32)
    rules = _rules(graph, blocked, max_time_s, options)
    most_labels = budget.max_labels or DEFAULT_LABELS
    most_children = int(np.max(np.diff(graph.arc_ptr)))
    pool = _pool(min(most_labels, _FIRST_SPACE))
    pool.node[0] = pool.duration_s[0] = pool.energy_j[0] = pool.heap_key[0] = pool.heap[0] = 0
    lists = Lists(np.full(graph.n_nodes, -1, np.int32), np.full((graph.n_nodes, BUCKETS), -1, np.int32))
    state = np.zeros(11, dtype=np.int64)
    state[LABELS] = state[QUEUED] = 1
    status = CHUNK_DONE
    while status == CHUNK_DONE and not clock.expired:
        status = run_chunk(graph, rules, pool, state, lists, most_children)
        if status == FULL and len(pool.node) < most_labels:
            pool = _pool(min(most_labels, 2 * len(pool.node)), pool)
            status = CHUNK_DONE
    complete = status not in (FULL, CHUNK_DONE)
    ended_by = "" if complete else budget.text(full=status == FULL, most_labels=most_labels)
    counters = {name: int(state[entry]) for name, entry in _COUNTERS.items()}
    counters["bytes"] = sum(column.nbytes for column in (*pool, *lists))
    counters["terminals"] = int(state[FOUND])
    if counters["terminals"] == 0:
        if complete:
            raise too_slow(float(least_to_go(graph, 1.0, 0.0)[0]), max_time_s)
        raise _nothing_found(options, ended_by, counters)
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
    if reference_energy_j is not None:  # the grid's least energies are below that of any run, but for its coarseness
        reference_energy_j = max(reference_energy_j - float(grid.floor_j.sum()), 0.0)
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
