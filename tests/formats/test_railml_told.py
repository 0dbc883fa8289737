"""What a railML file says that no run can use, or that can be read in two ways, is told or refused."""

import pytest

from tests.helpers.railml_line_case import LINE_2, LINE_3, limits_kmh
from tests.helpers.railml_stock_case import STOCK_2
from tests.helpers.refusal import refusal
from tgvdp.formats import load_track, load_train
from tgvdp.units import kmh_to_mps

pytest.importorskip("lxml")


def systems(*anchors):
    """A mileage with anchors: measures, and how far it is to the next one."""
    inside = "".join(f'<anchor measure="{at}" measureToNext="{on}"/>' for at, on in anchors)
    return f"""<common id="co"><positioning><linearPositioningSystems>
      <linearPositioningSystem id="lps" units="m">{inside}</linearPositioningSystem>
     </linearPositioningSystems></positioning></common>"""


@pytest.mark.parametrize(
    "anchors",
    [((1000, 1500), (2500, 0), (2600, 2400), (5000, 0)), ((1000, 1600), (2600, 0), (2500, 2500), (5000, 0))],
    ids=["gap", "overlap"],
)
def test_a_place_by_a_mileage_that_jumps_is_refused(saved_xml, anchors):
    text = LINE_3.replace('<common id="co"/>', systems(*anchors))
    message = refusal(load_track, saved_xml(text))
    assert "linearCoordinateBegin@measure: mileage of its net element jumps at 2550 (line " in message
    assert message.endswith("give pos or intrinsicCoord")
    even = ((1000, 1000), (2000, 3000), (5000, 0))
    assert load_track(saved_xml(LINE_3.replace('<common id="co"/>', systems(*even)))) == load_track(saved_xml(LINE_3))


def test_a_mileage_change_on_a_net_element_is_a_jump_of_its_mileage(saved_xml):
    change = """<mileageChanges><mileageChange id="mc" type="gap">
      <spotLocation netElementRef="ne1"><linearCoordinate positioningSystemRef="lps" measure="2500"/></spotLocation>
     </mileageChange></mileageChanges>"""
    text = LINE_3.replace("<operationalPoints>", f"{change}<operationalPoints>")
    assert "jumps at 2500 (line " in refusal(load_track, saved_xml(text))
    assert load_track(saved_xml(text.replace('="ne1"><linearC', '="ne2"><linearC'))) == load_track(saved_xml(LINE_3))


def test_no_length_follows_from_a_mileage_that_jumps(saved_xml):
    text = LINE_3.replace('id="ne1" length="4000"', 'id="ne1"').replace('<common id="co"/>', systems((1000, 4000)))
    assert load_track(saved_xml(text)).length_m == 10_000.0
    jumping = text.replace(systems((1000, 4000)), systems((1000, 1500), (2500, 0), (2600, 2400), (5000, 0)))
    assert "netElement[1]@length: missing attribute (m)" in refusal(load_track, saved_xml(jumping))


def known(*points):
    return "".join(
        f"""<intrinsicCoordinate intrinsicCoord="{share}">
         <linearCoordinate positioningSystemRef="lps" measure="{measure}"/></intrinsicCoordinate>"""
        for share, measure in points
    )


def with_points(*points):
    first, last = LINE_3.index("<intrinsicCoordinate "), LINE_3.index("</associatedPositioningSystem>")
    return LINE_3[:first] + known(*points) + LINE_3[last:]


def test_places_by_mileage_lie_between_the_coordinates_next_to_them(saved_xml):
    # The first half of the net element has 1 km of mileage, a gap of 1 km follows, the second half has 2 km.
    text = with_points((0, 1000), (0.5, 2000), (0.5, 3000), (1, 5000))
    assert limits_kmh(load_track(saved_xml(text))) == [(0.0, 90), (3000.0, 120)]
    within = text.replace('measure="4000"/>', 'measure="2400"/>')  # in the gap: where it is
    assert limits_kmh(load_track(saved_xml(within))) == [(0.0, 90), (2000.0, 120)]


def test_an_intrinsic_coordinate_beyond_its_net_element_is_refused(saved_xml):
    assert refusal(load_track, saved_xml(with_points((0, 1000), (5, 5000)))).endswith(
        "intrinsicCoordinate[2]@intrinsicCoord: must be at most 1, got '5'"
    )


