"""Limits of railML: which trains they are for, and what holds where one ends without another one."""

import pytest

from tests.helpers.railml_line_case import LINE_2, LINE_3, limits_kmh
from tests.helpers.refusal import refusal
from tgvdp.formats import load_track
from tgvdp.formats.railml.rows import LINE_SPEED_HINT
from tgvdp.units import kmh_to_mps

pytest.importorskip("lxml")


def line_2(*changes):
    """The track of 10 km from 100 m on with other speed changes: attributes of each."""
    first, last = LINE_2.index("<speedChanges>"), LINE_2.index("</speedChanges>")
    inside = "".join(f"\n<speedChange {change}/>" for change in changes)
    return LINE_2[:first] + f"<speedChanges>{inside}" + LINE_2[last:]


def up(*limits):
    """Speed changes at kilometres of the run."""
    return line_2(*(f'pos="{100 + 1000 * km}" dir="up" vMax="{limit}"' for km, limit in limits))


RESTORED = "{} speed changes end a limit (vMax end or 999.9): the one that it lowered holds again"


@pytest.mark.parametrize("end", ["end", "999.9"])
def test_where_a_restriction_ends_the_limit_before_it_holds_again(saved_xml, end):
    track = load_track(saved_xml(up((0, 120), (3, 60), (5, end))))
    assert limits_kmh(track) == [(0.0, 120), (3000.0, 60), (5000.0, 120)]
    assert RESTORED.format(1) in track.notes


def test_restrictions_within_each_other_end_one_by_one(saved_xml):
    track = load_track(saved_xml(up((0, 120), (1, 80), (2, 60), (3, "end"), (4, "end"), (5, 100), (6, "end"))))
    assert limits_kmh(track) == [
        (0.0, 120), (1000.0, 80), (2000.0, 60), (3000.0, 80), (4000.0, 120), (5000.0, 100), (6000.0, 120),
    ]  # fmt: skip
    assert RESTORED.format(3) in track.notes


def test_a_restriction_that_changes_ends_as_one(saved_xml):
    track = load_track(saved_xml(up((0, 120), (1, 60), (2, 80), (3, "end"))))
    assert limits_kmh(track) == [(0.0, 120), (1000.0, 60), (2000.0, 80), (3000.0, 120)]


def test_a_limit_that_begins_where_another_ends_holds(saved_xml):
    track = load_track(saved_xml(up((0, 120), (3, 60), (5, "end"), (5, 90), (7, "end"))))
    assert limits_kmh(track) == [(0.0, 120), (3000.0, 60), (5000.0, 90), (7000.0, 120)]


@pytest.mark.parametrize("limits", [((0, 90), (3, 120), (9, "end")), ((0, 90), (9, "end")), ((0, "end"),)])
def test_a_limit_that_ends_and_lowered_none_is_refused_unless_there_is_a_line_speed(saved_xml, limits):
    name = saved_xml(up(*limits))
    message = refusal(load_track, name)
    assert message.endswith(
        "ends a limit that lowered none before it, and does not say what holds from there: " + LINE_SPEED_HINT
    )
    assert message.startswith("line 5, ")
    track = load_track(name, line_speed_mps=kmh_to_mps(100.0))
    assert limits_kmh(track)[-1] == (1000.0 * limits[-1][0], 100)
    assert any("lowered none (vMax end or 999.9): from there the line speed, 100 km/h" in note for note in track.notes)


def test_an_end_at_the_end_of_the_track_asks_for_nothing(saved_xml):
    assert limits_kmh(load_track(saved_xml(up((0, 90), (10, "end"))))) == [(0.0, 90)]


def test_a_restriction_may_end_on_the_next_track(saved_xml):
    text = up((0, 120), (8, 60))
    second = up((1, "end"))
    second = second[second.index("<track ") : second.index("</track>") + len("</track>")].replace('id="t1"', 'id="t2"')
    track = load_track(saved_xml(text.replace("</tracks>", f"{second}</tracks>"), "#t1:up+t2:up"))
    assert limits_kmh(track) == [(0.0, 120), (8000.0, 60), (11_000.0, 120)]


def categories(attribute):
    return line_2(
        'pos="100" dir="up" vMax="90"',
        f'pos="100" dir="up" vMax="120" {attribute}="1"',
        f'pos="3100" dir="up" vMax="100" {attribute}="1"',
        f'pos="100" dir="up" vMax="140" {attribute}="2"',
    )


@pytest.mark.parametrize("attribute", ["etcsTrainCategory", "trainCategory", "profileRef"])
def test_limits_of_train_categories_are_not_mixed(saved_xml, attribute):
    name = saved_xml(categories(attribute))
    for_all = load_track(f"{name}#t1:up")
    assert limits_kmh(for_all) == [(0.0, 90)]
    others = "speedChanges of other profiles or train categories are not used: "
    assert f"{others}1 (2), 2 (1)" in for_all.notes
    first = load_track(f"{name}#t1:up:1")
    assert limits_kmh(first) == [(0.0, 120), (3000.0, 100)]
    assert f"{others}2 (1), all trains (1)" in first.notes
    assert limits_kmh(load_track(f"{name}#t1:up:2")) == [(0.0, 140)]
    assert refusal(load_track, f"{name}#t1:up:3").endswith("choose one as FILE#NAME: t1, t1:up:1, t1:up:2")


def test_categories_within_a_profile_are_not_mixed(saved_xml):
    text = line_2(
        'pos="100" dir="up" vMax="120" profileRef="p" etcsTrainCategory="1"',
        'pos="100" dir="up" vMax="140" profileRef="p" etcsTrainCategory="2"',
    )
    assert refusal(load_track, saved_xml(text)) == "holds 2 tracks, choose one as FILE#NAME: t1:up:p/1, t1:up:p/2"
    assert limits_kmh(load_track(saved_xml(text, "#t1:up:p/2"))) == [(0.0, 140)]


