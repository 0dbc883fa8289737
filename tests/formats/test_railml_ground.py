"""Gradients, curves and tunnels of railML 3 are there in both directions; what a vertical curve leaves open follows."""

import math

import pytest

from tests.helpers.railml_line_case import LINE_3
from tests.helpers.refusal import refusal
from tgvdp.formats import load_track
from tgvdp.model.track import Curve, NeutralSection

pytest.importorskip("lxml")

#: The ground as those write it who give all that is on a track one direction.
NORMAL_GROUND = (
    LINE_3.replace('id="l1" applicationDirection="both"', 'id="l1" applicationDirection="normal"')
    .replace('id="l2" applicationDirection="both"', 'id="l2" applicationDirection="normal"')
    .replace('id="l4"', 'id="l4" applicationDirection="normal"')
    .replace('id="l7"', 'id="l7" applicationDirection="normal"')
)


@pytest.mark.parametrize("direction", ["normal", "reverse"])
def test_ground_of_one_direction_is_that_of_both(saved_xml, direction):
    given = load_track(saved_xml(NORMAL_GROUND, f"#t1:{direction}"))
    both = load_track(saved_xml(LINE_3, f"#t1:{direction}"))
    assert given == both
    assert given.notes == both.notes


def test_ground_against_its_direction_is_turned_round(saved_xml):
    track = load_track(saved_xml(NORMAL_GROUND, "#t1:reverse"))
    assert track.gradients == ((0.0, 4.0), (6000.0, 4.0), (8000.0, -5.0))
    assert track.curves[1] == Curve(8500.0, -400.0, -400.0)


def curve(name, permil, direction, begin_m, end_m):
    return f"""<gradientCurve id="{name}" gradient="{permil}" curveType="straight">
      <linearLocation applicationDirection="{direction}">
       <associatedNetElement netElementRef="ne1" posBegin="{begin_m}" posEnd="{end_m}"/>
      </linearLocation></gradientCurve>"""


def test_a_description_of_the_direction_of_the_run_counts_before_that_of_the_other(saved_xml):
    curves = curve("up", 3.0, "normal", 0, 4000) + curve("down", 7.0, "reverse", 1000, 2500)
    first, last = LINE_3.index("<gradientCurve "), LINE_3.index("</gradientCurves>")
    text = LINE_3[:first] + curves + LINE_3[last:]
    assert load_track(saved_xml(text, "#t1:normal")).gradients == ((0.0, 3.0), (4000.0, 0.0))
    # Seen from the other end: level, then the rest of one, the other, and the rest of the first again.
    assert load_track(saved_xml(text, "#t1:reverse")).gradients == (
        (0.0, 0.0), (6000.0, -3.0), (7500.0, -7.0), (9000.0, -3.0),
    )  # fmt: skip


def test_descriptions_of_one_direction_that_overlap_stay_an_error(saved_xml):
    curves = curve("one", 3.0, "normal", 0, 3000) + curve("other", 7.0, "normal", 2000, 4000)
    first, last = LINE_3.index("<gradientCurve "), LINE_3.index("</gradientCurves>")
    text = LINE_3[:first] + curves + LINE_3[last:]
    for direction in ("normal", "reverse"):
        message = refusal(load_track, saved_xml(text, f"#t1:{direction}"))
        assert message.endswith("overlaps the gradientCurve before it by 1000 m of the run")


def test_a_transition_stays_one_between_its_neighbours_on_the_way_back(saved_xml):
    track = load_track(saved_xml(NORMAL_GROUND, "#t1:reverse"))
    assert track.curves[2] == Curve(9000.0, -400.0, math.inf)


def vertical(attributes, begin_m, end_m):
    return f"""<gradientCurve id="at{begin_m}" curveType="arc" {attributes}><linearLocation>
       <associatedNetElement netElementRef="ne1" posBegin="{begin_m}" posEnd="{end_m}"/>
      </linearLocation></gradientCurve>"""


def with_gradients(*curves):
    first, last = LINE_3.index("<gradientCurve "), LINE_3.index("</gradientCurves>")
    return LINE_3[:first] + "".join(curves) + LINE_3[last:]


