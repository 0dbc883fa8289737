"""The command line as a whole: help, catalog, validate, completion, errors and exit codes."""

import json
import os
import re
import subprocess
import sys

import click
import pytest

from tgvdp import __version__, instances
from tgvdp.cli import _COMMANDS, cli, main
from tgvdp.cli.screen import duration, front_table, spread
from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError, TgvdpError
from tgvdp.model import catalog


def run(*arguments):
    """Exit code of the command line in this process."""
    return main(list(arguments))


@pytest.fixture
def one_error(capsys):
    """Asserts that a run printed one line of error and nothing else, and returns it."""

    def check():
        out, err = capsys.readouterr()
        assert out == ""
        assert err.startswith("tgvdp: error: ")
        assert err.endswith("\n")
        assert err.count("\n") == 1
        return err

    return check


def test_module_and_console_command_say_the_same():
    module = subprocess.run([sys.executable, "-m", "tgvdp", "--help"], capture_output=True, text=True, check=True)
    script = os.path.join(os.path.dirname(sys.executable), "tgvdp")
    console = subprocess.run([script, "--help"], capture_output=True, text=True, check=True)
    assert module.stdout == console.stdout
    assert module.stdout.startswith("Usage: tgvdp ")


@pytest.mark.parametrize("command", ["", *_COMMANDS])
def test_help_has_examples(command, capsys):
    assert run(*filter(None, [command]), "--help") == 0
    out, err = capsys.readouterr()
    assert "Examples:" in out
    assert f"tgvdp {command}".strip() in out
    assert err == ""


def test_version(capsys):
    assert run("--version") == 0
    assert __version__ in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["serach"], "unknown command 'serach', did you mean 'search'?"),
        (["xyz"], "unknown command 'xyz'; there are search, "),
        (["search", "--train", "tgv", "--train", "tgv"], "--train is given 2 times"),
        (["search", "--tunnels", "--no-tunnels"], "--tunnels is given 2 times"),
        (["search", "--points", "1001"], "x<=1000"),
        (["search", "--wind", "5 kg"], "must be a number of km/h, got '5 kg'"),
        (["search", "--speed-restriction", "5:1:80"], "with 0 <= FROM < TO"),
        (["search", "--speed-restriction", "1:5"], "such as 50km:52km:80, got '1:5'"),
        (["search", "--speed-restriction", "1:5kg:8"], "must be a number of m, got '5kg'"),
        (["search", "--segmnt", "3"], "--segment"),
        (["search", "extra"], "extra"),
        (["search", "--method", "guess"], "best-first"),
        (["search", "--heuristic", "guess"], "ratio"),
        (["search", "--points", "1"], "2<=x<=1000"),
        (["search", "--points", "many"], "many"),
        (["search", "--max-margin", "0"], "above 0 %, got 0 %"),
        (["search", "--max-margin", "nan"], "must be finite, got nan %"),
        (["search", "--from", "-1"], "at least 0 m, got -1 m"),
        (["search", "--to", "inf"], "must be finite, got inf m"),
        (["search", "--to", "12 h"], "must be a number of m, got '12 h'"),
        (["search", "--start-speed", "-3"], "at least 0 km/h"),
        (["search", "--time-limit", "0"], "above 0 s, got 0 s"),
        (["search", "--speeds", "1"], "x>=2"),
        (["search", "--max-labels", "0"], "x>=1"),
        (["validate"], "FILE"),
        (["completion", "tcsh"], "fish"),
    ],
)
def test_wrong_usage_is_one_line_and_exit_code_2(arguments, part, one_error):
    assert run(*arguments) == 2
    assert part in one_error()


