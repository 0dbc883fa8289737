"""Sections in one piece: windows that bind nothing cost nothing, and those that bind part no time of the sections."""

import math
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.journey_case import LINE, METRO
from tgvdp.journeys.multiplier import Demand
from tgvdp.journeys.passed import PassedRun, passing
from tgvdp.journeys.stretches import through
from tgvdp.model.journey import Journey, TimingPoint

TWO = replace(LINE, stops_m=(1200.0, 3400.0, 6000.0))
LEVEL = tgvdp.Track(length_m=100e3, speed_limits=((0.0, 300 / 3.6),), stops_m=(0.0, 50e3, 100e3))


def stop(at_m, earliest_s=-math.inf, latest_s=math.inf):
    return TimingPoint(at_m, earliest_s, latest_s, 0.0, 0.0)


def timetable(line, *passed, last_s=math.inf):
    first_m, middle_m, end_m = line.stops_m
    points = [stop(first_m, 0.0, 0.0), stop(middle_m), stop(middle_m), stop(end_m, latest_s=last_s), *passed]
    return Journey(points=tuple(sorted(points, key=lambda point: point.position_m)))


@pytest.mark.parametrize("at_m", [(41e3, 42e3), (5e3, 15e3, 25e3, 35e3, 45e3)])
def test_windows_that_bind_nothing_cost_nothing(at_m):
    """They were planned by speeds at each point alone, which near ones cannot have: 1.4 % and 0.4 % dearer."""
    free = tgvdp.journey("tgv", LEVEL, at_s=(1720.0,), dwell_s=30.0)
    wide = timetable(LEVEL, *(TimingPoint(one_m, latest_s=3000.0) for one_m in at_m), last_s=3600.0)
    timed = tgvdp.journey("tgv", LEVEL, wide, at_s=(1750.0,), dwell_s=30.0)
    assert timed.front.energy_j[-1] == pytest.approx(free.front.energy_j[-1], rel=1e-4)
    assert timed.section_time_s[-1] == pytest.approx(free.section_time_s[-1], abs=0.5)


def test_a_stop_is_kept_wherever_rounding_puts_the_end_of_its_section():
    """A run that ended a rounding behind its stop did not stand there: its windows were never kept (37 % dearer)."""
    from_m, until_m = 21521.8, 63933.1
    assert from_m + (until_m - from_m) > until_m
    line = replace(LEVEL, stops_m=(0.0, from_m, until_m))
    free = tgvdp.journey("tgv", line, at_margin=(0.05,), dwell_s=30.0)
    wide = timetable(line, TimingPoint(42e3, latest_s=5000.0), last_s=9000.0)
    timed = tgvdp.journey("tgv", line, wide, at_s=(float(free.front.time_s[-1]) + 30.0,), dwell_s=30.0)
    assert timed.section_time_s[-1] == pytest.approx(free.section_time_s[-1], abs=0.05)


def test_a_speed_that_is_asked_for_is_kept_but_for_rounding():
    section = tgvdp.journey("tgv", LEVEL, at_margin=(0.0,)).sections[0]
    own_mps = float(passing(section.fastest, np.array([25e3]))[1][0])
    ends_s = passing(section.fastest, np.array([25e3, 50e3]))[0]
    run = PassedRun(section.fastest, ends_s, np.zeros(2), 0.0)
    for share, is_kept in ((1e-12, True), (1e-6, False)):
        slower = TimingPoint(25e3, highest_mps=own_mps * (1.0 - share))
        faster = TimingPoint(25e3, lowest_mps=own_mps * (1.0 + share))
        assert [run.keeps([point, stop(50e3)], 0.0) for point in (slower, faster)] == [is_kept, is_kept]


@pytest.mark.parametrize("early_s", [3.0, 6.0])
def test_a_section_with_a_window_and_one_behind_it_share_their_time_as_is_best(early_s):
    """No other arrival at the stop between them is cheaper: each part is solved alone for it."""
    free = tgvdp.journey(METRO, TWO, at_margin=(0.15,), dwell_s=0.0)
    total_s = float(free.front.time_s[0])
    first = free.section_profiles(0)[0]
    bound_s = float(passing(first, np.array([2200.0]))[0][0]) - early_s
    point = TimingPoint(2200.0, latest_s=bound_s)
    timed = tgvdp.journey(METRO, TWO, timetable(TWO, point, last_s=total_s + 0.1), at_s=(total_s,), dwell_s=0.0)
    own_s = float(timed.section_time_s[-1][0])
    alone = replace(LINE, stops_m=TWO.stops_m[:2])
    least_j = math.inf
    for one_s in own_s + np.array([-2.0, -1.0, 0.0, 1.0, 2.0]):
        ends = Journey(points=(stop(1200.0, 0.0, 0.0), point, stop(3400.0, latest_s=one_s + 0.01)))
        before = tgvdp.journey(METRO, alone, ends, at_s=(one_s,))
        after = tgvdp.search(METRO, TWO, origin_m=3400.0, at_s=(total_s - one_s,))
        least_j = min(least_j, before.front.energy_j[-1] + after.front.energy_j[-1])
    assert timed.front.energy_j[-1] <= least_j * (1.0 + 2e-4)


