"""The convex relaxation of an energy map: what it would draw if efforts could be switched infinitely fast.

Where the power of a map is not convex in the effort, partial effort is dearer than switching between two efforts with
the same mean (pulse and glide), and the cheapest run switches as often as its mesh allows. The infimum over ever finer
switching is the least energy under the lower convex hull of the map over the effort (relaxed controls; Young 1937,
McShane 1967). That problem has one optimum near which the switching runs lie.
"""

import numpy as np
from numpy.typing import NDArray

from tgvdp.model.train import Train
from tgvdp.physics.energy import EnergyTables

#: Share of the largest power by which a map may lie above its hull and count as convex.
_FLAT = 1e-6


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
        The tables themselves where there is no map, or a convex one.
    """
    if tables.power_w.size == 0:
        return tables
    power_w = np.empty_like(tables.power_w)
    for row, speed_mps in enumerate(tables.speed_mps.tolist()):
        pull_n, brake_n = train.traction.effort_n(speed_mps), train.braking.effort_n(speed_mps)
        effort_n = np.where(tables.demand >= 0.0, tables.demand * pull_n, tables.demand * brake_n)
        if (np.diff(effort_n) > 0.0).all():
            power_w[row] = _hull(effort_n, tables.power_w[row])
        else:  # without effort there is nothing to switch between
            power_w[row] = tables.power_w[row]
    if np.abs(tables.power_w - power_w).max() <= _FLAT * np.abs(power_w).max():
        return tables
    return tables._replace(power_w=power_w)


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
