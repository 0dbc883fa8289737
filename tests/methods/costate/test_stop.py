"""Stopping where braking returns energy: the dynamic brake as long as that pays, all brakes in the last metres."""

import numpy as np
import pytest

import tgvdp
from tgvdp import EffortCurve, SpeedLimit, Track, Train
from tgvdp.methods.costate.mesh import Mesh

TRAIN = Train(
    mass_kg=370e3, traction=EffortCurve.from_caps(214e3, 3.4e6), braking=EffortCurve.from_caps(171e3, 1.8e6),
    friction_brake_n=229e3, davis_a_n=5e3, davis_b_n_per_mps=143.0, davis_c_n_per_mps2=5.6, traction_efficiency=0.86,
    regeneration_efficiency=0.75, auxiliary_power_w=40e3,
)  # fmt: skip


@pytest.mark.parametrize("share", [0.3, 1.0])
def test_a_stop_costs_what_it_does_on_a_fine_mesh(share):
    """The dynamic brake alone stopped trains in the last cell: 0.01 % here, 0.05 % of a slow run of a survey."""
    track = Track(length_m=9500.0, speed_limits=(SpeedLimit(0.0, 31.0),))
    result = tgvdp.search(TRAIN, track, points=2, energy="pantograph")
    meshes = [Mesh.of(result.trip, result.fastest.profile, fineness) for fineness in (0.25, 16.0)]
    multiplier = share * meshes[0].usual_multiplier
    extremals = [mesh.extremal(multiplier, {"extremals": 0, "runs": 0, "costates": 0}) for mesh in meshes]
    costs_j = np.array([extremal.cost_j(multiplier) for extremal in extremals])
    assert costs_j[0] - costs_j[1] <= 8e-5 * extremals[1].energy_j
