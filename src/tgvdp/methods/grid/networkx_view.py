"""The networkx view of a layered graph: an independent oracle for tests, and something to draw."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.grid.layered import LayeredGraph

if TYPE_CHECKING:
    import networkx


def networkx_view(
    graph: LayeredGraph,
    level: NDArray[np.int32] | None = None,
    station_m: NDArray[np.float64] | None = None,
    level_mps: NDArray[np.float64] | None = None,
) -> "networkx.DiGraph[tuple[int, int]]":
    """Copy a graph into networkx.

    Parameters
    ----------
    graph : LayeredGraph
    level : (n_nodes,) int32, optional
        Speed index of each node, as in `Grid.level`; else nodes are numbered within their layer.
    station_m : (n_layers,) float64, optional
        Positions of the layers, m: become the node attribute ``position_m``.
    level_mps : (n_levels,) float64, optional
        Speeds by index, m/s: become the node attribute ``speed_mps``.

    Returns
    -------
    networkx.DiGraph
        Nodes are (station, level); edges carry ``duration_s`` and ``energy_j``.
    """
    import networkx

    layer = graph.layer
    number = level if level is not None else np.arange(graph.n_nodes) - graph.layer_ptr[layer]
    names = [(int(k), int(j)) for k, j in zip(layer, number, strict=True)]
    view: networkx.DiGraph[tuple[int, int]] = networkx.DiGraph()
    for name in names:
        view.add_node(name)
        if station_m is not None:
            view.nodes[name]["position_m"] = float(station_m[name[0]])
        if level_mps is not None:
            view.nodes[name]["speed_mps"] = float(level_mps[name[1]])
    arcs = zip(graph.arc_from, graph.arc_to, graph.duration_s, graph.energy_j, strict=True)
    view.add_edges_from(
        (names[source], names[target], {"duration_s": float(duration), "energy_j": float(energy)})
        for source, target, duration, energy in arcs
    )
    return view
