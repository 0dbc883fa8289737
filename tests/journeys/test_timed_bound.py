"""Bounds of journeys with windows: what time may cost in closed form, and between all paths of a grid and the runs."""

import math

import numpy as np
import pytest

import tgvdp
from tests.helpers.journey_case import LINE, METRO
from tgvdp.journeys.timed_bound import box_of, changes_of, most_cost_j, one_where_none_binds
from tgvdp.journeys.windows import Windows, windows_of
from tgvdp.model.journey import Journey, TimingPoint

STOP = {"lowest_mps": 0.0, "highest_mps": 0.0}


def windows(first=(-math.inf, math.inf), departs=(-math.inf, math.inf), dwell_s=10.0):
    """Two parts with a stop, or a point that is passed, between them."""
    return Windows(
        (TimingPoint(0.0, 0.0, 0.0), TimingPoint(1.0, *departs)),
        (TimingPoint(1.0, *first), TimingPoint(2.0)),
        (dwell_s,),
    )


def every_cost_j(windows, fastest_s, end_s, multiplier):
    """Largest Σ λT of all clocks by whole seconds."""
    most_j = -math.inf
    dwell_s = windows.dwells_s[0]
    for first_s in range(int(fastest_s[0]), int(end_s) + 1):
        arrives, departs = windows.arrivals[0], windows.departures[1]
        earliest_s = first_s + (dwell_s or 0.0)
        for second_s in [first_s] if dwell_s is None else range(int(earliest_s), int(end_s) + 1):
            if arrives.earliest_s <= first_s <= arrives.latest_s and departs.earliest_s <= second_s <= departs.latest_s:
                taken_s = end_s - second_s
                if taken_s >= fastest_s[1]:
                    most_j = max(most_j, multiplier[0] * first_s + multiplier[1] * taken_s)
    return most_j


@pytest.mark.parametrize("multiplier", [(3.0, 1.0), (1.0, 3.0), (2.0, 2.0)])
@pytest.mark.parametrize(
    "case",
    [
        windows(),
        windows(dwell_s=None),
        windows(first=(25.0, 30.0)),
        windows(first=(25.0, 30.0), dwell_s=None),
        windows(departs=(50.0, 55.0)),
        windows(first=(22.0, 24.0), departs=(50.0, 55.0)),
    ],
)
def test_what_time_may_cost(case, multiplier):
    fastest_s, end_s = [20.0, 30.0], 100.0
    box = box_of(case, fastest_s, end_s)
    most_j = every_cost_j(case, fastest_s, end_s, multiplier)
    for waiting_w in (0.0, 0.5):  # a second of the end is worth more than that of waiting
        waited_j = waiting_w * (end_s - (case.dwells_s[0] or 0.0))
        assert most_cost_j(case, box, np.array(multiplier), waiting_w) == pytest.approx(most_j - waited_j)


def test_multipliers_change_where_a_window_binds_or_the_train_waits():
    case = windows(first=(25.0, 30.0))
    box = box_of(case, [20.0, 30.0], 100.0)
    for arrival_s, departure_s, expected in ((27.0, 37.0, False), (30.0, 40.0, True), (27.0, 50.0, True)):
        clock_s = np.array([0.0, departure_s]), np.array([arrival_s, 100.0])
        assert changes_of(case, box, *clock_s, 0.1) == [expected]
    equal = one_where_none_binds(np.array([1.0, 4.0, 8.0]), np.array([10.0, 10.0, 5.0]), [False, True])
    assert equal == pytest.approx([2.0, 2.0, 8.0])


@pytest.mark.parametrize("energy", ["wheel", "pantograph"])
def test_journeys_with_windows_are_near_their_bound(energy):
    """A window between stops, one at a stop, a stop where the train waits."""
    free = tgvdp.journey(METRO, LINE, at_margin=(0.15,), energy=energy)
    profile = free.profile(0)
    passed_s = float(np.interp(2200.0, profile.position_m, profile.time_s))
    first, *between, last = (TimingPoint(at_m, **STOP) for at_m in LINE.stops_m)
    twice = [stop for stop in between for _ in range(2)]
    twice[3] = twice[3]._replace(earliest_s=free.found.departure_s[0, 2] + 12.0)
    passing = TimingPoint(2200.0, passed_s - 9.0, passed_s - 6.0)
    points = sorted(
        [first._replace(earliest_s=0.0, latest_s=0.0), passing, *twice, last], key=lambda one: one.position_m
    )
    journey = tgvdp.journey(METRO, LINE, Journey(points=tuple(points), track=LINE.name), points=5, energy=energy)
    bound = journey.certify()
    assert bound.complete
    assert windows_of(Journey(points=tuple(points)), 30.0).dwells_s.count(None) == 1
    gap_pct = bound.gap_pct(journey.front.energy_j)
    assert (gap_pct >= 0.0).all()
    assert np.median(gap_pct) < 0.2


def test_a_time_limit_leaves_points_without_a_bound():
    timetable = Journey(
        points=(TimingPoint(0.0, 0.0, 0.0, 0.0, 0.0), TimingPoint(600.0, 0.0, 60.0), TimingPoint(1200.0, **STOP))
    )
    bound = tgvdp.journey(METRO, LINE, timetable, points=3).certify(time_limit_s=1e-9)
    assert not bound.complete
    assert np.isnan(bound.lower_bound_j).all()
