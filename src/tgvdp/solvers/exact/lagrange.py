"""Lagrangian bounds of the exact dynamic program, and the windows of distance that they leave.

A family is the set of plans whose top speed lies between two levels. Its bound is that of the convex hull of (distance,
cost) over its plans, walked towards the wanted distance by programs over (step, speed) alone. One family of all plans
is enough where cost is convex in speed. Where it is not, as in the efficiency model, the hull mixes standing still with
running at top speed, and its bound is weak: narrower families cannot, because each of their plans must reach its speed.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import BudgetExceededError
from tgvdp.formulations.problem.levels import Ladder
from tgvdp.solvers.exact import ladder as kernels
from tgvdp.solvers.exact.ladder import Floats, Ints

#: Prices kept for the windows: 8 bytes each.
_MOST_PRICES = 60_000_000
#: Multipliers around the best one, relative to the scale of all: near ones cut what is nearly optimal, far ones what is
#: far from it.
_SPREAD = (1 / 64, 1 / 16, 1 / 4, 1.0, 4.0)
_HULL_STEPS = 200


class Family(NamedTuple):
    """Plans whose top speed is ``touch`` at least and ``top`` at most, in levels.

    Attributes
    ----------
    bound : float
        Lower bound on their costs; infinite where there are none.
    touch, top : int
    multiplier, scale : float
        μ at the bound, and the cost per distance over the whole hull.
    """

    bound: float
    touch: int
    top: int
    multiplier: float
    scale: float


def family(ladder: Ladder, touch: int, top: int) -> Family:
    """Make a family and its bound."""
    largest = 4.0 * float(np.abs(ladder.cost).max() + 1) * ladder.caps.size
    (left_cost, left), (right_cost, right) = (
        cheapest(ladder, touch, top, multiplier) for multiplier in (largest, -largest)
    )
    if left_cost >= kernels.NEVER or left > ladder.high or right < ladder.low:
        return Family(np.inf, touch, top, 0.0, 0.0)
    scale = abs(right_cost - left_cost) / max(1, right - left)
    free_cost, free = cheapest(ladder, touch, top, 0.0)
    if ladder.low <= free <= ladder.high:
        return Family(float(free_cost), touch, top, 0.0, scale)
    wanted = ladder.low if free < ladder.low else ladder.high
    if free < wanted:
        left_cost, left = free_cost, free
    else:
        right_cost, right = free_cost, free
    for _ in range(_HULL_STEPS):
        slope = (right_cost - left_cost) / (right - left)
        cost, height = cheapest(ladder, touch, top, -slope)
        if (cost - left_cost) * (right - left) >= (right_cost - left_cost) * (height - left):
            break  # nothing below the edge
        if height < wanted:
            left_cost, left = cost, height
        else:
            right_cost, right = cost, height
        if height == wanted:
            break
    slope = (right_cost - left_cost) / (right - left)
    return Family(left_cost + slope * (wanted - left), touch, top, -slope, scale)


def halves(ladder: Ladder, whole: Family) -> list[Family]:
    """Split a family by top speed; empty halves are left out."""
    middle = (whole.touch + whole.top) // 2
    parts = (family(ladder, whole.touch, middle), family(ladder, middle + 1, whole.top))
    return [part for part in parts if part.bound < np.inf]


def cheapest(ladder: Ladder, touch: int, top: int, multiplier: float, sign: int = 1) -> tuple[int, int]:
    """Cost and height of a plan of a family with least sign·cost + μ·height."""
    signed = sign * np.ascontiguousarray(ladder.cost[:, : top + 1])
    cost, height = kernels.cheapest_path(ladder.caps, ladder.rise, ladder.fall, signed, touch, multiplier)
    return int(cost), int(height)


def windows(ladder: Ladder, one: Family, heights: Ints, bound: float) -> tuple[Ints, Ints]:
    """Lowest and highest height of each (step, level) of all plans of a family that cost at most ``bound``.

    Raises
    ------
    BudgetExceededError
        When the tables of prices would be too large.
    """
    multipliers = _multipliers(one)
    require_tables(ladder, one.top, 4 * multipliers.size)
    graph = (ladder.caps, ladder.rise, ladder.fall, costs(ladder, one), one.touch, multipliers)
    prices = (kernels.prices_of_prefixes(*graph), kernels.prices_of_suffixes(*graph))
    return kernels.windows(ladder.low, ladder.high, *prices, multipliers, heights, bound)


def require_tables(ladder: Ladder, top: int, tables: int) -> None:
    """Refuse an instance of which so many tables over (step, level) would be too large."""
    if tables * ladder.caps.size * (top + 1) > _MOST_PRICES:
        raise BudgetExceededError(f"{ladder.instance.id}: {ladder.caps.size - 1} steps × {top + 1} speeds are too many")


def costs(ladder: Ladder, one: Family) -> Ints:
    """Costs of steps at the levels that a family may use: (3, top + 1) int64."""
    return np.ascontiguousarray(ladder.cost[:, : one.top + 1])


def _multipliers(one: Family) -> Floats:
    scale = max(one.scale, abs(one.multiplier), 1e-3)
    around = [one.multiplier + sign * part * scale for part in _SPREAD for sign in (1, -1)]
    multipliers: NDArray[np.float64] = np.array([one.multiplier, *around])
    return multipliers
