"""The certificate where a run on a mesh slips into a regime that no optimal run has there."""

import numpy as np
import pytest

import tgvdp
from tgvdp import EffortCurve, Gradient, SpeedLimit, Track, Train
from tgvdp.certificate.line import BoundingProblem
from tgvdp.model.train import BrakingRate

METRO = Train(
    mass_kg=157e3, traction=EffortCurve.from_caps(136e3, 1.4e6), braking=EffortCurve.from_caps(97.65e3, 1.098e6),
    friction_brake_n=97.65e3, braking_rates=(BrakingRate(0.0, 1.074),), rotating_mass_factor=1.0367, davis_a_n=2870.0,
    davis_b_n_per_mps=91.3, davis_c_n_per_mps2=7.47, max_deceleration_mps2=0.8476, max_speed_mps=29.8,
    traction_efficiency=0.911, regeneration_efficiency=0.5, auxiliary_power_w=15.7e3,
)  # fmt: skip
STREETS = Track(
    length_m=7e3, gradients=(Gradient(0.0, -2.14), Gradient(4619.0, 2.23)),
    speed_limits=tuple(
        map(
            SpeedLimit._make,
            [(0.0, 13.9), (1029.0, 29.8), (1939.0, 9.72), (2628.0, 23.6), (3545.0, 29.8), (5050.0, 27.8)],
        )
    ),
)  # fmt: skip
EXPRESS = Train(
    mass_kg=556e3, traction=EffortCurve.from_caps(185.5e3), friction_brake_n=392.6e3, rotating_mass_factor=1.079,
    davis_a_n=3837.0, davis_b_n_per_mps=60.6, davis_c_n_per_mps2=6.22, max_acceleration_mps2=0.657, max_speed_mps=91.9,
)  # fmt: skip
HILLS = Track(
    length_m=12e3, speed_limits=tuple(map(SpeedLimit._make, [(0.0, 33.333), (2306.0, 38.889), (4052.0, 45.833)])),
    gradients=tuple(
        map(
            Gradient._make,
            [(0.0, 3.28), (520.0, -35.7), (1121.0, 0.0), (1286.0, -32.85), (1500.0, 20.6), (2525.0, -32.7),
             (2947.0, 14.0), (4000.0, 0.0)],
        )
    ),
)  # fmt: skip


@pytest.mark.parametrize(
    ("train", "track", "energy"),
    [(METRO, STREETS, "pantograph"), (EXPRESS, HILLS, "wheel")],
    ids=["friction for a hand's breadth where the dynamic brake meets the limit", "held back before the limit is met"],
)
def test_no_slip_widens_the_gap(train, track, energy):
    """0.39 and 0.70 % with costates that took the slips for phases."""
    gap_pct = tgvdp.search(train, track, points=12, energy=energy).certify().gap_pct
    assert gap_pct.min() > -0.001
    assert gap_pct.max() < 0.05


def test_costates_of_lasting_phases_are_taken_where_they_are_better_alone():
    result = tgvdp.search(METRO, STREETS, points=12, energy="pantograph")
    problem, profile = BoundingProblem(result.trip), result.profile(11)
    rows = profile.position_m, profile.speed_mps**2
    price = 60.0 * result.price_kwh_per_min[11] * 1e3
    ledger = problem.ledger(*rows, price)
    again = problem.evaluate(ledger, problem.total(price) / problem.train.inertia_kg, ledger.left, ledger.right)
    np.testing.assert_allclose(again.bound, ledger.bound, rtol=1e-9, atol=1e-12 * abs(ledger.bound).max())
