"""The optimal run on level track between two stops, by quadrature: no cells, no stations, no speed grid.

Minimise J = E + λT. With V(K) the cost to go by kinetic energy K and p = dV/dK, the Hamiltonian per metre

    H = F⁺ + λ/v + p·(F − R(v) − B)

is linear in the efforts, so that F is full for p < −1, anything for p = −1, none for −1 < p, and the train brakes for
p > 0. The line is level and uniform: H is constant along the run. Where p = −1, H = R(v) + λ/v whatever F is, so that

  - holding is stationary where d/dv (R + λ/v) = 0, at the speed V with V²·R'(V) = λ, or at the speed limit below it;
  - coasting begins at p = −1, at the top speed W ≤ V, so H = R(W) + λ/W;
  - coasting, where λ/v − p·R = H, ends at p = 0, at the speed U = λ/H (Howlett & Pudney 1995, ch. 3).

If traction up to V, coasting and braking are longer than the line, there is no holding and W < V fits the length.
"""

import itertools
import math
from dataclasses import dataclass

from scipy.integrate import quad
from scipy.optimize import brentq

from .running import brake_n, breaks_of


@dataclass(frozen=True)
class Run:
    """The optimal run for one multiplier."""

    duration_s: float
    energy_j: float
    top_mps: float
    brake_from_mps: float
    hold_m: float


def _integrals(train, net, v0, v1, breaks):
    """Distance, duration and effort work from v0 to v1 with net force net(v), and effort = net + resistance."""
    edges = sorted({v0, v1, *(v for v in breaks if min(v0, v1) < v < max(v0, v1))}, reverse=v1 < v0)
    parts = [0.0, 0.0]
    for a, b in itertools.pairwise(edges):
        for i, function in enumerate((lambda v: v / net(v), lambda v: 1.0 / net(v))):
            parts[i] += train.inertia_kg * quad(function, a, b, epsabs=0.0, epsrel=1e-13, limit=400)[0]
    return parts


def _phases(train, top, switch):
    """Distance, time and traction work of traction to ``top``, coasting to ``switch`` and braking to a stop."""

    def pull(v):
        free = train.traction.effort_n(v) - train.resistance_n(v)
        return min(free, train.inertia_kg * train.max_acceleration_mps2)

    def drag(v):
        return -train.resistance_n(v)

    def brake(v):
        return max(-brake_n(train, v) - train.resistance_n(v), -train.inertia_kg * train.max_deceleration_mps2)

    up = _integrals(train, pull, 0.0, top, breaks_of(train.traction))
    edges = [0.0, *(v for v in breaks_of(train.traction) if 0.0 < v < top), top]
    work = 0.0
    for a, b in itertools.pairwise(edges):
        work += quad(
            lambda v: (pull(v) + train.resistance_n(v)) * v * train.inertia_kg / pull(v), a, b,
            epsabs=0.0, epsrel=1e-13, limit=400,
        )[0]  # fmt: skip
    coast = _integrals(train, drag, top, switch, ()) if train.resistance_n(top) > 0.0 else [0.0, 0.0]
    down = _integrals(train, brake, switch, 0.0, breaks_of(train.braking))
    return up[0] + coast[0] + down[0], up[1] + coast[1] + down[1], work


def _switch(train, price, top):
    return price / (train.resistance_n(top) + price / top)


def holding_mps(train, price):
    """Speed V with V²·R'(V) = λ; infinite where the resistance does not depend on speed."""

    def excess(v):
        return v * v * (train.davis_b_n_per_mps + 2.0 * train.davis_c_n_per_mps2 * v) - price

    if train.davis_b_n_per_mps == 0.0 and train.davis_c_n_per_mps2 == 0.0:
        return math.inf
    high = 1.0
    while excess(high) < 0.0:
        high *= 2.0
    return brentq(excess, 0.0, high, xtol=1e-15, rtol=1e-15)


def optimal_run(train, length_m, limit_mps, price):
    """The optimal run from stop to stop for a multiplier λ in J/s.

    Not for a train without resistance (coasting then has no speed of its own), nor for a limit that it cannot reach.
    """
    hold = min(holding_mps(train, price), limit_mps, train.max_speed_mps)

    def used_m(top):
        return _phases(train, top, _switch(train, price, top))[0]

    def surplus(v):
        return train.traction.effort_n(v) - train.resistance_n(v)

    # A train may balance below the speed that it would hold: then it never gets there.
    high = 1.0
    while high < hold and surplus(high) > 0.0 and used_m(min(high, hold)) < length_m:
        high *= 1.5
    high = min(high, hold)
    if surplus(high) <= 0.0:
        high = brentq(surplus, 0.0, high, xtol=1e-15, rtol=1e-15) * (1.0 - 1e-7)
    top, held_m = hold, 0.0
    if high == hold and used_m(hold) <= length_m:
        held_m = length_m - used_m(hold)
    else:
        top = brentq(lambda v: used_m(v) - length_m, 1e-3 * high, high, xtol=1e-15, rtol=1e-15)
    switch = _switch(train, price, top)
    _, duration, work = _phases(train, top, switch)
    if held_m:
        duration += held_m / top
        work += held_m * train.resistance_n(top)
    return Run(duration, work, top, switch, held_m)
