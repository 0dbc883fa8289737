"""The front of a sum from the fronts of its parts: all Pareto-minimal sums, exact, whether the parts are convex or not.

The parts give their energies on common steps of time, so that sums of steps are steps again and the sums of so many
fronts do not multiply: this is the (min, +) convolution of their energies.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Sums(NamedTuple):
    """Least sums for each total of steps: energies in J, (n,), and the steps that each part takes, (n, parts)."""

    energy_j: NDArray[np.float64]
    steps: NDArray[np.int64]


def least_sums(parts_j: Sequence[NDArray[np.float64]]) -> Sums:
    """Least energy of all parts together for each number of steps of time that they take together.

    Parameters
    ----------
    parts_j : sequence of (k,) float64
        Energy of each part when it takes 0, 1, ... steps, J.

    Returns
    -------
    Sums
        For 0 steps up to as many as the parts can take. Of equal sums the one whose later parts take fewer steps.
    """
    energy_j = np.asarray(parts_j[0])
    steps = np.arange(len(energy_j))[:, None]
    for part_j in parts_j[1:]:
        sums_j = np.full(len(energy_j) + len(part_j) - 1, np.inf)
        taken = np.zeros(len(sums_j), dtype=np.int64)
        for step, own_j in enumerate(part_j.tolist()):
            here = slice(step, step + len(energy_j))
            candidate_j = energy_j + own_j
            better = candidate_j < sums_j[here]
            sums_j[here][better] = candidate_j[better]
            taken[here][better] = step
        steps = np.column_stack((steps[np.arange(len(sums_j)) - taken], taken))
        energy_j = sums_j
    return Sums(energy_j, steps)
