"""Whatever is killed, and however full the disk is: after --resume the result set is that of an undisturbed sweep."""

import contextlib
import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.helpers.sweep_case import COUNT, command, digests, run, write_case

psutil = pytest.importorskip("psutil")
pytest.importorskip("distributed")

FAULTS = Path(__file__).resolve().parents[1] / "helpers" / "worker_faults.py"
#: Has workers pause, so that there is time to step in.
SLOW = {"SWEEP_PAUSE_S": "0.15"}


def faulty(**how):
    return os.environ | {"DASK_DISTRIBUTED__WORKER__PRELOAD": json.dumps([str(FAULTS)])} | how


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """The spec, and the tables of an undisturbed sweep."""
    folder = tmp_path_factory.mktemp("faults")
    spec = write_case(folder)
    done = run(spec, "--out", folder / "out")
    assert done.returncode == 0, done.stderr
    return spec, digests(folder / "out")


def begun(spec, out, *words):
    """A sweep that has kept something, and has more to do."""
    process = subprocess.Popen(
        command(spec, "--out", out, *words),
        env=faulty(**SLOW),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    limit_s = time.monotonic() + 600
    while len(list((out / "work").glob("fronts/*.parquet"))) < 2:  # the first one is in the journal then
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < limit_s
        time.sleep(0.05)
    return process


def workers_of(process):
    """Processes that solve: children of the fork server where there is one, else those spawned with a main module."""
    children = psutil.Process(process.pid).children(recursive=True)
    words = {}
    for one in children:
        with contextlib.suppress(psutil.Error):  # which has ended meanwhile
            words[one] = " ".join(one.cmdline())
    forked = [one for one in words if "multiprocessing.forkserver" in words[one] and one.ppid() != process.pid]
    return forked or [one for one in words if "spawn_main" in words[one]]


def resumed(spec, out, *words):
    done = run(spec, "--out", out, "--resume", "--json", *words)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def killed_rows(out):
    with open(out / "scenarios.csv", encoding="utf-8", newline="") as file:
        return [row for row in csv.DictReader(file) if row["status"] != "done"]


def test_killed_worker(case, tmp_path):
    spec, expected = case
    process = begun(spec, tmp_path / "out", "--workers", 2)
    workers_of(process)[0].kill()
    _, errors = process.communicate(timeout=600)
    assert (process.returncode, errors) == (0, "")
    assert digests(tmp_path / "out") == expected


def test_worker_killed_as_it_starts(case, tmp_path):
    """The only one, of which Dask starts no other then."""
    spec, expected = case
    process = subprocess.Popen(
        command(spec, "--out", tmp_path / "out", "--workers", 1),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    while not (workers := workers_of(process)):
        assert process.poll() is None, process.communicate()
    workers[0].kill()
    _, errors = process.communicate(timeout=200)
    assert (process.returncode, errors) == (0, "")
    assert digests(tmp_path / "out") == expected


@pytest.mark.skipif(sys.platform != "linux", reason="workers are not forked")
def test_killed_fork_server(case, tmp_path):
    """What it forked goes on, and the next worker comes from another one."""
    spec, expected = case
    process = begun(spec, tmp_path / "out", "--workers", 2)
    worker, *_ = workers_of(process)
    worker.parent().kill()
    worker.kill()
    _, errors = process.communicate(timeout=600)
    assert (process.returncode, errors) == (0, "")
    assert digests(tmp_path / "out") == expected


def test_killed_driver(case, tmp_path):
    spec, expected = case
    process = begun(spec, tmp_path / "out", "--workers", 2)
    workers = workers_of(process)
    process.kill()
    process.communicate()
    _, alive = psutil.wait_procs(workers, timeout=60)
    assert alive == []
    content = resumed(spec, tmp_path / "out")
    assert 0 < content["earlier"] < COUNT
    assert digests(tmp_path / "out") == expected


def test_ctrl_c(case, tmp_path):
    spec, expected = case
    process = begun(spec, tmp_path / "out", "--workers", 2)
    workers = workers_of(process)
    os.killpg(process.pid, signal.SIGINT)  # as terminals do
    _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (130, "tgvdp: error: interrupted\n")
    _, alive = psutil.wait_procs(workers, timeout=60)
    assert alive == []
    assert 0 < resumed(spec, tmp_path / "out")["earlier"] < COUNT
    assert digests(tmp_path / "out") == expected


def test_full_disk(case, tmp_path):
    """The journal cannot be made; it cannot take a commit; the tables cannot be written."""
    resource = pytest.importorskip("resource")
    spec, expected = case
    out = tmp_path / "out"

    def fails_with(limit_b):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit_b, limit_b))

        done = run(spec, "--out", out, "--resume", preexec_fn=limit)
        assert done.returncode == 3
        assert done.stderr.startswith(f"tgvdp: error: {out}")
        assert done.stderr.count("\n") == 1

    fails_with(18_000)
    assert not out.exists()
    fails_with(30_000)
    assert not out.exists()
    resumed(spec, out)
    assert digests(out) == expected
    (out / "fronts.csv").unlink()
    fails_with(22_000)
    assert not (out / "fronts.csv").exists()
    resumed(spec, out)
    assert digests(out) == expected


