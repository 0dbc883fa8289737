"""How many qubits of an annealer a QUBO takes: its graph of couplers embedded into an ideal Pegasus or Zephyr graph.

Each bit becomes a chain of connected qubits, by minorminer (Cai, Macready & Roy, arXiv 1406.2741). Machines lack some
of the qubits of the ideal graph, so that the figures are lower than theirs by a few per cent.
"""

import time
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
    qubits, longest_chain : int or None
        None where none was found in time.
    elapsed_s : float
    """

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
    minorminer = extra("minorminer", "an embedding")
    pairs = list(zip(qubo.rows.tolist(), qubo.cols.tolist(), strict=True))
    start = time.perf_counter()
    chains: dict[Any, list[Any]] = minorminer.find_embedding(
        pairs, list(graph.edges), random_seed=seed, timeout=time_limit_s
    )
    elapsed_s = time.perf_counter() - start
    if pairs and not chains:
        return Embedding(None, None, elapsed_s)
    alone = qubo.n - len(chains)
    lengths = [len(chain) for chain in chains.values()]
    return Embedding(sum(lengths) + alone, max([*lengths, min(alone, 1)]), elapsed_s)
