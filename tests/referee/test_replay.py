"""The referee: honest profiles pass, and every kind of forgery is caught."""

from dataclasses import replace

import numpy as np
import pytest

import tgvdp.referee.drive as drive
import tgvdp.referee.replay as referee
from tests.helpers.twins.trips import level_trip
from tgvdp.model.effort import EffortCurve
from tgvdp.model.energy import PANTOGRAPH
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.referee.replay import replay
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.profile import Profile, profile_of

TRAIN = Train(
    mass_kg=3e5,
    traction=EffortCurve.from_caps(2.5e5, 3.5e6),
    braking=EffortCurve.from_caps(1.5e5, 3e6),
    friction_brake_n=1e5,
    rotating_mass_factor=1.06,
    davis_a_n=3e3,
    davis_b_n_per_mps=30.0,
    davis_c_n_per_mps2=6.0,
    max_acceleration_mps2=0.9,
    max_deceleration_mps2=0.7,
)
PLAIN = replace(TRAIN, davis_a_n=0.0, davis_b_n_per_mps=0.0, davis_c_n_per_mps2=0.0)
TRACK = Track(
    length_m=8e3,
    speed_limits=((0, 30), (3000, 20), (3500, 40)),
    gradients=((0, 0), (1000, 8), (5000, -12.0)),
)
TRIP = Trip(train=TRAIN, track=TRACK, origin_m=0.0, destination_m=8e3)


@pytest.fixture(scope="module")
def honest():
    return fastest_run(TRIP)


def rows(profile):
    return np.array(profile.position_m), np.array(profile.speed_mps) ** 2


def test_an_honest_profile_passes(honest):
    verdict = replay(TRIP, honest)
    assert verdict.ok
    assert abs(verdict.time_error_pct) < 0.01
    assert abs(verdict.energy_error_pct) < 0.01
    assert verdict.overspeed_mps == 0.0
    assert verdict.effort_excess_pct < 0.01


def test_a_closed_form_is_met_exactly():
    train = Train(mass_kg=2.0, traction=EffortCurve.from_caps(2.0), friction_brake_n=2.0)
    profile = fastest_run(level_trip(train, 100.0, limit_mps=5.0))
    verdict = replay(level_trip(train, 100.0, limit_mps=5.0), profile)
    assert abs(verdict.time_error_pct) < 1e-9
    assert abs(verdict.energy_error_pct) < 1e-9
    assert verdict.speed_error_mps < 1e-9


