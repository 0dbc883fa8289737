"""What runs in a worker: the tasks of a batch, one after the other, each with its result or its error."""

import functools
import gc
import os
import pickle
import platform
import time
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.cores import on_one_core
from tgvdp.errors import InputError, TgvdpError
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.sweeps.scenario import Task, engine_version

Status = Literal["done", "partial", "failed", "killed"]
_Floats = NDArray[np.float64]
#: New objects between two looks for garbage: some fronts, of which next to nothing is garbage that only a look finds.
_YOUNG = 20_000
#: File of the cache that tells that the kernels of a method are in it.
_MARK = "{}.compiled"
#: Trains and lines with fields set that a worker remembers.
_KNOWN = 16


class Front(NamedTuple):
    """Points of a front: running times, s, energies, J, and prices of a minute, kWh/min (not finite: none), (n,)."""

    time_s: _Floats
    energy_j: _Floats
    price_kwh_per_min: _Floats


class Allocation(NamedTuple):
    """What each section of a journey gets: running times, s, and energies, J, (n, sections); ends of sections, m."""

    time_s: _Floats
    energy_j: _Floats
    ends_m: _Floats


class Record(NamedTuple):
    """What came of a task.

    Attributes
    ----------
    id : int
    status : {"done", "partial", "failed", "killed"}
        Partial: its budget ended it. Failed: it has an error. Killed: its worker died of it, time and again.
    error : str or None
    fastest_time_s, fastest_energy_j : float or None
    front : Front or None
    allocation : Allocation or None
        Of journeys.
    profiles : mapping or None
        Columns of the rows of all speed profiles, with the point that each belongs to.
    elapsed_s, cpu_s : float
        What it took, on the clock and of the processor.
    worker : str
        Machine and process.
    """

    id: int
    status: Status
    error: str | None = None
    fastest_time_s: float | None = None
    fastest_energy_j: float | None = None
    front: Front | None = None
    allocation: Allocation | None = None
    profiles: Mapping[str, Any] | None = None
    elapsed_s: float = 0.0
    cpu_s: float = 0.0
    worker: str = ""

    @property
    def rows(self) -> int:
        """Rows of all tables that this is."""
        profiles = 0 if self.profiles is None else len(self.profiles["point"])
        return profiles + (0 if self.front is None else len(self.front.time_s))


def solve_batch(content: bytes, engine: str) -> bytes:
    """Solve the tasks of a batch.

    Parameters
    ----------
    content : bytes
        The pickled list of tasks.
    engine : str
        `engine_version` of who asks.

    Returns
    -------
    bytes
        The pickled list of their records. Pickled here, because Dask would send each array on its own.

    Raises
    ------
    InputError
        When the worker is of another version.
    """
    if engine != engine_version():
        raise InputError(f"a worker on {platform.node()} runs tgvdp {engine_version()}, the sweep {engine}")
    tasks: Sequence[Task] = pickle.loads(content)
    return pickle.dumps([solve(task) for task in tasks], protocol=5)


def solve(task: Task) -> Record:
    """Solve one task; whatever goes wrong is in its record."""
    worker = _worker()
    try:
        _load_kernels(task)
        started_s, started_cpu_s = time.perf_counter(), time.process_time()
        with on_one_core():  # the others have workers of their own
            record = _solved(task)
    except TgvdpError as error:
        return Record(task.id, "failed", str(error), worker=worker)
    except Exception as error:  # a fault of tgvdp: the others go on
        return Record(task.id, "failed", f"{type(error).__name__}: {error}", worker=worker)
    elapsed_s, cpu_s = time.perf_counter() - started_s, time.process_time() - started_cpu_s
    return record._replace(elapsed_s=elapsed_s, cpu_s=cpu_s, worker=worker)


