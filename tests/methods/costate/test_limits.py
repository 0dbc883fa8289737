"""Where the front method ends: too many points, running times that jump, plain grids, and an impatient user."""

import os
import re
import signal
import sys
import threading
import time

import numpy as np
import pytest

import tgvdp
from tests.helpers.twins.trips import random_trip
from tgvdp.errors import InfeasibleError, TgvdpError
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate import backward as costate
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
    with pytest.raises(TgvdpError, match="costate program lost its way"):
        search(random_trip(20131), points=3)


def test_running_times_that_jump_are_named():
    """Which of these trips jumps over a wanted time depends on the last digits of the extremals; most of them do."""
    named = 0
    for seed in (20116, 20131, 20179, 20200, 11, 13, 61, 115):
        result = search(random_trip(seed), points=60, max_margin=0.25)
        assert result.complete
        for warning in result.warnings:
            if "running times jump" not in warning:
                continue
            named += 1
            for time_s in map(float, re.findall(r"([\d.e+-]+) s\b", warning)):
                assert not np.isclose(result.front.time_s, time_s, rtol=1e-5).any()
                assert result.front.time_s.min() < time_s <= result.front.time_s[0] * 1.25 * (1.0 + 1e-5)
    assert named >= 3


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
