"""The certificate of trains whose braking rates are larger at lower speeds: chords for braking."""

import pytest

import tgvdp
from tgvdp import EffortCurve, SpeedLimit, Track, Train
from tgvdp.model.train import BrakingRate

TRAIN = Train(
    mass_kg=150e3, traction=EffortCurve.from_caps(150e3, 2e6), friction_brake_n=120e3, davis_a_n=2500.0,
    davis_c_n_per_mps2=6.0, rotating_mass_factor=1.06,
    braking_rates=(BrakingRate(0.0, 1.1), BrakingRate(7.0, 0.8), BrakingRate(14.0, 0.3)),
)  # fmt: skip
TRACK = Track(length_m=3e3, speed_limits=(SpeedLimit(0.0, 22.0), SpeedLimit(1500.0, 10.0), SpeedLimit(1800.0, 22.0)))


@pytest.mark.parametrize("energy", ["wheel", "pantograph"])
def test_gaps_of_rates_that_rise_as_the_train_slows_down(energy):
    gap_pct = tgvdp.search(TRAIN, TRACK, points=8, energy=energy).certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct[2:].max() < 0.05
