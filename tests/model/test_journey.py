"""Journeys: the model's rules, their TTOBench file, and the sections from stop to stop."""

import json
import math

import pytest

from tests.helpers.format_case import JOURNEY, changed, write_json
from tgvdp.errors import InputError
from tgvdp.formats import describe_file, load_journey, load_scenario, load_section, load_train
from tgvdp.model.journey import Journey, TimingPoint

UNITS = ("timing points", "units")
VALUES = ("timing points", "values")


def stop(position_m, earliest_s=-math.inf, latest_s=math.inf):
    return TimingPoint(position_m, earliest_s, latest_s, 0.0, 0.0)


def test_journey_in_si(tmp_path):
    journey = load_journey(write_json(tmp_path / "journey.json", JOURNEY))
    assert (journey.name, journey.track) == ("toy_01", "toy")
    assert journey.points == (
        TimingPoint(0.0, 0.0, 30.0, 0.0, 0.0),
        TimingPoint(1000.0, -math.inf, math.inf, 0.0, math.inf),
        TimingPoint(2000.0, 120.0, 150.0, 10.0, 20.0),
        TimingPoint(4000.0, 300.0, 330.0, 0.0, 0.0),
        TimingPoint(4000.0, 360.0, math.inf, 0.0, 0.0),
        TimingPoint(10000.0, -math.inf, 900.0, 0.0, 0.0),
    )


def test_sections_run_from_stop_to_stop(tmp_path):
    first, second = load_journey(write_json(tmp_path / "journey.json", JOURNEY)).sections
    assert (first.number, first.origin_m, first.destination_m) == (1, 0.0, 4000.0)
    assert (first.shortest_s, first.longest_s) == (270.0, 330.0)
    assert [point.position_m for point in first.passing] == [2000.0]  # what is free asks nothing
    assert (second.number, second.origin_m, second.destination_m) == (2, 4000.0, 10000.0)
    assert (second.shortest_s, second.longest_s, second.passing) == (0.0, 540.0, ())


def test_an_open_window_leaves_the_running_time_open():
    (section,) = Journey(points=(stop(0.0), stop(5.0))).sections
    assert (section.shortest_s, section.longest_s) == (0.0, math.inf)


def test_a_section_is_chosen_by_its_number(tmp_path):
    path = write_json(tmp_path / "journey.json", JOURNEY)
    assert load_section(path)[1].number == 1
    journey, section = load_section(f"{path}#2")
    assert (journey.name, section.number) == ("toy_01", 2)
    for part in ("3", "0", "two", ""):
        with pytest.raises(InputError, match=f"has sections 1 to 2, got '{part}'"):
            load_section(f"{path}#{part}")


