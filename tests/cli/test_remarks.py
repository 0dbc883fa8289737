"""What readers note on files (what is not used, what was assumed) is said by commands, once, and kept with results."""

import json
from hashlib import sha256

import pytest

from tests.helpers.format_case import write_json
from tests.helpers.osrd_case import OSRD_TRAIN
from tgvdp.cli import main
from tgvdp.cli.notes import remarked

LINE = "position_m,speed_kmh,gradient,remark\n0,90,5,a\n3000,90,,\n"
TRAIN = (
    "[train]\nmass_t = 200\nmax_speed_kmh = 120\ndavis_a_n = 2000\ndavis_b_n_per_kmh = 10\n"
    'davis_c_n_per_kmh2 = 0.5\nfriction_brake_kn = 150\ntraction = { file = "effort.csv" }\nnotes = ["my own"]\n'
)
NOTE = "line.csv: columns not used: 'remark'"


@pytest.fixture
def line(tmp_path):
    """A line with a column that is not used."""
    path = tmp_path / "line.csv"
    path.write_text(LINE.replace("gradient", "gradient_permil"))
    return path


def search(out, *arguments):
    asked = ("--points", "4", "--no-certify", "--no-pictures", "--out", out)
    return main(["search", *map(str, (*arguments, *asked))])


def test_search_says_what_readers_noted_and_result_json_keeps_it(line, tmp_path, capsys):
    assert search(tmp_path / "out", "--train", "alstom-emu", "--track", line, "--json") == 0
    said = capsys.readouterr()
    assert said.err.count(f"tgvdp: note: {NOTE}\n") == 1
    inputs = json.loads(said.out)["provenance"]["inputs"]
    assert inputs["track"]["notes"] == [NOTE]
    assert "notes" not in inputs["train"]
    assert search(tmp_path / "quiet", "--train", "alstom-emu", "--track", line, "--quiet") == 0
    assert capsys.readouterr().err == ""


def test_notes_of_files_that_a_scenario_references(line, tmp_path, capsys):
    (tmp_path / "effort.csv").write_text("speed_kmh,effort_kn,mode\n0,200,a\n100,100,b\n")
    scenario = tmp_path / "trip.toml"
    scenario.write_text(f'track = "line.csv"\n{TRAIN}')
    assert search(tmp_path / "out", "--scenario", scenario) == 0
    said = capsys.readouterr().err
    assert (
        said.count(f"tgvdp: note: {NOTE}\n") == said.count("tgvdp: note: effort.csv: columns not used: 'mode'\n") == 1
    )
    assert "my own" not in said
    assert search(tmp_path / "other", "--scenario", scenario, "--train", "alstom-emu") == 0
    assert "effort.csv" not in capsys.readouterr().err


def test_tables_of_fields_that_are_set_are_inputs(line, tmp_path, capsys):
    """Those of a native train are, too: neither its curve nor that of --set was to be known again."""
    table = tmp_path / "effort.csv"
    table.write_text("speed_kmh,effort_kn\n50,150\n100,100\n")
    note = "effort.csv: effort below 50 km/h is taken to be as large as there"
    asked = ("--track", line, "--set", f'train.traction={{file="{table}"}}')
    assert search(tmp_path / "out", "--train", "alstom-emu", *asked, "--json") == 0
    said = capsys.readouterr()
    assert said.err.count(f"tgvdp: note: {note}\n") == 1
    digest = sha256(table.read_bytes()).hexdigest()
    assert json.loads(said.out)["provenance"]["inputs"]["set"] == {"beside": {"effort.csv": digest}, "notes": [note]}
    train = tmp_path / "train.toml"
    train.write_text(TRAIN)
    assert search(tmp_path / "native", "--train", train, "--track", line, "--json") == 0
    held = json.loads(capsys.readouterr().out)["provenance"]["inputs"]["train"]
    assert (held["beside"], held["notes"]) == ({"effort.csv": digest}, [note])


def test_journeys_and_comparisons_say_it_once(line, tmp_path, capsys):
    trains = ("--train", "alstom-emu", "--train", "tgv")
    assert (
        main(["journey", "--track", str(line), *trains, "--points", "3", "--no-pictures", "--out", f"{tmp_path}/j"])
        == 0
    )
    assert capsys.readouterr().err.count(NOTE) == 1
    assert main(["compare", *trains, "--track", str(line), "--out", str(tmp_path / "c")]) == 0
    assert capsys.readouterr().err.count(NOTE) == 1


def test_sweeps_and_instances_say_it_once(line, tmp_path, capsys):
    spec = tmp_path / "spec.toml"
    spec.write_text(f'trains = ["alstom-emu", "tgv"]\nlines = ["{line.name}"]\nrun = {{ points = 3 }}\n')
    assert main(["sweep", str(spec), "--dry-run"]) == 0
    assert capsys.readouterr().err.count(f"tgvdp: note: {NOTE}\n") == 1
    asked = ("--train", "alstom-emu", "--track", str(line), "--to", "instance", "-o", str(tmp_path / "i.json"))
    assert main(["formulate", "--steps", "60", *asked]) == 0
    assert capsys.readouterr().err.count(f"tgvdp: note: {NOTE}\n") == 1


def test_of_many_notes_the_first_are_said(tmp_path):
    notes = [f"stock.json: {number}" for number in range(7)]
    assert list(remarked(notes)) == [*notes[:3], "4 more notes on what was read: tgvdp validate tells them"]
    assert list(remarked(notes[:4])) == notes[:4]
    (long,) = remarked(["x" * 1000])
    assert len(long) < 250


def test_what_an_osrd_train_assumes_is_said(line, tmp_path, capsys):
    stock = write_json(tmp_path / "stock.json", OSRD_TRAIN)
    assert search(tmp_path / "out", "--train", stock, "--track", line) == 0
    said = capsys.readouterr().err
    assert "tgvdp: note: stock.json: resistance is taken to be in N, as A is above 1\n" in said
    assert "tgvdp: note: 2 more notes on what was read: tgvdp validate tells them\n" in said
