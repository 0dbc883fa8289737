"""Where the front method ends: too many points, running times that jump, plain grids, and an impatient user."""

import os
import signal
import sys
import threading
import time

import numpy as np
import pytest

import tgvdp
from tests.helpers.twins.trips import random_trip
from tgvdp import EffortCurve, Track, Train
from tgvdp.errors import InfeasibleError, TgvdpError
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate import backward as costate
from tgvdp.methods.costate import room
from tgvdp.methods.costate.front import optimal_front
from tgvdp.runs.fastest import fastest_run

#: Largest share of the energy by which a plain grid may be below the front: that of an arc's rounding and of blends.
TOLERANCE = 2e-3


def search(trip, **options):
    return tgvdp.search(
        trip.train, trip.track, origin_m=trip.origin_m, destination_m=trip.destination_m,
        start_speed_mps=trip.start_speed_mps, end_speed_mps=trip.end_speed_mps, **options,
    )  # fmt: skip


def test_a_polyline_without_room_is_a_named_error(monkeypatch):
    monkeypatch.setattr(costate, "ROOM", 150)
    monkeypatch.setattr(room, "_threads", threading.local())  # that of this thread has more
    with pytest.raises(TgvdpError, match="costate program lost its way"):
        search(random_trip(20131), points=3)


@pytest.mark.parametrize("seed", [20116, 20131, 20179, 20200, 11, 13, 61, 115])
def test_running_times_over_which_policies_jump_are_met(seed):
    """Most of these trips once had "running times jump" and a faster run in place of a point."""
    result = search(random_trip(seed), points=60, max_margin=0.25)
    assert not result.warnings
    assert len(result.front.time_s) == 60
    assert all(verdict.ok for verdict in result.verify())


def test_points_close_to_each_other_on_level_track_are_met():
    """A policy drives a cell in one way or another, which alone is a jump of the running time by 0.1 to 0.3 s."""
    train = Train(
        mass_kg=200e3, traction=EffortCurve.from_caps(200e3, 3e6), friction_brake_n=200e3,
        davis_a_n=3000.0, davis_b_n_per_mps=50.0, davis_c_n_per_mps2=6.0,
    )  # fmt: skip
    result = tgvdp.search(train, Track(length_m=20e3, speed_limits=((0.0, 40.0),)), points=500)
    assert not result.warnings
    assert len(result.front.time_s) == 500
    assert (np.diff(result.front.energy_j) < 0.0).all()


@pytest.mark.parametrize("first", range(40000, 40150, 30))
def test_no_random_grid_beats_the_front(first):
    """No path of any grid takes as long as a run of the front and clearly less energy."""
    compared = 0
    for seed in range(first, first + 30):
        trip = random_trip(seed)
        if trip is None:
            continue
        rng = np.random.default_rng(seed)
        segment_m, speeds = trip.distance_m / int(rng.integers(4, 20)), int(rng.integers(5, 25))
        try:
            fastest = fastest_run(trip)
            grid = search(trip, method="exact", segment_m=segment_m, speeds=speeds, max_margin=0.5)
        except InfeasibleError:
            continue
        chosen = np.unique(np.linspace(0, len(grid.front) - 1, 4).astype(int))
        wanted_s = np.maximum(grid.front.time_s[chosen], fastest.duration_s * (1.0 + 1e-6))
        found = optimal_front(trip, fastest, wanted_s, SearchBudget(), tolerance_s=1e-6 * fastest.duration_s)
        scale_j = 0.05 * trip.train.inertia_kg * float(fastest.speed_mps.max()) ** 2
        for time_s, energy_j in zip(wanted_s, grid.front.energy_j[chosen], strict=True):
            as_fast = found.duration_s <= time_s * (1.0 + 1e-9)
            if as_fast.any():  # else running times jump there, and the front says so
                assert found.energy_j[as_fast].min() <= energy_j + TOLERANCE * max(energy_j, scale_j), seed
                compared += 1
    assert compared > 20


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_an_interrupt_is_heard_on_a_large_grid():
    train, track = tgvdp.load_train("tgv"), tgvdp.load_track("flat-100km")
    tgvdp.search(train, track, method="exact", segment_m=10e3, speeds=10)  # compiles
    sent_s = []

    def interrupt():
        sent_s.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(1.0, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        tgvdp.search(train, track, method="exact", segment_m=400.0, speeds=400, time_limit_s=60.0)
    assert time.perf_counter() - sent_s[0] < 2.0  # half a second on a machine that does nothing else
