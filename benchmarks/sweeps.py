"""Sweeps: ``python -m benchmarks.sweeps`` runs 10,010 metro fronts from end to end, and the driver alone with far more.

Processor times count, so that it may run on a machine that others use; the clock is told beside them.
"""

import argparse
import json
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pyarrow.parquet as parquet

from benchmarks.timing import ROOT
from tgvdp.report import make_provenance
from tgvdp.report.plain import markdown_table, to_json
from tgvdp.report.provenance import write_ledger
from tgvdp.sweeps.batches import BATCH_S, Batches
from tgvdp.sweeps.cluster import Cluster, started
from tgvdp.sweeps.engine import Engine
from tgvdp.sweeps.journal import Journal
from tgvdp.sweeps.parts import write_part
from tgvdp.sweeps.read import read_spec
from tgvdp.sweeps.scenario import Task, engine_version, task_of
from tgvdp.sweeps.spec import SweepSpec
from tgvdp.sweeps.tables import write_tables
from tgvdp.sweeps.work import Front, Record, solve

POINTS = 30
#: Stops of a metro line of 13 sections, m.
STOPS_M = (0, 1980, 3040, 4890, 6420, 7210, 8450, 9530, 10620, 12400, 14170, 15820, 16830, 18010)
MASSES, WINDS = 35, 22
#: Scenarios that a part of the driver is measured with, and of a batch and of a commit there.
_BATCH, _COMMIT = 50, 500
_TICK_S = 0.2

_TRAIN = """
[train]
name = "metro"
mass_t = 200
rotating_mass_factor = 1.06
max_speed_kmh = 80
davis_a_n = 4000
davis_b_n_per_kmh = 16.6667
davis_c_n_per_kmh2 = 0.6944
friction_brake_kn = 60
max_acceleration_mps2 = 1.2
traction = { force_kn = 300, power_kw = 2500 }
braking = { force_kn = 200, power_kw = 4000 }
traction_efficiency_pct = 85
regeneration_efficiency_pct = 60
auxiliary_power_kw = 400
"""


def write_spec(folder: Path, masses: int, winds: int) -> Path:
    """Write train, line and spec: 13 sections × so many masses × so many head winds."""
    limits = ", ".join(
        f"{{ from_m = {stop}, speed_kmh = {60 + 5 * (at % 5)} }}" for at, stop in enumerate(STOPS_M[:-1])
    )
    slopes = ", ".join(f"{{ from_m = {at * 600}, gradient_permil = {(-1) ** at * (at * 7 % 23)} }}" for at in range(30))
    line = f"[track]\nlength_m = {STOPS_M[-1]}\nstops_m = {list(STOPS_M)}\nspeed_limits = [{limits}]\n"
    (folder / "metro.toml").write_text(_TRAIN)
    (folder / "line.toml").write_text(f"{line}gradients = [{slopes}]\n")
    values = [f'"train.mass_t" = {[180 + 2 * at for at in range(masses)]}', f"wind_kmh = {list(range(winds))}"]
    head = 'trains = ["metro.toml"]\nlines = ["line.toml"]\nsections = "stops"\n'
    path = folder / "spec.toml"
    path.write_text(f"{head}[run]\npoints = {POINTS}\nmax_margin_pct = 20\n[product]\n" + "\n".join(values))
    return path


class Watch:
    """Processor time, s, and largest memory, MB, of a process and of the workers that it starts."""

    def __init__(self, process: "subprocess.Popen[str]") -> None:
        self._driver = psutil.Process(process.pid)
        self._cpu_s: dict[int, float] = {}
        self._is_worker: dict[int, bool] = {}
        self.driver_mb = self.worker_mb = 0.0
        while process.poll() is None:
            self._look()
            time.sleep(_TICK_S)

    def _look(self) -> None:
        try:
            for one in [self._driver, *self._driver.children(recursive=True)]:
                times, rss_mb = one.cpu_times(), one.memory_info().rss / 1e6
                self._cpu_s[one.pid] = times.user + times.system
                if one.pid == self._driver.pid:
                    self.driver_mb = max(self.driver_mb, rss_mb)
                elif self._is_worker.setdefault(one.pid, _solves(one)):
                    self.worker_mb = max(self.worker_mb, rss_mb)
        except psutil.NoSuchProcess:
            pass

    @property
    def driver_s(self) -> float:
        """Processor time of the driver, s."""
        return self._cpu_s[self._driver.pid]

    @property
    def workers_s(self) -> float:
        """Processor time of all workers, s."""
        return sum(cpu_s for pid, cpu_s in self._cpu_s.items() if self._is_worker.get(pid))


