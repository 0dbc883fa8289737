"""``tgvdp search --journey``: what a section of a timetable decides, and what the search says it does not keep."""

import json

import pytest

from tests.helpers.format_case import JOURNEY, TTOBENCH_TRACK, TTOBENCH_TRAIN, changed, write_json
from tgvdp.cli import main

LONG = changed(JOURNEY, ("timing points", "values", 5, 2), 1500)


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Function that searches a section of a journey and returns exit code and result."""
    monkeypatch.chdir(tmp_path)
    write_json(tmp_path / "train.json", TTOBENCH_TRAIN)
    write_json(tmp_path / "track.json", TTOBENCH_TRACK)

    def search(section, *options, journey=LONG):
        write_json(tmp_path / "journey.json", journey)
        files = ["--train", "train.json", "--track", "track.json", "--journey", f"journey.json{section}"]
        code = main(["search", *files, "--points", "3", "--no-certify", *options])
        result = tmp_path / "out" / "result.json"
        return code, json.loads(result.read_text()) if result.exists() else None

    return search


def test_a_section_gives_origin_destination_and_longest_time(run, capsys):
    code, result = run("#2")
    assert code == 0
    options, inputs = result["provenance"]["options"], result["provenance"]["inputs"]
    assert (options["origin_m"], options["destination_m"]) == (4000.0, 10_000.0)
    assert options["max_time_s"] == 1140.0
    assert result["front"][-1]["time_s"] <= 1140.0 + 0.05
    assert (inputs["journey"]["file"], inputs["journey"]["part"]) == ("journey.json", "2")
    assert "warning: journey" not in capsys.readouterr().err


def test_what_is_not_kept_is_said(run, capsys):
    slow = changed(LONG, ("timing points", "values", 3), [4, 16, 1000, 0, 0])
    slow = changed(slow, ("timing points", "values", 4), [4, 17, None, 0, 0])
    slow = changed(slow, ("metadata", "id"), "other_01")
    slow = changed(slow, ("metadata", "associated track"), "other")
    code, result = run("", journey=slow)
    assert code == 0
    for text in (
        "it belongs to track other, not to toy",
        "runs shorter than 930 s arrive before the window opens",
        "the search does not keep what is asked of passing: at 2000 m 120 to 150 s and 36 to 72 km/h",
    ):
        assert f"journey other_01, section 1: {text}" in result["warning"]
        assert text in capsys.readouterr().err or text in result["warning"]


def test_a_section_that_no_train_can_run_in_time(run, capsys):
    tight = changed(LONG, ("timing points", "values", 3), [4, 0, 150, 0, 0])
    assert run("", journey=tight)[0] == 4
    assert "no run takes 150 s or less: the fastest one takes" in capsys.readouterr().err


@pytest.mark.parametrize("option", ["--from", "--to", "--start-speed", "--end-speed", "--max-margin"])
def test_what_a_journey_decides_is_not_given_twice(run, capsys, option):
    assert run("", option, "5")[0] == 2
    assert f"--journey and {option} exclude each other" in capsys.readouterr().err


def test_all_that_a_journey_decides_is_named(run, capsys):
    assert run("", "--to", "5", "--reverse", "--from", "3")[0] == 2
    assert "--journey and --from, --to, --reverse exclude each other" in capsys.readouterr().err


def test_a_journey_needs_its_track_and_a_section_on_it(run, capsys):
    assert main(["search", "--journey", "journey.json"]) == 2
    assert "--journey needs the --track that it belongs to" in capsys.readouterr().err
    far = changed(LONG, ("timing points", "values", 5, 0), 11)
    assert run("#2", journey=far)[0] == 3
    assert "journey.json: timing points.values[5]: position 11 km: lies beyond the end of" in capsys.readouterr().err
    assert run("#7")[0] == 3
    assert "journey.json: has sections 1 to 2, got '7'" in capsys.readouterr().err
