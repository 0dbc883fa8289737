"""Runs that have next to no speed at a summit: what they still have there, the descent gives for nothing."""

import numpy as np

import tgvdp
from tgvdp.methods.costate.mesh import Mesh


def test_a_thrifty_run_coasts_over_a_summit_at_next_to_no_speed() -> None:
    # Down the other side brakes hold the limit: kinetic energy at the summit is lost.
    force = tgvdp.EffortCurve.from_caps(1e6)
    train = tgvdp.Train(
        mass_kg=2e6, traction=force, braking=tgvdp.EffortCurve.from_caps(2e6), davis_a_n=700.0,
        davis_b_n_per_mps=90.0, davis_c_n_per_mps2=4.0, max_speed_mps=25.0,
    )  # fmt: skip
    track = tgvdp.Track(
        length_m=4000.0,
        speed_limits=(tgvdp.SpeedLimit(0.0, 22.0), tgvdp.SpeedLimit(1800.0, 3.0)),
        gradients=(tgvdp.Gradient(0.0, -20.0), tgvdp.Gradient(1000.0, 20.0), tgvdp.Gradient(2000.0, -35.0)),
    )
    result = tgvdp.search(train, track, points=6, max_margin=0.4, energy="wheel")
    thriftiest = result.profile(len(result.front) - 1)
    summit_w = np.interp(2000.0, thriftiest.position_m, thriftiest.speed_mps**2)
    assert summit_w < 1e-5 * np.max(result.profile(0).speed_mps) ** 2


def test_slow_summits_are_passed_alike_on_any_mesh() -> None:
    """Costates were interpolated over gaps where trains are slow but do not crawl: finer meshes were 1 % dearer."""
    train = tgvdp.Train(
        mass_kg=510e3, rotating_mass_factor=1.1, traction=tgvdp.EffortCurve.from_caps(52e3, 450e3),
        friction_brake_n=150e3, davis_a_n=9e3, davis_b_n_per_mps=36.0, davis_c_n_per_mps2=47.0,
    )  # fmt: skip
    summits = (
        tgvdp.Gradient(0.0, -5.0),
        tgvdp.Gradient(4e3, 2.7),
        tgvdp.Gradient(9e3, -20.7),
        tgvdp.Gradient(11e3, 2.7),
    )
    track = tgvdp.Track(
        length_m=25e3, speed_limits=(tgvdp.SpeedLimit(0.0, 27.0),),
        gradients=(*summits, tgvdp.Gradient(15e3, -25.0), tgvdp.Gradient(18e3, 0.0)),
    )  # fmt: skip
    result = tgvdp.search(train, track, points=2)
    meshes = [Mesh.of(result.trip, result.fastest.profile, fineness) for fineness in (1.0, 2.0, 4.0)]
    for share in (0.2, 0.35, 0.5, 0.7, 1.0):
        multiplier = share * meshes[0].usual_multiplier
        extremals = [mesh.extremal(multiplier, {"extremals": 0, "runs": 0, "costates": 0}) for mesh in meshes]
        costs_j = np.array([extremal.cost_j(multiplier) for extremal in extremals])
        assert np.ptp(costs_j) <= 5e-5 * extremals[0].energy_j
