"""Timetables as tables: where a train stops, and when."""

import datetime
import math
from dataclasses import replace

import pytest

import tgvdp
from tests.helpers.refusal import refusal
from tests.helpers.table_case import workbook
from tgvdp.formats import describe_file, load_journey, load_section, load_track
from tgvdp.formats.detect import load_all, read_source
from tgvdp.model.track import Place
from tgvdp.model.variants import reversed_track

INF = math.inf
PLAIN = "Station,km,Arrival,Departure\nAston,0,,10:00\nMid,2.25,10:02:30,10:03\nBerry,5,10:07,\n"
#: What PLAIN says: position, earliest and latest time, least and highest speed.
POINTS = [(0.0, 0.0, INF, 0.0, 0.0), (2250.0, -INF, 150.0, 0.0, 0.0), (2250.0, 180.0, INF, 0.0, 0.0),
          (5000.0, -INF, 420.0, 0.0, 0.0)]  # fmt: skip
LINE = """Position [km];Speed limit [km/h];Station;Arrival;Departure
10;80;Aston;;23:55
11,5;120;;;
12;;Mid;23:58;23:59
13;;pass;;00:01
15;;Berry;00:03;
"""


def points(path):
    return [tuple(point) for point in load_journey(path).points]


@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        "Bahnhof;km;Ankunft;Abfahrt\nA;0;-;10:00\nM;2,25;10:02:30;10:03\nB;5;10:07;-\n",
        "km,arrival_min,departure [min]\n0,,0\n2.25,2.5,3\n5,7,\n",
        "km,arrival,departure\n0,,2026-01-02T10:00:00\n2.25,2026-01-02T10:02:30,2026-01-02T10:03:00\n"
        "5,2026-01-02T10:07,\n",
        "km,arrival,departure\n0,,23:58\n2.25,24:00:30,24:01\n5,24:05,\n",
        "km,arrival,departure\n0,,23:58\n2.25,0:00:30,0:01\n5,0:05,\n",
        "km,arrival,departure\n0,,10:00\n2.25,10:02:30,\n2.25,,10:03\n4,,\n5,10:07,10:20\n",
    ],
    ids=["plain", "german", "minutes", "dates", "beyond midnight", "past midnight", "two rows a stop"],
)
def test_arrivals_are_the_latest_and_departures_the_earliest_times(saved, text):
    assert points(saved(text, "t.csv")) == POINTS


def test_a_stop_with_a_departure_alone_is_left_at_that_time_and_what_is_passed_is_passed_no_later(saved):
    path = saved("km,stop,arrival,departure\n0,A,,10:00\n2,B,,10:03\n3,pass,,10:05\n5,C,10:07,\n", "t.csv")
    assert points(path)[1:4] == [
        (2000.0, -INF, 180.0, 0.0, 0.0), (2000.0, 180.0, 180.0, 0.0, 0.0), (3000.0, -INF, 300.0, 0.0, INF),
    ]  # fmt: skip


def test_a_line_and_its_timetable_may_be_one_table(saved):
    path = saved(LINE, "line.csv")
    (held,) = load_all(path)
    assert held.track.length_m == 5000.0
    assert held.track.stops_m == (0.0, 2000.0, 5000.0)
    assert [point.position_m for point in held.journey.points] == [0.0, 2000.0, 2000.0, 3000.0, 5000.0]
    assert [point.latest_s for point in held.journey.points] == [INF, 180.0, INF, 360.0, 480.0]
    assert held.track.notes == ("positions count from the first row, which is at 10 km",)


def test_positions_without_a_line_count_from_where_one_begins(saved):
    journey = load_journey(saved("km,arrival,departure\n12.3,,10:00\n15,10:05,\n", "t.csv"))
    assert journey.notes == ("positions count from where the line begins: the journey does at 12.3 km",)
    track = load_track(saved("km,arrival,departure\n12.3,,10:00\n15,10:05,\n", "t.csv"), line_speed_mps=20.0)
    assert track.length_m == pytest.approx(2700.0)


