"""Bound sets of a layered graph: up to which energy a label can still lead to a Pareto-optimal path.

Two phases, as in bi-objective combinatorial optimisation (Ehrgott & Gandibleux, *Bound sets for biobjective
combinatorial optimization problems*, 2007; for labels Demeyer, Goedgebeur, Audenaert, Pickavet & Demeester, *Speeding
up Martins' algorithm for multiple objective shortest path problems*, 2013). First the supported paths are found by
bisection: each multiplier λ of time takes one dynamic program for E + λ·t backward and one forward. They give

- a lower bound: from a node on, a path of time τ takes at least H(τ) = max over λ of (least E + λ·t to go) - λ·τ;
- an upper bound: at each node a forward and a backward path make a known path from root to terminal. The least energy
  U(T) of those that arrive by T is tabulated in equal cells of time.

A label with time t and energy E at a node with least time to go T' is useless unless a completion beats the known
paths somewhere: E < Z(t) = max over arrivals T ≥ t + T' of U(T) - H(T - t); see `exact_ceiling`.

No bound may cut off a path by rounding. Known paths count as later and costlier, labels as earlier and lower bounds as
lower than they are, by `ROUNDING`, which is far above the rounding error of sums of costs, none of which is negative.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.methods.budget import Clock
from tgvdp.methods.grid.layered import Incoming, LayeredGraph
from tgvdp.methods.grid.to_go import ROUNDING

#: Cells of arrival time, from the fastest path's to the limit; a power of two.
CELLS = 256
#: Depth of the bisection at most, and the share of the range of energy that it leaves unknown of the hull. Measured on
#: grids of 20 to 40 segments: a fifth of it costs more time than its bounds save.
_BISECTIONS = 8
_HULL_RTOL = 0.01
#: Multipliers differ by this share at least, so that rounding does not change the order of the lines of H.
_APART = 1e-3
#: A range of times below this share of the limit has no cells: nothing is bounded.
_LEAST_RANGE = 1e-6


class Arrivals(NamedTuple):
    """Equal cells of arrival time, which begin at ``begin_s``, shifted for known paths and for labels."""

    begin_s: float
    known_from_s: float
    label_from_s: float
    cell_s: float
    cells_per_s: float


class BoundSet(NamedTuple):
    """What bounds the labels of a search; L multipliers, n nodes.

    Attributes
    ----------
    multiplier_j_per_s : (L,) float64
        Decreasing; the last one is 0.
    least_cost_j : (L, n) float64
        Least E + multiplier · t from a node to the terminal, lowered by `ROUNDING`.
    through_cost_j : (L, n) float64
        The same from the root through a node to the terminal.
    earliest_s, latest_s : (n,) float64
        Least time from the root to a node, and the latest useful time there.
    to_go_s : (n,) float64
        Least time from a node to the terminal.
    known_j : (CELLS,) float64
        Least energy of a known path that arrives before a cell begins, raised by `ROUNDING`; infinite if there is none.
    arrivals : Arrivals
    """

    multiplier_j_per_s: NDArray[np.float64]
    least_cost_j: NDArray[np.float64]
    through_cost_j: NDArray[np.float64]
    earliest_s: NDArray[np.float64]
    latest_s: NDArray[np.float64]
    to_go_s: NDArray[np.float64]
    known_j: NDArray[np.float64]
    arrivals: Arrivals


class _Tree(NamedTuple):
    """Cheapest paths at one multiplier: time and energy of those from each node, and of those to each node, (n,)."""

    from_s: NDArray[np.float64]
    from_j: NDArray[np.float64]
    to_s: NDArray[np.float64]
    to_j: NDArray[np.float64]


@leaf
def _fill_tree(graph, incoming, time_weight, energy_weight, tree, cost):
    """Dynamic programs backward and forward; receives the least ``time_weight · t + energy_weight · E``, (2, n)."""
    n_nodes = graph.arc_ptr.size - 1
    cost[0, n_nodes - 1] = cost[1, 0] = 0.0
    tree.from_s[n_nodes - 1] = tree.from_j[n_nodes - 1] = tree.to_s[0] = tree.to_j[0] = 0.0
    for node in range(n_nodes - 2, -1, -1):
        least, best = np.inf, -1
        for a in range(graph.arc_ptr[node], graph.arc_ptr[node + 1]):
            sum_a = time_weight * graph.duration_s[a] + energy_weight * graph.energy_j[a] + cost[0, graph.arc_to[a]]
            if sum_a < least:
                least, best = sum_a, a
        cost[0, node] = tree.from_s[node] = tree.from_j[node] = least
        if best >= 0:
            tree.from_s[node] = graph.duration_s[best] + tree.from_s[graph.arc_to[best]]
            tree.from_j[node] = graph.energy_j[best] + tree.from_j[graph.arc_to[best]]
    for node in range(1, n_nodes):
        least, best = np.inf, -1
        for a in range(incoming.arc_ptr[node], incoming.arc_ptr[node + 1]):
            arc_cost = time_weight * incoming.duration_s[a] + energy_weight * incoming.energy_j[a]
            sum_a = arc_cost + cost[1, incoming.arc_from[a]]
            if sum_a < least:
                least, best = sum_a, a
        cost[1, node] = tree.to_s[node] = tree.to_j[node] = least
        if best >= 0:
            tree.to_s[node] = incoming.duration_s[best] + tree.to_s[incoming.arc_from[best]]
            tree.to_j[node] = incoming.energy_j[best] + tree.to_j[incoming.arc_from[best]]


@leaf
def _note_known(to, back, arrivals, known_j):
    """Enter the paths that go to each node as in one tree and on as in another."""
    for node in range(to.to_s.size):
        cell = np.ceil((to.to_s[node] + back.from_s[node] - arrivals.known_from_s) * arrivals.cells_per_s)
        if cell < CELLS:
            c = int(max(cell, 0.0))
            known_j[c] = min(known_j[c], to.to_j[node] + back.from_j[node])


@kernel
def _solve(graph, incoming, time_weight, energy_weight, tree, cost):
    """Fill a tree."""
    _fill_tree(graph, incoming, time_weight, energy_weight, tree, cost)


@kernel
def _solve_between(graph, incoming, multiplier, fast, slow, arrivals, tree, cost, known_j):
    """Fill a tree at a multiplier between those of two others, and note the paths that the three make known."""
    _fill_tree(graph, incoming, multiplier, 1.0, tree, cost)
    _note_known(tree, tree, arrivals, known_j)
    _note_known(tree, fast, arrivals, known_j)
    _note_known(fast, tree, arrivals, known_j)
    _note_known(tree, slow, arrivals, known_j)
    _note_known(slow, tree, arrivals, known_j)


def _arrivals(first_s: float, max_time_s: float) -> Arrivals | None:
    """Cells up to the limit; None where there is no range of times."""
    margin_s = ROUNDING * max_time_s
    begin_s = first_s - 2.0 * margin_s
    range_s = max_time_s - begin_s
    if not range_s > _LEAST_RANGE * max_time_s:
        return None
    return Arrivals(begin_s, begin_s - margin_s, begin_s + margin_s, range_s / CELLS, CELLS / range_s)


class _Supported:
    """Supported paths, by bisection between the fastest and the thriftiest: multipliers fall, costs go with them."""

    def __init__(self, graph: LayeredGraph, incoming: Incoming, max_time_s: float, clock: Clock) -> None:
        self._graph, self._incoming, self._clock = graph, incoming, clock
        self._max_time_s = max_time_s
        self.fastest, _ = self._solve(1.0, 0.0)
        self.arrivals = _arrivals(float(self.fastest.from_s[0]), max_time_s)
        self.known_j = np.full(CELLS, np.inf)
        self.multipliers = [0.0]
        self.costs_j = [np.zeros((2, graph.n_nodes))]
        if self.arrivals is not None:
            thriftiest, cost_j = self._solve(0.0, 1.0)
            self._unknown_j = _HULL_RTOL * float(self.fastest.from_j[0] - thriftiest.from_j[0])
            self.multipliers, self.costs_j = [], []
            self._bisect(self.fastest, math.inf, thriftiest, 0.0, _BISECTIONS)
            self.multipliers.append(0.0)
            self.costs_j.append(cost_j)

    def _empty(self) -> tuple[_Tree, NDArray[np.float64]]:
        return _Tree(*np.empty((4, self._graph.n_nodes))), np.empty((2, self._graph.n_nodes))

    def _solve(self, time_weight: float, energy_weight: float) -> tuple[_Tree, NDArray[np.float64]]:
        tree, cost = self._empty()
        _solve(self._graph, self._incoming, time_weight, energy_weight, tree, cost)
        return tree, cost

    def _bisect(self, fast: _Tree, high_multiplier: float, slow: _Tree, low_multiplier: float, levels: int) -> None:
        """Find the supported paths between two others, those of higher multipliers first."""
        delay_s, saved_j = float(slow.from_s[0] - fast.from_s[0]), float(fast.from_j[0] - slow.from_j[0])
        if levels == 0 or delay_s <= 0.0 or saved_j <= 0.0 or fast.from_s[0] > self._max_time_s or self._clock.expired:
            return
        multiplier = saved_j / delay_s
        if not low_multiplier * (1.0 + _APART) < multiplier < high_multiplier * (1.0 - _APART):
            return
        # The hull lies between the chord and the corner of the tangents.
        steeper = (
            1.0 if math.isinf(high_multiplier) else (high_multiplier - multiplier) / (high_multiplier - low_multiplier)
        )
        if (multiplier - low_multiplier) * delay_s * steeper <= self._unknown_j:
            return
        tree, cost_j = self._empty()
        _solve_between(self._graph, self._incoming, multiplier, fast, slow, self.arrivals, tree, cost_j, self.known_j)
        self._bisect(fast, high_multiplier, tree, multiplier, levels - 1)
        self.multipliers.append(multiplier)
        self.costs_j.append(cost_j)
        self._bisect(tree, multiplier, slow, low_multiplier, levels - 1)


def find_bounds(graph: LayeredGraph, incoming: Incoming, max_time_s: float, clock: Clock) -> BoundSet:
    """Find the bound set of a graph.

    Parameters
    ----------
    graph : LayeredGraph
    incoming : Incoming
        Its arcs by their ends.
    max_time_s : float
        Longest running time, s.
    clock : Clock
        When it has expired, the bounds stay loose.

    Returns
    -------
    BoundSet
        For paths within the limit. Where the range of times is empty, it bounds times alone.
    """
    supported = _Supported(graph, incoming, max_time_s, clock)
    latest_s = max_time_s * (1.0 + ROUNDING) - supported.fastest.from_s
    latest_s[-1] = max_time_s
    costs_j = np.array(supported.costs_j) * (1.0 - ROUNDING)
    return BoundSet(
        multiplier_j_per_s=np.array(supported.multipliers),
        least_cost_j=costs_j[:, 0].copy(),
        through_cost_j=costs_j.sum(axis=1),
        earliest_s=supported.fastest.to_s * (1.0 - ROUNDING),
        latest_s=latest_s,
        to_go_s=supported.fastest.from_s,
        known_j=np.minimum.accumulate(supported.known_j) * (1.0 + ROUNDING),
        arrivals=supported.arrivals or Arrivals(0.0, 0.0, 0.0, 0.0, 0.0),
    )
