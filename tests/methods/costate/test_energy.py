"""The front method where energy is counted at the pantograph: efficiencies, regeneration, auxiliary power."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import tgvdp
from tests.helpers.fronts import cheapest_above_grid, check_front, feasible_seeds, feasible_trip, front_at, front_to
from tests.helpers.trips import commuter, references, trip_on
from tgvdp import Track, Train
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate.front import optimal_front
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.refine.front import refine_front
from tgvdp.model.effort import EffortCurve
from tgvdp.model.energy import PANTOGRAPH
from tgvdp.model.train import BrakingRate
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.profile import profile_of

HILLS = trip_on([(0, 35), (6000, 22)], [(0, 0), (2000, 12), (4000, -9), (8000, 3)])


def charged(trip, traction=1.0, regeneration=0.0, auxiliary_w=0.0):
    """The trip, charged at the pantograph by these efficiencies."""
    train = replace(
        trip.train,
        traction_efficiency=traction,
        regeneration_efficiency=regeneration,
        auxiliary_power_w=auxiliary_w,
    )
    return replace(trip, train=train, energy=PANTOGRAPH)


def test_meets_every_reference(shared):
    """Energies of independent direct transcription with efficiencies and regeneration (variant B)."""
    count = 0
    for trip, seconds, joules in references(shared, "B"):
        found = front_at(replace(trip, energy=PANTOGRAPH), seconds)
        above_j = found.energy_j + found.multiplier_j_per_s * (found.duration_s - seconds) - joules
        metro = trip.train.max_speed_mps < 25.0
        most_j = np.where(np.abs(joules) < 15 * 3.6e6, 0.02 * 3.6e6, (2e-3 if metro else 1e-3) * np.abs(joules))
        assert (above_j <= most_j).all(), (trip.origin_m, above_j / joules)
        assert (above_j >= -3e-4 * np.abs(joules)).all(), (trip.origin_m, above_j / joules)
        count += len(seconds)
    assert count == 90


def test_without_losses_and_returns_it_is_the_energy_at_the_wheel():
    _, wheel = front_to(HILLS, 0.25, 12)
    _, found = front_to(charged(HILLS), 0.25, 12)
    for name in ("duration_s", "energy_j", "multiplier_j_per_s"):
        assert getattr(found, name).tolist() == getattr(wheel, name).tolist()


def test_losses_of_traction_alone_change_energy_and_price_in_proportion():
    _, wheel = front_to(HILLS, 0.25, 12)
    _, found = front_to(charged(HILLS, 0.5), 0.25, 12)
    assert found.duration_s == pytest.approx(wheel.duration_s, rel=1e-9)
    assert found.energy_j == pytest.approx(2.0 * wheel.energy_j, rel=1e-9)
    assert found.multiplier_j_per_s == pytest.approx(2.0 * wheel.multiplier_j_per_s, rel=1e-6)


def test_auxiliary_power_adds_to_energy_and_lowers_the_price():
    """The best run for a running time is the same: E + P·T, whose slope is −(λ − P)."""
    auxiliary_w = 2e5
    _, plain = front_to(charged(HILLS, 0.9, 0.7), 0.25, 12)
    _, found = front_to(charged(HILLS, 0.9, 0.7, auxiliary_w), 0.25, 12)
    count = len(found.duration_s)
    assert count >= 10
    assert found.duration_s == pytest.approx(plain.duration_s[:count], rel=1e-6)
    expected_j = plain.energy_j[:count] + auxiliary_w * found.duration_s
    expected_j += plain.multiplier_j_per_s[:count].clip(max=1e9) * (plain.duration_s[:count] - found.duration_s)
    assert found.energy_j == pytest.approx(expected_j, rel=1e-6)
    assert found.multiplier_j_per_s[1:] == pytest.approx(plain.multiplier_j_per_s[1:count] - auxiliary_w, rel=0.05)


def test_the_front_ends_where_a_second_more_costs_nothing():
    """At λ = 0 auxiliaries take all that a slower run would save: there is a thriftiest run, and no slower point."""
    trip = charged(HILLS, 0.9, 0.7, 1e6)
    fastest = fastest_run(trip)
    found = optimal_front(trip, fastest, fastest.duration_s * np.linspace(1.0, 3.0, 60), SearchBudget())
    assert found.exhausted
    assert found.multiplier_j_per_s[-1] == 0.0
    assert found.duration_s[-1] < 1.8 * fastest.duration_s
    assert (np.diff(found.energy_j) < 0.0).all()
    free = charged(HILLS, 0.9, 0.7)
    for share in (0.98, 1.02):  # faster and slower ones, by the front without auxiliaries, are dearer
        run = front_at(free, [share * found.duration_s[-1]])
        assert run.energy_j[0] + 1e6 * run.duration_s[0] > found.energy_j[-1]


DOWNHILL = trip_on([(0, 40), (7000, 25)], [(0, -4), (3000, -14), (6000, -2)])


def test_net_energies_around_and_below_zero():
    """What counts is the scale of the energies that are exchanged, not that of their difference."""
    trip = charged(DOWNHILL, 0.9, 0.8)
    fastest, found = check_front(trip, 0.5, 40)
    assert found.energy_j[0] > 0.0 > found.energy_j[-1]
    assert len(found.duration_s) == 40
    refined = refine_front(trip, fastest, found.duration_s[5::8], SearchBudget())
    above_j = refined.energy_j + refined.multiplier_j_per_s * (refined.duration_s - found.duration_s[5::8])
    exchanged_j = fastest.balance.pantograph_j + 2.0 * fastest.balance.regenerated_j
    assert (found.energy_j[5::8] - above_j <= 2e-3 * exchanged_j).all()
    assert (above_j - found.energy_j[5::8] <= 5e-3 * exchanged_j).all()


def test_both_holding_speeds_have_closed_forms():
    """Partial traction holds v with λ = v²·R'(v)/η_t, partial regeneration with λ = η_r·v²·R'(v)."""
    line = trip_on([(0, 60)], [(0, 0), (15e3, -20), (30e3, 0)], length_m=40e3)
    trip = charged(line, 0.9, 0.8)
    train = trip.train
    mesh = Mesh.of(trip, fastest_run(trip))
    for factor, first_m, last_m in ((1.0 / 0.9, 4e3, 6.5e3), (0.8, 22e3, 28e3)):
        speed = 30.0
        multiplier = factor * speed**2 * (train.davis_b_n_per_mps + 2.0 * train.davis_c_n_per_mps2 * speed)
        counters = {"extremals": 0, "runs": 0, "costates": 0}
        extremal = mesh.extremal(multiplier, counters)
        *_, x_m, w = mesh.drive(extremal.switch, counters)
        held = (x_m > first_m) & (x_m < last_m)
        assert held.sum() > 3
        assert np.sqrt(w[held]) == pytest.approx(speed, rel=3e-3)


@pytest.mark.parametrize(
    ("rates", "end_speed_mps"),
    [
        ([BrakingRate(0.0, 0.85)], 8.0),  # the dynamic brake lacks a little of what they ask for
        ([BrakingRate(0.0, 0.6), BrakingRate(12.0, 2.0)], 0.0),  # and much of it, but for the last stretch
    ],
)
def test_slow_runs_need_no_friction_brake(rates, end_speed_mps):
    """They brake by the dynamic brake alone, to the very place from which it suffices: the end, or a step of rates."""
    dynamic = EffortCurve.from_caps(0.8 * commuter().inertia_kg)
    train = replace(commuter(), braking=dynamic, friction_brake_n=1e6, braking_rates=tuple(rates))
    trip = charged(trip_on([(0, 25)], length_m=2000.0, train=train, end_speed_mps=end_speed_mps), 0.9, 0.8)
    _, found = check_front(trip, 0.3, 8)
    for index in range(3, 8):
        balance = profile_of(trip, *found.rows(index)).balance
        by_friction_j = balance.braking_losses_j + balance.regenerated_j - balance.regenerated_j / 0.8
        assert by_friction_j <= 1e-5 * balance.regenerated_j


SHAPES = {
    "hills": HILLS,
    "downhill": DOWNHILL,
    "steep": trip_on([(0, 35)], [(0, 0), (2000, 30), (3500, -35), (6000, 0)]),
    "limits": trip_on([(0, 30), (2000, 12), (2200, 40), (7000, 25), (9900, 8)]),
    "moving ends": trip_on([(0, 40), (5000, 20)], start_speed_mps=25.0, end_speed_mps=18.0),
    "metro": trip_on([(0, 22), (900, 15)], [(0, 4), (400, -6)], length_m=1500.0),
    "comfort": trip_on([(0, 30), (4000, 20)], train=commuter(max_acceleration_mps2=0.4, max_deceleration_mps2=0.5)),
}


@pytest.mark.parametrize("name", SHAPES)
def test_no_plain_grid_is_better(name):
    assert cheapest_above_grid(charged(SHAPES[name], 0.85, 0.75)) <= 1e-3


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    feasible_seeds,
    st.sampled_from([0.05, 0.25, 1.0]),
    st.floats(0.5, 1.0),
    st.floats(0.0, 1.0),
    st.sampled_from([0.0, 0.2]),
)
def test_every_front_is_sound(seed, margin, traction, regeneration, share):
    trip = feasible_trip(seed)
    if trip is not None:
        fastest = fastest_run(trip)
        auxiliary_w = share * fastest.total_energy_j / fastest.duration_s
        check_front(charged(trip, traction, regeneration, auxiliary_w), margin, 20)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(feasible_seeds)
def test_no_front_is_worse_than_a_grid(seed):
    trip = feasible_trip(seed)
    if trip is not None and len(trip.track.speed_limits) + len(trip.track.gradients) < 40:
        assert cheapest_above_grid(charged(trip, 0.85, 0.75)) <= 2e-3


def test_a_train_without_dynamic_brake_returns_nothing():
    trip = replace(HILLS, train=replace(HILLS.train, braking=EffortCurve.from_caps(0.0), friction_brake_n=3e5))
    _, plain = front_to(charged(trip, 0.9, 0.0), 0.25, 8)
    _, found = front_to(charged(trip, 0.9, 0.8), 0.25, 8)
    assert found.energy_j.tolist() == plain.energy_j.tolist()


def test_cells_however_short_leave_friction_to_the_brakes_that_need_it():
    """At speed b falls by little within a short cell: runs followed it by friction, 70 % dearer at worst."""
    train = Train(
        mass_kg=840e3, traction=EffortCurve.from_caps(330e3, 12e6), davis_a_n=9500.0, davis_b_n_per_mps=100.0,
        davis_c_n_per_mps2=5.7, friction_brake_n=800e3, braking=EffortCurve.from_caps(260e3, 9e6),
        traction_efficiency=0.83, regeneration_efficiency=0.8,
    )  # fmt: skip
    track = Track(length_m=16e3, speed_limits=((0.0, 98.0),))
    result = tgvdp.search(train, track, points=2, energy="pantograph", start_speed_mps=69.0, end_speed_mps=6.0)
    multiplier = 50e6
    counters = {"extremals": 0, "runs": 0, "costates": 0}
    costs = [
        Mesh.of(result.trip, result.fastest.profile, fineness).extremal(multiplier, counters).cost_j(multiplier)
        for fineness in (1.0, 16.0)
    ]
    assert costs[1] <= costs[0]
