"""Windows between stops: against the run without them, against exact fronts on a grid, and what cannot be kept."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.journey_case import LINE, METRO
from tgvdp.errors import InfeasibleError
from tgvdp.model.journey import Journey, TimingPoint

ONE = replace(LINE, stops_m=(1200.0, 3400.0))
TWO = replace(LINE, stops_m=(1200.0, 3400.0, 6000.0))
HALF_M = 2200.0


def timetable(*passing, line=ONE, last_s=math.inf):
    def stop(position_m, earliest_s=-math.inf, latest_s=math.inf):
        return TimingPoint(position_m, earliest_s, latest_s, 0.0, 0.0)

    first_m, *between_m, end_m = line.stops_m
    stops = [stop(first_m, 0.0, 0.0), *(stop(at_m) for at_m in between_m for _ in range(2)), stop(end_m, 0.0, last_s)]
    return Journey(points=tuple(sorted([*stops, *passing], key=lambda point: point.position_m)), track=line.name)


def run(*passing, line=ONE, **options):
    last_s = options.pop("last_s", math.inf)
    return tgvdp.journey(METRO, line, timetable(*passing, line=line, last_s=last_s), **options)


def passed(journey, index, position_m=HALF_M):
    """Time and speed at a position, s and m/s."""
    profile = journey.profile(index)
    time_s = np.interp(position_m, profile.position_m, profile.time_s)
    return time_s, np.sqrt(np.interp(position_m, profile.position_m, profile.speed_mps**2))


def test_a_window_that_does_not_bind_costs_nothing():
    free = tgvdp.journey(METRO, TWO, points=5)
    wide = run(TimingPoint(HALF_M, 0.0, 1e4), line=TWO, points=5)
    assert wide.front.time_s == pytest.approx(free.front.time_s, abs=0.02)
    assert wide.front.energy_j[1:] == pytest.approx(free.front.energy_j[1:], rel=2e-3)
    assert (wide.front.energy_j >= free.certify().lower_bound_j * (1.0 - 1e-9)).all()


@pytest.mark.parametrize(("shift_s", "width_s"), [(-6.0, 1.0), (6.0, 1.0), (4.0, 0.0)])
def test_windows_are_met_and_runs_replay(shift_s, width_s):
    free = tgvdp.journey(METRO, ONE, at_margin=(0.15,))
    earliest_s = passed(free, 0)[0] + shift_s
    journey = run(TimingPoint(HALF_M, earliest_s, earliest_s + width_s), points=6, max_margin=0.3)
    assert len(journey.front) > 2
    for index in range(len(journey.front)):
        assert earliest_s - 2e-3 <= passed(journey, index)[0] <= earliest_s + width_s + 2e-3
    assert all(verdict.ok for point in journey.verify() for verdict in point)


@pytest.mark.parametrize("shift_s", [-30.0, -20.0, 20.0, 35.0])
def test_windows_are_met_on_long_trips_whose_times_are_met_less_well(shift_s):
    """Times are met to 10 ms there: who aims at the end of a window is outside it half of the time."""
    free = tgvdp.search("tgv", "flat-100km", at_margin=(0.1,))
    earliest_s = passed(free, len(free.front) - 1, 40_000.0)[0] + shift_s
    stops = [TimingPoint(at_m, 0.0, latest_s, 0.0, 0.0) for at_m, latest_s in ((0.0, 0.0), (100_000.0, math.inf))]
    points = (stops[0], TimingPoint(40_000.0, earliest_s, earliest_s + 0.5), stops[1])
    timed = tgvdp.journey("tgv", "flat-100km", Journey(points=points), at_s=(1.02 * free.front.time_s[-1],))
    at_s = passed(timed, len(timed.front) - 1, 40_000.0)[0]
    assert earliest_s <= at_s <= earliest_s + 0.5


def exact_front(from_m, to_m, **speeds):
    found = tgvdp.search(
        METRO, ONE, origin_m=from_m, destination_m=to_m, method="exact", segment_m=250.0, speeds=9, **speeds
    )
    return found.front.time_s, found.front.energy_j


def test_no_exact_path_on_a_grid_with_the_window_is_cheaper():
    """All Pareto-optimal paths of a grid before and after the point, at four speeds there."""
    window = TimingPoint(HALF_M, 90.0, 93.0)
    journey = run(window, points=5, max_margin=0.3)
    halves = []
    for speed_mps in (6.0, 9.0, 12.0, 15.0):
        before = exact_front(1200.0, HALF_M, end_speed_mps=speed_mps)
        after = exact_front(HALF_M, 3400.0, start_speed_mps=speed_mps)
        halves.append((*before, *after))
    for time_s, energy_j in zip(journey.front.time_s[1:], journey.front.energy_j[1:], strict=True):
        least_j = math.inf
        for first_s, first_j, second_s, second_j in halves:
            met = (first_s >= window.earliest_s) & (first_s <= window.latest_s)
            met = met[:, None] & (first_s[:, None] + second_s <= time_s)
            least_j = min(least_j, np.where(met, first_j[:, None] + second_j, math.inf).min(initial=math.inf))
        assert energy_j <= least_j * (1.0 + 1e-3)


def test_windows_hold_for_energies_by_a_map():
    """Runs by a map may be slower and dearer than another; who is faster than planned waits before it leaves."""
    free = tgvdp.journey(METRO, TWO, at_margin=(0.2,), energy="map", dwell_s=20.0)
    first_s, last_s = (free.profile(0).time_s[at] for at in (np.searchsorted(free.profile(0).position_m, 3400.0), -1))
    rows = list(timetable(line=TWO, last_s=last_s + 10.0).points)
    rows[1] = rows[1]._replace(earliest_s=first_s - 1.0, latest_s=first_s + 1.0)
    rows[3] = rows[3]._replace(earliest_s=last_s - 2.0)
    options = {"energy": "map", "dwell_s": 20.0, "points": 6, "time_limit_s": 600.0}
    journey = tgvdp.journey(METRO, TWO, Journey(points=tuple(rows)), **options)
    arrival_s = journey.found.departure_s + journey.section_time_s
    assert (arrival_s[:, 0] >= first_s - 1.0).all()
    assert (arrival_s[:, 0] <= first_s + 1.0 + 1e-9).all()
    assert (arrival_s[:, 1] >= last_s - 2.0).all()
    assert not journey.found.left


def test_the_multipliers_part_at_a_binding_window():
    free = tgvdp.journey(METRO, TWO, at_margin=(0.15,))
    before_s = passed(free, 0)[0]
    journey = run(TimingPoint(HALF_M, 0.0, before_s - 5.0), line=TWO, at_margin=(0.15,))
    assert passed(journey, 0)[0] == pytest.approx(before_s - 5.0, abs=0.01)
    assert journey.front.energy_j[0] > 1.01 * free.front.energy_j[0]


def test_speeds_at_a_point_are_kept():
    slow = run(TimingPoint(HALF_M, highest_mps=8.0), points=4)
    assert all(passed(slow, index)[1] <= 8.0 + 1e-6 for index in range(len(slow.front)))
    fast = run(TimingPoint(HALF_M, lowest_mps=14.0), points=4, max_margin=0.6)
    assert all(passed(fast, index)[1] >= 14.0 - 1e-6 for index in range(len(fast.front)))


def test_two_points_between_two_stops():
    free = tgvdp.journey(METRO, ONE, at_margin=(0.2,))
    first_s, second_s = (passed(free, 0, position_m)[0] for position_m in (1800.0, 2800.0))
    points = TimingPoint(1800.0, first_s - 4.0, first_s - 3.0), TimingPoint(2800.0, second_s + 1.0, second_s + 3.0)
    journey = run(*points, at_margin=(0.2,))
    assert first_s - 4.01 <= passed(journey, 0, 1800.0)[0] <= first_s - 2.99
    assert second_s + 0.99 <= passed(journey, 0, 2800.0)[0] <= second_s + 3.01
    assert journey.verify()[0][0].ok


@pytest.mark.parametrize(
    ("point", "message"),
    [
        (TimingPoint(HALF_M, 0.0, 50.0), "the window at 2200 m closes at 50 s, the first time possible there is"),
        (
            TimingPoint(HALF_M, lowest_mps=21.0),
            "2200 m is to be passed at 75.6 km/h at least, the fastest run has 61.2",
        ),
    ],
)
def test_what_cannot_be_kept_is_named(point, message):
    with pytest.raises(InfeasibleError, match=message):
        run(point, points=3)


@pytest.mark.parametrize(
    ("opens_s", "energy", "slopes"),
    [
        (9000.0, "wheel", LINE.gradients),
        (200.0, "wheel", ((0.0, -10.0), (2500.0, 0.0))),
        (300.0, "pantograph", ((0.0, 0.0), (1500.0, -10.0))),
    ],
)
def test_what_is_later_than_the_thriftiest_run_is_kept(opens_s, energy, slopes):
    line = replace(ONE, gradients=tuple(tgvdp.Gradient(*slope) for slope in slopes))
    journey = run(TimingPoint(HALF_M, opens_s, opens_s + 1.0), line=line, points=3, energy=energy)
    for index in range(len(journey.front)):
        assert opens_s - 0.1 <= passed(journey, index)[0] <= opens_s + 1.1
    assert all(verdict.ok for point in journey.verify() for verdict in point)


def misses(error):
    """By how much each window is missed, s, as an error tells it."""
    return [float(missed_s) for missed_s in re.findall(r"missed by ([0-9.]+) s", str(error.value))]


def test_what_is_told_of_missed_windows_meets_them_and_less_does_not():
    """Two windows close too early: each by so much, when the one before closes no later than it has to."""

    def windows(first_s, second_s):
        return TimingPoint(1800.0, 0.0, 30.0 + first_s), TimingPoint(2800.0, 0.0, 80.0 + second_s)

    with pytest.raises(InfeasibleError, match=r"at 1800 m closes .*; the window at 2800 m closes") as error:
        run(*windows(0.0, 0.0), points=3)
    first_s, second_s = misses(error)
    journey = run(*windows(first_s, second_s), points=3)
    assert passed(journey, 0, 2800.0)[0] <= 80.0 + second_s + 0.1
    with pytest.raises(InfeasibleError, match="at 1800 m closes"):
        run(*windows(first_s - 0.1, second_s), points=3)
    with pytest.raises(InfeasibleError, match="at 2800 m closes"):
        run(*windows(first_s, second_s - 0.1), points=3)


def test_two_windows_that_need_two_other_speeds_are_kept():
    """Between the points the train is slower than any run that is fast at one of them."""
    level = replace(ONE, gradients=())
    points = TimingPoint(1800.0, 42.0, 43.0), TimingPoint(2800.0, 342.0, 347.0)
    journey = run(*points, line=level, points=3, max_margin=2.0)
    assert 41.9 <= passed(journey, 0, 1800.0)[0] <= 43.1
    assert 341.9 <= passed(journey, 0, 2800.0)[0] <= 347.1


@pytest.mark.parametrize("opens_s", [95.0, 100.7, 113.3, 120.1])
def test_the_earliest_arrival_behind_a_window_that_opens_late_is_a_point(opens_s):
    """The train is there as it opens, as fast as can be, and goes on at full effort: it was missed by rounding."""
    journey = run(TimingPoint(HALF_M, opens_s, opens_s + 9.0), points=3, max_margin=0.3)
    assert not any("missing" in text for text in journey.warnings)
    assert passed(journey, 0)[0] == pytest.approx(opens_s, abs=3e-3)


def test_where_running_longer_saves_nothing_is_said():
    """Behind the point the train rolls down to its stop."""
    down = replace(ONE, gradients=(tgvdp.Gradient(0.0, 0.0), tgvdp.Gradient(HALF_M, -10.0)))
    journey = run(TimingPoint(HALF_M, 80.0, 85.0), line=down, points=4, max_margin=3.0)
    assert any("the front ends with the thriftiest journey" in text for text in journey.warnings)


def test_the_published_journey_cannot_be_kept(shared):
    folder = shared / "ttobench"
    train, track = folder / "trains" / "CH_Stadler_KISS_SBB.json", folder / "tracks" / "CH_StGallen_Wil.json"
    missed = r"values\[5\]: position 29556.1 m\) closes at 1450 s, .* is 1556\.\d+ s: it is missed by 106"
    with pytest.raises(InfeasibleError, match=missed):
        tgvdp.journey(train, track, folder / "journeys" / "CH_StGallen_Wil_Journey_01.json")


def test_a_journey_is_found_that_has_to_slow_down_in_one_section_and_may_not_in_the_next():
    """Its windows are a twentieth of a second wide around a run that is slower than it has to be next to each point.

    Speeds that are too slow for a window in the second section miss it by less than the fastest ones are too fast in
    the first one: they look nearer, and were where the search ended.
    """
    dwell_s, width_s = 20.0, 0.05
    before = [TimingPoint(at_m, open_s, open_s + width_s) for at_m, open_s in ((2157.0, 59.508), (2360.0, 74.008))]
    after = [TimingPoint(at_m, open_s, open_s + width_s) for at_m, open_s in ((4532.0, 226.146), (4630.0, 237.035))]
    stops = [TimingPoint(3400.0, open_s, open_s + width_s, 0.0, 0.0) for open_s in (134.14, 134.14 + dwell_s)]
    ends = [TimingPoint(1200.0, 0.0, 0.0, 0.0, 0.0), TimingPoint(6000.0, 314.916, 314.966, 0.0, 0.0)]
    points = (ends[0], *before, *stops, *after, ends[1])
    journey = tgvdp.journey(METRO, TWO, Journey(points=points), dwell_s=dwell_s, at_s=(314.96,))
    assert not journey.warnings
    clock_s = passed(journey, 0, 2360.0)[0]
    assert 74.008 - 2e-3 <= clock_s <= 74.058 + 2e-3
