"""railML files of other tools, which leave out lengths and limits: what follows from the rest, what must be asked."""

import pytest

from tests.helpers.railml_line_case import BARE_2, BARE_3, BARE_NET, limits_kmh
from tests.helpers.refusal import refusal
from tgvdp.errors import InputError
from tgvdp.formats import load_scenario, load_track, load_train
from tgvdp.formats.railml.rows import LINE_SPEED_HINT
from tgvdp.units import kmh_to_mps

pytest.importorskip("lxml")


@pytest.mark.parametrize(
    ("name", "length_m"),
    [("alone", 510.0), ("rest", 800.5), ("reverse", 290.5), ("mileage", 700.0), ("together", 2000.0)],
)
def test_lengths_of_net_elements_follow_from_tracks_and_mileage(saved_xml, name, length_m):
    track = load_track(saved_xml(BARE_3, f"#{name}"), line_speed_mps=20.0)
    assert track.length_m == pytest.approx(length_m, abs=1e-9)
    assert track.speed_limits == ((0.0, pytest.approx(20.0)),)
    assert f"no speed section on {track.length_m:.12g} m: limit is the line speed asked for, 72 km/h" in track.notes


def test_a_mileage_that_is_not_in_metres_gives_no_length(saved_xml):
    text = BARE_3.replace('id="lps" units="m"', 'id="lps" units="Km"')
    message = refusal(load_track, saved_xml(text, "#mileage"), line_speed_mps=20.0)
    assert "netElement[4]@length: missing attribute (m), nor has a track on it alone a length" in message


def test_a_net_element_of_unknown_length_is_named(saved_xml):
    assert "netElement[6]@length: missing attribute" in refusal(load_track, saved_xml(BARE_3, "#unknown"))
    assert refusal(load_track, saved_xml(BARE_3, "#lost")).endswith("no net element 'null' in this file")


def test_what_lies_on_net_elements_known_only_together_is_an_error(saved_xml):
    section = """<speeds><speedSection maxSpeed="60"><linearLocation>
      <associatedNetElement netElementRef="ne5" posBegin="0" posEnd="100"/></linearLocation></speedSection></speeds>"""
    text = BARE_3.replace("<lines>", f"{section}<lines>")
    message = refusal(load_track, saved_xml(text, "#together"), line_speed_mps=20.0)
    assert message.endswith("net element 'ne5' has no length, only all of its track has one")
    on_known = section.replace("ne5", "ne1").replace('posEnd="100"', 'posEnd="400"')
    track = load_track(saved_xml(BARE_3.replace("<lines>", f"{on_known}<lines>"), "#together"), line_speed_mps=20.0)
    assert limits_kmh(track) == [(0.0, 60), (400.0, 72)]


def test_a_coarse_line_has_its_mileage_its_own_limit_and_says_what_it_does_not_see(saved_xml):
    section = """<speeds><speedSection maxSpeed="60"><linearLocation>
      <associatedNetElement netElementRef="ne1"/></linearLocation></speedSection></speeds>"""
    track = load_track(saved_xml(BARE_3.replace("<lines>", f"{section}<lines>"), "#line"), line_speed_mps=50.0)
    assert (track.length_m, track.stops_m) == (4300.0, (0.0, 300.0, 4300.0))
    assert limits_kmh(track) == [(0.0, 80)]
    assert track.notes[:3] == (
        "the line speed asked for, 180 km/h, changes nothing: there is a limit everywhere",
        "not used, as they lie on parts of the net elements, or on what these are parts of: speedSection (1)",
        "no speed section on 4300 m: limit is linePerformance@maxSpeed, 80 km/h",
    )


def test_temporary_limits_count_and_say_so(saved_xml):
    section = """<speeds><speedSection maxSpeed="20" isTemporary="true"><linearLocation>
      <associatedNetElement netElementRef="ne1"/></linearLocation></speedSection></speeds>"""
    track = load_track(saved_xml(BARE_3.replace("<lines>", f"{section}<lines>"), "#alone"))
    assert limits_kmh(track) == [(0.0, 20)]
    assert "temporary limits (1) count as any other" in track.notes


def test_no_limits_at_all_are_one_line_that_says_what_helps(saved_xml):
    assert refusal(load_track, saved_xml(BARE_3, "#alone")).endswith(
        f"track[1]: speed sections leave 510 m of 510 m without a limit: {LINE_SPEED_HINT}"
    )
    assert refusal(load_track, saved_xml(BARE_2, "#a")).endswith(
        f"track[1]: no speed limit from 0 m to 350 m of a: {LINE_SPEED_HINT}"
    )


