"""Comfort limits what the effort does: where the line alone does more, none is added."""

import numpy as np
import pytest

import tgvdp
from tgvdp import EffortCurve, Gradient, SpeedLimit, Track, Train
from tgvdp.model.track import NeutralSection

TRAIN = Train(
    mass_kg=2e5, traction=EffortCurve.from_caps(2e5, 3e6), friction_brake_n=3e5, davis_a_n=3e3, davis_c_n_per_mps2=9.0,
    max_acceleration_mps2=0.4, max_deceleration_mps2=0.3, traction_efficiency=0.85,
)  # fmt: skip


def _track(permil, neutral_m=()):
    return Track(
        length_m=6e3,
        speed_limits=(SpeedLimit(0.0, 40.0),),
        gradients=(Gradient(0.0, 0.0), Gradient(2e3, permil), Gradient(2.8e3, 0.0)),
        neutral_sections=tuple(NeutralSection(at_m, 200.0, False) for at_m in neutral_m),
    )


CASES = {
    # Without current nothing can keep the deceleration of a climb small.
    "neutral section on a climb": (TRAIN, _track(45.0, (2.3e3,)), {}),
    # Nor can traction, where the drag is ten times what it gives.
    "drag": (
        Train(mass_kg=2e5, traction=EffortCurve.from_caps(2e5, 3e6), friction_brake_n=3e5, davis_a_n=3e3,
              davis_c_n_per_mps2=150.0, max_deceleration_mps2=0.5, max_speed_mps=80.0),
        Track(length_m=6e3, speed_limits=(SpeedLimit(0.0, 80.0),)),
        {"start_speed_mps": 70.0},
    ),
    "steep descent": (TRAIN, _track(-60.0), {}),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_no_effort_adds_to_what_the_line_does_beyond_comfort(case):
    train, track, speeds = CASES[case]
    result = tgvdp.search(train, track, points=6, energy="pantograph", **speeds)
    assert all(verdict.ok for verdict in result.verify())
    assert np.abs(result.certify().gap_pct[2:]).max() < 0.1
    fastest = result.profile(0)
    acceleration = np.diff(fastest.speed_mps**2) / (2.0 * np.diff(fastest.position_m))
    uncomfortable = (acceleration > 1.001 * train.max_acceleration_mps2) | (
        acceleration < -1.001 * train.max_deceleration_mps2
    )
    assert uncomfortable.any()
    adds_n = fastest.force_n[:-1] * np.sign(acceleration)
    assert adds_n[uncomfortable].max() < 1e-3 * train.traction.effort_n(0.0)


def test_what_coasts_to_a_limit_just_before_the_end_of_a_cell_does_not_brake_there():
    """Brakes of 0.4 % held it for the last 3 mm, on a climb that slows it more than comfort lets brakes do."""
    train = Train(
        mass_kg=78.3e3, rotating_mass_factor=1.053, davis_a_n=2959.0, davis_b_n_per_mps=31.4, davis_c_n_per_mps2=3.92,
        traction=EffortCurve.from_caps(68.5e3, 957e3), braking=EffortCurve.from_caps(54.6e3, 957e3),
        friction_brake_n=119e3, max_acceleration_mps2=0.2523, max_deceleration_mps2=0.2986,
        traction_efficiency=0.89, regeneration_efficiency=0.85, auxiliary_power_w=23.5e3,
    )  # fmt: skip
    limits = ((0.0, 75.0), (537.6, 75.0), (613.4, 45.0), (948.9, 60.0), (1772.7, 50.0))
    climbs = (
        (0.0, 54.6), (0.3, 49.0), (145.5, 19.9), (325.7, 45.4), (413.0, 0.0), (543.0, 32.9), (992.4, 35.6),
        (1133.0, 0.0), (1742.4, 45.0), (1834.2, 54.4), (1973.3, 53.1),
    )  # fmt: skip
    track = Track(length_m=2043.0, speed_limits=tuple((at_m, kmh / 3.6) for at_m, kmh in limits), gradients=climbs)
    margins = np.linspace(0.002, 0.25, 300)
    result = tgvdp.search(train, track, start_speed_mps=8.0, energy="pantograph", at_margin=margins)
    assert max(verdict.effort_excess_pct for verdict in result.verify()) < 0.1
