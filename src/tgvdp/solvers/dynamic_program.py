"""Exact dynamic program over (step, speed, distance): optimum, one solution, and the number of optimal solutions.

1. Multiplier. The cheapest cost + μ·distance over all plans needs only (step, speed). The convex hull of (distance,
   cost) is walked towards the wanted distance, each edge by one such program; its value there is a lower bound L.
2. Guess. All plans of cost ≤ L + gap live in windows of distance, one per (step, speed), that the bounds of prefixes
   and suffixes under a dozen multipliers leave (`tgvdp.graph.ladder`). The windows are filled backwards.
3. If the cheapest plan found costs no more than the guess, it is optimal and all optimal plans lie in the windows;
   otherwise the gap grows. When the guess reaches the dearest plan there is, no window leaves anything out.

Costs are whole numbers (`tgvdp.formulations.ladder`), so optima, ties and counts are exact.
"""

import functools
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import BudgetExceededError, InfeasibleError
from tgvdp.formulations.instances import BinaryInstance
from tgvdp.formulations.ladder import Ladder
from tgvdp.graph import ladder as kernels
from tgvdp.graph import ladder_paths as paths

#: States of one run of the dynamic program; each takes a byte.
MOST_STATES = 400_000_000
#: Prices kept for the windows: 8 bytes each, twice.
_MOST_PRICES = 20_000_000
#: Multipliers around the best one, relative to the scale of all: near ones cut what is nearly optimal, far ones what is
#: far from it.
_SPREAD = (1 / 256, 1 / 64, 1 / 16, 1 / 4, 1.0, 4.0)
_GROWTH = 4
_FIRST_GAPS = 1 << 14
_HULL_STEPS = 200


@dataclass(frozen=True)
class Optimum:
    """What the dynamic program proves.

    Attributes
    ----------
    levels : (N+1,) int64
        Speeds of one optimal plan, in levels of the ladder.
    cost : int
        In whole units of the ladder.
    n_optimal : int
        Number of optimal plans.
    states : int
        (step, speed, distance) states of the last run.
    bound : float
        Lagrangian lower bound, in the same unit as the cost.
    """

    levels: NDArray[np.int64]
    cost: int
    n_optimal: int
    states: int
    bound: float


class _Hull(NamedTuple):
    bound: float
    multiplier: float
    scale: float


