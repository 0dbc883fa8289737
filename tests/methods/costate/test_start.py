"""Pulling off: the line of switching of the first cell begins beyond the one speed that a run has at the start."""

import numpy as np

import tgvdp
from tgvdp import EffortCurve, Track, Train

TRAIN = Train(
    mass_kg=2500e3, traction=EffortCurve.from_caps(260e3, 5e6), friction_brake_n=800e3, davis_a_n=24e3,
    davis_b_n_per_mps=200.0, davis_c_n_per_mps2=38.0,
)  # fmt: skip


def descent(cells):
    """A start on −27 ‰, whose first 24 m have so many breaks that cells next to the start are as short."""
    at_m = np.linspace(0.0, 24.0, cells + 1)
    start = tuple((float(x_m), -27.0 - 0.02 * (at % 2)) for at, x_m in enumerate(at_m))
    return Track(length_m=6e3, speed_limits=((0.0, 11.0),), gradients=(*start, (3e3, 0.0), (4e3, 5.0)))


def test_a_train_that_starts_downhill_pulls_as_long_as_on_short_cells():
    """It coasted from a crawl on: 0.3 % of energy, and 0.5 % on a freight line."""
    one = tgvdp.search(TRAIN, descent(1), points=8)
    many = tgvdp.search(TRAIN, descent(80), points=8)
    multiplier = many.price_kwh_per_min[1:] * 6e4
    more_j = (one.front.energy_j - many.front.energy_j)[1:] + multiplier * (one.front.time_s - many.front.time_s)[1:]
    assert (np.abs(more_j) <= 1e-4 * many.front.energy_j[1:]).all()
