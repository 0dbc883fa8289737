"""Certificates of journeys: below every split, close to the front, and in closed form for single lines."""

import math

import numpy as np
import pytest

import tgvdp
from tests.helpers.journey_case import LINE, METRO
from tgvdp.certificate.front import Certificate
from tgvdp.journeys.bound import journey_bound


def certificate(*lines, fastest_s=1.0, fastest_j=1.0):
    multiplier, line_j = np.array(lines, dtype=float).reshape(-1, 2).T
    return Certificate(np.empty(0), np.empty(0), multiplier, line_j, fastest_s, fastest_j)


def test_bounds_are_added_at_one_multiplier():
    """E1 ≥ 10 − T, E2 ≥ 30 − 3T and both ≥ 0, fastest 2 s each: the best λ of each total."""
    first = certificate((0.0, 0.0), (1.0, 10.0), fastest_s=2.0, fastest_j=8.0)
    second = certificate((0.0, 0.0), (3.0, 30.0), fastest_s=2.0, fastest_j=24.0)
    time_s = np.array([4.0, 10.0, 12.0, 20.0, 30.0])
    grid_s = np.linspace(2.0, 40.0, 38_001)
    own_j = [np.maximum(0.0, 10.0 - grid_s), np.maximum(0.0, 30.0 - 3.0 * grid_s)]
    expected_j = []
    for total_s in time_s:
        rest_s = total_s - grid_s
        possible = rest_s >= 2.0
        expected_j.append((own_j[0] + np.interp(rest_s, grid_s, own_j[1]))[possible].min())
    bound = journey_bound([first, second], time_s)
    assert bound.lower_bound_j == pytest.approx(np.array(expected_j), abs=1e-2)
    assert (bound.lower_bound_j <= np.array(expected_j) + 1e-9).all()


def test_without_lines_nothing_is_known():
    assert math.isnan(journey_bound([certificate((0.0, 1.0)), certificate()], np.ones(1)).lower_bound_j[0])


def test_no_journey_of_the_fastest_time_is_cheaper_than_the_fastest():
    parts = [certificate((0.0, 0.0), fastest_s=3.0, fastest_j=own_j) for own_j in (5.0, 7.0)]
    assert journey_bound(parts, np.array([6.0, 6.1])).lower_bound_j == pytest.approx([12.0, 0.0])


@pytest.mark.parametrize("energy", ["wheel", "pantograph"])
def test_no_split_is_below_the_bound_and_the_front_is_close(energy):
    journey = tgvdp.journey(METRO, LINE, points=5, energy=energy)
    bound = journey.certify()
    assert bound.complete
    for points in (journey.front, *journey.found.practices.values()):
        assert (points.energy_j >= bound.lower_bound_j).all()
    gap_pct = bound.gap_pct(journey.front.energy_j)
    assert gap_pct[0] == pytest.approx(0.0, abs=1e-9)
    assert gap_pct.max() < 0.5


def test_a_map_has_no_bound():
    journey = tgvdp.journey("alstom-emu", LINE, points=2, energy="map")
    assert np.isnan(journey.certify().lower_bound_j).all()
