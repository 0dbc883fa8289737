"""Numbers beyond sense are refused where they stand, in the unit that is written there."""

import pytest

from tests.helpers.format_case import JOURNEY, SCENARIO, TTOBENCH_TRACK, TTOBENCH_TRAIN, changed, quantity, write_json
from tests.helpers.osrd_case import OSRD_TRAIN
from tests.helpers.railtoolkit_case import ROLLING_STOCK
from tests.helpers.refusal import refusal
from tgvdp.cli import main
from tgvdp.formats import load_run, load_scenario
from tgvdp.formats.detect import load_all


@pytest.mark.parametrize(
    ("tree", "place", "value", "message"),
    [
        (TTOBENCH_TRAIN, ("mass",), quantity(1e308, "t"), "mass: must be within ±1e+12 t, got 1e+308 t"),
        (TTOBENCH_TRAIN, ("mass",), quantity(1e-300, "t"), "mass: must be at least 1e-12 t, got 1e-300 t"),
        (OSRD_TRAIN, ("mass",), 1e-300, "mass: must be a number in kg >= 1e-12, got 1e-300 kg"),
        (ROLLING_STOCK, ("vehicles", 0, "mass"), 0.0, "vehicles[0].mass: must be a number > 0.0, got 0.0"),
        (
            TTOBENCH_TRACK,
            ("speed limits", "values", 0, 1),
            1e200,
            "speed limits.values[0]: must be within ±1e+12 km/h, got 1e+200 km/h",
        ),
        (
            JOURNEY,
            ("timing points", "values", 0, 2),
            -1e30,
            "timing points.values[0]: upper time constraint: must be within ±1e+12 s, got -1e+30 s",
        ),
        (ROLLING_STOCK, ("vehicles", 0, "mass"), 1e307, "vehicles[0].mass: must be a number within ±1e+12, got 1e+307"),
    ],
)
def test_in_files_of_others(tmp_path, tree, place, value, message):
    assert refusal(load_all, write_json(tmp_path / "file.json", changed(tree, place, value))) == message


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("mass_t = 200", "mass_t = 1e308", "train.mass_t: must be a number within ±1e+12, got 1e+308"),
        ("mass_t = 200", "mass_t = 1e-300", "train.mass_t: must be a number >= 1e-12, got 1e-300"),
        ("mass_t = 200", "mass_t = 1e18", "train.mass_t: must be a number within ±1e+12, got 1e+18"),
        ("to_m = 9_000", "to_m = 1e30", "run.to_m: must be a number within ±1e+12, got 1e+30"),
    ],
)
def test_in_native_files(saved, before, after, message):
    assert before in SCENARIO
    assert refusal(load_scenario, saved(SCENARIO.replace(before, after), "trip.toml")) == message


def test_in_tables(saved):
    line = saved("position_m,speed_kmh\n0,90\n1e40,90\n")
    assert refusal(load_all, line) == "line 3, column 'position_m': must be within ±1e+12 m, got 1e+40 m"
    run = saved("position_m,speed_kmh\n0,0\n100,1e40\n200,0\n", "run.csv")
    assert refusal(load_run, run) == "line 3: speed: must be within ±1e+12 km/h, got 1e+40 km/h"


def test_on_the_command_line(capsys):
    assert main(["search", "--start-speed", "1e300"]) == 2
    assert "'--start-speed': must be within ±1e+12 km/h, got 1e+300 km/h" in capsys.readouterr().err
    assert main(["search", "--wind", "600"]) == 2
    assert "'--wind': must be at most 500 km/h, got 600 km/h" in capsys.readouterr().err
