"""A guide for the generic refinement: the costate program, with the efficiencies that a map has on average.

Where a line coasts, holds and brakes hangs on the price of time more than on the shape of the map. The costate program
knows all of the line at once; the refinement, which looks next to its incumbent, then mends what the map asks for.
"""

import math
from dataclasses import replace

import numpy as np

from tgvdp.errors import TgvdpError
from tgvdp.methods.costate.mesh import Mesh, Run
from tgvdp.model.energy import WHEEL
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import EnergyTables, energy_tables
from tgvdp.runs.profile import Profile


def fitted_tables(train: Train, tables: EnergyTables, top_mps: float) -> EnergyTables:
    """Tables of two efficiencies and a power of auxiliaries that draw what a map draws at full effort, on average.

    Parameters
    ----------
    train : Train
        Its effort limits turn demands into efforts.
    tables : EnergyTables
        Tables without a map are returned as they are.
    top_mps : float
        Nodes of higher speeds do not count, m/s.
    """
    if tables.power_w.size == 0:
        return tables
    counts = tables.speed_mps <= max(top_mps, float(tables.speed_mps[1]))
    speed_mps = tables.speed_mps[counts]
    braking_w, idle_w, traction_w = (
        np.array([np.interp(demand, tables.demand, row) for row in tables.power_w[counts]]) for demand in (-1, 0, 1)
    )
    pull_w, brake_w = (
        speed_mps * [curve.effort_n(v) for v in speed_mps.tolist()] for curve in (train.traction, train.braking)
    )
    traction = max(float((traction_w - idle_w).sum() / pull_w.sum()), 0.0)
    returned = float((idle_w - braking_w).sum() / brake_w.sum()) if brake_w.any() else 0.0
    return energy_tables(train, WHEEL)._replace(
        traction=traction,
        regeneration=min(max(returned, 0.0), traction),
        auxiliary_w=tables.auxiliary_w + float(idle_w.mean()),
    )


class Guide:
    """The costate program of a trip whose energy is that of a map.

    Parameters
    ----------
    trip : Trip
    fastest : Profile
        Its fastest run.
    tables : EnergyTables
        What it shall draw; a map is fitted.

    Attributes
    ----------
    tables : EnergyTables
        What its runs draw.
    """

    def __init__(self, trip: Trip, fastest: Profile, tables: EnergyTables) -> None:
        self.tables = fitted = fitted_tables(trip.train, tables, float(fastest.speed_mps.max()))
        self._mesh = replace(Mesh.of(trip, fastest), tables=fitted) if fitted.traction > 0.0 else None
        self._counters = {"extremals": 0, "runs": 0, "costates": 0}

    def run(self, multiplier: float) -> Run | None:
        """Its optimal run for λ in J/s, energy without auxiliaries; none where it finds none."""
        mesh = self._mesh
        if mesh is None or not math.isfinite(total := multiplier + mesh.tables.auxiliary_w) or total <= 0.0:
            return None
        try:
            return mesh.optimal_run(total, self._counters)
        except (TgvdpError, ArithmeticError):  # a start less: the grid has one, too
            return None
