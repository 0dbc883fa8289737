"""Runs that have next to no speed at a summit: what they still have there, the descent gives for nothing."""

import numpy as np

import tgvdp


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
