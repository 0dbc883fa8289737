"""What ``tgvdp search`` does with its input: read once, set, noted where it does not act; and whose folder it takes."""

import hashlib
import json
from collections import Counter
from pathlib import Path

import pytest

from tgvdp.cli import main
from tgvdp.cli.notes import idle
from tgvdp.formats import load_track, load_train
from tgvdp.formats.syntax import reading
from tgvdp.model.convention import convention_of
from tgvdp.model.track import Track
from tgvdp.model.trip import Trip

SHORT = ("--track", "flat-100km", "--to", "3km", "--points", "4", "--no-certify")


def search(out, *arguments):
    return main(["search", *map(str, arguments), "--out", str(out)])


def result_of(out):
    return json.loads((out / "result.json").read_text())


@pytest.fixture
def files(tmp_path):
    """A train, a line and a scenario of one's own."""
    paths = {name: tmp_path / f"{name}.toml" for name in ("train", "track", "trip")}
    for kind, name in (("train", "alstom-emu"), ("track", "flat-100km")):
        assert main(["convert", "--to", "toml", name, str(paths[kind])]) == 0
    paths["trip"].write_text('train = "train.toml"\ntrack = "track.toml"\n[run]\nto_m = 3000\npoints = 4\n')
    return paths


def test_each_file_is_read_once_and_its_hash_is_that_of_what_was_read(files, tmp_path, monkeypatch):
    reads = Counter()
    real = reading.read_bytes

    def read_and_spoil(path):
        reads[Path(path).name] += 1
        data = real(path)
        Path(path).write_bytes(b"somebody else wrote here")
        return data

    before = {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in files.items()}
    monkeypatch.setattr(reading, "read_bytes", read_and_spoil)
    asked = ("--to", 3000, "--points", 4, "--no-certify", "--quiet")
    assert search(tmp_path / "out", "--train", files["train"], "--track", files["track"], *asked) == 0
    assert reads == {"train.toml": 1, "track.toml": 1}
    inputs = result_of(tmp_path / "out")["provenance"]["inputs"]
    assert inputs == {
        "train": {"file": "train.toml", "sha256": before["train"]},
        "track": {"file": "track.toml", "sha256": before["track"]},
    }


def test_a_scenario_is_read_once(files, tmp_path, monkeypatch):
    reads = Counter()
    real = reading.read_bytes
    monkeypatch.setattr(reading, "read_bytes", lambda path: reads.update([Path(path).name]) or real(path))
    assert search(tmp_path / "out", "--scenario", files["trip"], "--quiet", "--no-certify") == 0
    assert reads == {"trip.toml": 1, "train.toml": 1, "track.toml": 1}
    assert set(result_of(tmp_path / "out")["provenance"]["inputs"]) == {"scenario", "train", "track"}


def test_fields_that_were_set_are_searched_shown_and_kept(tmp_path, capsys):
    setting = ("--set", "train.mass_t=500", "--set", "track.speed_limits[0].speed_kmh=90")
    assert search(tmp_path / "plain", *SHORT) == search(tmp_path / "set", *SHORT, *setting) == 0
    assert "with train.mass_t=500, track.speed_limits[0].speed_kmh=90" in capsys.readouterr().out
    plain, with_fields = (result_of(tmp_path / name) for name in ("plain", "set"))
    assert with_fields["provenance"]["options"]["set"] == ["train.mass_t=500", "track.speed_limits[0].speed_kmh=90"]
    assert "set" not in plain["provenance"]["options"]
    assert with_fields["fastest"]["time_s"] > plain["fastest"]["time_s"]


def test_restrictions_and_direction_of_a_scenario(files, tmp_path):
    with files["trip"].open("a") as file:
        file.write('reverse = true\nspeed_restriction = ["1km:2km:72", "2500:2600:36"]\nwind_kmh = 18\n')
    assert search(tmp_path / "out", "--scenario", files["trip"], "--quiet", "--no-certify") == 0
    options = result_of(tmp_path / "out")["provenance"]["options"]
    assert (options["reverse"], options["wind_mps"]) == (True, 5.0)
    assert options["speed_restrictions"] == [[1000.0, 2000.0, 20.0], [2500.0, 2600.0, 10.0]]
    wins = ("--no-reverse", "--speed-restriction", "0:1km:50", "--wind", "0")
    assert search(tmp_path / "out", "--scenario", files["trip"], *wins, "--quiet", "--no-certify") == 0
    options = result_of(tmp_path / "out")["provenance"]["options"]
    assert (options["reverse"], options["wind_mps"], len(options["speed_restrictions"])) == (False, 0.0, 1)


