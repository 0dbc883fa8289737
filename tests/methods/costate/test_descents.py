"""Descents that the dynamic brake cannot hold: at the speed at which it returns most for the time, or at the limit."""

from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tgvdp import EffortCurve, Track, Train
from tgvdp.methods.costate.characteristics import held_back_w
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.model.track import NeutralSection
from tgvdp.physics.forces import kernel_train, per_kilogram

TRAIN = Train(
    mass_kg=2e6, traction=EffortCurve.from_caps(400e3, 5e6), braking=EffortCurve.from_caps(300e3, 3.6e6),
    friction_brake_n=800e3, davis_a_n=25e3, davis_b_n_per_mps=200.0, davis_c_n_per_mps2=30.0,
    rotating_mass_factor=1.06, traction_efficiency=0.87, regeneration_efficiency=0.8,
)  # fmt: skip
DESCENT = Track(
    length_m=50e3,
    speed_limits=((0.0, 22.2),),
    gradients=((0.0, 0.0), (10e3, -27.0), (30e3, 0.0), (35e3, 8.0)),
)
#: At the corner of the dynamic brake it returns 300 kN over a metre, above it less.
CORNER_MPS = 12.0


@pytest.fixture(scope="module")
def found():
    return tgvdp.search(TRAIN, DESCENT, energy="pantograph", at_s=(2900.0, 3348.9, 3800.0))


def test_what_was_missed_is_found(found):
    """The wall of the limit alone gave 159.8 kWh at 3348.9 s."""
    index = found.front.at_delay(3349.0 - found.fastest.time_s, found.fastest.time_s)
    assert found.front.energy_j[index] / 3.6e6 <= -315.5
    assert all(verdict.ok for verdict in found.verify())


def test_the_descent_is_run_at_the_corner(found):
    profile = found.profile(len(found.front.time_s) - 1)
    speed_mps = np.interp(np.linspace(12e3, 27e3, 50), profile.position_m, profile.speed_mps)
    assert speed_mps == pytest.approx(CORNER_MPS, rel=1e-6)


def test_no_run_lies_below(found):
    certificate = found.certify()
    assert (certificate.gap_pct >= -1e-3).all()


def test_a_limit_cannot_save_energy(found):
    """A limit of 12 m/s on the descent gave −215 kWh where the line without it gave 159.8."""
    limited = Track(
        length_m=50e3,
        speed_limits=((0.0, 22.2), (10e3, CORNER_MPS), (30e3, 22.2)),
        gradients=DESCENT.gradients,
    )
    other = tgvdp.search(TRAIN, limited, energy="pantograph", at_s=(3800.0,))
    price_j_per_s = found.price_kwh_per_min[-1] * 3.6e6 / 60.0
    late_s = found.front.time_s[-1] - other.front.time_s[-1]
    assert found.front.energy_j[-1] + price_j_per_s * late_s <= other.front.energy_j[-1] + 1e-3 * 300 * 3.6e6


def test_friction_holds_the_train_back_where_there_is_no_current():
    """Faster than that, the dynamic brake returns less behind the section: coasting through it cost 2 % more."""
    dark = replace(DESCENT, neutral_sections=(NeutralSection(20e3, 600.0, False),))
    limited = replace(dark, speed_limits=((0.0, 22.2), (20e3, 13.0), (20.6e3, 22.2)))
    front, other = (tgvdp.search(TRAIN, track, energy="pantograph", at_s=(3348.9, 3800.0)) for track in (dark, limited))
    assert (front.front.energy_j <= other.front.energy_j - 5e-4 * np.abs(other.front.energy_j)).all()
    assert front.certify().gap_pct.max() < 0.06
    assert all(verdict.ok for verdict in front.verify())


