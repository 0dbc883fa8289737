"""Energy of an arc, given its work at the wheel, in a form that kernels can use (see `model.energy`)."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.model.energy import EnergyModel
from tgvdp.model.train import Train
from tgvdp.physics.forces import effort_at, mean_effort, mean_rate

#: A mean effort above this share of its mean limit is full effort, which follows the limit along an arc.
FULL_EFFORT = 0.999
#: Where the limit of the dynamic brake changes by less than this share of its mean along an arc, it is followed.
FOLLOWED = 0.05
#: Halvings that find the speed at which the dynamic brake no longer suffices to 1e-4 of an arc's change of speed.
_BISECTIONS = 14


class EnergyTables(NamedTuple):
    """Energy of an arc as tables for kernels: what is drawn from the line for work at the wheel.

    Attributes
    ----------
    traction : float
        Energy drawn per joule of traction work, 1/η_t.
    regeneration : float
        Energy returned per joule of braking work, η_r, as far as the dynamic brake does it.
    auxiliary_w : float
        Power drawn at any time.
    speed_mps, demand : (n,), (m,) float64
        Nodes of a map; none for the other kinds.
    power_w : (n, m) float64
        Power drawn at the nodes. A map with nodes replaces the two factors.
    """

    traction: float
    regeneration: float
    auxiliary_w: float
    speed_mps: NDArray[np.float64]
    demand: NDArray[np.float64]
    power_w: NDArray[np.float64]


_NO_NODES = np.empty(0)
_NO_MAP = np.empty((0, 0))


def energy_tables(train: Train, energy: EnergyModel) -> EnergyTables:
    """Reduce an energy model to what kernels need.

    Parameters
    ----------
    train : Train
        Its efficiencies and auxiliary power, which count at the pantograph alone.
    energy : EnergyModel
    """
    if energy.kind == "wheel":
        return EnergyTables(1.0, 0.0, 0.0, _NO_NODES, _NO_NODES, _NO_MAP)
    auxiliary_w = energy.auxiliary_w(train)
    if energy.map is not None:
        return EnergyTables(1.0, 0.0, auxiliary_w, *energy.map.tables)
    efficiencies = (1.0 / train.traction_efficiency, float(train.regeneration_efficiency))
    return EnergyTables(*efficiencies, auxiliary_w, _NO_NODES, _NO_NODES, _NO_MAP)


@leaf
def _node(nodes, x):
    """Index and share of x between two nodes, held at the ends."""
    last = nodes.shape[0] - 1
    if x <= nodes[0]:
        return 0, 0.0
    if x >= nodes[last]:
        return last - 1, 1.0
    lo = 0
    hi = last
    while hi - lo > 1:
        middle = (lo + hi) // 2
        if nodes[middle] <= x:
            lo = middle
        else:
            hi = middle
    return lo, (x - nodes[lo]) / (nodes[hi] - nodes[lo])


@leaf
def _power_at(tables, v, j, b):
    """Power in W that a map draws at speed v and a share b between the nodes j and j + 1 of demand."""
    i, a = _node(tables.speed_mps, v)
    power = tables.power_w
    here = power[i, j] + b * (power[i, j + 1] - power[i, j])
    there = power[i + 1, j] + b * (power[i + 1, j + 1] - power[i + 1, j])
    return here + a * (there - here)


@leaf
def map_power(tables, v, demand):
    """Power in W that a map draws at speed v and a demand, without auxiliaries."""
    j, b = _node(tables.demand, demand)
    return _power_at(tables, v, j, b)


@leaf
def _braking_power(train, tables, effort, v):
    """Power in W that a map draws at speed v under a braking effort, as far as the dynamic brake takes it."""
    limit = effort_at(train.braking, v)
    return map_power(tables, v, -min(effort / limit, 1.0) if limit > 0.0 else 0.0)


@leaf
def follows_dynamic(train, length, effort, v0, v1):
    """Whether the dynamic brake follows its limit along an arc of a braking ``effort``, N, friction being constant.

    It does where that passes the effort, but changes by little. Brakes at full effort follow their own limit, and a
    braking rate or a comfort limit gives the effort that it takes.
    """
    limit0 = effort_at(train.braking, v0)
    limit1 = effort_at(train.braking, v1)
    if not min(limit0, limit1) < effort < max(limit0, limit1):
        return False
    dynamic = mean_effort(train.braking, v0, v1)
    return abs(limit0 - limit1) <= FOLLOWED * dynamic and not _brakes_fully(train, length, effort, dynamic, v0, v1)


@leaf
def _brakes_fully(train, length, effort, dynamic, v0, v1):
    """Whether a braking effort is all that brakes, a braking rate or a comfort limit allow along an arc."""
    most = train.inertia_kg * train.max_deceleration
    if train.rates.shape[0] > 0:
        most = min(most, mean_rate(train.rates, v0, v1))
    elif effort >= FULL_EFFORT * (dynamic + train.friction_n):
        return True
    return 0.5 * train.inertia_kg * (v0 * v0 - v1 * v1) >= FULL_EFFORT * most * length


@kernel
def regenerated(train, length, effort, v0, v1):
    """Mean over distance, in N, of what the dynamic brake takes of a braking effort, friction the rest.

    The effort is that of all brakes along an arc at full effort. Along any other it is constant, or friction is (see
    `follows_dynamic`).
    """
    dynamic = mean_effort(train.braking, v0, v1)
    limit0 = effort_at(train.braking, v0)
    limit1 = effort_at(train.braking, v1)
    if effort <= min(limit0, limit1) or effort >= min(max(limit0, limit1), FULL_EFFORT * (dynamic + train.friction_n)):
        return min(effort, dynamic)
    if follows_dynamic(train, length, effort, v0, v1):
        return min(effort, dynamic)
    enough = v0 if limit0 >= effort else v1  # the limit crosses the effort once: effort curves have short pieces
    short = v1 if limit0 >= effort else v0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (enough + short)
        if effort_at(train.braking, middle) >= effort:
            enough = middle
        else:
            short = middle
    end = v1 if limit0 >= effort else v0
    other = v0 + v1 - end
    limited = mean_effort(train.braking, short, end) * abs(end * end - short * short)
    return (limited + effort * abs(short * short - other * other)) / abs(v1 * v1 - v0 * v0)


@leaf
def _holds_effort(train, length, effort, v0, v1):
    """Whether a braking ``effort``, N, is held along an arc, friction taking what passes the dynamic brake's limit.

    A dynamic brake that suffices holds its demand, unless a braking rate or a comfort limit gives the effort.
    """
    if train.friction_n == 0.0 or follows_dynamic(train, length, effort, v0, v1):
        return False
    dynamic = mean_effort(train.braking, v0, v1)
    short = effort > min(effort_at(train.braking, v0), effort_at(train.braking, v1))
    return short or _brakes_fully(train, length, effort, dynamic, v0, v1)


@kernel
def _map_energy(train, tables, length, duration, effort, v0, v1):
    """Energy of an arc by the map: Simpson's rule in time, in which the speed is linear.

    Traction counts at its mean demand: to hold the effort constant instead would make effort free where it passes the
    limit at one end of an arc, and let arcs pass a kink of the map between the three speeds. So does the dynamic brake.
    """
    if effort < 0.0 and _holds_effort(train, length, -effort, v0, v1):
        middle = 0.5 * (v0 + v1)
        ends = _braking_power(train, tables, -effort, v0) + _braking_power(train, tables, -effort, v1)
        return duration / 6.0 * (ends + 4.0 * _braking_power(train, tables, -effort, middle))
    limit = mean_effort(train.traction if effort >= 0.0 else train.braking, v0, v1)
    demand = min(max(effort / limit, -1.0), 1.0) if limit > 0.0 else 0.0
    j, b = _node(tables.demand, demand)
    ends = _power_at(tables, v0, j, b) + _power_at(tables, v1, j, b)
    return duration / 6.0 * (ends + 4.0 * _power_at(tables, 0.5 * (v0 + v1), j, b))


@leaf
def arc_energy(train, tables, length, duration, work, w0, w1):
    """Energy in J drawn on an arc, given its duration in s and its work at the wheel in J; negative if returned."""
    auxiliary = tables.auxiliary_w * duration
    if tables.speed_mps.shape[0] > 0:
        return auxiliary + _map_energy(train, tables, length, duration, work / length, math.sqrt(w0), math.sqrt(w1))
    if work >= 0.0:
        return auxiliary + tables.traction * work
    if tables.regeneration == 0.0:
        return auxiliary
    return auxiliary - tables.regeneration * length * regenerated(
        train, length, -work / length, math.sqrt(w0), math.sqrt(w1)
    )