def _solves(process: psutil.Process) -> bool:
    """Whether a process is a worker, or the fork server that has loaded all for it."""
    words = " ".join(process.cmdline())
    return "spawn_main" in words or "multiprocessing.forkserver" in words


def run_through(spec: Path, out: Path, workers: int) -> dict[str, Any]:
    """Run a sweep from end to end, and look at its processes."""
    shutil.rmtree(out, ignore_errors=True)
    command = [
        sys.executable,
        "-m",
        "tgvdp",
        "sweep",
        str(spec),
        "--out",
        str(out),
        "--workers",
        str(workers),
        "--json",
    ]
    # An installation has its bytecode, which a variable of whoever runs this may forbid to keep.
    environment = {name: text for name, text in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    started = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    watch = Watch(process)
    elapsed_s = time.perf_counter() - started
    content = json.loads(process.communicate()[0])
    timings = parquet.read_table(out / "timings.parquet")
    solve_s = float(np.sum(timings.column("cpu_s").to_numpy()))
    count = content["done"]
    total_s = watch.driver_s + watch.workers_s
    return {
        "workers": workers,
        "fronts": count,
        "elapsed, s": elapsed_s,
        "a second, by the clock": count / elapsed_s,
        "solving, s": solve_s,
        "driver, s": watch.driver_s,
        "all, s": total_s,
        "solving, ms each": 1e3 * solve_s / count,
        "beyond solving, ms each": 1e3 * (total_s - solve_s) / count,
        "a second of processor time": count / total_s,
        "most memory of the driver, MB": watch.driver_mb,
        "most memory of a worker, MB": watch.worker_mb,
    }


def sharing_gain(spec: SweepSpec, count: int) -> dict[str, float]:
    """Processor time of solving with what scenarios of a batch share, and with every one on its own, ms each."""
    tasks = [task_of(spec[number], number) for number in range(count)]
    solve(tasks[0])  # kernels

    def each_ms(prepared: Callable[[Task], Task]) -> float:
        started_s = time.process_time()
        for task in tasks:
            solve(prepared(task))
        return 1e3 * (time.process_time() - started_s) / count

    together: list[float] = []
    apart: list[float] = []
    for _ in range(3):
        together.append(each_ms(lambda task: task))
        apart.append(each_ms(_alone))
    return {"together_ms": float(np.median(together)), "apart_ms": float(np.median(apart))}


def _alone(task: Task) -> Task:
    """A task that shares nothing with any other one: objects of its own, and nothing remembered."""
    from tgvdp.line import resolved
    from tgvdp.runs.fastest import reachable_w
    from tgvdp.sweeps import work

    resolved.resolve.cache_clear()
    resolved._on_steps.cache_clear()
    reachable_w.cache_clear()
    work._changed.cache_clear()
    alone: Task = pickle.loads(pickle.dumps(task))
    return alone


def driver_parts(spec: SweepSpec, folder: Path) -> list[dict[str, Any]]:
    """Processor time and time of each part of the driver, with records that nobody solved."""
    count = len(spec)
    rows: list[dict[str, Any]] = []

    def measured(part: str, call: Callable[[], Any]) -> Any:
        cpu_s, clock_s = time.process_time(), time.perf_counter()
        value = call()
        cpu_s, clock_s = time.process_time() - cpu_s, time.perf_counter() - clock_s
        rows.append(
            {
                "part": part,
                "scenarios": count,
                "cpu ms each": 1e3 * cpu_s / count,
                "clock ms each": 1e3 * clock_s / count,
            }
        )
        return value

    engine, generator = engine_version(), np.random.default_rng(1)
    journal = Journal(folder / "journal.sqlite")
    measured("enrol", lambda: journal.enrol((scenario.key(engine) for scenario in spec), "plan"))
    front = Front(*(generator.random(POINTS) + 1.0 for _ in Front._fields))

    def record(task: Task) -> Record:
        return Record(task.id, "done", None, 100.0, 1e7, front, None, None, 0.01, 0.01, "machine:1")

    def answers() -> list[bytes]:
        made = []
        batch: list[Task] = []
        for id, number in journal.pending():
            batch.append(task_of(spec[number], id))
            if len(batch) == _BATCH:
                pickle.dumps(batch, protocol=5)
                made.append(pickle.dumps([Record(task.id, "done") for task in batch], protocol=5))
                batch = []
        return made

    measured("make and pickle tasks", answers)
    tasks = [task_of(spec[number], id) for id, number in journal.pending()]

    def keep() -> None:
        for part, start in enumerate(range(0, count, _COMMIT)):
            own = [record(task) for task in tasks[start : start + _COMMIT]]
            write_part(folder, part, own)
            journal.commit(own, part)

    measured("part files and commits", keep)
    measured("tables", lambda: write_tables(spec, journal, folder, folder / "out"))
    journal.close()
    return rows


class _Idle(Engine):
    """Has workers answer at once."""

    def _submit(self, tasks: list[Task]) -> Any:
        content = pickle.dumps(tasks, protocol=5)
        future = self._client.submit(_answer, content, pure=False)
        self._running[future] = tasks
        future.add_done_callback(self._finished.put)
        return future


def _answer(content: bytes) -> bytes:
    front = Front(*(np.zeros(POINTS) for _ in Front._fields))
    took_s = BATCH_S / _BATCH
    return pickle.dumps([Record(task.id, "done", front=front, cpu_s=took_s) for task in pickle.loads(content)])


def dispatch_ms(spec: SweepSpec, batches: int) -> dict[str, float]:
    """What the driver, with the scheduler in it, takes for a batch of 50 beside its workers, ms."""

    def tasks() -> Iterator[Task]:
        for number in range(batches * _BATCH):
            yield task_of(spec[number % len(spec)], number)

    with started(Cluster(workers=1)) as connect:
        client = connect()
        client.submit(_answer, pickle.dumps([task_of(spec[0], 0)])).result()
        started_s = time.process_time()
        done = sum(map(len, _Idle(client, Batches(tasks(), lambda: None)).records()))
        cpu_s = time.process_time() - started_s
    return {"per batch": 1e3 * cpu_s / (done / _BATCH), "per scenario": 1e3 * cpu_s / done}


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.sweeps", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "sweeps")
    parser.add_argument("--quick", action="store_true", help="few scenarios: to see that it works")
    options = parser.parse_args()
    masses, winds = (3, 4) if options.quick else (MASSES, WINDS)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path = write_spec(folder, masses, winds)
        spec = read_spec(path)
        (folder / "first").mkdir()
        run_through(write_spec(folder / "first", 2, 2), folder / "out-first", 1)  # kernels and bytecode
        through = [run_through(path, folder / f"out-{workers}", workers) for workers in (1, 2)]
        gain = sharing_gain(spec, min(len(spec), 440))
        dispatch = dispatch_ms(spec, 20 if options.quick else 400)
        (folder / "driver").mkdir()
        parts = driver_parts(spec, folder / "driver")
    content = {
        "schema": "tgvdp.sweep-benchmark/1",
        "through": through,
        "sharing": gain,
        "dispatch_ms": dispatch,
        "driver": parts,
    }
    gained = through[1]["a second, by the clock"] / through[0]["a second, by the clock"]
    page = "\n".join(
        [
            "# Sweeps: metro sections, fronts of 30 points", "", markdown_table(through),
            f"Two workers do {gained:.2f} times what one does.", "",
            "## Driver, per scenario", "", markdown_table(parts), markdown_table([dispatch]), markdown_table([gain]),
        ]
    )  # fmt: skip
    provenance = make_provenance({"masses": masses, "winds": winds, "points": POINTS}, {}, 0.0)
    write_ledger(options.out, {"sweeps.json": to_json(content), "sweeps.md": page.encode()}, provenance)
    print(page)
    return 0


if __name__ == "__main__":
    sys.exit(main())
