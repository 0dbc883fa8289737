"""The couplings of a QUBO as a networkx graph."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

if TYPE_CHECKING:
    import networkx


def coupler_graph(
    labels: Sequence[str],
    linear: NDArray[Any],
    rows: NDArray[Any],
    cols: NDArray[Any],
    values: NDArray[Any],
    offset: float,
) -> "networkx.Graph[str]":
    """Graph of the couplers: nodes are labels with ``bias``, edges carry ``coupling``, the graph itself ``offset``.

    Parameters
    ----------
    labels : sequence of n str
    linear : (n,) float64
    rows, cols : (m,) int32
    values : (m,) float64
    offset : float
    """
    import networkx

    graph: networkx.Graph[str] = networkx.Graph(offset=offset)
    graph.add_nodes_from((label, {"bias": float(bias)}) for label, bias in zip(labels, linear, strict=True))
    graph.add_edges_from(
        (labels[row], labels[col], {"coupling": float(value)})
        for row, col, value in zip(rows.tolist(), cols.tolist(), values, strict=True)
    )
    return graph


def node_link(graph: "networkx.Graph[str]") -> dict[str, Any]:
    """The node-link object of a graph, which ``networkx.node_link_graph`` reads again."""
    import networkx

    content: dict[str, Any] = networkx.node_link_data(graph, edges="edges")
    return content