@pytest.mark.parametrize("line", ['speed_restriction = "1km:2km:72"', 'speed_restriction = ["1km:2km"]', "reverse = 1"])
def test_a_wrong_run_table_is_said(line, files, capsys):
    with files["trip"].open("a") as file:
        file.write(f"{line}\n")
    assert main(["validate", str(files["trip"])]) == 3
    assert f"run.{line.partition(' ')[0]}" in capsys.readouterr().err


def test_energy_in_any_case_and_misspelt(tmp_path, capsys):
    assert search(tmp_path / "out", *SHORT, "--energy", "Pantograph", "--quiet") == 0
    assert result_of(tmp_path / "out")["energy"] == {"model": "pantograph"}
    assert search(tmp_path / "other", *SHORT, "--energy", "pantografh") == 3
    assert capsys.readouterr().err.endswith("unknown energy 'pantografh', did you mean 'pantograph'?\n")


def test_a_train_without_brakes_is_said(tmp_path, capsys):
    setting = ("--set", "train.friction_brake_kn=0", "--set", "train.braking={ force_kn = 0 }")
    assert search(tmp_path / "out", "--track", "lgv-100km", "--from", "90km", "--train", "alstom-emu", *setting) == 4
    note, error = capsys.readouterr().err.splitlines()
    assert "this train has no brake" in note
    assert "has no brakes: it cannot keep its speed down at" in error


# Notes


def busy_line(**held):
    return Track(length_m=9000.0, speed_limits=((0.0, 30.0),), name="line", **held)


@pytest.mark.parametrize(
    ("held", "switches", "notes"),
    [
        ({}, {}, []),
        (
            {"stops_m": (0.0, 1000.0, 9000.0)},
            {},
            ["1 stop between origin and destination is passed: tgvdp journey stops there"],
        ),
        (
            {"stops_m": (0.0, 1000.0, 2000.0, 8500.0)},
            {},
            ["2 stops between origin and destination are passed: tgvdp journey stops there"],
        ),
        ({"curves": ((0.0, 500.0, 500.0),)}, {}, ["1 curve of the line counts nothing: --curves is none"]),
        ({"curves": ((0.0, 500.0, 500.0),)}, {"curves": "roeckl"}, []),
        ({"curves": ((0.0, float("inf"), float("inf")), (8500.0, 300.0, 300.0))}, {}, []),
        ({"tunnels": ((100.0, 50.0, 60.0),)}, {}, ["1 tunnel of the line counts nothing without --tunnels"]),
        (
            {"tunnels": ((100.0, 50.0, 60.0), (200.0, 50.0, 60.0))},
            {"tunnels": True},
            ["2 tunnels of the line count nothing: train Alstom EMU has no tunnel drag"],
        ),
    ],
)
def test_what_does_not_act_is_noted(held, switches, notes):
    train = load_train("alstom-emu")
    trip = Trip(
        train=train,
        track=busy_line(**held),
        origin_m=0.0,
        destination_m=8000.0,
        convention=convention_of("ttobench", **switches),
    )
    assert list(idle(trip)) == [note.replace("Alstom EMU", train.name) for note in notes]


def test_restrictions_that_make_nothing_slower_are_noted(tmp_path, capsys):
    away = ("--speed-restriction", "2000:3000:400", "--speed-restriction", "20km:21km:80")
    assert search(tmp_path / "out", *SHORT, *away, "--speed-restriction", "2000:3000:60") == 0
    notes = [line for line in capsys.readouterr().err.splitlines() if "restriction" in line]
    assert notes == [
        "tgvdp: note: the speed restriction from 2000 to 3000 m changes nothing: 400 km/h are not reached there anyway",
        "tgvdp: note: the speed restriction from 20000 to 21000 m lies outside the trip",
    ]


def test_built_in_lines_have_no_parts(tmp_path, capsys):
    assert search(tmp_path / "out", "--track", "lgv-100km#1") == 3
    assert capsys.readouterr().err == "tgvdp: error: the built-in track 'lgv-100km' has no part '1': it is one track\n"


def test_slips_of_unit_are_noted_and_quiet_silences(tmp_path, capsys):
    slip = (*SHORT, "--set", "train.mass_t=212000")
    assert search(tmp_path / "out", *slip) == 0
    err = capsys.readouterr().err
    assert "tgvdp: note: train tgv: mass 2.12e+05 t (usual 10 to 40000: t or kg?)" in err
    assert search(tmp_path / "out", *slip, "--quiet") == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("train", ["tgv", "alstom-emu"])
