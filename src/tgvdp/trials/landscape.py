"""The energy landscape of a small instance: how deep the strings lie, by their distance from the nearest optimum."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.formulations.problem.instances import BinaryInstance, Instance
from tgvdp.formulations.qubo.encoded import Encoded
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.formulations.qubo.names import Encoding
from tgvdp.formulations.qubo.qubo import bits_of

#: Most bits of which all strings are listed.
MAX_BITS = 16
#: Quantiles of the energies at each distance.
QUANTILES = (0.0, 0.1, 0.5, 0.9, 1.0)


@dataclass(frozen=True)
class Landscape:
    """All strings of an encoding.

    Attributes
    ----------
    title : str
    bits : int
    quantiles : (len(QUANTILES), bits + 1) float64
        Energy above the optimum of the strings at each Hamming distance from the nearest optimum; NaN where none is.
    feasible_distance, feasible_energy : (f,)
        Hamming distance and energy above the optimum of the strings that decode to a feasible schedule.
    penalty : float
        λ in (m/s)².
    optima, strict_minima, weak_minima : int
        Strings that decode to an optimum; strings that every single flip raises, and those that none lowers but some
        leave as they are, optima included.
    """

    title: str
    bits: int
    quantiles: NDArray[np.float64]
    feasible_distance: NDArray[np.int64]
    feasible_energy: NDArray[np.float64]
    penalty: float
    optima: int
    strict_minima: int
    weak_minima: int


def landscapes(instances: Sequence[Instance], encodings: Sequence[Encoding]) -> list[Landscape]:
    """Of the largest instance that all encodings write in at most `MAX_BITS` bits; none where there is no such one."""
    for instance in sorted(instances, key=lambda one: -one.steps):
        if not isinstance(instance, BinaryInstance) or instance.steps > MAX_BITS:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FormulationWarning)
            try:
                encoded = [encode(instance, encoding, "sufficient") for encoding in encodings]
            except InputError:
                continue  # an encoding that needs equal steps
        encoded = [one for one in encoded if one.complete]  # elsewhere strings may lie below the optimum
        if encoded and all(1 <= one.qubo.n <= MAX_BITS for one in encoded):
            found = [landscape(one) for one in encoded]
            if all(one is not None for one in found):
                return [one for one in found if one is not None]
    return []


def landscape(encoded: Encoded) -> Landscape | None:
    """List all strings of an encoded instance; None where nothing is feasible."""
    n = encoded.qubo.n
    energies = encoded.qubo.all_energies()
    unbroken = np.flatnonzero(encoded.violation.all_energies() < 0.5)
    feasible = np.array([z for z in unbroken.tolist() if encoded.decode(bits_of(z, n)).feasible], dtype=np.int64)
    if not feasible.size:
        return None
    least = float(energies[feasible].min())
    tiny = 1e-9 * max(1.0, encoded.qubo.stats.coefficient_range[1])
    optima = feasible[energies[feasible] <= least + tiny]
    z = np.arange(energies.size)
    distance = np.min([np.bitwise_count(z ^ optimum) for optimum in optima.tolist()], axis=0).astype(np.int64)
    above = energies - least
    above[np.abs(above) <= tiny] = 0.0  # rounding
    quantiles = np.full((len(QUANTILES), n + 1), np.nan)
    for d in np.unique(distance).tolist():
        quantiles[:, d] = np.quantile(above[distance == d], QUANTILES)
    lowest_flip = np.min([energies[z ^ (1 << bit)] for bit in range(n)], axis=0)
    title = f"{encoded.instance.id}, {encoded.encoding}"
    strict = int(np.count_nonzero(energies < lowest_flip - tiny))
    weak = int(np.count_nonzero(energies <= lowest_flip + tiny)) - strict
    return Landscape(
        title, n, quantiles, distance[feasible], above[feasible], encoded.penalty, len(optima), strict, weak
    )
