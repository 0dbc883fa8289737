"""A price of energy in each step, which takes the trains of a substation apart and bounds what they need together.

As max(0, x) ≥ π·x for 0 ≤ π ≤ 1, and x ≤ P may be priced by μ ≥ 0, with w = π + μ

    Σ_i n_i ≥ Σ_k min over plans of train k of Σ_i w_i·(q·drawn_ki − p·offered_ki) − Σ_i max(0, w_i − 1)·q·P

for any w ≥ 0: every train is alone again, and pays w_i in step i. The bound is concave in w; it is raised by
subgradients, with steps by Polyak's rule (1987) towards a plan that is known. Prices are whole multiples of 1/`SCALE`,
so that bounds are whole numbers too, and the table of every train tells what remains from each of its states.
"""

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tgvdp.formulations.problem.instances import SharedTrip, SubstationInstance
from tgvdp.formulations.problem.substation import shares

Ints: TypeAlias = NDArray[np.int64]

#: Prices are whole multiples of 1/SCALE.
SCALE = 256
#: Above every cost, and safe to add some to.
NEVER = np.int64(1) << np.int64(58)
_ROUNDS = 300
#: Polyak's factor at first, and after how many rounds without progress it is halved.
_FACTOR, _PATIENCE = 1.0, 10


class Train(NamedTuple):
    """One train and its states, v·(D + 1) + d of the speed and the distance so far.

    Attributes
    ----------
    train : SharedTrip
    width : int
        D + 1.
    levels : int
        Number of speeds, 0 among them.
    """

    train: SharedTrip
    width: int
    levels: int

    @property
    def size(self) -> int:
        """Number of states."""
        return self.levels * self.width

    @property
    def drawn(self) -> Ints:
        """What accelerating draws from each speed: (levels,) int64."""
        return self.train.mass_units * (2 * np.arange(self.levels) + 1)

    @property
    def offered(self) -> Ints:
        """What braking offers from each speed: (levels,) int64."""
        return self.train.mass_units * (2 * np.arange(self.levels) - 1)

    def own_step(self, step: int) -> int:
        """Its own clock at a step of the substation's: 0 before it starts, N when it has arrived."""
        return min(max(step - self.train.start, 0), self.train.trip.steps)


class Bound(NamedTuple):
    """What prices prove.

    Attributes
    ----------
    prices : (steps,) int64
        w·SCALE.
    tables : tuple of (N_k+1, size) int64
        What each state of each train still pays at least, times SCALE; `NEVER` and more where the train cannot come
        home.
    rent : (steps+1,) int64
        Σ max(0, w − 1)·q·P of this step and all later ones, times SCALE.
    total : int
        Lower bound of q·Σ n_i.
    """

    prices: Ints
    tables: tuple[Ints, ...]
    rent: Ints
    total: int


def train_of(train: SharedTrip) -> Train:
    """Count the states of a train."""
    distance, top = train.trip.distance_range[1], max((*train.trip.cap_units[:-1], 0))
    return Train(train, distance + 1, top + 1)


def bound_of(instance: SubstationInstance, trains: list[Train], prices: Ints) -> Bound:
    """The bound of given prices."""
    tables = tuple(costs_to_go(one, priced(instance, one, prices)).reshape(-1, one.size) for one in trains)
    q = shares(instance).q
    rent = np.append(np.cumsum((np.maximum(prices - SCALE, 0) * q * instance.power_units)[::-1])[::-1], 0)
    total = sum(int(table[0, 0]) for table in tables) - int(rent[0])
    return Bound(prices, tables, rent, max(0, -(-total // SCALE)))


def raised_bound(instance: SubstationInstance, trains: list[Train], start: Bound, known: int) -> Bound:
    """Raise a bound towards the cost of a known plan.

    Parameters
    ----------
    start : Bound
    known : int
        q·Σ n_i of some plan of all trains.
    """
    best = bound = start
    exact, factor, idle = best.prices.astype(np.float64), _FACTOR, 0
    for _ in range(_ROUNDS):
        slope = _slope(instance, trains, bound)
        size = float(slope @ slope)
        if not size or best.total >= known:
            break
        exact = np.maximum(0.0, exact + SCALE * factor * (known - bound.total) / size * slope)
        bound = bound_of(instance, trains, np.rint(exact).astype(np.int64))
        idle += 1
        if bound.total > best.total:
            best, idle = bound, 0
        elif idle >= _PATIENCE:
            factor, idle, exact, bound = 0.5 * factor, 0, best.prices.astype(np.float64), best
    return best


def priced(instance: SubstationInstance, one: Train, prices: Ints) -> Ints:
    """Cost (N, 3, levels) of braking, holding and accelerating from each speed at given prices."""
    own = prices[one.train.start : one.train.start + one.train.trip.steps, None]
    p, q = shares(instance)
    cost = np.zeros((one.train.trip.steps, 3, one.levels), dtype=np.int64)
    cost[:, 0], cost[:, 2] = -p * own * one.offered, q * own * one.drawn
    return cost


def costs_to_go(one: Train, cost: Ints) -> Ints:
    """Least cost of one train from every own step, speed and distance to its end, backwards.

    Parameters
    ----------
    cost : (N, 3, levels) int64
        Of braking, holding and accelerating in each own step from each speed.

    Returns
    -------
    (N+1, levels, D+1) int64
        `NEVER` where the train cannot come home, and above the limit of a step, from where it might.
    """
    trip = one.train.trip
    v = np.arange(one.levels)[:, None]
    d = np.arange(one.width)[None, :]
    left = np.full((trip.steps + 1, one.levels, one.width), NEVER)
    left[trip.steps, 0, -1] = 0
    for i in range(trip.steps - 1, -1, -1):
        for u in (-1, 0, 1):
            # The distance of a plan is Σ v_k over k = 1..N: what is covered is whole after each step.
            w, e = v + u, d + v + u
            inside = (w >= 0) & (w < one.levels) & (e < one.width)
            after = left[i + 1, np.clip(w, 0, one.levels - 1), np.clip(e, 0, one.width - 1)]
            pay = np.where(inside & (after < NEVER), cost[i, u + 1][:, None] + after, NEVER)
            np.minimum(left[i], pay, out=left[i])
        if i:
            left[i, trip.cap_units[i - 1] + 1 :] = NEVER
    return left


def cheapest_speeds(one: Train, cost: Ints, left: Ints) -> Ints:
    """Speeds (N+1,) in Δv of a cheapest plan of one train, by `costs_to_go` of the same costs."""
    speeds = np.zeros(one.train.trip.steps + 1, dtype=np.int64)
    at = gone = 0
    for i in range(one.train.trip.steps):
        for u in (-1, 0, 1):
            to, there = at + u, gone + at + u
            reached = 0 <= to < one.levels and there < one.width
            if reached and cost[i, u + 1, at] + left[i + 1, to, there] == left[i, at, gone]:
                at, gone = to, there
                break
        speeds[i + 1] = at
    return speeds


def _slope(instance: SubstationInstance, trains: list[Train], bound: Bound) -> NDArray[np.float64]:
    """Subgradient in the prices: what a cheapest plan of every train draws less what it offers, less P where w > 1."""
    p, q = shares(instance)
    slope = np.where(bound.prices > SCALE, -float(q * instance.power_units), 0.0)
    for one, table in zip(trains, bound.tables, strict=True):
        left = table.reshape(-1, one.levels, one.width)
        v = cheapest_speeds(one, priced(instance, one, bound.prices), left)
        gained = one.train.mass_units * np.diff(v * v)
        slope[one.train.start : one.train.start + gained.size] += np.where(gained > 0, q, p) * gained
    return slope