def test_the_catalog_looks_usual(train, tmp_path, capsys):
    assert search(tmp_path / "out", *SHORT, "--train", train) == 0
    assert capsys.readouterr().err == ""
    assert load_track("flat-100km").name


# The folder


@pytest.mark.parametrize("command", ["search", "journey", "score tgv", "compare --train tgv", "sweep a.toml"])
def test_an_empty_name_is_no_folder(command, tmp_path, monkeypatch, capsys):
    """As of a variable of the shell that is not set: results went into the working folder."""
    monkeypatch.chdir(tmp_path)
    assert main([*command.split(), "--out", ""]) == 3
    assert "a folder for results must have a name, got an empty text" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", ["search", "journey", "score tgv", "compare --train tgv", "sweep a.toml", "bench"])
def test_stdout_is_no_folder(command, tmp_path, monkeypatch, capsys):
    """It was made as a folder of that name."""
    monkeypatch.chdir(tmp_path)
    assert main([*command.split(), "--out", "-"]) == 3
    assert "a folder for results cannot be stdout, got '-' (a folder of that name is ./-)" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_folder_of_somebody_else_is_not_written_into(tmp_path, capsys):
    out = tmp_path / "out"
    out.mkdir()
    (out / "front.csv").write_text("mine")
    (out / "provenance.json").write_text('{"schema": "else/1", "files": {"front.csv": ""}}')
    assert search(out, *SHORT) == 3
    assert capsys.readouterr().err.endswith("is not empty, and no results of tgvdp are in it (--force writes there)\n")
    assert (out / "front.csv").read_text() == "mine"
    assert search(out, *SHORT, "--force", "--quiet") == 0
    assert (out / "front.csv").read_text() != "mine"


@pytest.mark.parametrize("ledger", ["", "[]", "null", '{"schema": "tgvdp.provenance/1"}', '{"files": {}}', "\0"])
def test_a_broken_ledger_is_nobodys(ledger, tmp_path):
    (tmp_path / "provenance.json").write_text(ledger)
    assert search(tmp_path, *SHORT) == 3


def test_an_empty_folder_and_one_of_ours_are_written_without_asking(tmp_path):
    assert search(tmp_path, *SHORT, "--quiet") == 0
    assert search(tmp_path, *SHORT, "--quiet") == 0


def test_no_file_of_an_earlier_search_stays(tmp_path):
    assert search(tmp_path, *SHORT, "--quiet") == 0
    (tmp_path / "notes.txt").write_text("mine")
    assert search(tmp_path, *SHORT, "--profiles", "railtoolkit", "--quiet") == 0
    names = {path.name for path in tmp_path.iterdir()}
    assert "driving_course.csv" in names
    assert "profiles.csv" not in names
    assert "notes.txt" in names
    assert names - {"notes.txt", "provenance.json"} == set(
        json.loads((tmp_path / "provenance.json").read_text())["files"]
    )


def test_a_file_of_an_earlier_search_that_somebody_changed_stays(tmp_path):
    assert search(tmp_path, *SHORT, "--quiet") == 0
    (tmp_path / "profiles.csv").write_text("edited")
    assert search(tmp_path, *SHORT, "--profiles", "railtoolkit", "--quiet") == 0
    assert (tmp_path / "profiles.csv").read_text() == "edited"


# Budgets


@pytest.mark.parametrize(
    ("budget", "said", "method"),
    [
        (("--max-labels", "500"), "the budget of 500 labels ended the search", "best-first"),
        (("--max-labels", "50"), "the budget of 50 labels ended the search", "exact"),
        (("--max-labels", "100000000", "--time-limit", "0.001"), "the time limit passed", "exact"),
    ],
)
def test_the_part_of_the_budget_that_ended_is_named(budget, said, method, tmp_path, capsys):
    grid = ("--method", method, "--segment", "500", "--speeds", "40")
    assert search(tmp_path / "out", "--track", "flat-100km", "--to", "20km", *grid, *budget) == 5
    assert said in capsys.readouterr().err


def test_an_empty_list_of_points_is_refused(tmp_path, capsys):
    assert main(["search", "--at", "", "--out", str(tmp_path / "out")]) == 2
    assert "--at" in capsys.readouterr().err
