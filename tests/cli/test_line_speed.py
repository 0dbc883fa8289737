"""``--line-speed``: lines whose files give no limits, in every command that reads them."""

import json

import pytest

from tests.helpers.format_case import TTOBENCH_TRAIN, write_json
from tests.helpers.osrd_case import OSRD_PATH
from tgvdp.cli import main
from tgvdp.formats import load_track
from tgvdp.model.track import SpeedLimit

BARE = {name: value for name, value in OSRD_PATH.items() if name != "mrsp"}


@pytest.fixture
def line(tmp_path):
    return str(write_json(tmp_path / "line.json", BARE))


def test_validate_says_what_is_missing_and_takes_it(line, capsys):
    assert main(["validate", line]) == 3
    assert "no speed limits: missing field 'mrsp'; --line-speed KMH gives a limit" in capsys.readouterr().err
    assert main(["validate", "-v", line, "--line-speed", "72"]) == 0
    out = capsys.readouterr().out
    assert "speed limits  1, 72 km/h" in out
    assert "highest speed limit 72 km/h" in out


def test_convert_writes_it(line, tmp_path):
    assert main(["convert", line, str(tmp_path / "line.toml"), "--line-speed", "20m/s"]) == 0
    assert load_track(tmp_path / "line.toml").speed_limits == (SpeedLimit(0.0, 20.0),)


def test_search_runs_at_it_and_keeps_it_in_the_provenance(line, tmp_path, capsys):
    trip = ("search", "--to", "3000", "--points", "4", "--out", str(tmp_path / "out"), "--force")
    assert main([*trip, "--track", line, "--line-speed", "72"]) == 0
    assert "changes nothing" not in capsys.readouterr().err
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    assert result["fastest"]["time_s"] > 3000 / 20
    assert json.loads((tmp_path / "out" / "provenance.json").read_text())["options"]["line_speed_kmh"] == 72.0
    whole = str(write_json(tmp_path / "whole.json", OSRD_PATH))
    note = "the line speed asked for, 55 km/h, changes nothing: there is a limit everywhere"
    assert main([*trip, "--track", whole, "--line-speed", "55"]) == 0
    assert f"tgvdp: note: whole.json: {note}" in capsys.readouterr().err
    assert main(["validate", whole, "--line-speed", "55"]) == 0
    assert f"note: {note}" in capsys.readouterr().out
    assert main(["validate", whole]) == 0
    assert "changes nothing" not in capsys.readouterr().out


def test_convert_says_where_it_changes_nothing(tmp_path, capsys):
    """That stood in the notes of the file alone."""
    whole = str(write_json(tmp_path / "whole.json", OSRD_PATH))
    assert main(["convert", whole, str(tmp_path / "line.toml"), "--line-speed", "55"]) == 0
    assert f"note: {whole}: the line speed asked for, 55 km/h, changes nothing" in capsys.readouterr().err


def test_it_is_refused_where_there_is_no_line(line, tmp_path, capsys):
    """It was passed over in silence."""
    train, out = str(write_json(tmp_path / "train.json", TTOBENCH_TRAIN)), tmp_path / "out.toml"
    assert main(["convert", train, str(out), "--line-speed", "72"]) == 2
    assert f"--line-speed is for lines: no line of {train} is written" in capsys.readouterr().err
    assert not out.exists()
    assert main(["validate", train, "--line-speed", "72"]) == 2
    assert "--line-speed is for lines: no file holds one" in capsys.readouterr().err
    assert main(["validate", train, line, "--line-speed", "72"]) == 0


def test_it_is_refused_where_limits_are_never_missing_and_out_of_range(capsys):
    assert main(["search", "--track", "flat-100km", "--line-speed", "72"]) == 3
    assert "native lines have a speed limit everywhere: a line speed would change nothing" in capsys.readouterr().err
    assert main(["search", "--line-speed", "0"]) == 2