def test_notes_of_other_profiles_leave_out_the_other_direction(saved_xml):
    text = LINE_2.replace("</speedChanges>", '<speedChange pos="100" dir="up" vMax="1" profileRef="p"/></speedChanges>')
    assert not any("other profiles" in note for note in load_track(saved_xml(text, "#t1:down")).notes)


def sections_3(*profiles):
    """Limits on all of the line: 120 km/h for all, and another one for each profile."""
    made = "".join(
        f"""<speedSection id="p{index}" maxSpeed="{kmh}">
          <linearLocation><associatedNetElement netElementRef="ne1"/></linearLocation>
          <validForSpeedProfile ref="{profile}"/></speedSection>"""
        for index, (profile, kmh) in enumerate(profiles)
    )
    return LINE_3.replace("</speeds>", f"{made}</speeds>")


def test_sections_of_version_3_for_some_trains_are_not_limits_for_all(saved_xml):
    name = saved_xml(sections_3(("freight", 60), ("tilt", 100)))
    for_all = load_track(f"{name}#t1:normal")
    assert limits_kmh(for_all) == [(0.0, 90), (3000.0, 120)]
    assert "speedSections of other profiles or train categories are not used: freight (1), tilt (1)" in for_all.notes
    # Those for all trains count for those of a profile, too.
    assert limits_kmh(load_track(f"{name}#t1:normal:freight")) == [(0.0, 60), (4000.0, 120)]
    assert limits_kmh(load_track(f"{name}#t1:normal:tilt")) == [(0.0, 90), (3000.0, 100), (4000.0, 120)]
    assert "t1:normal:freight" in refusal(load_track, f"{name}#t1:normal:mail")


def test_a_section_may_be_valid_for_several_profiles(saved_xml):
    both = '<validForSpeedProfile ref="freight"/><validForSpeedProfile ref="mail"/>'
    text = sections_3(("freight", 60)).replace('<validForSpeedProfile ref="freight"/>', both)
    for profile in ("freight", "mail"):
        assert limits_kmh(load_track(saved_xml(text, f"#t1:normal:{profile}")))[0] == (0.0, 60)


def uncovered(*profiles):
    """Limits for all that leave the second net element without one."""
    return sections_3(*profiles).replace('<associatedNetElement netElementRef="ne2"/>', "", 1)


def test_the_only_profile_counts_where_limits_for_all_leave_gaps(saved_xml):
    one = uncovered(("freight", 60)).replace(
        '"ne1"/></linearLocation>\n          <valid', '"ne2"/></linearLocation><valid'
    )
    track = load_track(saved_xml(one))
    assert limits_kmh(track) == [(0.0, 90), (3000.0, 120), (4000.0, 60)]
    assert "speedSections for the trains of freight (1) count, beside those for all" in track.notes
    covered = load_track(saved_xml(sections_3(("freight", 60)), "#t1:normal"))  # with no gap it does not
    assert limits_kmh(covered) == [(0.0, 90), (3000.0, 120)]


def test_limits_that_are_given_for_profiles_alone_name_these(saved_xml):
    message = refusal(load_track, saved_xml(uncovered(("freight", 60), ("tilt", 100)), "#t1:normal"))
    assert message.endswith(f"{LINE_SPEED_HINT}, or choose a speed profile: freight, tilt")


@pytest.mark.parametrize("kind", ["clothoide", "cosinusoide", "curveBloss", "curveWiener", "sinusoide", "doucine"])
def test_transitions_of_the_schema_are_known(saved_xml, kind):
    text = LINE_3.replace('curveType="clothoid"', f'curveType="{kind}" radius="7"')
    track = load_track(saved_xml(text))
    assert track == load_track(saved_xml(LINE_3))
    assert any("horizontalCurve@radius" in note for note in track.notes if note.startswith("not used: "))


def test_where_limits_of_3_x_end_for_head_or_tail_is_told(saved_xml):
    text = LINE_3.replace("<speedSection ", '<speedSection endPointValidity="noTrainLengthDelay" ', 1)
    told = "limits end with no endPointValidity, noTrainLengthDelay: choose limits for head or tail"
    assert any(note.startswith(told) for note in load_track(saved_xml(text)).notes)
    assert not any("limits end with" in note for note in load_track(saved_xml(LINE_3)).notes)


def test_limits_of_drafts_of_3_1_have_the_name_that_they_have_in_2_x(saved_xml):
    draft = load_track(saved_xml(LINE_3.replace(" maxSpeed=", " vMax=")))
    assert draft == load_track(saved_xml(LINE_3))


def test_a_limit_that_begins_at_the_end_of_a_track_holds_on_the_next_one(saved_xml):
    first = up((0, 120), (10, 60))
    bare = first[first.index("<track ") : first.index("</track>") + 8].replace('id="t1"', 'id="t2"')
    bare = bare[: bare.index("<speedChanges>")] + bare[bare.index("</speedChanges>") + 15 :]
    track = load_track(saved_xml(first.replace("</tracks>", f"{bare}</tracks>"), "#t1:up+t2:up"))
    assert limits_kmh(track) == [(0.0, 120), (10_000.0, 60)]
    own = bare.replace(
        "<gradientChanges>", '<speedChanges><speedChange pos="100" vMax="80"/></speedChanges><gradientChanges>'
    )
    track = load_track(saved_xml(first.replace("</tracks>", f"{own}</tracks>"), "#t1:up+t2:up"))
    assert limits_kmh(track) == [(0.0, 120), (10_000.0, 80)]
    assert limits_kmh(load_track(saved_xml(first))) == [(0.0, 120)]
