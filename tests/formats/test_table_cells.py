"""Cells of tables: numbers with points and commas, errors of spreadsheets, stops that are none."""

import pytest

from tests.helpers.refusal import refusal
from tgvdp.formats import load_track

MISSING = ["NA", "N/A", "n/a", "NaN", "nan", "NULL", "null", "nil", "<NA>"]


@pytest.mark.parametrize(
    "no",
    [
        *("nein", "NO", "Non", "kein", "Keine", "n", "", " no ", "Durchfahrt"),
        *("0", "00", "0.00", "false", "FALSE", "-", "--", *MISSING),
    ],
)
def test_a_no_is_no_stop(saved, no):
    assert load_track(saved(f"km;speed_kmh;Halt\n0;90;\n1;90;{no}\n2;90;\n")).stops_m == (0.0, 2000.0)


@pytest.mark.parametrize("missing", MISSING)
def test_what_is_missing_is_blank_in_every_column(saved, missing):
    text = "km;speed_kmh;gradient_permil;radius_m;Halt\n0;90;1;500;\n1;NA;NA;NA;NA\n2;80;2;0;Nan\n3;;;;\n"
    track = load_track(saved(text.replace("NA", missing)))
    assert track == load_track(saved(text.replace("NA", "")))
    assert [place.name for place in track.places] == ["Nan"]
    assert refusal(load_track, saved(f"km;speed_kmh\n0;80\n{missing};90\n2;\n")) == (
        f"line 3, column 'km': must not be blank, got '{missing}'"
    )


def test_a_row_that_is_longer_than_the_header_is_no_row(saved):
    """Decimal commas between commas: 1,5 km and 90 km/h would be 1 km and 5 km/h."""
    message = refusal(load_track, saved("position_km,speed_kmh\n0,80\n1,5,90\n3,0,90"))
    assert message == ("line 3: holds 3 cells under a header of 2: are there commas in numbers that are not quoted?")
    assert load_track(saved("position_km,speed_kmh\n0,80,,\n3,90,\n")).length_m == 3000.0


def test_a_header_of_row_numbers_is_no_comment(saved):
    text = "#\n# a line; of words\n#;position_m;speed_kmh\n1;0;90\n2;500;80\n# 3;600;20\n4;1000;80\n"
    for name in ("line.csv", "line.txt"):
        track = load_track(saved(text, name))
        assert [row.position_m for row in track.speed_limits] == [0.0, 500.0]
        assert track.notes == ("columns not used: '#'",)


@pytest.mark.parametrize("error", ["#N/A", "#REF!", "#DIV/0!", "#NAME?", "#NV", "#WERT!", "#BEZUG!"])
def test_an_error_of_a_spreadsheet_is_no_comment(saved, error):
    first = saved(f"position_m,speed_kmh,stop\n0,90,\n{error},60,\n1000,90,")
    assert refusal(load_track, first) == f"line 3, column 'position_m': holds the error {error}"
    stop = saved(f"position_m,speed_kmh,stop\n0,90,\n500,60,{error}\n1000,90,")
    assert refusal(load_track, stop) == f"line 3, column 'stop': holds the error {error}"
    unused = saved(f"remark,position_m,speed_kmh\n{error},0,90\n{error},500,60\n,1000,60")
    assert len(load_track(unused).speed_limits) == 2


def _limits_kmh(track):
    return [pytest.approx(3.6 * row.speed_mps) for row in track.speed_limits]


@pytest.mark.parametrize(
    ("rows", "length_m", "gradient"),
    [
        ("0;90;0,5\n1.200;80;0\n12.500;80;0", 12500.0, 0.5),
        ("0;90;0.5\n1,200;80;0\n12,500;80;0", 12500.0, 0.5),
        ("0;90;0,5\n1 200;80;0\n12\u00a0500;80;0", 12500.0, 0.5),
        ("0;90;1,250\n1.200,5;80;0\n1.012.500;80;0", 1012500.0, 1.25),
        ("0.000;90;1.250\n1200;80;0\n12500.000;80;0", 12500.0, 1.25),
    ],
)
def test_the_other_numbers_tell_whether_a_mark_is_one_for_thousands(saved, rows, length_m, gradient):
    track = load_track(saved(f"Position [m];speed_kmh;gradient_permil\n{rows}\n"))
    assert (track.length_m, track.gradients[0].gradient_permil, track.notes) == (length_m, gradient, ())


def test_a_column_tells_more_than_the_table(saved):
    track = load_track(saved("Position [m];speed_kmh\n0,5;90\n1.200;80.5\n2.000,5;80.5\n"))
    assert track.length_m == 2000.0
    assert _limits_kmh(track) == [90.0, 80.5]


def test_a_mark_that_nothing_tells_is_refused_or_noted(saved):
    doubtful = saved("Position [m];speed_kmh\n0;90\n1.200;80\n2500;80\n")
    assert refusal(load_track, doubtful) == (
        "line 3, column 'Position [m]': may be 1.2 or 1200 m, got '1.200': write it without a mark for thousands"
    )
    noted = load_track(saved("km;speed_kmh\n12,345;90\n13,345;90\n"))
    assert noted.length_m == pytest.approx(1000.0)
    assert noted.notes[1:] == ("column 'km': numbers such as '12,345' are read as 12.345 km, not as 12345",)
    assert load_track(saved("position_m,speed_kmh\n0,90\n1.200,80\n")).length_m == 1.2


@pytest.mark.parametrize(
    "number", ["12 5", "1.2.3", "1.2345.678", "1,2,3", "1 2000", "12.34,5", "1,234,5", "0.123.456"]
)
def test_groups_are_of_three_digits(saved, number):
    message = refusal(load_track, saved(f"km;speed_kmh\n0;90\n{number};80\n"))
    assert message == f"line 3, column 'km': must be a finite number in km, got {number!r}"
