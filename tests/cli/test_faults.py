"""Faults of the machine: killed, full, gone, closed, shared. A sensible result or one line; no file is ever torn."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tgvdp.cli import main
from tgvdp.cli.folder import OutFolder

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no signals, mounts or pipes of that kind")

PROGRAM = (sys.executable, "-m", "tgvdp")
SHORT = ("search", "--track", "flat-100km", "--to", "3km", "--points", "3", "--no-certify", "--no-pictures", "--quiet")
LINE = b"tgvdp: error: "


def run(*arguments, cwd=None, stdout=subprocess.PIPE, **variables):
    """Run the program; returns its exit code and what it printed on stderr, which holds no traceback."""
    done = subprocess.run(
        [*PROGRAM, *arguments], env=os.environ | variables, cwd=cwd, stdout=stdout, stderr=subprocess.PIPE,
        check=False, timeout=300,
    )  # fmt: skip
    assert b"Traceback" not in done.stderr
    assert b"Exception ignored" not in done.stderr
    return done.returncode, done.stderr


@contextlib.contextmanager
def small_disk(folder, size="48k"):
    """A file system of its own; skips where none can be mounted."""
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder], check=False, capture_output=True
    )
    if mounted.returncode:
        pytest.skip("no file system can be mounted here")
    try:
        yield folder
    finally:
        subprocess.run(["umount", folder], check=True)


WRITER = """
import itertools, sys
from tgvdp.report.files import write_files
for letter in itertools.cycle((b"a", b"b")):
    write_files(sys.argv[1], {"one": 4_000_000 * letter, "two": 4_000_000 * letter})
