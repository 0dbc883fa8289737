"""The front of a sum from the fronts of its parts: all Pareto-minimal sums, exact, whether the parts are convex or not.

The parts give their energies on common steps of time, so that sums of steps are steps again and the sums of so many
fronts do not multiply: this is the (min, +) convolution of their energies.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.memory import ask_for
from tgvdp.methods.costate.multipliers import OutOfTime


class Sums(NamedTuple):
    """Least sums for each total of steps: energies in J, (n,), and the steps that each part takes, (n, parts)."""

    energy_j: NDArray[np.float64]
    steps: NDArray[np.int64]


def least_sums(parts_j: Sequence[NDArray[np.float64]], expired: Callable[[], bool] = bool) -> Sums:
    """Least energy of all parts together for each number of steps of time that they take together.

    Parameters
    ----------
    parts_j : sequence of (k,) float64
        Energy of each part when it takes 0, 1, ... steps, J.
    expired : callable, optional
        Whether the time for it is up.

    Returns
    -------
    Sums
        For 0 steps up to as many as the parts can take. Of equal sums the one whose later parts take fewer steps.

    Raises
    ------
    OutOfTime
        When the time is up.
    BudgetExceededError
        When there is not enough memory.
    """
    most = sum(map(len, parts_j))
    ask_for(16.0 * most * len(parts_j), f"the sums of the fronts of {len(parts_j):,} sections")
    energy_j = np.asarray(parts_j[0])
    taken_by_later: list[NDArray[np.int64]] = []
    for part_j in parts_j[1:]:
        if expired():
            raise OutOfTime
        sums_j = np.full(len(energy_j) + len(part_j) - 1, np.inf)
        taken = np.zeros(len(sums_j), dtype=np.int64)
        for step, own_j in enumerate(part_j.tolist()):
            here = slice(step, step + len(energy_j))
            candidate_j = energy_j + own_j
            better = candidate_j < sums_j[here]
            sums_j[here][better] = candidate_j[better]
            taken[here][better] = step
        taken_by_later.append(taken)
        energy_j = sums_j
    left = np.arange(len(energy_j))
    steps = np.empty((len(left), len(parts_j)), dtype=np.int64)
    for part in range(len(parts_j) - 1, 0, -1):
        steps[:, part] = taken_by_later[part - 1][left]
        left = left - steps[:, part]
    steps[:, 0] = left
    return Sums(energy_j, steps)
