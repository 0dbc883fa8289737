"""Explicit steps: the running times that TrainRuns.jl publishes, and what they converge to."""

import math

import numpy as np
import pytest

from tgvdp.api import search
from tgvdp.constants import GRAVITY_MPS2, STANDARD_GRAVITY_MPS2
from tgvdp.formats import load_track, load_train
from tgvdp.line.cells import cells_of
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Gradient, NeutralSection, SpeedLimit, Track
from tgvdp.model.train import BrakingRate, Train
from tgvdp.model.trip import Trip
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.stepped import stepped_time_s


def trip_of(train, limits=((0.0, 40.0),), gradients=(), length_m=8000.0, **ends):
    track = Track(
        length_m=length_m,
        speed_limits=tuple(SpeedLimit(*row) for row in limits),
        gradients=tuple(Gradient(*row) for row in gradients),
    )
    return Trip(train=train, track=track, origin_m=0.0, destination_m=length_m, **ends)


def until_the_tail_has_passed(track, length_m):
    """The same line with limits that rise where the tail has passed, worked out independently of the engine."""
    rows = track.speed_limits
    ends_m = [*(row.position_m for row in rows[1:]), track.length_m]
    breaks_m = sorted({row.position_m for row in rows} | {row.position_m + length_m for row in rows[1:]})
    limits = [
        (at_m, min(row.speed_mps for row, end_m in zip(rows, ends_m, strict=True)
                   if row.position_m <= at_m and end_m > at_m - length_m))
        for at_m in breaks_m if at_m < track.length_m
    ]  # fmt: skip
    return Track(length_m=track.length_m, speed_limits=tuple(limits), gradients=track.gradients)


@pytest.mark.parametrize("name", ["const", "slope", "speed"])
def test_running_times_of_trainruns(shared, name):
    folder = shared / "railtoolkit"
    published_s = float((folder / "snapshots" / f"local_{name}.csv").read_text().split()[1])
    train = load_train(folder / "trains" / "local.yaml")
    track = until_the_tail_has_passed(load_track(folder / "paths" / f"{name}.yaml"), train.length_m)
    trip = Trip(train=train, track=track, origin_m=0.0, destination_m=track.length_m)
    cells = cells_of(trip)
    cells = cells._replace(grade_n=cells.grade_n * (STANDARD_GRAVITY_MPS2 / GRAVITY_MPS2))
    assert stepped_time_s(trip, 20.0, cells) == pytest.approx(published_s, abs=0.01)  # 0.05 s is asked for
    converged_s = stepped_time_s(trip, 0.1, cells)
    assert 1.004 < converged_s / published_s < 1.006  # the first step alone, from standstill, makes up most of it


FORCE_BRAKED = Train(
    mass_kg=2e5,
    rotating_mass_factor=1.06,
    traction=EffortCurve.from_caps(2e5, 4e6),
    braking=EffortCurve.from_caps(1e5, 3e6),
    friction_brake_n=5e4,
    davis_a_n=2e3,
    davis_b_n_per_mps=30.0,
    davis_c_n_per_mps2=6.0,
    max_acceleration_mps2=0.9,
    max_speed_mps=45.0,
)
LIMITS = ((0.0, 30.0), (2000.0, 40.0), (5000.0, 20.0), (5500.0, 40.0))
HILLS = ((0.0, 5.0), (2500.0, -12.0), (4000.0, 20.0), (6000.0, 0.0))


def test_small_steps_converge_to_the_fastest_run():
    trip = trip_of(FORCE_BRAKED, LIMITS, HILLS)
    fastest_s = fastest_run(trip).duration_s
    errors_s = [abs(stepped_time_s(trip, step_m) - fastest_s) for step_m in (20.0, 2.0, 0.2)]
    assert errors_s[0] > 5.0 * errors_s[1] > 0.0
    assert errors_s[2] == pytest.approx(0.0, abs=1e-4 * fastest_s)


def test_constant_forces_are_exact_at_any_step():
    """Without resistance: 1 m/s² up, 0.5 m/s² down, so 10 m/s are reached after 50 m and kept for 850 m."""
    train = Train(mass_kg=1.0, traction=EffortCurve.from_caps(1.0), braking_rates=(BrakingRate(0.0, 0.5),))
    trip = trip_of(train, ((0.0, 10.0),), length_m=1000.0)
    for step_m in (0.7, 20.0, 1e5):
        assert stepped_time_s(trip, step_m) == pytest.approx(10.0 + 85.0 + 20.0, rel=1e-12)


def test_braking_rates_change_where_their_speeds_are():
    """From 20 m/s at 1 m/s² down to 10 m/s, then at 0.5 m/s²: 10 s and 20 s over 150 m and 100 m."""
    train = Train(
        mass_kg=1.0,
        traction=EffortCurve.from_caps(1.0),
        braking_rates=(BrakingRate(0.0, 0.5), BrakingRate(10.0, 1.0)),
    )
    trip = trip_of(train, ((0.0, 20.0),), length_m=1250.0, start_speed_mps=20.0)
    assert stepped_time_s(trip, 20.0) == pytest.approx(50.0 + 30.0, rel=1e-12)


def test_a_neutral_section_is_coasted_through():
    """Without resistance 10 m/s stay 10 m/s over its 100 m, where the others would gain speed."""
    train = Train(mass_kg=1.0, traction=EffortCurve.from_caps(1.0), braking_rates=(BrakingRate(0.0, 0.5),))
    track = Track(
        length_m=200.0,
        speed_limits=(SpeedLimit(0.0, 50.0),),
        neutral_sections=(NeutralSection(50.0, 100.0),),
    )
    trip = Trip(train=train, track=track, origin_m=0.0, destination_m=200.0, end_speed_mps=math.sqrt(200.0))
    cells = cells_of(trip, np.array([50.0, 150.0]))
    assert stepped_time_s(trip, 20.0, cells) == pytest.approx(10.0 + 10.0 + math.sqrt(200.0) - 10.0, rel=1e-12)


def test_a_train_that_stalls_has_no_running_time():
    trip = trip_of(FORCE_BRAKED, gradients=((0.0, 0.0), (2000.0, 200.0)))
    assert math.isinf(stepped_time_s(trip, 20.0))


def test_conventions_without_steps_report_none():
    assert search(FORCE_BRAKED, trip_of(FORCE_BRAKED).track, points=2).fastest.stepped_time_s is None
