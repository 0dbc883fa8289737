"""Clocks: medians of repeats on one core, and fresh processes for what a fresh process pays."""

import json
import math
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

ROOT = Path(__file__).resolve().parents[1]
#: Every library that could use more cores is held to one.
ONE_CORE = {"NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}

#: Cores that this process might use before it was pinned; empty where the platform does not tell.
_CORES = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()

_Result = TypeVar("_Result")


def pin() -> int | None:
    """Keep this process on the last of its cores; returns the core, or None where the platform cannot."""
    if not hasattr(os, "sched_setaffinity"):
        return None
    core = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {core})
    return core


@contextmanager
def on_all_cores() -> Iterator[None]:
    """Within this context the process may use all cores that it might before it was pinned."""
    if not _CORES:
        yield
        return
    pinned = os.sched_getaffinity(0)
    os.sched_setaffinity(0, _CORES)
    try:
        yield
    finally:
        os.sched_setaffinity(0, pinned)


def median_s(call: Callable[[], _Result], repeats: int, most_s: float = math.inf) -> tuple[float, _Result]:
    """Median wall time of some calls in s, and what the last one returned; call once before, to be warm.

    There are fewer calls where they take more than ``most_s`` seconds together.
    """
    times: list[float] = []
    while len(times) < repeats and sum(times) <= most_s:
        started = time.perf_counter()
        result = call()
        times.append(time.perf_counter() - started)
    return statistics.median(times), result


def run_fresh(
    arguments: Sequence[str], environment: Mapping[str, str] | None = None, all_cores: bool = False
) -> tuple[float, str]:
    """Run Python in a fresh process, on the core of this one or on all; returns its wall time in s and its output."""
    free = all_cores and _CORES
    started = time.perf_counter()
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=ROOT,
        env=os.environ | ONE_CORE | dict(environment or {}),
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
        preexec_fn=(lambda: os.sched_setaffinity(0, _CORES)) if free else None,
    )
    if done.returncode != 0:
        raise RuntimeError(f"python {' '.join(arguments)} failed:\n{done.stderr[-2000:]}")
    return time.perf_counter() - started, done.stdout


def probe(*arguments: object, environment: Mapping[str, str] | None = None, all_cores: bool = False) -> dict[str, Any]:
    """Run `benchmarks.probe` in a fresh process; returns what it reports and its wall time ``process_s``."""
    wall_s, text = run_fresh(["-m", "benchmarks.probe", *map(str, arguments)], environment, all_cores)
    return json.loads(text) | {"process_s": wall_s}


def peak_memory_bytes() -> int:
    """Largest resident memory of this process.

    Not ``getrusage`` on Linux: its figure starts with that of the process that started this one.
    """
    try:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM:"))
    except OSError:
        import resource

        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return peak if sys.platform == "darwin" else peak * 1024