def test_tracks_of_version_3_are_called_by_their_names_too(saved_xml):
    named = '<name name="Main" language="en"/>'
    assert named in LINE_3
    text = LINE_3.replace(named, f'{named}<name name="Hauptgleis" language="de"/>')
    for name in ("t1", "Main", "Hauptgleis", "Main:normal"):
        assert load_track(saved_xml(text, f"#{name}")).name == "Main"
    assert refusal(load_track, saved_xml(text, "#Nebengleis")) == "holds no track 'Nebengleis'; known: t1"


def test_a_mileage_that_is_there_twice_is_refused(saved_xml):
    text = with_points((0, 1000), (0.5, 4500), (0.5, 3500), (1, 5000))
    assert refusal(load_track, saved_xml(text)).endswith("@measure: is the mileage of two places of its net element")


def test_ground_on_net_elements_that_those_of_the_run_are_parts_of_is_told(saved_xml):
    coarse = """<netElement id="line" length="10000"><elementCollectionOrdered>
      <elementPart ref="ne1" sequence="1"/><elementPart ref="ne2" sequence="2"/>
     </elementCollectionOrdered></netElement></netElements>"""
    curve = """<gradientCurve id="gc3" gradient="9" curveType="straight"><linearLocation>
      <associatedNetElement netElementRef="line"/></linearLocation></gradientCurve></gradientCurves>"""
    text = LINE_3.replace("</netElements>", coarse).replace("</gradientCurves>", curve)
    told = "or on what these are parts of: gradientCurve (1)"
    assert any(note.endswith(told) for note in load_track(saved_xml(text)).notes)
    # One that is on the run as well is used, and not told.
    both = text.replace('Ref="line"/>', 'Ref="line"/></linearLocation><linearLocation><associatedNetElement '
                        'netElementRef="ne1" posBegin="0" posEnd="1"/>')  # fmt: skip
    assert "overlaps the gradientCurve before it" in refusal(load_track, saved_xml(both))


def test_what_lies_on_the_run_as_an_area_is_told(saved_xml):
    area = """<areaLocation><associatedNetElement netElementRef="{}"/></areaLocation>"""
    section = f'<speedSection maxSpeed="10">{area.format("ne1")}</speedSection></speeds>'
    point = f'<operationalPoint id="op9">{area.format("ne2")}</operationalPoint></operationalPoints>'
    other = f'<operationalPoint id="op8">{area.format("ne8")}</operationalPoint></operationalPoints>'
    text = LINE_3.replace("</speeds>", section).replace("</operationalPoints>", point)
    text = text.replace("</operationalPoints>", other)
    assert (
        "not used, as they have no location of a kind that places them: speedSection (1), operationalPoint (1)"
        in load_track(saved_xml(text)).notes
    )


def test_electrification_of_the_run_is_told(saved_xml):
    place = '<linearLocation><associatedNetElement netElementRef="ne1"/></linearLocation>'
    section = f'<electrificationSection contactLineType="overhead">{place}</electrificationSection>'
    area = f'<restrictionArea type="lowerPantograph">{place}</restrictionArea>'
    text = LINE_3.replace(
        "<overCrossings>",
        f"<electrifications>{section}</electrifications><restrictionAreas>{area}</restrictionAreas><overCrossings>",
    )
    told = (
        "not used, so that traction current is taken to be everywhere: electrificationSection (1), restrictionArea (1)"
    )
    assert told in load_track(saved_xml(text)).notes
    assert (
        told
        not in load_track(
            saved_xml(text.replace('Ref="ne1"/></linearLocation></', 'Ref="x"/></linearLocation></'))
        ).notes
    )


def test_a_direction_that_may_be_that_of_the_location_or_of_the_net_element_is_told(saved_xml):
    text = LINE_3.replace(
        'id="l5" applicationDirection="both">\n      <associatedNetElement netElementRef="ne1" keepsOrientation="true"',
        'id="l5" applicationDirection="normal"><associatedNetElement netElementRef="ne1" keepsOrientation="false"',
    )
    told = "applicationDirection of speedSections (1) is taken along their location"
    assert any(note.startswith(told) for note in load_track(saved_xml(text, "#t1:reverse")).notes)
    assert not any(note.startswith("applicationDirection") for note in load_track(saved_xml(LINE_3)).notes)


def two_tracks(first_end, second_begin, second=LINE_2):
    """Two tracks, with what is said of the end of the one and the beginning of the other."""
    other = second[second.index("<track ") : second.index("</track>") + len("</track>")]
    other = other.replace('id="t1" name="Main"', 'id="t2" name="Branch"')
    other = other.replace('<openEnd id="oe1"/>', second_begin)
    return LINE_2.replace('<openEnd id="oe2"/>', first_end).replace("</tracks>", f"{other}</tracks>")