def test_the_name_alone_says_where_to_start(capsys):
    assert run() == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("Usage: tgvdp ")
    assert "tgvdp search " in err
    assert len(err.splitlines()) < 10


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (InputError("line.json: stops: must increase"), 3),
        (InfeasibleError("the train cannot climb"), 4),
        (BudgetExceededError("nothing found"), 5),
        (TgvdpError("two\n  lines"), 1),
        (PermissionError(13, "Permission denied", "out/result.json"), 3),
        (KeyboardInterrupt(), 130),
    ],
)
def test_one_place_turns_errors_into_a_line_and_an_exit_code(error, code, monkeypatch, one_error):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr("tgvdp.formats.describe_file", fail)
    if isinstance(error, InputError):  # validate goes on after a wrong file
        monkeypatch.setattr("tgvdp.formats.load_train", fail)
        assert run("catalog") == code
    else:
        assert run("validate", "tgv") == code
    assert one_error()


def test_catalog_lists_every_train_and_track(capsys):
    assert run("catalog") == 0
    printed = capsys.readouterr().out.splitlines()
    lines = [line for line in printed if not line.startswith("instances")]
    expected = [(kind, name) for kind in catalog.KINDS for name in catalog.names(kind)]
    assert [tuple(line.split()[:2]) for line in lines] == expected
    assert "416 t" in lines[[name for _, name in expected].index("tgv")]
    assert "160 to 300 km/h" in lines[[name for _, name in expected].index("lgv-100km")]
    assert {"tgv", "alstom-emu", "lgv-100km", "flat-100km"} <= {name for _, name in expected}
    sizes = re.findall(r"\d{3}", " ".join(line for line in printed if line.startswith("instances")))
    assert len(sizes) == len(instances.index()) == 106


def test_catalog_shows_one_with_its_sources(capsys):
    assert run("catalog", "tgv") == 0
    out = capsys.readouterr().out
    assert "TGV" in out
    assert "http" in out or "ource" in out


def test_catalog_json(capsys):
    assert run("catalog", "--json") == 0
    content = json.loads(capsys.readouterr().out)
    assert content["schema"] == "tgvdp.catalog/1"
    by_name = {entry["name"]: entry for entry in content["entries"]}
    assert by_name["tgv"]["kind"] == "train"
    assert by_name["tgv"]["notes"]
    assert by_name["lgv-100km"]["kind"] == "track"
    assert by_name["easy-n008"]["figures"][1] == {"name": "certified optimum", "value": 1.4, "unit": "(m/s)^2"}


def test_catalog_suggests_the_nearest_name(one_error):
    assert run("catalog", "lgv-10km") == 3
    assert "lgv-100km" in one_error()


def test_validate_says_what_files_hold(shared, capsys):
    tracks = sorted(str(path) for path in (shared / "ttobench" / "tracks").glob("*.json"))
    assert run("validate", *tracks) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "CH_StGallen_Wil" in out


def test_validate_goes_on_after_a_wrong_file(tmp_path, capsys):
    good = tmp_path / "good.toml"
    good.write_text('train = "tgv"\ntrack = "flat-100km"\n')
    missing = tmp_path / "missing.json"
    assert run("validate", str(missing), str(good)) == 3
    out, err = capsys.readouterr()
    assert "good" in out
    assert err.startswith("tgvdp: error: ")
    assert "missing.json" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(("shell", "part"), [("bash", "complete -o"), ("zsh", "#compdef tgvdp"), ("fish", "complete ")])
