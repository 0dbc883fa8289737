"""Plans of the demand model: an exact search by layers where it fits into a budget, a beam where it does not.

Speeds and distances of the demand model are real numbers, so that a dynamic program over a grid of them is a
heuristic. The exact search keeps true states instead. Layer k holds every different (speed, distance) that k steps can
lead to, with its least cost and how many plans reach it so; a state whose cost plus proved cost to go
(`tgvdp.solvers.exact.demand_bounds`) exceeds that of a known plan is dropped. If no layer outgrows the budget, the
best plan is optimal. Known plans come from a beam: the same layers, but only the cheapest state of each small box of
speed and distance survives.

Continuous demand is searched on 21 levels: nothing is proved then.
"""

import time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.formulations.problem.alstom import Floats
from tgvdp.formulations.problem.demand import demand_schedule, drive, slope_permil, step
from tgvdp.formulations.problem.instances import DemandInstance
from tgvdp.formulations.problem.replay import replay
from tgvdp.formulations.problem.schedule import Solution
from tgvdp.solvers.exact.demand_bounds import Bounds, demand_bounds
from tgvdp.units import counted

#: Plans that brute force tries, and states of one layer of the exact search and of the beam.
MOST_PLANS = 5_000_000
MOST_STATES = 1_000_000
BEAM_STATES = 60_000
#: Levels that stand for continuous demand.
_CONTINUOUS = np.linspace(-1.0, 1.0, 21)
#: Costs closer than this, relative, count as equal.
_SAME = 1e-12
_CHUNK = 200_000
#: Rounding that a bound may exceed the cost of a known plan by, relative.
_PRUNING = 1e-9
#: Doubles hold all whole numbers below: more plans are not counted.
_MOST_COUNTED = 1 << 53
#: A layer may be so many times too large before equal states are merged.
_OVERFLOW = 8


class _Layer(NamedTuple):
    """States after k steps: (n,) speeds, distances, least costs, numbers of plans; index of the parent, and level."""

    speed_mps: Floats
    distance_m: Floats
    cost_j: Floats
    plans: Floats
    parent: NDArray[np.int64]
    level: NDArray[np.int64]

    def kept(self, which: NDArray[Any] | slice) -> "_Layer":
        """Some of the states."""
        return _Layer(*(column[which] for column in self))  # type: ignore[arg-type]


class _Found(NamedTuple):
    """The last layer, those before it, and how many states there were."""

    layers: list[_Layer]
    states: int

    @property
    def last(self) -> _Layer:
        return self.layers[-1]

    def plan(self, state: int) -> NDArray[np.int64]:
        """Levels of the cheapest plan to a state of the last layer."""
        levels = []
        for layer in reversed(self.layers[1:]):
            levels.append(int(layer.level[state]))
            state = int(layer.parent[state])
        return np.array(levels[::-1], dtype=np.int64)


def solve_demand_dp(instance: DemandInstance) -> Solution:
    """Beam, then exact search by layers.

    Raises
    ------
    InfeasibleError
        When it is proved that no plan satisfies all constraints.
    BudgetExceededError
        When neither found a plan.
    """
    started = time.perf_counter()
    levels = _CONTINUOUS if instance.levels is None else np.array(instance.levels)
    bounds = demand_bounds(instance, levels)
    start = bounds.cost_to_go(instance, 0, np.zeros(1), np.zeros(1))[0]
    if not np.isfinite(start) and instance.levels is not None:
        raise InfeasibleError(
            f"{instance.id}: no plan reaches {instance.distance_m:g} m in {counted(instance.steps, 'step')}"
        )
    beam = _search(instance, levels, bounds, np.inf, BEAM_STATES, boxes=True)
    known = float(beam.last.cost_j.min(initial=np.inf)) if beam else np.inf
    exact = None
    if instance.levels is not None:
        exact = _search(instance, levels, bounds, known, MOST_STATES, boxes=False)
        if exact and not exact.last.cost_j.size:
            raise InfeasibleError(f"{instance.id}: none of the plans satisfies all constraints")
    found = exact or beam
    if not found or not found.last.cost_j.size:
        raise BudgetExceededError(f"{instance.id}: no plan found with {BEAM_STATES} states per step")
    cost = found.last.cost_j
    best = int(np.argmin(cost))
    schedule = demand_schedule(instance, levels[found.plan(best)])
    same = cost <= cost[best] + _SAME * abs(cost[best])
    count = found.last.plans[same].sum()
    elapsed_s = time.perf_counter() - started
    return Solution(
        solver="dp",
        schedule=schedule,
        optimal=exact is not None,
        n_optimal=int(count) if exact is not None and count < _MOST_COUNTED else None,
        replay=replay(instance, schedule),
        elapsed_s=elapsed_s,
        details={
            "bound": float(start) if instance.levels is not None else None,
            "method": "exact search by layers" if exact is not None else "beam",
            "states": found.states,
        },
    )


