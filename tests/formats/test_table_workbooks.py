"""Excel workbooks: sheets, number formats, formulas, and what is damaged."""

import io
import sys
import zipfile

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.refusal import refusal
from tests.helpers.table_case import TRAIN_WITH_TABLE, workbook
from tgvdp.errors import InputError, MissingExtraError
from tgvdp.formats import describe_file, load_track, load_train
from tgvdp.formats.review.plausibility import review_file
from tgvdp.formats.tables import workbook as workbook_reader
from tgvdp.model.track import Gradient
from tgvdp.units import kmh_to_mps


def test_a_sheet_whose_name_holds_a_hash_is_reached_by_its_name(saved):
    rows = [["position_m", "speed_kmh"], [0, 90], [1000, 90]]
    path = saved(workbook(**{"track #1": rows, "track #2": rows}), "book.xlsx")
    assert load_track(f"{path}#track #2").name == "track #2"
    assert refusal(load_track, f"{path}#track").startswith("holds no track 'track'")


def test_sheets_of_a_workbook_are_lines_and_curves(saved):
    rows = [
        ["position_m", "speed_kmh", "gradient_permil", "stop"],
        [0, 90, 0.1, "A"],
        [None],
        [1000.5, "80,5", -3, True],
    ]
    effort = [["speed_kmh", "effort_kn"], [0, 200], [72, 100.5]]
    path = saved(workbook(up=rows, effort=effort, about=[["some text"]]), "book.xlsx")
    track = load_track(path)
    assert (track.name, track.length_m) == ("up", 1000.5)
    assert track.gradients == (Gradient(0.0, 0.1),)
    assert describe_file(path).format == "Excel table"
    assert [review.kind for review in review_file(path)] == ["track"]
    train = load_train(saved(TRAIN_WITH_TABLE.replace("effort.csv", "book.xlsx#effort"), "train.toml"))
    assert train.traction.effort_n(20.0) == 100.5e3
    two = saved(workbook(up=rows, down=rows), "book.xlsx")
    assert refusal(load_track, two) == "holds 2 tracks, choose one as FILE#NAME: up, down"
    assert load_track(f"{two}#down").name == "down"
    assert refusal(load_track, saved(b"PK\x03\x04 no archive", "x.xlsx")) == "is no Excel workbook (.xlsx)"