def test_where_all_speeds_cost_the_same_runs_do_not_saw():
    """A second is worth what the brake returns in it: the speed that is held is any one, but not any in each cell."""
    train = replace(TRAIN, braking=EffortCurve.from_caps(360e3, 5e6))
    track = Track(
        length_m=22e3,
        speed_limits=((0.0, 21.0), (11e3, 26.0)),
        gradients=((0.0, 0.0), (3e3, -24.0), (19.4e3, -18.0)),
    )
    found = tgvdp.search(train, track, energy="pantograph", points=10, max_margin=0.6)
    assert found.counters["short"] <= 3  # 292 they were
    assert all(verdict.ok for verdict in found.verify())


@pytest.mark.parametrize("multiplier", [0.01, 0.1, 0.7, 2.0])
def test_speed_that_is_held_back_costs_least_per_metre(multiplier):
    """λ/v − r·D(v) against samples, for a brake whose power is capped and one of a table."""

    for braking in (
        EffortCurve.from_caps(300e3, 3.6e6),
        EffortCurve.from_points([(0, 0), (3, 200e3), (20, 260e3), (40, 90e3)]),
    ):
        train = per_kilogram(kernel_train(Train(mass_kg=2e6, traction=TRAIN.traction, braking=braking)))
        v = np.linspace(0.05, 30.0, 30_000)
        cost = multiplier / v - 0.7 * np.array([braking.effort_n(x) for x in v]) / 2e6
        held_mps = np.sqrt(held_back_w(train, 0.7, multiplier, 900.0))
        assert np.interp(held_mps, v, cost) <= cost.min() + 1e-4 * abs(cost.min())


@pytest.mark.parametrize("dynamic_n", [36e3, 150e3])
def test_a_trip_may_start_on_a_descent_that_the_dynamic_brake_cannot_hold(dynamic_n):
    """From a standstill that brake alone passes the speed at which it begins: it is no braking curve then."""
    train = Train(
        mass_kg=860e3, rotating_mass_factor=1.06, traction=EffortCurve.from_caps(730e3, 5.57e6),
        braking=EffortCurve.from_caps(dynamic_n, 5.57e6), friction_brake_n=500e3, davis_a_n=8600.0,
        davis_c_n_per_mps2=7.8, traction_efficiency=0.85, regeneration_efficiency=0.6,
    )  # fmt: skip
    track = Track(length_m=12e3, speed_limits=((0.0, 40 / 3.6),), gradients=((0.0, -25.0),))
    result = tgvdp.search(train, track, energy="pantograph", points=6)
    assert all(verdict.ok for verdict in result.verify())
    assert result.certify().gap_pct.max() < 0.3


@pytest.mark.parametrize("fineness", [1.0, 4.0, 16.0])
def test_seconds_at_the_price_of_the_power_returned(fineness):
    """There all speeds cost the same where the brake's power is capped, and costates had any sign: 6 kWh of 100.

    On finer meshes, where p bent between points of braking that were far apart, up to 4 kWh of 500.
    """
    train = Train(
        mass_kg=1.5e6, traction=EffortCurve.from_caps(330e3), braking=EffortCurve.from_caps(265e3, 2.2e6),
        friction_brake_n=790e3, rotating_mass_factor=1.05, davis_a_n=22e3, davis_b_n_per_mps=250.0,
        davis_c_n_per_mps2=23.0, traction_efficiency=0.84, regeneration_efficiency=0.8,
    )  # fmt: skip
    track = Track(
        length_m=16e3,
        speed_limits=((0.0, 16.7), (12e3, 12.5)),
        gradients=((0.0, 0.0), (5e3, 15.0), (6.2e3, -20.0), (7e3, -24.0), (10e3, -37.0), (13e3, 0.0)),
    )
    result = tgvdp.search(train, track, energy="pantograph", points=2)
    mesh = Mesh.of(result.trip, result.fastest.profile, fineness)
    multipliers = 0.8 * 2.2e6 * np.array([0.98, 0.999, 1.0, 1.001, 1.005, 1.02])
    extremals = mesh.extremals(multipliers.tolist(), {"extremals": 0, "runs": 0, "costates": 0})
    costs_j = np.array([[one.cost_j(multiplier) for one in extremals] for multiplier in multipliers])
    assert (costs_j.diagonal() - costs_j.min(axis=1)).max() <= 0.1 * 3.6e6
