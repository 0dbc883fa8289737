"""Stops that people name where they may give positions or numbers of sections."""

import json

import pytest

from tgvdp.cli import main
from tgvdp.formats import load_section, load_track

LINE = "km,limit_kmh,stop\n0,80,Aston\n5,100,Mid\n7,90,Mid\n9,90,'s-Norton\n12,90,Berry\n"
TIMES = "stop,arrival,departure\nAston,,10:00\nMid West,10:08,10:09\nBerry,10:20,\n"
#: As TIMES, on a line where names are unique.
PLACED = "stop,km,arrival,departure\nThe Mill,0,,10:00\nMid,5,10:08,10:09\nBerry,12,10:20,\n"


@pytest.fixture
def ends(tmp_path, monkeypatch):
    """Function that searches on a line of named stops and returns exit code, origin and destination, m."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "line.csv").write_text(LINE)
    (tmp_path / "west.csv").write_text(LINE.replace("Mid", "Mid West", 1))
    (tmp_path / "times.csv").write_text(TIMES)
    (tmp_path / "placed.csv").write_text(PLACED)

    def search(*options, track="line.csv"):
        files = ["--track", track, "--train", "alstom-emu", "--points", "2", "--no-certify", "--no-pictures", "--quiet"]
        code = main(["search", *files, *options])
        if code:
            return code, None
        trip = json.loads((tmp_path / "out" / "result.json").read_text())["trip"]
        return code, (trip["origin_m"], trip["destination_m"])

    return search


@pytest.mark.parametrize(
    ("options", "trip_m"),
    [
        (["--from", "aston", "--to", "Berry"], (0.0, 12_000.0)),
        (["--from", "5km", "--to", " Berry "], (5000.0, 12_000.0)),
        (["--from", "Berry", "--to", "Aston", "--reverse"], (0.0, 12_000.0)),
        (["--from", "Berry", "--to", "3km", "--reverse"], (0.0, 3000.0)),
        (["--to", "'s-Norton"], (0.0, 9000.0)),
    ],
)
def test_origin_and_destination_may_be_names_of_stops(ends, options, trip_m):
    assert ends(*options) == (0, trip_m)


@pytest.mark.parametrize(
    ("track", "options", "said"),
    [
        (
            "line.csv",
            ["--from", "Norton"],
            "'--from': the line has no place of that name, got 'Norton' (it has 'Aston',",
        ),
        ("line.csv", ["--to", "mid"], "'--to': the line has 2 places of that name, got 'mid'"),
        ("flat-100km", ["--to", "Berry"], "no place of that name, got 'Berry' (it names none)"),
    ],
)
def test_a_name_that_the_line_does_not_have_once_is_refused(ends, track, options, said, capsys):
    assert ends(*options, track=track)[0] == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("part", "trip_m"),
    [
        ("times.csv#Mid West", (5000.0, 12_000.0)),
        ("times.csv#aston", (0.0, 5000.0)),
        ("placed.csv#the mill", (0.0, 5000.0)),  # as the timetable calls it
        ("placed.csv#Mid West", (5000.0, 12_000.0)),  # as the line does
    ],
)
def test_a_section_of_a_timetable_is_chosen_by_the_stop_that_it_begins_at(ends, part, trip_m):
    assert ends("--journey", part, track="west.csv") == (0, trip_m)


def test_a_stop_at_which_no_section_begins_is_refused(ends, capsys):
    assert ends("--journey", "times.csv#Berry", track="west.csv")[0] == 3
    assert "times.csv: has sections 1 to 2, which begin at 'Aston', 'Mid West', got 'Berry'" in capsys.readouterr().err


def test_python_chooses_a_section_of_a_timetable_of_names_alone(ends):
    assert ends(track="west.csv")[0] == 0
    assert load_section("times.csv#Mid West", load_track("west.csv"))[1].origin_m == 5000.0


def test_records_and_comparisons_take_names_too(ends, tmp_path, capsys):
    search = ["--track", "west.csv", "--train", "alstom-emu", "--from", "Aston", "--to", "Mid West"]
    assert ends(*search[4:], track="west.csv")[0] == 0
    assert main(["compare", *search, "--at", "5%", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["runs"][0]["destination_m"] == 5000.0
    rows = [f"{at_m},{2.0 * (0.5 * at_m) ** 0.5}" for at_m in range(0, 2500, 100)]
    back = [f"{5000 - at_m},{600.0 - 2.0 * (0.5 * at_m) ** 0.5}" for at_m in range(2500, -1, -100)]
    (tmp_path / "run.csv").write_text("\n".join(["position_m,time_s", *rows, *back]))
    assert main(["score", "run.csv", *search, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert (content["origin_m"], content["destination_m"]) == (0.0, 5000.0)