def test_completion_prints_a_script(shell, part, capsys):
    assert run("completion", shell) == 0
    out = capsys.readouterr().out
    assert part in out
    assert "_TGVDP_COMPLETE" in out


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("tgvdp se", "plain,search"),
        ("tgvdp search --tra", "plain,--train"),
        ("tgvdp search --train t", "plain,tgv"),
        ("tgvdp journey --train t", "plain,tgv"),
        ("tgvdp compare --track lg", "plain,lgv-100km"),
        ("tgvdp score run.csv --energy pan", "plain,pantograph"),
        ("tgvdp search --set train.mas", "plain,train.mass_t="),
        ("tgvdp solve easy-n00", "plain,easy-n008"),
        ("tgvdp catalog tg", "plain,tgv"),
        ("tgvdp validate li", "file,li"),
        ("tgvdp score ru", "file,ru"),
        ("tgvdp search --out o", "dir,o"),
        ("tgvdp compare ou", "dir,ou"),
    ],
)
def test_completion_completes(words, expected):
    environment = os.environ | {
        "_TGVDP_COMPLETE": "bash_complete",
        "COMP_WORDS": words,
        "COMP_CWORD": str(len(words.split()) - 1),
    }
    command = [sys.executable, "-m", "tgvdp"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert expected in done.stdout.splitlines()


def test_closed_pipe_is_silent():
    code = "import sys; from tgvdp.cli import main; sys.exit(main(['catalog']))"
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    process.stdout.close()
    errors = process.stderr.read()
    process.stderr.close()
    assert process.wait(timeout=60) != 0
    assert errors == b""


@pytest.mark.parametrize(
    ("time_s", "text"),
    [
        (0.0712, "0.0712 s"),
        (59.0, "59 s"),
        (60.0, "1:00.0"),
        (125.34, "2:05.3"),
        (3599.96, "1:00:00.0"),
        (4029, "1:07:09.0"),
    ],
)
def test_durations_are_readable(time_s, text):
    assert duration(time_s) == text


@pytest.mark.parametrize("count", [1, 2, 11, 12, 13, 60, 1000])
def test_table_rows_are_spread_evenly_and_hold_both_ends(count):
    rows = list(spread(count, 12))
    assert len(rows) == min(count, 12)
    assert (rows[0], rows[-1]) == (0, count - 1)
    assert rows == sorted(set(rows))


def test_table_of_a_single_point():
    point = {"id": 0, "time_s": 2.5, "delay_s": 0.0, "margin_pct": 0.0, "energy_kwh": 1e-7, "saved_pct": 0.0}
    point |= {"price_kwh_per_min": None, "lower_bound_kwh": None, "gap_pct": None}
    fastest = {"time_s": 2.5, "energy_kwh": 1e-7, "stepped_time_s": None}
    table = front_table({"front": [point], "fastest": fastest})
    assert "2.5 s" in table
    assert "1.0000e-07" in table
    assert "gap" not in table
    assert table.endswith("1 point on the front")
    stepped = front_table({"front": [point], "fastest": fastest | {"stepped_time_s": 2.375}})
    assert stepped == f"{table}\n  by the explicit steps of the convention 2.38 s, converged 2.50 s"


@pytest.mark.parametrize(("cause", "code"), [(KeyboardInterrupt(), 130), (ValueError("numba"), None)])
def test_an_interruption_within_a_kernel_is_one_too(cause, code, monkeypatch, one_error):
    def fail(*_, **__):
        raise SystemError("a kernel returned a result with an exception set") from cause

    monkeypatch.setattr("tgvdp.cli.catalog.command.callback", fail)
    if code is None:
        with pytest.raises(SystemError):
            run("catalog")
        return
    assert run("catalog") == code
    assert "interrupted" in one_error()


@pytest.mark.parametrize(
    "options", ["--solver tabu --tenure 7", "--solver sa --beta 3..1", "--solver dp --encoding unary"]
)
def test_wrong_settings_of_a_solver_are_wrong_usage(options, capsys):
    assert main(["solve", "easy-n004", *options.split()]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_characters_that_the_font_of_pictures_lacks_are_told_once(tmp_path, capsys):
    """Each was a warning of matplotlib's: a line of many stations in Chinese had dozens."""
    line = tmp_path / "line.csv"
    line.write_text("km,limit_kmh,stop\n0,80,東京\n3,80,大阪\n", encoding="utf-8")
    assert run("journey", "--track", str(line), "--points", "2", "--quiet", "--out", str(tmp_path / "out")) == 0
    said = "tgvdp: warning: the font of the pictures lacks characters of names, which are boxes there\n"
    assert capsys.readouterr().err in ("", said)  # there are machines whose fonts have them


@pytest.mark.parametrize("command", _COMMANDS)
def test_commands_that_can_be_quiet_can_be_so_by_one_letter(command):
    """Compare, score and bench had -q, the others had not."""
    options = [one.opts for one in cli.get_command(click.Context(cli), command).params if "--quiet" in one.opts]
    assert options in ([], [["-q", "--quiet"]])
