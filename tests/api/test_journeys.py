"""``tgvdp.journey``: stops of lines and timetables, published figures, whole profiles, and what is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.clocks import LooksAtTheClock
from tests.helpers.documented_case import OSRD_TRACK, OSRD_TRAIN
from tests.helpers.journey_case import LINE, METRO
from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.model.journey import Journey, TimingPoint

STOPPING = replace(OSRD_TRACK, stops_m=(0.0, 6000.0, 10_000.0))


def test_the_documented_example():
    """10 km in two sections, 10 % slower: 149.91 and 102.61 kWh when each gets its share, 252.37 kWh jointly."""
    journey = tgvdp.journey(OSRD_TRAIN, STOPPING, convention="osrd", at_margin=(0.1,))
    own = journey.found.practices["proportional_to_time"]
    separate_j = [one.front.energy_j[run] for one, run in zip(journey.sections, own.run[0], strict=True)]
    assert np.array(separate_j) / 3.6e6 == pytest.approx([149.91, 102.61], rel=1e-3)
    assert journey.section_time_s[0] == pytest.approx([255.49, 202.92], rel=1e-3)
    assert journey.front.energy_j[0] / 3.6e6 == pytest.approx(252.37, rel=1e-3)
    assert journey.front.time_s[0] == pytest.approx(1.1 * journey.fastest_time_s, abs=0.1)


def test_what_is_no_timetable_is_refused():
    """A list of positions ended in an AttributeError."""
    with pytest.raises(InputError, match=r"journey: journey must be a Journey or a path, got \[0, 5000\]"):
        tgvdp.journey(OSRD_TRAIN, STOPPING, [0, 5000])


def test_one_section_is_told_as_one():
    journey = tgvdp.journey(OSRD_TRAIN, OSRD_TRACK, points=2)
    assert ", 1 section, 2 points from " in repr(journey)


def test_the_published_metro_line(shared):
    train = shared / "ttobench" / "trains" / "CN_Beijing_Subway.json"
    track = shared / "ttobench" / "tracks" / "CN_Songjiazhuang_Yizhuang.json"
    journey = tgvdp.journey(train, track, points=10)
    assert (len(journey.sections), len(journey.front)) == (13, 10)
    assert all(verdict.ok for point in journey.verify() for verdict in point)
    wanted_s = journey.fastest_time_s * np.linspace(1.0, 1.25, 10)
    assert journey.front.time_s == pytest.approx(wanted_s, abs=0.1)
    assert journey.section_time_s.sum(axis=1) == pytest.approx(journey.front.time_s)
    assert journey.section_energy_j.sum(axis=1) == pytest.approx(journey.front.energy_j)
    for practice in journey.found.practices.values():
        assert (practice.energy_j >= journey.front.energy_j).all()


@pytest.fixture(scope="module")
def metro():
    return tgvdp.journey(METRO, LINE, points=5, dwell_s=20.0, energy="pantograph")


def test_a_profile_of_the_whole_journey(metro):
    profile = metro.profile(3)
    assert profile.duration_s == pytest.approx(metro.front.time_s[3] + 3 * 20.0)
    assert profile.total_energy_j == pytest.approx(metro.front.energy_j[3])
    assert profile.balance.pantograph_j == pytest.approx(metro.front.energy_j[3])
    assert (np.diff(profile.position_m) >= 0.0).all()
    assert (np.diff(profile.time_s) > 0.0).all()
    stands = profile.position_m[1:][np.diff(profile.position_m) == 0.0]
    assert stands.tolist() == [1200.0, 3400.0, 4300.0]
    assert np.diff(profile.time_s)[np.diff(profile.position_m) == 0.0] == pytest.approx(20.0)


def test_every_section_of_every_point_replays(metro):
    verdicts = metro.verify()
    assert (len(verdicts), len(verdicts[0])) == (5, 4)
    assert all(verdict.ok for point in verdicts for verdict in point)
    assert "4 sections, 5 points" in repr(metro)


def test_prices_fall_and_are_those_of_the_front(metro):
    price = metro.price_kwh_per_min
    slope = -60.0 / 3.6e6 * np.diff(metro.front.energy_j) / np.diff(metro.front.time_s)
    assert np.isinf(price[0])
    assert (np.diff(price[1:]) < 0.0).all()
    assert (slope[1:] < price[1:-1]).all()
    assert (slope[1:] > price[2:]).all()


def test_stops_of_a_timetable_count_in_place_of_the_lines():
    def stop(position_m, earliest_s=-np.inf, latest_s=np.inf):
        return TimingPoint(position_m, earliest_s, latest_s, 0.0, 0.0)

    free = Journey(points=(stop(500.0), stop(3400.0), stop(3400.0), stop(6000.0)), track=LINE.name)
    journey = tgvdp.journey(METRO, LINE, free, points=2)
    assert [one.trip.origin_m for one in journey.sections] == [500.0, 3400.0]
    assert (journey.trip.origin_m, journey.trip.destination_m) == (500.0, 6000.0)
    assert not journey.warnings
    elsewhere = tgvdp.journey(METRO, LINE, replace(free, track="another"), points=2)
    assert elsewhere.warnings == ("journey journey belongs to track another, not to metro line",)
    far = replace(free, points=(stop(0.0), stop(9000.0)))
    beyond = r"journey: points\[1\] at 9000 m: lies beyond the end of track metro line, which is 6000 m"
    with pytest.raises(InputError, match=beyond):
        tgvdp.journey(METRO, LINE, far)


def test_the_other_direction_has_the_same_stops():
    there = tgvdp.journey(METRO, LINE, points=2)
    back = tgvdp.journey(METRO, LINE, points=2, reverse=True)
    lengths = [[one.trip.distance_m for one in journey.sections] for journey in (there, back)]
    assert lengths[0] == lengths[1][::-1]


def test_a_front_that_ends_says_so():
    journey = tgvdp.journey(METRO, LINE, points=4, max_margin=6.0, energy="pantograph")
    assert journey.found.exhausted
    assert "the front ends with the thriftiest journey" in journey.warnings[0]


def test_times_are_met_also_by_a_map():
    """Runs by a map are found by another method than all others."""
    journey = tgvdp.journey(METRO, LINE, points=12, energy="map", time_limit_s=600.0)
    asked_s = journey.fastest_time_s * np.linspace(1.0, 1.25, 12)
    assert (journey.front.time_s <= asked_s * (1.0 + 1e-9)).all()
    assert (journey.front.time_s >= asked_s - 0.1).all()
    assert not journey.warnings


def test_memory_is_asked_for():
    with pytest.raises(BudgetExceededError, match="--max-memory"):
        tgvdp.journey(METRO, LINE, points=4, max_memory_b=1e6)


def test_what_is_refused():
    with pytest.raises(InfeasibleError, match="no run takes 100 s"):
        tgvdp.journey(METRO, LINE, at_s=(100.0,))
    with pytest.raises(InputError, match="dwell_s must be at least 0 s"):
        tgvdp.journey(METRO, LINE, dwell_s=-1.0)
    with pytest.raises(InputError, match="has no two stops"):
        tgvdp.journey(METRO, replace(LINE, stops_m=(0.0,)))


def test_without_time_for_the_fastest_runs_there_is_no_journey():
    with pytest.raises(BudgetExceededError, match="before every section had its fastest run"):
        tgvdp.journey(METRO, LINE, points=4, time_limit_s=1e-9)


def test_a_time_limit_leaves_the_fastest_runs_at_least(monkeypatch):
    monkeypatch.setattr("tgvdp.api.journeys.budget_of", lambda _: LooksAtTheClock(0))
    journey = tgvdp.journey(METRO, LINE, points=4)
    assert not journey.found.complete
    assert journey.front.time_s[0] == pytest.approx(journey.fastest_time_s)
    assert "the time limit ended the search" in journey.warnings[0]


def test_the_linear_margin_is_as_defined():
    """Every stretch takes the same ratio of its fastest time."""
    journey = tgvdp.journey(METRO, LINE, points=4, dwell_s=0.0)
    for index in range(1, 4):
        ratio = journey.front.time_s[index] / journey.fastest_time_s
        scaled, fastest = journey.linear_margin(index), journey.linear_margin(0)
        assert scaled.time_s == pytest.approx(ratio * fastest.time_s, rel=1e-9)
        assert scaled.speed_mps == pytest.approx(fastest.speed_mps / ratio, rel=1e-9)
        assert scaled.duration_s == pytest.approx(journey.front.time_s[index], rel=1e-9)
    assert journey.linear_margin_j[0] == pytest.approx(journey.fastest_energy_j, rel=1e-15)
    assert (journey.linear_margin_j[1:] > journey.found.practices["proportional_to_time"].energy_j[1:]).all()
    assert (np.diff(journey.linear_margin_j) < 0.0).all()


def test_errors_of_what_a_journey_shares_with_a_search_begin_with_its_name():
    with pytest.raises(InputError, match=r"^journey: points must be"):
        tgvdp.journey(METRO, LINE, points=0)
    with pytest.raises(InputError, match=r"^journey: train is a Track: the order is journey\(train, track\)"):
        tgvdp.journey(LINE, METRO)
    with pytest.raises(InfeasibleError, match=r"^journey: no run takes 1 s"):
        tgvdp.journey(METRO, LINE, at_s=(1.0,))


def test_a_timetable_that_ends_beyond_its_line_names_the_row_of_its_file(tmp_path):
    units = {"position": "km", "lower time constraint": "s", "upper time constraint": "s"}
    units |= {"lower speed constraint": "km/h", "upper speed constraint": "km/h"}
    content = {
        "metadata": {"id": f"{LINE.name}_far", "library version": "TTOBench v1.5", "associated track": LINE.name},
        "timing points": {"units": units, "values": [[0, 0, 0, 0, 0], [9, None, 3600, 0, 0]]},
    }
    path = tmp_path / "far.json"
    path.write_text(json.dumps(content))
    with pytest.raises(InputError, match=r"far\.json: timing points\.values\[1\]: position 9 km: lies beyond the end"):
        tgvdp.journey(METRO, LINE, path)
