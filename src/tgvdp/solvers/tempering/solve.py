"""Parallel tempering of a QUBO (Swendsen and Wang, Phys. Rev. Lett. 57, 2607, 1986; Hukushima and Nemoto 1996).

Without the cluster moves of Zhu, Ochoa and Katzgraber (Phys. Rev. Lett. 115, 077201, 2015): the square of the distance
couples all bits, and on a complete graph a cluster of two replicas' differences is all of them.
"""

import time
from math import ceil, log

import numpy as np

from tgvdp.formulations.problem.schedule import Solution
from tgvdp.formulations.qubo.encoded import Encoded
from tgvdp.formulations.qubo.qubo import Qubo
from tgvdp.solvers.allowance import Allowance, BetaRange
from tgvdp.solvers.samplers.sampling import Samples, sampled_solution
from tgvdp.solvers.tempering.kernel import Floats, temper


def solve_pt(encoded: Encoded, allowance: Allowance) -> Solution:
    """Parallel tempering; uses ``reads``, ``sweeps``, ``replicas``, ``beta`` and ``seed``.

    A read is a set of replicas at temperatures in geometric progression, and gives the lowest string that any of them
    met. ``sweeps`` counts the updates per bit of all replicas together, so that it means the same work as elsewhere.
    """
    linear, couplings = dense(encoded.qubo)
    beta = allowance.beta or default_beta(linear, couplings)
    ladder = np.geomspace(beta.low, beta.high, allowance.replicas)
    sweeps = ceil(allowance.sweeps / allowance.replicas)
    temper(linear[:1], couplings[:1, :1], ladder, 0, 0, allowance.seed)  # compiled before the clock starts
    start = time.perf_counter()
    bits = temper(linear, couplings, ladder, sweeps, allowance.reads, allowance.seed)
    elapsed_s = time.perf_counter() - start
    samples = Samples(bits, np.ones(len(bits), dtype=np.int64))
    details = {
        "sweeps": sweeps * allowance.replicas, "replicas": allowance.replicas, "beta": str(beta),
        "seed": allowance.seed,
    }  # fmt: skip
    return sampled_solution("pt", encoded, samples, elapsed_s, details)


def dense(qubo: Qubo) -> tuple[Floats, Floats]:
    """Linear coefficients, and the symmetric matrix of the couplings with 0 on its diagonal."""
    couplings = np.zeros((qubo.n, qubo.n))
    couplings[qubo.rows, qubo.cols] = qubo.values
    return np.array(qubo.linear), couplings + couplings.T


def default_beta(linear: Floats, couplings: Floats) -> BetaRange:
    """Range in which the hottest replica takes any flip with probability ½ at least, the coldest hardly the least one.

    The same rule as dwave-samplers': ln 2 over the largest change that a flip can make, ln 100 over the least
    coefficient.
    """
    sizes = np.abs(np.concatenate((linear, couplings.reshape(-1))))
    largest = float((np.abs(linear) + np.abs(couplings).sum(axis=1)).max(initial=0.0)) or 1.0
    least = float(sizes[sizes > 0.0].min(initial=largest))
    return BetaRange(log(2.0) / largest, log(100.0) / least)
