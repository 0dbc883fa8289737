"""Runs on steps of the resistance under the true one, and rows across jumps of an effort limit."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.twins.trips import level_trip
from tgvdp.line.resolved import resolve
from tgvdp.model.convention import Convention
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.referee.replay import replay
from tgvdp.runs.effort_jumps import cut_at_jumps
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.profile import profile_of
from tgvdp.runs.resistance_correction import follow

pytestmark = pytest.mark.nojit

#: 100 t without resistance, whose traction drops from 100 to 40 kN at 10 m/s.
PLAIN = Train(
    mass_kg=1e5,
    traction=EffortCurve.from_points([(0, 1e5), (10, 1e5), (10, 4e4), (90, 4e4)]),
    friction_brake_n=8e4,
    length_m=400.0,
)
STRIP = Convention(name="strip", mass_model="strip")
HILLS = Track(length_m=3000.0, speed_limits=((0.0, 60.0),), gradients=((0.0, 0.0), (800.0, -6.0), (1500.0, 9.0)))


def strip_trip(train=PLAIN, track=HILLS, **speeds):
    return Trip(train=train, track=track, origin_m=0.0, destination_m=track.length_m, convention=STRIP, **speeds)


def cut(trip, x_m, w):
    return cut_at_jumps(trip.train, resolve(trip), np.array(x_m), np.array(w))


def means(line, x_m):
    """Mean force of gradients on the steps between positions, N."""
    return line.grade_n[line.step_at(0.5 * (x_m[:-1] + x_m[1:]))]


def test_coasting_keeps_its_energy():
    """Without resistance ½·m·w + ∫G ds is constant: the true integral of the force, not that of its steps."""
    trip = strip_trip(start_speed_mps=25.0, end_speed_mps=24.0)
    line = resolve(trip)
    x_m = line.break_m
    w = 25.0**2 - 2.0 / trip.train.inertia_kg * np.concatenate(([0.0], np.cumsum(means(line, x_m) * np.diff(x_m))))
    at_m, found = follow(trip.train, line, x_m, w)
    assert len(at_m) > len(x_m)
    assert found == pytest.approx(25.0**2 - 2.0 / trip.train.inertia_kg * line.force.integral_to(at_m), rel=1e-12)


def test_a_held_speed_stays_and_its_effort_follows():
    trip = strip_trip(start_speed_mps=20.0, end_speed_mps=20.0)
    line = resolve(trip)
    x_m = np.union1d(line.break_m, np.linspace(0.0, 3000.0, 101))
    at_m, found = follow(trip.train, line, x_m, np.full(len(x_m), 400.0))
    assert found == pytest.approx(400.0, rel=1e-12)
    force_n = profile_of(trip, at_m, found).force_n[:-1]
    assert force_n == pytest.approx(line.force.mean(at_m[:-1], at_m[1:]), abs=1e-6 * 1e5)


def test_a_speed_limit_is_held_as_it_is():
    """Where braking that comfort bounds begins a run may lack some speed, which it also lacked on all of the limit."""
    limits = (0.0, 60.0), (1000.0, 14.0), (2000.0, 60.0)
    track = replace(HILLS, speed_limits=limits, gradients=((0.0, 0.0), (200.0, -6.0), (1500.0, 9.0)))
    train = replace(PLAIN, traction=EffortCurve.from_caps(1e5), max_deceleration_mps2=0.3)
    trip = strip_trip(train, track)
    profile = fastest_run(trip)
    inside = (profile.position_m >= 1000.0) & (profile.position_m <= 2000.0)
    assert profile.speed_mps[inside] == pytest.approx(14.0, rel=1e-9)
    assert replay(trip, profile).ok


@pytest.mark.parametrize("share", [0.2, 0.9])
def test_what_is_lost_is_not_won_back_by_any_effort(share):
    """At full traction up to a speed limit that holds for 20 cm, and coasting from there: no peak of effort."""
    track = replace(HILLS, speed_limits=((0.0, 60.0), (1000.0, 14.0), (1000.2, 60.0)))
    trip = strip_trip(replace(PLAIN, traction=EffortCurve.from_caps(1e5)), track)
    fastest = fastest_run(trip)
    w = fastest.speed_mps**2
    inside = np.flatnonzero((fastest.position_m >= 1000.0) & (fastest.position_m < 1000.2))
    w[inside[0]] *= 1.0 - 1e-4 * share  # as when something before it was lowered
    profile = profile_of(trip, *follow(trip.train, resolve(trip), fastest.position_m, w))
    assert replay(trip, profile).effort_excess_pct < 0.1


def test_an_even_line_without_jumps_is_left_alone():
    trip = level_trip(replace(PLAIN, traction=EffortCurve.from_caps(1e5)), 1000.0)
    x_m, w = np.array([0.0, 400.0, 1000.0]), np.array([0.0, 300.0, 0.0])
    again = follow(trip.train, resolve(trip), x_m, w)
    assert again[0] is x_m
    assert again[1] is w


def test_a_row_at_full_traction_is_cut_where_it_drops():
    """½·m·(100 − 25)/100 kN and ½·m·(225 − 100)/40 kN."""
    first_m, second_m = 0.5e5 * 75.0 / 1e5, 0.5e5 * 125.0 / 4e4
    x_m, w = cut(level_trip(PLAIN, 1000.0), [0.0, first_m + second_m, 1000.0], [25.0, 225.0, 225.0])
    assert x_m == pytest.approx([0.0, first_m, first_m + second_m, 1000.0])
    assert w == pytest.approx([25.0, 100.0, 225.0, 225.0])


def test_a_row_at_partial_traction_is_cut_where_the_limit_falls_below_it():
    """At 60 kN up to the drop, at 40 kN from there."""
    first_m, second_m = 0.5e5 * 75.0 / 6e4, 0.5e5 * 125.0 / 4e4
    x_m, _ = cut(level_trip(PLAIN, 1000.0), [0.0, first_m + second_m, 1000.0], [25.0, 225.0, 225.0])
    assert x_m[1] == pytest.approx(first_m)


def test_a_row_below_the_lower_limit_is_left_alone():
    """At 30 kN throughout its acceleration is the same."""
    x_m = np.array([0.0, 0.5e5 * 200.0 / 3e4, 1000.0])
    trip = level_trip(PLAIN, 1000.0)
    assert cut_at_jumps(PLAIN, resolve(trip), x_m, np.array([25.0, 225.0, 225.0]))[0] is x_m


def test_a_row_that_slows_down_under_traction_is_cut_too():
    """Up 100 ‰, 98.1 kN, from 15 to 5 m/s: at 40 kN down to the drop, at 60 kN from there."""
    track = Track(length_m=1000.0, speed_limits=((0.0, 60.0),), gradients=((0.0, 100.0),))
    trip = Trip(train=PLAIN, track=track, origin_m=0.0, destination_m=1000.0)
    first_m, second_m = 0.5e5 * 125.0 / 5.81e4, 0.5e5 * 75.0 / 3.81e4
    x_m, w = cut(trip, [0.0, first_m + second_m, 1000.0], [225.0, 25.0, 25.0])
    assert x_m[1] == pytest.approx(first_m)
    assert w[1] == pytest.approx(100.0)


def test_a_speed_that_is_held_at_a_drop_is_below_it():
    """60 ‰ take 59 kN, which there are below 10 m/s alone: a hair above they are half as much again as there is."""
    trip = strip_trip(track=Track(length_m=300.0, speed_limits=((0.0, 60.0),), gradients=((0.0, 60.0),)))
    just_above = 100.0 * (1.0 + 5e-9)
    x_m, w = cut(trip, [0.0, 100.0, 200.0, 300.0], [100.0, just_above, just_above, just_above])
    assert x_m.tolist() == [0.0, 100.0, 200.0, 300.0]
    assert ((100.0 * (1.0 - 2e-9) < w[1:-1]) & (w[1:-1] < 100.0)).all()
    assert w[0] == 100.0


def test_braking_is_cut_where_its_rate_jumps():
    """From 20 m/s at 0.4 m/s² to 12 and 6 m/s at 1.2 and 0.6 m/s², with 0.9 m/s² for comfort."""
    train = replace(PLAIN, braking_rates=((0.0, 0.6), (6.0, 1.2), (12.0, 0.4)), max_deceleration_mps2=0.9)
    lengths_m = np.array([(400 - 144) / 0.8, (144 - 36) / 1.8, (36 - 4) / 1.2])
    x_m, w = cut(level_trip(train, 1000.0), [0.0, lengths_m.sum(), 1000.0], [400.0, 4.0, 4.0])
    assert x_m[:4] == pytest.approx(np.concatenate(([0.0], np.cumsum(lengths_m))))
    assert w[:4] == pytest.approx([400.0, 144.0, 36.0, 4.0])


def test_coasting_is_not_cut():
    track = Track(length_m=1000.0, speed_limits=((0.0, 60.0),), gradients=((0.0, 10.0),))
    trip = Trip(train=PLAIN, track=track, origin_m=0.0, destination_m=1000.0)
    x_m, w = np.array([0.0, 1000.0]), np.array([400.0, 400.0 - 2.0 * 0.0981 * 1000.0])
    assert w[1] > 100.0
    slower = np.array([225.0, 225.0 - 2.0 * 0.0981 * 1000.0])
    assert cut(trip, x_m, w)[0] == pytest.approx(x_m)
    assert len(cut(trip, x_m, slower)[0]) == 2
    assert math.sqrt(slower[1]) < 10.0 < math.sqrt(slower[0])
