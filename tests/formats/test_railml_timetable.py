"""Timetables of railML 2.x: trains and train parts with their times at operational points."""

import math
import re

import pytest
from hypothesis import given

import tgvdp
from tests.helpers.railml_line_case import LINE_2, LINE_3
from tests.helpers.refusal import refusal
from tests.helpers.settings import fuzz
from tests.helpers.xml_slips import mutated
from tgvdp.cli import main
from tgvdp.formats import describe_file, load_journey, load_section, load_track
from tgvdp.formats.detect import load_all
from tgvdp.formats.review.plausibility import review_file
from tgvdp.model.track import Place

pytest.importorskip("lxml")

INF = math.inf
#: Where LINE_2 has its points, by name.
PLACES = (Place(0.0, "Aston"), Place(4000.0, "Mid"), Place(6000.0, "B7"), Place(10000.0, "Berry"))
POINTS = """<operationControlPoints>
   <ocp id="a" name="Aston"/><ocp id="z" name="Berry"/><ocp id="far" name="Far Away"/>
   <ocp id="halt" name="Mid"><propOperational operationalType="stoppingPoint"/></ocp>
   <ocp id="block"><designator register="DB640" entry="B7"/><propOperational operationalType="blockPost"/></ocp>
  </operationControlPoints>"""


def place(ref, times, kind="", inside=""):
    typed = f' ocpType="{kind}"' if kind else ""
    return f'<ocpTT ocpRef="{ref}"{typed}>{times}{inside}</ocpTT>'


def times(arrival="", departure="", more=""):
    given = "".join(f' {name}="{time}"' for name, time in (("arrival", arrival), ("departure", departure)) if time)
    return f"<times{given}{more}/>"


DAY = (
    place("a", times("", "10:00:00")),
    place("halt", times("10:04:00", "10:05:00"), "stop"),
    place("block", times("10:06:30", "10:06:30"), "pass"),
    place("z", times("10:10:00")),
)


TRAIN = """<train id="t" trainNumber="4711">
  <trainPartSequence sequence="1"><trainPartRef ref="p"/></trainPartSequence>
</train>"""


def part(name, *places):
    return f'<trainPart id="{name}"><ocpsTT>{"".join(places)}</ocpsTT></trainPart>'


def timetable(*parts, trains=""):
    return f"<timetable><trainParts>{''.join(parts)}</trainParts><trains>{trains}</trains></timetable>"


def file(*parts, trains=""):
    """LINE_2 with names and ends, and a timetable."""
    text = LINE_2.replace('<openEnd id="oe1"/>', '<openEnd id="oe1"/><macroscopicNode ocpRef="a"/>')
    text = text.replace('<openEnd id="oe2"/>', '<openEnd id="oe2"/><macroscopicNode ocpRef="z"/>')
    first, last = text.index("<operationControlPoints>"), text.index("</operationControlPoints>")
    text = text[:first] + POINTS + text[last + len("</operationControlPoints>") :]
    return text.replace("</railml>", timetable(*parts, trains=trains) + "</railml>")


@pytest.fixture
def journey(saved_xml):
    def read(*parts, trains="", name=None):
        path = saved_xml(file(*parts, trains=trains))
        return load_journey(path if name is None else f"{path}#{name}", load_track(f"{path}#t1:up"))

    return read


def points(journey):
    return [tuple(point) for point in journey.points]


EXPECTED = [
    (0.0, 0.0, INF, 0.0, 0.0), (4000.0, -INF, 240.0, 0.0, 0.0), (4000.0, 300.0, INF, 0.0, 0.0),
    (6000.0, -INF, 390.0, 0.0, INF), (10000.0, -INF, 600.0, 0.0, 0.0),
]  # fmt: skip


def test_places_of_a_track_have_names_or_codes_its_ends_and_those_that_are_passed_as_well(saved_xml):
    path = saved_xml(file())
    up, down = (load_track(f"{path}#t1:{way}") for way in ("up", "down"))
    assert up.places == PLACES
    assert [place.name for place in down.places] == ["Berry", "B7", "Mid", "Aston"]
    assert up.stops_m == (0.0, 4000.0, 10000.0)


def test_a_train_part_is_a_journey(journey):
    assert points(journey(part("p", *DAY))) == EXPECTED


@pytest.mark.parametrize("kind", ["", "stop"])
def test_a_place_without_type_is_a_stop_where_it_waits(journey, kind):
    waits = place("halt", times("10:04:00", "10:05:00"), kind)
    passed = place("block", times("10:06:30", "10:06:30"))
    assert points(journey(part("p", DAY[0], waits, passed, DAY[3]))) == EXPECTED


