"""Least cost from every node of a layered graph to its terminal: the bounds of the searches."""

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel
from tgvdp.methods.grid.layered import LayeredGraph

#: Sums from the terminal backward and from the root forward round differently; a bound is lowered by this share, far
#: above the rounding error of 10⁵ additions, so that it never cuts off a path whose own sum meets the limit.
ROUNDING = 1e-10


@kernel
def _least_to_go(graph, time_weight, energy_weight, to_go):
    for node in range(graph.arc_ptr.size - 3, -1, -1):
        best = np.inf
        for a in range(graph.arc_ptr[node], graph.arc_ptr[node + 1]):
            cost = time_weight * graph.duration_s[a] + energy_weight * graph.energy_j[a]
            best = min(best, cost + to_go[graph.arc_to[a]])
        to_go[node] = best


def least_to_go(graph: LayeredGraph, time_weight: float, energy_weight: float) -> NDArray[np.float64]:
    """Least weighted cost to the terminal from every node, by backward dynamic programming.

    Parameters
    ----------
    graph : LayeredGraph
    time_weight, energy_weight : float
        The cost of an arc is ``time_weight · duration_s + energy_weight · energy_j``.

    Returns
    -------
    (n_nodes,) float64
        Infinite where the terminal cannot be reached.
    """
    to_go = np.full(graph.n_nodes, np.inf)
    to_go[-1] = 0.0
    _least_to_go(graph, time_weight, energy_weight, to_go)
    return to_go


def fastest_path(graph: LayeredGraph, to_go_s: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Time and energy of the fastest path at every layer.

    Parameters
    ----------
    graph : LayeredGraph
        Its terminal can be reached.
    to_go_s : (n_nodes,) float64
        Least time to go.

    Returns
    -------
    duration_s, energy_j : (n_layers,) float64
        Added from the root forward.
    """
    duration_s, energy_j = np.zeros(graph.n_layers), np.zeros(graph.n_layers)
    node = 0
    for k in range(graph.n_layers - 1):
        arcs = slice(graph.arc_ptr[node], graph.arc_ptr[node + 1])
        best = arcs.start + int(np.argmin(graph.duration_s[arcs] + to_go_s[graph.arc_to[arcs]]))
        duration_s[k + 1] = duration_s[k] + graph.duration_s[best]
        energy_j[k + 1] = energy_j[k] + graph.energy_j[best]
        node = int(graph.arc_to[best])
    return duration_s, energy_j
