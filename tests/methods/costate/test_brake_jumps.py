"""Dynamic brakes whose effort jumps with speed: they cut out, or are weaker, where trains are slow, or fast."""

import math
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.brake_case import CUTS_OUT, DROPS, HILLY, LEVEL, LIMITS, metro
from tgvdp import EffortCurve, Gradient, SpeedLimit, Track, Train
from tgvdp.methods.costate.brake_jumps import saturated_image
from tgvdp.methods.costate.characteristics import Step
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.model.energy import EnergyModel
from tgvdp.model.trip import Trip
from tgvdp.physics.codes import DYNAMIC
from tgvdp.physics.forces import kernel_train, per_kilogram
from tgvdp.runs.fastest import fastest_run
from tgvdp.units import JOULE_PER_KWH


@pytest.mark.parametrize("track", [LEVEL, HILLY], ids=["level", "hilly"])
def test_a_brake_that_cuts_out_is_used_up_to_the_envelope(track):
    """Runs came to 2.2 m/s metres too early and crept on: up to 1.9 % dearer, on 556 and 3,888 cells."""
    result = tgvdp.search(metro(CUTS_OUT), track, points=8, energy="pantograph")
    assert result.counters["cells"] < 150
    assert all(verdict.ok for verdict in result.verify())
    gap_pct = result.certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct.max() < 0.06


@pytest.mark.parametrize("track", [LEVEL, HILLY], ids=["level", "hilly"])
@pytest.mark.parametrize("full_mps", [4.5, 5.0])
def test_a_brake_that_rises_steeply_from_nothing_cuts_out_there(track, full_mps):
    """Dents of the least energy, smoothed: gaps of 1 to 2.4 % on 774 to 1194 cells."""
    points = ((0.0, 0.0), (3.5, 0.0), (full_mps, 150e3), (14.0, 150e3), (22.0, 95e3))
    result = tgvdp.search(metro(points), track, at_margin=(0.05, 0.1, 0.2), energy="pantograph")
    assert result.counters["cells"] < 250
    assert all(verdict.ok for verdict in result.verify())
    gap_pct = result.certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct.max() < 0.25


@pytest.mark.parametrize(
    ("track", "energy_kwh"), [(LEVEL, (13.01, 11.04)), (HILLY, (11.43, 9.44))], ids=["level", "hilly"]
)
def test_friction_helps_down_to_a_drop_of_the_dynamic_brake(track, energy_kwh):
    """They braked by the little that there is above it: 1.2 to 3.3 % dearer, and bounds were 10 % below."""
    result = tgvdp.search(metro(DROPS), track, at_margin=(0.01, 0.02), energy="pantograph")
    assert all(verdict.ok for verdict in result.verify())
    assert np.all(result.front.energy_j <= np.array(energy_kwh) * 3.6e6)
    gap_pct = result.certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct.max() < 0.3


@pytest.mark.parametrize(
    ("points", "permil", "energy_kwh"),
    [(DROPS, -30.0, (7.48, 5.67)), (((0.0, 60e3), (15.4, 60e3), (15.4, 6e3), (23.0, 6e3)), -10.0, (17.18, 15.97))],
)
def test_a_brake_that_cannot_slow_down_above_a_drop_asks_for_no_friction_there(points, permil, energy_kwh):
    """Costates far above 0 were put there: runs braked to the drop everywhere, for 10 to 60 % more, or not at all."""
    track = replace(LEVEL, speed_limits=LIMITS[:1], gradients=(Gradient(0.0, 0.0), Gradient(1700.0, permil)))
    result = tgvdp.search(metro(points), track, at_margin=(0.001, 0.01), energy="pantograph")
    assert all(verdict.ok for verdict in result.verify())
    assert np.all(result.front.energy_j <= np.array(energy_kwh) * 3.6e6)


