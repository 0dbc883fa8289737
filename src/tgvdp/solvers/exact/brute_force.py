"""All plans of a small instance, one after the other: the oracle of the exact solvers.

Of the binary model all 3^N sequences of accelerating, holding and braking are made and judged by the model's own
formulas, without any of the identities, bounds and prunings of the other solvers.
"""

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError, InputError
from tgvdp.formulations.problem.binary import features, half_distance, speeds
from tgvdp.formulations.problem.instances import BinaryInstance, decimal

#: 3¹⁴ = 4.8 million plans, half a minute.
MOST_STEPS = 14
_CHUNK = 3**10


def best_plans(instance: BinaryInstance) -> tuple[NDArray[np.int8], Fraction]:
    """All optimal plans and their objective in Δv².

    Returns
    -------
    signs : (n_optimal, N) int8
        +1 accelerates, 0 holds, −1 brakes.
    objective : Fraction

    Raises
    ------
    InputError
        When the instance has more than `MOST_STEPS` steps.
    InfeasibleError
        When no plan satisfies all constraints.
    """
    if instance.steps > MOST_STEPS:
        raise InputError(
            f"{instance.id}: brute force takes at most {MOST_STEPS} steps, got {instance.steps}; use --solver dp"
        )
    best: Fraction | None = None
    found: list[NDArray[np.int8]] = []
    for start in range(0, 3**instance.steps, _CHUNK):
        signs = _feasible(instance, start, min(start + _CHUNK, 3**instance.steps))
        if not len(signs):
            continue
        value = features(instance, signs > 0, signs < 0)
        pairs, which = np.unique(np.column_stack((value.first, value.second)), axis=0, return_inverse=True)
        exact = [value.p * int(one) - value.q * int(other) for one, other in pairs]
        least = min(exact)
        if best is None or least < best:
            best, found = least, []
        if least == best:
            winners = [index for index, worth in enumerate(exact) if worth == best]
            found.append(signs[np.isin(which, winners)])
    if best is None:
        raise InfeasibleError(f"{instance.id}: none of the {3**instance.steps} plans satisfies all constraints")
    return np.concatenate(found), best


def _feasible(instance: BinaryInstance, start: int, end: int) -> NDArray[np.int8]:
    numbers = np.arange(start, end, dtype=np.int64)
    powers = 3 ** np.arange(instance.steps, dtype=np.int64)
    signs = (numbers[:, None] // powers % 3).astype(np.int8) - np.int8(1)
    v = speeds(instance, signs > 0, signs < 0)
    distance, tolerance = decimal(instance.distance_units), decimal(instance.tol_units)
    # In whole numbers: |half·unit/2 − D| ≤ tol, with D and tol as fractions.
    lowest, highest = 2 * (distance - tolerance), 2 * (distance + tolerance)
    half = half_distance(instance, signs > 0, signs < 0)
    inside = (half >= lowest.__ceil__()) & (half <= highest.__floor__())
    fits = (v[:, -1] == 0) & (v >= 0).all(-1) & (v[:, 1:] <= np.array(instance.cap_units)).all(-1)
    kept: NDArray[np.int8] = signs[inside & fits]
    return kept
