"""Energy of an arc, given its work at the wheel, in a form that kernels can use (see `model.energy`)."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.model.energy import EnergyModel
from tgvdp.model.train import Train
from tgvdp.physics.forces import effort_at, mean_effort


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
    auxiliary_w = float(train.auxiliary_power_w)
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
def map_power(tables, v, demand):
    """Power in W that a map draws at speed v and a demand, without auxiliaries."""
    i, a = _node(tables.speed_mps, v)
    j, b = _node(tables.demand, demand)
    power = tables.power_w
    here = power[i, j] + b * (power[i, j + 1] - power[i, j])
    there = power[i + 1, j] + b * (power[i + 1, j + 1] - power[i + 1, j])
    return here + a * (there - here)


@kernel
def _map_energy(train, tables, length, duration, work, v0, v1):
    """Energy of an arc by the map: power at its mean speed and mean demand, times its duration."""
    limit = mean_effort(train.traction if work >= 0.0 else train.braking, v0, v1) * length
    demand = 0.0
    if work > 0.0 and limit > 0.0:
        demand = work / limit
    elif work < 0.0 and limit > 0.0:
        demand = max(work / limit, -1.0)
    return duration * map_power(tables, length / duration, demand)


@kernel
def _regenerated(train, effort, w0, w1):
    """Mean over distance, in N, of what the dynamic brake takes of a constant braking effort, friction the rest."""
    v0 = math.sqrt(w0)
    v1 = math.sqrt(w1)
    limit0 = effort_at(train.braking, v0)
    limit1 = effort_at(train.braking, v1)
    low = min(limit0, limit1)
    high = max(limit0, limit1)
    if low < effort < high:  # the limit, nearly linear in v² along an arc, crosses the effort
        return effort - 0.5 * (effort - low) * (effort - low) / (high - low)
    return min(effort, mean_effort(train.braking, v0, v1))


@leaf
def arc_energy(train, tables, length, duration, work, w0, w1):
    """Energy in J drawn on an arc, given its duration in s and its work at the wheel in J; negative if returned."""
    auxiliary = tables.auxiliary_w * duration
    if tables.speed_mps.shape[0] > 0:
        return auxiliary + _map_energy(train, tables, length, duration, work, math.sqrt(w0), math.sqrt(w1))
    if work >= 0.0:
        return auxiliary + tables.traction * work
    if tables.regeneration == 0.0:
        return auxiliary
    return auxiliary - tables.regeneration * length * _regenerated(train, -work / length, w0, w1)
