"""Exact dynamic program of the trains of a substation: its states are (step; speed and distance of every train).

Layer by layer, every state is expanded by the actions of all trains at once, equal states are merged, and a state is
dropped when some train cannot come home from it, when a step would draw more than the limit, or when its cost and a
proved bound of what follows (`tgvdp.solvers.exact.joint_prices`) exceed a plan that a descent
(`tgvdp.solvers.exact.joint_descent`) or a beam found before. Nothing tames the product of the trains' states: that is
what makes this family hard, and where a layer outgrows the budget nothing is proved.
"""

import itertools
import math
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import BudgetExceededError, InfeasibleError
from tgvdp.formulations.problem.instances import SubstationInstance
from tgvdp.formulations.problem.substation import delivered, joint_speeds, shares
from tgvdp.solvers.exact.joint_descent import descend
from tgvdp.solvers.exact.joint_prices import NEVER, SCALE, Bound, Train, bound_of, raised_bound, train_of

Ints: TypeAlias = NDArray[np.int64]

#: States of one layer; with their ancestors they take some hundred bytes each while they are made.
MOST_STATES = 1_000_000
#: Joint actions of a step, each of which is tried on all states at once: those of eight trains take a second a layer.
_MOST_ACTIONS = 3**8
#: Width of the beam whose plan bounds the search.
BEAM = 2_000
#: Passes of looking for a plan, and raising the bound towards it.
_PASSES = 2
#: While no plan is known, one is guessed to cost this part more than the bound.
_GUESS = 10


@dataclass(frozen=True)
class JointPlan:
    """What was found.

    Attributes
    ----------
    speeds : tuple of (N_k + 1,) int64
        Of each train, in Δv.
    cost : int
        q·Σ n_i.
    n_optimal : int or None
        Number of plans of that cost; None where nothing is proved, or they are too many to count in 64 bits.
    proved : bool
    states : int
        Of all layers of the last search.
    bound : int
        Proved lower bound of q·Σ n_i.
    """

    speeds: tuple[Ints, ...]
    cost: int
    n_optimal: int | None
    proved: bool
    states: int
    bound: int


class _Layer(NamedTuple):
    """States between two steps, sorted by key.

    Attributes
    ----------
    states : (K, n) int64
    cost, parent : (n,) int64
    paths : (n,) float64
        Number of cheapest paths.
    """

    states: Ints
    cost: Ints
    parent: Ints
    paths: NDArray[np.float64]