#: A disk of its own in a namespace of its own: the sweep, the room that it needs, the sweep again, and what it left.
ON_A_SMALL_DISK = """
mount -t tmpfs -o size=$1k tmpfs "$2" || exit 77
kept=$3; disk=$2; shift 3
"$@" --out "$disk/out"
code=$?
mount -o remount,size=64m "$disk"
"$@" --out "$disk/out" --resume >&2 && cp -r "$disk/out" "$kept"
exit $code
"""


@pytest.mark.parametrize("room_kb", [16, 48, 120])
def test_disk_without_room(case, tmp_path, room_kb):
    """For the journal; for a commit; for the tables."""
    spec, expected = case
    disk, kept = tmp_path / "disk", tmp_path / "out"
    disk.mkdir()
    if shutil.which("unshare") is None:
        pytest.skip("no namespaces")
    words = [
        "unshare",
        "--map-root-user",
        "--mount",
        "sh",
        "-c",
        ON_A_SMALL_DISK,
        "sh",
        str(room_kb),
        str(disk),
        str(kept),
    ]
    done = subprocess.run([*words, *command(spec)], capture_output=True, text=True, check=False, timeout=600)
    if done.returncode == 77 or "unshare failed" in done.stderr:
        pytest.skip("no right to mount")
    error, *rest = done.stderr.splitlines()
    assert done.returncode == 3, done.stderr
    assert error.startswith(f"tgvdp: error: {disk / 'out'}: cannot be written: ")
    assert done.stdout == ""
    assert not any(line.startswith(("tgvdp: error", "Traceback")) for line in rest)
    assert digests(kept) == expected


@pytest.mark.parametrize("fault", ["signal", "memory"])
def test_poison_scenario(case, tmp_path, fault):
    spec, expected = case
    out = tmp_path / "out"
    done = run(spec, "--out", out, "--worker-memory", 700, env=faulty(SWEEP_FAULT=fault))
    assert done.returncode == 6
    assert f"{COUNT - 1} done, 1 killed" in done.stdout
    (row,) = killed_rows(out)
    assert (row["line"], row["section"], row["train.mass_t"], row["wind_kmh"]) == ("west", "0-1100", "200", "10")
    assert done.stderr == f"tgvdp: warning: scenario {row['scenario']} killed: 3 workers died of it\n"
    resumed_after(spec, out, expected)


def resumed_after(spec, out, expected):
    """What was killed is tried again when asked for, here without its poison."""
    assert run(spec, "--out", out, "--resume").returncode == 6
    assert run(spec, "--out", out, "--resume", "--retry").returncode == 0
    assert digests(out) == expected


class Processes:
    """A scheduler and two workers, each a process of its own on loopback."""

    def __enter__(self):
        module = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0"]
        self.scheduler = subprocess.Popen([*module, "--no-dashboard"], stderr=subprocess.PIPE, text=True)
        self.address = next(
            word for line in self.scheduler.stderr for word in line.split() if word.startswith("tcp://127.0.0.1:")
        )
        worker = [sys.executable, "-m", "distributed.cli.dask_worker", self.address, "--nthreads", "1"]
        options = {"env": faulty(**SLOW), "stderr": subprocess.DEVNULL}
        self.workers = [subprocess.Popen([*worker, "--no-dashboard"], **options) for _ in range(2)]
        return self

    def __exit__(self, *_):
        for process in (*self.workers, self.scheduler):
            for child in psutil.Process(process.pid).children(recursive=True) if process.poll() is None else ():
                child.kill()
            process.kill()
            process.wait()
        self.scheduler.stderr.close()


def test_scheduler_and_workers_of_their_own(case, tmp_path):
    spec, expected = case
    out = tmp_path / "out"
    with Processes() as cluster:
        process = begun(spec, out, "--scheduler", cluster.address)
        cluster.scheduler.kill()
        _, errors = process.communicate(timeout=60)
        assert (process.returncode, errors.count("\n")) == (3, 1), errors
        assert "the scheduler is gone" in errors
    with Processes() as cluster:
        assert resumed(spec, out, "--scheduler", cluster.address)["earlier"] < COUNT
    assert digests(out) == expected


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "127.0.0.1", "ftp://127.0.0.1:9"])
def test_no_scheduler_there(case, tmp_path, address):
    spec, _ = case
    done = run(spec, "--out", tmp_path / "out", "--scheduler", address)
    assert done.returncode == 3
    assert done.stderr.startswith(f"tgvdp: error: no scheduler answers at {address}: ")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()  # nothing is there that the same command would have to resume


def test_two_sweeps_at_once(case, tmp_path):
    spec, _ = case
    process = begun(spec, tmp_path / "out")
    psutil.Process(process.pid).suspend()  # it is not done before the other one asks
    done = run(spec, "--out", tmp_path / "out", "--resume")
    process.kill()
    process.communicate()
    assert done.returncode == 3
    assert "another sweep is writing here" in done.stderr