@pytest.mark.parametrize("slow_kmh", [30.0, 60.0])
def test_slow_passing_that_is_possible_is_found(slow_kmh):
    """Points were never passed at less than a quarter of the fastest run's speed: these windows were refused."""
    line = replace(LEVEL, length_m=60e3, stops_m=(0.0, 60e3))
    slow = tgvdp.search("tgv", line, speed_restrictions=[(20e3, 21e3, slow_kmh / 3.6)], at_margin=(0.05,)).profile(0)
    at_m = np.array([20e3, 20.5e3, 21e3])
    windows = [
        TimingPoint(one_m, one_s - 2.0, one_s + 2.0)
        for one_m, one_s in zip(at_m.tolist(), passing(slow, at_m)[0].tolist(), strict=True)
    ]
    points = (stop(0.0, 0.0, 0.0), *windows, stop(60e3, latest_s=slow.duration_s + 5.0))
    timed = tgvdp.journey("tgv", line, Journey(points=points), at_s=(slow.duration_s,))
    assert timed.front.energy_j[-1] <= slow.total_energy_j
    passed_s = passing(timed.profile(len(timed.front) - 1), at_m)[0]
    assert all(one.earliest_s <= own_s <= one.latest_s for one, own_s in zip(windows, passed_s, strict=True))


def test_windows_that_close_at_the_times_of_the_fastest_run_are_kept():
    line = replace(LEVEL, length_m=12e3, stops_m=(0.0, 12e3))
    fastest = tgvdp.journey("alstom-emu", line, at_margin=(0.0,)).sections[0].fastest
    at_m = float(fastest.position_m[len(fastest.position_m) // 2])
    latest_s = float(passing(fastest, np.array([at_m]))[0][0])
    points = (stop(0.0, 0.0, 0.0), TimingPoint(at_m, latest_s=latest_s), stop(12e3, latest_s=fastest.duration_s))
    timed = tgvdp.journey("alstom-emu", line, Journey(points=points), at_margin=(0.0,))
    assert timed.front.time_s == pytest.approx(fastest.duration_s, abs=0.01)


def test_between_rows_a_train_is_where_its_acceleration_leads():
    fastest = tgvdp.journey("tgv", LEVEL, at_margin=(0.0,)).sections[0].fastest
    time_s, speed_mps = passing(fastest, fastest.position_m)
    assert time_s == pytest.approx(fastest.time_s, abs=1e-9)
    assert speed_mps == pytest.approx(fastest.speed_mps, abs=1e-9)
    half_m = 0.5 * fastest.position_m[1]
    assert passing(fastest, np.array([half_m]))[0][0] == pytest.approx(fastest.time_s[1] / math.sqrt(2.0))


def test_a_demand_goes_through_what_was_found_and_between_that_along_the_chord():
    demand = Demand(np.array([0.0, 10.0, 20.0]), np.array([5.0, 3.0, 1.0]))
    one = through(demand, [(8.0, 30.0)])
    assert np.exp(np.interp(8.0, one.supplement_s, one.log_multiplier)) == pytest.approx(30.0)
    two = through(demand, [(8.0, 30.0), (12.0, 10.0)])
    assert np.exp(np.interp(10.0, two.supplement_s, two.log_multiplier)) == pytest.approx(20.0, rel=1e-6)
    # What was found before and cannot be any more is forgotten.
    assert through(demand, [(8.0, 5.0), (12.0, 10.0)]).supplement_s == pytest.approx(
        through(demand, [(12.0, 10.0)]).supplement_s
    )


def test_points_are_passed_as_fast_as_what_is_asked_at_the_others_lets_a_train():
    """Each was to be passed as fast as if nothing were asked at the others: no run led from one to the next."""
    line = replace(LEVEL, length_m=30e3, stops_m=(0.0, 30e3))
    slow = TimingPoint(15e3, highest_mps=20.0)
    near = TimingPoint(14.8e3, latest_s=600.0), slow, TimingPoint(15.2e3, latest_s=600.0, lowest_mps=22.0)
    points = (stop(0.0, 0.0, 0.0), *near, stop(30e3, latest_s=900.0))
    timed = tgvdp.journey("tgv", line, Journey(points=points), at_s=(700.0,))
    alone = tgvdp.journey("tgv", line, Journey(points=(points[0], slow, points[-1])), at_s=(700.0,))
    assert timed.front.energy_j[-1] == pytest.approx(alone.front.energy_j[-1], rel=1e-4)
    speed_mps = passing(timed.profile(0), np.array([15e3, 15.2e3]))[1]
    assert speed_mps[0] <= 20.0 * (1.0 + 1e-9)
    assert speed_mps[1] >= 22.0