def book_of(saved, rows, **formats):
    """A workbook of one sheet, cells with number formats."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.load_workbook(io.BytesIO(workbook(up=rows)))
    for cell, number_format in formats.items():
        book["up"][cell].number_format = number_format
    data = io.BytesIO()
    book.save(data)
    return saved(data.getvalue(), "book.xlsx")


def test_per_cent_formats_are_read_as_they_are_shown(saved):
    rows = [["position_m", "speed_kmh", "Gradient [%]"], [0, 90, 0.0125], [500, None, 2], [800, None, "3,5"], [1000]]
    track = load_track(book_of(saved, rows, C2="0.00%"))
    assert [row.gradient_permil for row in track.gradients] == [12.5, 20.0, 35.0]
    rows[0][2] = "gradient_permil"
    assert refusal(load_track, book_of(saved, rows, C2="0.00%")) == (
        "sheet 'up', cell C2, column 'gradient_permil': must be a number in ‰, got 1.25 % by its format"
    )
    assert load_track(book_of(saved, rows, C2='0.00" % of what?"')).gradients[0].gradient_permil == 0.0125


def test_numbers_that_are_shown_in_thousands_are_refused(saved):
    rows = [["position_km", "speed_kmh"], [0, 90], [1500, 90]]
    assert load_track(book_of(saved, rows, A3="#,##0.00")).length_m == 1.5e6
    assert refusal(load_track, book_of(saved, rows, A3="#,##0.0,")) == (
        "sheet 'up', cell A3, column 'position_km': is shown in thousands by its format, got 1500: give it as it is"
    )


@pytest.mark.parametrize("drawn", ["0+000", '0"+"000', "0\\+000", "#+000.0", '"km "0+000'])
def test_positions_that_are_drawn_as_kilometres_and_metres_are_read_as_they_are_shown(saved, drawn):
    rows = [["Position [km]", "speed_kmh"], [12345, 90], [13000.25, 80], [14007, None]]
    track = load_track(book_of(saved, rows, A2=drawn, A3=drawn, A4=drawn))
    assert (track.length_m, [row.position_m for row in track.speed_limits]) == (1662.0, [0.0, 655.25])
    assert refusal(load_track, book_of(saved, rows, A2=drawn, A4=drawn)) == (
        "sheet 'up', cell A3, column 'Position [km]': must be kilometres and metres as in 12+345, got '13000.25'"
    )


@pytest.mark.parametrize("drawn", ["0+00", '0"."000', "0\\,000"])
def test_marks_that_a_format_draws_between_digits_are_refused(saved, drawn):
    rows = [["position_km", "speed_kmh"], [0, 90], [1500, 90]]
    assert refusal(load_track, book_of(saved, rows, A3=drawn)) == (
        f"sheet 'up', cell A3, column 'position_km': is shown as {drawn} by its format, got 1500: give it as it is"
    )
    assert load_track(book_of(saved, rows, A3='0" km"')).length_m == 1.5e6


def test_errors_and_formulas_without_values_are_named_by_sheet_and_cell(saved):
    rows = [["position_m", "speed_kmh", "stop"], [0, 90], ["#REF!", 60], [1000, 90]]
    assert (
        refusal(load_track, book_of(saved, rows)) == "sheet 'up', cell A3, column 'position_m': holds the error #REF!"
    )
    rows[2] = [500, "=60+20"]
    assert refusal(load_track, book_of(saved, rows)) == (
        "sheet 'up', cell B3, column 'speed_kmh': "
        "is a formula without a stored value: open the workbook in a spreadsheet and save it"
    )
    rows[2] = ["=B2", None]
    assert "sheet 'up', cell A3" in refusal(load_track, book_of(saved, rows))


def test_formulas_with_stored_values_and_empty_texts_are_read(saved):
    rows = [["position_m", "speed_kmh", "stop"], [0, 90], [500, "=60+20", "=IF(A1,1,2)"], [1000, 90]]
    stored = {b"<f>60+20</f><v/>": b"<f>60+20</f><v>80</v>", b'"C3"><f>': b'"C3" t="str"><f>'}
    original = zipfile.ZipFile(book_of(saved, rows))
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        for name in original.namelist():
            text = original.read(name).replace(b"<v></v>", b"<v/>").replace(b"<v />", b"<v/>")
            for before, after in stored.items():
                assert before in text or "sheet1" not in name
                text = text.replace(before, after)
            archive.writestr(name, text)
    track = load_track(saved(data.getvalue(), "book.xlsx"))
    assert [row.speed_mps for row in track.speed_limits] == [kmh_to_mps(90.0), kmh_to_mps(80.0)]
    assert track.stops_m == (0.0, 1000.0)


def test_sheets_and_columns_of_a_workbook_that_are_not_used_are_noted(saved):
    rows = [["#", "position_m", "speed_kmh", None, "remark"], [1, 0, 90, 3], [2, 1000, 90, None, "end"]]
    path = saved(workbook(up=rows, about=[["some text"]]), "book.xlsx")
    assert load_track(path).notes == (
        "columns not used: '#', D (without a header), 'remark'",
        "sheets without positions, not used: 'about'",
    )


def test_openpyxl_is_an_extra(saved, monkeypatch):
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(MissingExtraError, match=r"Excel needs openpyxl: pip install 'tgvdp\[formats\]'$"):
        load_track(saved(b"PK\x03\x04", "book.xlsx"))


def test_a_workbook_that_unpacks_to_too_much_is_refused(saved, monkeypatch):
    monkeypatch.setattr(workbook_reader, "LARGEST_BYTES", 1000)
    message = refusal(load_track, saved(workbook(up=[["position_m"], [0]]), "book.xlsx"))
    assert message.startswith("unpacks to more than 0.001 MB, got ")


@given(at=st.floats(0, 1), byte=st.integers(0, 255), member=st.integers(0, 20))
def test_a_damaged_workbook_is_read_or_refused_in_one_line(tmp_path_factory, at, byte, member):
    """One byte of one of its parts is changed."""
    original = zipfile.ZipFile(io.BytesIO(workbook(up=[["position_m", "speed_kmh"], [0, 90], [1000, 90]])))
    names = original.namelist()
    damaged = io.BytesIO()
    with zipfile.ZipFile(damaged, "w") as archive:
        for name in names:
            data = bytearray(original.read(name))
            if name == names[member % len(names)]:
                data[int(at * (len(data) - 1))] = byte
            archive.writestr(name, bytes(data))
    path = tmp_path_factory.mktemp("book") / "book.xlsx"
    path.write_bytes(damaged.getvalue())
    try:
        load_track(path)
    except InputError as error:
        assert str(error).startswith(f"{path}: ")
        assert str(error).isprintable()