def solve_demand_brute(instance: DemandInstance) -> Solution:
    """All plans of a small instance, without bounds or merging.

    Raises
    ------
    InputError
        When demand is continuous, or there are more than `MOST_PLANS` plans.
    InfeasibleError
        When no plan satisfies all constraints.
    """
    if instance.levels is None:
        raise InputError(f"{instance.id}: brute force needs notches, not continuous demand")
    started = time.perf_counter()
    levels = np.array(instance.levels)
    total = levels.size**instance.steps
    if total > MOST_PLANS:
        raise InputError(f"{instance.id}: {total} plans are too many for brute force (at most {MOST_PLANS})")
    powers = levels.size ** np.arange(instance.steps, dtype=np.int64)
    best_cost, best_plan, count = np.inf, None, 0
    for first in range(0, total, _CHUNK):
        plans = np.arange(first, min(first + _CHUNK, total))[:, None] // powers % levels.size
        motion = drive(instance, levels[plans])
        fits = _fits(instance, motion.speed_mps[:, -1], motion.distance_m)
        fits &= motion.speed_mps.max(axis=1) <= instance.vmax_mps * (1.0 + 1e-9)
        cost = np.where(fits, motion.cost_j, np.inf)
        least = float(cost.min())
        if least < best_cost - _SAME * abs(best_cost) or (best_plan is None and least < np.inf):
            best_cost, best_plan, count = least, plans[int(np.argmin(cost))], 0
        if least < np.inf:
            count += int(np.count_nonzero(cost <= best_cost + _SAME * abs(best_cost)))
    if best_plan is None:
        raise InfeasibleError(f"{instance.id}: none of the {total} plans satisfies all constraints")
    schedule = demand_schedule(instance, levels[best_plan])
    elapsed_s = time.perf_counter() - started
    return Solution("brute", schedule, True, count, replay(instance, schedule), elapsed_s, details={"plans": total})


def _fits(instance: DemandInstance, speed_mps: Floats, distance_m: Floats) -> NDArray[np.bool_]:
    near = np.abs(distance_m - instance.distance_m) <= instance.tol_m + 1e-9 * instance.distance_m
    slow = speed_mps <= instance.end_speed_max_mps + 1e-9 * instance.vmax_mps
    fits: NDArray[np.bool_] = near & slow
    return fits


def _search(
    instance: DemandInstance, levels: Floats, bounds: Bounds, known_j: float, most: int, *, boxes: bool
) -> _Found | None:
    """Go through the layers; None where one outgrows ``most`` states (never with ``boxes``, which thin it out).

    The last layer holds the states that satisfy all constraints, perhaps none.
    """
    zero = np.zeros(1)
    nowhere = np.zeros(1, dtype=np.int64)
    layers = [_Layer(zero, zero, zero, np.ones(1), nowhere, nowhere)]
    states = 1
    for k in range(1, instance.steps + 1):
        parts = []
        for first in range(0, layers[-1].cost_j.size, _CHUNK):
            parts.append(_expanded(instance, levels, bounds, known_j, k, layers[-1], first))
            if not boxes and sum(part.cost_j.size for part in parts) > _OVERFLOW * most:
                return None
        layer = _merged(_Layer._make(map(np.concatenate, zip(*parts, strict=True)))) if parts else layers[-1]
        if boxes and layer.cost_j.size > most:
            layer = _thinned(instance, layer, most)
        if layer.cost_j.size > most:
            return None
        states += layer.cost_j.size
        layers.append(layer)
    last = layers[-1]
    layers[-1] = last.kept(_fits(instance, last.speed_mps, last.distance_m))
    return _Found(layers, states)


def _expanded(
    instance: DemandInstance, levels: Floats, bounds: Bounds, known_j: float, k: int, layer: _Layer, first: int
) -> _Layer:
    """All steps from some states of a layer that may still become a plan no dearer than the known one."""
    part = layer.kept(slice(first, first + _CHUNK))
    done = step(instance, part.speed_mps[:, None], levels, slope_permil(instance, part.distance_m)[:, None])
    speed, count = done.speed_mps.ravel(), levels.size
    distance = np.repeat(part.distance_m, count) + done.distance_m.ravel()
    cost = np.repeat(part.cost_j, count) + done.cost_j.ravel()
    parent = np.repeat(np.arange(first, first + part.cost_j.size), count)
    all_steps = _Layer(
        speed, distance, cost, np.repeat(part.plans, count), parent, np.tile(np.arange(count), part.cost_j.size)
    )
    slow = all_steps.kept(speed <= instance.vmax_mps * (1.0 + 1e-9))
    total = slow.cost_j + bounds.cost_to_go(instance, k, slow.speed_mps, slow.distance_m)
    return slow.kept((total <= known_j + _PRUNING * abs(known_j)) & np.isfinite(total))


def _merged(layer: _Layer) -> _Layer:
    """One state for each different (speed, distance): the cheapest, with the plans of all that cost the same."""
    order = np.lexsort((layer.cost_j, layer.distance_m, layer.speed_mps))
    layer = layer.kept(order)
    new = np.ones(order.size, dtype=np.bool_)
    new[1:] = (np.diff(layer.speed_mps) != 0.0) | (np.diff(layer.distance_m) != 0.0)
    group = np.cumsum(new) - 1
    least = layer.cost_j[new][group]
    same = layer.cost_j <= least + _SAME * np.abs(least)
    plans = np.bincount(group, layer.plans * same, minlength=int(new.sum())).astype(np.float64)
    return layer.kept(new)._replace(plans=plans)


def _thinned(instance: DemandInstance, layer: _Layer, most: int) -> _Layer:
    """The cheapest state of each box of speed and distance; boxes grow until few enough are left."""
    order = np.argsort(layer.cost_j, kind="stable")
    share = 1.0 / 4096
    while True:
        across = np.floor(layer.speed_mps[order] / (share * instance.vmax_mps)).astype(np.int64)
        along = np.floor(layer.distance_m[order] / (share * max(instance.distance_m, 1.0))).astype(np.int64)
        first = np.unique(across * (1 << 32) + along, return_index=True)[1]
        if first.size <= most:
            return layer.kept(order[np.sort(first)])
        share *= 2.0
