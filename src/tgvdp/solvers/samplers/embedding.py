"""How many qubits of an annealer a QUBO takes: its graph of couplers embedded into an ideal Pegasus or Zephyr graph.

Each bit becomes a chain of connected qubits. Two ways are tried, and the one of fewer qubits counts: minorminer (Cai,
Macready & Roy, arXiv 1406.2741), which looks for short chains in any graph, and the embedding of a complete graph
(Boothby, King & Roy, arXiv 1507.04774), which takes a moment and is the better one where nearly all bits are coupled.
Machines lack some of the qubits of the ideal graph, so that the figures are lower than theirs by a few per cent.

Both are compiled code, of which an abort would take the whole benchmark along: they run in a process of their own.
"""

import json
import subprocess
import sys
import time
from typing import Any, NamedTuple

import numpy as np

from tgvdp.errors import InputError
from tgvdp.formulations.qubo.ising import ising_of
from tgvdp.formulations.qubo.qubo import Qubo
from tgvdp.solvers.extras import extra
from tgvdp.solvers.samplers.bqm import bqm_of

#: Topology → function of dwave.graphs and size of the largest machine: 5640 and 4800 qubits.
TOPOLOGIES = {"pegasus": ("pegasus_graph", 16), "zephyr": ("zephyr_graph", 12)}
#: Beyond the time for minorminer, what imports, graph and clique may take, s.
_STARTING_S = 120.0


#: Range of fields over that of couplings, as machines report them.
FIELDS_OVER_COUPLINGS = 4.0


class Embedding(NamedTuple):
    """An embedding's size.

    Attributes
    ----------
    qubits, longest_chain : int or None
        None where none was found in time.
    method : str or None
        ``minorminer`` or ``clique``, whichever took fewer qubits.
    elapsed_s : float
        Of both.
    """

    qubits: int | None
    longest_chain: int | None
    method: str | None
    elapsed_s: float


class Fineness(NamedTuple):
    """How fine a machine must be.

    Attributes
    ----------
    chain_strength : float
        By uniform torque compensation, the rule of dwave-system, over the largest coupling of the Ising form.
    finest_coupling : float
        Smallest coupling over what fills the machine's range: the largest coupling or a chain, or a quarter of the
        largest field, because machines take fields up to 4 where couplings go to 1.
    """

    chain_strength: float
    finest_coupling: float


def fineness(qubo: Qubo) -> Fineness:
    """Chain strength and the smallest coupling of a QUBO; 0 where there is no coupling."""
    ising = ising_of(qubo, 1)
    couplings, fields = np.abs(ising.couplings), np.abs(ising.fields)
    if not couplings.size:
        return Fineness(0.0, 0.0)
    rule = extra("dwave.embedding.chain_strength", "a chain strength").uniform_torque_compensation
    chain = float(rule(bqm_of(qubo).spin))
    full = max(float(couplings.max()), chain, float(fields.max()) / FIELDS_OVER_COUPLINGS)
    return Fineness(chain / float(couplings.max()), float(couplings[couplings > 0.0].min()) / full)


def embedding_of(qubo: Qubo, topology: str, seed: int, time_limit_s: float) -> Embedding:
    """Embed the couplers of a QUBO; a bit without couplers takes one qubit.

    Raises
    ------
    InputError
        When there is no such topology.
    """
    if topology not in TOPOLOGIES:
        raise InputError(f"embedding: there is no {topology!r}; there are {', '.join(TOPOLOGIES)}")
    for module in ("dwave.graphs", "minorminer"):
        extra(module, "an embedding")
    pairs = list(zip(qubo.rows.tolist(), qubo.cols.tolist(), strict=True))
    asked = json.dumps({"pairs": pairs, "bits": qubo.n, "topology": topology, "seed": seed, "limit_s": time_limit_s})
    start = time.perf_counter()
    try:
        done = subprocess.run(
            [sys.executable, "-c", f"import sys; sys.path[:] = {sys.path!r}; import {__name__} as m; m.serve()"],
            input=asked, capture_output=True, text=True, timeout=time_limit_s + _STARTING_S, check=True,
        )  # fmt: skip
        found: dict[str, list[int]] = json.loads(done.stdout)
    except (subprocess.SubprocessError, ValueError):  # aborted, or took far too long
        found = {}
    elapsed_s = time.perf_counter() - start
    if not found:
        return Embedding(None, None, None, elapsed_s)
    method = min(found, key=lambda name: (sum(found[name]), max(found[name], default=0)))
    return Embedding(sum(found[method]), max(found[method], default=0), method, elapsed_s)


def serve() -> None:
    """Embed what stdin asks for; prints the lengths of the chains of each method that found any."""
    asked = json.loads(sys.stdin.read())
    chains = _chains(**asked)
    bits = asked["bits"]
    # A bit without couplers takes a qubit of its own.
    lengths = {name: [len(chain) for chain in own] + [1] * (bits - len(own)) for name, own in chains.items()}
    print(json.dumps(lengths))


def _chains(
    pairs: list[tuple[int, int]], bits: int, topology: str, seed: int, limit_s: float
) -> dict[str, list[list[Any]]]:
    if not pairs:
        return {"minorminer": []}
    graphs, minorminer = extra("dwave.graphs", "an embedding"), extra("minorminer", "an embedding")
    busclique = extra("minorminer.busclique", "an embedding")
    name, size = TOPOLOGIES[topology]
    graph = getattr(graphs, name)(size)
    coupled = len({bit for pair in pairs for bit in pair})
    found = {
        "clique": busclique.find_clique_embedding(coupled, graph),
        "minorminer": minorminer.find_embedding(pairs, list(graph.edges), random_seed=seed, timeout=limit_s),
    }
    return {method: list(chains.values()) for method, chains in found.items() if chains}
