"""Advice that is put into a SFERA journey: by segments, in both directions, with times, and valid by the schema."""

import csv
import json

import pytest

from tests.helpers.sfera_case import JOURNEY, PARTS, message, valid_by
from tgvdp.cli import main
from tgvdp.formats import load_journey, load_track
from tgvdp.formats.sfera.write import AdvisableJourney
from tgvdp.formats.sources import Target

etree = pytest.importorskip("lxml.etree")

#: From stop to stop of the journey; the segments are run 0 to 4000 m, and 6000 to 0 m.
STOPS = (200.0, 6500.0, 9700.0)
STEPS = [
    {"action": "power", "from_m": 200.0, "to_m": 900.0, "to_kmh": 79.96},
    {"action": "hold", "from_m": 900.0, "to_m": 4000.0, "from_s": 60.0, "to_s": 200.0, "to_kmh": 81.0},
    {"action": "coast", "from_m": 4000.0, "to_m": 6125.4321, "to_kmh": 61.25},
    {"action": "brake", "from_m": 6125.4321, "to_m": 6500.0, "to_kmh": 0.0},
    {"action": "power", "from_m": 6500.0, "to_m": 9700.0, "to_kmh": 0.04},
]


def advised(path, stops_m=STOPS, steps=STEPS, passing=lambda at_m: (at_m / 20.0, at_m / 20.0 + 30.0)):
    return AdvisableJourney(Target(path)).advised(stops_m, steps, passing)


@pytest.fixture
def written(tmp_path):
    """What is written for the steps above, and the file that it was made of."""
    path = tmp_path / "whole.xml"
    path.write_text(message())
    return advised(path), path


def constraints_of(data):
    """Of each segment: the ends of its advice, what is done, and the speed."""
    return [
        [
            tuple(one.get(name) for name in ("startEndQualifier", "startLocation", "endLocation"))
            + tuple(advice.get(name) for name in ("adviceType", "optimalSpeed"))
            for one in segment.iter("TemporaryConstraints")
            for advice in one.iter("AdvisedSpeed")
        ]
        for segment in etree.fromstring(data).iter("SegmentProfileReference")
    ]


def test_steps_by_segments_and_their_locations(written):
    assert constraints_of(written[0]) == [
        [
            ("StartsEnds", "200", "900", "AccelerationAdvice", "80"),
            ("StartsEnds", "900", "4000", "ConstantspeedAdvice", "79.7"),
        ],
        [
            ("StartsEnds", "6000", "3874.568", "CoastingAdvice", "61.2"),
            ("StartsEnds", "3874.568", "3500", "OperationalBrakingAdvice", "0"),
            ("StartsEnds", "3500", "300", "AccelerationAdvice", "0"),
        ],
    ]


def test_steps_over_the_ends_of_segments(written):
    steps = [{"action": "coast", "from_m": 200.0, "to_m": 9700.0, "to_kmh": 70.0}]
    ends = [[one[:3] for one in segment] for segment in constraints_of(advised(written[1], steps=steps))]
    assert ends == [[("Starts", "200", None)], [("Ends", None, "300")]]


def test_partial_effort_is_no_constant_speed(written):
    """By which the speed rises it is acceleration to its end; by which it falls there is no word for it."""
    steps = [
        {"action": "partial", "from_m": 200.0, "to_m": 900.0, "from_kmh": 60.0, "to_kmh": 70.0},
        {"action": "partial", "from_m": 900.0, "to_m": 3000.0, "from_kmh": 70.0, "to_kmh": 60.0},
        {"action": "coast", "from_m": 3000.0, "to_m": 4000.0, "to_kmh": 50.0},
    ]
    first, _ = constraints_of(advised(written[1], steps=steps))
    assert [one[1:] for one in first] == [
        ("200", "900", "AccelerationAdvice", "70"), ("3000", "4000", "CoastingAdvice", "50")
    ]  # fmt: skip


def test_a_step_that_takes_a_whole_segment(tmp_path):
    """A journey over s1 twice: the second time as a whole."""
    start, end = JOURNEY.index("  <SegmentProfileReference"), JOURNEY.index('  <SegmentProfileReference SP_ID="s2"')
    middle = JOURNEY[start:end].replace("Stopping_Point", "Passing_Point")
    (tmp_path / "whole.xml").write_text(message(JOURNEY[:end] + middle + JOURNEY[end:], *PARTS[1:]))
    steps = [{"action": "coast", "from_m": 200.0, "to_m": 13_700.0, "to_kmh": 70.0}]
    made = advised(tmp_path / "whole.xml", (200.0, 10_500.0, 13_700.0), steps)
    assert [[one[0] for one in segment] for segment in constraints_of(made)] == [["Starts"], ["WholeSP"], ["Ends"]]


