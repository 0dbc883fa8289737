"""Speed limits of SFERA journeys: profiles, categories of trains, restrictions, and Swiss line speeds."""

import re
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.sfera_case import JOURNEY, edited, limits_of, message, swiss
from tgvdp.errors import InputError
from tgvdp.formats import load_track
from tgvdp.formats.sfera.segments import Cap, lowest

pytest.importorskip("lxml")


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9), st.integers(1, 4))))
def test_the_lowest_of_several_values_holds(given_caps):
    caps = [Cap(float(min(a, b)), float(max(a, b)), float(value)) for a, b, value in given_caps]
    rows = lowest(caps, 8.0)
    assert rows[0][0] == 0.0
    assert all(one[1] != other[1] and one[0] < other[0] < 8.0 for one, other in pairwise(rows))
    for at in (0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5):
        held = [cap.value for cap in caps if cap.from_m < at < cap.to_m]
        assert [value for from_m, value in rows if from_m < at][-1] == min(held, default=None)


def test_without_limits_a_line_speed_runs(saved_xml):
    text = re.sub(r"<StaticSpeedProfile>.*?</StaticSpeedProfile>", "", message(), flags=re.DOTALL)
    with pytest.raises(InputError, match="no speed limit from 0 m to 10000 m of the journey: --line-speed KMH"):
        load_track(saved_xml(text))
    track = load_track(saved_xml(text), line_speed_mps=30.0)
    assert limits_of(track) == [(0, 108), (3500, 50), (4500, 108)]
    assert track.notes[0] == "no limit on 10000 m: limit is the line speed asked for, 108 km/h"


@pytest.mark.parametrize(
    ("train", "kmh"),
    [
        ("", 90),
        ('NC_CDTrain="150mm"', 110),  # that of the highest category up to its own
        ('NC_CDTrain="80mm"', 90),
        ('NC_Train="Freight_Train_G_Position" NC_CDTrain="150mm"', 70),
        ('trainCategoryCode="T" NC_CDTrain="150mm"', 130),
        ('trainCategoryCode="T" NC_Train="Freight_Train_G_Position"', 70),
    ],
)
def test_speeds_for_categories_of_trains(saved_xml, train, kmh):
    specific = "".join(
        f'<SpecificSSP specific_SSP_Category="{kind}" V_DIFF="{speed}">{inner}</SpecificSSP>'
        for kind, speed, inner in (
            ("Cant_Deficiency_SSP", 100, '<CantDeficiencySSP SSP_NC_CDDIFF="100mm"/>'),
            ("Cant_Deficiency_SSP", 110, '<CantDeficiencySSP SSP_NC_CDDIFF="130mm"/>'),
            ("Other_SSP_Noreplace_CDSSP", 70, '<OtherSpecificSSP SSP_NC_DIFF="Freight_Train_G_Position"/>'),
            ("Other_SSP_Replaces_CDSSP", 130, '<OtherSpecificSSP trainCategoryCode="T"/>'),
        )
    )
    text = edited(
        ('SSP_Speed="90" SSP_Front="false"/>', f'SSP_Speed="90">{specific}</StaticSpeedProfileStart>'),
        ('trainLength="100"', f'trainLength="100" {train}'),
    )
    assert limits_of(load_track(saved_xml(text)))[0] == (0, kmh)


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ('startLocation="500" startEndQualifier="Starts"', 'endLocation="900" startEndQualifier="Ends"', (500, 900)),
        ('startEndQualifier="WholeSP"', 'endLocation="900" startEndQualifier="Ends"', (0, 4000)),
        ('startLocation="500" endLocation="900" startEndQualifier="StartsEnds"', None, (500, 900)),
        ('endLocation="900" startEndQualifier="Ends"', None, (0, 900)),
    ],
)
def test_restrictions_that_start_and_end_in_a_segment(saved_xml, first, second, expected):
    speed = '<AdditionalSpeedRestriction ASR_Speed="30"/>'
    one, other = (
        f'<TemporaryConstraints {ends} temporaryConstraintType="ASR">{speed}</TemporaryConstraints>' if ends else ""
        for ends in (first, second)
    )
    found = re.search(r"<TemporaryConstraints.*?</TemporaryConstraints>", JOURNEY, re.DOTALL)[0]
    rows = limits_of(load_track(saved_xml(edited((found, one + other)))))
    slow = [at for at, kmh in rows if kmh == 30]
    ends = [at for (at, _), (_, before) in zip(rows[1:], rows, strict=False) if before == 30]
    assert (slow, ends) == ([expected[0]], [expected[1]])


