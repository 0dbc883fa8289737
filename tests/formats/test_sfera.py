"""SFERA messages as lines, timetables and trains: units, directions, what lies beside, what is refused."""

import os
import re

import pytest

from tests.helpers.refusal import refusal
from tests.helpers.sfera_case import JOURNEY, PARTS, SEGMENT_1, SEGMENT_2, TRAIN, edited, limits_of, message, valid_by
from tgvdp.errors import InputError
from tgvdp.formats import describe_file, load_bytes, load_journey, load_scenario, load_track, load_train, read_source
from tgvdp.formats.review.plausibility import review_file
from tgvdp.model.journey import TimingPoint
from tgvdp.model.track import Curve, Gradient, NeutralSection, Place, Tunnel
from tgvdp.model.train import BrakingRate

pytest.importorskip("lxml")

INF = float("inf")


def test_messages_of_these_tests_are_valid(sfera):
    for text in (*map(str.strip, PARTS), message()):
        ok, log = valid_by(sfera / "SFERA_4.00.xsd", text)
        assert ok, log


def test_line_in_si(saved_xml):
    track = load_track(saved_xml(message()))
    assert (track.name, track.length_m) == ("4711", 10_000.0)
    # 50 km/h from 3500 m of s1 to 500 m behind the beginning of s2, which is run from its end.
    assert limits_of(track) == [(0, 90), (1500, 120), (3500, 50), (4500, 100), (9000, 80)]
    assert track.gradients == (
        Gradient(0.0, 0.0), Gradient(1000.0, 12.5), Gradient(4000.0, 2.0), Gradient(8000.0, -4.0)
    )  # fmt: skip
    assert track.curves == (
        Curve(0.0, INF, INF), Curve(2000.0, 600.0, 600.0), Curve(2400.0, INF, INF), Curve(4000.0, INF, INF)
    )  # fmt: skip
    assert track.tunnels == (Tunnel(3000.0, 1400.0, 50.0),)  # to the end of s1, and the last 400 m of s2
    assert track.neutral_sections == (NeutralSection(1000.0, 200.0, True), NeutralSection(5900.0, 100.0))
    assert track.stops_m == (200.0, 6500.0, 9700.0)
    assert track.places == (
        Place(200.0, "Aston"), Place(2500.0, "b"), Place(6500.0, "Ceeville"), Place(9700.0, "d")
    )  # fmt: skip
    assert track.notes == (
        "additional speed restrictions (ASR) that lower the limit: 2",
        "limits that hold until the train's rear has left them (SSP_Front, ASR_Front; --limits tail): 3 of 6",
        "no curves on s2: taken as straight",
    )


def test_timetable_on_a_clock_of_its_own(saved_xml):
    journey = load_journey(saved_xml(message()))
    assert journey.points == (
        TimingPoint(200.0, 0.0, INF, 0.0, 0.0),
        TimingPoint(2500.0, -INF, 270.0),
        TimingPoint(6500.0, 330.0, 420.0, 0.0, 0.0),
        TimingPoint(6500.0, 480.0, INF, 0.0, 0.0),
        TimingPoint(9700.0, -INF, 720.0, 0.0, 0.0),
    )


def test_train_with_what_its_journey_overrides(saved_xml):
    train = load_train(saved_xml(message()))
    assert (train.name, train.mass_kg, train.length_m, train.rotating_mass_factor) == ("ic", 220_000.0, 100.0, 1.06)
    assert train.max_speed_mps == pytest.approx(140 / 3.6, rel=1e-15)
    assert (train.davis_a_n, train.davis_b_n_per_mps, train.davis_c_n_per_mps2) == (1500.0, 30.0, 6.0)
    assert [train.traction.effort_n(v) for v in (0.0, 10.0, 20.0, 30.0, 50.0)] == [2e5, 1.5e5, 1e5, 7.5e4, 5e4]
    assert [train.braking.effort_n(v) for v in (0.0, 20.0)] == [1.8e5, 1.7e5]
    assert (train.max_deceleration_mps2, train.braking_rates, train.notes) == (0.7, (), ())
    assert load_train(saved_xml(TRAIN.strip())).mass_kg == 200_000.0


def test_without_a_curve_comfortable_braking_is_full_braking(saved_xml):
    text = re.sub(r"<BrakingForceCurve>.*</BrakingForceCurve>", "", TRAIN, flags=re.DOTALL).strip()
    train = load_train(saved_xml(text))
    assert train.braking_rates == (BrakingRate(0.0, 0.7),)
    assert train.notes == ("full braking is comfortableBraking: there is no BrakingForceCurve",)


