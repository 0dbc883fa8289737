"""A section in one piece with windows on its way: windows are met, and a bound with the same multipliers is near."""

import numpy as np
import pytest

from tests.helpers.journey_case import sections_of
from tgvdp.journeys.whole import whole_run
from tgvdp.model.journey import TimingPoint

TOLERANCE_S = 3e-3
POINT_M = 2200.0
#: Times at a point may jump by hundredths of a second from one multiplier to the next.
JUMP_S = 0.1


@pytest.fixture(scope="module")
def section():
    """1200 m to 3400 m, downhill in the middle."""
    return sections_of()[1]


def run_of(section, *points, margin=1.25):
    time_s = margin * section.fastest.duration_s
    end = TimingPoint(section.trip.destination_m)
    multiplier = np.zeros(len(points) + 1)
    found = whole_run(section, section.trip, [*points, end], time_s, multiplier, TOLERANCE_S)
    assert found is not None
    return found


def window(at_m, first_s, last_s):
    return TimingPoint(at_m, first_s, last_s)


@pytest.fixture(scope="module")
def free(section):
    run, is_met = run_of(section, window(POINT_M, -np.inf, np.inf))
    assert is_met
    return run


def test_without_need_there_is_one_multiplier(section, free):
    section.reach(np.array([0.25 * section.fastest.duration_s]), TOLERANCE_S)
    assert free.profile.total_energy_j == pytest.approx(section.energy_j[-1], rel=1e-4)
    assert free.multiplier_j_per_s[0] == free.multiplier_j_per_s[1]
    assert free.ends_s[-1] == pytest.approx(1.25 * section.fastest.duration_s, abs=TOLERANCE_S)


@pytest.mark.parametrize("shift_s", [-8.0, -3.0, 3.0, 8.0])
def test_who_is_to_be_early_pays_more_for_seconds_before_and_who_late_less(section, free, shift_s):
    at_s = free.ends_s[0] + shift_s
    run, _ = run_of(section, window(POINT_M, at_s, at_s))
    assert run.ends_s[0] == pytest.approx(at_s, abs=JUMP_S)
    assert run.ends_s[1] == pytest.approx(free.ends_s[1], abs=TOLERANCE_S)
    before, after = run.multiplier_j_per_s
    assert (before > after) == (shift_s < 0.0)
    assert run.profile.total_energy_j > free.profile.total_energy_j


def test_the_multiplier_is_what_a_second_of_the_window_saves(section, free):
    """Energy over the time at the point has the slope −(λ before − λ after)."""
    at_s = free.ends_s[0] - 5.0 + np.array([-0.5, 0.0, 0.5])
    runs = [run_of(section, window(POINT_M, one_s, one_s))[0] for one_s in at_s]
    slope = (runs[2].profile.total_energy_j - runs[0].profile.total_energy_j) / (runs[2].ends_s[0] - runs[0].ends_s[0])
    before, after = runs[1].multiplier_j_per_s
    assert -slope == pytest.approx(before - after, rel=0.03)


def test_two_windows(section, free):
    first_s, second_s = np.interp([1800.0, 2800.0], free.profile.position_m, free.profile.time_s)
    points = window(1800.0, first_s - 4.0, first_s - 3.0), window(2800.0, second_s - 2.0, second_s - 1.0)
    run, is_met = run_of(section, *points)
    assert is_met
    assert (run.ends_s[:2] <= np.array([first_s - 3.0, second_s - 1.0]) + TOLERANCE_S).all()
    assert (run.ends_s[:2] >= np.array([first_s - 4.0, second_s - 2.0]) - TOLERANCE_S).all()


def test_two_windows_that_one_run_without_pulling_passes(section):
    """Each multiplier moves both times alike: one after the other they would not be found in any number of rounds."""
    points = window(1719.0, 46.005, 46.055), window(1969.0, 61.025, 61.075)
    run, is_met = run_of(section, *points)
    assert is_met
    assert run.keeps([*points, TimingPoint(section.trip.destination_m)], TOLERANCE_S)


def test_speeds_that_are_not_kept_are_told(section):
    _, is_met = run_of(section, window(POINT_M, -np.inf, np.inf)._replace(highest_mps=5.0))
    assert not is_met


def test_what_no_run_can_keep_has_none(section):
    end = TimingPoint(section.trip.destination_m)
    early = window(POINT_M, 0.0, 0.5 * section.fastest.duration_s - 40.0)
    time_s = 1.2 * section.fastest.duration_s
    assert whole_run(section, section.trip, [early, end], time_s, np.zeros(2), TOLERANCE_S) is None