def test_journeys_are_described_and_are_no_trains(tmp_path):
    path = write_json(tmp_path / "journey.json", JOURNEY)
    text = str(describe_file(path))
    assert text.startswith("journey toy_01 (TTOBench)")
    assert "section 1  0 to 4 km in 270 to 330 s, 1 passing window" in text
    assert "section 2  4 to 10 km in 0 to 540 s" in text
    assert load_scenario(path).journey.name == "toy_01"
    with pytest.raises(InputError, match="holds a TTOBench journey, not a train"):
        load_train(path)


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("metadata", "associated track"), ..., "metadata: missing field 'associated track'"),
        (("metadata", "associated track"), "other", "metadata.id: must start with 'other_', got 'toy_01'"),
        ((*UNITS, "position"), "mile", "timing points.units.position: unknown unit 'mile' of length"),
        ((*UNITS, "lower time constraint"), "km/h", "timing points.units.lower time constraint: unknown unit 'km/h'"),
        ((*UNITS, "colour"), "red", "timing points.units: unknown field 'colour'"),
        ((*VALUES, 1), [1, None, None, None], "timing points.values[1]: must be a list of length 5, got 4 values"),
        ((*VALUES, 1, 1), "soon", "timing points.values[1][1]: must be a number or null, got 'soon'"),
        ((*VALUES, 1, 0), None, "timing points.values[1][0]: must be a number, got null"),
        ((*VALUES, 2, 3), 0, "timing points.values[2]: both speeds must be 0 at a stop, and above 0 or null elsewhere"),
        ((*VALUES, 2, 3), 90, "timing points.values[2]: the window from 90 km/h to 20 m/s is empty"),
        ((*VALUES, 2, 1), 3, "timing points.values[2]: the window from 3 min to 150 s is empty"),
        ((*VALUES, 2, 0), 0.5, "timing points.values[2]: position must not decrease, got 0.5 km after 1 km"),
        ((*VALUES, 2, 0), 1, "timing points.values[1]: position 1 km: must be two stops"),
        ((*VALUES, 3), ..., "timing points.values[3]: position 4 km: must be two stops (arrival, departure) or"),
        ((*VALUES, 4, 0), 0, "timing points.values[4]: position must not decrease, got 0 km after 4 km"),
        ((*VALUES, 5), ..., "timing points.values[3]: position 4 km: must be one stop, got 2 stops and"),
        ((*VALUES, 0), ..., "timing points.values[0]: position 1 km: the first of the points must be a stop"),
        ((*VALUES,), [[0, 0, 0, 0, 0]], "journey toy_01: points must be at least 2, got 1"),
        ((*VALUES, 0, 0), -1, "timing points.values[0]: position must be at least 0 km, got -1 km"),
        ((*VALUES, 3, 2), 110, "timing points.values[3]: the window from 5 min to 110 s is empty"),
        (
            (*VALUES, 5, 2),
            200,
            "timing points.values[5]: upper time constraint must not lie before the lower one of an earlier row, "
            "6 min, got 200 s",
        ),
    ],
    ids=lambda value: str(value)[:50],
)
def test_bad_journeys(tmp_path, path, value, message):
    file = write_json(tmp_path / "journey.json", changed(JOURNEY, path, value))
    with pytest.raises(InputError) as caught:
        describe_file(file)
    assert str(caught.value).startswith(f"{file}: {message}")
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ((stop(0.0), stop(0.0)), "must be one stop, got 2 stops"),
        ((stop(0.0), stop(5.0), stop(9.0)), r"points\[1\] at 5 m: must be two stops"),
        ((stop(0.0), stop(5.0), stop(5.0), stop(5.0), stop(9.0)), r"points\[1\] at 5 m: must be two stops"),
        ((stop(0.0, math.nan), stop(5.0)), "earliest must be finite"),
        ((stop(0.0, math.inf), stop(5.0)), "is empty"),
        ((stop(0.0, 9.0, 8.0), stop(5.0)), r"points\[0\]: the window from 9 s to 8 s is empty"),
        ((stop(0.0), TimingPoint(2.0, lowest_mps=9.0, highest_mps=8.0), stop(5.0)), "the window from 9 m/s to 8 m/s"),
        ((stop(0.0), TimingPoint(6.0), stop(5.0)), r"points\[2\] at 5 m: positions must not decrease, got 5 m after"),
        ((stop(-1.0), stop(5.0)), r"points\[0\]: position must be at least 0 m"),
        (
            (stop(0.0, 9.0), stop(5.0, latest_s=8.0)),
            r"points\[1\] at 5 m: latest must not lie before an earlier",
        ),
        ("ab", "points must be a list of"),
    ],
)
def test_rules_of_the_model(points, message):
    with pytest.raises(InputError, match=message):
        Journey(points=points)


def test_the_published_journey(shared):
    path = shared / "ttobench" / "journeys" / "CH_StGallen_Wil_Journey_01.json"
    journey = load_journey(path)
    published = json.loads(path.read_text(encoding="utf-8"))["timing points"]["values"]
    assert [point.position_m for point in journey.points] == [row[0] for row in published]
    assert [(s.origin_m, s.destination_m, s.shortest_s, s.longest_s) for s in journey.sections] == [
        (0.0, 15_000.0, 620.0, 680.0),
        (15_000.0, 29_556.1, 560.0, 650.0),
    ]
    assert [point.position_m for section in journey.sections for point in section.passing] == [12_500.0, 20_000.0]