def test_several_tractions_are_chosen_by_name(saved_xml):
    curve = re.search(r"<TractionForceCurve>.*</TractionForceCurve>", TRAIN, re.DOTALL)[0]
    weak = curve.replace("200000", "90000").replace("<TractionForceCurve>", '<TractionForceCurve identifier="weak">')
    text = TRAIN.replace(curve, curve + weak).strip()
    assert load_train(saved_xml(text, "#ic:weak")).traction.effort_n(0.0) == 90_000.0
    assert load_train(saved_xml(text, "#ic:1")).traction.effort_n(0.0) == 200_000.0
    with pytest.raises(InputError, match="holds 2 trains, choose one as FILE#NAME: ic:1, ic:weak"):
        load_train(saved_xml(text))


def test_segments_and_train_may_lie_beside_their_journey(tmp_path, saved_xml):
    whole = load_scenario(saved_xml(message()))
    for number, part in enumerate(PARTS):
        (tmp_path / f"part-{number}.xml").write_text(part.strip())
    (tmp_path / "file.xml").unlink()
    (tmp_path / "other.xml").write_text("<other>")
    (tmp_path / "broken.xml").write_text('<SegmentProfile SP_ID="s9">')
    os.mkfifo(tmp_path / "pipe.xml")
    apart = load_scenario(tmp_path / "part-0.xml")
    assert (apart.track, apart.journey, apart.train) == (whole.track, whole.journey, whole.train)
    assert set(apart.inputs) == {str(tmp_path / f"part-{number}.xml") for number in range(4)}
    beside = read_source(tmp_path / "part-0.xml", "track").fingerprint["beside"]
    assert set(beside) == {"part-1.xml", "part-2.xml", "part-3.xml"}


def test_the_same_segment_may_be_there_twice(tmp_path, saved_xml):
    (tmp_path / "again.xml").write_text(SEGMENT_1.strip())
    assert load_track(saved_xml(message(JOURNEY, SEGMENT_1, SEGMENT_1, SEGMENT_2, TRAIN))).length_m == 10_000.0
    (tmp_path / "more.xml").write_text(message(SEGMENT_1, SEGMENT_2, TRAIN))
    assert load_track(saved_xml(JOURNEY.strip())).length_m == 10_000.0


