"""A local optimiser: dynamic programming in a window of squared speed around a run, at stations that stay.

At each station a few squared speeds around the run's are tried, and the cheapest chain of them by ``E + λ·T`` becomes
the new run, until none is cheaper; then the window shrinks. Between stations acceleration is constant. It finds no
other valley than the run's own, so a gain is a lower bound of what the run costs too much, and none proves nothing.

Nothing here or in `motion` is the package's but the model that is read. Where the two differ a little (a row that an
effort limit bends), a run and what is made of it are measured in the same way. New rows keep to the lower of the limits
at their ends wherever a limit steps between them.
"""

import math

import numpy as np
from numpy.typing import NDArray

from benchmarks.proof.motion import Floats, Laws, Road, current_at, effort_at, laws_of, look, measure, road_of, row
from tgvdp._jit import kernel, leaf
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile

#: Half widths of the windows, as shares of the largest squared speed, and speeds tried on each side.
_WIDTHS = 0.04 * 2.0 ** -np.arange(13.0)
_ASIDE = 2
#: Passes with one width at most, and the share of the cost that a pass must gain to be followed by another.
_MOST_PASSES, _LEAST_GAIN = 60, 1e-7
#: Rows that no limit binds are cut so that the trip has at least so many.
_ROWS = 600
#: Share of a limit above which a row counts as bound by it: it stays whole, because its parts would break it.
_BOUND = 0.97
#: Attempts to have one run on either side of the time, the first change of the price between them, and halvings between
#: the two runs.
_ATTEMPTS, _STEP, _HALVINGS = 8, 0.01, 30
#: Least price of time that is tried, as a share of energy over time.
_LEAST_PRICE = 1e-3
#: Least width of a window as a share of the widest, and the factor by which it recovers from row to row.
_LITTLE, _RECOVERY = 0.25, 1.25


@leaf
def _tried(road, shape, w, k, j, width):
    """Squared speed number j of a station's window, −1 where there is none; number ``_ASIDE`` is the run's own."""
    if j == _ASIDE:
        return w[k]
    if k == 0 or k == w.shape[0] - 1:
        return -1.0
    width *= shape[k]
    tried = w[k] + (j - _ASIDE) * width
    top = road.top_w[k]
    if tried > top:  # the highest one that is not below the limit is the limit
        tried = top if tried - width < top else -1.0
    return tried if tried > 0.0 else -1.0


@kernel
def _pass(laws, road, shape, multiplier, w, width, seen, cost, source):
    """Move the run w, in place, to the cheapest chain of its window; returns the cost.

    ``seen`` (2, window, 8) and ``cost`` (2, window) float64, ``source`` (stations, window) int8 are room to work in.
    """
    last = w.shape[0] - 1
    cost[0, :] = math.inf
    cost[0, _ASIDE] = 0.0
    look(laws, w[0], seen[0, _ASIDE])
    for k in range(1, last + 1):
        here, back = k % 2, (k - 1) % 2
        d = road.x[k] - road.x[k - 1]
        for j in range(2 * _ASIDE + 1):
            cost[here, j] = math.inf
            tried = _tried(road, shape, w, k, j, width)
            if tried < 0.0:
                continue
            look(laws, tried, seen[here, j])
            for i in range(2 * _ASIDE + 1):
                if cost[back, i] == math.inf:
                    continue
                allowed, t, e = row(
                    laws, seen[back, i], seen[here, j], d, road.grade_n[k - 1], road.current[k - 1],
                    road.auxiliary[k - 1],
                )  # fmt: skip
                own = i == _ASIDE and j == _ASIDE
                total = cost[back, i] + e + multiplier * t
                if (allowed or own) and (total < cost[here, j] or (own and total == cost[here, j])):
                    cost[here, j] = total
                    source[k, j] = i
    j = _ASIDE
    for k in range(last, 0, -1):
        w[k] = _tried(road, shape, w, k, j, width)
        j = source[k, j]
    return cost[last % 2, _ASIDE]


