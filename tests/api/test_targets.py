"""Points where people want them: targets in words, in scenarios, on the command line, and how well they are met."""

import json
import os
import signal
import sys
import threading
import time

import numpy as np
import pytest

import tgvdp
from tgvdp import api
from tgvdp.api.targets import asked_targets
from tgvdp.cli import main
from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.options.search import SearchOptions
from tgvdp.options.texts import parse_targets

TRIP = {"destination_m": 6000.0, "end_speed_mps": 5.0}


def search(**arguments):
    return api.search(tgvdp.load_train("alstom-emu"), tgvdp.load_track("flat-100km"), **(TRIP | arguments))


@pytest.mark.parametrize(
    ("text", "margin", "time_s"),
    [
        ("3%,5%,10%", (0.03, 0.05, 0.1), ()),
        (" .5 % , 0%", (0.005, 0.0), ()),
        ("1050s, 17:30, 1:07:09.5, 90:00", (), (1050.0, 1050.0, 4029.5, 5400.0)),
        ("5%,12.5s", (0.05,), (12.5,)),
    ],
)
def test_grammar(text, margin, time_s):
    targets = parse_targets(text)
    assert targets.margin == pytest.approx(margin)
    assert targets.time_s == pytest.approx(time_s)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "5",
        "5%,",
        "-5%",
        "5 min",
        "1:60",
        "1:60:00",
        "nan%",
        "1e3s",
        "17:3",
        "0s",
        "0:00",
        "9" * 400 + "s",
        "9" * 5000 + ":00",
    ],
)
def test_what_is_no_target_is_said_in_one_line(text):
    with pytest.raises(InputError, match=r"^must be|^running times must|^minutes after") as caught:
        parse_targets(text)
    assert "\n" not in str(caught.value)


def test_points_are_exactly_there():
    fastest_s = search(points=2).fastest.time_s
    wanted_s = fastest_s * np.array([1.0, 1.004, 1.05, 1.1003, 1.4])
    result = search(at_s=[wanted_s[4], wanted_s[1]], at_margin=[0.0, 0.05, 0.1003])
    assert result.front.time_s == pytest.approx(wanted_s, abs=0.05)
    assert np.max(np.abs(result.front.time_s - wanted_s)) <= 1e-5 * fastest_s
    assert all(verdict.ok for verdict in result.verify())
    assert result.warnings == ()
    assert result.options["at_margin"] == (0.0, 0.05, 0.1003)


def test_every_point_of_the_default_front_exists():
    result = search()
    assert len(result.front) == 60
    assert result.front.time_s[-1] == pytest.approx(1.25 * result.fastest.time_s, rel=1e-3)
    steps = np.diff(result.front.time_s)
    assert steps.max() <= 2.0 * 0.25 / 59 * result.fastest.time_s


def test_price_is_the_slope_of_the_front():
    result = search(at_margin=[0.099, 0.1, 0.101])
    slope = -(result.front.energy_j[2] - result.front.energy_j[0]) / (result.front.time_s[2] - result.front.time_s[0])
    assert result.price_kwh_per_min[1] == pytest.approx(slope * 60.0 / 3.6e6, rel=0.03)


def test_same_and_printed_times_are_one_point():
    target_s, tolerance_s = asked_targets(1000.0, SearchOptions(at_s=[999.96, 1050.0], at_margin=[0.05, 0.0]))
    assert target_s.tolist() == [1000.0, 1050.0]
    assert 0.0 < tolerance_s <= 0.025
    assert asked_targets(1.0, SearchOptions(at_margin=[0.1, 0.1001]))[1] <= 1e-5


@pytest.mark.parametrize("above_s", [-0.02, 0.0, 0.002, 0.02])
def test_next_to_the_fastest_run_it_is_what_is_asked_for(above_s):
    fastest_s = search(points=2).fastest.time_s
    found = search(at_s=(fastest_s + above_s, 1.05 * fastest_s))
    assert found.front.time_s == pytest.approx((fastest_s, 1.05 * fastest_s), abs=0.05)
    assert not found.warnings


def test_faster_than_the_fastest_run_is_infeasible():
    with pytest.raises(InfeasibleError, match=r"no run takes 100 s, the fastest one takes \d+"):
        search(at_s=[400.0, 100.0])


def test_slower_than_the_thriftiest_run_ends_with_it():
    """Downhill into the destination's speed there is a thriftiest run."""
    train = tgvdp.load_train("alstom-emu")
    track = tgvdp.Track(length_m=3000.0, speed_limits=((0.0, 40.0),), gradients=((0.0, -15.0),), name="downhill")
    result = tgvdp.search(train, track, at_margin=[0.02, 30.0])
    assert result.complete
    assert len(result.front) >= 1
    assert result.front.time_s[-1] < 10.0 * result.fastest.time_s
    (warning,) = result.warnings
    assert "thriftiest" in warning


@pytest.mark.parametrize(
    "arguments",
    [
        {"at_s": [0.0]},
        {"at_s": [float("nan")]},
        {"at_s": ["5"]},
        {"at_s": 5.0},
        {"at_margin": "5%"},
        {"at_margin": [-0.1]},
        {"at_margin": [0.1], "method": "exact"},
        {"at_s": [500.0], "method": "best-first"},
    ],
)
def test_bad_targets_are_bad_input(arguments):
    with pytest.raises(InputError, match="at_"):
        search(**arguments)
    assert SearchOptions(at_s=np.array([5.0])).at_s == (5.0,)


