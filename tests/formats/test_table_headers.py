"""Headers of tables as they come: units in many spellings and places, names in several languages, titles above."""

import time

import pytest

from tests.helpers.refusal import refusal
from tests.helpers.table_case import TRAIN_WITH_TABLE
from tgvdp.formats import load_run, load_track, load_train
from tgvdp.formats.tables.headers import split


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("gradient_permille", "gradient", "‰"),
        ("gradient_per_mille", "gradient", "‰"),
        ("Slope [mm/m]", "slope", "‰"),
        ("Distance (metres)", "distance", "m"),
        ("Position / km", "position", "km"),
        ("v / (km/h)", "v", "km/h"),
        ("v/km/h", "v", "km/h"),
        ("v_km_h", "v", "km/h"),
        ("Position, m", "position", "m"),
        ("Speed limit in km/h", "speed limit", "km/h"),
        ("Velocity [m s⁻¹]", "velocity", "m/s"),
        ("SpeedLimit_kmh", "speed limit", "km/h"),
        ("vMax [km/h]", "v max", "km/h"),
        ("speed_mph", "speed", "mph"),
        ("gradient [1 in x]", "gradient", "1 in x"),
        ("km", "km", ""),
        ("km/h", "km/h", ""),
        ("line-speed", "line speed", ""),
        ("speed target", "speed target", ""),
    ],
)
def test_a_header_is_a_name_and_a_unit(header, name, unit):
    assert split(header) == (name, unit)


@pytest.mark.parametrize(
    "text",
    [
        "position_m,speed_kmh,gradient_per_mille,station_name\n0,72,5,A\n1000,108,-3,B\n2000,,,C\n",
        "Position;Speed limit;Gradient;Stop\nkm;km/h;‰;-\n0;72;5;A\n1;108;-3;B\n2;;;C\n",
        "Line A to C\n\nPosition [km];Speed limit [km/h];Gradient [‰];Stop\n0;72;5;A\n1;108;-3;B\n2;;;C\n",
        "Line A, to C,,\nPosition,Speed,Gradient,Stop\n[m],[m/s],[%],\n0,20,.5,A\n1000,30,-.3,B\n2000,,,C\n",
        "Von [km];Bis [km];Geschwindigkeit [km/h];Längsneigung [‰];Bahnhof\n0;1,0;72;5;A\n1;2,0;108;-3;B\n",
        "PK [km];Vitesse [km/h];Déclivité [pour mille];Gare\n0;72;5;A\n1,0;108;-3;B\n2;;;C\n",
        "Chainage;Speed limit [km/h];Gradient [‰];Stop\nK12+345;72;5;A\nK13+345;108;-3;B\nK14+345;;;C\n",
        "Chainage [km];Speed [km/h];Gradient [‰];Stop\n12+345.0;72;5;A\n13+345,0;108;-3;B\n14+345;;;C\n",
        "position_m,speed_kmh,speed_limit_kmh,gradient_permil,stop,station\n0,0,72,5,1,A\n1000,7,108,-3,1,\n2000,0,,,,C\n",
    ],
    ids=lambda text: text.split("\n")[0][:30],
)
def test_one_line_under_many_headers(saved, text):
    track = load_track(saved(text))
    assert [tuple(one) for one in track.speed_limits] == [(0.0, 20.0), (1000.0, 30.0)]
    assert [tuple(one) for one in track.gradients] == [(0.0, 5.0), (1000.0, -3.0)]
    assert track.stops_m == (0.0, 1000.0, 2000.0)


@pytest.mark.parametrize(
    "rows", ["0,72\n500,72\n500,108\n900,108\n900,72\n2000,72\n", "0,72\n500,108\n900,72\n2000,\n"]
)
def test_steps_are_drawn_by_two_rows_at_one_position(saved, rows):
    track = load_track(saved(f"position_m,speed_kmh\n{rows}"))
    assert [tuple(one) for one in track.speed_limits] == [(0.0, 20.0), (500.0, 30.0), (900.0, 20.0)]


def test_two_values_at_one_position_that_are_no_step_are_refused(saved):
    path = saved("position_m,speed_kmh\n0,72\n500,90\n500,108\n900,\n")
    assert "line 4, column 'speed_kmh': a second value at one position" in refusal(load_track, path)


