"""railML 2.x and 3.x: what a run needs of tracks, and trains with effort tables."""

import math

import pytest

from tests.helpers.railml_case import SAMPLES
from tests.helpers.railml_line_case import LINE_2, LINE_3, limits_kmh
from tests.helpers.railml_stock_case import STOCK_2, STOCK_3
from tests.helpers.refusal import refusal
from tgvdp.formats import describe_file, load_scenario, load_track, load_train
from tgvdp.formats.railml.reader import lines_of
from tgvdp.formats.railml.rows import LINE_SPEED_HINT
from tgvdp.formats.syntax.reading import read_document
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Curve, Place, Tunnel
from tgvdp.model.train import BrakingRate
from tgvdp.units import kmh_to_mps

pytest.importorskip("lxml")


def test_line_of_version_2_upwards(saved_xml):
    track = load_track(saved_xml(LINE_2, "#t1:up"))
    assert (track.name, track.length_m, track.stops_m) == ("Main", 10_000.0, (0.0, 4000.0, 10_000.0))
    assert limits_kmh(track) == [(0.0, 90), (3000.0, 120), (9000.0, 100)]
    assert track.gradients == ((0.0, 5.0), (2000.0, -4.0))
    straight = (math.inf, math.inf)
    assert track.curves == (Curve(0.0, *straight), Curve(1000.0, -400.0, -400.0), Curve(1500.0, *straight))
    assert track.tunnels == (Tunnel(7000.0, 1050.0, 40.0),)
    assert track.notes == (
        "limits count for headOfTrain: choose limits for head or tail of the train accordingly",
        "a tunnel of 100 m in line 33 has no crossSection: not used",
        "not used: extra, gradientChange@transitionLength, ocsElements",
    )


def test_line_of_version_2_downwards_turns_the_ground_round(saved_xml):
    track = load_track(saved_xml(LINE_2, "#t1:down"))
    assert track.stops_m == (0.0, 6000.0, 10_000.0)
    assert limits_kmh(track) == [(0.0, 80), (8000.0, 110)]
    assert track.gradients == ((0.0, 4.0), (8000.0, -5.0))  # + uphill in the direction of the run
    assert [(row.position_m, row.radius_start_m) for row in track.curves] == [
        (0.0, math.inf), (8500.0, 400.0), (9000.0, math.inf),
    ]  # fmt: skip
    assert track.tunnels == (Tunnel(1950.0, 1050.0, 40.0),)


def test_gradients_that_are_given_downwards_hold_from_there_on_downwards(saved_xml):
    changes = """<gradientChange id="g3" pos="10100" dir="down" slope="-4.0"/>
                 <gradientChange id="g4" pos="2100" dir="down" slope="5.0"/></gradientChanges>"""
    both = LINE_2.replace("</gradientChanges>", changes)
    assert load_track(saved_xml(both, "#t1:down")).gradients == ((0.0, 4.0), (8000.0, -5.0))
    assert load_track(saved_xml(both, "#t1:up")).gradients == ((0.0, 5.0), (2000.0, -4.0))
    only = both.replace('<gradientChange id="g1" pos="100" dir="up" slope="5.0" transitionLength="20"/>', "").replace(
        '<gradientChange id="g2" pos="2100" dir="up" slope="-4.0"/>', ""
    )
    assert load_track(saved_xml(only, "#t1:up")).gradients == ((0.0, 5.0), (2000.0, -4.0))


def test_a_first_gradient_behind_the_start_is_level_before_and_says_so(saved_xml):
    text = LINE_2.replace('pos="100" dir="up" slope="5.0"', 'pos="600" dir="up" slope="5.0"')
    track = load_track(saved_xml(text, "#t1:up"))
    assert track.gradients == ((0.0, 0.0), (500.0, 5.0), (2000.0, -4.0))
    assert "gradients are not given on 500 m (0.5 km): taken as level" in track.notes
    assert load_track(saved_xml(text, "#t1:down")).gradients == ((0.0, 4.0), (8000.0, -5.0), (9500.0, 0.0))


