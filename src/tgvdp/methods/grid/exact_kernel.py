"""Kernels of the exact search: the labels of a node, merged from those at the other ends of its arcs; see `exact`."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.methods.grid.exact_bounds import CELLS
from tgvdp.methods.grid.exact_ceiling import cell_of, fill_ceiling

#: Candidates looked at in one kernel call, less than a tenth of a second.
_CHUNK = 1_000_000
#: Entries of the work counts.
LOOKED_AT, BEYOND_BOUND = range(2)


class Labels(NamedTuple):
    """Labels of one station: those of its node j are ``ptr[j] .. ptr[j + 1] - 1``, sorted by time."""

    ptr: NDArray[np.int64]
    duration_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]


class Scratch(NamedTuple):
    """Room to work in: one entry per stream, a binary heap of the streams by time, and tables by cell of arrival."""

    energy_j: NDArray[np.float64]
    position: NDArray[np.int64]
    end: NDArray[np.int64]
    arc: NDArray[np.int64]
    heap_s: NDArray[np.float64]
    heap: NDArray[np.int32]
    hull_j: NDArray[np.float64]
    best: NDArray[np.int32]
    ceiling_j: NDArray[np.float64]


def make_scratch(most_streams: int) -> Scratch:
    """Room for so many streams."""
    energy_j, heap_s = np.empty((2, most_streams))
    position, end, arc = np.empty((3, most_streams), dtype=np.int64)
    heap, best = np.empty(most_streams, dtype=np.int32), np.zeros(CELLS, dtype=np.int32)
    return Scratch(energy_j, position, end, arc, heap_s, heap, np.empty(CELLS), best, np.empty(CELLS))


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


@leaf
def _next_useful(labels, shift_s, shift_j, below_j, p, end, bounds, node, ceiling_j, work):
    """First label of p .. end - 1 that makes a useful candidate below an energy, else end.

    Candidates grow cheaper and the ceiling falls along the list: one that is not below it rules out all that are not
    cheaper than that.
    """
    while True:
        if p == end or labels.energy_j[end - 1] + shift_j >= below_j:
            return end
        p = _first_below(labels.energy_j, shift_j, below_j, p, end)
        work[LOOKED_AT] += 1
        t = labels.duration_s[p] + shift_s
        if t > bounds.latest_s[node]:
            work[BEYOND_BOUND] += 1
            return end
        below_j = ceiling_j[cell_of(bounds, node, t)]
        if labels.energy_j[p] + shift_j < below_j:
            return p
        work[BEYOND_BOUND] += 1


@leaf
def _open_streams(labels, incoming, bounds, first_node, node, scratch, work):
    """Start one stream per arc into a node whose list has a useful candidate; return their number."""
    if bounds.earliest_s[node] > bounds.latest_s[node]:
        return 0
    if not fill_ceiling(bounds, node, scratch.hull_j, scratch.best, scratch.ceiling_j):
        return 0
    size = 0
    for a in range(incoming.arc_ptr[node], incoming.arc_ptr[node + 1]):
        source = incoming.arc_from[a] - first_node
        shift_s, shift_j = incoming.duration_s[a], incoming.energy_j[a]
        start, end = labels.ptr[source], labels.ptr[source + 1]
        if start == end:
            continue
        p = _next_useful(labels, shift_s, shift_j, np.inf, start, end, bounds, node, scratch.ceiling_j, work)
        if p < end:
            scratch.energy_j[size] = labels.energy_j[p] + shift_j
            scratch.position[size] = p
            scratch.end[size] = end
            scratch.arc[size] = a
            scratch.heap_s[size] = labels.duration_s[p] + shift_s
            scratch.heap[size] = size
            size += 1
    for slot in range(size // 2 - 1, -1, -1):
        _sift_down(scratch.heap_s, scratch.heap, size, slot, scratch.heap_s[slot], scratch.heap[slot])
    return size


@kernel
def merge(labels, incoming, bounds, nodes, scratch, out, parent, work):
    """Merge the lists of the next station's nodes, until all are done, a chunk of work is done or the space ends.

    Parameters
    ----------
    labels : Labels
        The station before.
    incoming : Incoming
    bounds : BoundSet
    nodes : tuple of 4 ints
        First node of the station before, first node of the next station, node to begin with, one past the last node.
    scratch : Scratch
        Modified in place.
    out : Labels
        Lists of the next station, modified in place; ``out.ptr`` is filled up to the returned node.
    parent : (capacity or more,) int32
        Modified in place.
    work : (2,) int64
        Candidates looked at, and those beyond the bounds; receives those of this call.

    Returns
    -------
    node : int
        Node to go on with.
    full : bool
        Whether the space ended.
    """
    before_first, first, node, end_node = nodes
    work[:] = 0
    while node < end_node and work[LOOKED_AT] < _CHUNK:
        n = begin = out.ptr[node - first]
        last_j = np.inf
        looked_at, beyond_bound = work[LOOKED_AT], work[BEYOND_BOUND]
        size = _open_streams(labels, incoming, bounds, before_first, node, scratch, work)
        while size > 0:
            t = scratch.heap_s[0]
            s = scratch.heap[0]
            p = scratch.position[s]
            if scratch.energy_j[s] < last_j:
                last_j = scratch.energy_j[s]
                if n > begin and out.duration_s[n - 1] == t:
                    n -= 1
                if n == out.duration_s.size:
                    work[LOOKED_AT], work[BEYOND_BOUND] = looked_at, beyond_bound  # this node begins anew
                    return node, True
                out.duration_s[n] = t
                out.energy_j[n] = last_j
                parent[n] = p
                n += 1
            arc = scratch.arc[s]
            shift_s, shift_j = incoming.duration_s[arc], incoming.energy_j[arc]
            end = scratch.end[s]
            p = _next_useful(labels, shift_s, shift_j, last_j, p + 1, end, bounds, node, scratch.ceiling_j, work)
            if p < end:
                scratch.position[s] = p
                scratch.energy_j[s] = labels.energy_j[p] + shift_j
                t = labels.duration_s[p] + shift_s
            else:
                size -= 1
                t = scratch.heap_s[size]
                s = scratch.heap[size]
            _sift_down(scratch.heap_s, scratch.heap, size, 0, t, s)
        node += 1
        out.ptr[node - first] = n
    return node, False
