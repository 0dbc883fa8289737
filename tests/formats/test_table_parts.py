"""Workbooks whose sheets are parts of one line."""

import math

import pytest

from tests.helpers.refusal import refusal
from tests.helpers.table_case import workbook
from tgvdp.formats import load_track

LIMITS = [["From [km]", "To [km]", "Speed limit [km/h]"], [1, 3, 72], [3, 11, 108]]
GRADIENTS = [["Position [m]", "Gradient [‰]"], [0, 2], [500, 5], [4000, -8]]
CURVES = [["From [km]", "To [km]", "Radius [m]"], [2, 2.5, 400], [2.5, 3, 500], [7, 8, 500], [20, 21, 600]]
STATIONS = [["Chainage [km]", "Station"], [0.5, "Out"], [1, "A"], [6, "B"], [11, "C"]]


@pytest.fixture
def book(saved):
    def save(**sheets):
        return saved(workbook(**sheets), "book.xlsx")

    return save


def test_sheets_that_each_give_something_else_are_one_line(book):
    track = load_track(book(Limits=LIMITS, Gradients=GRADIENTS, Curves=CURVES, Stations=STATIONS))
    assert track.name == "book"
    assert track.length_m == 10_000.0
    assert [tuple(one) for one in track.speed_limits] == [(0.0, 20.0), (2000.0, 30.0)]
    assert [tuple(one) for one in track.gradients] == [(0.0, 5.0), (3000.0, -8.0)]
    radii = [(0.0, math.inf), (1000.0, 400.0), (1500.0, 500.0), (2000.0, math.inf), (6000.0, 500.0), (7000.0, math.inf)]
    assert [(one.position_m, one.radius_start_m) for one in track.curves] == radii
    assert track.stops_m == (0.0, 5000.0, 10_000.0)
    assert track.notes == (
        "positions count from the first row, which is at 1 km",
        "the line is put together of the sheets 'Limits', 'Gradients', 'Curves', 'Stations'",
        "sheet 'Gradients': goes from 0 to 4 km, the line with its limits from 1 to 11 km",
        "sheet 'Curves': goes from 2 to 21 km, the line with its limits from 1 to 11 km",
        "sheet 'Stations': goes from 0.5 to 11 km, the line with its limits from 1 to 11 km",
    )


def test_a_sheet_may_be_taken_alone_and_limits_may_be_absent(book):
    path = book(Limits=LIMITS, Gradients=GRADIENTS)
    alone = load_track(f"{path}#Limits")
    assert alone.gradients == ()
    assert alone.notes[1:] == ("sheets without limits, not used: 'Gradients'",)
    track = load_track(book(Gradients=GRADIENTS, Stations=STATIONS), line_speed_mps=20.0)
    assert track.length_m == 11_000.0
    assert track.stops_m == (0.0, 500.0, 1000.0, 6000.0, 11_000.0)


def test_steps_are_drawn_by_two_rows_at_one_position_in_sheets_of_their_own_too(book):
    steps = [["Position [km]", "Gradient [‰]"], [0, 2], [4, 2], [4, -8], [11, -8]]
    track = load_track(book(Limits=LIMITS, Gradients=steps))
    assert [tuple(one) for one in track.gradients] == [(0.0, 2.0), (3000.0, -8.0)]


def test_sheets_that_give_the_same_are_lines_of_their_own(book):
    path = book(Up=LIMITS, Down=LIMITS, Curves=CURVES)
    assert "holds 3 tracks, choose one as FILE#NAME: Up, Down, Curves" in refusal(load_track, path)
    assert load_track(f"{path}#Up").notes[1:] == ("sheets without limits, not used: 'Curves'",)
    path = book(Up=LIMITS, Down=LIMITS, Gradients=GRADIENTS)
    assert "sheet 'Gradients': no column for the speed" in refusal(load_track, f"{path}#Gradients")


@pytest.mark.parametrize(
    ("sheets", "message"),
    [
        ({"Limits": LIMITS, "Curves": [*CURVES[:2], [2.4, 3, 500]]},
         "sheet 'Curves', cell A3, column 'From [km]': an overlap: begins at 2400 m, the row before ends at 2500 m"),
        ({"Limits": [*LIMITS[:2], [4, 11, 108]], "Curves": CURVES},
         "sheet 'Limits', cell A3, column 'From [km]': a gap"),
        ({"Limits": [*LIMITS[:2], [3, 11, 0]], "Curves": CURVES},
         "sheet 'Limits', cell C3, column 'Speed limit [km/h]': must be above 0 km/h, got 0 km/h"),
        ({"Limits": LIMITS, "Gradients": [*GRADIENTS, [4000, 8]]},
         "sheet 'Gradients', cell B5, column 'Gradient [‰]': a second value at one position, got 8 ‰"),
        ({"Limits": LIMITS, "Curves": [["From [km]", "To [km]", "Radius"], [1, 2, 400]]},
         "sheet 'Curves', column 'Radius': give its unit in the header"),
        ({"Limits": LIMITS, "Curves": CURVES[:1]}, "sheet 'Curves': no rows below the header"),
    ],
    ids=lambda value: str(value)[:30],
)  # fmt: skip
def test_errors_name_the_sheet_that_they_are_in(book, sheets, message):
    assert message in refusal(load_track, book(**sheets))
