"""Replicas of a bit string at different temperatures that change places: the kernel of parallel tempering."""

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import allocating, leaf

Floats: TypeAlias = NDArray[np.float64]
Bits: TypeAlias = NDArray[np.int8]
State: TypeAlias = NDArray[np.uint64]

_TO_UNIT = 2.0**-53
#: Rises that are never taken: exp(−40) is below the spacing of the random numbers.
_HOPELESS = 40.0


@leaf
def uniform(state: State) -> float:
    """Next number in [0, 1): SplitMix64 (Steele, Lea and Flood, OOPSLA 2014)."""
    state[0] += np.uint64(0x9E3779B97F4A7C15)
    z = state[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return float((z ^ (z >> np.uint64(31))) >> np.uint64(11)) * _TO_UNIT


@allocating
def temper(linear: Floats, couplings: Floats, beta: Floats, sweeps: int, reads: int, seed: int) -> Bits:
    """Random replicas, sweeps by Metropolis' rule, exchanges of neighbours, and the lowest string of each read.

    Parameters
    ----------
    linear : (n,) float64
    couplings : (n, n) float64
        Symmetric, 0 on the diagonal: the energy is Σ aᵢ·xᵢ + ½·Σ wᵢⱼ·xᵢ·xⱼ.
    beta : (R,) float64
        Inverse temperatures, rising.
    sweeps : int
        Of each replica.
    reads, seed : int

    Returns
    -------
    (reads, n) int8
    """
    replicas, n = beta.size, linear.size
    state = np.array([seed], dtype=np.uint64)
    found = np.empty((reads, n), dtype=np.int8)
    bits = np.empty((replicas, n), dtype=np.int8)
    fields = np.empty((replicas, n))  # what setting each bit costs beside the others
    energy = np.empty(replicas)
    at = np.arange(replicas)  # replica at each temperature
    for read in range(reads):
        lowest = math.inf
        for r in range(replicas):
            energy[r] = 0.0
            fields[r] = linear
            for i in range(n):
                bits[r, i] = 1 if uniform(state) < 0.5 else 0
                if bits[r, i]:
                    energy[r] += fields[r, i]
                    fields[r] += couplings[i]
        for sweep in range(sweeps):
            for rank in range(replicas):
                r = at[rank]
                for i in range(n):
                    sign = 1.0 - 2.0 * bits[r, i]
                    rise = beta[rank] * sign * fields[r, i]
                    if rise > 0.0 and (rise > _HOPELESS or uniform(state) >= math.exp(-rise)):
                        continue
                    energy[r] += sign * fields[r, i]
                    bits[r, i] = 1 - bits[r, i]
                    fields[r] += sign * couplings[i]
                    if energy[r] < lowest:
                        lowest = energy[r]
                        found[read] = bits[r]
            for rank in range(sweep % 2, replicas - 1, 2):
                gain = (beta[rank + 1] - beta[rank]) * (energy[at[rank + 1]] - energy[at[rank]])
                if gain >= 0.0 or uniform(state) < math.exp(gain):
                    at[rank], at[rank + 1] = at[rank + 1], at[rank]
    return found