class Polish:
    """A run at its stations, ready to be polished.

    Attributes
    ----------
    time_s, energy_j : float
        Of the run, measured as all that it is compared with.
    """

    def __init__(self, trip: Trip, profile: Profile) -> None:
        self._laws = laws_of(trip)
        x, w = profile.position_m, profile.speed_mps**2
        self.time_s, self.energy_j = measure(self._laws, road_of(trip, x), w)
        fine_x = _stations(trip, profile)
        self._w = np.interp(fine_x, x, w)
        self._road = road_of(trip, fine_x)
        self._shape = _spread(self._laws, self._road, self._w)

    def polished(self, multiplier_j_per_s: float) -> tuple[float, Floats, Floats]:
        """Find a cheaper run in the same time.

        Parameters
        ----------
        multiplier_j_per_s : float
            Price of time at this run; it changes until there are runs on both sides of its time, and a mean of them
            takes it.

        Returns
        -------
        gain_j : float
            Energy that it saves, J; 0 if none was found.
        x_m, w : (n,) float64
            Its rows: positions from the origin and squared speeds.
        """
        gain_j, best_w, w = 0.0, self._w, self._w.copy()
        price = max(multiplier_j_per_s, _LEAST_PRICE * abs(self.energy_j) / self.time_s)
        early = late = None  # the last runs on either side of the time: how late in s, price, w
        for attempt in range(_ATTEMPTS):
            for width in _WIDTHS * w.max():
                self._polish(price, width, w)
            late_s = measure(self._laws, self._road, w)[0] - self.time_s
            run = (late_s, price, w.copy())
            early, late = (run, late) if late_s <= 0.0 else (early, run)
            found_w = w
            if early is not None and late is not None:
                found_w = self._in_time(early[2], late[2])
            seconds, joules = measure(self._laws, self._road, found_w)
            if seconds <= self.time_s and self.energy_j - joules > gain_j:
                gain_j, best_w = self.energy_j - joules, found_w.copy()
            if early is not None and late is not None:
                break
            step = _STEP * 2.0**attempt
            price *= (1.0 + late_s / self.time_s) ** 3 * (1.0 + step if late_s > 0.0 else 1.0 / (1.0 + step))
        return gain_j, self._road.x - self._road.x[0], best_w

    def _in_time(self, early_w: Floats, late_w: Floats) -> Floats:
        """Mean of two runs that takes the time."""
        low, high = 0.0, 1.0
        for _ in range(_HALVINGS):
            share = 0.5 * (low + high)
            seconds, _ = measure(self._laws, self._road, early_w + share * (late_w - early_w))
            low, high = (share, high) if seconds <= self.time_s else (low, share)
        return np.asarray(early_w + low * (late_w - early_w))

    def _polish(self, price: float, width: float, w: Floats) -> None:
        """Make a run cheaper, in place."""
        window = 2 * _ASIDE + 1
        room = np.empty((2, window, 8)), np.empty((2, window)), np.zeros((len(w), window), dtype=np.int8)
        before = math.inf
        for _ in range(_MOST_PASSES):
            cost = _pass(self._laws, self._road, self._shape, price, w, width, *room)
            if not before - cost > _LEAST_GAIN * abs(cost):
                break
            before = cost


def _stations(trip: Trip, profile: Profile) -> Floats:
    """Ends of the profile's rows, and points within long ones that no limit binds."""
    x = profile.position_m
    parts = np.ceil(np.diff(x) / (trip.distance_m / _ROWS))
    parts[_bound_rows(trip.train, profile) | (current_at(trip.track, 0.5 * (x[1:] + x[:-1])) == 0.0)] = 1.0
    pieces = [np.linspace(a, b, int(n), endpoint=False) for a, b, n in zip(x, x[1:], parts, strict=False)]
    return np.concatenate([*pieces, x[-1:]])


def _bound_rows(train: Train, profile: Profile) -> NDArray[np.bool_]:
    """Rows that a limit of effort or acceleration binds, or nearly."""
    v, effort = 0.5 * (profile.speed_mps[1:] + profile.speed_mps[:-1]), profile.force_n[:-1]
    acceleration = np.diff(profile.speed_mps**2) / (2.0 * np.diff(profile.position_m))
    pull = np.array([train.traction.effort_n(one) for one in v])
    brake = np.array([train.braking.effort_n(one) for one in v]) + train.friction_brake_n
    least = min([train.max_deceleration_mps2, *(row.deceleration_mps2 for row in train.braking_rates)])
    bound = (effort > _BOUND * pull) | (acceleration > _BOUND * train.max_acceleration_mps2)
    return np.asarray(bound | (effort < -_BOUND * brake) | (-acceleration > _BOUND * least))


def _spread(laws: Laws, road: Road, w: Floats) -> Floats:
    """How a small change of w spreads along a run on which neither traction nor brakes answer it.

    Windows of this shape hold neighbours that coast where the run coasts and pull in full where it does. On other rows
    it recovers.
    """
    length_m = np.diff(road.x)
    v = np.sqrt(np.maximum(0.5 * (w[1:] + w[:-1]), 1e-6 * w.max()))
    load = road.grade_n + laws.davis_a + v * (laws.davis_b + v * laws.davis_c)
    effort = 0.5 * laws.inertia_kg * np.diff(w) / length_m + load
    pull, more = (np.array([effort_at(laws.traction, one) for one in speeds]) for speeds in (v, 1.001 * v))
    falls = np.clip((more - pull) / (1.001**2 - 1.0), -pull, 0.0) / v**2
    slope = np.where(effort > _BOUND * pull, falls, 0.0) - laws.davis_c - 0.5 * laws.davis_b / v
    free = (effort > _BOUND * pull) | (np.abs(effort) < (1.0 - _BOUND) * pull)
    factors = np.where(free, np.exp(2.0 * slope * length_m / laws.inertia_kg), _RECOVERY)
    shape = np.ones_like(w)
    for k, factor in enumerate(factors):
        shape[k + 1] = min(max(shape[k] * factor, _LITTLE), 1.0)
    return shape
