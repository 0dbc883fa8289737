"""Views in networkx: of a layered graph, an oracle for tests; of the tree that a best-first search grew."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.grid.layered import LayeredGraph
from tgvdp.methods.grid.trace import Trace

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


def search_tree(trace: Trace) -> "networkx.DiGraph[int]":
    """Copy the tree of a search into networkx.

    Returns
    -------
    networkx.DiGraph
        Nodes are labels with ``position_m``, ``speed_mps``, ``duration_s``, ``energy_j``, ``priority``, ``taken`` (the
        step at which it left the queue, -1 for never) and ``became`` (see `Step`, "queued" where it never left);
        edges lead from a label to its children. The graph has the attributes ``effective_branching_factor`` and
        ``depth``.
    """
    import networkx

    tree: networkx.DiGraph[int] = networkx.DiGraph(effective_branching_factor=trace.branching, depth=trace.depth)
    grid = trace.grid
    taken = {step.label: (number, step.became) for number, step in enumerate(trace.steps)}
    for label, node in enumerate(trace.node.tolist()):
        at, became = taken.get(label, (-1, "queued"))
        tree.add_node(
            label,
            position_m=float(grid.station_m[grid.graph.layer[node]]), speed_mps=float(grid.level_mps[grid.level[node]]),
            duration_s=float(trace.duration_s[label]), energy_j=float(trace.energy_j[label]),
            priority=float(trace.priority[label]), taken=at, became=became,
        )  # fmt: skip
    tree.add_edges_from((parent, label) for label, parent in enumerate(trace.parent.tolist()) if parent >= 0)
    return tree


def graphml(tree: "networkx.DiGraph[int]") -> bytes:
    """A graph as GraphML, which most programs that draw graphs read."""
    import networkx

    lines = networkx.generate_graphml(tree)
    return "\n".join(('<?xml version="1.0" encoding="utf-8"?>', *lines, "")).encode()