def test_what_gives_way_and_what_stands_above_is_noted(saved):
    track = load_track(saved("Aston to Berry\nposition_m,speed_limit_kmh,velocity_kmh\n0,72,9\n2000,,\n"))
    assert track.notes == ("rows above the header, not used: 'Aston to Berry'", "columns not used: 'velocity_kmh'")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("position_m,speed_kmh,gradient_deg\n0,72,1\n9,,\n", "column 'gradient_deg': unknown unit 'deg' of gradient"),
        ("position_mi,speed_kmh\n0,72\n9,\n", "column 'position_mi': unknown unit 'mi' of length"),
        ("Chainage,speed_kmh\n12+345,72\n13.4,\n",
         "line 3, column 'Chainage': must be kilometres and metres as in 12+345, got '13.4'"),
        ("Chainage,speed_kmh\n123+45.67,72\n124+00,\n", "column 'Chainage': give its unit in the header"),
    ],
    ids=lambda value: value[:30],
)  # fmt: skip
def test_units_that_are_not_read_are_named(saved, text, message):
    assert message in refusal(load_track, saved(text))


def test_traction_and_braking_stand_in_one_table(saved):
    saved("Speed;Tractive effort;Braking effort\nkm/h;kN;kN\n0;200;50\n36;150;100\n", "effort.csv")
    both = TRAIN_WITH_TABLE + '\n[train.braking]\nfile = "effort.csv"\n'
    train = load_train(saved(both, "train.toml"))
    assert train.traction.effort_n(0.0) == 200e3
    assert train.braking.effort_n(10.0) == 100e3


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        ("Zeit [s];Höhe [m];Geschwindigkeit [km/h]\n0;400;0\n10;401;36\n", "cp1252"),
        ("time_s\tspeed_kmh\n0\t0\n10\t36\n", "utf-16"),
        ("sep=;\ntime_s;speed_kmh\n0;0\n10;36\n", "utf-8"),
        ("Run 17\ntime,speed\ns,km/h\n0,0\n10,36\n", "utf-8"),
        ("Elapsed time / s;v / (km/h)\n0;0\n10;36\n", "utf-8"),
        ("elapsed_time_min,time_s,velocity_mps\n9,0,0\n9,10,10\n", "utf-8"),
        ("Datum/Uhrzeit;Geschwindigkeit [km/h]\n29.3.2026 01:59:55;0\n29.3.2026 02:00:05;36\n", "utf-8"),
        ("timestamp (UTC),speed_kmh\n2026-03-29 01:59:55 UTC,0\n2026-03-29 02:00:05 UTC,36\n", "utf-8"),
    ],
    ids=lambda value: value.split("\n")[0][:30],
)
def test_recorded_runs_are_tables_too(saved, text, encoding):
    run = load_run(saved(text.encode(encoding), "run.csv"))
    assert run.time_s.tolist() == [0.0, 10.0]
    assert run.speed_mps.tolist() == [0.0, 10.0]


@pytest.mark.skipif(not hasattr(time, "tzset"), reason="the zone of this machine cannot be set here")
def test_clocks_without_a_zone_do_not_depend_on_that_of_the_machine(saved, monkeypatch):
    monkeypatch.setenv("TZ", "Europe/Zurich")
    time.tzset()
    run = load_run(saved("time,speed_kmh\n2026-03-29T01:59:55,0\n2026-03-29T03:00:05,36\n", "run.csv"))
    monkeypatch.undo()
    time.tzset()
    assert run.time_s.tolist() == [0.0, 3610.0]


def test_a_recorded_run_stands_in_a_workbook(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["made by a logger"])
    sheet = book.create_sheet("log")
    for row in (["time_s", "position_km"], [0.5, 1.234], [10.5, 2.468]):
        sheet.append(row)
    book.save(tmp_path / "run.xlsx")
    run = load_run(tmp_path / "run.xlsx")
    assert run.time_s.tolist() == [0.0, 10.0]
    assert run.position_m.tolist() == [1234.0, 2468.0]
    sheet["B3"] = "far"
    book.save(tmp_path / "run.xlsx")
    assert "sheet 'log', row 3: position must be a number in km, got 'far'" in refusal(load_run, tmp_path / "run.xlsx")
