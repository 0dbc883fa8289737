"""``tgvdp formulate`` of a trip: instances of real trains and lines, and what they say that they leave out."""

import json
import shlex

import pytest

from tgvdp.cli import main
from tgvdp.cli.formulate import command
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.formulations.problem.three_phase import three_phase_run
from tgvdp.solvers.registry import solve

LINE = """
[track]
name = "hill"
length_m = 12000
speed_limits = [{ from_m = 0, speed_kmh = 120 }, { from_m = 8000, speed_kmh = 80 }]
gradients = [{ from_m = 0, gradient_permil = 0 }, { from_m = 5000, gradient_permil = 10 }]
curves = [
  { from_m = 0, radius_start_m = "infinity", radius_end_m = "infinity" },
  { from_m = 6000, radius_start_m = 400, radius_end_m = 400 },
]
"""


@pytest.fixture
def line(tmp_path):
    path = tmp_path / "hill.toml"
    path.write_text(LINE)
    return str(path)


def made(tmp_path, capsys, *words):
    output = tmp_path / "trip.json"
    code = main(["formulate", "--train", "alstom-emu", *words, "--to", "instance", "-o", str(output), "--force"])
    return code, output, capsys.readouterr().err


def test_one_step_is_told_as_one(capsys):
    assert main(["formulate", "--steps", "1", "--to", "instance", "-o", "-"]) == 4
    told = capsys.readouterr().err
    assert "tgv on lgv-100km, 1 step: 1 step of " in told and " cover 0 of 1 Δv·Δt: take more" in told


def test_a_circuit_names_its_penalty_without_rounding_noise(capsys):
    assert main(["formulate", "easy-n007", "--penalty", "2.7299999999999995", "--to", "qasm3", "-o", "-"]) == 0
    assert "\n// easy-n007: unary, penalty 2.73, QAOA ramp of depth 1\n" in capsys.readouterr().out


def test_the_examples_of_the_help_that_need_no_file_work(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    lines = [shlex.split(line) for line in (command.epilog or "").splitlines() if "tgvdp formulate" in line]
    asked = [words[1:] for words in lines if "trip.json" not in words]
    assert len(asked) == 3
    for words in asked:
        assert main(words) == 0, words
        assert (tmp_path / words[-1]).stat().st_size


def test_binary_instance_of_a_level_trip_has_its_distance_time_and_top_speed(tmp_path, capsys):
    code, path, _ = made(tmp_path, capsys, "--track", "flat-100km", "--steps", "60", "--at", "10%")
    assert code == 0
    one = read_instance(path)
    assert one.distance_units * one.dv_mps * one.dt_s == pytest.approx(100e3, rel=1e-12)
    assert one.cap_units[0] * one.dv_mps <= 220 / 3.6 < (one.cap_units[0] + 1) * one.dv_mps
    # Three phases at these accelerations take the fastest running time: 1/1.1 of the instance's.
    rate = one.dv_mps / one.dt_s
    fastest_s = one.steps * one.dt_s / 1.1
    assert three_phase_run(100e3, fastest_s, rate, rate).cruising_speed_mps == pytest.approx(220 / 3.6, rel=0.02)
    assert solve(one, "dp").replay["feasible"]


def test_what_is_left_out_is_said_and_noted(tmp_path, capsys, line):
    code, path, err = made(tmp_path, capsys, "--track", line, "--steps", "30", "--at", "20%")
    assert code == 0
    said = [text.removeprefix("tgvdp: left out: ") for text in err.splitlines()]
    assert json.loads(path.read_text())["notes"] == said == list(read_instance(path).notes)
    for word in ("traction", "running resistance", "gradients, +0 to +10 ‰", "radii from 400 m", "from 80 km/h on"):
        assert any(word in text for text in said), word


def test_demand_instance_keeps_gradients_and_curves_from_its_origin_on(tmp_path, capsys, line):
    words = ("--track", line, "--steps", "10", "--model", "demand", "--at", "30%", "--between", "1km:11km")
    code, path, err = made(tmp_path, capsys, *words)
    assert code == 0
    params = json.loads(path.read_text())["params"]
    assert params["D_m"] == 10e3
    assert params["gradients_permil"] == [[0.0, 0.0], [4000.0, 10.0]]
    assert params["curves_m"] == [[0.0, None], [5000.0, 400.0]]
    assert read_instance(path).slopes[-1] == (5000.0, 12.0)
    assert "efforts of the train" in err and "gradients" not in err


def test_alpha_is_what_efficiency_and_regeneration_leave(tmp_path, capsys):
    words = ("--track", "flat-100km", "--steps", "20")
    at_wheel = read_instance(made(tmp_path, capsys, *words)[1]).alpha
    at_pantograph = read_instance(made(tmp_path, capsys, *words, "--energy", "pantograph")[1]).alpha
    from tgvdp.formats import load_train

    train = load_train("alstom-emu")
    assert at_wheel == 0.0 < at_pantograph == train.traction_efficiency * train.regeneration_efficiency


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        ((), 2, "give INSTANCE, or --steps"),
        (("--at", "10%"), 2, "give INSTANCE, or --steps"),
        (("easy-n004", "--steps", "5"), 2, "INSTANCE and --steps exclude each other"),
        (("easy-n004", "--at", "5%", "--steps", "5"), 2, "INSTANCE and --at, --steps exclude each other"),
        (("--steps", "5", "--at", "5%,10%"), 2, "must be one running time"),
        (("--steps", "5", "--between", "12"), 2, "must be FROM:TO"),
        (("--steps", "2", "--track", "flat-100km", "--at", "1%"), 4, "take more steps or a longer running time"),
        (("--steps", "9", "--track", "lgv-100km", "--model", "demand"), 4, "take a longer running time"),
        (("easy-n004", "--layers", "2"), 2, "--layers is of --to qasm3"),
        (("easy-n004", "--form", "joint"), 2, "no encoding, penalty or form"),
    ],
)
def test_wrong_usage_and_trips_without_a_plan_are_one_line(tmp_path, capsys, words, code, message):
    train = ("--train", "tgv") if "--steps" in words and "easy-n004" not in words else ()
    assert main(["formulate", *words, *train, "--to", "instance", "-o", str(tmp_path / "x.json")]) == code
    err = capsys.readouterr().err
    assert message in err and err.count("\n") == 1
    assert not (tmp_path / "x.json").exists()


def test_a_file_without_a_name_is_refused(capsys):
    assert main(["formulate", "easy-n008", "--to", "lp", "-o", ""]) == 3
    assert capsys.readouterr().err == "tgvdp: error: a file to write must have a name, got an empty text\n"


def test_no_folder_is_made_for_a_file(tmp_path, capsys):
    assert main(["formulate", "easy-n008", "--to", "lp", "-o", str(tmp_path / "none" / "a.lp")]) == 3
    assert capsys.readouterr().err.endswith(f"a.lp: there is no folder {tmp_path / 'none'}\n")
    assert not list(tmp_path.iterdir())
