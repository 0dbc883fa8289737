"""Trips at the edge of what a train can do, on which fronts once failed: brakes that barely hold, climbs that slow a
train down by more than comfort allows, rows of rounding errors, and multipliers far above the usual ones."""

import math
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from benchmarks.proof.trips import proof_trip
from tests.helpers.fronts import counters, front_to
from tests.helpers.trips import commuter, trip_on
from tgvdp import Track, Train
from tgvdp.errors import InfeasibleError
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.model.effort import EffortCurve
from tgvdp.model.energy import PANTOGRAPH
from tgvdp.physics.cell import Rows
from tgvdp.referee.replay import replay
from tgvdp.runs.braking_point import drop_slivers
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.profile import profile_of

NO_DYNAMIC_BRAKE = EffortCurve.from_caps(0.0)


def failing(trip, found):
    return [i for i in range(len(found.duration_s)) if not replay(trip, profile_of(trip, *found.rows(i))).ok]


@pytest.mark.parametrize("permil", [20.0, 30.0, 38.0])
@pytest.mark.parametrize("excess", [1.005, 1.05])
def test_brakes_that_barely_hold_on_a_descent(permil, excess):
    """Coasting there gains so much speed that most of the braking curve is met by no run from below it."""
    holds_n = 3e5 * 9.81 * 0.024
    train = commuter(friction_brake_n=excess * holds_n, braking=NO_DYNAMIC_BRAKE, davis_a_n=0.0)
    gradients = [(0, 0), (1000, permil), (5200, 12), (7400, -24)]
    trip = trip_on([(0, 20)], gradients, length_m=8500.0, train=train)
    fastest, found = front_to(trip, 0.25, 24)
    assert not failing(trip, found)
    mesh, counters = Mesh.of(trip, fastest), {"extremals": 0, "runs": 0, "costates": 0}
    for multiplier in mesh.usual_multiplier * np.array([1.0, 0.1, 0.01]):
        assert np.isfinite(mesh.extremal(multiplier, counters).switch).all()


@pytest.mark.parametrize("permil", [55.0, 60.0])
def test_a_climb_that_slows_down_more_than_comfort_allows_may_be_coasted(permil):
    train = commuter(max_deceleration_mps2=0.5)
    trip = trip_on([(0, 28)], [(0, 0), (2000, permil), (2600, 0), (6000, permil), (6300, 0)], train=train)
    _, found = front_to(trip, 0.25, 24)
    assert not failing(trip, found)
    for index in range(len(found.duration_s)):
        profile = profile_of(trip, *found.rows(index))
        gains = np.diff(profile.speed_mps**2) / (2.0 * np.diff(profile.position_m))
        braked = profile.force_n[:-1] < -1e-6 * train.traction.effort_n(0.0)
        assert gains[braked].min() >= -0.5 * (1.0 + 1e-6)
    assert gains.min() < -0.51


def test_braking_at_the_comfort_limit_against_linear_resistance_alone():
    train = commuter(
        davis_a_n=0.0, davis_b_n_per_mps=210.0, davis_c_n_per_mps2=0.0, max_deceleration_mps2=0.5,
        braking=NO_DYNAMIC_BRAKE, friction_brake_n=2.5e5,
    )  # fmt: skip
    trip = trip_on([(0, 35)], length_m=20e3, train=train)
    assert replay(trip, fastest_run(trip)).ok


@pytest.mark.parametrize(
    ("row_m", "w", "kept"),
    [
        (1e-10, 99.0, False),  # rounding, whatever it claims
        (5e-7, 100.0 * (1.0 - 1e-8), False),  # too short to say what the effort is
        (5e-7, 99.0, True),  # short, but it changes the speed that is held afterwards
        (5e-6, 100.0 * (1.0 - 1e-8), False),  # some jump of the effort may lie between
        (5e-6, 100.0 * (1.0 - 1e-6), True),
        (5e-5, 100.0 * (1.0 - 1e-8), True),
    ],
)
def test_rows_of_rounding_errors_are_merged(row_m, w, kept):
    xs, ws = np.array([0.0, 0.5, 0.5 + row_m, 1.0]), np.array([100.0, 100.0, w, 98.0])
    n = drop_slivers(Rows(xs, ws), 1, 4, 1.0)
    assert n == (4 if kept else 3)
    assert (xs[n - 1], ws[n - 1]) == (1.0, 98.0)


