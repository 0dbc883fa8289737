"""What a driver is told of a run: steps that are all of it, and a sentence that says them."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import tgvdp
from tgvdp.model.track import Place
from tgvdp.report.advice import sentence
from tgvdp.runs.instructions import LEAST_STEP_S, Instruction, instructions_of
from tgvdp.runs.profile import EnergyBalance, Profile, profile_of
from tgvdp.units import kmh_to_mps

POWER, HOLD, COAST, BRAKE = range(4)


def run(*phases):
    """A profile of phases (regime, seconds), a row a second, at 1 m/s."""
    regime = np.array([code for code, seconds in phases for _ in range(seconds)] + [phases[-1][0]], dtype=np.int8)
    along = np.arange(len(regime), dtype=np.float64)
    ones = np.ones(len(regime))
    return Profile(along, ones, along.copy(), ones.copy(), along.copy(), regime, EnergyBalance(0.0, 0.0, 0.0, 0.0, 0.0))


def told(*phases, **options):
    return [(step.action, step.to_s) for step in instructions_of(run(*phases), **options)]


@pytest.mark.parametrize(
    ("phases", "steps"),
    [
        ([(POWER, 9)], [("power", 9)]),
        ([(POWER, 9), (HOLD, 5), (COAST, 8), (BRAKE, 4)], [("power", 9), ("hold", 14), ("coast", 22), ("brake", 26)]),
        # What nobody could follow goes to the longer neighbour, and two of one kind become one.
        ([(POWER, 9), (HOLD, 2), (COAST, 8)], [("power", 11), ("coast", 19)]),
        ([(POWER, 5), (HOLD, 2), (COAST, 8)], [("power", 5), ("coast", 15)]),
        ([(POWER, 5), (COAST, 1), (POWER, 5), (BRAKE, 3)], [("power", 11), ("brake", 14)]),
        ([(HOLD, 1), (POWER, 5), (BRAKE, 2)], [("power", 8)]),
        ([(HOLD, 1), (BRAKE, 1)], [("brake", 2)]),
        # Many in a row hold a speed by switching.
        ([(POWER, 9), *[(COAST, 1), (POWER, 2)] * 3, (BRAKE, 4)], [("power", 9), ("hold", 18), ("brake", 22)]),
    ],
)
def test_phases_become_steps(phases, steps):
    assert told(*phases) == steps


def test_many_phases_take_little_time():
    """Energies by a map may switch thousands of times."""
    phases = [(POWER, 4), *[(COAST, 1), (POWER, 2), (HOLD, 5)] * 4000]
    assert len(told(*phases)) == 2
    assert len(told(*[(COAST, 1), (POWER, 2)] * 20_000)) == 1


def test_all_phases_are_steps_where_that_is_asked_for():
    assert len(told((POWER, 5), (COAST, 1), (POWER, 5), least_s=0.0)) == 3


@pytest.mark.parametrize(("train", "track"), [("tgv", "lgv-100km"), ("alstom-emu", "flat-100km")])
def test_steps_are_all_of_a_run(train, track):
    result = tgvdp.search(train, track, points=4, destination_m=40e3)
    for index in range(4):
        profile, steps = result.profile(index), result.instructions(index)
        assert (steps[0].from_m, steps[-1].to_m) == (profile.position_m[0], profile.position_m[-1])
        for before, after in pairwise(steps):
            assert before.action != after.action
            assert (before.to_m, before.to_s, before.to_mps) == (after.from_m, after.from_s, after.from_mps)
        assert min(step.to_s - step.from_s for step in steps) >= LEAST_STEP_S
        middles = np.interp([step.to_m for step in steps], profile.position_m, profile.speed_mps)
        assert middles == pytest.approx([step.to_mps for step in steps], abs=1e-9)
        assert result.advice(index).endswith("then brake to stop at km 40.0.")


@pytest.mark.parametrize(
    ("from_kmh", "to_kmh", "action"),
    [(80, 82.9, "hold"), (80, 77.1, "hold"), (80, 83.1, "partial"), (80, 76.9, "partial")],
)
def test_a_speed_that_changes_much_is_not_held(from_kmh, to_kmh, action):
    speed_mps = np.linspace(kmh_to_mps(from_kmh), kmh_to_mps(to_kmh), 10)
    (step,) = instructions_of(replace(run((HOLD, 9)), speed_mps=speed_mps))
    assert step.action == action


def test_a_sentence_says_where_and_how_fast():
    def step(action, from_m, to_m, from_kmh, to_kmh):
        from_mps, to_mps = kmh_to_mps(from_kmh), kmh_to_mps(to_kmh)
        lasts_s = 2.0 * (to_m - from_m) / (from_mps + to_mps)
        return Instruction(action, from_m, to_m, 0.0, lasts_s, from_mps, to_mps)

    track = replace(tgvdp.load_track("flat-100km"), places=(Place(5000.0, "Mid"), Place(9000.0, "End")))
    steps = [
        step("power", 0.0, 1e3, 0.0, 80.2), step("hold", 1e3, 5e3, 80.2, 80.2), step("power", 5e3, 6e3, 80, 70),
        step("brake", 6e3, 7e3, 70, 40), step("coast", 7e3, 8.5e3, 40, 30), step("brake", 8.5e3, 9e3, 30, 0),
    ]  # fmt: skip
    assert sentence(track, steps) == (
        "Accelerate to 80 km/h, hold 80 km/h to Mid (km 5.00), full power to km 6.00 (70 km/h), brake to 40 km/h by km"
        " 7.00, coast to km 8.50 (30 km/h), then brake to stop at End (km 9.00)."
    )
    assert sentence(track, [step("partial", 0.0, 9e3, 60, 56)]) == "Partial effort to End (km 9.00) (56 km/h)."
    assert sentence(track, steps[:1]) == "Full power to km 1.00 (80 km/h)."
    assert sentence(track, [step("coast", 0.0, 90e3, 50, 40)]) == "Coast to km 90.0 (40 km/h)."
    assert sentence(track, [step("coast", 0.0, 9e3, 50, 0)]) == "Coast to stop at End (km 9.00)."
    # A speed that drifts is held at its mean, up to which the train accelerates.
    steps = [step("power", 0.0, 1e3, 0.0, 78.0), step("hold", 1e3, 4e3, 78.0, 81.0), step("brake", 4e3, 5e3, 81, 90)]
    assert sentence(track, steps) == (
        "Accelerate to 80 km/h, hold 80 km/h to km 4.00, then brake to Mid (km 5.00) (90 km/h)."
    )


def test_little_effort_along_which_a_train_slows_down_is_not_full_power():
    """It was told by its acceleration alone."""
    trip = tgvdp.search("tgv", "flat-100km", points=2, destination_m=20e3).trip
    x_m = np.array([0.0, 5e3, 10e3, 15e3, 20e3])
    speed_mps = np.array([0.0, 60.0, 60.0, 55.0, 0.0])
    rows = profile_of(trip, x_m, speed_mps**2)
    assert 0.0 < rows.force_n[2] < 0.1 * rows.force_n[0]
    assert rows.regime_names[:4] == ["traction", "cruising", "cruising", "braking"]
