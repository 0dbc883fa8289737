"""Rows cut where motion bends, against motion that has a closed form, and what many runs are asked in one call."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.fronts import front_at
from tests.helpers.trips import commuter, trip_on
from tgvdp.line.resolved import resolve
from tgvdp.model.convention import Convention
from tgvdp.model.effort import EffortCurve
from tgvdp.model.energy import PANTOGRAPH, WHEEL
from tgvdp.model.track import NeutralSection, Track
from tgvdp.model.train import BrakingRate, Train
from tgvdp.model.trip import Trip
from tgvdp.physics.forces import kernel_train, mean_resistance
from tgvdp.referee.replay import replay
from tgvdp.runs.batch import Batch, totals_of
from tgvdp.runs.bends import cut_at_bends, most_off_s
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.profile import profile_of
from tgvdp.runs.resistance_correction_kernel import cut_rows

pytestmark = pytest.mark.nojit

#: 1000 t with quadratic drag alone: it coasts by v = v₀·exp(−C·x/m).
DRAG = Train(mass_kg=1e6, traction=EffortCurve.from_caps(2e5, 4e6), friction_brake_n=4e5, davis_c_n_per_mps2=40.0)
LEVEL = Track(length_m=20e3, speed_limits=((0.0, 60.0),))


def level_trip(train, **speeds):
    return Trip(train=train, track=LEVEL, origin_m=0.0, destination_m=LEVEL.length_m, **speeds)


def coasting(rows):
    """Rows of a train that coasts from 40 m/s, and their time, s."""
    x_m = np.linspace(0.0, LEVEL.length_m, rows + 1)
    speed_mps = 40.0 * np.exp(-DRAG.davis_c_n_per_mps2 / DRAG.inertia_kg * x_m)
    time_s = DRAG.inertia_kg / DRAG.davis_c_n_per_mps2 * (1.0 / speed_mps[-1] - 1.0 / speed_mps[0])
    return x_m, speed_mps**2, time_s


@pytest.mark.parametrize("rows", [60, 120, 240])
def test_a_train_that_coasts_takes_the_time_of_its_motion(rows):
    x_m, w, time_s = coasting(rows)
    trip = level_trip(DRAG, start_speed_mps=40.0, end_speed_mps=math.sqrt(w[-1]))
    runs, parts = cut_at_bends(DRAG, resolve(trip), Batch.of([(x_m, w), (x_m, w)]))
    assert time_s - profile_of(trip, x_m, w).duration_s == pytest.approx(81.7 / rows**2, rel=0.01)
    assert (parts[:-1].sum() + 1 == len(runs.x_m)) and parts[rows] == parts[-1] == 1
    for cut_m, cut_w in runs.runs():
        assert np.isin(x_m, cut_m).all()
        assert profile_of(trip, cut_m, cut_w).duration_s == pytest.approx(time_s, abs=7e-4)
        motion_w = 1600.0 * np.exp(-2.0 * DRAG.davis_c_n_per_mps2 / DRAG.inertia_kg * cut_m)
        assert cut_w == pytest.approx(motion_w, rel=1e-6)


def test_parts_of_a_row_share_what_they_miss_its_end_by():
    """Drag slows a light train with 4 m/s²: parts of a row that coasts all have one effort, next to none of it."""
    light = replace(DRAG, mass_kg=1e3, davis_c_n_per_mps2=2.0)
    slowed = light.davis_c_n_per_mps2 * 40.0 / light.inertia_kg
    x_m, w = np.array([0.0, 40.0]), 45.0**2 * np.array([1.0, (1.0 - slowed) / (1.0 + slowed)])
    cut_m, cut_w = np.empty((2, 6))
    trip = replace(level_trip(light, start_speed_mps=45.0, end_speed_mps=math.sqrt(w[-1])), destination_m=40.0)
    assert cut_rows(kernel_train(light), resolve(trip), x_m, w, np.array([5]), cut_m, cut_w) == 6
    force_n = profile_of(trip, cut_m, cut_w).force_n[:-1]
    np.testing.assert_allclose(force_n, force_n[0], rtol=2e-3)
    assert 0.0 < -force_n[0] < 3e-3 * light.davis_c_n_per_mps2 * w[-1]


@pytest.mark.parametrize("backwards", [False, True])
def test_parts_next_to_a_standstill_share_it_too(backwards):
    """Resistance that is linear in the speed makes no parabola there; the last part took 4 ms too long."""
    train = replace(DRAG, davis_b_n_per_mps=300.0, davis_c_n_per_mps2=0.0)
    known, permil = kernel_train(train), (-35.0 if backwards else 35.0)
    track = replace(LEVEL, gradients=((0.0, permil),))
    load_n = mean_resistance(known, 0.0, 0.0, 0.8) + train.mass_kg * 9.81 * 1e-3 * permil
    length_m = 0.5 * train.inertia_kg * 0.64 / abs(load_n)
    w = np.array([0.0, 0.64] if backwards else [0.64, 0.0])
    ends = dict(zip(("start_speed_mps", "end_speed_mps"), np.sqrt(w).tolist(), strict=True))
    trip = Trip(train=train, track=track, origin_m=0.0, destination_m=length_m, **ends)
    cut_m, cut_w = np.empty((2, 6))
    assert cut_rows(known, resolve(trip), np.array([0.0, length_m]), w, np.array([5]), cut_m, cut_w) == 6
    force_n = profile_of(trip, cut_m, cut_w).force_n[:-1]
    assert abs(force_n).max() <= 1e-6 * abs(load_n)


def test_a_line_that_alone_does_more_than_comfort_allows_is_cut():
    """Coasting downhill next to standstill bends most, whatever the effort may do."""
    train = replace(DRAG, davis_a_n=2e4, davis_b_n_per_mps=5e3, davis_c_n_per_mps2=0.0, max_acceleration_mps2=0.1)
    track = replace(LEVEL, gradients=((0.0, -35.0),))
    w = np.array([0.2, 4.0])
    load_n = mean_resistance(kernel_train(train), 0.0, *np.sqrt(w)) - train.mass_kg * 9.81 * 0.035
    length_m = 0.5 * train.inertia_kg * (w[1] - w[0]) / -load_n
    trip = Trip(
        train=train, track=track, origin_m=0.0, destination_m=length_m, start_speed_mps=math.sqrt(w[0]),
        end_speed_mps=math.sqrt(w[1]),
    )  # fmt: skip
    _, parts = cut_at_bends(train, resolve(trip), Batch.of([(np.array([0.0, length_m]), w)]))
    assert parts[0] > 1


def test_a_row_a_hair_beyond_comfort_keeps_its_acceleration():
    """Runs are joined to 1e-7 of v²; parts that kept their share of the traction were 0.16 % beyond comfort."""
    train = replace(DRAG, max_acceleration_mps2=0.5)
    v0, v1 = 50.0, 50.375
    load_n = mean_resistance(kernel_train(train), train.davis_c_n_per_mps2, v0, v1)
    pull_n = 1.03 * (0.5 * train.inertia_kg + load_n) * v0
    train = replace(train, traction=EffortCurve.from_caps(2.0 * pull_n / v0, pull_n))
    w = np.array([v0**2 * (1.0 - 5e-8), v1**2])
    x_m = np.array([0.0, v1**2 - v0**2])
    cut_m, cut_w = np.empty((2, 3))
    trip = replace(level_trip(train, start_speed_mps=w[0] ** 0.5, end_speed_mps=v1), destination_m=x_m[1])
    assert cut_rows(kernel_train(train), resolve(trip), x_m, w, np.array([2]), cut_m, cut_w) == 3
    np.testing.assert_allclose(np.diff(cut_w) / (2.0 * np.diff(cut_m)), 0.5, rtol=1e-5)


def test_what_coasts_from_a_standstill_takes_the_time_of_its_motion():
    """Parts of even length left the first of them off by 7 ms: it bends most."""
    train = replace(DRAG, davis_a_n=0.0, davis_b_n_per_mps=1e3, davis_c_n_per_mps2=0.0)
    rate, gained = train.davis_b_n_per_mps / train.inertia_kg, train.mass_kg * 9.81 * 0.02 / train.inertia_kg
    end_mps = 4.0
    time_s = -math.log1p(-rate * end_mps / gained) / rate
    length_m = (gained * time_s - end_mps) / rate
    trip = Trip(
        train=train, track=replace(LEVEL, gradients=((0.0, -20.0),)), origin_m=0.0, destination_m=length_m,
        end_speed_mps=end_mps,
    )  # fmt: skip
    rows = np.array([0.0, length_m]), np.array([0.0, end_mps**2])
    (cut, _) = cut_at_bends(train, resolve(trip), Batch.of([rows]))
    assert abs(profile_of(trip, *rows).duration_s - time_s) > 5e-3
    assert profile_of(trip, cut.x_m, cut.w).duration_s == pytest.approx(time_s, abs=1e-3)
    assert len(cut.x_m) < 40


@pytest.mark.parametrize(
    "limit", [{"max_deceleration_mps2": 1.2}, {"braking_rates": (BrakingRate(0.0, 1.2),)}], ids=["comfort", "rate"]
)
def test_partial_braking_next_to_a_limit_is_cut_straight(limit):
    """Rows whose constant effort would pass the limit somewhere stayed whole, and were 3 ms off their motion."""
    train = replace(DRAG, mass_kg=2e3, friction_brake_n=4e3, davis_c_n_per_mps2=3.0, **limit)
    x_m, w = np.array([0.0, 17.0]), np.array([81.0, 81.0 - 2.0 * 17.0 * 1.195])
    trip = replace(level_trip(train, start_speed_mps=9.0, end_speed_mps=math.sqrt(w[-1])), destination_m=17.0)
    (cut, _), off_s = cut_at_bends(train, resolve(trip), Batch.of([(x_m, w)])), []
    for rows in ((x_m, w), (cut.x_m, cut.w)):
        profile = profile_of(trip, *rows)
        off_s.append(0.01 * abs(replay(trip, profile).time_error_pct) * profile.duration_s)
    assert off_s[0] > 1e-3
    assert off_s[1] <= 5e-4
    assert (np.diff(cut.w) / np.diff(cut.x_m) == pytest.approx(-2.0 * 1.195, rel=1e-9)) and len(cut.x_m) < 8


def test_what_does_not_bend_is_left_as_it_is():
    """A speed that is held, constant forces, a comfort limit, a braking rate, and times that are right."""
    x_m = np.array([0.0, 2e3, 4e3, 8e3])
    braking_mps = np.sqrt([900.0, 700.0, 500.0, 100.0])
    constant = replace(DRAG, davis_c_n_per_mps2=0.0)
    for train, speeds in (
        (DRAG, (30.0, 30.0, 30.0, 30.0)),
        (constant, braking_mps),
        (replace(DRAG, max_deceleration_mps2=0.05), braking_mps),
        (replace(DRAG, braking_rates=((0.0, 0.05),), friction_brake_n=0.0), braking_mps),
    ):
        line = resolve(level_trip(train, start_speed_mps=speeds[0], end_speed_mps=speeds[-1]))
        runs, parts = cut_at_bends(train, line, Batch.of([(x_m, np.array(speeds) ** 2)]))
        assert parts.tolist() == [1, 1, 1, 1]
        assert runs.x_m.tolist() == x_m.tolist()
    assert most_off_s(59.0) == 0.0 < most_off_s(3600.0) < 0.02


@pytest.mark.parametrize("energy", [PANTOGRAPH, WHEEL])
def test_totals_of_many_runs_are_those_of_their_profiles(energy):
    sections = (NeutralSection(1000.0, 300.0), NeutralSection(1800.0, 200.0, True))
    hills = ((0.0, 0.0), (800.0, -6.0), (1500.0, 9.0))
    trip = Trip(
        train=replace(DRAG, regeneration_efficiency=0.7, auxiliary_power_w=5e4, length_m=400.0),
        track=Track(length_m=3000.0, speed_limits=((0.0, 60.0),), gradients=hills, neutral_sections=sections),
        origin_m=0.0, destination_m=3000.0, convention=Convention(name="strip", mass_model="strip"), energy=energy,
    )  # fmt: skip
    fastest = fastest_run(trip)
    rows = fastest.position_m - trip.origin_m, fastest.speed_mps**2
    slower = rows[0], rows[1] * 0.9
    time_s, energy_j = totals_of(trip, Batch.of([rows, slower]))
    for i, run in enumerate((rows, slower)):
        profile = profile_of(trip, *run)
        assert time_s[i] == pytest.approx(profile.duration_s, rel=1e-12)
        assert energy_j[i] == pytest.approx(profile.total_energy_j, rel=1e-10)


def test_runs_of_an_hour_are_replayed_to_a_millisecond_and_never_late():
    """At a tolerance finer than what cutting changes, too: they are aimed anew."""
    trip = Trip(
        train=replace(DRAG, mass_kg=2e6, davis_a_n=2e4),
        track=Track(length_m=60e3, speed_limits=((0.0, 25.0),), gradients=((0.0, 3.0), (20e3, -4.0), (45e3, 1.0))),
        origin_m=0.0, destination_m=60e3,
    )  # fmt: skip
    fastest = fastest_run(trip)
    target_s = fastest.duration_s * np.array([1.02, 1.1, 1.3])
    for tolerance_s in (1e-4, 1.0):
        found = front_at(trip, target_s, tolerance_s)
        assert (found.duration_s <= target_s + 1e-9).all()
        assert (found.duration_s >= target_s - tolerance_s - 1e-9).all()
        for index in range(len(target_s)):
            profile = profile_of(trip, *found.rows(index))
            verdict = replay(trip, profile)
            assert verdict.ok
            assert abs(verdict.time_error_pct) * 1e-2 * profile.duration_s <= 1e-3


def test_times_are_as_right_as_their_worth_asks_for():
    """Between the fastest run and one that hardly drives a quarter of a millisecond was worth 0.03 % of the energy."""
    train = commuter(friction_brake_n=2e5, braking=EffortCurve.from_caps(0.0), max_speed_mps=60.0)
    trip = trip_on([(0, 50.0)], length_m=2600.0, train=train, start_speed_mps=44.0)
    duration_s = fastest_run(trip).duration_s
    found = front_at(trip, duration_s + np.array([0.2, 0.6, 1.0]))
    for index, multiplier in enumerate(found.multiplier_j_per_s):
        profile = profile_of(trip, *found.rows(index))
        off_s = abs(replay(trip, profile).time_error_pct) * 1e-2 * profile.duration_s
        assert off_s * multiplier <= 1e-4 * profile.total_energy_j