def test_tracks_join_one_after_the_other_and_limits_go_on(saved_xml):
    second = LINE_2[LINE_2.index("<track ") : LINE_2.index("</track>") + len("</track>")]
    second = second.replace('id="t1" name="Main"', 'id="t2" name="Branch"').replace("<speedChange ", "<unknown ", 1)
    text = LINE_2.replace("</tracks>", f"{second}</tracks>")
    track = load_track(saved_xml(text, "#t1:up+t2:up"))
    assert (track.name, track.length_m) == ("Main + Branch", 20_000.0)
    assert limits_kmh(track) == [(0.0, 90), (3000.0, 120), (9000.0, 100), (13_000.0, 120), (19_000.0, 100)]
    assert track.gradients == ((0.0, 5.0), (2000.0, -4.0), (10_000.0, 5.0), (12_000.0, -4.0))
    assert track.stops_m == (0.0, 4000.0, 14_000.0, 20_000.0)
    assert refusal(load_track, saved_xml(text, "#t2:up+t1:up")).endswith(
        f"no speed limit from 0 m to 3000 m of Branch: {LINE_SPEED_HINT}"
    )


def test_choices_are_asked_for_by_name(saved_xml):
    name = saved_xml(LINE_2)
    assert refusal(load_track, name) == "holds 2 tracks, choose one as FILE#NAME: t1:up, t1:down"
    assert refusal(load_track, f"{name}#t1") == (
        "track 't1' can be run in several ways, choose one as FILE#NAME: t1:up, t1:down"
    )
    assert refusal(load_track, f"{name}#t1:up:ice").endswith("choose one as FILE#NAME: t1:up, t1:down")
    assert refusal(load_track, f"{name}#t7:up") == "holds no track 't7'; known: t1"
    assert refusal(load_train, name) == "holds a railML 2.3 track, not a train"
    assert load_track(f"{name}#Main:up").name == "Main"  # by its name as well as by its id
    described = describe_file(name)
    assert [figure.name for figure in described.figures] == ["t1:up", "t1:down"]


def test_one_direction_needs_no_choice(saved_xml):
    text = LINE_2.replace('dir="down"', 'dir="up"').replace(
        '<speedChange id="s4" pos="10100"', '<speedChange id="s4" pos="9900"'
    )
    assert load_track(saved_xml(text)).length_m == 10_000.0


def test_speed_profiles_are_layers_of_their_own(saved_xml):
    tilting = '<speedChange id="p" pos="100" dir="up" vMax="140" profileRef="tilt"/></speedChanges>'
    text = LINE_2.replace("</speedChanges>", tilting)
    assert limits_kmh(load_track(saved_xml(text, "#t1:up")))[0] == (0.0, 90)
    assert limits_kmh(load_track(saved_xml(text, "#t1:up:tilt"))) == [(0.0, 140)]
    assert "t1:up:tilt" in refusal(load_track, saved_xml(text))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('vMax="120"', 'vMax="fast"', "line 17, railml/infrastructure/tracks/track/trackElements/speedChanges/"
                                      "speedChange[2]@vMax: must be a number of km/h (or end), got 'fast'"),
        ('vMax="120"', 'vMax="0"', "speedChange[2]@vMax: must be above 0 km/h (or end), got '0'"),
        ('vMax="120" ', "", "speedChange[2]@vMax: missing attribute"),
        ('dir="up" vMax="120"', 'dir="north" vMax="120"', "@dir: must be one of up, down, both, none, unknown, got"),
        ('trainRelation="headOfTrain"', 'trainRelation="nose"', "@trainRelation: must be one of headOfTrain"),
        ('pos="3100"', 'pos="10200"', "speedChange[2]@pos: must lie on the track, 100 to 10100 m, got '10200'"),
        ('pos="3100"', 'pos="100"', "speedChange[2]@pos: a second speedChange at the position of line 16"),
        ('id="s1" pos="100"', 'id="s1" pos="300"', "no speed limit from 0 m to 200 m of Main"),
        ('slope="-4.0"', 'slope="-4000"', "gradients[1].gradient must be within ±1000 ‰, got -4000 ‰"),
        ('slope="-4.0"', "", "gradientChange[2]@slope: missing attribute"),
        ('pos="10100"><openEnd', 'pos="100"><openEnd', "trackEnd@pos: must lie after trackBegin at 100 m, got 100 m"),
        ("trackTopology>", "topology>", "tracks/track: missing element trackTopology"),
        ('length="1050"', 'length="5000"', "tunnel[1]@length: must end on the track, ends at 12100 m"),
    ],
)  # fmt: skip
def test_errors_of_version_2_name_line_element_and_attribute(saved_xml, old, new, message):
    assert message in refusal(load_track, saved_xml(LINE_2.replace(old, new), "#t1:up"))


