"""``tgvdp convert``: formats by suffix or option, losses on stderr, nothing overwritten or half-written."""

import json
import tomllib

import pytest

from tests.helpers.format_case import SCENARIO, TTOBENCH_TRACK, TTOBENCH_TRAIN, write_json
from tgvdp.cli import main
from tgvdp.formats import load_energy_map, load_scenario, load_track, load_train


def run(*arguments):
    return main(["convert", *map(str, arguments)])


@pytest.fixture
def train(tmp_path):
    return write_json(tmp_path / "train.json", TTOBENCH_TRAIN)


def test_ttobench_to_native_and_back(train, tmp_path, capsys):
    assert run(train, tmp_path / "a.toml") == 0
    assert run(tmp_path / "a.toml", tmp_path / "b.json") == 0
    assert load_train(tmp_path / "a.toml") == load_train(tmp_path / "b.json") == load_train(train)
    assert capsys.readouterr() == ("", "tgvdp: lost: train toy: num seats: not held by this format\n")
    assert "metadata" in json.loads((tmp_path / "b.json").read_text())


def test_stdout_is_no_file(train, tmp_path, monkeypatch, capsys):
    """A file of that name was written."""
    monkeypatch.chdir(tmp_path)
    assert run("--to", "toml", train, "-") == 3
    message = "this is not written to stdout, got '-' (a file of that name is ./-)"
    assert capsys.readouterr().err == f"tgvdp: error: {message}\n"
    assert [file.name for file in tmp_path.iterdir()] == [train.name]


def test_the_option_wins_over_the_suffix(train, tmp_path):
    assert run("--to", "json", train, tmp_path / "a.json") == 0
    assert set(json.loads((tmp_path / "a.json").read_text())) == {"name", "train"}
    assert run("--to", "toml", train, tmp_path / "a.txt") == 0
    assert tomllib.loads((tmp_path / "a.txt").read_text())["train"]["mass_t"] == 200


def test_a_map_is_taken_alone(tmp_path, capsys):
    """It ended in a traceback."""
    assert run("--only", "map", "alstom-map", tmp_path / "map.toml") == 0
    assert capsys.readouterr() == ("", "")
    assert load_energy_map(tmp_path / "map.toml") == load_energy_map("alstom-map")


def test_a_scenario_keeps_its_options_and_can_be_taken_apart(tmp_path, capsys):
    (tmp_path / "trip.toml").write_text(SCENARIO)
    assert run(tmp_path / "trip.toml", tmp_path / "copy.toml") == 0
    before, after = (load_scenario(tmp_path / f"{name}.toml") for name in ("trip", "copy"))
    assert (after.train, after.track, after.options) == (before.train, before.track, before.options)
    assert run("--only", "track", tmp_path / "trip.toml", tmp_path / "track.json") == 0
    assert load_track(tmp_path / "track.json") == before.track
    assert capsys.readouterr().err == ""
    assert run("--only", "journey", tmp_path / "trip.toml", tmp_path / "journey.json") == 3
    assert capsys.readouterr().err.endswith("trip.toml: holds no journey\n")


def test_names_of_the_catalog_convert_too(tmp_path):
    assert run("lgv-100km", tmp_path / "line.json") == 0
    assert load_track(tmp_path / "line.json").gradients == load_track("lgv-100km").gradients


def test_nothing_is_overwritten_without_force(train, tmp_path, capsys):
    out = tmp_path / "a.toml"
    out.write_text("mine")
    assert run(train, out) == 3
    assert capsys.readouterr().err == f"tgvdp: error: {out}: exists already (--force overwrites it)\n"
    assert out.read_text() == "mine"
    assert run("--force", train, out) == 0
    assert load_train(out) == load_train(train)


def test_losses_are_said_on_stderr(tmp_path, capsys):
    track = write_json(
        tmp_path / "t.json", TTOBENCH_TRACK | {"metadata": TTOBENCH_TRACK["metadata"] | {"id": "St Gall"}}
    )
    assert run(track, tmp_path / "a.json") == 0
    out, err = capsys.readouterr()
    assert (out, err) == ("", "tgvdp: lost: track St Gall: name: 'St Gall' reads back as 'St_Gall'\n")


@pytest.mark.parametrize(
    ("arguments", "code", "part"),
    [
        (["train.json", "a.xml"], 2, "unknown suffix '.xml': give --to"),
        (["train.json"], 2, "Missing argument 'OUT'"),
        (["train.json", "a.json", "--to", "yaml"], 2, "'yaml' is not one of"),
        (["absent.json", "a.toml"], 3, "absent.json: no such file"),
        (["alstom-emu", "a.json"], 3, "TTOBench holds a force and a power limit"),
        (["train.json", "train.json/a.toml"], 3, "there is no folder train.json"),
        (["train.json", "absent/a.toml"], 3, "absent/a.toml: there is no folder absent"),
    ],
)
def test_errors_are_one_line_and_write_nothing(train, tmp_path, monkeypatch, capsys, arguments, code, part):
    monkeypatch.chdir(tmp_path)
    assert run(*arguments) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("tgvdp: error: ")
    assert part in err
    assert err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["train.json"]


def test_the_description_of_a_ttobench_file_is_its_notes_and_comes_back(tmp_path, capsys):
    """What tgvdp had written there was lost by the next conversion, without a word."""
    assert run("tgv", tmp_path / "a.json") == 0
    assert run(tmp_path / "a.json", tmp_path / "b.json") == 0
    assert run(tmp_path / "b.json", tmp_path / "c.toml") == 0
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    notes = "; ".join(load_train("tgv").notes)
    assert "; ".join(load_train(tmp_path / "c.toml").notes) == notes
    assert json.loads((tmp_path / "a.json").read_text())["metadata"]["description"] == notes
    capsys.readouterr()
    options = ["--to", "3km", "--points", "2", "--no-certify", "--no-pictures", "--out", str(tmp_path / "out")]
    assert main(["search", "--train", str(tmp_path / "a.json"), *options]) == 0
    assert "source" not in capsys.readouterr().err  # nobody is warned of a file's own words
