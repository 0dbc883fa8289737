"""Method ``exact``: all Pareto-optimal (time, energy) paths of a grid, by a layered merge.

A label is a path from the root to a node. Going from station to station, the labels of a node are kept sorted by time,
with strictly decreasing energy. A node's list is the merge of its arcs' streams, each the list of the arc's start
shifted by the arc's costs: a heap of streams gives the candidates by time, and a candidate stays if it is cheaper than
the last one that stayed (and replaces that one if their times are equal). A stream that falls behind gallops to its
next candidate that could stay. Candidates that cannot lead to a new Pareto-optimal path are left out (see
`exact_bounds`), which on grids are nine of ten. Costs are sums from the root forward in float64; rounding is monotone,
so the result is exactly the front of all paths' sums.

The best-first order of BOA* (Hernández Ulloa, Yeoh, Baier, Zhang, Suazo & Koenig, ICAPS 2020) buys nothing on layers.

What is stored: for all labels one int32, the index of the parent in the list of its station, from which the parent's
node follows by the lists' offsets; and float64 time and energy for the labels of two stations at a time. Costs of a
whole path are the sums along it.

Rejected, measured on a line of 30 km, 66 segments × 67 speeds, 21 million labels: a heap of stream numbers with
lookups of time and energy in each comparison (3.6 instead of 14 million labels per second).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import BudgetExceededError
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.methods.grid.exact_bounds import BoundSet, find_bounds
from tgvdp.methods.grid.exact_kernel import BEYOND_BOUND, LOOKED_AT, Labels, make_scratch, merge
from tgvdp.methods.grid.grid import Grid
from tgvdp.methods.grid.layered import Incoming, LayeredGraph
from tgvdp.methods.grid.paths import GraphPaths, GridPaths, grid_paths, require_limit, too_slow
from tgvdp.progress import tell

_FIRST_SPACE = 256
#: Labels that may be stored unless the budget says otherwise; a label takes 4 bytes, and 16 more for two stations.
DEFAULT_LABELS = 80_000_000


def _grown(array: NDArray[Any], size: int) -> NDArray[Any]:
    larger = np.empty(size, dtype=array.dtype)
    larger[: len(array)] = array
    return larger


class _Sweep:
    """The lists of one station after the other, and the parents of all.

    Attributes
    ----------
    labels : Labels
        Lists of the last station that is done.
    parents : list of (count,) int32
        By station, from the second on.
    offsets : list of (n_nodes + 1,) int64
        Offsets of the lists, by station.
    labels_stored, looked_at, beyond_bound : int
        Work done: labels kept, candidates looked at, candidates that the bounds rule out.
    label_bytes : int
        Memory that the labels took at most.
    """

    def __init__(self, graph: LayeredGraph, incoming: Incoming, bounds: BoundSet) -> None:
        self._graph, self._incoming, self._bounds = graph, incoming, bounds
        self._scratch = make_scratch(int(np.max(np.diff(incoming.arc_ptr), initial=1)))
        self._work = np.zeros(2, dtype=np.int64)
        self.labels = Labels(np.array([0, 1]), np.zeros(_FIRST_SPACE), np.zeros(_FIRST_SPACE))
        self._spare = Labels(self.labels.ptr, np.empty(_FIRST_SPACE), np.empty(_FIRST_SPACE))
        self._parent = np.empty(_FIRST_SPACE, dtype=np.int32)
        self.parents: list[NDArray[np.int32]] = []
        self.offsets = [self.labels.ptr]
        self.labels_stored, self.looked_at, self.beyond_bound, self.label_bytes = 1, 0, 0, 0

    def merge_station(self, most_labels: int, clock: Clock) -> bool:
        """Merge the lists of the next station; False when the budget ends first."""
        k = len(self.offsets)
        before, first, end = (int(node) for node in self._graph.layer_ptr[k - 1 : k + 2])
        out = self._spare._replace(ptr=np.zeros(end - first + 1, dtype=np.int64))
        node = first
        while node < end:
            span = (before, first, node, end)
            node, full = merge(
                self.labels, self._incoming, self._bounds, span, self._scratch, out, self._parent, self._work
            )
            self.looked_at += int(self._work[LOOKED_AT])
            self.beyond_bound += int(self._work[BEYOND_BOUND])
            merged = len(out.duration_s) if full else int(out.ptr[node - first])
            if clock.expired or self.labels_stored + merged > most_labels:
                return False
            if full:
                out = self._with_more_room(out)
        self._spare, self.labels = self.labels, out
        count = int(out.ptr[-1])
        self.parents.append(self._parent[:count].copy())
        self.offsets.append(out.ptr)
        self.labels_stored += count
        self._note_memory()
        return True

    def _with_more_room(self, out: Labels) -> Labels:
        """Half as much room again for the lists of a station."""
        size = len(out.duration_s) * 3 // 2
        self._note_memory(out)
        if len(self._parent) < size:
            self._parent = _grown(self._parent, size)
        return Labels(out.ptr, _grown(out.duration_s, size), _grown(out.energy_j, size))

    def _note_memory(self, growing: Labels | None = None) -> None:
        """Keep the largest number of bytes that labels have taken, with the room that is not in use."""
        held = 4 * (self.labels_stored - 1 + len(self._parent)) + 16 * len(self.labels.duration_s)
        held += 16 * len(self._spare.duration_s)
        if growing is not None:  # the array that grows is there twice
            held += 20 * len(growing.duration_s)
        self.label_bytes = max(self.label_bytes, held)

    def fixed_bytes(self) -> int:
        """Memory that depends on the graph and not on the labels: bounds, offsets, scratch, the arcs by their ends."""
        arrays = [*self._incoming, *self._bounds, *self._scratch, *self.offsets]
        return sum(array.nbytes for array in arrays if isinstance(array, np.ndarray))


def exact_paths(graph: LayeredGraph, max_time_s: float, budget: SearchBudget) -> GraphPaths:
    """All Pareto-optimal paths of a layered graph within a time limit.

    Parameters
    ----------
    graph : LayeredGraph
    max_time_s : float
        Longest running time, s.
    budget : SearchBudget

    Returns
    -------
    GraphPaths
        Sorted by time, energy strictly decreasing; one path per point of the front.

    Raises
    ------
    InfeasibleError
        When no path keeps the time limit.
    BudgetExceededError
        When the budget ends first: a layered search has no path to show before its last station.
    """
    require_limit(max_time_s)
    clock = budget.start()
    most_labels = budget.max_labels or DEFAULT_LABELS
    incoming = graph.incoming()
    bounds = find_bounds(graph, incoming, max_time_s, clock)
    sweep = _Sweep(graph, incoming, bounds)
    for k in range(1, graph.n_layers):
        tell("searching", k - 1, graph.n_layers - 1, labels=sweep.labels_stored, generated=sweep.looked_at)
        if not sweep.merge_station(most_labels, clock):
            ended_by = budget.text(full=not clock.expired, most_labels=most_labels)
            raise BudgetExceededError(
                f"exact: {ended_by} ended the search at station {k} of {graph.n_layers - 1}; use fewer speeds, longer "
                "segments, less delay or a larger budget"
            )
    labels = sweep.labels
    if labels.ptr[-1] == 0:
        raise too_slow(float(bounds.to_go_s[0]), max_time_s)
    nodes = np.empty((int(labels.ptr[-1]), graph.n_layers), dtype=np.int32)
    nodes[:, -1] = graph.n_nodes - 1
    index: NDArray[np.integer] = np.arange(len(nodes))
    for k in range(graph.n_layers - 2, -1, -1):
        index = sweep.parents[k][index]
        nodes[:, k] = graph.layer_ptr[k] + np.searchsorted(sweep.offsets[k], index, side="right") - 1
    counters = {
        "labels": sweep.labels_stored,
        "generated": sweep.looked_at,
        "pruned_bound": sweep.beyond_bound,
        "pruned_dominance": sweep.looked_at - sweep.beyond_bound - sweep.labels_stored + 1,
        "label_bytes": sweep.label_bytes,
        "bytes": sweep.label_bytes + sweep.fixed_bytes(),
        "terminals": len(nodes),
    }
    front = slice(len(nodes))
    return GraphPaths(labels.duration_s[front].copy(), labels.energy_j[front].copy(), nodes, True, counters)


def exact_front(grid: Grid, max_time_s: float, budget: SearchBudget) -> GridPaths:
    """All Pareto-optimal paths of a grid within a time limit; see `exact_paths`."""
    return grid_paths(grid, exact_paths(grid.graph, max_time_s, budget))
