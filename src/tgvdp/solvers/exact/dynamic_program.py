"""Exact dynamic program over (step, speed, distance): optimum, one solution, and the number of optimal solutions.

1. Bound. A Lagrangian lower bound L needs only (step, speed) (`tgvdp.solvers.exact.lagrange`).
2. Guess. All plans of cost ≤ L + gap live in windows of distance, one per (step, speed), that the bounds of prefixes
   and suffixes under several multipliers leave. The windows are filled backwards (`tgvdp.solvers.exact.ladder`).
3. If the cheapest plan found costs no more than the guess, it is optimal and all optimal plans lie in the windows;
   otherwise the gap grows, but not beyond what was found. When the guess reaches the dearest plan there is, no window
   leaves anything out.

Where the windows of all plans are large, plans are split into families by top speed, and each is treated apart.
Costs are whole numbers (`tgvdp.formulations.problem.levels`), so optima, ties and counts are exact.
"""

import functools
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import BudgetExceededError, InfeasibleError
from tgvdp.formulations.problem.instances import BinaryInstance
from tgvdp.formulations.problem.levels import Ladder
from tgvdp.solvers.exact import ladder as kernels
from tgvdp.solvers.exact import ladder_paths as paths
from tgvdp.solvers.exact.ladder import Ints
from tgvdp.solvers.exact.lagrange import Family, cheapest, costs, family, halves, require_tables, windows
from tgvdp.units import counted

#: States of one run of the dynamic program; each takes a byte.
MOST_STATES = 500_000_000
#: Families are split where the windows hold more states than this: below, filling them takes less time.
_SPLIT_ABOVE = 4_000_000
#: Growth of the gap, and its first value as a part of the range of all costs.
_GROWTH = 2
_FIRST_GAPS = 1 << 14


