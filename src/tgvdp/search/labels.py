"""Method ``exact``: all Pareto-optimal (time, energy) paths of a grid, by a layered merge.

A label is a path from the root to a node. Going from station to station, the labels of a node are kept sorted by time,
with strictly decreasing energy. A node's list is the merge of its arcs' streams, each the list of the arc's start
shifted by the arc's costs: a heap of streams gives the candidates by time, and a candidate stays if it is cheaper than
the last one that stayed (and replaces that one if their times are equal). A stream that falls behind gallops to its
next candidate that could stay. Costs are sums from the root forward in float64; rounding is monotone, so the result is
exactly the front of all paths' sums. Labels whose time plus least time to go passes the limit are dropped.

The best-first order of BOA* (Hernández Ulloa, Yeoh, Baier, Zhang, Suazo & Koenig, ICAPS 2020) buys nothing on layers.

What is stored: for all labels one int32, the index of the parent in the list of its station, from which the parent's
node follows by the lists' offsets; and float64 time and energy for the labels of two stations at a time. Costs of a
whole path are the sums along it.

Rejected, measured on a line of 30 km, 66 segments × 67 speeds, 21 million labels: a heap of stream numbers with
lookups of time and energy in each comparison (3.6 instead of 14 million labels per second).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.errors import BudgetExceededError
from tgvdp.graph.layered import Incoming, LayeredGraph
from tgvdp.search.budget import Clock, SearchBudget
from tgvdp.search.grid import Grid
from tgvdp.search.paths import GraphPaths, GridPaths, grid_paths, require_limit, too_slow
from tgvdp.search.to_go import ROUNDING, least_to_go

#: Candidates looked at in one kernel call, about a tenth of a second.
_CHUNK = 1_000_000
_FIRST_SPACE = 1 << 16
#: Labels that may be stored unless the budget says otherwise; a label takes 4 bytes, and 16 more for two stations.
DEFAULT_LABELS = 80_000_000


class Labels(NamedTuple):
    """Labels of one station: those of its node j are ``ptr[j] .. ptr[j + 1] - 1``, sorted by time."""

    ptr: NDArray[np.int64]
    duration_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]


class Streams(NamedTuple):
    """Scratch of the merge, one entry per stream, and a binary heap of the streams by time of their candidates."""

    energy_j: NDArray[np.float64]
    position: NDArray[np.int64]
    end: NDArray[np.int64]
    arc: NDArray[np.int64]
    heap_s: NDArray[np.float64]
    heap: NDArray[np.int32]


@leaf
def _sift_down(heap_s, heap, size, slot, key_s, stream):
    """Put a stream with this key at or below a slot."""
    child = 2 * slot + 1
    while child + 1 < size:
        child += heap_s[child + 1] < heap_s[child]
        if heap_s[child] >= key_s:
            break
        heap_s[slot] = heap_s[child]
        heap[slot] = heap[child]
        slot = child
        child = 2 * slot + 1
    if child + 1 == size and heap_s[child] < key_s:
        heap_s[slot] = heap_s[child]
        heap[slot] = heap[child]
        slot = child
    heap_s[slot] = key_s
    heap[slot] = stream


@leaf
def _open_streams(labels, incoming, first_node, node, streams):
    """Start one stream per arc into the node that has labels; return their number."""
    size = 0
    for a in range(incoming.arc_ptr[node], incoming.arc_ptr[node + 1]):
        source = incoming.arc_from[a] - first_node
        start = labels.ptr[source]
        if start < labels.ptr[source + 1]:
            streams.energy_j[size] = labels.energy_j[start] + incoming.energy_j[a]
            streams.position[size] = start
            streams.end[size] = labels.ptr[source + 1]
            streams.arc[size] = a
            streams.heap_s[size] = labels.duration_s[start] + incoming.duration_s[a]
            streams.heap[size] = size
            size += 1
    for slot in range(size // 2 - 1, -1, -1):
        _sift_down(streams.heap_s, streams.heap, size, slot, streams.heap_s[slot], streams.heap[slot])
    return size


@leaf
def _first_below(energy_j, shift, bound, p, end):
    """First index of p .. end - 1 whose shifted energy is below the bound, else end; energies decrease."""
    step = 1
    while p + step <= end and energy_j[p + step - 1] + shift >= bound:
        p += step
        step *= 2
    high = min(end, p + step - 1)
    while p < high:
        middle = (p + high) >> 1
        if energy_j[middle] + shift >= bound:
            p = middle + 1
        else:
            high = middle
    return p


@kernel
def _merge(labels, incoming, nodes, latest_s, streams, out, parent):
    """Merge the lists of the next station's nodes, until all are done, a chunk of work is done or the space ends.

    Parameters
    ----------
    labels : Labels
        The station before.
    incoming : Incoming
    nodes : tuple of 4 ints
        First node of the station before, first node of the next station, node to begin with, one past the last node.
    latest_s : (n_nodes,) float64
        Latest useful time at each node.
    streams : Streams
        Scratch, modified in place.
    out : Labels
        Lists of the next station, modified in place; ``out.ptr`` is filled up to the returned node.
    parent : (capacity,) int32
        Modified in place.

    Returns
    -------
    node, candidates : int
        Node to go on with, and candidates looked at for the nodes before it.
    full : bool
        Whether the space ended.
    """
    before_first, first, node, end_node = nodes
    candidates = 0
    while node < end_node and candidates < _CHUNK:
        n = begin = out.ptr[node - first]
        last_j = np.inf
        size = _open_streams(labels, incoming, before_first, node, streams)
        while size > 0:
            t = streams.heap_s[0]
            if t > latest_s[node]:
                break
            candidates += 1
            s = streams.heap[0]
            p = streams.position[s]
            if streams.energy_j[s] < last_j:
                last_j = streams.energy_j[s]
                if n > begin and out.duration_s[n - 1] == t:
                    n -= 1
                if n == parent.size:
                    return node, candidates, True
                out.duration_s[n] = t
                out.energy_j[n] = last_j
                parent[n] = p
                n += 1
            arc = streams.arc[s]
            shift = incoming.energy_j[arc]
            p = _first_below(labels.energy_j, shift, last_j, p + 1, streams.end[s])
            if p < streams.end[s]:
                streams.position[s] = p
                streams.energy_j[s] = labels.energy_j[p] + shift
                t = labels.duration_s[p] + incoming.duration_s[arc]
            else:
                size -= 1
                t = streams.heap_s[size]
                s = streams.heap[size]
            _sift_down(streams.heap_s, streams.heap, size, 0, t, s)
        node += 1
        out.ptr[node - first] = n
    return node, candidates, False


def _grown(array: NDArray[Any], size: int) -> NDArray[Any]:
    larger = np.empty(size, dtype=array.dtype)
    larger[: len(array)] = array
    return larger


class _Station(NamedTuple):
    """Finished labels of a station, their parents and the candidates looked at."""

    labels: Labels
    parent: NDArray[np.int32]
    candidates: int


def _merge_station(
    labels: Labels, incoming: Incoming, span: tuple[int, int, int], latest_s: NDArray[np.float64], streams: Streams,
    space: _Station, most_labels: int, clock: Clock,
) -> _Station | None:  # fmt: skip
    """Merge all lists of one station into ``space``, growing it as needed; None when the budget ends."""
    before, first, end = span
    out, parent = space.labels._replace(ptr=np.zeros(end - first + 1, dtype=np.int64)), space.parent
    node, total = first, 0
    while node < end:
        node, candidates, full = _merge(labels, incoming, (before, first, node, end), latest_s, streams, out, parent)
        total += candidates
        if clock.expired or (len(parent) if full else int(out.ptr[node - first])) > most_labels:
            return None
        if full:
            size = 2 * len(parent)
            out = Labels(out.ptr, _grown(out.duration_s, size), _grown(out.energy_j, size))
            parent = _grown(parent, size)
    return _Station(out, parent, total)


def _sweep(
    graph: LayeredGraph, latest_s: NDArray[np.float64], budget: SearchBudget
) -> tuple[Labels, list[NDArray[np.int32]], list[NDArray[np.int64]], dict[str, int]]:
    """Merge station after station; return the terminal's labels, and parents and list offsets of all stations."""
    clock = budget.start()
    most_labels = budget.max_labels or DEFAULT_LABELS
    incoming = graph.incoming()
    most = int(np.max(np.diff(incoming.arc_ptr), initial=1))
    streams = Streams(
        energy_j=np.empty(most),
        position=np.empty(most, dtype=np.int64),
        end=np.empty(most, dtype=np.int64),
        arc=np.empty(most, dtype=np.int64),
        heap_s=np.empty(most),
        heap=np.empty(most, dtype=np.int32),
    )
    labels = Labels(np.array([0, 1]), np.zeros(_FIRST_SPACE), np.zeros(_FIRST_SPACE))
    spare = Labels(labels.ptr, np.empty(_FIRST_SPACE), np.empty(_FIRST_SPACE))
    parent = np.empty(_FIRST_SPACE, dtype=np.int32)
    parents: list[NDArray[np.int32]] = []
    offsets = [labels.ptr]
    stored, candidates = 1, 0
    for k in range(1, graph.n_layers):
        before, first, end = (int(node) for node in graph.layer_ptr[k - 1 : k + 2])
        if len(spare.duration_s) > len(parent):
            parent = np.empty(len(spare.duration_s), dtype=np.int32)
        space = _Station(spare, parent[: len(spare.duration_s)], 0)
        done = _merge_station(
            labels, incoming, (before, first, end), latest_s, streams, space, most_labels - stored, clock
        )
        if done is None:
            raise BudgetExceededError(
                f"exact: the budget of {most_labels:,} labels and {budget.time_limit_s:g} s ended at station {k} "
                f"of {graph.n_layers - 1}; use fewer speeds, longer segments, less delay or a larger budget"
            )
        spare, labels, parent = labels, done.labels, done.parent
        count = int(labels.ptr[-1])
        parents.append(parent[:count].copy())
        offsets.append(labels.ptr)
        stored += count
        candidates += done.candidates
    pool_bytes = sum(array.nbytes for array in parents) + sum(array.nbytes for array in offsets)
    scratch_bytes = parent.nbytes + 2 * (labels.duration_s.nbytes + spare.duration_s.nbytes)
    counters = {
        "labels": stored,
        "generated": candidates,
        "pruned_dominance": candidates - stored + 1,
        "bytes": pool_bytes + scratch_bytes,
    }
    return labels, parents, offsets, counters


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
    time_to_go_s = least_to_go(graph, 1.0, 0.0)
    latest_s = max_time_s * (1.0 + ROUNDING) - time_to_go_s
    latest_s[-1] = max_time_s
    labels, parents, offsets, counters = _sweep(graph, latest_s, budget)
    if labels.ptr[-1] == 0:
        raise too_slow(float(time_to_go_s[0]), max_time_s)
    nodes = np.empty((int(labels.ptr[-1]), graph.n_layers), dtype=np.int32)
    nodes[:, -1] = graph.n_nodes - 1
    index: NDArray[np.integer] = np.arange(len(nodes))
    for k in range(graph.n_layers - 2, -1, -1):
        index = parents[k][index]
        nodes[:, k] = graph.layer_ptr[k] + np.searchsorted(offsets[k], index, side="right") - 1
    counters["terminals"] = len(nodes)
    front = slice(len(nodes))
    return GraphPaths(labels.duration_s[front].copy(), labels.energy_j[front].copy(), nodes, True, counters)


def exact_front(grid: Grid, max_time_s: float, budget: SearchBudget) -> GridPaths:
    """All Pareto-optimal paths of a grid within a time limit; see `exact_paths`."""
    return grid_paths(grid, exact_paths(grid.graph, max_time_s, budget))
