"""The random baseline: bit strings drawn by tossing coins, decoded and judged as those of any sampler."""

import time

import numpy as np

from tgvdp.formulations.problem.encoding import Encoded, Solution
from tgvdp.solvers.allowance import Options
from tgvdp.solvers.samplers.sampling import Samples, sampled_solution


def solve_random(encoded: Encoded, options: Options) -> Solution:
    """Draw every bit with a fair coin; uses ``reads`` and ``seed``. What is no better than this has found nothing."""
    start = time.perf_counter()
    bits = np.random.default_rng(options.seed).integers(0, 2, (options.reads, encoded.qubo.n), dtype=np.int8)
    elapsed_s = time.perf_counter() - start
    samples = Samples(bits, np.ones(options.reads, dtype=np.int64))
    return sampled_solution("random", encoded, samples, elapsed_s, {"seed": options.seed})