def joint_plan(instance: SubstationInstance, most_states: int = MOST_STATES) -> JointPlan:
    """Find the cheapest plan of all trains, and prove it where no layer outgrows the budget.

    Raises
    ------
    InfeasibleError
        When no plan of all trains obeys all constraints.
    BudgetExceededError
        When the budget ends without a plan.
    """
    trains = [train_of(train) for train in instance.trains]
    bound = bound_of(instance, trains, np.full(instance.steps, SCALE // 2))
    for number, table in enumerate(bound.tables, start=1):
        if table[0, 0] >= NEVER:
            raise InfeasibleError(f"{instance.id}: train {number} alone cannot cover its distance in its time")
    bound, plan = _first_plan(instance, trains, bound)
    known = None if plan is None else _cost(instance, plan)
    layers, complete = _search(instance, trains, bound, known, most_states, beam=False)
    if not complete:
        if plan is None:
            raise BudgetExceededError(
                f"{instance.id}: a layer has more than {most_states} states or {_MOST_ACTIONS} joint actions, and no"
                " plan was found"
            )
        return JointPlan(tuple(plan), _cost(instance, plan), None, False, 0, bound.total)
    if layers is None:
        raise InfeasibleError(f"{instance.id}: no plan of all trains obeys all constraints")
    last = layers[-1]
    cost, count = int(last.cost[0]), float(last.paths[0])
    states = sum(layer.cost.size for layer in layers)
    # Doubles are whole below 2⁵³.
    return JointPlan(
        tuple(_speeds(instance, trains, layers)), cost, int(count) if count < 2.0**53 else None, True, states, cost
    )


def _first_plan(instance: SubstationInstance, trains: list[Train], bound: Bound) -> tuple[Bound, list[Ints] | None]:
    """A cheap plan, or none, and a bound that was raised towards its cost."""
    best: list[Ints] | None = None
    for _ in range(_PASSES):
        for plan in (descend(instance, trains, bound.prices), _beam_plan(instance, trains, bound, best)):
            if plan is not None and (best is None or _cost(instance, plan) < _cost(instance, best)):
                best = plan
        target = bound.total + bound.total // _GUESS + 1 if best is None else _cost(instance, best)
        bound = raised_bound(instance, trains, bound, target)
    return bound, best


def _beam_plan(
    instance: SubstationInstance, trains: list[Train], bound: Bound, best: list[Ints] | None
) -> list[Ints] | None:
    """What is left of the search when each layer keeps its most promising states."""
    layers, _ = _search(instance, trains, bound, None if best is None else _cost(instance, best), BEAM)
    return None if layers is None else _speeds(instance, trains, layers)


def _cost(instance: SubstationInstance, plan: list[Ints]) -> int:
    return int(delivered(instance, joint_speeds(instance, plan)).sum())


def _to_go(trains: list[Train], bound: Bound, step: int, states: Ints) -> Ints:
    """What remains from a step on at least, times SCALE and perhaps below 0; `NEVER` where a train cannot come home."""
    total = np.zeros(states.shape[1], dtype=np.int64)
    lost = np.zeros(states.shape[1], dtype=bool)
    for one, table, state in zip(trains, bound.tables, states, strict=True):
        left = table[one.own_step(step), state]
        lost |= left >= NEVER
        total += np.where(lost, 0, left)
    return np.where(lost, NEVER, total - bound.rent[step])


def _search(
    instance: SubstationInstance, trains: list[Train], bound: Bound, known: int | None, most: int, *, beam: bool = True
) -> tuple[list[_Layer] | None, bool]:
    """All layers, or None where the last stays empty; False where the budget ended the search.

    Parameters
    ----------
    known : int, optional
        Cost above which nothing is looked for.
    most : int
        States of a layer. With ``beam`` the most promising ones are kept, without it the search ends. It ends where
        trains have too many joint actions.
    """
    one = np.zeros(1, dtype=np.int64)
    layers = [_Layer(np.zeros((len(trains), 1), dtype=np.int64), one, one, np.ones(1))]
    for step in range(instance.steps):
        moving = [_actions(one, step) for one in trains]
        if math.prod(map(len, moving)) > _MOST_ACTIONS:
            return None, False
        layer = _expanded(instance, trains, bound, step, moving, layers[-1], known)
        if not layer.cost.size:
            return None, True
        if layer.cost.size > most:
            if not beam:
                return None, False
            rank = SCALE * layer.cost + _to_go(trains, bound, step + 1, layer.states)
            kept = np.sort(np.argpartition(rank, most)[:most])
            layer = _Layer(layer.states[:, kept], layer.cost[kept], layer.parent[kept], layer.paths[kept])
        layers.append(layer)
    return layers, True


def _actions(one: Train, step: int) -> tuple[int, ...]:
    """What a train may do in a step: change its speed where it is on its way."""
    return (-1, 0, 1) if 0 <= step - one.train.start < one.train.trip.steps else (0,)


def _expanded(
    instance: SubstationInstance,
    trains: list[Train],
    bound: Bound,
    step: int,
    moving: list[tuple[int, ...]],
    layer: _Layer,
    known: int | None,
) -> _Layer:
    """The next layer: all actions of all trains."""
    p, q = shares(instance)
    parts = []
    for actions in itertools.product(*moving):
        drawn = np.zeros(layer.cost.size, dtype=np.int64)
        offered = np.zeros_like(drawn)
        alive = np.ones(layer.cost.size, dtype=bool)
        states = np.empty_like(layer.states)
        for row, one, u, moves, state in zip(states, trains, actions, moving, layer.states, strict=True):
            if len(moves) == 1:
                row[:] = state
                continue
            v, d = state // one.width, state % one.width
            w = v + u
            # Within the tables; whether the train can come home from there is in the bound.
            alive &= (w >= 0) & (w < one.levels) & (d + w < one.width)
            row[:] = w * one.width + d + w
            gained = one.train.mass_units * (w * w - v * v)
            if u > 0:
                drawn += gained
            elif u < 0:
                offered -= gained
        net = np.maximum(q * drawn - p * offered, 0)
        alive &= net <= q * instance.power_units
        kept = np.flatnonzero(alive)
        cost = layer.cost[kept] + net[kept]
        states = states[:, kept]
        left = _to_go(trains, bound, step + 1, states)
        good = left < NEVER
        if known is not None:
            good &= SCALE * cost + np.maximum(left, 0) <= SCALE * known
        parts.append((states[:, good], cost[good], kept[good], layer.paths[kept[good]]))
    states = np.concatenate([part[0] for part in parts], axis=1)
    cost, parent, count = (np.concatenate([part[i] for part in parts]) for i in (1, 2, 3))
    return _merged(trains, _Layer(states, cost, parent, count))


def _merged(trains: list[Train], layer: _Layer) -> _Layer:
    """Each state once, with its least cost and the number of paths of that cost."""
    if not layer.cost.size:
        return layer
    keys = _keys(trains, layer.states)
    order = np.lexsort((layer.cost, *keys))
    new = np.zeros(order.size, dtype=bool)
    for key in keys:
        new |= np.diff(key[order], prepend=-1) != 0
    first = np.flatnonzero(new)
    chosen = order[first]
    least = np.repeat(layer.cost[chosen], np.diff(np.append(first, order.size)))
    count = np.add.reduceat(np.where(layer.cost[order] == least, layer.paths[order], 0.0), first)
    return _Layer(layer.states[:, chosen], layer.cost[chosen], layer.parent[chosen], count)


def _keys(trains: list[Train], states: Ints) -> list[Ints]:
    """Numbers that tell states apart, of as many trains in one as 64 bits hold."""
    keys, room = [np.zeros(states.shape[1], dtype=np.int64)], 1
    for one, state in zip(trains, states, strict=True):
        if room * one.size >= 1 << 62:
            keys.append(np.zeros(states.shape[1], dtype=np.int64))
            room = 1
        keys[-1] = keys[-1] * one.size + state
        room *= one.size
    return keys


def _speeds(instance: SubstationInstance, trains: list[Train], layers: list[_Layer]) -> list[Ints]:
    """Speeds of one cheapest plan, backwards through the parents."""
    table = np.zeros((len(trains), instance.steps + 1), dtype=np.int64)
    at = 0
    for step in range(instance.steps, 0, -1):
        layer = layers[step]
        table[:, step] = [state // one.width for state, one in zip(layer.states[:, at], trains, strict=True)]
        at = int(layer.parent[at])
    return [
        row[one.train.start : one.train.start + one.train.trip.steps + 1]
        for row, one in zip(table, trains, strict=True)
    ]