def test_a_journey_from_elsewhere_has_to_hold_its_segments():
    (scenario,) = load_bytes("upload.xml", message().encode())
    assert scenario.track.length_m == 10_000.0
    with pytest.raises(InputError, match=r"upload\.xml: references another file, which is not at hand: put it inside"):
        load_bytes("upload.xml", JOURNEY.strip().encode())


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('SP_ID="s1" SP_VersionMajor="1" SP_VersionMinor="2" SP_Length', 'SP_ID="s1" SP_VersionMajor="2" SP_Length',
         "SegmentProfileReference[1]@SP_ID: no SegmentProfile 's1' 1.2 of 0099 in the file; there is 2 of 0099"),
        ('SP_ID="s2" SP_VersionMajor="1" SP_VersionMinor="0" SP_Length', 'SP_ID="s3" SP_VersionMajor="1" SP_Length',
         "no SegmentProfile 's2' 1.0 of 0099 in the file, nor beside the file"),
        (SEGMENT_1, SEGMENT_1 + SEGMENT_1.replace("4000", "4100"),
         "SegmentProfileReference[1]@SP_ID: 2 SegmentProfiles of this version that differ, in file.xml line"),
        ('SP_Length="4000"', 'SP_Length="4000" SP_Status="Invalid"', "SegmentProfile[1]@SP_Status: must be Valid"),
        ('SP_Length="4000"', 'SP_Length="0"', "SegmentProfile[1]@SP_Length: must be above 0.001 m, got '0'"),
        ('TP_ID="b" location="2500"', 'TP_ID="b" location="4001"',
         "TimingPoint[2]@location: must be within SP_Length, 4000 m of file.xml, got 4001 m"),
        ('TP_ID_Reference TP_ID="b"', 'TP_ID_Reference TP_ID="x"',
         "TP_ID_Reference@TP_ID: TimingPoint 'x' is not in segment 's1' of file.xml"),
        ('TP_ID="b" location="2500"', 'TP_ID="b" location="100"', "'b' lies before the point above it, got 100 m"),
        (' startLocation="3500" startEndQualifier', " startEndQualifier", "@startLocation: missing attribute"),
        ('"3500" startEndQualifier="Starts" t', '"3500" t', "@startEndQualifier: missing attribute"),
        ('"12.5" gradientDirection="Uphill"', '"12.5"', "@gradientDirection: missing attribute"),
        ('gradientValue="12.5"', 'gradientValue="-1"', "@gradientValue: must be at least 0 ‰, got '-1'"),
        ('curveRadius="600"', 'curveRadius="x"', "CurveChange[1]@curveRadius: must be a number of m, got 'x'"),
        ('location="2400"', 'location="1900"', "CurveChange[2]@location: must not decrease, got 1900 m after 2000 m"),
        ('<CurveStart curveRadius="0"/>', "", "Curves: missing element CurveStart"),
        ("2026-05-05T00:02:30Z", "2026-05-05 00:02", "@TP_latestArrivalTime: must be a time in UTC such as"),
        ("2026-05-05T00:02:30Z", "2026-13-05T00:02:30Z", "@TP_latestArrivalTime: must be seconds, h:min:s or a date"),
        ("2026-05-05T00:02:30Z", "2026-05-05T00:05:30Z", "'Ceeville': times must not decrease, got 30 s less"),
        ("PT1M30S", "90", "@arrivalWindow: must be a duration such as PT1M30S, got '90'"),
        ('<StoppingPointDepartureDetails departureTime="2026-05-04T23:58:00Z"/>', "",
         "the first stop has no StoppingPointDepartureDetails@departureTime"),
        ('MassFactor="1.06"', 'MassFactor="6"', "TC_Features@rotatingMassFactor: must be below 2, got 6"),
        ('speed="72"', 'speed="150"', "@speed: speeds must start at 0 km/h and not decrease, got 144 km/h"),
        ('brakingForce="160000"', 'brakingForce="-1"', "@brakingForce: must be at least 0 N, got '-1'"),
        ('trainWeight="220"', 'trainWeight="0"', "TrainCharacteristicsRef@trainWeight: must be above 0 t, got '0'"),
        (JOURNEY, 2 * JOURNEY, "JourneyProfile[2]: a second journey of train '4711': leave one"),
        ('JP_Status="Valid"', 'JP_Status="Unavailable"', "@JP_Status: must be of a journey to run, got 'Unavailable'"),
        ('JP_Version="7"', 'JP_Version="abc"', "JourneyProfile@JP_Version: must be a number, got 'abc'"),
        ('JP_Version="7"', 'JP_Version="1.5"', "JourneyProfile@JP_Version: must be a whole number, got '1.5'"),
        ('JP_Version="7"', 'JP_Version="-1"', "JourneyProfile@JP_Version: must be at least 0, got '-1'"),
        ("<teltsi_OperationalTrainNumber>4711</teltsi_OperationalTrainNumber>", "", "missing element TrainIdentif"),
    ],
)  # fmt: skip
def test_wrong_messages_are_refused_in_one_line(saved_xml, old, new, message):
    path = saved_xml(edited((old, new)))
    with pytest.raises(InputError) as caught:
        load_scenario(path)
    line = str(caught.value)
    assert line.startswith(f"{path}: line ")
    assert message in line
    assert line.isprintable()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (SEGMENT_1.strip(), "holds segments alone: a JourneyProfile tells in which order they are run"),
        (
            "<G2B_EventPayload/>",
            "holds no JourneyProfile and no TrainCharacteristics: of SFERA messages these are read",
        ),
        (
            "<SFERA_B2G_RequestMessage/>",
            "holds XML, but neither railML nor SFERA to be run: its root is 'SFERA_B2G_Requ",
        ),
    ],
)
def test_messages_without_a_run_are_refused(saved_xml, text, message):
    with pytest.raises(InputError, match=re.escape(message)):
        describe_file(saved_xml(text))


def test_a_train_that_lacks_something_says_so(saved_xml):
    text = edited(('rolloutCoefficientA="1500" rolloutCoefficientB="30" rolloutCoefficientC="6"', ""))
    lacks = (
        "TrainCharacteristics ic lacks rolloutCoefficientA, B and C: the train comes from another file (--train FILE)"
    )
    assert lacks in load_track(saved_xml(text)).notes
    with pytest.raises(InputError, match=re.escape(f"holds a SFERA track and a journey, not a train: {lacks}")):
        load_train(saved_xml(text))


def test_tunnels_that_are_there_twice_or_overlap_are_one(saved_xml):
    tunnel = '<Tunnel startLocation="3000" startEndQualifier="Starts" tunnelFactor="50"/>'
    once = load_track(saved_xml(message())).tunnels
    across = '<Tunnel startLocation="3200" endLocation="3500" startEndQualifier="StartsEnds" tunnelFactor="50"/>'
    unknown = tunnel.replace(' tunnelFactor="50"', "")
    assert load_track(saved_xml(edited((tunnel, tunnel + across + unknown + tunnel)))).tunnels == once