def optimal_plan(ladder: Ladder, most_states: int = MOST_STATES) -> Optimum:
    """Solve exactly.

    Raises
    ------
    InfeasibleError
        When no plan satisfies all constraints.
    BudgetExceededError
        When more than ``most_states`` states would have to be kept.
    """
    heights = _heights(ladder)
    hull = _hull(ladder, heights)
    dearest = -_cheapest(ladder, 0.0, -1)[0]
    multipliers = _multipliers(ladder, hull)
    graph = (ladder.caps, ladder.rise, ladder.fall, ladder.cost)
    prefixes = kernels.prices_of_prefixes(*graph, multipliers)
    suffixes = kernels.prices_of_suffixes(*graph, multipliers)
    slack = 0.5 + 1e-12 * max(abs(hull.bound), abs(dearest))
    lowest = ladder.quantum * int(np.ceil((hull.bound - slack) / ladder.quantum))
    gap = 0
    while True:
        guess = min(lowest + gap, dearest)
        low, high = kernels.windows(ladder.low, ladder.high, prefixes, suffixes, multipliers, heights, guess + slack)
        start = _starts(low, high)
        states = int(start[-1, -1])
        if states > most_states:
            raise BudgetExceededError(
                f"{ladder.instance.id}: needs {states} states (step, speed, distance), and may keep {most_states}; "
                f"the objective is at least {ladder.objective(lowest):.9g}"
            )
        moves = np.empty(states, dtype=np.uint8)
        cost = int(
            kernels.cheapest_moves(
                low, high, start, ladder.low, ladder.high, ladder.rise, ladder.fall, ladder.cost, moves
            )
        )
        if cost <= guess:
            break
        if guess == dearest:
            raise _infeasible(ladder)
        gap = max(gap * _GROWTH, ladder.quantum, (dearest - lowest) // _FIRST_GAPS)
    walk = (low, start, moves, ladder.rise, ladder.fall)
    return Optimum(paths.one_path(*walk), cost, _count(walk), states, hull.bound)


@functools.cache
def load_kernels() -> None:
    """Compile the kernels, or load them from the cache, by solving a toy."""
    cost = np.array(((1, 1), (0, 0), (0, 0)), dtype=np.int64)
    toy = BinaryInstance(
        id="toy", model="constant", steps=2, dt_s=1.0, dv_mps=1.0, acc_units=1, dec_units=1, cap_units=(1, 0),
        distance_units=1.0,
    )  # fmt: skip
    caps = np.array((0, 1, 0), dtype=np.int64)
    optimal_plan(Ladder(toy, caps, 1, 1, cost, 1, 1, 1, Fraction(1), Fraction(0)))


def _heights(ladder: Ladder) -> NDArray[np.int64]:
    least, most = (
        kernels.heights_of_suffixes(ladder.caps, ladder.rise, ladder.fall, ladder.top, sign) for sign in (1, -1)
    )
    if ladder.low > ladder.high or least[0, 0] > ladder.high or most[0, 0] < ladder.low:
        raise _infeasible(ladder)
    return np.stack((least, most))


def _infeasible(ladder: Ladder) -> InfeasibleError:
    instance = ladder.instance
    return InfeasibleError(
        f"{instance.id}: no plan of {instance.steps} steps covers {instance.distance_units:g} "
        f"± {instance.tol_units:g} Δv·Δt from stop to stop within the speed limits"
    )


def _cheapest(ladder: Ladder, multiplier: float, sign: int = 1) -> tuple[int, int]:
    cost, height = kernels.cheapest_path(ladder.caps, ladder.rise, ladder.fall, sign * ladder.cost, multiplier)
    return int(cost), int(height)


def _hull(ladder: Ladder, heights: NDArray[np.int64]) -> _Hull:
    """Lower bound on the cost, by the lower convex hull of (height, cost) of all plans, and the multiplier there."""
    largest = 4.0 * float(np.abs(ladder.cost).max() + 1) * ladder.caps.size
    (left_cost, left), (right_cost, right) = (_cheapest(ladder, price) for price in (largest, -largest))
    scale = abs(right_cost - left_cost) / max(1, right - left)
    free_cost, free = _cheapest(ladder, 0.0)
    if ladder.low <= free <= ladder.high:
        return _Hull(float(free_cost), 0.0, scale)
    wanted = ladder.low if free < ladder.low else ladder.high
    if free < wanted:
        left_cost, left = free_cost, free
    else:
        right_cost, right = free_cost, free
    for _ in range(_HULL_STEPS):
        slope = (right_cost - left_cost) / (right - left)
        cost, height = _cheapest(ladder, -slope)
        if (cost - left_cost) * (right - left) >= (right_cost - left_cost) * (height - left):
            break  # nothing below the edge
        if height < wanted:
            left_cost, left = cost, height
        else:
            right_cost, right = cost, height
        if height == wanted:
            break
    slope = (right_cost - left_cost) / (right - left)
    return _Hull(left_cost + slope * (wanted - left), -slope, scale)


def _multipliers(ladder: Ladder, hull: _Hull) -> NDArray[np.float64]:
    scale = max(hull.scale, abs(hull.multiplier), 1e-3)
    around = [hull.multiplier + sign * part * scale for part in _SPREAD for sign in (1, -1)]
    multipliers = np.array([hull.multiplier, *around])
    if multipliers.size * (ladder.top + 1) * ladder.caps.size > _MOST_PRICES:
        raise BudgetExceededError(
            f"{ladder.instance.id}: {ladder.caps.size - 1} steps × {ladder.top + 1} speeds are too many"
        )
    return multipliers


def _starts(low: NDArray[np.int64], high: NDArray[np.int64]) -> NDArray[np.int64]:
    """Where each window starts in one array of all states; the last column is the end of the layer."""
    width = np.maximum(0, high - low + 1)
    end = np.cumsum(width).reshape(width.shape)
    return np.hstack((end[:, :1] - width[:, :1], end))


def _count(walk: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint8], int, int]) -> int:
    rough = float(paths.roughly_count(*walk))
    most_bits = 1.585 * walk[0].shape[0] if np.isinf(rough) else np.log2(rough) + 1.0
    limbs = paths.count(*walk, int(most_bits // kernels.LIMB_BITS) + 1)
    return sum(int(limb) << (kernels.LIMB_BITS * position) for position, limb in enumerate(limbs))
