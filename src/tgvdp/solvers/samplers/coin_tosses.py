"""The random baseline: bit strings drawn by tossing coins, decoded and judged as those of any sampler."""

import time

import numpy as np

from tgvdp.formulations.problem.schedule import Solution
from tgvdp.formulations.qubo.encoded import Encoded
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.samplers.sampling import Samples, sampled_solution


def solve_random(encoded: Encoded, allowance: Allowance) -> Solution:
    """Draw every bit with a fair coin; uses ``reads`` and ``seed``. What is no better than this has found nothing."""
    start = time.perf_counter()
    bits = np.random.default_rng(allowance.seed).integers(0, 2, (allowance.reads, encoded.qubo.n), dtype=np.int8)
    elapsed_s = time.perf_counter() - start
    samples = Samples(bits, np.ones(allowance.reads, dtype=np.int64))
    return sampled_solution("random", encoded, samples, elapsed_s, {"seed": allowance.seed})