"""


def test_kill_during_a_write_leaves_old_or_new_files_never_torn(tmp_path):
    for round in range(8):
        out = tmp_path / str(round)
        process = subprocess.Popen([sys.executable, "-c", WRITER, out])
        while not (out / "two").exists():
            time.sleep(0.01)
        time.sleep(0.003 * round)
        process.kill()
        process.wait()
        for name in ("one", "two"):
            content = (out / name).read_bytes()
            assert len(content) == 4_000_000
            assert len(set(content)) == 1


def test_drafts_of_a_killed_process_do_not_stand_in_the_way(tmp_path):
    (tmp_path / ".front.csv.4711.tmp").write_bytes(b"half a li")
    OutFolder(str(tmp_path), "result.json", force=False)
    (tmp_path / "mine.csv").touch()
    assert main([*SHORT, "--out", str(tmp_path)]) == 3


def test_a_full_disk_is_said_in_one_line_and_keeps_the_old_results(tmp_path):
    with small_disk(tmp_path / "disk") as disk:
        out = disk / "out"
        assert run(*SHORT, "--every", "500", "--out", str(out))[0] == 0
        before = {path.name: path.read_bytes() for path in out.iterdir()}
        code, stderr = run(*SHORT, "--every", "1", "--out", str(out))
        assert (code, stderr) == (3, LINE + f"{out}: cannot be written: No space left on device\n".encode())
        assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def test_a_folder_that_is_read_only_is_found_before_the_search(tmp_path):
    with small_disk(tmp_path / "disk") as disk:
        subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
        code, stderr = run(*SHORT, "--out", str(disk / "out"))
        assert (code, stderr) == (3, LINE + f"{disk / 'out'}: cannot be written: no permission in {disk}\n".encode())


def test_a_cache_on_a_full_disk_costs_a_warning(tmp_path):
    with small_disk(tmp_path / "disk", "16k") as disk:
        code, stderr = run(*SHORT, "--out", str(tmp_path / "out"), TGVDP_CACHE_DIR=str(disk))
        assert code == 0
        (warning,) = stderr.splitlines()
        assert warning.startswith(b"tgvdp: warning: ")
        assert (tmp_path / "out" / "front.csv").exists()


def test_the_working_folder_may_vanish(tmp_path):
    command = f"mkdir gone; cd gone; rmdir ../gone; exec {' '.join(PROGRAM)} {' '.join(SHORT)} --out out"
    done = subprocess.run(["sh", "-c", command], cwd=tmp_path, capture_output=True, check=False, timeout=60)
    assert done.returncode == 3
    assert done.stderr.startswith(LINE)
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("command", ["catalog", "catalog --json", "--help", "validate tgv"])
def test_a_closed_pipe_is_no_fault(command):
    """As of ``tgvdp catalog | head -1``."""
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "wb") as pipe:
        code, stderr = run(*command.split(), stdout=pipe)
    assert (code, stderr) == (128 + signal.SIGPIPE, b"")


@pytest.mark.parametrize("command", ["catalog --json", "catalog", "validate tgv", "--help"])
def test_a_closed_stdout_loses_nothing_in_silence(command):
    line = f'exec "$0" -m tgvdp {command} >&-'
    done = subprocess.run(["sh", "-c", line, sys.executable], check=False, stderr=subprocess.PIPE, timeout=60)
    assert (done.returncode, done.stderr) == (3, LINE + b"standard output: Bad file descriptor\n")


def test_a_closed_stdout_does_no_harm_where_nothing_is_printed(tmp_path):
    line = f'exec "$0" -m tgvdp convert tgv {tmp_path}/train.toml >&-'
    done = subprocess.run(["sh", "-c", line, sys.executable], check=False, stderr=subprocess.PIPE, timeout=60)
    assert (done.returncode, done.stderr) == (0, b"")
    assert (tmp_path / "train.toml").stat().st_size > 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
@pytest.mark.parametrize("command", [("catalog",), SHORT[:-1]])
def test_what_cannot_be_printed_is_said(tmp_path, command):
    with open("/dev/full", "wb") as full:
        code, stderr = run(*command, cwd=tmp_path, stdout=full, PYTHONUNBUFFERED="")
    assert code == 3
    assert stderr == LINE + b"standard output: No space left on device\n"


def test_a_closed_stderr_costs_what_it_would_tell(tmp_path):
    line = f'exec "$0" -m tgvdp {" ".join(SHORT)} --out {tmp_path}/out 2>&-'
    done = subprocess.run(["sh", "-c", line, sys.executable], check=False, stdout=subprocess.PIPE, timeout=60)
    assert done.returncode == 0
    assert (tmp_path / "out" / "result.json").exists()


@pytest.mark.parametrize(
    ("file", "command"),
    [
        ("line.json", "formulate easy-n008 --to coo -o line"),
        ("trip.lp", "formulate easy-n008 --to lp -o trip.lp"),
        ("page.html", "report out -o page.html"),
        ("b/benchmark.csv", "bench easy-n008 --solvers dp --out b"),
    ],
)
def test_files_of_others_are_not_overwritten(tmp_path, file, command):
    assert run(*SHORT, "--out", "out", cwd=tmp_path)[0] == 0
    place = tmp_path / file
    place.parent.mkdir(exist_ok=True)
    place.write_bytes(b"precious")
    code, stderr = run(*command.split(), cwd=tmp_path)
    assert code == 3 and stderr.startswith(LINE + file.partition("/")[0].encode())
    assert place.read_bytes() == b"precious"


def test_a_page_and_a_benchmark_may_be_made_again(tmp_path):
    assert run(*SHORT, "--out", "out", cwd=tmp_path)[0] == 0
    for command in 2 * ("report out", "bench easy-n008 --solvers dp --out b"):
        assert run(*command.split(), cwd=tmp_path)[0] == 0


def test_two_processes_share_a_folder_and_a_cold_cache(tmp_path):
    out = tmp_path / "out"
    command = [*PROGRAM, *SHORT, "--force", "--out", out]
    environment = os.environ | {"TGVDP_CACHE_DIR": str(tmp_path / "cache")}
    both = [subprocess.Popen(command, env=environment, stderr=subprocess.PIPE) for _ in range(2)]
    for one in both:
        assert one.communicate(timeout=600)[1] == b""
        assert one.returncode == 0
    assert json.loads((out / "result.json").read_text())["complete"]
    assert {path.name for path in out.iterdir()} == {
        "advice.csv",
        "front.csv",
        "profiles.csv",
        "provenance.json",
        "result.json",
    }


@pytest.mark.parametrize("schema", ["tgvdp.search/0", "tgvdp.search/2", None, 7])
def test_results_of_another_version_are_named(tmp_path, capsys, schema):
    path = tmp_path / "result.json"
    path.write_text(json.dumps({"schema": schema, "trip": {}}))
    assert main(["compare", str(tmp_path), str(tmp_path), "--out", str(tmp_path / "out")]) == 3
    message = f"tgvdp: error: {path}: must be a result of this tgvdp, schema tgvdp.search/1, got {schema!r}\n"
    assert capsys.readouterr().err == message


def test_numbers_have_points_whatever_the_locale_and_pictures_need_no_display(tmp_path):
    fronts = []
    for name in ("C", "de_DE.UTF-8"):
        variables = {"LC_ALL": name, "LC_NUMERIC": name, "DISPLAY": "", "WAYLAND_DISPLAY": "", "MPLBACKEND": "TkAgg"}
        arguments = [argument for argument in SHORT if argument != "--no-pictures"]
        assert run(*arguments, "--out", str(tmp_path / name), **variables) == (0, b"")
        fronts.append((tmp_path / name / "front.csv").read_text().splitlines())
        assert (tmp_path / name / "front.png").stat().st_size > 1000
    assert [line.split(",")[:5] for line in fronts[0]] == [line.split(",")[:5] for line in fronts[1]]


DECIMAL_COMMA = """
import locale, sys
known = []
for name in ("de_DE.UTF-8", "fr_FR.UTF-8", "pl_PL.UTF-8"):
    try:
        locale.setlocale(locale.LC_ALL, name)
        known.append(name)
        break
    except locale.Error:
        pass
if not known:
    sys.exit(77)
from tgvdp.cli import main
sys.exit(main(sys.argv[1:]))
"""


def test_a_decimal_comma_changes_nothing(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", DECIMAL_COMMA, *SHORT, "--out", tmp_path / "out"], capture_output=True, check=False
    )
    if done.returncode == 77:
        pytest.skip("no locale with a decimal comma is installed")
    assert (done.returncode, done.stderr) == (0, b"")
    head, first, *_ = (tmp_path / "out" / "front.csv").read_text().splitlines()
    assert len(first.split(",")) == len(head.split(","))
