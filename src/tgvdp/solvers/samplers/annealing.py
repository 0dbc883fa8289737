"""Classical samplers of D-Wave's dwave-samplers, and dimod's enumeration: thin adapters, with draws that come again."""

import time
from math import ceil
from typing import Any

import numpy as np

from tgvdp.errors import InputError
from tgvdp.formulations.problem.schedule import Solution
from tgvdp.formulations.qubo.encoded import Encoded
from tgvdp.formulations.qubo.qubo import Qubo
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.extras import extra
from tgvdp.solvers.samplers.bqm import bqm_of
from tgvdp.solvers.samplers.sampling import ground_state_solution, lowest, sampled_solution, samples_of

#: Most bits that dimod enumerates, in a second or two.
MAX_EXACT_BITS = 20

#: Most sweeps of tabu search between restarts: each looks at every bit once and flips the best that is allowed.
TABU_STAGE = 200

#: Widest tree decomposition: a table of 2²² doubles.
MAX_WIDTH = 22

#: Most fields and couplings that are eliminated: the search for an order is quadratic.
MAX_TREE_BITS = 5000


def solve_sa(encoded: Encoded, allowance: Allowance) -> Solution:
    """Simulated annealing; uses ``reads``, ``sweeps``, ``beta`` and ``seed``.

    Temperatures fall in geometric progression; without ``beta`` their range is dwave-samplers' own.
    """
    sampler = extra("dwave.samplers", "solver sa").SimulatedAnnealingSampler()
    budget = {
        "num_reads": allowance.reads, "num_sweeps": allowance.sweeps, "beta_range": allowance.beta,
        "seed": allowance.seed,
    }  # fmt: skip
    used = {"sweeps": allowance.sweeps, "beta": allowance.beta and str(allowance.beta), "seed": allowance.seed}
    return _sampled("sa", sampler, encoded, budget, used)


def solve_tabu(encoded: Encoded, allowance: Allowance) -> Solution:
    """Tabu search in equal stages of at most `TABU_STAGE` sweeps; uses ``reads``, ``sweeps``, ``tenure`` and ``seed``.

    The stages together have the sweeps that were asked for, rounded up to whole ones of each, so that they mean the
    same work as elsewhere. There is no limit of time, because results would depend on the machine.
    """
    sampler = extra("dwave.samplers", "solver tabu").TabuSampler()
    tenure = max(1, min(encoded.qubo.n - 1, int(allowance.tenure * encoded.qubo.n)))
    stages = max(1, ceil(allowance.sweeps / TABU_STAGE))
    stage = ceil(allowance.sweeps / stages)
    budget = {
        "num_reads": allowance.reads,
        "seed": allowance.seed,
        "tenure": tenure,
        "timeout": None,
        "num_restarts": stages - 1,
        "coefficient_z_first": stage,
        "coefficient_z_restart": stage,
        "lower_bound_z": 1,
    }
    details = {"sweeps": stages * stage, "tenure": tenure, "restarts": stages - 1, "seed": allowance.seed}
    return _sampled("tabu", sampler, encoded, budget, details)


def solve_descent(encoded: Encoded, allowance: Allowance) -> Solution:
    """Steepest descent from random strings, a baseline; uses ``reads`` and ``seed``."""
    sampler = extra("dwave.samplers", "solver descent").SteepestDescentSampler()
    return _sampled(
        "descent", sampler, encoded, {"num_reads": allowance.reads, "seed": allowance.seed}, {"seed": allowance.seed}
    )


def solve_exact_qubo(encoded: Encoded, _: Allowance) -> Solution:
    """Enumerate all bit strings with dimod's ExactSolver, and count the ground states.

    Raises
    ------
    InputError
        When there are more than `MAX_EXACT_BITS` bits.
    """
    n = encoded.qubo.n
    if n > MAX_EXACT_BITS:
        raise InputError(f"solver exact-qubo: {n} bits are too many to enumerate (at most {MAX_EXACT_BITS})")
    sampler = extra("dimod", "solver exact-qubo").ExactSolver()
    bqm = bqm_of(encoded.qubo)
    start = time.perf_counter()
    sampleset = sampler.sample(bqm)
    elapsed_s = time.perf_counter() - start
    states = samples_of(sampleset, encoded.qubo).bits
    if n:
        states = states[lowest(np.asarray(sampleset.record.energy), encoded.qubo)]
    return ground_state_solution("exact-qubo", encoded, states, elapsed_s, {}, counted=True)


def solve_tree(encoded: Encoded, _: Allowance) -> Solution:
    """Ground state by dynamic programming over a tree decomposition, exponential in its width only.

    Raises
    ------
    InputError
        When the width is above `MAX_WIDTH`. The square of the distance couples all bits, so that only small instances
        pass.
    """
    module = extra("dwave.samplers", "solver tree")
    start = time.perf_counter()
    order, width = elimination_order(encoded.qubo)
    sampleset = module.TreeDecompositionSolver().sample(
        bqm_of(encoded.qubo), elimination_order=[encoded.qubo.labels[bit] for bit in order]
    )
    elapsed_s = time.perf_counter() - start
    states = samples_of(sampleset, encoded.qubo).bits
    return ground_state_solution("tree", encoded, states, elapsed_s, {"width": width}, counted=False)


def elimination_order(qubo: Qubo) -> tuple[list[int], int]:
    """Order in which to eliminate bits, always one of least degree, and the width of the tree that it makes.

    Raises
    ------
    InputError
        As soon as the width exceeds `MAX_WIDTH`, or for more than `MAX_TREE_BITS` bits.
    """
    if qubo.n > MAX_TREE_BITS:
        raise InputError(f"solver tree: {qubo.n} bits are more than {MAX_TREE_BITS}")
    neighbours: dict[int, set[int]] = {bit: set() for bit in range(qubo.n)}
    for row, col in zip(qubo.rows.tolist(), qubo.cols.tolist(), strict=True):
        neighbours[row].add(col)
        neighbours[col].add(row)
    order, width = [], 0
    while neighbours:
        bit = min(neighbours, key=lambda one: (len(neighbours[one]), one))
        around = neighbours.pop(bit)
        width = max(width, len(around))
        if width > MAX_WIDTH:
            raise InputError(f"solver tree: the couplings of {qubo.n} bits have a width above {MAX_WIDTH}")
        for other in around:
            neighbours[other] |= around
            neighbours[other] -= {bit, other}
        order.append(bit)
    return order, width


def _sampled(solver: str, sampler: Any, encoded: Encoded, budget: dict[str, Any], details: dict[str, Any]) -> Solution:
    bqm = bqm_of(encoded.qubo)
    start = time.perf_counter()
    sampleset = sampler.sample(bqm, **budget) if encoded.qubo.n else None
    elapsed_s = time.perf_counter() - start
    return sampled_solution(solver, encoded, samples_of(sampleset, encoded.qubo), elapsed_s, details)
