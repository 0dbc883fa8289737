"""Adhesion by Curtius and Kniffler or by a constant coefficient, and what passengers feel of a run."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.line_case import TRACK, TRAIN
from tgvdp.errors import InputError
from tgvdp.model.adhesion import Adhesion
from tgvdp.model.effort import EffortCurve, EffortPiece
from tgvdp.model.track import Track
from tgvdp.model.trip import Trip
from tgvdp.referee.replay import replay
from tgvdp.runs.comfort import ride_of
from tgvdp.runs.fastest import fastest_run

SPEEDS = np.linspace(0.0, 60.0, 601)


def run(train, track=TRACK):
    trip = Trip(train=train, track=track, origin_m=0.0, destination_m=track.length_m)
    profile = fastest_run(trip)
    assert replay(trip, profile).ok
    return profile


def test_curtius_and_kniffler():
    limit = Adhesion(80e3).limit()
    for speed_mps in (*SPEEDS, 130.0):
        mu = 7.5 / (3.6 * speed_mps + 44.0) + 0.161
        assert limit.effort_n(speed_mps) == pytest.approx(mu * 80e3 * 9.81, rel=5e-5)
    assert limit.effort_n(200.0) == limit.effort_n(139.0)  # held from 500 km/h on
    assert limit.jumps_mps == ()


@pytest.mark.parametrize(
    "curve",
    [
        EffortCurve.from_caps(3e5, 4e6),
        EffortCurve.from_points([(0, 2.6e5), (10, 2.9e5), (10, 2e5), (40, 1e5)]),
        EffortCurve((EffortPiece(0.0, c0_n=2.5e5, c1=-3e3), EffortPiece(20.0, 4e6, 1e3, 10.0))),
        EffortCurve.from_caps(1e4),
    ],
)
@pytest.mark.parametrize("adhesion", [Adhesion(80e3), Adhesion(80e3, 0.25)])
def test_the_smaller_one_of_two_curves(curve, adhesion):
    cap = adhesion.limit()
    both = curve.within(cap)
    for speed_mps in SPEEDS + 1e-7:
        smaller_n = min(curve.effort_n(speed_mps), cap.effort_n(speed_mps))
        assert both.effort_n(speed_mps) == pytest.approx(smaller_n, rel=1e-9)
    again = both.within(cap)
    assert [again.effort_n(v) for v in SPEEDS] == pytest.approx([both.effort_n(v) for v in SPEEDS])
    if curve.largest_n(60.0) < 0.161 * 80e3 * 9.81:
        assert both is curve


def test_less_adhesion_is_slower_and_a_constant_has_its_closed_form():
    plain_s = run(TRAIN).duration_s
    times_s = [run(replace(TRAIN, adhesion=Adhesion(mass_kg))).duration_s for mass_kg in (2e5, 5e4, 2.5e4)]
    assert plain_s == pytest.approx(times_s[0], rel=1e-9)  # 2e5 kg carry more than the drive pulls
    assert plain_s < times_s[1] < times_s[2]
    train = replace(TRAIN, adhesion=Adhesion(5e4, 0.2), davis_a_n=0.0, davis_b_n_per_mps=0.0, davis_c_n_per_mps2=0.0)
    profile = run(train, Track(length_m=400.0, speed_limits=((0.0, 100.0),)))
    pull, brake = 5e4 * 9.81 * 0.2, 5e4 * 9.81 * 0.2 + 5e4
    top = math.sqrt(2.0 * 400.0 / train.inertia_kg / (1.0 / pull + 1.0 / brake))
    assert profile.speed_mps.max() == pytest.approx(top, rel=1e-6)
    assert profile.force_n.max() == pytest.approx(pull)
    assert profile.force_n.min() == pytest.approx(-brake)


@pytest.mark.parametrize(
    ("adhesion", "message"),
    [
        (Adhesion(3e5), "adhesive_mass must be at most the mass of 200000 kg, got 300000 kg"),
        (Adhesion(0.0), "adhesive_mass must be above 0 kg"),
        (Adhesion(1e5, 0.0), "coefficient must be above 0"),
        (Adhesion(1e5, 33.0), "coefficient must be at most 1, got 33"),
        ((1.0, 2.0, 3.0), "adhesion"),
    ],
)
def test_adhesion_that_is_refused(adhesion, message):
    with pytest.raises(InputError, match=message):
        replace(TRAIN, adhesion=adhesion)


def test_ride_of_a_run_with_constant_accelerations():
    train = replace(
        TRAIN,
        traction=EffortCurve.from_caps(1e6),
        braking_rates=((0.0, 0.6),),
        max_acceleration_mps2=0.4,
        davis_a_n=0.0,
        davis_b_n_per_mps=0.0,
        davis_c_n_per_mps2=0.0,
    )
    ride = ride_of(run(train, Track(length_m=1000.0, speed_limits=((0.0, 100.0),))))
    assert ride.acceleration_mps2 == pytest.approx(0.4)
    assert ride.deceleration_mps2 == pytest.approx(0.6)
    assert ride.jerk_mps3 == pytest.approx(1.0)  # from 0.4 to −0.6 within a second
    moving = Trip(
        train=train,
        track=Track(length_m=1000.0, speed_limits=((0.0, 20.0),)),
        origin_m=0.0,
        destination_m=1000.0,
        start_speed_mps=20.0,
        end_speed_mps=20.0,
    )
    assert ride_of(fastest_run(moving)) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_ride_of_a_run_so_slow_that_rows_take_no_time():
    """A time of 10¹⁴ s has steps of 16 ms: shorter rows begin and end at the same one."""
    profile = run(TRAIN)
    time_s = profile.time_s.copy()
    time_s[1] = time_s[2]
    assert ride_of(replace(profile, time_s=time_s)) == pytest.approx(ride_of(profile), rel=0.5)


def test_comfort_limits_bound_the_ride():
    train = replace(TRAIN, max_acceleration_mps2=0.5, max_deceleration_mps2=0.45)
    ride = ride_of(run(train))
    assert ride.acceleration_mps2 == pytest.approx(0.5, rel=1e-6)
    assert ride.deceleration_mps2 == pytest.approx(0.45, rel=1e-6)
    assert ride.jerk_mps3 <= 0.95 * (1.0 + 1e-6)
