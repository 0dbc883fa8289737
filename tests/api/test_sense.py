"""Where arithmetic fails, figures outside their usual ranges are named; without any it is a fault of tgvdp."""

from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tgvdp.api.sense import sensible_numbers
from tgvdp.errors import BudgetExceededError, InputError, NumericalError
from tgvdp.line.cells import cells_of
from tgvdp.memory import ask_for, limited_memory
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.refine.mesh import Level
from tgvdp.model.trip import Trip
from tgvdp.physics.forces import kernel_train
from tgvdp.referee.replay import replay
from tgvdp.runs.fastest import fastest_run
from tgvdp.runs.profile import profile_of
from tgvdp.runs.stepped import stepped_time_s

TRAIN, TRACK = tgvdp.load_train("alstom-emu"), tgvdp.load_track("flat-100km")


def trip_of(train=TRAIN):
    return Trip(train=train, track=TRACK, origin_m=0.0, destination_m=TRACK.length_m)


def test_a_train_that_creeps_is_searched_within_its_time_and_memory():
    """Its mesh would have 4 cells per way to its top speed, 10⁹ of them, for which there is no memory.

    The mesh has some 50,000 cells at most, and is held against one with each of them cut in two.
    """
    creeping = replace(TRAIN, max_speed_mps=1e-3 * TRAIN.max_speed_mps)
    result = tgvdp.search(creeping, TRACK, points=2, time_limit_s=2.0)
    assert result.counters["cells"] < 120_000
    assert result.fastest.time_s == pytest.approx(TRACK.length_m / creeping.max_speed_mps, rel=0.01)


def test_failures_name_the_figures_that_are_unusual():
    heavy = replace(TRAIN, mass_kg=1e3 * TRAIN.mass_kg)
    named = r"cannot be computed: train .*: mass .* t \(usual 10 to 40000: t or kg\?\); .*overflow"
    with pytest.raises(InputError, match=named), sensible_numbers(trip_of(heavy)):
        np.float64(1e200) * np.float64(1e200)
    with pytest.raises(InputError, match=r"cannot be computed: .*mass"), sensible_numbers(trip_of(heavy)):
        raise MemoryError


def test_a_train_that_takes_off_like_a_bullet_is_refused():
    """Its fastest run has two million rows on a real line, and fails the replay."""
    light = replace(TRAIN, mass_kg=1e-6 * TRAIN.mass_kg)
    with pytest.raises(InputError, match=r"cannot be computed: train .*: mass .*it starts with .* m/s², at most"):
        tgvdp.search(light, TRACK, points=2)
    tgv = tgvdp.load_train("tgv")
    result = tgvdp.search(replace(tgv, mass_kg=1e-3 * tgv.mass_kg), TRACK, points=2)
    assert all(verdict.ok for verdict in result.verify())


def test_failures_of_usual_figures_are_faults():
    usual = replace(TRAIN, braking=tgvdp.EffortCurve.from_caps(0.0), friction_brake_n=TRAIN.mass_kg)
    with pytest.raises(NumericalError, match=r"divide by zero.*please report"), sensible_numbers(trip_of(usual)):
        np.float64(1.0) / np.float64(0.0)
    with pytest.raises(BudgetExceededError, match="more memory than there is"), sensible_numbers(trip_of(usual)):
        raise MemoryError


def test_memory_is_asked_for():
    with sensible_numbers(trip_of(), max_memory_b=1e12):
        ask_for(1e11, "a lot")
    refused = pytest.raises(BudgetExceededError, match=r"a lot would take 100 GB beside 0\S* GB in use, more than 1 GB")
    with refused, sensible_numbers(trip_of(), max_memory_b=1e9):
        ask_for(1e11, "a lot")
    refused = pytest.raises(
        BudgetExceededError, match=r"a little would take 20 MB beside \d\S* MB in use, more than 1 MB"
    )
    with refused, sensible_numbers(trip_of(), max_memory_b=1e6):
        ask_for(2e7, "a little")
    with pytest.raises(BudgetExceededError, match="--max-memory"):
        tgvdp.search(TRAIN, TRACK, max_memory_b=1e6)


HUNGRY = {
    "a mesh of": Mesh.of,
    "a refinement on": lambda trip, run: Level(trip, kernel_train(trip.train), cells_of(trip)),
    "a profile of": lambda trip, run: profile_of(trip, run.position_m - trip.origin_m, run.speed_mps**2),
    "a replay of": replay,
    "the explicit steps": lambda trip, run: stepped_time_s(trip, 20.0),
    "rows of runs": lambda trip, run: fastest_run(trip),
}


@pytest.mark.parametrize("what", HUNGRY)
def test_whoever_makes_large_arrays_asks_first(what):
    trip = trip_of()
    run = fastest_run(trip)
    refused = pytest.raises(BudgetExceededError, match=f"{what}.* would take .* MB .* more than")
    with refused, limited_memory(1.0):
        HUNGRY[what](trip, run)
