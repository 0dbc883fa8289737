"""Lines as tables: columns and units as people write them, and errors that say what was wanted."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.refusal import refusal
from tests.helpers.table_case import EFFORT_TABLE
from tgvdp.errors import InputError
from tgvdp.formats import load_scenario, load_track
from tgvdp.model.track import Curve, Gradient, SpeedLimit
from tgvdp.units import kmh_to_mps

AGAINST_MILEAGE = "against the mileage write how far each row lies from the first one, + uphill in that order"
LINE = """position_m,speed_kmh,gradient_permil,radius_m,stop
0,90,0,,Aston
1000,,-5.5,800,
1500,120,,0,
3000,,12,,yes
4000,,,,Berry
"""


def test_rows_hold_until_the_next_one_and_blank_cells_go_on(saved):
    track = load_track(saved(LINE))
    assert (track.name, track.length_m, track.stops_m) == ("line", 4000.0, (0.0, 3000.0, 4000.0))
    assert track.speed_limits == (SpeedLimit(0.0, 25.0), SpeedLimit(1500.0, kmh_to_mps(120.0)))
    assert track.gradients == (Gradient(0.0, 0.0), Gradient(1000.0, -5.5), Gradient(3000.0, 12.0))
    assert track.curves == (
        Curve(0.0, math.inf, math.inf),
        Curve(1000.0, 800.0, 800.0),
        Curve(1500.0, math.inf, math.inf),
    )
    assert track.notes == ()


@pytest.mark.parametrize(
    "text",
    [
        "Position [km];Speed limit (km/h);Gradient [%];Radius [km];Stop\n0;90;0;;A\n"
        "1;;-0,55;0,8;\n1,5;120;;;\n3;;1,2;;x\n4;;;;B",
        "km\tvmax_m/s\tslope in \u2030\tcurve radius in m\tstation\n"
        "0\t25\t0\t\tA\n1\t\t\u22125.5\t800\n1.5\t33.333333333333336\n"
        "3\t\t12\t\tx\n4\t\t\t\tB",
        'sep=;\n"Chainage [m]";"Line speed [kmph]";"Grade (per mille)";"R [m]";"halt"\n'
        '"0";"90";0;;A\n1000;"90";-5,5;800;no\n'
        "# comment\n\n1500;120;;800;0\n3000;120;12;800;1\n4000;120;12;800;B\n",
        " S_M , V_KMH , Slope Permil , Radius m , Stop Name \n"
        "0,90,0,,A\n1e3,90,-5.5,800,\n1500,120,-5.5,,\n3000,120,12,,C\n4000,,,,B",
    ],
    ids=["semicolons", "tabs", "sep", "commas"],
)  # fmt: skip
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_headers_and_cells_as_people_write_them(saved, text, encoding):
    if encoding == "cp1252":
        text = text.replace("\u2212", "-")  # which it does not have
    track = load_track(saved(text.encode(encoding)))
    expected = load_track(saved(LINE, "expected.csv"))
    assert (track.length_m, track.stops_m) == (expected.length_m, expected.stops_m)
    assert track.speed_limits == expected.speed_limits
    assert [(at, pytest.approx(permil)) for at, permil in track.gradients] == list(expected.gradients)
    assert track.curves[:2] == expected.curves[:2]


def test_it_is_told_by_its_header_not_its_suffix(saved):
    assert load_scenario(saved(LINE, "line.txt")).format == "CSV table"
    assert load_track(saved(LINE, "line")).length_m == 4000.0


def test_positions_count_from_the_first_row_and_unknown_columns_are_noted(saved):
    track = load_track(saved("chainage_km,speed_kmh,remark\n12.5,90,a\n13.5,80,b\n14,80,c"))
    assert track.speed_limits == (SpeedLimit(0.0, 25.0), SpeedLimit(1000.0, kmh_to_mps(80.0)))
    assert track.notes == (
        "positions count from the first row, which is at 12.5 km",
        "columns not used: 'remark'",
    )


def test_a_line_against_its_mileage_is_told_what_to_write(saved):
    falling = saved("km,vmax_kmh\n15.0,120\n13.8,80\n12.3,\n")
    assert refusal(load_track, falling) == (
        f"line 3, column 'km': positions must not decrease, got 13800 m after 15000 m: {AGAINST_MILEAGE}"
    )


def test_a_line_speed_stands_where_there_is_no_limit(saved):
    no_column = saved("position_m,gradient_permil\n0,5\n1000,5")
    assert refusal(load_track, no_column).startswith(
        "no column for the speed (such as speed_kmh or Speed limit [km/h]), got"
    )
    assert load_track(no_column, line_speed_mps=25.0).speed_limits == (SpeedLimit(0.0, 25.0),)
    late = saved("position_m,speed_kmh\n0,\n100,90\n1000,")
    assert "line 2, column 'speed_kmh': no speed limit from here on; --line-speed" in refusal(load_track, late)
    assert load_track(late, line_speed_mps=20.0).speed_limits == (SpeedLimit(0.0, 20.0), SpeedLimit(100.0, 25.0))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name,speed_kmh\n0,90\n1,90",
         "no column for the position (such as position_m or Position [km]), got 'name', 'speed_kmh'"),
        ("position,speed_kmh\n0,90\n1,90",
         "column 'position': give its unit in the header, such as position_m or Position [km]"),
        ("position_m,speed\n0,90\n1,90",
         "column 'speed': give its unit in the header, such as speed_kmh or Speed limit [km/h]"),
        ("position_m,speed [mph]\n0,90\n1,90", "column 'speed [mph]': unknown unit 'mph' of speed; known: m/s, km/h"),
        ("position_m,km,speed_kmh\n0,0,90\n1,1,90", "columns 'position_m' and 'km' both give the position"),
        ("position_m,speed_kmh\n0,fast\n1,90",
         "line 2, column 'speed_kmh': must be a finite number in km/h, got 'fast'"),
        ("position_m,speed_kmh\n0,1e999\n1,90",
         "line 2, column 'speed_kmh': must be a finite number in km/h, got '1e999'"),
        ('position_m,speed_kmh\n0,"90,5"\n1,90',
         "line 2, column 'speed_kmh': a comma in a number may mean two things, got '90,5'"),
        ("position_m,speed_kmh\n0,90\n\n200,80\n100,80",
         "line 5, column 'position_m': positions must not decrease, got 100 m after 200 m"),
        ("position_m,speed_kmh\n0,90\n,80\n100,80", "line 3, column 'position_m': must not be blank"),
        ("position_m,speed_kmh\n0,90\n50,80\n50,70\n100,80",
         "line 4, column 'speed_kmh': a second value at one position, got 70 km/h"),
        ("position_m,speed_kmh\n0,90",
         "column 'position_m': needs two rows at different positions, the last one at the end"),
        ("position_m,speed_kmh\n0,-90\n1,90", "line 2, column 'speed_kmh': must be above 0 km/h, got -90 km/h"),
        ('position_m,speed_kmh\n0,"90\n1,90', "line 3: is no CSV: unexpected end of data"),
        (EFFORT_TABLE, 'holds an effort curve; a native train takes it as traction = { file = "NAME" }'),
    ],
    ids=lambda value: str(value)[:40],
)  # fmt: skip
def test_errors_name_the_line_the_column_and_what_was_wanted(saved, text, message):
    assert refusal(load_track, saved(text)).startswith(message)


@pytest.mark.parametrize(
    ("header", "length_m"), [("from_km;to_km", 3000.0), ("Start [km];End [km]", 3000.0), ("From (km);to_m", 3000.0)]
)
def test_the_end_of_the_last_segment_is_that_of_the_line(saved, header, length_m):
    scale = 1000 if "to_m" in header else 1
    rows = f"12,3;{13.3 * scale:g};80;5;A\n13,3;{14 * scale:g};100;;\n14;{15.3 * scale:g};120;-3;\n"
    track = load_track(saved(f"{header};speed_kmh;gradient_permil;stop\n{rows.replace('.', ',')}"))
    assert track.length_m == pytest.approx(length_m)
    assert [row.speed_mps for row in track.speed_limits] == [kmh_to_mps(speed) for speed in (80.0, 100.0, 120.0)]
    assert [row.gradient_permil for row in track.gradients] == [5.0, -3.0]
    assert track.stops_m == (0.0, track.length_m)
    assert track.notes == ("positions count from the first row, which is at 12.3 km",)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("0,1000,80\n1200,2000,90",
         "line 3, column 'from_m': a gap: begins at 1200 m, the row before ends at 1000 m"),
        ("0,1000,80\n900,2000,90",
         "line 3, column 'from_m': an overlap: begins at 900 m, the row before ends at 1000 m"),
        ("0,1000,80\n1000,900,90",
         "line 3, column 'to_m': must not lie before 1000 m, where the row begins, got 900 m"),
        ("0,1000,80\n1000,,90", "line 3, column 'to_m': must not be blank"),
        ("1000,0,80\n0,-1000,80",
         f"line 3, column 'from_m': positions must not decrease, got 0 m after 1000 m: {AGAINST_MILEAGE}"),
    ],
)  # fmt: skip
def test_segments_must_join(saved, rows, message):
    assert refusal(load_track, saved(f"from_m,to_m,speed_kmh\n{rows}\n")) == message


def test_values_of_the_row_that_marks_the_end_are_noted(saved):
    track = load_track(saved("position_m,speed_kmh,gradient_permil,radius_m\n0,80,5,\n1000,,-3,\n2000,100,-3,0"))
    assert track.notes == ("the last row marks the end: its speed holds nowhere",)


def test_columns_without_a_header_are_noted_and_empty_ones_are_not(saved):
    track = load_track(saved("position_m,speed_kmh,,remark,more\n0,90,1,,x\n1000,,2,,"))
    assert track.notes == ("columns not used: 3 (without a header), 'more'",)


_rows = st.lists(
    st.tuples(st.integers(1, 50_000), st.integers(10, 400), st.integers(-400, 400)), min_size=1, max_size=12
)


@given(
    rows=_rows,
    delimiter=st.sampled_from([",", ";", "\t"]),
    comma=st.booleans(),
    quoted=st.booleans(),
    ends=st.sampled_from(["\n", "\r\n"]),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16"]),
    km=st.booleans(),
)
def test_every_dialect_reads_as_the_same_line(tmp_path_factory, rows, delimiter, comma, quoted, ends, encoding, km):
    """Steps in m, limits in km/h and gradients in tenths of ‰, written in one of many ways, come back as they were."""

    def cell(value):
        text = f"{value:.12g}".replace(".", "," if comma and delimiter != "," else ".")
        return f'"{text}"' if quoted else text

    at_m, lines = 0.0, []
    limits, gradients = [], []
    for step, speed, tenths in rows:
        lines.append([at_m / 1000 if km else at_m, speed, tenths / 10])
        limits += [] if limits and limits[-1][1] == kmh_to_mps(speed) else [(at_m, kmh_to_mps(speed))]
        gradients += [] if gradients and gradients[-1][1] == tenths / 10 else [(at_m, tenths / 10)]
        at_m += step
    lines.append([at_m / 1000 if km else at_m, rows[-1][1], 0])
    header = delimiter.join(["Position [km]" if km else "position_m", "Speed limit (km/h)", "gradient_permil"])
    text = ends.join([header, *(delimiter.join(map(cell, line)) for line in lines), ""])
    path = tmp_path_factory.mktemp("table") / "line.csv"
    path.write_bytes(text.encode(encoding))
    track = load_track(path)
    assert track.length_m == pytest.approx(at_m, rel=1e-12)
    assert [(row.position_m, row.speed_mps) for row in track.speed_limits] == [
        (pytest.approx(at), v) for at, v in limits
    ]
    assert [(row.position_m, row.gradient_permil) for row in track.gradients] == [
        (pytest.approx(at), g) for at, g in gradients
    ]


@given(st.text(alphabet=st.characters(codec="utf-8"), max_size=200))
def test_no_text_ends_otherwise_than_in_a_line_or_one_line_of_error(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("table") / "line.csv"
    path.write_bytes(f"position_m,speed_kmh,stop\n0,90,\n{text}\n".encode())
    try:
        load_track(path)
    except InputError as error:
        assert str(error).startswith(f"{path}: ")
        assert str(error).isprintable()
