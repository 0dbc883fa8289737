"""Neutral sections in the front method: no traction there, and no auxiliaries where the pantograph is lowered."""

from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.metro_case import TRAIN
from tgvdp import EffortCurve, Track, Train
from tgvdp.line.cells import cells_of
from tgvdp.model.energy import WHEEL
from tgvdp.model.train import BrakingRate

#: So little that the train may run much longer and save energy.
FRUGAL = replace(TRAIN, auxiliary_power_w=50e3)
LINE = Track(
    length_m=12_000.0,
    speed_limits=((0.0, 16.0), (600.0, 25.0), (9000.0, 18.0)),
    gradients=((0.0, 3.0), (700.0, -8.0), (1500.0, 0.0), (1900.0, 6.0), (4000.0, 0.0)),
)


def found(*sections, **options):
    track = replace(LINE, neutral_sections=sections)
    return tgvdp.search(FRUGAL, track, energy="pantograph", points=12, **options)


@pytest.mark.parametrize("lowered", [False, True])
def test_points_are_optimal_and_feasible(lowered):
    result = found((1200.0, 400.0, lowered), (5000.0, 150.0, lowered), (11_800.0, 200.0, lowered))
    assert len(result.front.time_s) == 12
    assert not result.warnings
    assert all(verdict.ok for verdict in result.verify())
    gap_pct = result.certify().gap_pct
    assert gap_pct.min() >= -1e-3
    assert np.median(gap_pct[2:]) <= 0.05
    assert gap_pct[2:].max() <= 0.2


def test_there_is_no_traction_and_no_dynamic_brake():
    result = found((1200.0, 400.0, False), (5000.0, 150.0, True))
    profile = result.profile(6)
    for start_m, end_m in ((1200.0, 1600.0), (5000.0, 5150.0)):
        inside = (profile.position_m >= start_m) & (profile.position_m < end_m)
        assert (np.abs(profile.force_n[inside]) <= 1e-3 * TRAIN.traction.effort_n(0.0)).all()
    lowered = (profile.position_m >= 5000.0) & (profile.position_m <= 5150.0)
    assert np.ptp(profile.energy_j[lowered]) == 0.0


def test_where_the_train_coasts_anyway_a_neutral_section_costs_nothing():
    without = found()
    profile = without.profile(9)
    coasting = (profile.regime == 2) & (profile.position_m > 1000.0)
    start_m, end_m = profile.position_m[coasting][0], profile.position_m[coasting][-1]
    inside_m = float(start_m + 0.4 * (end_m - start_m))
    with_one = found((inside_m, 0.2 * (float(end_m) - inside_m), False))
    i, j = 9, 9
    price_j_per_s = without.price_kwh_per_min[i] * 3.6e6 / 60.0
    late_s = with_one.front.time_s[j] - without.front.time_s[i]
    assert with_one.front.energy_j[j] + price_j_per_s * late_s == pytest.approx(without.front.energy_j[i], rel=5e-4)


def test_lowering_saves_the_auxiliaries_of_the_stretch_and_slows_down_in_it():
    """A second is cheaper there by their power, so that the run takes longer in it than with the pantograph up."""
    section = (4500.0, 900.0)
    raised, lowered = found((*section, False)), found((*section, True))

    def seconds_inside(result):
        profile = result.profile(6)
        at_s = np.interp((section[0], sum(section)), profile.position_m, profile.time_s)
        return float(at_s[1] - at_s[0])

    assert seconds_inside(lowered) > seconds_inside(raised)
    saved_j = raised.front.energy_j[6] - lowered.front.energy_j[6]
    assert saved_j >= FRUGAL.auxiliary_power_w * seconds_inside(raised) * (1.0 - 1e-3)


def test_stepped_rates_and_neutral_sections_have_a_front():
    """One arc of constant acceleration per cell is no such run: the refinement found no fastest one."""
    train = Train(
        mass_kg=134.5e3, traction=EffortCurve.from_caps(143.7e3, 1.77e6), friction_brake_n=80e3,
        braking_rates=tuple(
            BrakingRate(*row) for row in ((0.0, 0.547), (8.88, 1.877), (21.61, 0.1197), (31.33, 0.335))
        ),
        rotating_mass_factor=1.045, davis_a_n=2461.0, davis_b_n_per_mps=66.2, davis_c_n_per_mps2=7.4,
        max_acceleration_mps2=1.0, max_deceleration_mps2=0.9, max_speed_mps=38.2,
        traction_efficiency=0.896, regeneration_efficiency=0.5,
    )  # fmt: skip
    track = Track(
        length_m=11_278.0,
        speed_limits=((0.0, 38.0), (520.0, 19.44), (1564.0, 33.33), (7743.0, 31.94)),
        neutral_sections=((1701.0, 200.0, True), (3290.0, 338.0, False), (6559.0, 200.0, False)),
    )
    result = tgvdp.search(train, track, energy="pantograph", points=12)
    assert len(result.front.time_s) == 12
    assert not result.warnings
    assert result.certify().gap_pct[2:].max() <= 0.2


def test_auxiliaries_that_are_not_drawn_are_known_to_cells():
    trip = found((1200.0, 400.0, False), (5000.0, 150.0, True)).trip
    cells = cells_of(trip)
    inside = (cells.station_m[:-1] >= 5000.0) & (cells.station_m[1:] <= 5150.0)
    assert (cells.saved_w == np.where(inside, FRUGAL.auxiliary_power_w, 0.0)).all()
    assert not cells_of(replace(trip, energy=WHEEL)).saved_w.any()
