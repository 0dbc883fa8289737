"""Odd environments: a sensible result, or one line; each in a process of its own."""

import os
import subprocess
import sys

import pytest

from tgvdp import cli
from tgvdp._jit.cache import key_folder
from tgvdp.model import catalog


def run(*arguments, **variables):
    """Run the program with environment variables; returns its exit code, and what it printed as bytes."""
    environment = {name: text for name, text in os.environ.items() if name != "PYTHONUTF8"} | variables
    command = [sys.executable, "-m", "tgvdp", *arguments]
    done = subprocess.run(command, env=environment, capture_output=True, check=False, timeout=120)
    assert b"Traceback" not in done.stderr
    return done.returncode, done.stdout, done.stderr


SEARCH = ("search", "--track", "flat-100km", "--to", "3km", "--points", "3", "--no-certify")


@pytest.mark.parametrize("command", ["catalog", "validate -v tgv", "search --help", "solve easy-n004 --solver dp"])
def test_terminals_without_all_characters_get_question_marks(command):
    code, stdout, stderr = run(*command.split(), PYTHONIOENCODING="latin-1")
    assert (code, stderr) == (0, b"")
    assert b"?" in stdout


def test_json_keeps_all_characters_on_any_terminal():
    code, stdout, _ = run("catalog", "tgv", "--json", PYTHONIOENCODING="latin-1")
    assert code == 0
    assert b"\\u" in stdout
    assert b"?" not in stdout


def test_variables_that_mean_nothing_here_do_no_harm(tmp_path):
    variables = {"MPLBACKEND": "nonsense", "NUMBA_NUM_THREADS": "0", "PYTHONOPTIMIZE": "2", "LC_ALL": "xx_YY"}
    code, _, stderr = run(*SEARCH, "--quiet", "--out", str(tmp_path / "out"), **variables)
    assert (code, stderr) == (0, b"")
    assert (tmp_path / "out" / "profile.png").exists()


ALONE = """
import os, runpy
os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # on one core nobody else draws
runpy.run_module("tgvdp", run_name="__main__")
"""


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no processes that are held to one core")
def test_what_libraries_log_is_not_shown(tmp_path):
    """Matplotlib says where its caches are if not at home."""
    environment = {name: text for name, text in os.environ.items() if name != "MPLCONFIGDIR"}
    homeless = {"HOME": "/proc/none", "TGVDP_CACHE_DIR": str(key_folder().parent)}  # kernels stay where they are
    done = subprocess.run(
        [sys.executable, "-c", ALONE, *SEARCH, "--quiet"], cwd=tmp_path, capture_output=True, check=False, timeout=120,
        env=environment | homeless,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, b"")


LACKING = "import runpy, sys; sys.modules[sys.argv.pop(1)] = None; runpy.run_module('tgvdp', run_name='__main__')"


@pytest.mark.parametrize("package", ["click", "msgspec", "numpy", "numba", "llvmlite", "matplotlib", "tomli_w"])
def test_an_installation_that_lacks_a_package_is_said_in_one_line(tmp_path, package):
    command = [sys.executable, "-c", LACKING, package, *SEARCH, "--quiet"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120)
    assert (done.returncode, done.stdout, len(done.stderr.splitlines())) == (1, "", 1), done.stderr
    assert done.stderr.startswith("tgvdp: error: the installation lacks something: ")
    assert package in done.stderr


def test_unknown_request_for_completion_is_named():
    code, stdout, stderr = run("catalog", _TGVDP_COMPLETE="elvish_source")
    assert (code, stdout) == (2, b"")
    assert stderr.splitlines() == [
        b"tgvdp: error: _TGVDP_COMPLETE: must be SHELL_source or SHELL_complete, got 'elvish_source'"
    ]
    assert run(_TGVDP_COMPLETE="bash_source")[0] == 0


@pytest.mark.skipif(sys.platform in ("win32", "darwin"), reason="names of files are text here")
def test_names_of_files_may_be_no_text(tmp_path):
    name = os.fsdecode(os.fsencode(tmp_path) + b"/train\xff.toml")
    with open(name, "wb") as file:
        file.write(catalog.path("tgv", "train").read_bytes())
    code, stdout, stderr = run(
        *SEARCH, "--train", name, "--no-pictures", "--out", os.fsdecode(b"%b/out\xff" % os.fsencode(tmp_path))
    )
    assert code == 0
    assert b"in " in stdout
    assert all(line.startswith(b"tgvdp: note: ") for line in stderr.splitlines())
    code, _, stderr = run("validate", name + "x")
    assert code == 3
    assert stderr.endswith(b"train\\udcff.tomlx: no such file\n")


@pytest.mark.skipif(sys.platform == "win32", reason="no limits of resources")
def test_files_that_grow_too_large_are_said_in_one_line(tmp_path):
    out = tmp_path / "out"
    command = f"ulimit -f 8; exec {sys.executable} -m tgvdp {' '.join(SEARCH)} --quiet --no-pictures --out {out}"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 3
    assert done.stderr == f"tgvdp: error: {out}: cannot be written: File too large\n"
    assert not out.exists()


INTERRUPTED = """
import os, signal, sys, threading
from tgvdp.__main__ import main
threading.Timer({after_s}, os.kill, (os.getpid(), signal.SIGINT)).start()
sys.argv[1:] = ["search", "--points", "1000", "--quiet", "--out", {out!r}]
sys.exit(main())
"""


def test_ctrl_c_while_arguments_are_parsed_prints_no_empty_line(monkeypatch, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli.cli, "parse_args", interrupted)
    assert cli.main(["search"]) == 130
    assert capsys.readouterr().err == "tgvdp: error: interrupted\n"


@pytest.mark.skipif(sys.platform == "win32", reason="no signals")
@pytest.mark.parametrize("after_s", [0.05, 0.2, 0.4, 0.8])
def test_ctrl_c_ends_at_any_moment_in_one_line(tmp_path, after_s):
    """While libraries are loaded, too, which make other errors of it, or none."""
    program = INTERRUPTED.format(after_s=after_s, out=str(tmp_path / "out"))
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stderr) == (130, "tgvdp: error: interrupted\n")
    assert list(tmp_path.iterdir()) == []
