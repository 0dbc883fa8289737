"""D-Wave's annealers: a QUBO embedded in the graph of a machine, with the account of its standard file."""

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from tgvdp.errors import InputError, UnavailableError
from tgvdp.formulations.problem.schedule import Solution
from tgvdp.formulations.qubo.encoded import Encoded
from tgvdp.formulations.qubo.ising import ising_of
from tgvdp.formulations.qubo.qubo import Qubo
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.extras import extra
from tgvdp.solvers.samplers.bqm import bqm_of
from tgvdp.solvers.samplers.sampling import sampled_solution, samples_of


def solve_dwave(encoded: Encoded, allowance: Allowance) -> Solution:
    """Sample on a quantum annealer; uses ``reads``, ``chain_strength``, ``anneal_us`` and ``backend``.

    The clock includes embedding, network and queue.

    Raises
    ------
    UnavailableError
        When there is no account or no such machine.
    InputError
        When the problem does not fit it.
    """
    chosen = {} if allowance.backend is None else {"solver": allowance.backend}
    machine = connected("dwave", "machine", "DWaveSampler", **chosen)
    return embedded_solution(machine, encoded, allowance)


def connected(solver: str, what: str, sampler: str, **options: Any) -> Any:
    """Sampler of the cloud, by the name of its class in ``dwave.system``.

    Raises
    ------
    UnavailableError
        When there is no account, or not what is asked for.
    """
    system = extra("dwave.system", f"solver {solver}")
    try:
        return getattr(system, sampler)(**options)
    except Exception as error:  # the cloud client has many of its own, for accounts, machines, services and networks
        raise UnavailableError(
            f"solver {solver}: no {what}: {error} (an account is set up by: dwave config create)"
        ) from None


def embedded_solution(machine: Any, encoded: Encoded, allowance: Allowance) -> Solution:
    """Sample on a machine, or on a ``MockDWaveSampler``, through an embedding by minorminer.

    Raises
    ------
    InputError
        When no embedding is found.
    """
    composite = extra("dwave.system", "solver dwave").EmbeddingComposite(machine)
    bqm = bqm_of(encoded.qubo)
    anneal = {} if allowance.anneal_us is None else {"annealing_time": allowance.anneal_us}
    start = time.perf_counter()
    try:
        sampleset = composite.sample(
            bqm,
            num_reads=allowance.reads,
            chain_strength=chain_strength(encoded.qubo, allowance.chain_strength),
            return_embedding=True,
            embedding_parameters={"random_seed": allowance.seed},
            **anneal,
        )
    except ValueError as error:
        raise InputError(f"solver dwave: {encoded.qubo.n} bits do not fit the machine: {error}") from None
    samples = samples_of(sampleset, encoded.qubo)
    elapsed_s = time.perf_counter() - start
    chains = sampleset.info["embedding_context"]["embedding"].values()
    details = {
        "qubits": sum(map(len, chains)),
        "longest_chain": max(map(len, chains)),
        "chain_strength": sampleset.info["embedding_context"]["chain_strength"],
        "broken_chains": float(np.mean(sampleset.record.chain_break_fraction)),
        "anneal_us": allowance.anneal_us,
        "seed": allowance.seed,
        "qpu_s": qpu_time_s(sampleset.info.get("timing", {})),
    }
    return sampled_solution("dwave", encoded, samples, elapsed_s, details)


def chain_strength(qubo: Qubo, relative: float | None) -> float | None:
    """Coupling of a chain: a multiple of the largest field or coupling of the Ising form; None stays None."""
    ising = ising_of(qubo, 1)
    largest = max(np.abs(ising.fields).max(initial=0.0), np.abs(ising.couplings).max(initial=0.0))
    return None if relative is None else relative * float(largest)


def qpu_time_s(timing: Mapping[str, Any]) -> float | None:
    """Time on the quantum processor that an answer of the cloud reports, s; None where it does not."""
    access_us = timing.get("qpu_access_time")
    return None if access_us is None else 1e-6 * float(access_us)
