"""A train with losses on a short line, and a map that says the same."""

import numpy as np

import tgvdp
from tests.helpers.trips import commuter
from tgvdp.model.energy import EnergyMap

TRAIN = commuter(traction_efficiency=0.8, regeneration_efficiency=0.6, auxiliary_power_w=2e5)


TRACK = tgvdp.Track(
    length_m=6000.0, speed_limits=((0.0, 33.0), (3500.0, 22.0)), gradients=((0.0, 4.0), (2000.0, -12.0), (4000.0, 2.0))
)


def perfect_map(train, losses=0.0):
    """Power of a drive that loses a share of what it moves, with nodes where the effort curves bend."""
    speeds = np.unique(np.concatenate(([0.0, 3.5e6 / 2.5e5, 3e6 / 1.5e5], np.linspace(0.0, 44.0, 89))))
    pull_w = np.array([v * train.traction.effort_n(v) if v else 0.0 for v in speeds]) * (1.0 + losses)
    brake_w = np.array([v * train.braking.effort_n(v) if v else 0.0 for v in speeds]) * (1.0 - losses)
    rows = tuple(zip((-brake_w).tolist(), np.zeros_like(speeds).tolist(), pull_w.tolist(), strict=True))
    return EnergyMap(speed_mps=tuple(speeds.tolist()), demand=(-1.0, 0.0, 1.0), power_w=rows)