def test_the_mesh_is_fine_enough_for_prices_far_above_the_usual():
    """The first point of this front costs seven times the usual price of a second."""
    train = commuter(
        mass_kg=2.6e5, davis_a_n=5900.0, davis_b_n_per_mps=110.0, davis_c_n_per_mps2=9.3, max_speed_mps=math.inf,
        traction=EffortCurve.from_points([(0, 8.2e4), (12, 6.5e4), (36, 2.45e4), (120, 6.5e3)]),
        braking=EffortCurve.from_points([(0, 4.1e4), (12, 7.3e4), (120, 8e3)]), friction_brake_n=1.4e5,
        traction_efficiency=0.78, regeneration_efficiency=0.5,
    )  # fmt: skip
    limits = [(0, 22), (1750, 36), (2600, 18), (3800, 25), (5100, 40)]
    trip = trip_on(limits, [(0, 10), (2000, -10), (4000, 5)], length_m=6400.0, train=train)
    trip = replace(trip, energy=PANTOGRAPH)
    fastest, found = front_to(trip, 0.25, 24)
    mesh, counters = Mesh.of(trip, fastest, 8.0), {"extremals": 0, "runs": 0, "costates": 0}
    multiplier = float(found.multiplier_j_per_s[1])
    cost_j = found.energy_j[1] + multiplier * found.duration_s[1]
    assert cost_j - mesh.extremal(multiplier, counters).cost_j(multiplier) <= 5e-4 * found.energy_j[1]


@pytest.mark.parametrize("fineness", [0.125, 0.25, 0.5])
def test_a_strong_train_is_not_slow_to_start_on_a_coarse_mesh(fineness):
    """After a rise of the limit it needs a fraction of a cell; where nothing resists, holding is coasting."""
    train = commuter(
        mass_kg=3.3e4, davis_a_n=0.0, davis_b_n_per_mps=0.0, davis_c_n_per_mps2=0.0, braking=NO_DYNAMIC_BRAKE,
        traction=EffortCurve.from_caps(9.5e4, 2.5e6), friction_brake_n=1.6e4,
    )  # fmt: skip
    trip = trip_on([(0, 40), (120, 14), (530, 5), (1920, 44)], length_m=2084.0, train=train)
    fastest = fastest_run(trip)
    counters = {"extremals": 0, "runs": 0, "costates": 0}
    mesh, fine = (Mesh.of(trip, fastest, cells) for cells in (fineness, 8.0))
    multiplier = 5.0 * mesh.usual_multiplier
    reference = fine.extremal(multiplier, counters)
    assert (
        mesh.extremal(multiplier, counters).cost_j(multiplier) - reference.cost_j(multiplier)
        <= 1e-3 * reference.energy_j
    )


def barely_climbable(share):
    """10 km of a climb that takes a share of the starting effort of a train, rolling resistance included."""
    train = commuter(davis_a_n=4e3)
    permil = 1e3 * (share * 2.5e5 - 4e3) / (train.mass_kg * 9.81)
    return trip_on([(0, 30)], [(0, permil)], train=train)


@pytest.mark.parametrize("share", [0.9, 0.99, 0.999])
def test_a_line_that_is_barely_climbed_still_saves_by_time(share):
    trip = barely_climbable(share)
    fastest, found = front_to(trip, 1.0, 6)
    assert len(found.duration_s) == 6
    assert not found.exhausted
    assert (np.diff(found.energy_j) < 0.0).all()
    assert replay(trip, profile_of(trip, *found.rows(5))).ok
    assert found.duration_s[5] == pytest.approx(2.0 * fastest.duration_s, rel=2e-2)


def test_a_line_that_takes_all_effort_is_not_climbed():
    with pytest.raises(InfeasibleError, match="stalls at 0 m"):
        fastest_run(barely_climbable(1.0))


@pytest.mark.parametrize("seed", [20149, 20210])
def test_no_brakes_where_the_train_slows_down_by_more_than_its_braking_rate_anyway(seed):
    """Rows of one effort make up for nothing at their end: there braking is not allowed, however little of it."""
    drawn = proof_trip(seed)
    result = tgvdp.search(drawn.train, drawn.track, points=6, **drawn.options)
    assert all(verdict.ok for verdict in result.verify())


