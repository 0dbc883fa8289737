"""Workers and batches: who compiles, who is refused, how long batches are, and what is said of how far it is."""

import itertools
import os
import pickle
import subprocess
import sys
from concurrent.futures import Future
from dataclasses import replace
from types import SimpleNamespace

import pytest

from tests.helpers.metro_case import TRAIN
from tgvdp import InputError, SpeedLimit, Track, cores
from tgvdp.api import warm
from tgvdp.cli.screen import Screen
from tgvdp.cli.sweep import teller
from tgvdp.errors import UnavailableError
from tgvdp.sweeps import cluster, engine, run, work
from tgvdp.sweeps.batches import BATCH_S, Batches
from tgvdp.sweeps.cluster import Cluster, started
from tgvdp.sweeps.scenario import Task
from tgvdp.sweeps.work import solve, solve_batch

LINES = [Track(length_m=length_m, speed_limits=(SpeedLimit(0.0, 15.0),)) for length_m in (1e3, 2e3)]

#: Loads kernels with a compilation of half a second, and says when it began and ended.
COLD = """
import sys, time
from pathlib import Path
from tgvdp.api import warm
from tgvdp.sweeps import work

compiled = Path(sys.argv[1]) / "kernels"

def tour(name):
    began = time.time()
    found = compiled.exists()
    if not found:
        time.sleep(0.5)
        compiled.touch()
    print(int(found), began, time.time(), flush=True)

warm.tour = tour
warm.make_folder = lambda: Path(sys.argv[1])
work.load_kernels("front")
"""


