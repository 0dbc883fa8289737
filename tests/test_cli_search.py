"""``tgvdp search`` from option to file, on the real search."""

import csv
import functools
import inspect
import json
import os
import signal
import subprocess
import sys
import time

import pytest

import tgvdp
from tgvdp import api
from tgvdp.cli import main
from tgvdp.cli import search as cli_search

SHORT = ("--track", "flat-100km", "--to", "3000", "--points", "6", "--max-margin", "10")
FILES = {"result.json", "front.csv", "profiles.csv", "front.png", "profile.png"}


def search(out, *arguments):
    return main(["search", *arguments, "--out", str(out)])


@pytest.fixture
def calls(monkeypatch):
    """Records what the command line asks of the search, which runs for real."""
    recorded = []
    real = api.search

    @functools.wraps(real)
    def record(train, track, **arguments):
        recorded.append((train, track, arguments))
        return real(train, track, **arguments)

    monkeypatch.setattr(api, "search", record)
    return recorded


def test_table_and_files(tmp_path, capsys):
    assert search(tmp_path / "out", *SHORT) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.splitlines()[1].split() == [
        *("margin", "time", "delay", "energy", "saved", "kWh/min", "bound", "gap"),
    ]
    assert "fastest run" in out
    assert str(tmp_path / "out") in out
    assert FILES <= {path.name for path in (tmp_path / "out").iterdir()}


def test_json_is_one_object_on_stdout(tmp_path, capsys):
    assert search(tmp_path, *SHORT, "--json") == 0
    out, err = capsys.readouterr()
    content = json.loads(out)
    assert content["schema"] == "tgvdp.search/1"
    assert {"fastest", "front", "counters", "provenance"} <= set(content)
    assert set(content["fastest"]) == {"time_s", "energy_kwh", "balance"}
    for point in content["front"]:
        assert point["replay"]["ok"]
        assert {"id", "time_s", "delay_s", "margin_pct", "energy_kwh", "saved_pct"} <= set(point)
    assert content == json.loads((tmp_path / "result.json").read_text())
    assert "margin" in err


def test_quiet_prints_nothing(tmp_path, capsys):
    assert search(tmp_path, *SHORT, "--quiet") == 0
    assert capsys.readouterr() == ("", "")


def test_quiet_json_prints_the_object_alone(tmp_path, capsys):
    assert search(tmp_path, *SHORT, "--quiet", "--json") == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["front"]
    assert err == ""