def run(out, *arguments):
    return main(
        ["search", "--track", "flat-100km", "--to", "3000", "--train", "tgv", *arguments, "--out", str(out), "--json"]
    )


def test_option_at(tmp_path, capsys):
    assert run(tmp_path, "--at", "5%, 12%, 5:00") == 0
    out, err = capsys.readouterr()
    content = json.loads(out)
    points = content["front"]
    assert [point["margin_pct"] for point in points[:2]] == pytest.approx([5.0, 12.0], abs=1e-2)
    assert points[2]["time_s"] == pytest.approx(300.0, abs=0.05)
    assert "kWh/min" in err
    assert content["provenance"]["elapsed_verify_s"] > 0.0


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["--at", "5"], 2),
        (["--at", "5%", "--points", "9"], 2),
        (["--at", "5%", "--max-margin", "9"], 2),
        (["--at", "5%", "--method", "exact"], 2),
        (["--at", "1s"], 4),
    ],
)
def test_option_at_refuses(arguments, code, tmp_path, capsys):
    assert run(tmp_path / "out", *arguments) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_warning_of_a_front_that_ends_early_is_a_field_and_a_line(tmp_path, capsys):
    track = tmp_path / "downhill.toml"
    track.write_text(
        "[track]\nlength_m = 3000.0\nspeed_limits = [{ from_m = 0.0, speed_kmh = 144.0 }]\n"
        "gradients = [{ from_m = 0.0, gradient_permil = -15.0 }]\n"
    )
    arguments = ["--track", str(track), "--train", "alstom-emu", "--at", "3000%", "--out", str(tmp_path / "out")]
    assert main(["search", *arguments, "--json"]) == 0
    out, err = capsys.readouterr()
    assert "thriftiest" in json.loads(out)["warning"]
    assert "tgvdp: warning: the front ends with the thriftiest run" in err


def test_scenario_at_and_who_wins(tmp_path, capsys):
    scenario = tmp_path / "trip.toml"
    head = 'train = "tgv"\ntrack = "flat-100km"\n[run]\nto_m = 3000.0\n'

    def count(text, *arguments):
        scenario.write_text(head + text)
        code = main(["search", "--scenario", str(scenario), *arguments, "--out", str(tmp_path / "out"), "--json"])
        assert code == 0
        return len(json.loads(capsys.readouterr().out)["front"])

    assert count('at = "3%, 6%"\n') == 2
    assert count('at = "3%, 6%"\n', "--points", "4") == 4
    assert count("points = 4\n", "--at", "7%") == 1


@pytest.mark.parametrize("line", ['at = "3"', "at = 3", 'at = "3%"\npoints = 5', 'at = "3%"\nmax_margin_pct = 5.0'])
def test_bad_at_of_a_scenario_is_found_by_validate(line, tmp_path, capsys):
    scenario = tmp_path / "trip.toml"
    scenario.write_text(f"[run]\n{line}\n")
    assert main(["validate", str(scenario)]) == 3
    assert "at" in capsys.readouterr().err


def long_track():
    """1000 km of changing limits and gradients."""
    random = np.random.default_rng(7)
    places = np.arange(0.0, 1e6, 700.0)
    gradients = tuple(zip(places.tolist(), random.uniform(-12.0, 12.0, len(places)).tolist(), strict=True))
    limits = tuple(zip(places[::8].tolist(), random.uniform(35.0, 80.0, len(places[::8])).tolist(), strict=True))
    return tgvdp.Track(length_m=1e6, speed_limits=limits, gradients=gradients, name="1000 km")


def test_time_limit_holds_on_1000_km():
    train, track = tgvdp.load_train("tgv"), long_track()
    tgvdp.search(train, tgvdp.load_track("flat-100km"), points=3)  # compiles
    result = tgvdp.search(train, track, time_limit_s=0.05)
    assert result.elapsed_s < 0.05 + 0.5
    assert not result.complete
    assert 1 <= len(result.front) < 60
    assert "time limit" in result.warnings[0]
    with pytest.raises(BudgetExceededError):
        tgvdp.search(train, track, time_limit_s=1e-6, at_margin=[0.05])


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_interrupt_is_heard_within_half_a_second_on_1000_km():
    train, track = tgvdp.load_train("tgv"), long_track()
    tgvdp.search(train, tgvdp.load_track("flat-100km"), points=3)  # compiles
    sent_s = []

    def interrupt():
        sent_s.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    threading.Timer(0.3, interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        while not sent_s or time.perf_counter() - sent_s[0] < 5.0:
            tgvdp.search(train, track, points=200)
    assert time.perf_counter() - sent_s[0] < 0.5


def test_partial_front_exits_with_5(tmp_path, capsys):
    assert run(tmp_path, "--time-limit", "1e-6") == 5
    out, err = capsys.readouterr()
    content = json.loads(out)
    assert content["complete"] is False
    assert len(content["front"]) == 1
    assert "budget reached" in err
