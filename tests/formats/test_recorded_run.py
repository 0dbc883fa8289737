"""Recorded runs as CSV: names, units, separators and clocks as they come."""

import pytest

from tgvdp.errors import InputError
from tgvdp.formats import load_run


def read(tmp_path, text, encoding="utf-8"):
    path = tmp_path / "run.csv"
    path.write_bytes(text.encode(encoding))
    return load_run(path)


@pytest.mark.parametrize(
    "text",
    [
        "time_s,speed_kmh\n0,0\n1.5,36\n",
        "\ufefftime [s];speed [km/h]\n0;0\n1,5;36,0\n",
        "# from a logger\nt (s)\tv (m/s)\n\n10\t0\n11,5\t10\n",
        "Zeit in min;Geschwindigkeit in m/s\n0;0\n0,025;10\n",
        "timestamp,lat,lon,speed_mps\n2026-01-02T10:00:00Z,1,2,0\n2026-01-02T10:00:01.500Z,1,2,10\n",
        "time,speed_kph\n09:59:59.5,0\n10:00:01,36\n",
        "time;speed [km/h]\n59:59,5;0\n60:01,0;36\n",
        "time_s,speed_kmh\n0,0\n,\n1.5,36\n",
    ],
)
def test_one_run_in_many_spellings(tmp_path, text):
    run = read(tmp_path, text)
    assert run.name == "run.csv"
    assert run.position_m is None
    assert run.time_s.tolist() == pytest.approx([0.0, 1.5])
    assert run.speed_mps.tolist() == pytest.approx([0.0, 10.0])


@pytest.mark.parametrize(
    ("text", "time_s"),
    [
        ("time,speed_mps\n23:59:30,0\n00:00:30,9\n00:10:00,9\n", [0.0, 60.0, 630.0]),
        ("time,speed_mps\n47:30,0\n48:30,9\n49:00,9\n", [0.0, 60.0, 90.0]),
        ("time [h],speed_mps\n9:59,0\n10:00,9\n10:01,9\n", [0.0, 60.0, 120.0]),
        ("time [h],speed_mps\n23:59,0\n0:01,9\n0:02,9\n", [0.0, 120.0, 180.0]),
        ("time [h],speed_mps\n1.5,0\n1.6,9\n1.7,9\n", [0.0, 360.0, 720.0]),
    ],
)
def test_clocks_go_past_midnight_and_tell_hours_where_these_are_the_unit(tmp_path, text, time_s):
    assert read(tmp_path, text).time_s.tolist() == pytest.approx(time_s)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("id,position_m,time_s\nfastest,0,0\nfastest,90,9.5\n0,0,0.0\n0,90,10\n",
         "line 4: time goes back, got '0.0' after '9.5'"),
        ("time,speed_mps\n10:00:00,0\n\n10:00:09,9\n10:00:08,9\n",
         "line 5: time goes back, got '10:00:08' after '10:00:09'"),
    ],
)  # fmt: skip
def test_several_runs_in_a_table_are_told_by_the_row(tmp_path, text, words):
    with pytest.raises(InputError, match=f"run.csv: {words}: a table of one run is expected"):
        read(tmp_path, text)


def test_positions_in_kilometres(tmp_path):
    run = read(tmp_path, "speed_mps,chainage [km],time_s\n0,12.5,0\n10,12.6,20\n")
    assert run.position_m.tolist() == [12_500.0, 12_600.0]
    assert run.time_s.tolist() == [0.0, 20.0]


@pytest.mark.parametrize(
    "text",
    [
        "#;time_s;position_m\n1;0,5;0\n2;60,5;1.200\n# 3;1;1\n",
        "time_s;position_m\n0.5;0\n60.5;1,200\n",
        "time_s,position_km\n0,0\n60,1.200\n",
        'time_s,position_m\n0.5,0\n60.5,"1,200"\n',
        "time_s\tposition_km\n0.000\t0\n60.000\t1.200\n",
        "time_s\tposition_m\n0\t0\n60\t1 200\n",
    ],
)
def test_the_other_numbers_tell_what_a_mark_is(tmp_path, text):
    run = read(tmp_path, text)
    assert run.time_s.tolist() == [0.0, 60.0]
    assert run.position_m.tolist() == [0.0, 1200.0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("# nothing\n", "is empty"),
        ("time_s,altitude_m\n0,1\n1,2\n", "needs two of position, speed and time with units"),
        ("time_s,speed\n0,1\n1,2\n", "column 'speed' names no unit: write speed_kmh"),
        ("time,speed_mps\n0,1\n1,2\n", "line 2: column of time names no unit"),
        ("time_s,speed_knots\n0,1\n1,2\n", "column 'speed_knots': unknown unit 'knots' of speed"),
        ("time_s,speed_mps\n0,1\n", "must have at least 2 rows"),
        ("time_s,speed_mps\n0,1\n1,fast\n", "line 3: speed must be a number in m/s, got 'fast'"),
        ("time_s,speed_mps\n0,1\n1,inf\n", "line 3: speed must be a number in m/s, got 'inf'"),
        ("time_s,speed_mps\n0,1\n1\n", "line 3: speed must be a number in m/s, got ''"),
        ("time_s,t_min,speed_mps\n0,1,2\n1,2,3\n", "has two columns of time: 'time_s' and 't_min'"),
        ("time_s;position_m\n0;0\n10;1.200\n", "line 3: position may be 1.2 or 1200 m, got '1.200'"),
        ("time_s,speed_mps\n0,1\n#N/A,1\n", "line 3: time must be a number in s, got '#N/A'"),
        ("time,speed_mps\n10:00:00,1\nten:past,2\n", "line 3: time must be seconds"),
    ],
)
def test_faults_are_named(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, text)
    assert str(caught.value).startswith(str(tmp_path / "run.csv"))


def test_files_that_are_no_text(tmp_path):
    with pytest.raises(InputError, match="is neither UTF-8, UTF-16 nor Windows-1252"):
        read(tmp_path, "Zeit [s];H\x81he [m]\n", "latin-1")
    with pytest.raises(InputError, match="must be a table, as CSV or Excel, got JSON"):
        read(tmp_path, '{"time_s": [0, 1]}')
    with pytest.raises(InputError, match="no such file"):
        load_run(tmp_path / "gone.csv")