def _solved(task: Task) -> Record:
    from tgvdp import api

    train, track = _changed(task.train, task.track, task.changes) if task.changes else (task.train, task.track)
    if task.kind == "journey":
        journey = api.journey(train, track, **task.arguments)
        front = Front(journey.front.time_s, journey.front.energy_j, np.asarray(journey.price_kwh_per_min))
        ends_m = np.array([journey.sections[0].trip.origin_m, *(one.trip.destination_m for one in journey.sections)])
        allocation = Allocation(journey.section_time_s, journey.section_energy_j, ends_m)
        status: Status = "done" if journey.found.complete else "partial"
        return Record(task.id, status, None, journey.fastest_time_s, journey.fastest_energy_j, front, allocation)
    result = api.search(train, track, **{"max_memory_b": _worker_memory_b(), **task.arguments})
    price = result.price_kwh_per_min
    front = Front(
        result.front.time_s, result.front.energy_j, np.full(len(result.front), np.nan) if price is None else price
    )
    profiles = None if task.profiles_every_m is None else _profiles(result, task.profiles_every_m)
    fastest = result.fastest
    status = "done" if result.complete else "partial"
    return Record(task.id, status, None, fastest.time_s, fastest.energy_j, front, None, profiles)


@functools.lru_cache(maxsize=_KNOWN)
def _changed(train: Train, track: Track, changes: tuple[str, ...]) -> tuple[Train, Track]:
    """Train and track with fields set: neighbours often have the same ones."""
    from tgvdp.formats.native.changes import changed

    made = changed(train, track, changes)
    return made.train, made.track


def _profiles(result: Any, every_m: float) -> dict[str, Any]:
    """Rows of the speed profiles of all points, one below the other."""
    from tgvdp.runs.samples import Samples, sampled

    tables = [sampled(result.trip, result.profile(index), every_m) for index in range(len(result.front))]
    point = np.repeat(np.arange(len(tables)), [len(table.position_m) for table in tables])
    return {"point": point} | {
        field: np.concatenate([getattr(table, field) for table in tables]) for field in Samples._fields
    }


@functools.cache
def _worker() -> str:
    return f"{platform.node()}:{os.getpid()}"


def _worker_memory_b() -> float | None:
    """Memory that Dask grants this worker, B: whoever asks for more is refused before the worker is killed."""
    from distributed import get_worker

    try:
        limit_b: float | None = get_worker().memory_manager.memory_limit
    except ValueError:  # no worker: an estimate
        return None
    return limit_b


def _load_kernels(task: Task) -> None:
    arguments = task.arguments
    clean, is_map = arguments.get("clean", False), arguments.get("energy", "wheel") not in ("wheel", "pantograph")
    load_kernels("clean" if clean else "map" if is_map else arguments.get("method", "front"))


@functools.cache
def load_kernels(tour: str) -> None:
    """Load the kernels of a method; where they are not compiled yet, one process of the machine does it for all.

    What is loaded then stays, and Python need not look through it for garbage again and again.

    Parameters
    ----------
    tour : str
        One of `tgvdp.api.warm.TOURS`.
    """
    import locket

    from tgvdp.api import warm

    try:
        done = warm.make_folder() / _MARK.format(tour)
        if not done.exists():
            with locket.lock_file(str(done.with_suffix(".lock"))):  # the system gives it back when its holder dies
                warm.tour(tour)
                done.touch()
    except OSError:  # nothing can be written there: what is there is used, all else compiled by each
        pass
    warm.tour(tour)
    gc.freeze()
    gc.set_threshold(_YOUNG)


def load_what_is_compiled(tour: str) -> None:
    """Load the kernels of a method, unless they have to be compiled, which whoever needs them does.

    Parameters
    ----------
    tour : str
        One of `tgvdp.api.warm.TOURS`.
    """
    from tgvdp.api import warm

    try:
        compiled = (warm.key_folder() / _MARK.format(tour)).exists()
    except OSError:  # there is no place for them
        return
    if compiled:
        load_kernels(tour)