def test_a_train_for_which_no_slower_run_saves_has_its_fastest_run_alone():
    """It creeps: one extremal is all there is, and nothing lies between it and another."""
    train = tgvdp.load_train("alstom-emu")
    result = tgvdp.search(replace(train, max_speed_mps=1e-6 * train.max_speed_mps), "lgv-100km", points=4)
    assert result.complete
    assert len(result.front) == 1


def test_runs_that_coast_nearly_to_a_stand_meet_their_line_of_switching():
    """On a long climb they would stand soon behind it, from where on coasting looks alike everywhere."""
    margins = [3.0, 10.0, 40.0]
    result = tgvdp.search("tgv", "lgv-100km", at_margin=margins)
    assert result.front.time_s == pytest.approx(result.fastest.time_s * (1.0 + np.array(margins)), rel=1e-5)
    assert all(verdict.ok for verdict in result.verify())
    assert (np.diff(result.front.energy_j) < 0.0).all()


@pytest.mark.parametrize("share", [0.05, 0.03])
def test_a_line_of_switching_does_not_fall_below_its_end_in_a_long_cell(share):
    """It bends as coasting does, and a light train comes to a stand on the way: below 0 no run met it, and stalled."""
    trolley = Train(
        mass_kg=320.0, rotating_mass_factor=1.12, traction=EffortCurve.from_caps(206.0, 6e3), friction_brake_n=900.0,
        davis_a_n=12.0, davis_c_n_per_mps2=0.4,
    )  # fmt: skip
    permil = np.random.default_rng(24).uniform(-38.0, 22.0, 100)
    gradients = tuple((400.0 * k, float(value)) for k, value in enumerate(permil))
    result = tgvdp.search(trolley, Track(length_m=40e3, speed_limits=((0.0, 44.0),), gradients=gradients), points=2)
    coarse, fine = (Mesh.of(result.trip, result.fastest.profile, fineness) for fineness in (0.125, 4.0))
    multiplier = share * coarse.usual_multiplier
    least_j, cost_j = (mesh.extremal(multiplier, counters()).cost_j(multiplier) for mesh in (fine, coarse))
    assert cost_j < 1.02 * least_j


@pytest.mark.parametrize("permil", [-39.8, -42.0])
def test_where_not_even_all_brakes_hold_a_train_they_brake_no_harder(permil):
    """Rows ended where the train passed the line of friction from below, and the next ones went over the rest again."""
    freight = Train(
        mass_kg=3.17e6, rotating_mass_factor=1.06, traction=EffortCurve.from_caps(773e3, 7.15e6),
        braking=EffortCurve.from_caps(600e3, 5.38e6), friction_brake_n=564e3, davis_a_n=38e3, davis_b_n_per_mps=635.0,
        davis_c_n_per_mps2=21.4, max_speed_mps=20.3, max_acceleration_mps2=0.5, traction_efficiency=0.85,
        regeneration_efficiency=0.9,
    )  # fmt: skip
    track = Track(
        length_m=4e3, speed_limits=((0.0, 20.3), (1860.0, 10.16)),
        gradients=((0.0, 0.0), (1700.0, permil), (2130.0, 0.0)),
    )  # fmt: skip
    result = tgvdp.search(freight, track, energy="pantograph", points=20, max_margin=0.6)
    assert all(verdict.ok for verdict in result.verify())
    assert max(verdict.effort_excess_pct for verdict in result.verify()) < 0.02


@pytest.mark.parametrize("seed", [9, 10, 46])
def test_slow_runs_that_have_to_arrive_at_speed_ask_for_no_more_effort_than_there_is(seed):
    """Below the slowest run that still arrives so, the last metres of a cell made up for it: up to 8 % too much."""
    train = Train(
        mass_kg=360e3, traction=EffortCurve.from_caps(230e3, 5e6), friction_brake_n=400e3, davis_a_n=4000.0,
        davis_b_n_per_mps=60.0, davis_c_n_per_mps2=7.0, max_speed_mps=70.0, max_acceleration_mps2=0.5,
    )  # fmt: skip
    rng = np.random.default_rng(seed)
    gradients = tuple((500.0 * k, float(value)) for k, value in enumerate(rng.uniform(-12.0, 12.0, 40)))
    track = Track(length_m=20e3, speed_limits=((0.0, 70.0),), gradients=gradients)
    result = tgvdp.search(train, track, points=20, max_margin=1.5, end_speed_mps=float(rng.uniform(25.0, 40.0)))
    assert max(verdict.effort_excess_pct for verdict in result.verify()) < 0.05
