"""Full effort of the dynamic brake, which follows its limit: nothing of it is lost to friction."""

from dataclasses import replace

import numpy as np
import pytest

from tgvdp.line.resolved import resolve
from tgvdp.model.effort import EffortCurve
from tgvdp.model.energy import PANTOGRAPH, EnergyMap, EnergyModel
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.referee.replay import replay
from tgvdp.runs.batch import Batch
from tgvdp.runs.bends import cut_at_bends
from tgvdp.runs.profile import profile_of

#: A brake of 2 MW above 10 m/s, and friction; no resistance: all kinetic energy goes through the brakes.
TRAIN = Train(
    mass_kg=2e5,
    traction=EffortCurve.from_caps(2e5, 2e6),
    braking=EffortCurve.from_caps(2e5, 2e6),
    friction_brake_n=1e5,
    regeneration_efficiency=0.8,
)
FAST_MPS, SLOW_MPS, POWER_W, ROWS = 30.0, 15.0, 2e6, 100
#: The train's efficiencies, 1 and 0.8, as a map: both brakes and motors have 2 MW from 10 m/s on.
FULL_W = (-1.6e6, 0.0, 2e6)
MAP = EnergyModel(
    "map",
    EnergyMap(speed_mps=(0.0, 10.0, 40.0), demand=(-1.0, 0.0, 1.0), power_w=((0.0, 0.0, 0.0), FULL_W, FULL_W)),
)


def braked(train: Train, share: float, energy: EnergyModel = PANTOGRAPH):
    """A trip on which a share of the dynamic brake's power, taken at 2 MW, slows the train; P·x = m·(v0³ − v1³)/3."""
    v = np.linspace(FAST_MPS, SLOW_MPS, ROWS + 1)
    x = train.inertia_kg * (FAST_MPS**3 - v**3) / (3.0 * share * POWER_W)
    track = Track(length_m=float(x[-1]), speed_limits=((0.0, 40.0),))
    trip = Trip(
        train=train, track=track, origin_m=0.0, destination_m=float(x[-1]), start_speed_mps=FAST_MPS,
        end_speed_mps=SLOW_MPS, energy=energy,
    )  # fmt: skip
    return trip, profile_of(trip, x, v**2)


@pytest.mark.parametrize("energy", [PANTOGRAPH, MAP], ids=["factors", "map"])
@pytest.mark.parametrize("share", [0.7, 0.996, 1.0, 1.1])
def test_the_dynamic_brake_takes_what_it_can(share, energy):
    """All of the kinetic energy up to its full effort, and P·T beyond that; the referee has it so, too."""
    trip, profile = braked(TRAIN, share, energy)
    kinetic_j = 0.5 * TRAIN.inertia_kg * (FAST_MPS**2 - SLOW_MPS**2)
    assert profile.total_energy_j == pytest.approx(-0.8 * kinetic_j * min(1.0, 1.0 / share), rel=5e-6)
    verdict = replay(trip, profile)
    assert verdict.ok
    assert abs(verdict.energy_error_pct) < 1e-3
    assert abs(verdict.time_error_pct) < 1e-3


def test_rows_that_are_cut_follow_the_brake():
    """An hour of full braking, cut where its motion bends: its time, m/P·(v0² − v1²)/2, and nothing for friction."""
    heavy = replace(TRAIN, mass_kg=2e7)
    trip, profile = braked(heavy, 1.0)
    rows = profile.position_m, profile.speed_mps**2
    runs, parts = cut_at_bends(heavy, resolve(trip), Batch.of([rows]))
    assert parts.max() > 1
    cut = profile_of(trip, runs.x_m, runs.w)
    kinetic_j = 0.5 * heavy.inertia_kg * (FAST_MPS**2 - SLOW_MPS**2)
    assert cut.duration_s == pytest.approx(kinetic_j / POWER_W, abs=1e-3)
    assert cut.balance.regenerated_j == pytest.approx(0.8 * kinetic_j, rel=5e-6)
    verdict = replay(trip, cut)
    assert verdict.ok
    assert abs(verdict.energy_error_pct) < 1e-3


def test_rows_that_are_cut_keep_to_the_braking_rate():
    """The dynamic brake's effort grows along a row whose mean deceleration is within the rate, but not its end."""
    rate_mps2 = POWER_W / (1.0025 * SLOW_MPS) / 2e7
    heavy = replace(TRAIN, mass_kg=2e7, braking_rates=((0.0, rate_mps2),))
    trip, profile = braked(heavy, 1.0)
    runs, parts = cut_at_bends(heavy, resolve(trip), Batch.of([(profile.position_m, profile.speed_mps**2)]))
    assert parts[-2] > 1
    assert (-np.diff(runs.w) / (2.0 * np.diff(runs.x_m))).max() <= rate_mps2 * (1.0 + 1e-6)


def test_a_rate_that_is_kept_leaves_friction_the_rest():
    """Where comfort gives the effort it is constant, whatever the dynamic brake could do a little slower."""
    v = np.array([20.2, 19.8])
    rate_mps2 = POWER_W / 20.0 / TRAIN.inertia_kg
    train = replace(TRAIN, max_deceleration_mps2=rate_mps2)
    x = np.array([0.0, 0.5 * (v[0] ** 2 - v[1] ** 2) / rate_mps2])
    trip = Trip(
        train=train, track=Track(length_m=float(x[-1]), speed_limits=((0.0, 40.0),)), origin_m=0.0,
        destination_m=float(x[-1]), start_speed_mps=v[0], end_speed_mps=v[1], energy=PANTOGRAPH,
    )  # fmt: skip
    speeds = np.sqrt(np.linspace(v[0] ** 2, v[1] ** 2, 20001))
    taken_n = np.minimum(POWER_W / (0.5 * (speeds[1:] + speeds[:-1])), train.inertia_kg * rate_mps2).mean()
    profile = profile_of(trip, x, v**2)
    assert profile.balance.regenerated_j == pytest.approx(0.8 * taken_n * x[-1], rel=1e-6)
    verdict = replay(trip, profile)
    assert verdict.ok
    assert abs(verdict.energy_error_pct) < 1e-4