APART = "Main and Branch follow each other, but the file has no connection of their ends"


@pytest.mark.parametrize(
    ("first_end", "second_begin", "told"),
    [
        ('<connection id="c1" ref="c2"/>', '<connection id="c2" ref="c1"/>', False),
        ('<connection id="c1" ref="c2"/>', '<connection id="c4" ref="c3"/>', True),
        ('<openEnd id="o"/>', '<connection id="c4" ref="c3"/>', False),
        ('<macroscopicNode ocpRef="halt"/>', '<macroscopicNode ocpRef="halt"/>', False),
        ('<connection id="c1" ref="s1"/>', "<openEnd/>", False),
    ],
)
def test_tracks_that_do_not_join_are_told(saved_xml, first_end, second_begin, told):
    track = load_track(saved_xml(two_tracks(first_end, second_begin), "#t1:up+t2:up"))
    assert (APART in track.notes) == told


def test_tracks_join_by_a_switch_at_their_ends(saved_xml):
    text = two_tracks('<connection id="c1" ref="s1"/>', '<connection id="c9" ref="c8"/>')
    switch = (
        '<connections><switch id="sw" pos="{}"><connection id="s1" ref="c1"/></switch></connections><crossSections>'
    )
    start = text.index('id="t2"')
    at_start = text[:start] + text[start:].replace("<crossSections>", switch.format(100), 1)
    assert APART not in load_track(saved_xml(at_start, "#t1:up+t2:up")).notes
    halfway = text[:start] + text[start:].replace("<crossSections>", switch.format(5000), 1)
    assert APART in load_track(saved_xml(halfway, "#t1:up+t2:up")).notes


def test_a_track_without_ground_after_one_with_is_told(saved_xml):
    bare = LINE_2.replace("<gradientChange ", "<other ").replace("<radiusChange ", "<other ")
    track = load_track(saved_xml(two_tracks("<openEnd/>", "<openEnd/>", bare), "#t1:up+t2:up"))
    assert {"no gradients on Branch: taken as level", "no curves on Branch: taken as straight"} <= set(track.notes)


def test_an_efficiency_that_some_vehicles_do_not_give_is_told(saved_xml):
    second = STOCK_2[STOCK_2.index('<vehicle id="loco"') : STOCK_2.index("</vehicle>") + 10]
    second = second.replace('"loco"', '"tail"').replace('totalTractEfficiency="0.85"', "")
    text = STOCK_2.replace("<vehicles>", f"<vehicles>{second}")
    text = text.replace("</trainOrder>", '<vehicleRef vehicleRef="tail"/></trainOrder>')
    train = load_train(saved_xml(text))
    assert train.traction_efficiency == 0.85
    assert "totalTractEfficiency 0.85 counts for all vehicles, some of which give none" in train.notes


def test_a_formation_that_is_faster_than_a_vehicle_is_told(saved_xml):
    train = load_train(saved_xml(STOCK_2.replace('<formation id="ic"', '<formation speed="200" id="ic"')))
    assert train.max_speed_mps == kmh_to_mps(200.0)
    assert "speed of the formation, 200 km/h, is above that of a vehicle, 140 km/h" in train.notes


def test_an_engine_without_effort_beside_others_is_told(saved_xml):
    engine = '<engine><propulsion power="1"/></engine>'
    bare = f'<vehicle id="helper" length="20" speed="160" bruttoWeight="80">{engine}</vehicle>'
    text = STOCK_2.replace("<vehicles>", f"<vehicles>{bare}")
    text = text.replace("</trainOrder>", '<vehicleRef vehicleRef="helper"/></trainOrder>')
    assert "engines of helper give no effort: they drive nothing" in load_train(saved_xml(text)).notes


def test_a_name_of_several_tracks_does_not_choose_one(saved_xml):
    text = two_tracks("<openEnd/>", "<openEnd/>").replace('name="Branch"', 'name="Main"')
    assert refusal(load_track, saved_xml(text, "#Main:up")) == (
        "holds 2 tracks of the name 'Main', choose one by its id: t1, t2"
    )
    named = text.replace('id="t2" name="Main"', 'id="Main" name="Main"')
    assert load_track(saved_xml(named, "#Main:up")).length_m == 10_000.0  # an id goes before names
