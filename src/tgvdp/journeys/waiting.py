"""What a train draws while it waits for a window: its auxiliaries, or what its energy map draws at a stand.

Where a journey starts and ends, it takes E + P·W in all, W the time that it waits at P watts. Running times, dwells and
waiting add up to the time between the two ends, so that for each arrival that is the least where E − P·T is, T the
running time: a train that draws nothing at a stand anyway, less P while it runs, has that energy (`waiting_for_free`).
"""

from dataclasses import replace

import numpy as np

from tgvdp.model.energy import EnergyMap, EnergyModel
from tgvdp.model.trip import Trip


def waiting_w(trip: Trip) -> float:
    """Power drawn by a train that waits, W; 0 at the wheel.

    And on lines where pantographs are lowered: nothing counts there, so that a train would linger in place of waiting.
    """
    if any(row.lowered_pantograph for row in trip.track.neutral_sections):
        return 0.0
    return trip.energy.auxiliary_w(trip.train) + _standing_w(trip.energy.map)


def waiting_for_free(trip: Trip) -> Trip:
    """The trip with `waiting_w` less drawn, at a stand and while it runs; itself where that is nothing."""
    if waiting_w(trip) == 0.0:
        return trip
    energy, standing_w = trip.energy, _standing_w(trip.energy.map)
    if energy.map is not None:
        power_w = tuple(tuple(one_w - standing_w for one_w in row) for row in energy.map.power_w)
        energy = EnergyModel(energy.kind, replace(energy.map, power_w=power_w))
    return replace(trip, train=replace(trip.train, auxiliary_power_w=0.0), energy=energy)


def _standing_w(map: EnergyMap | None) -> float:
    """What a map draws at a stand without effort, W, if anything."""
    return 0.0 if map is None else max(float(np.interp(0.0, map.demand, map.power_w[0])), 0.0)
