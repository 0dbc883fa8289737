"""What holds for optima whatever they are: relaxing a limit, other units, redundant breaks, more points."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.fronts import front_at
from tgvdp.model.convention import Convention
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Gradient, SpeedLimit, Track
from tgvdp.model.trip import Trip
from tgvdp.runs.fastest import fastest_run
from tgvdp.verification.agreement import TRAIN
from tgvdp.verification.trips import random_track

SEEDS = range(10, 16)
MARGINS = np.array([0.02, 0.05, 0.1, 0.2])
#: How far points may be from the optimum (README), as a share of the energy of the fastest run.
ACCURACY = 5e-4


def trip_of(seed, train=TRAIN, track=None):
    track = random_track(seed, 45.0, (2e3, 20e3)) if track is None else track
    return Trip(train=train, track=track, origin_m=0.0, destination_m=track.length_m)


def raised(track, factor):
    limits = tuple(SpeedLimit(row.position_m, row.speed_mps * factor) for row in track.speed_limits)
    return replace(track, speed_limits=limits)


RELAXED = {
    "speed limits": lambda trip: replace(trip, track=raised(trip.track, 1.15)),
    "one speed limit": lambda trip: replace(
        trip,
        track=replace(
            trip.track, speed_limits=(*raised(trip.track, 1.3).speed_limits[:1], *trip.track.speed_limits[1:])
        ),
    ),
    "traction": lambda trip: replace(trip, train=replace(trip.train, traction=EffortCurve.from_caps(2.4e5, 3.6e6))),
    "power": lambda trip: replace(trip, train=replace(trip.train, traction=EffortCurve.from_caps(2e5, 4e6))),
    "brakes": lambda trip: replace(trip, train=replace(trip.train, friction_brake_n=1.5e5)),
    "comfort": lambda trip: replace(
        trip, train=replace(trip.train, max_acceleration_mps2=np.inf, max_deceleration_mps2=np.inf)
    ),
}  # fmt: skip
COMFORTABLE = replace(TRAIN, max_acceleration_mps2=0.5, max_deceleration_mps2=0.4)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("what", RELAXED)
def test_relaxing_a_limit_never_worsens_the_front(what, seed):
    trip = trip_of(seed, COMFORTABLE)
    fastest = fastest_run(trip)
    target_s = fastest.duration_s * (1.0 + MARGINS)
    strict, relaxed = (front_at(one, target_s, 1e-6 * fastest.duration_s) for one in (trip, RELAXED[what](trip)))
    worse_j = relaxed.energy_j - strict.energy_j[: len(relaxed.energy_j)]
    assert worse_j.max() <= ACCURACY * fastest.total_energy_j
    assert fastest_run(RELAXED[what](trip)).duration_s <= fastest.duration_s * (1.0 + 1e-9)


@pytest.mark.parametrize(("mass", "length", "time"), [(2.0**-10, 2.0**6, 2.0**3), (1e-3, 10.0, 0.3), (7.0, 1e-2, 1e2)])
@pytest.mark.parametrize("seed", SEEDS[:3])
def test_units_of_mass_length_and_time_change_nothing(seed, mass, length, time):
    """Forces scale as m·l/t², Davis coefficients as m·l/t², m/t and m/l, energies as m·l²/t²."""
    trip, force, speed = trip_of(seed), mass * length / time**2, length / time
    train = replace(
        TRAIN,
        mass_kg=TRAIN.mass_kg * mass,
        traction=EffortCurve.from_caps(2e5 * force, 3e6 * force * speed),
        braking=EffortCurve.from_caps(2e5 * force, 3e6 * force * speed),
        friction_brake_n=TRAIN.friction_brake_n * force,
        davis_a_n=TRAIN.davis_a_n * force,
        davis_b_n_per_mps=TRAIN.davis_b_n_per_mps * mass / time,
        davis_c_n_per_mps2=TRAIN.davis_c_n_per_mps2 * mass / length,
        max_speed_mps=TRAIN.max_speed_mps * speed,
    )
    track = Track(
        length_m=trip.track.length_m * length,
        speed_limits=tuple(SpeedLimit(at * length, limit * speed) for at, limit in trip.track.speed_limits),
        gradients=tuple(Gradient(at * length, permil) for at, permil in trip.track.gradients),
    )
    gravity_mps2 = trip.convention.gravity_mps2 * length / time**2
    scaled = Trip(
        train=train, track=track, origin_m=0.0, destination_m=track.length_m,
        convention=Convention(name="scaled", gravity_mps2=gravity_mps2),
    )  # fmt: skip
    target_s = fastest_run(trip).duration_s * (1.0 + MARGINS)
    plain, other = front_at(trip, target_s, 0.001), front_at(scaled, target_s * time, 0.001 * time)
    assert other.duration_s / time == pytest.approx(plain.duration_s, rel=1e-5)
    energy_j = other.energy_j / (mass * speed**2)
    shift_j = plain.multiplier_j_per_s * (other.duration_s / time - plain.duration_s)
    assert energy_j + shift_j == pytest.approx(plain.energy_j, rel=1e-4)


@pytest.mark.parametrize("seed", SEEDS)
def test_breaks_that_change_nothing_change_nothing(seed):
    trip = trip_of(seed)
    track, half_m = trip.track, 0.37 * trip.track.length_m
    at_half = [
        max((row for row in rows if row.position_m <= half_m), key=lambda row: row.position_m)._replace(
            position_m=half_m
        )
        for rows in (track.speed_limits, track.gradients)
    ]
    limits, gradients = (
        tuple(sorted({*rows, row})) for rows, row in zip((track.speed_limits, track.gradients), at_half, strict=True)
    )
    split = replace(trip, track=replace(track, speed_limits=limits, gradients=gradients))
    fastest = fastest_run(trip)
    assert fastest_run(split).duration_s == pytest.approx(fastest.duration_s, rel=1e-7)
    target_s = fastest.duration_s * (1.0 + MARGINS)
    plain, cut = (front_at(one, target_s, 1e-6 * fastest.duration_s) for one in (trip, split))
    assert cut.energy_j == pytest.approx(plain.energy_j, abs=ACCURACY * fastest.total_energy_j)


@pytest.mark.parametrize("seed", SEEDS[:3])
def test_more_points_never_lower_the_hypervolume(seed):
    """Each front's times hold those of the one before."""
    track = random_track(seed, 45.0, (2e3, 20e3))
    fronts = [tgvdp.search(TRAIN, track, points=points, max_margin=0.2) for points in (5, 9, 17, 33)]
    corner = 1.2 * fronts[0].fastest.time_s, fronts[0].fastest.energy_j
    area = [one.front.hypervolume(*corner) for one in fronts]
    slack = ACCURACY * corner[1] * 0.2 * fronts[0].fastest.time_s
    assert all(more >= fewer - slack for fewer, more in itertools.pairwise(area))
    assert area[-1] > area[0]
