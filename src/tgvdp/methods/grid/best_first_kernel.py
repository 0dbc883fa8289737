"""Kernels of the best-first search: label pool, heap, lists of each node's labels, found paths; see `best_first`."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.methods.grid.to_go import ROUNDING

#: Time buckets of a node's list.
BUCKETS = 512

#: Entries of the state vector; from EXPANDED on they are counters.
(LABELS, QUEUED, FOUND, EXPANDED, GENERATED, BY_CONSTRAINT, BY_DELAY, BY_BOUND, BY_DOMINANCE, COPIES, WORK) = range(11)

#: Why the kernel returned.
EXHAUSTED, ENOUGH, CHUNK_DONE, FULL = range(4)


class Rules(NamedTuple):
    """Frozen settings of a search, as the kernel sees them; arrays are (n_nodes,) float64.

    With ``ratio`` the priority is (t - base_s[node]) / (base_j[node] - E), else time_weight · t + energy_weight · E +
    base_s[node]. ``least_s`` is the least time to go, whether or not it bounds; it places a label in its node's list.
    """

    ratio: bool
    time_weight: float
    energy_weight: float
    base_s: NDArray[np.float64]
    base_j: NDArray[np.float64]
    to_go_s: NDArray[np.float64]
    to_go_j: NDArray[np.float64]
    bounds: bool
    dominance: bool
    max_time_s: float
    most_paths: int
    apart_s: float
    apart_j: float
    blocked: NDArray[np.int32]
    least_s: NDArray[np.float64]
    buckets_per_s: float


class Lists(NamedTuple):
    """Lists of labels by node: the first label, (n_nodes,), and the last in each time bucket, (n_nodes, BUCKETS)."""

    first: NDArray[np.int32]
    tail: NDArray[np.int32]


class Pool(NamedTuple):
    """Labels as columns, and the heap; all arrays have the same length.

    ``next`` chains the labels of a node by time, strictly decreasing in energy (with dominance); -2 marks a label that
    was displaced. ``found`` holds paths by time.
    """

    node: NDArray[np.int32]
    parent: NDArray[np.int32]
    next: NDArray[np.int32]
    duration_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]
    heap_key: NDArray[np.float64]
    heap: NDArray[np.int32]
    found: NDArray[np.int32]


@leaf
def _priority(rules, node, t, e):
    if not rules.ratio:
        return rules.time_weight * t + rules.energy_weight * e + rules.base_s[node]
    delay = t - rules.base_s[node]
    if delay <= 0.0:
        return 0.0
    saved = rules.base_j[node] - e
    if saved <= 0.0:
        return np.inf
    return delay / saved


@leaf
def _above(pool, a, b):
    """Whether heap entry a comes before b: by key, then the younger label first, which leads to the terminal."""
    return pool.heap_key[a] < pool.heap_key[b] or (pool.heap_key[a] == pool.heap_key[b] and pool.heap[a] > pool.heap[b])


@leaf
def _swap(pool, a, b):
    pool.heap_key[a], pool.heap_key[b] = pool.heap_key[b], pool.heap_key[a]
    pool.heap[a], pool.heap[b] = pool.heap[b], pool.heap[a]


@leaf
def _push(pool, state, key, label):
    slot = state[QUEUED]
    state[QUEUED] += 1
    pool.heap_key[slot] = key
    pool.heap[slot] = label
    while slot > 0 and _above(pool, slot, (slot - 1) >> 1):
        _swap(pool, slot, (slot - 1) >> 1)
        slot = (slot - 1) >> 1


@leaf
def _pop(pool, state):
    label = pool.heap[0]
    state[QUEUED] -= 1
    size = state[QUEUED]
    pool.heap_key[0] = pool.heap_key[size]
    pool.heap[0] = pool.heap[size]
    slot = 0
    while True:
        child = 2 * slot + 1
        if child >= size:
            return label
        if child + 1 < size and _above(pool, child + 1, child):
            child += 1
        if not _above(pool, child, slot):
            return label
        _swap(pool, slot, child)
        slot = child


@leaf
def _bucket(rules, node, t):
    """Time bucket of a label in the list of its node."""
    share = (t + rules.least_s[node] - rules.least_s[0]) * rules.buckets_per_s
    return int(min(max(share, 0.0), BUCKETS - 1.0))


@leaf
def _enter(pool, state, rules, lists, node, t, e, label):
    """Put a label into the list of its node; return False if one there is no worse, else displace the worse ones.

    ``lists.tail[node, b]`` is the last label of the list in bucket b, so that a walk starts close to its place.
    """
    bucket = _bucket(rules, node, t)
    before = -1
    for b in range(bucket - 1, -1, -1):
        before = lists.tail[node, b]
        if before >= 0:
            break
    after = lists.first[node] if before < 0 else pool.next[before]
    while after >= 0 and pool.duration_s[after] < t:
        before = after
        after = pool.next[after]
        state[WORK] += 1
    if before >= 0 and pool.energy_j[before] <= e:
        return False
    if after >= 0 and pool.duration_s[after] == t and pool.energy_j[after] <= e:
        return False
    while after >= 0 and pool.energy_j[after] >= e:
        displaced = after
        after = pool.next[after]
        pool.next[displaced] = -2
        b = _bucket(rules, node, pool.duration_s[displaced])
        if lists.tail[node, b] == displaced:
            lists.tail[node, b] = -1
        state[BY_DOMINANCE] += 1
    if after < 0 or _bucket(rules, node, pool.duration_s[after]) > bucket:
        lists.tail[node, bucket] = label
    pool.next[label] = after
    if before >= 0:
        pool.next[before] = label
    else:
        lists.first[node] = label
    return True


@leaf
def _no_better_than_found(pool, state, t, e):
    """Whether a found path is at most as late and as costly: the last one that is at most as late is the cheapest."""
    low = 0
    high = state[FOUND]
    while low < high:
        middle = (low + high) >> 1
        if pool.duration_s[pool.found[middle]] <= t:
            low = middle + 1
        else:
            high = middle
    return low > 0 and pool.energy_j[pool.found[low - 1]] <= e


@leaf
def _accept(pool, state, rules, label):
    """Add a path to those found, if it is new."""
    t = pool.duration_s[label]
    e = pool.energy_j[label]
    if _no_better_than_found(pool, state, t, e):
        state[BY_BOUND] += 1
        return
    kept = 0
    copy = False
    state[WORK] += state[FOUND]
    slot = 0
    for i in range(state[FOUND]):
        other = pool.found[i]
        if pool.duration_s[other] >= t and pool.energy_j[other] >= e:
            continue
        near = abs(pool.duration_s[other] - t) <= rules.apart_s and abs(pool.energy_j[other] - e) <= rules.apart_j
        copy = copy or (near and rules.most_paths > 0)
        pool.found[kept] = other
        kept += 1
        if pool.duration_s[other] < t:
            slot = kept
    state[FOUND] = kept
    if copy:
        state[COPIES] += 1
        return
    for i in range(kept, slot, -1):
        pool.found[i] = pool.found[i - 1]
    pool.found[slot] = label
    state[FOUND] += 1


@leaf
def _expand(graph, rules, pool, state, lists, label):
    """Add the children of a label."""
    node = pool.node[label]
    state[EXPANDED] += 1
    state[BY_CONSTRAINT] += rules.blocked[node]
    terminal = graph.arc_ptr.size - 2
    for a in range(graph.arc_ptr[node], graph.arc_ptr[node + 1]):
        state[GENERATED] += 1
        state[WORK] += 1
        child = graph.arc_to[a]
        t = pool.duration_s[label] + graph.duration_s[a]
        e = pool.energy_j[label] + graph.energy_j[a]
        ideal_s = (t + rules.to_go_s[child]) * (1.0 - ROUNDING)
        if ideal_s > rules.max_time_s or (child == terminal and t > rules.max_time_s):
            state[BY_DELAY] += 1
            continue
        ideal_j = (e + rules.to_go_j[child]) * (1.0 - ROUNDING)
        if rules.bounds and _no_better_than_found(pool, state, ideal_s, ideal_j):
            state[BY_BOUND] += 1
            continue
        new = state[LABELS]
        if rules.dominance and not _enter(pool, state, rules, lists, child, t, e, new):
            state[BY_DOMINANCE] += 1
            continue
        pool.node[new] = child
        pool.parent[new] = label
        pool.duration_s[new] = t
        pool.energy_j[new] = e
        state[LABELS] += 1
        _push(pool, state, _priority(rules, child, t, e), new)


@kernel
def run_chunk(graph, rules, pool, state, lists, most_children, chunk):
    """Expand labels until nothing is left, enough paths are found, a chunk of work is done or the space ends.

    Parameters
    ----------
    graph : LayeredGraph
    rules : Rules
    pool : Pool
        Modified in place.
    state : (11,) int64
        Numbers of labels, queued labels and paths found, then counters; modified in place.
    lists : Lists
        Modified in place.
    most_children : int
        Largest number of arcs that leave a node.
    chunk : int
        Steps along arcs and lists after which it returns; with 1 it takes one label from the queue.

    Returns
    -------
    int
        ``EXHAUSTED``, ``ENOUGH``, ``CHUNK_DONE`` or ``FULL``.
    """
    terminal = graph.arc_ptr.size - 2
    state[WORK] = 0
    while state[QUEUED] > 0:
        if state[WORK] >= chunk:
            return CHUNK_DONE
        if state[LABELS] + most_children > pool.node.size:
            return FULL
        label = _pop(pool, state)
        state[WORK] += 1
        if pool.next[label] == -2:
            continue
        node = pool.node[label]
        if node == terminal:
            _accept(pool, state, rules, label)
            if rules.most_paths > 0 and state[FOUND] >= rules.most_paths:
                return ENOUGH
            continue
        if rules.bounds:
            ideal_s = (pool.duration_s[label] + rules.to_go_s[node]) * (1.0 - ROUNDING)
            ideal_j = (pool.energy_j[label] + rules.to_go_j[node]) * (1.0 - ROUNDING)
            if _no_better_than_found(pool, state, ideal_s, ideal_j):
                state[BY_BOUND] += 1
                continue
        _expand(graph, rules, pool, state, lists, label)
    return EXHAUSTED
