"""The economy margin: against a simulation in short steps, closed forms on level track, and its own description."""

from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.documented_case import OSRD_TRACK, OSRD_TRAIN
from tests.helpers.margin_case import HILLS, TRAIN, twin
from tests.helpers.trips import commuter
from tgvdp import EffortCurve
from tgvdp.margins.economy import coasting_ends_mps
from tgvdp.physics.codes import BRAKING, COASTING


@pytest.fixture(scope="module")
def hills():
    return tgvdp.journey(TRAIN, HILLS, points=2)


def test_a_second_implementation_takes_the_same_energy(hills):
    """Explicit steps of 2 m, with limits, a brake before a slow stretch, and two descents."""
    margins = hills.margins("10%")
    time_s, energy_j = twin().of_time(margins.time_s["economy"])
    assert time_s == pytest.approx(margins.time_s["economy"], rel=1e-3)
    assert margins.energy_j["economy"] == pytest.approx(energy_j, rel=2e-3)


def test_on_level_track_it_is_the_optimum_of_each_section():
    """The documented example of OSRD's running time, 10 % slower: 149.91 and 102.61 kWh, in closed form."""
    stopping = replace(OSRD_TRACK, stops_m=(0.0, 6000.0, 10_000.0))
    margins = tgvdp.journey(OSRD_TRAIN, stopping, convention="osrd", points=2).margins("10%")
    own_kwh = [run.total_energy_j / 3.6e6 for run in margins.runs["economy"]]
    assert own_kwh == pytest.approx([149.91, 102.61], rel=1e-3)


def test_it_holds_one_speed_and_coasts_down_to_the_speed_that_follows_from_it(hills):
    level = replace(HILLS, gradients=((0.0, 0.0),), speed_limits=((0.0, 40.0),))
    run = tgvdp.journey(TRAIN, level, points=2).margins("30%").profile("economy")
    held_mps = float(run.speed_mps.max())
    assert set(run.regime_names) == {"traction", "cruising", "coasting", "braking"}
    coasting = np.flatnonzero(run.regime == COASTING)
    assert run.speed_mps[coasting[-1] + 1] == pytest.approx(coasting_ends_mps(TRAIN, held_mps), rel=1e-4)
    assert run.regime[coasting[-1] + 1] == BRAKING


def test_it_coasts_into_descents_and_does_not_brake_on_them(hills):
    run = hills.margins("10%").profile("economy")
    on_the_descent = (run.position_m[:-1] >= 14_000.0) & (run.position_m[1:] <= 15_500.0)
    assert (run.regime[:-1][on_the_descent] == COASTING).all()
    before = np.interp(14_000.0, run.position_m, run.speed_mps)
    assert before < np.interp(15_500.0, run.position_m, run.speed_mps)


def test_a_climb_that_takes_a_run_up_bounds_the_cap():
    """The lowest caps tried stall on the climb: once that refused any margin."""
    weak = commuter(traction=EffortCurve.from_caps(1e5, 3e6))
    line = replace(HILLS, gradients=((0.0, 0.0), (10_000.0, 40.0), (10_400.0, 0.0)))
    margins = tgvdp.journey(weak, line, points=2).margins("5%")
    assert margins.time_s["economy"] == pytest.approx(margins.time_s["linear"], abs=0.1)
    assert margins.energy_j["optimum"] <= margins.energy_j["economy"] * (1.0 + 1e-4)


def test_without_resistance_coasting_ends_nowhere():
    assert coasting_ends_mps(replace(TRAIN, davis_a_n=0.0, davis_b_n_per_mps=0.0, davis_c_n_per_mps2=0.0), 20.0) == 0.0
    assert 0.0 < coasting_ends_mps(TRAIN, 20.0) < 20.0
    assert coasting_ends_mps(TRAIN, 1e6) == pytest.approx(2e6 / 3.0, rel=1e-3)  # R = C·v²: vf = ⅔·v1
