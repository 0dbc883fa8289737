"""The convex relaxation of an energy map: what it would draw if efforts could be switched infinitely fast.

Where the power of a map is not convex in the effort, partial effort is dearer than switching between two efforts with
the same mean (pulse and glide), and the cheapest run switches as often as its mesh allows. The infimum over ever finer
switching is the least energy under the lower convex hull of the map over the effort (relaxed controls; Young 1937,
McShane 1967). That problem has one optimum near which the switching runs lie.

There is no switching to an effort beyond what comfort and braking rates allow; beyond that the map stays as it is.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tgvdp.model.train import Train
from tgvdp.physics.energy import EnergyTables

#: Share of the largest power by which a map may lie above its hull and count as convex.
_FLAT = 1e-6
#: The hull has nodes of speed no further apart than this, m/s, for limits of effort bend between those of a map, and
#: nodes of demand no further apart than that where comfort or rates cut it. A table may go far beyond what trains do.
_SPEED_MPS, _DEMAND = 3.0, 0.02
_MOST_PARTS = 1000


def relaxed_tables(train: Train, tables: EnergyTables) -> EnergyTables:
    """Tables whose map is the lower convex hull over the effort at each node of speed.

    Parameters
    ----------
    train : Train
        Its effort limits turn demands into efforts.
    tables : EnergyTables

    Returns
    -------
    EnergyTables
        The tables themselves where there is no map, or a convex one; else the hull, which may have more nodes.
    """
    if tables.power_w.size == 0:
        return tables
    finer = _refined(train, tables)
    power_w = finer.power_w.copy()
    for row, speed_mps in enumerate(finer.speed_mps.tolist()):
        pull_n, brake_n = train.traction.effort_n(speed_mps), train.braking.effort_n(speed_mps)
        limit_n = np.where(finer.demand >= 0.0, pull_n, brake_n)
        effort_n = finer.demand * limit_n
        least_n, most_n = _allowed_n(train, speed_mps)
        # where a limit is 0 there is nothing to switch between
        allowed = (least_n <= effort_n) & (effort_n <= most_n) & ((limit_n > 0.0) | (finer.demand == 0.0))
        power_w[row, allowed] = _hull(effort_n[allowed], finer.power_w[row, allowed])
    if np.abs(finer.power_w - power_w).max() <= _FLAT * np.abs(power_w).max():
        return tables
    return finer._replace(power_w=power_w)


def _refined(train: Train, tables: EnergyTables) -> EnergyTables:
    """The same map with more nodes: no effort and full effort among them, between which trains switch."""
    limits_mps2 = train.max_acceleration_mps2, train.max_deceleration_mps2
    is_cut = len(train.braking_rates) > 0 or min(limits_mps2) < math.inf
    speed_mps = _divided(tables.speed_mps, _SPEED_MPS)
    demand = np.union1d(tables.demand, (-1.0, 0.0, 1.0))
    demand = _divided(demand, _DEMAND) if is_cut else demand
    rows = np.array([np.interp(demand, tables.demand, row) for row in tables.power_w])
    power_w = np.array([np.interp(speed_mps, tables.speed_mps, column) for column in rows.T]).T
    return tables._replace(speed_mps=speed_mps, demand=demand, power_w=np.ascontiguousarray(power_w))


def _divided(nodes: NDArray[np.float64], most: float) -> NDArray[np.float64]:
    """Nodes, and others between them where they are further apart than that, up to so many parts."""
    parts = np.minimum(np.ceil(np.diff(nodes) / most * (1.0 - _FLAT)), _MOST_PARTS).astype(np.int64)
    pieces = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(nodes[:-1], nodes[1:], parts, strict=True)]
    return np.concatenate((*pieces, nodes[-1:]))


def _allowed_n(train: Train, speed_mps: float) -> tuple[float, float]:
    """Least and largest effort, N, that comfort and braking rates allow at a speed on level track."""
    rates_mps2 = [one.deceleration_mps2 for one in train.braking_rates if one.from_mps <= speed_mps]
    slowing_mps2 = min([train.max_deceleration_mps2, *rates_mps2[-1:]])
    resistance_n = train.resistance_n(speed_mps)
    least_n = resistance_n - train.inertia_kg * slowing_mps2
    return min(least_n, 0.0), resistance_n + train.inertia_kg * train.max_acceleration_mps2


def _hull(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lower convex hull of points (x, y), x increasing, at these x (Andrew's monotone chain)."""
    kept: list[int] = []
    for i in range(len(x)):
        while len(kept) > 1:
            a, b = kept[-2], kept[-1]
            if (y[b] - y[a]) * (x[i] - x[a]) < (y[i] - y[a]) * (x[b] - x[a]):
                break
            kept.pop()
        kept.append(i)
    return np.interp(x, x[kept], y[kept])
