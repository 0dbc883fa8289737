"""Runs for times over which blends jump: between two policies, from station to station."""

import numpy as np
import pytest

from tests.helpers.fronts import counters
from tests.helpers.trips import commuter, trip_on
from tgvdp.methods.costate.bridge import bridge
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.runs.fastest import fastest_run

TOLERANCE_S = 0.01


@pytest.fixture(scope="module")
def mesh():
    trip = trip_on([(0, 22)], [(0, 0), (900, 4), (2500, -3)], length_m=6000.0, train=commuter())
    return Mesh.of(trip, fastest_run(trip), 4.0)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("ratio", [1.05, 2.0, 8.0])
def test_any_time_between_two_policies_is_met_but_for_little(mesh, ratio, share):
    """Where two runs that are near have no blend within the effort that there is, the faster one stands for it."""
    fast, slow = (mesh.extremal(mesh.usual_multiplier * level, counters()) for level in (1.0, 1.0 / ratio))
    target_s = fast.time_s + share * (slow.time_s - fast.time_s)
    run = bridge(mesh, fast.switch, slow.switch, target_s, TOLERANCE_S, counters())
    assert target_s - TOLERANCE_S <= run.time_s <= target_s + TOLERANCE_S
    assert (np.diff(run.x_m) > 0.0).all()
    assert slow.energy_j * (1.0 - 1e-4) <= run.energy_j <= fast.energy_j


def test_between_one_policy_and_itself_there_is_but_its_run(mesh):
    one = mesh.extremal(mesh.usual_multiplier, counters())
    run = bridge(mesh, one.switch, one.switch, one.time_s + 1.0, TOLERANCE_S, counters())
    assert run.time_s == pytest.approx(one.time_s)