def test_times_go_on_past_midnight_with_days_or_without(journey):
    late = (place("a", times("", "23:58:00")), place("halt", times("00:02:00", "00:03:00"), "stop"))
    by_day = place("halt", times("00:02:00", "00:03:00", ' arrivalDay="1" departureDay="1"'), "stop")
    end = place("z", times("00:08:00"))
    dated = place("z", times("00:08:00", "", ' arrivalDay="1"'))
    assert points(journey(part("p", *late, end))) == [EXPECTED[at] for at in (0, 1, 2, 4)]
    half_said = place("halt", times("00:02:00Z", "00:03:00+01:00", ' departureDay="1"'), "stop")
    for halt, last in ((by_day, dated), (half_said, end), (half_said, dated)):
        assert points(journey(part("p", late[0], halt, last))) == [EXPECTED[at] for at in (0, 1, 2, 4)]


def test_a_stop_without_times_may_have_any(journey):
    free = journey(part("p", DAY[0], place("halt", "", "stop"), DAY[3]))
    assert points(free) == [EXPECTED[0], (4000.0, -INF, INF, 0.0, 0.0), (4000.0, -INF, INF, 0.0, 0.0), EXPECTED[4]]


def test_scheduled_times_count_and_actual_ones_never(journey):
    several = place("halt", times("10:09:00", "10:09:30", ' scope="actual"') + times("10:04:00", "10:05:00"), "stop")
    found = journey(part("p", DAY[0], several, *DAY[2:]))
    assert points(found) == EXPECTED
    assert any("actual" in note for note in found.notes)


def test_a_train_joins_its_parts_and_is_chosen_by_its_number(journey):
    first = part("p1", DAY[0], place("halt", times("10:04:00"), "stop"))
    second = part("p2", place("halt", times("", "10:05:00"), "stop"), *DAY[2:])
    other = part("q", *DAY)
    sequence = "".join(
        f'<trainPartSequence sequence="{at}"><trainPartRef ref="p{at}"/></trainPartSequence>' for at in (2, 1)
    )
    trains = f'<train id="t" trainNumber="4711" type="operational">{sequence}</train>'
    again = trains.replace('"t"', '"c"').replace("operational", "commercial")
    for name in ("4711", "t", "q"):
        assert points(journey(first, second, other, trains=trains + again, name=name)) == EXPECTED
    with pytest.raises(tgvdp.InputError, match="holds 2 journeys, choose one as FILE#NAME: t, q"):
        journey(first, second, other, trains=trains + again)


def test_a_train_is_chosen_by_each_of_its_names_and_by_no_other(journey):
    ref = '<trainPartSequence sequence="1"><trainPartRef ref="{}"/></trainPartSequence>'
    given = (("t", "4711", "p"), ("c", "IC 1", "p"), ("u", "4711", "q"))
    trains = "".join(f'<train id="{id}" trainNumber="{number}">{ref.format(own)}</train>' for id, number, own in given)
    other = (DAY[0], place("z", times("10:20:00")))
    for name in ("t", "c", "IC 1"):
        assert points(journey(part("p", *DAY), part("q", *other), trains=trains, name=name)) == EXPECTED
    with pytest.raises(
        tgvdp.InputError, match="holds 2 journeys that are called '4711', choose one as FILE#NAME: t, u"
    ):
        journey(part("p", *DAY), part("q", *other), trains=trains, name="4711")
    with pytest.raises(tgvdp.InputError, match="holds no journey '4712'; it holds: p"):
        journey(part("p", *DAY), name="4712")