def test_tracks_of_version_2_without_limits_are_found_by_namespace_and_run_at_the_line_speed(saved_xml):
    assert load_scenario(saved_xml(BARE_2, "#a"), line_speed_mps=kmh_to_mps(50.0)).format == "railML 2.2"
    assert limits_kmh(load_track(saved_xml(BARE_2, "#a"), line_speed_mps=kmh_to_mps(50.0))) == [(0.0, 50)]
    track = load_track(saved_xml(BARE_2, "#b"), line_speed_mps=kmh_to_mps(50.0))
    assert limits_kmh(track) == [(0.0, 50), (50.0, 60), (150.0, 50)]  # also from where a limit ends
    assert any("from there the line speed, 50 km/h, holds" in note for note in track.notes)
    assert [curve.position_m for curve in track.curves] == [0.0, 70.0]  # one place said twice


def test_two_values_at_one_place_stay_an_error(saved_xml):
    text = BARE_2.replace('<radiusChange pos="0" radius="0"/><radiusChange pos="0" radius="0"/>',
                          '<radiusChange pos="0" radius="0"/><radiusChange pos="0" radius="9"/>')  # fmt: skip
    message = refusal(load_track, saved_xml(text, "#b"), line_speed_mps=20.0)
    assert message.endswith(
        "@pos: a second radiusChange at the position of line 6, and another value, got radius '9' after radius '0'"
    )


def test_a_reference_to_attributes_of_the_infrastructure_is_no_speed_profile(saved_xml):
    changes = "".join(
        f'<speedChange pos="{pos}" dir="up" profileRef="at{pos}" vMax="{v}"/>' for pos, v in ((0, 90), (9, 80))
    )
    text = BARE_2.replace('<speedChange pos="50" dir="up" vMax="60"/>', changes)
    groups = '<infraAttrGroups><infraAttributes id="at0"/><infraAttributes id="at9"/></infraAttrGroups>'
    assert "no speed limit from 0 m to 150 m" in refusal(load_track, saved_xml(text, "#b"))
    track = load_track(saved_xml(text.replace("<tracks>", f"{groups}<tracks>"), "#b"))
    assert limits_kmh(track)[:2] == [(0.0, 90), (9.0, 80)]


def test_a_net_without_tracks_and_a_file_of_no_version_are_refused_in_one_line(saved_xml):
    message = refusal(load_track, saved_xml(BARE_NET))
    assert message == (
        "holds no track and no train: neither a track or line with a linearLocation over net elements, "
        "nor a formation or a vehicle with engine"
    )
    unknown = BARE_2.replace("schemas/2013", "schemas/1999")
    assert refusal(load_track, saved_xml(unknown)).endswith(
        "railml@version: missing attribute, and the namespace is that of no known version"
    )


def test_a_line_speed_where_limits_are_never_missing_is_refused(saved_xml, tmp_path):
    (tmp_path / "trip.toml").write_text('track = "flat-100km"')
    for name in ("flat-100km", str(tmp_path / "trip.toml")):
        with pytest.raises(InputError, match="native lines have a speed limit everywhere"):
            load_track(name, line_speed_mps=20.0)
    (tmp_path / "file.xml").write_text(BARE_2)
    (tmp_path / "trip.toml").write_text('track = "file.xml#a"')
    assert load_track(tmp_path / "trip.toml", line_speed_mps=20.0).length_m == 350.0
    with pytest.raises(InputError, match="line_speed must be above 0 m/s"):
        load_track(tmp_path / "trip.toml", line_speed_mps=0.0)


def test_a_formation_of_one_kind_of_engine_chooses_its_propulsion_once(saved_xml):
    stock = """<railml xmlns="http://www.railml.org/schemas/2013" version="2.2"><rollingstock><vehicles>
     <vehicle id="e" length="18" speed="130" bruttoWeight="74"><engine>
      <propulsion id="p1" maxTractEffort="100000" power="2000000"/>
      <propulsion id="p2" maxTractEffort="90000" power="1000000"/>
     </engine></vehicle>
     <vehicle id="w" length="161" speed="130" bruttoWeight="410"><wagon rotationMassFactor="1.06"/></vehicle></vehicles>
     <formations><formation id="f"><trainOrder><vehicleRef vehicleRef="e" vehicleCount="1"/>
      <vehicleRef vehicleRef="e" vehicleCount="1"/><vehicleRef vehicleRef="w" vehicleCount="1"/></trainOrder>
      <trainResistance><daviesFormula constantFactorA="5000"/></trainResistance></formation></formations>
     </rollingstock></railml>"""
    assert "f:p1, f:p2" in refusal(load_train, saved_xml(stock))
    train = load_train(saved_xml(stock, "#f:p1"))
    assert train.traction.effort_n(0.0) == 200_000.0
    assert train.rotating_mass_factor == pytest.approx(1 + 0.06 * 410 / 558)
