"""Options of ``tgvdp search``: each reaches the search, or is refused before it."""

import functools
import inspect
import json

import pytest

import tgvdp
from tgvdp import api
from tgvdp.cli import main, search_options
from tgvdp.constants import METHODS
from tgvdp.methods.budget import SearchBudget
from tgvdp.options.search import OPTIONS

SHORT = ("--track", "flat-100km", "--to", "3000", "--points", "6", "--max-margin", "10")


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


def test_defaults_are_left_to_the_search_and_help_tells_them(capsys):
    assert main(["search", "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    defaults = {name: value.default for name, value in inspect.signature(api.search).parameters.items()}
    assert f"front: number of points. [default: {defaults['points']}]" in text
    assert f"the fastest run's. [default: {100 * defaults['max_margin']:g}]" in text
    assert f"How to search. [default: {defaults['method']}]" in text
    assert f"what orders the queue. [default: {defaults['heuristic']}]" in text
    assert f"so many complete paths, 0: find all. [default: {defaults['paths']}]" in text
    assert f"End after so many seconds. [default: {SearchBudget().time_limit_s:g}]" in text
    assert "--curves [none|800/R|roeckl]" in text
    assert f"[default: {search_options.DEFAULT_TRAIN}]" in text
    assert f"[default: {search_options.DEFAULT_TRACK}]" in text
    assert defaults["dominance"] is defaults["bounds"] is True


def test_every_option_reaches_the_search(tmp_path, calls):
    line = "--train alstom-emu --track flat-100km --reverse --speed-restriction 1500:2km:72"
    trip = f"{line} --from 1000 --to 3000 --start-speed 36 --end-speed 18"
    line = "--convention osrd --mass-model point --limits head --curves roeckl --no-tunnels --wind 18"
    common = f"--energy wheel {line} --max-margin 30 --time-limit 20 --max-memory 4GB --no-certify --quiet"
    grid = "--segment 500 --speeds 12 --max-labels 100000"
    best_first = "--method best-first --paths 3 --heuristic time --no-dominance --bounds"
    for out, options in enumerate(("--points 7 --clean --min-phase 3", f"{grid} {best_first}")):
        assert search(tmp_path / str(out), *f"{trip} {common} {options}".split()) == 0
    (train, track, on_front), (_, _, on_grid) = calls
    assert train == tgvdp.load_train("alstom-emu")
    assert track == tgvdp.load_track("flat-100km")
    shared = {
        "origin_m": 1000.0,
        "destination_m": 3000.0,
        "start_speed_mps": 10.0,
        "end_speed_mps": 5.0,
        "reverse": True,
        "speed_restrictions": ((1500.0, 2000.0, 20.0),),
        "wind_mps": 5.0,
        "energy": "wheel",
        "convention": "osrd",
        "mass_model": "point",
        "limits": "head",
        "curves": "roeckl",
        "tunnels": False,
        "max_margin": 0.3,
        "max_memory_b": 4e9,
    }
    other = {"train", "track", "at_s", "at_margin", "max_time_s"}  # --at and --journey stand for the last three
    assert set(on_front) | set(on_grid) == set(inspect.signature(api.search).parameters) - other
    for one in (on_front, on_grid):  # replay, proof and tables keep a second each
        assert 10.0 <= one.pop("time_limit_s") <= 17.0
    assert on_front == shared | {"points": 7, "clean": True, "min_phase_s": 3.0}
    assert on_grid == shared | {
        "method": "best-first",
        "paths": 3,
        "heuristic": "time",
        "segment_m": 500.0,
        "speeds": 12,
        "dominance": False,
        "bounds": True,
        "max_labels": 100000,
    }
    for out in "01":
        assert json.loads((tmp_path / out / "result.json").read_text())["provenance"]["options"]["time_limit_s"] == 20.0


@pytest.mark.parametrize("method", ["front", "exact"])
def test_a_trace_of_a_method_without_a_queue_is_refused_before_the_search(tmp_path, calls, capsys, method):
    scenario = tmp_path / "trip.toml"
    scenario.write_text(f'train = "tgv"\ntrack = "flat-100km"\n[run]\nmethod = "{method}"\n')
    for named in (("--method", method), ("--scenario", str(scenario))):
        assert search(tmp_path / "out", *named, "--trace") == 2
        assert f"--trace belongs to method best-first, not to {method}" in capsys.readouterr().err
    assert search(tmp_path / "out", "--trace") == 2
    assert not calls


#: For each option that some methods only have a value other than its default: as a flag, in a file, in Python.
FOREIGN = {
    "points": ("--points 7", "points = 7", 7),
    "at_s": ("--at 200s", 'at = "200s"', (200.0,)),
    "at_margin": ("--at 5%", 'at = "5%"', (0.05,)),
    "clean": ("--clean", "clean = true", True),
    "min_phase_s": ("--min-phase 3", "min_phase_s = 3.0", 3.0),
    "paths": ("--paths 7", "paths = 7", 7),
    "heuristic": ("--heuristic time", 'heuristic = "time"', "time"),
    "dominance": ("--no-dominance", "dominance = false", False),
    "bounds": ("--no-bounds", "bounds = false", False),
    "segment_m": ("--segment 500", "segment_m = 500.0", 500.0),
    "speeds": ("--speeds 12", "speeds = 12", 12),
    "max_labels": ("--max-labels 900", "max_labels = 900", 900),
}


OWNERS = {one.argument: one.methods for one in OPTIONS if one.methods != METHODS}


@pytest.mark.parametrize("option", OWNERS)
def test_options_that_the_method_does_not_have_are_refused(option, tmp_path, capsys):
    flag, line, value = FOREIGN[option]
    trip = ("--train", "alstom-emu", "--track", "flat-100km", "--to", "3000")
    train, track = tgvdp.load_train("alstom-emu"), tgvdp.load_track("flat-100km")
    for method in set(METHODS) - set(OWNERS[option]):
        assert search(tmp_path / "out", *trip, "--method", method, *flag.split()) == 2
        assert flag.split()[0].replace("--no-", "--") in capsys.readouterr().err
        scenario = tmp_path / "trip.toml"
        scenario.write_text(f'train = "alstom-emu"\ntrack = "flat-100km"\n[run]\nmethod = "{method}"\n{line}\n')
        assert search(tmp_path / "out", "--scenario", str(scenario)) == 3
        error = capsys.readouterr().err
        assert error.count("\n") == 1
        assert f"run.{line.partition(' ')[0]}" in error
        with pytest.raises(tgvdp.InputError, match=option):
            tgvdp.search(train, track, destination_m=3000.0, method=method, **{option: value})
    assert not (tmp_path / "out").exists()


def test_another_method_on_the_command_line_leaves_the_options_of_the_scenarios_method(tmp_path, calls):
    scenario = tmp_path / "trip.toml"
    scenario.write_text(
        'train = "alstom-emu"\ntrack = "flat-100km"\n[run]\nto_m = 3000.0\nmethod = "best-first"\n'
        "paths = 5\nspeeds = 15\nsegment_m = 300.0\n"
    )
    assert search(tmp_path / "out", "--scenario", str(scenario), "--method", "exact", "--quiet") == 0
    ((_, _, arguments),) = calls
    del arguments["time_limit_s"]  # what replay, proof and tables leave of it
    assert arguments == {"destination_m": 3000.0, "method": "exact", "speeds": 15, "segment_m": 300.0}


def test_all_options_without_effect_are_named(tmp_path, calls, capsys):
    assert search(tmp_path / "out", "--speeds", "9", "--paths", "3") == 2
    said = "--speeds belongs to method exact and best-first, not to front; --paths belongs to method best-first, not to"
    assert said in capsys.readouterr().err
    assert search(tmp_path / "out", "--at", "5%", "--max-margin", "9", "--points", "3") == 2
    assert "--at and --points, --max-margin exclude each other" in capsys.readouterr().err
    scenario = tmp_path / "trip.toml"
    scenario.write_text('train = "tgv"\ntrack = "flat-100km"\n[run]\nspeeds = 9\npaths = 3\n')
    assert search(tmp_path / "out", "--scenario", str(scenario)) == 3
    said = "trip.toml: run.paths: belongs to method best-first, not to front; run.speeds: belongs to method exact and"
    assert said in capsys.readouterr().err
    assert not calls


def test_points_at_times_leave_no_even_points():
    train, track = tgvdp.load_train("alstom-emu"), tgvdp.load_track("flat-100km")
    for even in ({"points": 7}, {"max_margin": 0.3}):
        with pytest.raises(tgvdp.InputError, match=f"{next(iter(even))} has no effect"):
            tgvdp.search(train, track, at_margin=(0.05,), **even)


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
    del arguments["time_limit_s"]
    assert arguments == {"destination_m": 3000.0, "points": 6, "max_margin": 0.2, "end_speed_mps": 10.0}
    inputs = json.loads((tmp_path / "out" / "result.json").read_text())["provenance"]["inputs"]
    assert set(inputs) == {"scenario", "train", "track"}


def test_unwritable_folder_is_found_before_the_search(tmp_path, calls, capsys):
    (tmp_path / "file").write_text("no folder")
    assert search(tmp_path / "file" / "out", *SHORT) == 3
    assert calls == []
    assert "file" in capsys.readouterr().err


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
    track = () if "--track" in arguments else ("--track", "flat-100km")
    assert search(tmp_path / "out", *track, *arguments, "--quiet") == code
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("tgvdp: error: ")
    assert err.count("\n") == 1
    assert part in err
    assert not (tmp_path / "out").exists()