def test_a_change_for_both_directions_is_refused_against_the_track(saved_xml):
    text = LINE_2.replace('id="s1" pos="100" dir="up"', 'id="s1" pos="100" dir="both"')
    assert limits_kmh(load_track(saved_xml(text, "#t1:up")))[0] == (0.0, 90)
    message = refusal(load_track, saved_xml(text, "#t1:down"))
    assert message.endswith("speedChange[1]@dir: must be up or down for a run against the track, got 'both'")


def test_line_of_version_3(saved_xml):
    track = load_track(saved_xml(LINE_3))
    assert (track.name, track.length_m, track.stops_m) == ("Main", 10_000.0, (0.0, 4000.0, 7000.0, 10_000.0))
    assert limits_kmh(track) == [(0.0, 90), (3000.0, 120)]  # the least of those that cover a place
    assert track.gradients == ((0.0, 5.0), (2000.0, -4.0), (4000.0, -4.0))
    assert track.curves == (
        Curve(0.0, math.inf, math.inf),
        Curve(900.0, math.inf, 400.0),  # the transition reaches from one neighbour to the other
        Curve(1000.0, 400.0, 400.0),
        Curve(1500.0, math.inf, math.inf),
    )
    assert track.notes == (
        "horizontalCurves are not given on 9400 m (9.4 km): taken as straight",
        "tunnels (1, 0.2 km) have no cross section: not used",
        "not used: name@language",
    )


def test_stops_have_the_names_of_their_operational_points(saved_xml):
    second = LINE_2.replace('<ocp id="halt">', '<ocp id="halt" name="Old\nTown">')
    assert load_track(saved_xml(second, "#t1:up")).places == (Place(4000.0, "Old Town"),)
    assert load_track(saved_xml(second, "#t1:down")).places == (Place(6000.0, "Old Town"),)
    third = LINE_3.replace('<operationalPoint id="op1">', '<operationalPoint id="op1"><name name="New" language="en"/>')
    (place,) = load_track(saved_xml(third)).places
    assert place.name == "New"
    assert place.position_m in load_track(saved_xml(third)).stops_m


def test_line_of_version_3_in_reverse(saved_xml):
    track = load_track(saved_xml(LINE_3, "#t1:reverse"))
    assert limits_kmh(track) == [(0.0, 120), (7000.0, 90)]
    assert track.gradients == ((0.0, 4.0), (6000.0, 4.0), (8000.0, -5.0))
    assert track.stops_m == (0.0, 3000.0, 6000.0, 10_000.0)
    assert track.curves[2] == Curve(9000.0, -400.0, math.inf)


def test_sections_of_one_direction_ask_for_it(saved_xml):
    one = LINE_3.replace('id="l5" applicationDirection="both"', 'id="l5" applicationDirection="normal"')
    assert refusal(load_track, saved_xml(one)) == "holds 2 tracks, choose one as FILE#NAME: t1:normal, t1:reverse"
    assert limits_kmh(load_track(saved_xml(one, "#t1:reverse"))) == [(0.0, 120)]
    assert limits_kmh(load_track(saved_xml(one, "#t1:normal"))) == [(0.0, 90), (3000.0, 120)]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('maxSpeed="120"', 'maxSpeed="NaN"', "speeds/speedSection[2]@maxSpeed: must be finite, got 'NaN'"),
        ('id="l6" applicationDirection="both"', 'id="l6" applicationDirection="reverse"',
         "tracks/track: speed sections leave 1000 m of 10000 m without a limit"),  # ne2 is passed against its direction
        ('netElementRef="ne2"/>', 'netElementRef="ne9"/>', "speed sections leave 6000 m of 10000 m without a limit"),
        ('<netElement id="ne2" length="6000"/>', "", "@netElementRef: no net element 'ne2' in this file"),
        ('id="ne2" length="6000"', 'id="ne2"', "netElement[2]@length: missing attribute"),
        ('posEnd="2000"', 'posEnd="5000"', "@posEnd: must lie on the net element of 4000 m, got 5000 m"),
        ('intrinsicCoordEnd="1"', 'intrinsicCoordEnd="1.5"', "@intrinsicCoordEnd: must lie on the net element"),
        ('posEnd="2000"', 'posEnd="2500"', "gradientCurve[2]: overlaps the gradientCurve before it by 500 m"),
        (' radius="400"', "", "horizontalCurve[2]@radius: missing attribute"),
        ('curveType="arc"', 'curveType="loop"', "horizontalCurve[2]@curveType: must be one of straight, arc"),
        ('positioningSystemRef="lps" measure="4000"', 'positioningSystemRef="gps" measure="4000"',
         "linearCoordinateEnd: its net element has no two coordinates in the positioning system 'gps'"),
        ('keepsOrientation="false" sequence="2"/>', 'keepsOrientation="no"/>', "Orientation: must be one of true"),
    ],
)  # fmt: skip
def test_errors_of_version_3_name_line_element_and_attribute(saved_xml, old, new, message):
    assert message in refusal(load_track, saved_xml(LINE_3.replace(old, new), "#t1:normal"))