def test_a_train_that_changes_on_the_way_is_told(saved_xml):
    again = '<TrainCharacteristicsRef TC_ID="ic" TC_VersionMajor="3" trainLength="50"><TC_RU_ID>9901</TC_RU_ID>'
    ends = JOURNEY.rindex("  </SegmentProfileReference>")
    shorter = JOURNEY[:ends] + f"{again}</TrainCharacteristicsRef>\n" + JOURNEY[ends:]
    notes = load_track(saved_xml(message(shorter, *PARTS[1:]))).notes
    assert "the train changes on the way: TrainCharacteristics ic is taken all along" in notes


def test_trains_of_several_journeys_are_told_apart_by_these(saved_xml):
    """One is lighter; a third journey is of the same train as the first."""
    others = [JOURNEY.replace(">4711<", ">4712<").replace('"220"', '"180"'), JOURNEY.replace(">4711<", ">4713<")]
    path = saved_xml(message(JOURNEY, *others, *PARTS[1:]))
    for name, mass_kg in (("ic:4711", 220e3), ("ic:4712", 180e3), ("4711", 220e3), ("4712", 180e3), ("4713", 220e3)):
        assert load_train(f"{path}#{name}").mass_kg == mass_kg
    assert refusal(load_train, path).endswith("holds 2 trains, choose one as FILE#NAME: ic:4711, ic:4712")
    assert load_train(f"{saved_xml(message(JOURNEY, others[1], *PARTS[1:]))}#ic").mass_kg == 220e3


def test_a_journey_of_another_train_is_not_run(saved_xml):
    path = saved_xml(message())
    assert load_journey(f"{path}#4711") == load_journey(path)
    assert refusal(load_journey, f"{path}#4712").endswith("holds no journey '4712'; it holds: 4711")


def test_points_before_the_first_stop_are_told(saved_xml):
    clock = '<StoppingPointDepartureDetails departureTime="2026-05-04T23:58:00Z"/>'
    text = message().replace("Stopping_Point", "Passing_Point", 1).replace(clock, "")
    journey = load_journey(saved_xml(text))
    assert [point.position_m for point in journey.points] == [6500.0, 9700.0]
    assert "passed before the first stop or behind the last one, and not run, at km 0.2, 2.5" in journey.notes


def test_without_times_there_is_no_timetable(saved_xml):
    text = re.sub(r' TP_latestArrivalTime="[^"]*"|<StoppingPointDepartureDetails[^>]*>', "", message())
    assert load_track(saved_xml(text)).stops_m == (200.0, 6500.0, 9700.0)
    with pytest.raises(InputError, match="not a journey: none of its points has a time"):
        load_journey(saved_xml(text))


def test_real_messages(sfera):
    samples = sfera / "samples"
    one = samples / "T24_SFERA_JP_T24.xml"
    track, journey = load_track(one), load_journey(one)
    assert limits_of(track) == [
        (0, 80), (2000, 120), (4200, 44), (4250, 120), (5600, 80), (8300, 120), (10300, 80), (12450, 60), (12550, 80)
    ]  # fmt: skip
    assert track.stops_m == (0.0, 2000.0, 5600.0, 12_300.0, 15_100.0)
    assert [place.name for place in track.places[:3]] == ["Genève-Aéroport", "Genève", "Coppet"]
    assert [(point.earliest_s, point.latest_s) for point in journey.points[:4]] == [
        (0.0, INF), (-INF, 440.0), (550.0, INF), (-INF, 930.0)
    ]  # fmt: skip
    other = samples / "T2_SFERA_JP_T2.xml"
    with pytest.raises(InputError, match="no speed limit from 0 m to 130000 m of the journey"):
        load_track(other)
    line = load_track(other, line_speed_mps=30.0)
    assert limits_of(line) == [(0, 108), (700, 60), (116_800, 108)]
    assert [one.position_m for one in line.neutral_sections] == [1700, 93_200, 95_200, 116_700, 118_700, 120_200]
    with pytest.raises(InputError, match=r"T16_1\.xml: line 37, .*@location: must be within SP_Length, 2000 m"):
        load_track(samples / "T16_SFERA_JP_T16.xml", line_speed_mps=30.0)


def test_all_of_a_message_is_described_and_reviewed(saved_xml):
    path = saved_xml(message())
    assert str(describe_file(path)).startswith("scenario ic (SFERA)")
    assert {review.kind for review in review_file(path)} == {"train", "track"}
