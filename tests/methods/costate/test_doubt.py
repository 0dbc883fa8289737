"""Which cells are too long: against meshes many times as fine, and where the answer must point to."""

import numpy as np
import pytest

import tgvdp
from tgvdp import EffortCurve, Track, Train
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate.doubt import Doubt
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.costate.multipliers import ExtremalFront

TRAIN = Train(
    mass_kg=450e3, traction=EffortCurve.from_caps(300e3, 6e6), friction_brake_n=400e3, davis_a_n=4000.0,
    davis_b_n_per_mps=100.0, davis_c_n_per_mps2=8.0,
)  # fmt: skip


def hills(seed):
    """Forty gradients of 1 km between −20 and 12 ‰, at each of which the best speed is another."""
    permil = np.random.default_rng(seed).uniform(-20.0, 12.0, 40)
    gradients = tuple((1e3 * km, float(value)) for km, value in enumerate(permil))
    return Track(length_m=40e3, speed_limits=((0.0, 75.0),), gradients=gradients)


def counters():
    return {"extremals": 0, "runs": 0, "costates": 0}


@pytest.mark.parametrize("seed", [5, 17, 18, 20, 23])
def test_points_on_hills_are_no_dearer_than_extremals_of_a_fine_mesh(seed):
    """A mesh and its check at marched multipliers alone left points at 0.1 % and more."""
    result = tgvdp.search(TRAIN, hills(seed), points=12)
    fine = Mesh.of(result.trip, result.fastest.profile, 4.0)
    for index in range(1, 12):
        multiplier = float(result.price_kwh_per_min[index] * 3.6e6 / 60.0)
        least_j = fine.extremal(multiplier, counters()).cost_j(multiplier)
        energy_j, time_s = result.front.energy_j[index], result.front.time_s[index]
        assert energy_j + multiplier * time_s - least_j <= 5e-4 * energy_j


def front_on(mesh, fastest_s):
    front = ExtremalFront(mesh, 1.0, 0.0, counters(), SearchBudget().start())
    front.reach(1.02 * fastest_s, 1.25 * fastest_s)
    return front


def test_cells_in_doubt_are_few_and_halving_them_settles_the_mesh():
    result = tgvdp.search(TRAIN, hills(5), points=2)
    fastest_s = result.fastest.time_s
    coarse = Mesh.of(result.trip, result.fastest.profile, 0.25)
    doubt = Doubt()
    mesh = doubt.refined(front_on(coarse, fastest_s))
    assert len(coarse.cells.length_m) < len(mesh.cells.length_m) < 1.8 * len(coarse.cells.length_m)
    front = front_on(mesh, fastest_s)
    assert doubt.refined(front) is mesh
    assert {extremal.multiplier for extremal in front.extremals[1:]} <= doubt.settled


def test_extremals_that_the_points_added_are_asked_too():
    """A mesh that was asked at marched multipliers alone left points between them at 0.06 %."""
    result = tgvdp.search(TRAIN, hills(1), points=2)
    fastest_s = result.fastest.time_s
    doubt = Doubt()
    front = front_on(Mesh.of(result.trip, result.fastest.profile, 1.0), fastest_s)
    doubt.refined(front)
    marched = set(doubt.settled)
    list(front.points(fastest_s * np.linspace(1.02, 1.25, 20)))
    doubt.refined(front)
    assert doubt.settled > marched
    assert {extremal.multiplier for extremal in front.extremals[1:]} <= doubt.settled