def test_train_of_version_2(saved_xml):
    train = load_train(saved_xml(STOCK_2))
    assert (train.name, train.mass_kg, train.length_m) == ("IC", 460_000.0, 196.0)
    assert train.max_speed_mps == kmh_to_mps(140.0)  # the slowest vehicle
    assert train.traction == EffortCurve.from_points(
        [(0.0, 600e3), (kmh_to_mps(72.0), 400e3), (kmh_to_mps(144.0), 200e3)]  # two locomotives
    )
    assert train.rotating_mass_factor == pytest.approx(1.0 + 0.2 * 160.0 / 460.0)
    weight_kn = 460.0 * 9.81
    assert train.resistance_n(kmh_to_mps(100.0)) == pytest.approx(weight_kn * (1.5 + 0.5 + 2.0))
    assert train.braking_rates == (BrakingRate(0.0, 0.7),)
    assert (train.max_acceleration_mps2, train.traction_efficiency) == (0.6, 0.85)
    assert any(note.startswith("not used: trainBrakes@brakeType") for note in train.notes)


def test_train_of_version_3_with_a_fitted_resistance(saved_xml):
    train = load_train(saved_xml(STOCK_3))
    assert (train.name, train.mass_kg, train.length_m) == ("EMU", 130_000.0, 75.0)
    assert train.traction.effort_n(kmh_to_mps(110.0)) == pytest.approx(0.5 * (150e3 + 56.25e3))
    # The table is 2000 + 10·V + 0.3·V² N at its points.
    assert train.davis_a_n == pytest.approx(2000.0)
    assert train.davis_b_n_per_mps == pytest.approx(10.0 * 3.6)
    assert train.davis_c_n_per_mps2 == pytest.approx(0.3 * 12.96)
    assert not any("fitted" in note for note in train.notes)
    assert "no brakeEffort table, no meanDeceleration nor maxDeceleration: this train has no brake" in train.notes


def test_a_resistance_that_davis_does_not_meet_says_so(saved_xml):
    train = load_train(saved_xml(STOCK_3.replace('yValue="6"', 'yValue="5"')))
    assert any("fitted to a table; it is off by" in note for note in train.notes)
    assert min(train.davis_a_n, train.davis_b_n_per_mps, train.davis_c_n_per_mps2) >= 0.0


def test_brake_effort_and_caps(saved_xml):
    brake = """<vehicleBrakes><vehicleBrake><brakeEffort><valueTable yValueUnit="kN">
        <valueLine xValue="0"><values yValue="100"/></valueLine>
        </valueTable></brakeEffort></vehicleBrake></vehicleBrakes>"""
    table = STOCK_2[STOCK_2.index("<tractiveEffort>") : STOCK_2.index("</tractiveEffort>") + 17]
    text = STOCK_2.replace(table, "").replace('power="4000000"', 'power="4000000" maxTractEffort="250000"')
    train = load_train(saved_xml(text.replace("</engine>", f"</engine>{brake}")))
    assert train.traction == EffortCurve.from_caps(500e3, 8e6)
    assert train.braking == EffortCurve.from_points([(0.0, 200e3)])


