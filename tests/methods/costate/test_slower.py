"""The run of a lesser multiplier is nowhere faster: below it no run is sought, where meshes have many cells."""

import numpy as np
import pytest

import tgvdp
from tests.helpers.doubt_case import TRAIN, front_on, hills
from tests.helpers.fronts import counters
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.model.track import Tunnel
from tgvdp.model.train import TunnelDrag


@pytest.mark.parametrize("seed", range(5))
def test_runs_of_lesser_multipliers_are_nowhere_faster(seed):
    result = tgvdp.search(TRAIN, hills(seed), points=2)
    mesh = Mesh.of(result.trip, result.fastest.profile, 1.0)
    levels = np.exp(np.linspace(1.5, -2.5, 9)) * mesh.usual_multiplier
    w = np.array([mesh.extremal(level, counters()).passed[:, 0] for level in levels])
    assert (w[1:] - w[:-1]).max() <= 2e-3 * w.max()  # of which `slower._BELOW` leaves a hundred times as much


@pytest.mark.parametrize("seed", range(5))
def test_extremals_are_what_they_are_among_all_speeds(seed):
    result = tgvdp.search(TRAIN, hills(seed), points=2)
    front = front_on(Mesh.of(result.trip, result.fastest.profile, 1.0), result.fastest.time_s)
    for mesh in (front.mesh, front.mesh.finer):
        multipliers = [one.multiplier for one in front.extremals[1:]]
        multipliers += [0.5 * (one + other) for one, other in zip(multipliers[1:], multipliers[:-1], strict=True)]
        above, among_all = counters(), counters()
        front.counters = above
        solved = front.solved(mesh, multipliers)
        expected = mesh.extremals(multipliers, among_all)
        assert above["costates"] < 0.9 * among_all["costates"]
        for one, other in zip(solved, expected, strict=True):
            excess_j = one.cost_j(one.multiplier) - other.cost_j(one.multiplier)
            assert abs(excess_j) <= 2e-5 * other.energy_j


def test_a_slower_run_than_any_known_is_sought_among_all_speeds():
    result = tgvdp.search(TRAIN, hills(0), points=2)
    front = front_on(Mesh.of(result.trip, result.fastest.profile, 1.0), result.fastest.time_s)
    multiplier = 0.1 * front.extremals[-1].multiplier
    [solved], expected = front.solved(front.mesh, [multiplier]), front.mesh.extremal(multiplier, counters())
    assert solved.outcome == expected.outcome


def test_a_tunnel_that_a_coarse_mesh_does_not_see_keeps_no_run_fast():
    """Its run kept the limit in the tunnel, and those of all finer meshes, where slower is better, 80 % of its w."""
    train = tgvdp.Train(
        mass_kg=400e3,
        traction=tgvdp.EffortCurve.from_caps(310e3, 3.1e6),
        friction_brake_n=260e3,
        davis_a_n=4e3,
        davis_c_n_per_mps2=29.0,
        tunnel_drag=(TunnelDrag(40.0, 58.0),),
    )
    track = tgvdp.Track(length_m=12e3, speed_limits=(tgvdp.SpeedLimit(0.0, 22.0),), tunnels=(Tunnel(6e3, 1e3, 40.0),))
    result = tgvdp.search(train, track, tunnels=True, points=12, max_margin=0.1)
    assert result.certify().gap_pct.max() <= 0.05  # it was 0.24