def test_swiss_line_and_curve_speeds(saved_xml):
    rows = ('trainSeries="R" brakeSeries="115" speed="75"', 'trainSeries="N" brakeSeries="115" speed="60"')
    line = swiss("newLineSpeed", "xmlNewLineSpeed", rows)
    station = swiss("stationSpeed", "xmlStationSpeed", ['trainSeries="R" brakeSeries="115" speed="40/30"'])
    kind = '<NetworkSpecificParameter name="curvePointType" value="{}"/>'
    begin = swiss("curvePoint", "xmlCurveSpeed", ['trainSeries="R" speed="45"']) + kind.format("begin")
    end = f"<teltsi_Company>0085</teltsi_Company><NSP_GroupName>curvePoint</NSP_GroupName>{kind.format('end')}"
    points = "".join(
        f'<NetworkSpecificPoint location="{at}" identifier="1">{inner}</NetworkSpecificPoint>'
        for at, inner in ((2000, line), (2200, begin), (2300, end), (2500, station))
    )
    up = '<PowerConstraint powerConstraintInstruction="Pantograph_Up"/></SignalInformation>\n    </Signal>\n  '
    text = edited(
        (f"{up}</SP_Points>", f"{up}{points}</SP_Points>"),
        ('trainLength="100"', 'trainLength="100" trainCategoryCode="R" brakedWeightPercentage="115"'),
    )  # fmt: skip
    track = load_track(saved_xml(text))
    assert limits_of(track)[:5] == [(0, 90), (1500, 120), (2000, 75), (2200, 45), (2300, 75)]
    assert "Swiss line and curve speeds are those for R 115, as TrainCharacteristics ic says" in track.notes
    assert any(note.endswith("how far they hold: stationSpeed") for note in track.notes)
    broken = text.replace("&lt;/speeds>", "", 1)
    with pytest.raises(InputError, match=r"@value: xmlNewLineSpeed: line 1: is not well-formed XML"):
        load_track(saved_xml(broken))
    for wrong in ("-80", "0", "-0.5"):
        negative = text.replace("speed=&quot;75&quot;", f"speed=&quot;{wrong}&quot;")
        with pytest.raises(InputError, match=rf"@value: xmlNewLineSpeed: speed must be above 0 km/h, got '{wrong}'$"):
            load_track(saved_xml(negative))


def test_from_a_line_speed_that_is_not_read_on_there_is_none(saved_xml):
    points = "".join(
        f'<NetworkSpecificPoint location="{at}">'
        f"{swiss('newLineSpeed', 'xmlNewLineSpeed', [row])}</NetworkSpecificPoint>"
        for at, row in (
            (0, 'trainSeries="R" speed="75"'), (1000, 'trainSeries="N" speed="60"'),
            (2000, 'trainSeries="R" speed="80/70"'), (3000, 'trainSeries="R" speed="85"'),
        )
    )  # fmt: skip
    bare = re.sub(r"<StaticSpeedProfile>.*?</StaticSpeedProfile>", "", message(), flags=re.DOTALL)
    text = bare.replace("</SP_Points>", f"{points}</SP_Points>", 1)
    text = text.replace('trainLength="100"', 'trainLength="100" trainCategoryCode="R"')
    with pytest.raises(InputError, match="no speed limit from 1000 m to 3000 m of the journey"):
        load_track(saved_xml(text))
    track = load_track(saved_xml(text), line_speed_mps=10.0)
    assert limits_of(track) == [(0, 75), (1000, 36), (3000, 85), (3500, 50), (4500, 85)]
    assert any(note.endswith("how far they hold: newLineSpeed (2)") for note in track.notes)
