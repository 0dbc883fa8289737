"""``tgvdp warm``, and what people see of compilation: nothing but when it happens."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tgvdp._jit.watch import is_compiled
from tgvdp.cores import usable_cores

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not is_compiled(), reason="nothing is compiled"),
]

#: Runs the command line, and prints whether this process drew, and the kernels that it compiled.
COUNTED = """
import sys
from tgvdp import second_process
from tgvdp._jit.watch import watch
from tgvdp.cli import main
second_process.is_of_use = lambda _: {second}
with watch() as compiled:
    code = main(sys.argv[1:])
print(code, "matplotlib" in sys.modules, *(one.kernel for one in compiled))
"""
#: Searches from Python, and prints the kernels that this process compiled.
LATE = """
from tgvdp import second_process
from tgvdp._jit.watch import watch
import tgvdp
second_process.is_of_use = lambda _: {second}
with watch() as compiled:
    tgvdp.search("tgv", "flat-100km", destination_m=3000.0, points=4)
print(*(one.kernel for one in compiled))
"""
SEARCHES = """
from tgvdp._jit.watch import watch
from tests.test_fingerprint import CASES
import tgvdp
with watch() as compiled:
    for case in CASES.values():
        train, track, options = case()
        result = tgvdp.search(train, track, **options)
        result.verify()
        result.certify()
print(*(one.kernel for one in compiled))
"""
SHORT = ("search", "--track", "flat-100km", "--to", "3000", "--points", "4", "--quiet")
ROOT = Path(__file__).resolve().parents[2]


def run(cache, *arguments):
    """Run Python in a fresh process; returns what it printed."""
    done = subprocess.run(
        [sys.executable, *arguments],
        env=os.environ | {"TGVDP_CACHE_DIR": str(cache)},
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=600,
        check=True,
    )
    return done.stdout


def warm(cache):
    return json.loads(run(cache, "-m", "tgvdp", "warm", "--json"))


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """An empty cache that was warmed, and what that printed."""
    cache = tmp_path_factory.mktemp("cache")
    return cache, warm(cache)


def forget(cache, kernel):
    """Delete a kernel from the cache."""
    module, name = kernel.split(".")[-2:]
    files = list(cache.rglob(f"{module}.{name}-*"))
    assert files
    for path in files:
        path.unlink()


def at_terminal(cache, out, *options):
    """What a search writes to stderr where that is a terminal."""
    import pty  # absent on Windows

    terminal, theirs = pty.openpty()
    command = [sys.executable, "-m", "tgvdp", *SHORT[:-1], *options, "--out", str(out)]
    environment = os.environ | {"TGVDP_CACHE_DIR": str(cache)}
    with subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=theirs) as process:
        os.close(theirs)
        seen = b""
        try:
            while part := os.read(terminal, 4096):
                seen += part
        except OSError:  # Linux: the other end was closed
            pass
    os.close(terminal)
    assert process.returncode == 0
    return seen.decode()


def test_first_call_says_what_it_compiled_and_second_that_all_is_there(first):
    cache, said = first
    assert said["schema"] == "tgvdp.warm/1"
    assert len(said["compiled"]) > 20
    assert all(one["elapsed_s"] > 0.0 for one in said["compiled"])
    assert len({one["kernel"] for one in said["compiled"]}) == len(said["compiled"])
    assert Path(said["folder"]).is_relative_to(cache)
    assert warm(cache)["compiled"] == []
    assert "everything is compiled already" in run(cache, "-m", "tgvdp", "warm")


def test_no_search_compiles_anything_after_it(first):
    cache, _ = first
    assert run(cache, "-c", SEARCHES).split() == []


def test_what_comes_after_the_search_is_compiled_and_drawn_by_the_second_process(first, tmp_path):
    cache, _ = first
    for second, ours in ((True, ["False"]), (False, ["True", "referee.drive.replay_rows"])):
        forget(cache, "referee.drive.replay_rows")
        said = run(cache, "-c", COUNTED.format(second=second), *SHORT, "--out", str(tmp_path))
        assert said.split() == ["0", *ours]


@pytest.mark.skipif(usable_cores() == 1, reason="one core")
def test_what_drives_in_a_first_search_from_python_is_compiled_by_a_second_process(first):
    cache, _ = first
    for second, ours in ((True, []), (False, ["methods.costate.interpolate.drive"])):
        forget(cache, "methods.costate.interpolate.drive")
        assert run(cache, "-c", LATE.format(second=second)).split() == ours


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals")
def test_terminal_hears_of_compilation_only_where_there_is_some(first, tmp_path):
    cache, _ = first
    assert "compiling" not in at_terminal(cache, tmp_path)
    forget(cache, "runs.measure.measure_runs")
    assert "\r\x1b[Kcompiling, once: 0 s …" in at_terminal(cache, tmp_path)
    forget(cache, "runs.measure.measure_runs")
    assert at_terminal(cache, tmp_path, "--quiet") == ""


def test_warming_in_vain_is_an_error(tmp_path):
    (tmp_path / "file").write_text("a cache folder cannot be made below a file")
    for variables, reason in (
        ({"TGVDP_CACHE_DIR": str(tmp_path / "file" / "cache")}, "cannot be cached"),
        ({"NUMBA_DISABLE_JIT": "1"}, "NUMBA_DISABLE_JIT is set"),
    ):
        command = [sys.executable, "-m", "tgvdp", "warm"]
        done = subprocess.run(
            command, env=os.environ | variables, capture_output=True, text=True, timeout=600, check=False
        )
        assert done.returncode == 3
        assert reason in done.stderr
        assert len(done.stderr.splitlines()) == 1