def test_times_are_those_of_the_run_in_whole_seconds(written):
    data, _ = written
    points = list(etree.fromstring(data).iter("TimingPointConstraints"))
    arrivals = [point.get("TP_latestArrivalTime") for point in points]
    # 23:58:00 and 2500 m / 20 m/s = 125 s, 325 s, 485 s.
    assert arrivals == [None, *(f"2026-05-05T00:{clock}Z" for clock in ("00:05", "03:25", "06:05"))]
    departures = [one.get("departureTime") for one in etree.fromstring(data).iter("StoppingPointDepartureDetails")]
    assert departures == ["2026-05-04T23:58:40Z", "2026-05-05T00:03:55Z"]


def test_all_else_stands_as_it_was(tmp_path, written):
    data, path = written
    for number, part in enumerate(PARTS[1:]):
        (tmp_path / f"part-{number}.xml").write_text(part.strip())
    before = load_track(path)
    path.unlink()
    again = tmp_path / "again.xml"
    again.write_bytes(data)
    assert load_track(again) == before
    assert [point.position_m for point in load_journey(again).points] == [200.0, 2500.0, 6500.0, 6500.0, 9700.0]
    assert constraints_of(advised(again)) == constraints_of(data)  # in place of the advice that was there
    assert etree.fromstring(data).get("JP_Version") == "8"


def test_a_run_with_other_stops_is_no_advice_for_the_journey(written):
    assert advised(written[1], (200.0, 9700.0)) is None


def test_without_a_clock_times_stay_as_they_are(tmp_path):
    departure = '<StoppingPointDepartureDetails departureTime="2026-05-04T23:58:00Z"/>'
    (tmp_path / "whole.xml").write_text(message().replace(departure, ""))
    assert b"2026-05-05T00:02:30Z" in advised(tmp_path / "whole.xml")


def test_what_is_written_is_valid(written, sfera):
    ok, log = valid_by(sfera / "SFERA_4.00.xsd", written[0])
    assert ok, log


def speed_of(step):
    """What advice of a step says, km/h: its end, or the mean that is held."""
    far_m, lasts_s = (float(step[f"to_{unit}"]) - float(step[f"from_{unit}"]) for unit in "ms")
    return 3.6 * far_m / lasts_s if step["action"] == "hold" else float(step["to_kmh"])


def test_a_journey_writes_its_advice(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "whole.xml").write_text(message())
    asked = ["journey", "--track", "whole.xml", "--train", "whole.xml", "--points", "3", "--no-pictures", "--quiet"]
    assert main([*asked, "--journey", "whole.xml", "--out", "timed"]) == 0
    with (tmp_path / "timed" / "advice.csv").open() as table:
        steps = list(csv.DictReader(table))
    data = (tmp_path / "timed" / "sfera.xml").read_bytes()
    told = [speed for segment in constraints_of(data) for *_, speed in segment]
    assert set(told) == {f"{speed_of(step):.1f}".removesuffix(".0") for step in steps}
    assert "hold" in {step["action"] for step in steps}
    ledger = json.loads((tmp_path / "timed" / "provenance.json").read_text())
    assert "sfera.xml" in ledger["files"]


def test_a_journey_that_is_run_otherwise_says_that_it_has_no_advice(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "whole.xml").write_text(message())
    asked = ["journey", "--track", "whole.xml", "--train", "whole.xml", "--points", "3", "--no-pictures"]
    assert main([*asked, "--reverse", "--out", "back"]) == 0
    assert not (tmp_path / "back" / "sfera.xml").exists()
    assert "no sfera.xml: the journey that the line was read from has other stops, or" in capsys.readouterr().err


def test_advice_for_real_journeys_is_valid(tmp_path, monkeypatch, sfera):
    monkeypatch.chdir(tmp_path)
    real = sfera / "samples" / "T24_SFERA_JP_T24.xml"
    asked = ["--train", "alstom-emu", "--points", "3", "--no-pictures", "--quiet", "--out", "out"]
    assert main(["journey", "--track", str(real), "--journey", str(real), *asked]) == 0
    ok, log = valid_by(sfera / "SFERA_4.00.xsd", (tmp_path / "out" / "sfera.xml").read_bytes())
    assert ok, log
    assert all(constraints_of((tmp_path / "out" / "sfera.xml").read_bytes()))