def test_forged_running_time(honest):
    assert not replay(TRIP, replace(honest, time_s=honest.time_s * 0.999)).ok
    middle = np.array(honest.time_s)
    middle[len(middle) // 2] -= 0.002 * middle[-1]  # the total is honest
    verdict = replay(TRIP, replace(honest, time_s=middle))
    assert not verdict.ok
    assert verdict.time_error_pct == pytest.approx(-0.2, rel=0.1)


def test_forged_energy(honest):
    verdict = replay(TRIP, replace(honest, energy_j=honest.energy_j * 0.998))
    assert not verdict.ok
    assert verdict.energy_error_pct == pytest.approx(-0.2, rel=0.05)


def test_energy_that_the_forces_do_not_give(honest):
    """Less force in every row, and the energy to match: the speeds then come from nowhere."""
    weaker = np.where(honest.force_n > 0.0, honest.force_n * 0.98, honest.force_n)
    energy = honest.energy_j * 0.98
    assert not replay(TRIP, replace(honest, force_n=weaker, energy_j=energy)).ok


def test_overspeed(honest):
    x, w = rows(honest)
    inside = (x >= 3000.0) & (x <= 3500.0)
    assert inside.any()
    w[inside] *= 1.01
    verdict = replay(TRIP, profile_of(TRIP, x, w))
    assert not verdict.ok
    assert verdict.overspeed_mps == pytest.approx(0.1, rel=0.2)


def test_a_limit_hidden_inside_a_row(honest):
    x, w = rows(honest)
    keep = (x < 2900.0) | (x > 3600.0)
    assert not replay(TRIP, profile_of(TRIP, x[keep], w[keep])).ok
    fast_track = Track(length_m=8e3, speed_limits=((0, 30),), gradients=TRACK.gradients)
    fast = Trip(train=TRAIN, track=fast_track, origin_m=0.0, destination_m=8e3)
    profile = fastest_run(fast)
    assert replay(fast, profile).ok
    verdict = replay(TRIP, profile)
    assert not verdict.ok
    assert verdict.overspeed_mps == pytest.approx(10.0, abs=0.5)


def test_a_gradient_hidden_inside_a_row(honest):
    track = Track(length_m=8e3, speed_limits=TRACK.speed_limits)
    level = Trip(train=TRAIN, track=track, origin_m=0.0, destination_m=8e3)
    assert not replay(TRIP, fastest_run(level)).ok


@pytest.mark.parametrize("stronger", ["traction", "friction_brake_n", "max_acceleration_mps2", "max_deceleration_mps2"])
def test_too_much_effort(stronger):
    changes = {
        "traction": EffortCurve.from_caps(2.6e5, 3.8e6),
        "friction_brake_n": 2e5,
        "max_acceleration_mps2": 1.0,
        "max_deceleration_mps2": 0.8,
    }
    weak = replace(TRAIN, max_deceleration_mps2=np.inf) if stronger == "friction_brake_n" else TRAIN
    strong = replace(weak, **{stronger: changes[stronger]})
    if stronger == "max_acceleration_mps2":
        strong, weak = (replace(train, traction=EffortCurve.from_caps(4e5, 4e6)) for train in (strong, weak))
    profile = fastest_run(Trip(train=strong, track=TRACK, origin_m=0.0, destination_m=8e3))
    verdict = replay(Trip(train=weak, track=TRACK, origin_m=0.0, destination_m=8e3), profile)
    assert not verdict.ok
    assert verdict.effort_excess_pct > 1.0


def test_a_lighter_train(honest):
    heavy = Trip(train=replace(TRAIN, mass_kg=3.03e5), track=TRACK, origin_m=0.0, destination_m=8e3)
    assert not replay(heavy, honest).ok


def test_a_mean_effort_that_hides_a_peak():
    """One row from 5 to 45 m/s has a mean effort within the mean limit, but not within P/v at its end."""
    train = replace(TRAIN, davis_a_n=0.0, davis_b_n_per_mps=0.0, davis_c_n_per_mps2=0.0, max_acceleration_mps2=np.inf)
    for length_m in (2.6e3, 3.2e3):
        forged = level_trip(train, length_m, start_speed_mps=5.0, end_speed_mps=45.0)
        profile = profile_of(forged, np.array([0.0, forged.distance_m]), np.array([25.0, 45.0**2]))
        assert not replay(forged, profile).ok


@pytest.mark.parametrize("cut", [slice(1, None), slice(None, -1), slice(None, None, -1)])
def test_a_run_that_does_not_cover_the_trip(honest, cut):
    columns = {name: column[cut].copy() for name, column in vars(honest).items() if name != "balance"}
    assert not replay(TRIP, Profile(**columns, balance=honest.balance)).ok


def test_other_speeds_at_the_ends(honest):
    rolling = Trip(train=TRAIN, track=TRACK, origin_m=0.0, destination_m=8e3, start_speed_mps=5.0)
    assert not replay(rolling, honest).ok


@pytest.mark.parametrize("name", ["position_m", "speed_mps", "time_s", "force_n", "energy_j"])
def test_numbers_that_are_none(honest, name):
    column = np.array(getattr(honest, name))
    column[3] = np.nan
    assert not replay(TRIP, replace(honest, **{name: column})).ok


def test_a_break_of_the_line_may_be_rounded():
    """Positions from an odd origin are not exactly those of the track."""
    track = Track(length_m=9e3, speed_limits=((0, 30), (4000.1, 20), (4500.7, 40)), gradients=((0, 0), (2000.3, 5.0)))
    trip = Trip(train=TRAIN, track=track, origin_m=1.0 / 3.0, destination_m=8765.4321)
    assert replay(trip, fastest_run(trip)).ok


def test_long_rows_are_stable():
    """Balanced for 900 km in one row: 8 Runge–Kutta steps of 100 km would explode."""
    trip = level_trip(TRAIN, 1e6)
    profile = fastest_run(trip)
    assert np.diff(profile.position_m).max() > 5e5
    assert replay(trip, profile).ok


def test_sub_steps_have_converged(honest, monkeypatch):
    """Four times as many sub-steps tell the same time and energy."""
    base = replay(TRIP, honest)
    counts = drive.sub_steps
    monkeypatch.setattr(drive, "sub_steps", lambda *law: 4 * counts(*law))
    monkeypatch.setattr(drive, "_drive_row", getattr(drive._drive_row, "py_func", drive._drive_row))
    monkeypatch.setattr(referee, "replay_rows", getattr(drive.replay_rows, "py_func", drive.replay_rows))
    finer = replay(TRIP, honest)
    assert finer.time_error_pct == pytest.approx(base.time_error_pct, abs=1e-4)
    assert finer.energy_error_pct == pytest.approx(base.energy_error_pct, abs=1e-4)
    assert finer.time_error_pct != base.time_error_pct


def test_a_row_across_a_jump_of_the_brakes_is_met_exactly():
    """From 20 to 12 m/s at 0.3 m/s², from there to 5 m/s at 1.2 m/s²: one row as long as both."""
    train = replace(PLAIN, braking_rates=((0.0, 1.2), (12.0, 0.3)), max_deceleration_mps2=np.inf)
    length_m = (20.0**2 - 12.0**2) / 0.6 + (12.0**2 - 5.0**2) / 2.4
    trip = level_trip(train, length_m, start_speed_mps=20.0, end_speed_mps=5.0)
    whole = profile_of(trip, np.array([0.0, length_m]), np.array([400.0, 25.0]))
    verdict = replay(trip, whole)
    assert verdict.speed_error_mps < 1e-6
    seconds = 8.0 / 0.3 + 7.0 / 1.2
    assert 100.0 * (whole.duration_s / seconds - 1.0) == pytest.approx(verdict.time_error_pct, abs=1e-4)
    assert not verdict.ok  # its speed is not what the row says on the way


def test_what_the_dynamic_brake_returns_while_a_rate_is_kept_is_met_exactly():
    """From 30 to 10 m/s at 0.8 m/s², which takes more than the dynamic brake has: 150 kN up to 20 m/s, then 3 MW."""
    train = replace(PLAIN, braking_rates=((0.0, 0.8),), max_deceleration_mps2=np.inf, regeneration_efficiency=0.8)
    length_m = (30.0**2 - 10.0**2) / 1.6
    trip = replace(level_trip(train, length_m, start_speed_mps=30.0, end_speed_mps=10.0), energy=PANTOGRAPH)
    whole = profile_of(trip, np.array([0.0, length_m]), np.array([900.0, 100.0]))
    wheel_j = 3e6 * (30.0 - 20.0) / 0.8 + 1.5e5 * (20.0**2 - 10.0**2) / 1.6
    assert whole.total_energy_j == pytest.approx(-0.8 * wheel_j, rel=1e-12)
    assert replay(trip, whole).energy_error_pct == pytest.approx(0.0, abs=3e-4)


@pytest.mark.parametrize("rises", [True, False])
def test_a_row_across_a_drop_of_traction_is_refused(rises):
    """One acceleration has the right mean effort over the speeds of a row, but not over its length."""
    curve = EffortCurve.from_points([(0, 2.5e5), (15, 2.5e5), (15, 1e5), (90, 1e5)])
    train = replace(PLAIN, traction=curve)
    effort_n = (2.5e5 * (15.0**2 - 10.0**2) + 1e5 * (20.0**2 - 15.0**2)) / (20.0**2 - 10.0**2)
    speeds_mps = (10.0, 20.0) if rises else (20.0, 10.0)
    permil = 0.0 if rises else 2.0 * effort_n / (train.mass_kg * 9.81 / 1000.0)
    net_n = effort_n if rises else -effort_n
    length_m = 0.5 * train.inertia_kg * (speeds_mps[1] ** 2 - speeds_mps[0] ** 2) / net_n
    track = Track(length_m=length_m, speed_limits=((0, 50.0),), gradients=((0, permil),))
    start_mps, end_mps = speeds_mps
    trip = Trip(
        train=train, track=track, origin_m=0.0, destination_m=length_m, start_speed_mps=start_mps, end_speed_mps=end_mps
    )
    verdict = replay(trip, profile_of(trip, np.array([0.0, length_m]), np.array(speeds_mps) ** 2))
    assert verdict.effort_excess_pct < 1e-6
    assert not verdict.ok


def test_parts_between_two_looks_at_the_clock_add_up_to_the_whole(honest, monkeypatch):
    whole = replay(TRIP, honest)
    monkeypatch.setattr(referee, "_SUB_STEPS_AT_ONCE", 20)
    assert replay(TRIP, honest) == whole


def test_a_replay_ends_when_its_time_is_up(honest, monkeypatch):
    monkeypatch.setattr(referee, "_SUB_STEPS_AT_ONCE", 20)
    looks = iter([False, False, True])
    assert replay(TRIP, honest, lambda: next(looks)).ok is None
    assert list(looks) == []


@pytest.mark.parametrize(("excess", "passes"), [(5e-4, True), (2e-2, False)])
def test_drag_beyond_the_braking_rate_leaves_brakes_nothing(excess, passes):
    """A row that slows down a hair more than it coasts is no refusal: the excess is a share of what the drag takes."""
    rate_mps2, drag_mps2 = 0.3, 1.0
    train = Train(mass_kg=1e3, traction=EffortCurve.from_caps(2e2), braking_rates=((0.0, rate_mps2),), davis_a_n=1e3)
    w = 900.0 - 2.0 * (1.0 + excess) * drag_mps2 * np.array([0.0, 10.0])
    trip = replace(level_trip(train, 10.0), start_speed_mps=30.0, end_speed_mps=float(np.sqrt(w[-1])))
    verdict = replay(trip, profile_of(trip, np.array([0.0, 10.0]), w))
    assert verdict.effort_excess_pct == pytest.approx(100.0 * excess, rel=1e-6)
    assert verdict.ok == passes