@pytest.mark.parametrize("track", [LEVEL, HILLY], ids=["level", "hilly"])
@pytest.mark.parametrize("share", [1.0, 2.0, 3.0])
def test_extremals_of_a_brake_that_drops_do_not_depend_on_the_mesh(track, share):
    """Friction helps above the drop where a run comes late: p jumps where it begins to, and not where it does most.

    Dynamic braking to a limit below the drop began a little too late, on coarse meshes the more so: 0.3 % dearer.
    """
    trip = Trip(
        train=metro(DROPS), track=track, origin_m=0.0, destination_m=track.length_m, energy=EnergyModel("pantograph")
    )
    fastest = fastest_run(trip)
    multiplier = share * Mesh.of(trip, fastest).usual_multiplier
    costs_j = [
        Mesh.of(trip, fastest, fineness)
        .extremal(multiplier, {"extremals": 0, "runs": 0, "costates": 0})
        .cost_j(multiplier)
        for fineness in (0.5, 1.0, 2.0, 8.0)
    ]
    np.testing.assert_allclose(costs_j, min(costs_j), rtol=1e-5)


def test_runs_on_the_envelope_pass_a_drop_by_all_brakes():
    """They were to come from the drop by the dynamic brake, where all brakes end above it: rows of 53 MN."""
    points = ((0.0, 300e3), (3.0, 300e3), (3.0, 30e3), (23.0, 24e3))
    track = Track(length_m=6000.0, speed_limits=LIMITS[:1])
    result = tgvdp.search(metro(points), track, at_margin=(0.001, 0.03, 0.1), energy="pantograph")
    assert all(verdict.ok for verdict in result.verify())


def _railcar(share, rises_mps):
    """A railcar whose dynamic brake has a share of its effort only below a speed."""
    points = ((0.0, share * 80e3), (rises_mps, share * 80e3), (rises_mps, 80e3), (18.0, 80e3), (40.0, 36e3))
    return Train(
        mass_kg=150e3, rotating_mass_factor=1.07, traction=EffortCurve.from_caps(120e3, 1.5e6),
        braking=EffortCurve.from_points(points), friction_brake_n=100e3, davis_a_n=1800.0, davis_b_n_per_mps=30.0,
        davis_c_n_per_mps2=6.0, max_speed_mps=33.0, traction_efficiency=0.85, regeneration_efficiency=0.9,
    )  # fmt: skip


@pytest.mark.parametrize("share", [0.02, 0.2, 0.4])
def test_a_brake_that_is_weaker_at_low_speeds(share):
    """V has a dent there, and its hull hid where to brake: 0.6 to 3.1 % too dear, on 848 to 3,082 cells."""
    track = Track(length_m=4000.0, speed_limits=(SpeedLimit(0.0, 33.0),))
    result = tgvdp.search(_railcar(share, 8.0), track, points=8, energy="pantograph")
    assert result.counters["cells"] < 100
    assert all(verdict.ok for verdict in result.verify())
    gap_pct = result.certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct.max() < 0.08


@pytest.mark.parametrize(("rises_mps", "energy_kwh"), [(8.0, -20.03), (14.0, -17.53)])
def test_a_descent_that_is_held_only_above_the_rise_of_a_brake(rises_mps, energy_kwh):
    """Runs come to that speed from both sides and keep it: 2.1 and 12.8 % of what they draw were lost."""
    track = Track(
        length_m=4000.0, speed_limits=(SpeedLimit(0.0, 33.0),), gradients=(Gradient(0.0, -5.0), Gradient(1000.0, -25.0))
    )
    result = tgvdp.search(_railcar(0.2, rises_mps), track, at_margin=(0.25,), energy="pantograph")
    assert all(verdict.ok for verdict in result.verify())
    assert result.front.energy_j[-1] < energy_kwh * JOULE_PER_KWH


