"""Schedules of OSRD's trains as journeys over the path beside them."""

import math

import pytest

import tgvdp
from tests.helpers.format_case import changed, write_json
from tests.helpers.osrd_case import OSRD_SCHEDULE, OSRD_TRAIN
from tests.helpers.refusal import refusal
from tgvdp.formats import describe_file, load_journey

INF = math.inf
SCHEDULE = OSRD_SCHEDULE["train_schedule"]


def file_of(tmp_path, schedule=SCHEDULE):
    return write_json(tmp_path / "t1.json", OSRD_SCHEDULE | {"train_schedule": schedule})


def points(path):
    return [tuple(point) for point in load_journey(path).points]


EXPECTED = [
    (0.0, 0.0, INF, 0.0, 0.0), (2000.0, -INF, 100.0, 0.0, INF), (5000.0, -INF, 300.0, 0.0, 0.0),
    (5000.0, 330.0, INF, 0.0, 0.0), (10_000.0, -INF, 600.0, 0.0, 0.0),
]  # fmt: skip


def test_arrivals_are_the_latest_and_departures_the_earliest_times(tmp_path):
    path = file_of(tmp_path)
    assert points(path) == EXPECTED
    assert load_journey(path).notes == ()
    assert "A to C" in str(describe_file(path))


def test_times_count_from_the_departure_which_may_be_after_a_stop(tmp_path):
    items = [item | {"stop_for": "PT20S"} if item["at"] == "a" else item for item in SCHEDULE["schedule"]]
    later = [
        (at_m, early_s - 20.0 * (at_m > 0.0), late_s - 20.0, *speeds) for at_m, early_s, late_s, *speeds in EXPECTED
    ]
    assert points(file_of(tmp_path, changed(SCHEDULE, ("schedule",), items))) == later


def test_a_stop_without_arrival_may_have_any_and_the_end_is_a_stop(tmp_path):
    items = [{"at": "c", "stop_for": "PT30S"}]
    path = file_of(
        tmp_path, changed(SCHEDULE, ("schedule",), items) | {"initial_speed": 3.0, "margins": {"values": ["0%", "5%"]}}
    )
    any_time = (5000.0, -INF, INF, 0.0, 0.0)
    assert points(path) == [EXPECTED[0], any_time, any_time, (10_000.0, -INF, INF, 0.0, 0.0)]
    assert load_journey(path).notes == (
        "stops without arrival (1): how long the train stands there is what --dwell says",
        "initial_speed 3 m/s is not used: the train starts from a stand",
        "margins are not used: --at and --margins take some",
    )


@pytest.mark.parametrize(
    ("at", "value", "message"),
    [
        (("schedule", 1, "at"), "bb", "train_schedule.schedule[1].at: no item of the path, got 'bb', did you mean"),
        (("schedule", 1, "arrival"), "100 s", "train_schedule.schedule[1].arrival: invalid ISO8601 duration, got '1"),
        (("schedule", 1), {"at": "b", "arival": "PT9M"}, "train_schedule.schedule[1]: unknown field 'arival', did you"),
        (("schedule", 1, "arrival"), "PT9M",
         "train_schedule.schedule: times must not decrease, got arrival 300 s at 5000 m after 540 s"),
        (("schedule", 2, "stop_for"), "-PT5S", "train_schedule.schedule[2].stop_for: must be at least 0 s, got -5 s"),
        (("schedule", 0, "arrival"), "PT5S",
         "train_schedule.schedule[0].arrival: must be 0 s where the train starts, got 5 s"),
        (("schedule", 2, "at"), "b", "train_schedule.schedule[2].at: 'b' is there already: leave one"),
        (("path", 2, "id"), "b", "train_schedule.schedule[1].at: 2 items of the path, got 'b'"),
        (("path",), [{}] * 4, "pathfinding.path_item_positions: must be one for each item, got 5 positions for 4"),
    ],
    ids=lambda value: str(value)[:30],
)  # fmt: skip
def test_what_is_wrong_is_named(tmp_path, at, value, message):
    assert refusal(load_journey, file_of(tmp_path, changed(SCHEDULE, at, value))).startswith(message)


def test_positions_are_in_the_order_of_the_run(tmp_path):
    back = OSRD_SCHEDULE | {"pathfinding": {"path_item_positions": [0, 9_000_000, 5_000_000, 7_000_000, 10_000_000]}}
    message = "pathfinding.path_item_positions[2]: must not decrease, got 5000000 mm after 9000000 mm"
    assert refusal(load_journey, write_json(tmp_path / "t1.json", back)) == message
    same = OSRD_SCHEDULE | {"pathfinding": {"path_item_positions": [0, 5_000_000, 5_000_000, 7_000_000, 10_000_000]}}
    message = "train_schedule.schedule: two items at 5000 m: leave one"
    assert refusal(load_journey, write_json(tmp_path / "t1.json", same)) == message


def test_a_train_keeps_its_schedule_on_the_path_of_one_file(tmp_path):
    path = file_of(tmp_path)
    train = write_json(tmp_path / "toy.json", OSRD_TRAIN)
    found = tgvdp.journey(train, path, path, points=3, convention="osrd")
    passed_s = [
        float(profile.time_s[profile.position_m.searchsorted(2000.0)])
        for profile in (found.profile(index) for index in range(len(found.front)))
    ]
    assert max(passed_s) <= 101.0
    assert (found.found.departure_s[:, 1] >= 330.0 - 1e-3).all()


def test_a_place_beyond_the_end_of_another_line_is_named_by_its_field(tmp_path):
    message = "pathfinding.path_item_positions[2]: 5000000 mm: lies beyond the end of track short, which is 4000 m long"
    short = tgvdp.Track(name="short", length_m=4000.0, speed_limits=((0.0, 30.0),))
    assert refusal(lambda path: tgvdp.journey("tgv", short, path), file_of(tmp_path)) == message