#: What Dask has to say of a worker that is closed as it starts, and multiprocessing of one that is closed later.
CLOSED = """
import logging
import multiprocessing
import tgvdp.sweeps.preload
import distributed

def closed():
    raise RuntimeError("ConnectionPool is closed")

logging.getLogger("distributed.worker").error("ConnectionPool is closed")
process = multiprocessing.get_context("fork").Process(target=closed)
process.start()
process.join()
raise SystemExit(process.exitcode - 1)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="workers are forked on Linux")
def test_workers_say_nothing_on_the_terminal():
    pytest.importorskip("distributed")
    done = subprocess.run([sys.executable, "-c", CLOSED], check=False, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_one_worker_compiles_and_the_others_wait_for_it(tmp_path):
    pytest.importorskip("locket")
    processes = [
        subprocess.Popen([sys.executable, "-c", COLD, str(tmp_path)], stdout=subprocess.PIPE, text=True)
        for _ in range(3)
    ]
    tours = [line.split() for process in processes for line in process.communicate(timeout=60)[0].splitlines()]
    assert all(process.returncode == 0 for process in processes)
    (first,) = [tour for tour in tours if tour[0] == "0"]
    others = [tour for tour in tours if tour[0] == "1"]
    assert len(others) >= 3  # each loads, after the one that compiled
    assert all(float(began) >= float(first[2]) for _, began, _ in others)


def test_a_worker_of_another_version_refuses():
    with pytest.raises(InputError, match=r"a worker on .* runs tgvdp .*, the sweep 0\.0"):
        solve_batch(pickle.dumps([]), "0.0")


def tasks(count):
    return iter(Task(number, "search", TRAIN, LINES[number % 2], (), {}, None) for number in range(count))


def test_a_journey_leaves_the_other_cores_to_other_workers(monkeypatch):
    line = replace(LINES[1], stops_m=(0.0, 900.0, 2e3))
    monkeypatch.setattr(cores, "ThreadPoolExecutor", None)  # who asks for threads fails
    monkeypatch.setattr(cores, "usable_cores", lambda: 2)
    task = Task(0, "journey", TRAIN, line, (), {"points": 2}, None)
    assert solve(task).error is None


@pytest.mark.parametrize("is_own", [True, False])
def test_workers_that_never_come_end_a_sweep_on_this_machine_alone(monkeypatch, is_own):
    monkeypatch.setattr(engine, "PATIENCE_S", 0.5)
    local = SimpleNamespace(workers={}, scheduler=SimpleNamespace(workers={})) if is_own else None
    client = SimpleNamespace(cluster=local, nthreads=dict, submit=lambda *_, **__: Future())
    task = Task(0, "search", TRAIN, LINES[0], (), {}, None)
    records = engine.Engine(client, Batches(iter([task]), lambda: None)).records()
    if is_own:
        with pytest.raises(UnavailableError, match=r"no worker starts within 0.5 s: each may need more memory"):
            list(records)
    else:
        assert list(itertools.islice(records, 10)) == [[]] * 10  # 2 s


def test_batches_take_as_long_as_is_worth_a_message():
    batches = Batches(tasks(1000), lambda: None)
    assert len(batches.take(1)) == 1  # nothing is known yet
    for task in itertools.islice(tasks(100), 100):
        batches.pace.observe(task, 0.01 if task.track is LINES[0] else 0.03)
    assert len(batches.take(1)) == pytest.approx(BATCH_S / 0.02, abs=2)
    assert len(batches.take(100)) == pytest.approx(3.2 / 0.02, abs=2)  # many workers: longer ones


def test_the_last_batches_are_short_so_that_all_workers_end_together():
    left = 40
    batches = Batches(tasks(left), lambda: left)
    batches.pace.observe(next(tasks(1)), 0.01)
    assert len(batches.take(4)) == left / (2 * 4)
    left = 8
    assert len(batches.take(4)) == 5  # 0.05 s, for each batch is a message
    assert len(Batches(tasks(0), lambda: 0).take(4)) == 0


@pytest.fixture
def progress(monkeypatch):
    """Ten scenarios of this run in two seconds, after fifty of an earlier one."""
    monkeypatch.setattr(run.time, "perf_counter", lambda: 102.0)
    return run.Progress(100, 60, 2, 50, 100.0, "http://127.0.0.1:1/status")


def test_progress_counts_this_run_only(progress):
    assert (progress.per_second, progress.left_s) == (5.0, 8.0)


def test_progress_is_one_line_at_a_terminal(monkeypatch, capsys, progress):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with Screen(quiet=False) as screen:
        teller(screen)(progress)
        text = capsys.readouterr().err
    assert "dashboard at http://127.0.0.1:1/status\n" in text
    assert "60 of 100 done, 2 failed, 5/s, 8 s left" in text


def test_nothing_is_said_elsewhere(capsys, progress):
    with Screen(quiet=True) as screen:
        teller(screen)(progress)
    assert capsys.readouterr().err == ""


def _malloc() -> dict[str, str]:
    return {name: size_b for name, size_b in os.environ.items() if name.startswith("MALLOC_")}


def test_workers_keep_their_memory_for_the_next_front():
    """Both are needed: glibc takes the least size of an array that it maps anew as fixed once one of them is set."""
    pytest.importorskip("distributed")
    with started(Cluster(workers=1)) as connect:
        kept = connect().submit(_malloc).result()
    assert int(kept["MALLOC_MMAP_THRESHOLD_"]) >= 16 << 20
    assert int(kept["MALLOC_TRIM_THRESHOLD_"]) > int(kept["MALLOC_MMAP_THRESHOLD_"])


def _loaded() -> tuple[bool, bool]:
    return "tgvdp.api.warm" in sys.modules, "scipy.linalg" in sys.modules


def test_workers_load_what_fronts_need_as_they_start_and_no_more():
    pytest.importorskip("distributed")
    with started(Cluster(workers=1)) as connect:
        assert connect().submit(_loaded).result() == (True, False)


def _is_watched() -> bool:
    from distributed import get_worker

    return "profile" in get_worker().periodic_callbacks


def test_workers_are_not_asked_all_the_time_what_they_are_doing():
    """A hundred times a second, which takes a sixteenth of their time."""
    pytest.importorskip("distributed")
    with started(Cluster(workers=1)) as connect:
        assert not connect().submit(_is_watched).result()


def test_the_driver_makes_ready_while_workers_come(monkeypatch):
    pytest.importorskip("distributed")
    made = []
    monkeypatch.setattr(cluster, "_local", lambda asked, local=cluster._local: made.append(local(asked)) or made[0])
    with started(Cluster(workers=1)) as connect:
        assert not made[0].scheduler.workers
        assert len(connect().nthreads()) == 1


def test_kernels_are_loaded_before_workers_are_forked_unless_they_have_to_be_compiled(monkeypatch, tmp_path):
    loaded = []
    monkeypatch.setattr(work, "load_kernels", loaded.append)
    monkeypatch.setattr(warm, "key_folder", lambda: tmp_path)
    work.load_what_is_compiled("front")
    assert loaded == []
    (tmp_path / "front.compiled").touch()
    work.load_what_is_compiled("front")
    assert loaded == ["front"]
