"""Energy of an arc as tables: what is drawn from the line for work at the wheel, in a form that kernels can use."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.model.train import Train
from tgvdp.physics.forces import mean_effort


class EnergyTables(NamedTuple):
    """Energy of an arc as tables for kernels: what is drawn from the line for work at the wheel.

    Attributes
    ----------
    traction : float
        Energy drawn per joule of traction work, 1/η_t.
    regeneration : float
        Energy returned per joule of braking work, η_r, as far as the dynamic brake does it.
    speed_mps, demand : (n,), (m,) float64
        Nodes of a map, increasing; the demand is the effort as a share of the effort limit, negative when braking,
        where the limit is that of the dynamic brake.
    power_w : (n, m) float64
        Power drawn at the nodes, negative when it is returned; bilinear between them, constant beyond. A map with
        nodes replaces the two factors.
    """

    traction: float
    regeneration: float
    speed_mps: NDArray[np.float64]
    demand: NDArray[np.float64]
    power_w: NDArray[np.float64]


_NO_NODES = np.empty(0)
_NO_MAP = np.empty((0, 0))


def linear_energy(traction: float, regeneration: float) -> EnergyTables:
    """Energy that is piecewise linear in work at the wheel.

    Parameters
    ----------
    traction : float
        Energy drawn per joule of traction work.
    regeneration : float
        Energy returned per joule of braking work, as far as the dynamic brake does it.
    """
    return EnergyTables(float(traction), float(regeneration), _NO_NODES, _NO_NODES, _NO_MAP)


#: Traction work at the wheel.
WHEEL = linear_energy(1.0, 0.0)


def pantograph_energy(train: Train) -> EnergyTables:
    """Energy at the pantograph by the train's constant efficiencies; its dynamic brake regenerates."""
    return linear_energy(1.0 / train.traction_efficiency, train.regeneration_efficiency)


def map_energy(
    speed_mps: NDArray[np.float64], demand: NDArray[np.float64], power_w: NDArray[np.float64]
) -> EnergyTables:
    """Energy by a map of the power drawn, bilinear between its nodes and constant beyond them.

    Parameters
    ----------
    speed_mps, demand : (n,), (m,) float64
        Increasing nodes, at least two each; the demand is the effort as a share of its limit, negative when braking.
    power_w : (n, m) float64
        Power drawn from the line, negative when it is returned.
    """
    return EnergyTables(1.0, 0.0, *(np.ascontiguousarray(a, dtype=np.float64) for a in (speed_mps, demand, power_w)))


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


@kernel
def _map_energy(train, tables, length, duration, work, v0, v1):
    """Energy of an arc by the map: power at its mean speed and mean demand, times its duration."""
    limit = mean_effort(train.traction if work >= 0.0 else train.braking, v0, v1) * length
    demand = 0.0
    if work != 0.0 and limit > 0.0:
        demand = work / limit
    i, a = _node(tables.speed_mps, length / duration)
    j, b = _node(tables.demand, demand)
    power = tables.power_w
    here = power[i, j] + b * (power[i, j + 1] - power[i, j])
    there = power[i + 1, j] + b * (power[i + 1, j + 1] - power[i + 1, j])
    return duration * (here + a * (there - here))


@leaf
def arc_energy(train, tables, length, duration, work, w0, w1):
    """Energy in J drawn on an arc, given its duration in s and its work at the wheel in J; negative if returned."""
    if tables.speed_mps.shape[0] > 0:
        return _map_energy(train, tables, length, duration, work, math.sqrt(w0), math.sqrt(w1))
    if work >= 0.0:
        return tables.traction * work
    if tables.regeneration == 0.0:
        return 0.0
    return -tables.regeneration * min(-work, length * mean_effort(train.braking, math.sqrt(w0), math.sqrt(w1)))