@pytest.mark.parametrize(
    ("given", "permil"),
    [
        ("", 4.5),  # between 10 and -1
        ('deltaGradient="-11" radius="36363"', 4.5),
        ('gradient="10" deltaGradient="-11"', 4.5),
    ],
)
def test_a_vertical_curve_without_a_gradient_links_its_neighbours(saved_xml, given, permil):
    curves = [
        curve("rise", 10.0, "both", 0, 1000),
        vertical(given, 1000, 1400),
        curve("fall", -1.0, "both", 1400, 4000),
    ]
    text = with_gradients(*curves)
    rows = load_track(saved_xml(text, "#t1:normal")).gradients
    assert rows == ((0.0, 10.0), (1000.0, permil), (1400.0, -1.0), (4000.0, 0.0))
    rows = load_track(saved_xml(text, "#t1:reverse")).gradients
    assert rows == ((0.0, 0.0), (6000.0, 1.0), (8600.0, -permil), (9000.0, -10.0))


def test_vertical_curves_in_a_row_follow_from_the_one_before(saved_xml):
    rise, fall = curve("rise", 10.0, "both", 0, 1000), curve("fall", -1.0, "both", 1800, 4000)
    text = with_gradients(rise, vertical('radius="40000"', 1000, 1400), vertical("", 1400, 1800), fall)
    assert load_track(saved_xml(text, "#t1:normal")).gradients[1:3] == ((1000.0, 5.0), (1400.0, -0.5))
    lonely = with_gradients(rise, vertical('deltaGradient="4"', 1000, 1400))
    assert load_track(saved_xml(lonely, "#t1:normal")).gradients[1] == (1000.0, 12.0)
    assert load_track(saved_xml(lonely, "#t1:reverse")).gradients[1] == (8600.0, -12.0)
    for unknown in (with_gradients(rise, vertical("", 1000, 1400)), with_gradients(vertical('radius="9"', 10, 20))):
        assert refusal(load_track, saved_xml(unknown, "#t1:normal")).endswith(
            "@gradient: missing attribute (‰), and it does not follow from the gradientCurves next to it"
        )


def test_tunnels_of_3_3_have_a_cross_section(saved_xml):
    tunnel = LINE_3[LINE_3.index("<overCrossing ") : LINE_3.index("</overCrossing>")]
    text = LINE_3.replace(tunnel, tunnel + '<tunnelResistance crossSection="52"/>')
    bare, track = load_track(saved_xml(LINE_3, "#t1:normal")), load_track(saved_xml(text, "#t1:normal"))
    (made,) = track.tunnels
    assert (made.length_m, made.cross_section_m2) == (200.0, 52.0)
    assert not any("tunnels (" in note for note in track.notes)
    assert bare.tunnels == ()
    (turned,) = load_track(saved_xml(text, "#t1:reverse")).tunnels
    assert turned.position_m == pytest.approx(10_000.0 - 200.0 - made.position_m)


def separation(attributes, insulated="true"):
    section = f"""<electrifications><electrificationSection isInsulatedSection="{insulated}" contactLineType="overhead">
      <linearLocation applicationDirection="both">
       <associatedNetElement netElementRef="ne1" posBegin="1500" posEnd="1620"/></linearLocation>
      <phaseSeparationSection lengthPhaseSeparation="100" {attributes}/>
     </electrificationSection></electrifications></functionalInfrastructure>"""
    return LINE_3.replace("</functionalInfrastructure>", section)


UNREAD = "traction current is taken to be everywhere: electrificationSection (1)"


@pytest.mark.parametrize(
    ("attributes", "lowered"), [('switchOffBreaker="true"', False), ('switchOffBreaker="1" lowerPantograph="1"', True)]
)
def test_insulated_sections_passed_without_current_are_neutral(saved_xml, attributes, lowered):
    name = saved_xml(separation(attributes))
    track = load_track(f"{name}#t1:normal")
    assert track.neutral_sections == (NeutralSection(1500.0, 120.0, lowered),)
    assert load_track(f"{name}#t1:reverse").neutral_sections == (NeutralSection(8380.0, 120.0, lowered),)
    assert not any(UNREAD in note for note in track.notes)


@pytest.mark.parametrize(("attributes", "insulated"), [("", "true"), ('switchOffBreaker="true"', "false")])
def test_separations_without_a_place_or_an_order_are_told(saved_xml, attributes, insulated):
    track = load_track(saved_xml(separation(attributes, insulated), "#t1:normal"))
    assert track.neutral_sections == ()
    assert any(UNREAD in note for note in track.notes)
