"""Credits for seconds before a point: the front method's extremals where a second costs more before it than behind."""

import math

import numpy as np
import pytest

from tests.helpers.trips import commuter, trip_on
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.runs.fastest import fastest_run

#: Of the resistance of the commuter.
B_N_PER_MPS, C_N_PER_MPS2 = 30.0, 6.0


def price_of_holding(speed_mps):
    """The multiplier λ = v²·R'(v) at which a speed is held, J/s (Howlett & Pudney, 1995)."""
    return speed_mps**2 * (B_N_PER_MPS + 2.0 * C_N_PER_MPS2 * speed_mps)


def driven(trip, multiplier):
    """An extremal, and its positions, m, and speeds, m/s."""
    mesh = Mesh.of(trip, fastest_run(trip))
    counters = {"extremals": 0, "runs": 0, "costates": 0}
    extremal = mesh.extremal(multiplier, counters)
    *_, x_m, w = mesh.drive(extremal.switch, counters).copied()
    return extremal, x_m, np.sqrt(w)


@pytest.mark.parametrize(("before_mps", "behind_mps"), [(32.0, 22.0), (22.0, 32.0)])
def test_each_side_holds_the_speed_of_its_own_price(before_mps, behind_mps):
    price, other = price_of_holding(before_mps), price_of_holding(behind_mps)
    trip = trip_on([(0, 40)], length_m=60e3, train=commuter(max_speed_mps=40.0), credits=((30e3, other - price),))
    _, x_m, speed_mps = driven(trip, other)
    assert np.interp(15e3, x_m, speed_mps) == pytest.approx(before_mps, rel=1e-6)
    assert np.interp(45e3, x_m, speed_mps) == pytest.approx(behind_mps, rel=1e-6)


def test_no_extremal_is_dearer_than_another_at_its_own_multiplier():
    """Once the speed that is held before the point was that of the price behind it."""
    trip = trip_on([(0, 36)], [(0, 5.4), (1700, 1.0), (2000, -5.4)], length_m=3200.0, credits=((1800.0, -7e5),))
    multipliers = [2e5 * math.exp(-0.25 * step) for step in range(12)]
    found = [driven(trip, multiplier)[0] for multiplier in multipliers]
    for multiplier, own in zip(multipliers, found, strict=True):
        least_j = min(other.cost_j(multiplier) for other in found)
        assert own.cost_j(multiplier) <= least_j * (1.0 + 5e-4)