#: Lowest heights, starts of windows, cheapest moves, rise, fall, level to touch.
_Walk: TypeAlias = tuple[Ints, Ints, NDArray[np.uint8], int, int, int]


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

    levels: Ints
    cost: int
    n_optimal: int
    states: int
    bound: float


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
    dearest = -cheapest(ladder, 0, ladder.top, 0.0, -1)[0]
    families = [family(ladder, 0, ladder.top)]
    concave = bool((np.diff(ladder.cost[1], 2) < 0).any())
    gap, known = 0, dearest
    while families:
        least = min(families).bound
        slack = 0.5 + 1e-12 * max(abs(least), abs(dearest))
        lowest = _next_cost(ladder, least - slack)
        guess = min(lowest + gap, known)
        found, families = _solve_families(ladder, families, heights, guess, slack, most_states, concave)
        if found is None:  # bounds are better now: nothing costs less than they say, nor than what was tried
            gap = max(0, guess - _next_cost(ladder, min(families).bound - slack)) if families else 0
            continue
        if found.cost <= guess:
            path = paths.one_path(*found.walks[0])
            return Optimum(path, found.cost, sum(map(_count, found.walks)), found.states, least)
        if guess == dearest:
            break
        known = min(known, found.cost)
        gap = max(gap * _GROWTH, ladder.quantum, (dearest - guess) // _FIRST_GAPS)
    raise _infeasible(ladder)


class _Solved(NamedTuple):
    """Least cost over some families, the walks of those that reach it, and the states that it took."""

    cost: int
    walks: list[_Walk]
    states: int


def _solve_families(
    ladder: Ladder,
    families: list[Family],
    heights: Ints,
    guess: int,
    slack: float,
    most_states: int,
    concave: bool,
) -> tuple[_Solved | None, list[Family]]:
    """Fill the windows of all families whose bound is no more than the guess or what others found, best bound first.

    A family with too many states is split. Returns what was found, and the families that there are now; nothing was
    looked for where the one of the least bound was split.
    """
    best, walks, states = int(kernels.NEVER), list[_Walk](), 0
    waiting, treated = sorted(families), list[Family]()
    while waiting and waiting[0].bound <= min(guess, best) + slack:
        one = waiting[0]
        table = _table(ladder, one, heights, min(guess, best) + slack)
        if concave and table.states > _SPLIT_ABOVE and one.touch < one.top:
            if not treated:
                return None, _split(ladder, waiting, one)
            waiting = sorted([*waiting[1:], *halves(ladder, one)])
            continue
        if table.states > most_states:
            least = ladder.objective(_next_cost(ladder, min(families).bound - slack))
            raise BudgetExceededError(
                f"{ladder.instance.id}: needs {table.states} states (step, speed, distance), and may keep "
                f"{most_states}; the objective is at least {least:.9g}"
            )
        treated.append(waiting.pop(0))
        states += table.states
        cost, walk = _filled(ladder, table)
        if cost <= best:
            walks = [*walks, walk] if cost == best else [walk]
            best = cost
    return _Solved(best, walks, states), [*treated, *waiting]


class _Table(NamedTuple):
    """Windows of a family, and where each starts in one array of all its states."""

    family: Family
    low: Ints
    high: Ints
    start: Ints

    @property
    def states(self) -> int:
        return int(self.start[-1, -1])


def _table(ladder: Ladder, one: Family, heights: Ints, bound: float) -> _Table:
    low, high = windows(ladder, one, heights, bound)
    width = np.maximum(0, high - low + 1)
    end = np.cumsum(width).reshape(width.shape)
    return _Table(one, low, high, np.hstack((end[:, :1] - width[:, :1], end)))


def _filled(ladder: Ladder, table: _Table) -> tuple[int, "_Walk"]:
    """Cost of the cheapest plan in the windows of a family, and what is needed to walk over all of them."""
    one, low, high, start = table
    moves = np.empty(table.states, dtype=np.uint8)
    graph = (ladder.low, ladder.high, ladder.rise, ladder.fall, costs(ladder, one), one.touch)
    cost = int(kernels.cheapest_moves(low, high, start, *graph, moves))
    return cost, (low, start, moves, ladder.rise, ladder.fall, one.touch)


def _next_cost(ladder: Ladder, bound: float) -> int:
    """The least cost that a plan may have above a bound."""
    return ladder.quantum * int(np.ceil(bound / ladder.quantum))


def _split(ladder: Ladder, families: list[Family], wide: Family) -> list[Family]:
    """Halve a family, and then those of the least bound until that is one of a single top speed."""
    families = [*(one for one in families if one != wide), *halves(ladder, wide)]
    while families:
        least = min(families)
        if least.touch == least.top:
            break
        families.remove(least)
        families += halves(ladder, least)
    return families


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


def _heights(ladder: Ladder) -> Ints:
    require_tables(ladder, ladder.top, 4)
    least, most = (
        kernels.heights_of_suffixes(ladder.caps, ladder.rise, ladder.fall, ladder.top, sign) for sign in (1, -1)
    )
    if ladder.low > ladder.high or least[0, 0] > ladder.high or most[0, 0] < ladder.low:
        raise _infeasible(ladder)
    return np.stack((least, most))


def _infeasible(ladder: Ladder) -> InfeasibleError:
    instance = ladder.instance
    return InfeasibleError(
        f"{instance.id}: no plan of {counted(instance.steps, 'step')} covers {instance.distance_units:g} "
        f"± {instance.tol_units:g} Δv·Δt from stop to stop within the speed limits"
    )


def _count(walk: _Walk) -> int:
    rough = float(paths.roughly_count(*walk))
    most_bits = 1.585 * walk[0].shape[0] if np.isinf(rough) else np.log2(rough) + 1.0
    limbs = paths.count(*walk, int(most_bits // kernels.LIMB_BITS) + 1)
    return sum(int(limb) << (kernels.LIMB_BITS * position) for position, limb in enumerate(limbs))
