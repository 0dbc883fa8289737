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


@pytest.mark.parametrize("fineness", [0.125, 0.5])
def test_the_run_of_a_high_multiplier_is_the_fastest_one(fineness):
    """Dynamic braking all the way before a limit made it 0.1 to 0.7 % slower, however high the multiplier."""
    limits = (SpeedLimit(0.0, 31.0), SpeedLimit(4000.0, 12.0), SpeedLimit(5000.0, 31.0), SpeedLimit(7000.0, 20.0))
    result = tgvdp.search(TRAIN, Track(length_m=9500.0, speed_limits=limits), points=2, energy="pantograph")
    mesh = Mesh.of(result.trip, result.fastest.profile, fineness)
    extremal = mesh.extremal(1e9 * mesh.usual_multiplier, {"extremals": 0, "runs": 0, "costates": 0})
    assert extremal.time_s <= result.fastest.time_s * (1.0 + 1e-4)


@pytest.mark.parametrize("share", [0.5, 1.0, 2.0])
def test_dynamic_braking_begins_where_it_should_in_long_cells(share):
    """It began up to a cell too early: extremals on the first mesh cost 0.1 % and more."""
    limits = (SpeedLimit(0.0, 31.0), SpeedLimit(4000.0, 12.0), SpeedLimit(5000.0, 31.0), SpeedLimit(7000.0, 20.0))
    result = tgvdp.search(TRAIN, Track(length_m=9500.0, speed_limits=limits), points=2, energy="pantograph")
    meshes = [Mesh.of(result.trip, result.fastest.profile, fineness) for fineness in (0.25, 16.0)]
    multiplier = share * meshes[0].usual_multiplier
    extremals = [mesh.extremal(multiplier, {"extremals": 0, "runs": 0, "costates": 0}) for mesh in meshes]
    lost_j = extremals[0].cost_j(multiplier) - extremals[1].cost_j(multiplier)
    assert lost_j <= 1e-3 * extremals[1].energy_j