def test_workbooks_hold_a_line_and_several_timetables(saved):
    limits = [["From [km]", "To [km]", "Speed limit [km/h]"], [12, 14, 80], [14, 20, 120]]
    clock = datetime.time
    fast = [["Station", "km", "Arrival", "Departure"], ["A", 12, None, clock(6)], ["C", 20, clock(6, 9), None]]
    slow = [
        ["km", "Arrival", "Departure"],
        [12, None, clock(7)],
        [15, clock(7, 5), clock(7, 6)],
        [20, clock(7, 12), None],
    ]
    path = saved(workbook(Limits=limits, Fast=fast, Slow=slow), "book.xlsx")
    assert points(f"{path}#Slow")[1:] == [
        (3000.0, -INF, 300.0, 0.0, 0.0), (3000.0, 360.0, INF, 0.0, 0.0), (8000.0, -INF, 720.0, 0.0, 0.0),
    ]  # fmt: skip
    assert load_section(f"{path}#Fast")[1].longest_s == 540.0
    assert [one.name for one in load_all(path)] == ["book", "Fast", "Slow"]
    assert "holds 2 journeys, choose one as FILE#NAME: Fast, Slow" in refusal(load_journey, path)


def test_sections_of_a_timetable_are_chosen_by_number(saved):
    assert load_section(f"{saved(PLAIN, 't.csv')}#2")[1].origin_m == 2250.0


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("0,,10:00\n3,9:59,10:01\n5,10:04,", "line 3, column 'arrival': times must not decrease, got 9:59 after"),
        (
            "0,,10:00\n5,10:65,",
            "column 'arrival': minutes after hours and seconds must be below 60, got '10:65'",
        ),
        (
            "0,,10:00\n5,soon,",
            "column 'arrival': must be a time of day such as 10:05, or its header needs a unit",
        ),
        ("0,,10.00\n5,10.07,", "line 2, column 'departure': must be a time of day such as 10:05"),
        ("5,,10:00\n0,10:07,", "positions must not decrease"),
        ("0,,10:00\n5,,", "a timetable needs two stops with times"),
    ],
)
def test_what_is_no_timetable_is_refused_by_its_cell(saved, rows, said):
    path = saved(f"km,arrival,departure\n{rows}\n", "t.csv")
    assert said in refusal(load_journey, path)


def test_a_line_whose_columns_look_like_times_by_name_alone_stays_a_line(saved):
    path = saved("km,speed limit [km/h],dep\n0,80,x\n5,,y\n", "t.csv")
    assert read_source(path).value.journey is None
    track = load_track(path)
    assert (track.length_m, track.notes) == (5000.0, ("columns not used: 'dep'",))


@pytest.mark.parametrize("time", ["10.05", "0.4201388889", "10h05"])
def test_times_beside_limits_that_are_none_are_refused_and_not_left_out(saved, time):
    path = saved(f"km;speed limit [km/h];arrival;departure\n0;80;;10:00\n5;;{time};\n".replace("10:00", time), "t.csv")
    assert refusal(read_source, path) == (
        "line 2, column 'departure': must be a time of day such as 10:05, or its header needs a unit such as "
        f"departure_min, got '{time}'"
    )
    assert load_track(path).length_m == 5000.0


def test_columns_of_a_line_with_its_timetable_that_are_not_used_are_said_once(saved):
    text = "Stop;Station;km;speed_kmh;arrival;departure\nx;A;0;80;;10:00\nx;B;5;;10:08;\n"
    assert describe_file(saved(text, "t.csv")).notes == ("columns not used: 'Station'",)


def test_a_journey_keeps_a_timetable_and_none_belongs_to_another_track(saved):
    path = saved(LINE, "line.csv")
    result = tgvdp.journey("alstom-emu", path, path, points=3)
    assert (result.found.departure_s[:, 1] >= 240.0 - 1e-9).all()
    assert not [text for text in result.warnings if "belongs" in text]