@pytest.mark.parametrize(("from_mps", "energy_kwh"), [(3.0, 5.692), (5.0, 6.049), (7.0, 6.65)])
def test_a_brake_of_limited_power_from_a_speed_on(from_mps, energy_kwh):
    """Runs braked early, to pass that speed and coast on, as p just above it is a little more than −r/2: 2 %."""
    curve = tuple((v_mps, from_mps * 150e3 / v_mps) for v_mps in np.linspace(from_mps, 22.0, 12).tolist())
    points = ((0.0, 0.0), (from_mps, 0.0), *curve)
    result = tgvdp.search(metro(points), LEVEL, points=12, energy="pantograph")
    assert result.counters["cells"] < 100
    assert all(verdict.ok for verdict in result.verify())
    assert result.front.energy_j[-1] < energy_kwh * JOULE_PER_KWH


def test_a_brake_that_fades_before_a_climb_to_the_stop():
    """It was taken to cut out where it comes to five times the resistance of level track, uphill, too: 3.7 %."""
    brake = EffortCurve.from_points(((0.0, 0.0), (3.0, 0.0), (6.0, 34.7e3), (22.6, 34.7e3), (40.0, 19.8e3)))
    train = Train(
        mass_kg=151e3, rotating_mass_factor=1.07, traction=EffortCurve.from_caps(110e3, 1.46e6), braking=brake,
        friction_brake_n=99.7e3, davis_a_n=1815.0, davis_b_n_per_mps=59.0, davis_c_n_per_mps2=12.2, max_speed_mps=20.5,
        max_deceleration_mps2=0.8, traction_efficiency=0.64, regeneration_efficiency=0.7,
    )  # fmt: skip
    track = Track(
        length_m=5000.0, speed_limits=(SpeedLimit(0.0, 20.5), SpeedLimit(160.0, 12.3)),
        gradients=(Gradient(0.0, 27.9), Gradient(160.0, -28.3), Gradient(4817.0, 32.0)),
    )  # fmt: skip
    result = tgvdp.search(train, track, points=8, energy="pantograph")
    assert all(verdict.ok for verdict in result.verify())
    gap_pct = result.certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct.max() < 0.08


@pytest.mark.parametrize("p1", [-0.25, -0.12, -0.02])
def test_costates_step_where_the_dynamic_brake_drops(p1):
    """Against the derivative of what braking costs in closed form, without friction above the drop and with it."""
    strong, weak, friction, drop_w, returned, price, length = 0.5, 0.2, 0.6, 144.0, 0.6, 1.5, 40.0
    points = ((0.0, strong), (12.0, strong), (12.0, weak), (50.0, weak))
    train = per_kilogram(
        kernel_train(
            Train(
                mass_kg=1.0, traction=EffortCurve.from_caps(1.0), braking=EffortCurve.from_points(points),
                friction_brake_n=friction,
            )
        )
    )  # fmt: skip

    def back(w1, brakes):
        """Squared speed before the cell, and what the way through it costs, above the drop with so much effort."""
        strong_m = (drop_w - w1) / (2.0 * strong)
        w0 = drop_w + 2.0 * brakes * (length - strong_m)
        seconds = (12.0 - math.sqrt(w1)) / strong + (math.sqrt(w0) - 12.0) / brakes
        return w0, price * seconds - returned * (strong * strong_m + weak * (length - strong_m))

    w1, change = drop_w - 4.0, 1e-5
    # p at the drop decides: what a metre costs is the same on both sides of it
    at_drop = p1 + 0.5 * price / strong * (1.0 / 12.0 - 1.0 / math.sqrt(w1))
    helps = -(returned + 2.0 * at_drop) * strong < -returned * weak
    brakes = weak + friction if helps else weak
    assert helps == (p1 > -0.2)
    (ahead_w, ahead), (behind_w, behind) = back(w1 - change, brakes), back(w1 - 2.0 * change, brakes)
    step = Step(length, 0.0, 0.0, price, returned, math.inf, math.inf, 1.0, 400.0, drop_w, 0.0)
    w0, p0 = saturated_image(train, DYNAMIC, step, length, w1 - 1.5 * change, p1)
    assert w0 == pytest.approx(0.5 * (ahead_w + behind_w), rel=1e-6)
    assert p0 == pytest.approx((ahead - behind + p1 * change) / (ahead_w - behind_w), rel=5e-3)