def test_defaults_are_left_to_the_search_and_help_tells_them(capsys):
    assert main(["search", "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    defaults = {name: value.default for name, value in inspect.signature(api.search).parameters.items()}
    assert f"Points of the front. [default: {defaults['points']}]" in text
    assert f"the fastest run's. [default: {100 * defaults['max_margin']:g}]" in text
    assert f"How to search. [default: {defaults['method']}]" in text
    assert f"what orders the queue. [default: {defaults['heuristic']}]" in text
    assert f"so many complete paths. [default: {defaults['paths']}]" in text
    assert f"[default: {cli_search.DEFAULT_TRAIN}]" in text
    assert f"[default: {cli_search.DEFAULT_TRACK}]" in text
    assert defaults["dominance"] is defaults["bounds"] is True


def test_every_option_reaches_the_search(tmp_path, calls):
    code = search(
        tmp_path,
        "--train",
        "alstom-emu",
        "--track",
        "flat-100km",
        "--from",
        "1000",
        "--to",
        "3000",
        "--start-speed",
        "36",
        "--end-speed",
        "18",
        "--energy",
        "pantograph",
        "--convention",
        "osrd",
        "--mass-model",
        "point",
        "--limits",
        "head",
        "--curves",
        "roeckl",
        "--no-tunnels",
        "--method",
        "best-first",
        "--points",
        "7",
        "--max-margin",
        "30",
        "--paths",
        "3",
        "--heuristic",
        "time",
        "--segment",
        "500",
        "--speeds",
        "12",
        "--no-dominance",
        "--bounds",
        "--max-labels",
        "100000",
        "--time-limit",
        "20",
        "--no-certify",
        "--quiet",
    )
    ((train, track, arguments),) = calls
    assert code == 0
    assert train == tgvdp.load_train("alstom-emu")
    assert track == tgvdp.load_track("flat-100km")
    assert arguments == pytest.approx(
        {
            "origin_m": 1000.0,
            "destination_m": 3000.0,
            "start_speed_mps": 10.0,
            "end_speed_mps": 5.0,
            "energy": "pantograph",
            "convention": "osrd",
            "mass_model": "point",
            "limits": "head",
            "curves": "roeckl",
            "tunnels": False,
            "method": "best-first",
            "points": 7,
            "max_margin": 0.3,
            "paths": 3,
            "heuristic": "time",
            "segment_m": 500.0,
            "speeds": 12,
            "dominance": False,
            "bounds": True,
            "max_labels": 100000,
            "time_limit_s": 20.0,
        }
    )
    other = {"train", "track", "at_s", "at_margin"}  # --at stands for the last two, of method front only
    assert set(arguments) == set(inspect.signature(api.search).parameters) - other


def test_certificate_is_given_unless_declined(tmp_path, capsys):
    assert search(tmp_path / "proven", *SHORT, "--json") == 0
    content = json.loads(capsys.readouterr().out)
    for point in content["front"][1:]:
        assert point["lower_bound_kwh"] <= point["energy_kwh"]
        assert 0.0 <= point["gap_pct"] < 5.0
        assert point["price_kwh_per_min"] > 0.0
    assert content["front"][0]["price_kwh_per_min"] is None
    assert {"elapsed_s", "elapsed_verify_s", "elapsed_certify_s"} <= set(content["provenance"])

    assert search(tmp_path / "plain", *SHORT, "--no-certify", "--json") == 0
    out, err = capsys.readouterr()
    declined = json.loads(out)
    assert all(point["gap_pct"] is None for point in declined["front"])
    assert "elapsed_certify_s" not in declined["provenance"]
    assert "gap" not in err
    assert (tmp_path / "plain" / "front.png").read_bytes() != (tmp_path / "proven" / "front.png").read_bytes()


def test_grid_has_bounds_but_no_prices(tmp_path, capsys):
    arguments = ("--method", "exact", "--segment", "200", "--speeds", "40", "--max-margin", "20")
    assert search(tmp_path, *SHORT, *arguments, "--json") == 0
    out, err = capsys.readouterr()
    front = json.loads(out)["front"]
    assert all(point["lower_bound_kwh"] <= point["energy_kwh"] for point in front)
    assert all(point["price_kwh_per_min"] is None for point in front)
    assert "kWh/min" not in err


def test_command_line_wins_over_the_scenario(tmp_path, calls):
    scenario = tmp_path / "trip.toml"
    scenario.write_text(
        'train = "alstom-emu"\ntrack = "flat-100km"\n'
        "[run]\nto_m = 3000.0\npoints = 5\nmax_margin_pct = 20.0\nend_speed_kmh = 36.0\n"
    )
    code = search(tmp_path / "out", "--scenario", str(scenario), "--train", "tgv", "--points", "6", "--quiet")
    assert code == 0
    ((train, track, arguments),) = calls
    assert train == tgvdp.load_train("tgv")
    assert track == tgvdp.load_track("flat-100km")
    assert arguments == {"destination_m": 3000.0, "points": 6, "max_margin": 0.2, "end_speed_mps": 10.0}
    inputs = json.loads((tmp_path / "out" / "result.json").read_text())["provenance"]["inputs"]
    assert set(inputs) == {"scenario", "train", "track"}


def test_stations_of_a_metro(shared, tmp_path, capsys):
    tracks = shared / "ttobench"
    code = search(
        tmp_path,
        "--track",
        str(tracks / "tracks" / "CN_Songjiazhuang_Yizhuang.json"),
        "--train",
        str(next((tracks / "trains").glob("CN_*.json"), tracks / "trains" / "CH_Stadler_KISS_SBB.json")),
        "--to",
        "2631",
        "--points",
        "10",
        "--json",
    )
    assert code == 0
    content = json.loads(capsys.readouterr().out)
    assert len(content["front"]) > 1
    assert all(point["replay"]["ok"] for point in content["front"])
    with (tmp_path / "front.csv").open() as file:
        assert len(list(csv.DictReader(file))) == len(content["front"])


@pytest.mark.parametrize(
    ("arguments", "code", "part"),
    [
        (["--train", "tvg"], 3, "'tgv'"),
        (["--track", "flat-100"], 3, "'flat-100km'"),
        (["--track", "missing.json"], 3, "missing.json"),
        (["--train", ""], 3, ""),
        (["--scenario", "missing.toml"], 3, "missing.toml"),
        (["--from", "3000", "--to", "2000"], 3, "origin"),
        (["--to", "100001"], 3, "100001"),
        (["--start-speed", "1000", "--to", "3000"], 4, ""),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(arguments, code, part, tmp_path, capsys):
    assert search(tmp_path / "out", "--track", "flat-100km", *arguments) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("tgvdp: error: ")
    assert err.count("\n") == 1
    assert part in err
    assert not (tmp_path / "out").exists()


def test_unwritable_folder_is_found_before_the_search(tmp_path, calls, capsys):
    (tmp_path / "file").write_text("no folder")
    assert search(tmp_path / "file" / "out", *SHORT) == 3
    assert calls == []
    assert "file" in capsys.readouterr().err


def test_partial_result_is_written_labelled_and_exits_with_5(tmp_path, capsys):
    code = search(
        tmp_path,
        "--track",
        "flat-100km",
        "--to",
        "5000",
        "--method",
        "best-first",
        "--segment",
        "500",
        "--speeds",
        "40",
        "--heuristic",
        "time",
        "--paths",
        "100000",
        "--max-labels",
        "1000",
        "--json",
    )
    out, err = capsys.readouterr()
    assert code == 5
    content = json.loads(out)
    assert content["complete"] is False
    assert content["warning"]
    assert "budget" in err
    assert (tmp_path / "result.json").exists()


def test_naive_search_ends_by_its_budget_with_a_clear_message(tmp_path, capsys):
    code = search(
        tmp_path / "out",
        "--track",
        "flat-100km",
        "--method",
        "best-first",
        "--no-dominance",
        "--no-bounds",
        "--max-labels",
        "100000",
    )
    out, err = capsys.readouterr()
    assert code == 5
    assert out == ""
    assert err.count("\n") == 1
    assert "budget" in err
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_interrupt_leaves_no_files_and_exits_with_130(tmp_path):
    command = [
        sys.executable,
        "-m",
        "tgvdp",
        "search",
        "--method",
        "best-first",
        "--no-dominance",
        "--no-bounds",
        "--max-labels",
        "500000000",
        "--time-limit",
        "60",
        "--out",
        str(tmp_path / "out"),
    ]
    environment = {name: text for name, text in os.environ.items() if name != "NUMBA_DISABLE_JIT"}
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment) as process:
        time.sleep(1.0)  # inside imports, compilation or the search: all must end alike
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=30)
    assert process.returncode == 130
    assert errors == "tgvdp: error: interrupted\n"
    assert not (tmp_path / "out").exists()