NAMES = "Station,Arrival,Departure\nASTON,,10:00\nDepot,,\nMid,10:03,10:04\nBerry,10:08,\n"


def test_names_tell_where_a_timetable_stops_on_its_line(saved):
    track = load_track(saved(LINE, "line.csv"))
    assert [tuple(place) for place in track.places] == [(0.0, "Aston"), (2000.0, "Mid"), (5000.0, "Berry")]
    journey = load_journey(saved(NAMES, "names.csv"), track)
    assert [point.position_m for point in journey.points] == [0.0, 2000.0, 2000.0, 5000.0]
    backwards = NAMES.replace("ASTON", "berry").replace("Berry", "aston")
    journey = load_journey(saved(backwards, "back.csv"), reversed_track(track))
    assert [point.position_m for point in journey.points] == [0.0, 3000.0, 3000.0, 5000.0]


def test_names_that_the_line_does_not_have_once_are_refused(saved):
    track = load_track(saved(LINE, "line.csv"))
    path = saved(NAMES.replace("Mid", "Middle"), "names.csv")
    said = "line 4, column 'Station': the line has no place of that name, got 'Middle' (it has 'Aston', 'Mid', 'Berry')"
    assert refusal(load_journey, path, track=track) == said
    twice = replace(track, places=(*track.places[:2], Place(3000.0, "mid"), track.places[2]))
    path = saved(NAMES, "names.csv")
    assert "the line has 2 places of that name, got 'Mid'" in refusal(load_journey, path, track=twice)
    assert "is the line to be reversed?" in refusal(load_journey, path, track=reversed_track(track))
    assert refusal(load_journey, path) == (
        "its timetable names places alone, and no line is given that has names"
        " (or it lacks a column for the position, such as position_m or Position [km])"
    )


def test_names_alone_are_described_as_a_timetable_that_needs_a_line(saved):
    told = describe_file(saved(NAMES, "names.csv"))
    assert (told.kind, told.format) == ("timetable", "CSV table")
    assert [(one.name, one.value) for one in told.figures] == [
        ("timetable names", "ASTON to Berry, 3 places, 10:00 to 10:08")
    ]
    assert told.notes == ("it gives no positions: tgvdp journey takes it with a line that has places of these names",)
    path = saved(NAMES, "names.csv")
    assert describe_file(f"{path}#names") == told
    assert refusal(describe_file, f"{path}#other") == "holds no journey 'other'; it holds: names"
    assert refusal(describe_file, saved("Station,Departure\nA,10:00\n", "t.csv")).endswith("two stops with times")
    wrong = saved(NAMES.replace("10:03,10:04", "10:03,10:02"), "wrong.csv")
    assert "times must not decrease, got 10:02" in refusal(describe_file, wrong)
    assert "no column for the position" in refusal(describe_file, saved("Station,Arrival,Departure\nA,-,-\n", "t.csv"))


def test_a_row_beyond_the_end_of_the_line_is_named_in_its_unit(saved):
    line = load_track(saved("km,speed_kmh\n0,90\n5,90\n"))
    timetable = saved("km,arrival,departure\n0,,10:00\n2.5,10:03,10:04\n6.25,10:09,\n", "times.csv")
    message = "line 4, column 'km': 6.25 km: lies beyond the end of track line, which is 5000 m long"
    assert refusal(lambda path: tgvdp.journey("tgv", line, path), timetable) == message
    assert load_section(timetable)[1].destination_m == 2500.0
    stationed = saved("km,arrival,departure\n0+000,,10:00\n7+500,10:09,\n", "times.csv")
    told = refusal(lambda path: tgvdp.journey("tgv", line, path), stationed)
    assert told.startswith("line 3, column 'km': 7+500: lies beyond")