def test_several_propulsions_are_asked_for(saved_xml):
    propulsion = STOCK_2[STOCK_2.index("<propulsion ") : STOCK_2.index("</propulsion>") + 13]
    second = propulsion.replace('id="ac"', 'id="dc"').replace('yValue="300"', 'yValue="200"')
    text = STOCK_2.replace("</engine>", f"{second}</engine>")
    assert refusal(load_train, saved_xml(text)) == "holds 2 trains, choose one as FILE#NAME: ic:ac, ic:dc"
    assert load_train(saved_xml(text, "#ic:ac")).traction.effort_n(0.0) == 600e3
    assert load_train(saved_xml(text, "#ic:dc")).traction.effort_n(0.0) == 400e3
    assert "choose one as FILE#NAME: ic:ac, ic:dc" in refusal(load_train, saved_xml(text, "#ic"))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('bruttoWeight="80"', "", "vehicle[1]@bruttoWeight: missing attribute (t), and so is tareWeight"),
        ('bruttoWeight="80"', 'bruttoWeight="-80"', "vehicle[1]@bruttoWeight: must be above 0 t, got '-80'"),
        ('vehicleRef="coach"', 'vehicleRef="wagon"', "vehicleRef[2]@vehicleRef: no vehicle 'wagon' in this file"),
        ('vehicleCount="6"', 'vehicleCount="1.5"', "@vehicleCount: must be a whole number of 1 to 1000 vehicles"),
        ('yValueUnit="kN"', 'yValueUnit="kp"', "valueTable: unknown unit 'kp' of force; known: N, kN"),
        ('xValue="72"', 'xValue="172"', "valueLine[3]@xValue: speeds must not decrease, got 144 km/h"),
        ('yValue="200"', 'yValue="-2"', "values@yValue: must be at least 0 kN, got -2 kN"),
        ("<trainResistance>", "<trainResistance/><other>", "file.xml"),
        ('massDependent="true"', "", ""),
        ('constantFactorA="1.5"', 'constantFactorA="60"', ""),
        ('speed="140"', "", "vehicle[2]@speed: missing attribute"),
        ('rotationMassFactor="1.2"', 'rotationMassFactor="0.2"', "rotationMassFactor: must be at least 1, got '0.2'"),
    ],
)  # fmt: skip
def test_errors_of_trains_name_line_element_and_attribute(saved_xml, old, new, message):
    text = STOCK_2.replace(old, new)
    if not message:
        assert load_train(saved_xml(text)).davis_a_n > 0.0
        return
    if message == "file.xml":
        text = text.replace("</trainResistance>", "</other>")
        message = "formation/trainResistance: missing element daviesFormula, valueTable or segmentTable"
    assert message in refusal(load_train, saved_xml(text))


def test_a_resistance_that_may_be_either_is_refused(saved_xml):
    either = STOCK_2.replace('massDependent="true"', "").replace('constantFactorA="1.5"', 'constantFactorA="60"')
    assert refusal(load_train, saved_xml(either)).endswith("massDependent: missing attribute: 60 may be N or N/kN")
    absolute = either.replace('constantFactorA="60"', 'constantFactorA="6000"')
    assert load_train(saved_xml(absolute)).davis_a_n == 6000.0


def test_a_file_with_a_line_and_a_train_is_a_scenario(saved_xml):
    stock = STOCK_2[STOCK_2.index("<rollingstock") : STOCK_2.index("</railml>")]
    one_way = LINE_2.replace('dir="down"', 'dir="up"').replace('id="s4" pos="10100"', 'id="s4" pos="9900"')
    name = saved_xml(one_way.replace("</railml>", f"{stock}</railml>"))
    scenario = load_scenario(name)
    assert (scenario.train.name, scenario.track.name, scenario.format) == ("IC", "Main", "railML 2.3")
    assert load_scenario(f"{name}#ic").track is None
    assert load_train(name).name == "IC"


def test_lines_of_fields_are_those_of_the_file(saved_xml, tmp_path):
    saved_xml(LINE_2)
    lines = lines_of(read_document(tmp_path / "file.xml"), "track", "t1:up")
    rows = LINE_2.splitlines()
    assert 'vMax="120"' in rows[lines["speed_limits[1]"] - 1]
    assert 'slope="-4.0"' in rows[lines["gradients[1]"] - 1]
    assert 'radius="-400"' in rows[lines["curves[1]"] - 1]
    saved_xml(STOCK_2)
    lines = lines_of(read_document(tmp_path / "file.xml"), "train", None)
    assert "<valueTable" in STOCK_2.splitlines()[lines["traction"] - 1]


@pytest.mark.parametrize("sample", SAMPLES)
def test_samples_are_described(saved_xml, sample):
    assert describe_file(saved_xml(SAMPLES[sample])).format.startswith("railML ")
