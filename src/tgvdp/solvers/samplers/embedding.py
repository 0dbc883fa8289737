"""How many qubits of an annealer a QUBO takes: its graph of couplers embedded into an ideal Pegasus or Zephyr graph.

Each bit becomes a chain of connected qubits: by minorminer (Cai, Macready & Roy, arXiv 1406.2741), or as a part of the
largest complete graph that fits (Boothby, King & Roy, Quantum Inf. Process. 15, 495, 2016), whichever takes fewer
qubits. Machines lack some qubits of the ideal graph, so that the figures are lower than theirs by a few per cent.
"""

import time
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from tgvdp.errors import InputError
from tgvdp.formulations.qubo.qubo import Qubo
from tgvdp.solvers.extras import extra

#: Topology → function of dwave.graphs and size of the largest machine: 5640 and 4800 qubits.
TOPOLOGIES = {"pegasus": ("pegasus_graph", 16), "zephyr": ("zephyr_graph", 12)}


class Embedding(NamedTuple):
    """An embedding's size.

    Attributes
    ----------
    method : {"minorminer", "clique"} or None
    qubits, longest_chain : int or None
        None where none was found in time.
    elapsed_s : float
        Of both methods.
    """

    method: str | None
    qubits: int | None
    longest_chain: int | None
    elapsed_s: float


def embedding_of(qubo: Qubo, topology: str, seed: int, time_limit_s: float) -> Embedding:
    """Embed the couplers of a QUBO; a bit without couplers takes one qubit.

    Raises
    ------
    InputError
        When there is no such topology.
    """
    if topology not in TOPOLOGIES:
        raise InputError(f"embedding: there is no {topology!r}; there are {', '.join(TOPOLOGIES)}")
    name, size = TOPOLOGIES[topology]
    graph = getattr(extra("dwave.graphs", "an embedding"), name)(size)
    minorminer, busclique = (extra(module, "an embedding") for module in ("minorminer", "minorminer.busclique"))
    pairs = list(zip(qubo.rows.tolist(), qubo.cols.tolist(), strict=True))
    coupled = sorted({bit for pair in pairs for bit in pair})
    start = time.perf_counter()
    found: dict[str, Mapping[Any, Sequence[Any]]] = {
        "clique": busclique.find_clique_embedding(coupled, graph, use_cache=False),
        "minorminer": minorminer.find_embedding(pairs, list(graph.edges), random_seed=seed, timeout=time_limit_s),
    }
    elapsed_s = time.perf_counter() - start
    sizes = {name: sum(map(len, chains.values())) for name, chains in found.items() if chains or not pairs}
    if not sizes:
        return Embedding(None, None, None, elapsed_s)
    method = min(sizes, key=lambda name: sizes[name])
    alone = qubo.n - len(coupled)
    longest = max([*map(len, found[method].values()), min(alone, 1)])
    return Embedding(method, sizes[method] + alone, longest, elapsed_s)