def test_a_section_is_one_of_the_train_of_a_number(saved_xml, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = saved_xml(file(part("p", *DAY), trains=TRAIN))
    asked = ["--train", "alstom-emu", "--points", "2", "--no-pictures", "--quiet", "--out", "out"]
    assert main(["search", "--track", f"{path}#t1:up", "--journey", f"{path}#4711", *asked]) == 0


def test_a_stop_near_the_end_of_a_track_is_the_place_of_that_name(saved_xml):
    stop = '<crossSection id="cs0" pos="150" ocpRef="a"/><crossSection id="cs1"'
    path = saved_xml(file(part("p", *DAY)).replace('<crossSection id="cs1"', stop))
    track = load_track(f"{path}#t1:up")
    assert track.places == (Place(50.0, "Aston"), *PLACES[1:])
    assert points(load_journey(path, track))[0] == (50.0, *EXPECTED[0][1:])


def test_what_is_passed_before_and_behind_the_stops_is_told(journey):
    through = place("a", times("10:00:00", "10:00:00"), "pass"), *DAY[1:]
    found = journey(part("p", *through))
    assert [point.position_m for point in found.points] == [4000.0, 6000.0, 10000.0]
    assert "passed before the first stop or behind the last one, and not run, at km 0" in found.notes


def test_shortest_stops_are_told(journey):
    halt = place("halt", times("10:04:00", "10:05:00"), "stop", "<stopDescription><stopTimes/></stopDescription>")
    assert (
        "stopTimes of train p are not used at stops, where --dwell counts: 1"
        in journey(part("p", DAY[0], halt, DAY[3])).notes
    )


def test_what_lies_beyond_the_line_is_left_out_and_said(journey):
    before = place("far", times("", "09:50:00"))
    started = place("a", times("09:59:00", "10:00:00"), "stop")
    found = journey(part("p", before, started, *DAY[1:]))
    assert points(found) == EXPECTED
    assert "not on the line, left out of train p: Far Away" in found.notes


@pytest.mark.parametrize(
    ("places", "message"),
    [
        ((DAY[0], place("far", times("10:02:00"), "stop"), DAY[3]), "no place of that name, got 'Far Away'"),
        ((DAY[3], place("a", times("10:12:00"))), "'Aston' lies before the place above it: is the line to be reversed"),
        ((DAY[0], place("halt", times("9:00:00", "10:05:00")), DAY[3]), "@arrival: .* got 9:00:00 after a later one"),
        ((place("a", times("", "10:00:00"), "halt"), DAY[3]), "@ocpType: must be one of begin, stop, pass, end"),
        ((DAY[0], place("halt", times("10:04:00") + times("10:05:00")), DAY[3]), "a second time of scope 'scheduled'"),
        ((DAY[0], place("halt", times("10:61:00")), DAY[3]), "@arrival: minutes after hours"),
        ((DAY[0], place("halt", times("", "soon")), DAY[3]), "got 'soon'"),
        ((place("a", "", "stop"), *DAY[1:]), "the first stop must have a time"),
        ((DAY[0], place("far", times("10:05:00"))), "1 of 2 stops are places of the line .it has 'Aston', 'Mid', 'B7'"),
        ((DAY[0], DAY[2]), "a timetable needs two stops with times"),
    ],
)  # fmt: skip
def test_what_cannot_be_run_is_refused_with_its_place(journey, places, message):
    with pytest.raises(tgvdp.InputError, match=message) as error:
        journey(part("p", *places))
    assert "line " in str(error.value)


def test_a_timetable_needs_a_line_with_names_and_hinders_nothing_else(saved_xml):
    path = saved_xml(file(part("p", *DAY), part("q", *DAY)))
    message = "its timetable names places alone, and no line is given that has names"
    assert refusal(load_journey, path).endswith(message)
    assert refusal(load_section, path).endswith(message)
    assert {kind for one in load_all(path) for kind in ("track", "journey") if getattr(one, kind)} == {"track"}
    alone = saved_xml('<railml version="2.4">' + timetable(part("p", *DAY)) + "</railml>")
    assert refusal(load_all, alone).endswith(message)
    assert "not a journey" in refusal(load_journey, saved_xml(LINE_3))


def test_a_timetable_without_a_line_is_described_by_its_trains(saved_xml):
    points = f"<infrastructure>{POINTS}</infrastructure>"
    parts = part("p", *DAY), part("q", place("x", times("", "")), *DAY[1:3])
    text = f'<railml version="2.4">{points}{timetable(*parts, trains=TRAIN)}</railml>'
    described = describe_file(saved_xml(text))
    assert described.kind == "timetable"
    assert [(figure.name, str(figure)) for figure in described.figures] == [
        ("train t", "4711: Aston to Berry, 4 places, 10:00:00 to 10:10:00"),
        ("train q", "x to B7, 3 places, 10:04:00 to 10:06:30; a timetable needs two stops with times, got 1"),
    ]
    assert described.notes == (
        "it gives no positions: tgvdp journey takes it with a line that has places of these names",
    )
    path = saved_xml(text)
    for chosen in ("t", "4711"):
        assert describe_file(f"{path}#{chosen}").figures == described.figures[:1]
    assert refusal(describe_file, f"{path}#4712") == "holds no journey '4712', did you mean '4711'?"
    assert review_file(path) == []
    passed = text.replace(timetable(*parts, trains=TRAIN), timetable(part("p", DAY[2])))
    assert refusal(describe_file, saved_xml(passed)).endswith("two stops with times, and no train has them")
    late = text.replace('"10:10:00"', '"10:00:30"')
    assert "times must not decrease, got 10:00:30 after a later one" in refusal(describe_file, saved_xml(late))


def test_a_train_keeps_its_railml_timetable(saved_xml):
    path = saved_xml(file(part("p", *DAY)))
    found = tgvdp.journey("alstom-emu", f"{path}#t1:up", f"{path}#p", points=3)
    assert found.found.departure_s[:, 1].min() >= 300.0
    assert "Mid" in found.advice(0)[0]


def test_mutated_timetables_load_or_are_refused_in_one_line_that_names_the_place(tmp_path, saved_xml):
    track = load_track(saved_xml(file(), "#t1:up"))
    head, _, tail = file(part("p", *DAY), trains=TRAIN).partition("<timetable>")
    path = tmp_path / "input.xml"

    @fuzz()
    @given(mutated(f"<timetable>{tail}"))
    def check(text):
        path.write_text(head + text, encoding="utf-8")
        try:
            assert load_journey(path, track).points[0].is_stop
        except tgvdp.InputError as error:
            line = str(error).removeprefix(f"{path}: ")
            assert line.isprintable()
            assert re.match(r"line \d+[,:] |holds ", line), line

    check()
