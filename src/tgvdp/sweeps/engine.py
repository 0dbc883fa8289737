"""Dask's workers solve batches; whoever kills its worker is found and set aside.

A batch is one task of Dask. When its worker dies, its tasks run again one by one; when a worker dies of a single one,
that runs again with nothing else under way, so that nobody else can be the reason; at its third death it is reported as
killed. So one poison scenario costs four workers and itself, and nothing else.
"""

import contextlib
import pickle
import queue
from collections import deque
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from tgvdp.errors import InputError, MissingExtraError, UnavailableError
from tgvdp.second_process import usable_cores
from tgvdp.sweeps.batches import Batches
from tgvdp.sweeps.scenario import Task, engine_version
from tgvdp.sweeps.work import Record, solve_batch

if TYPE_CHECKING:
    from distributed import Client, Future

#: Deaths of workers after which a task is reported as killed.
MOST_DEATHS = 3
#: Batches under way for each worker: one runs, one waits.
_AHEAD = 2
#: Time between two looks at the clock, s.
_TICK_S = 0.2
#: Time for a scheduler to answer, s.
_CONNECT_S = 10.0
#: Workers of an own cluster: one thread of everything, and no spilling, for they keep nothing.
_LOCAL = {
    "distributed.scheduler.allowed-failures": 0,
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.admin.system-monitor.gil.enabled": False,
}
_ONE_THREAD = {
    name: "1" for name in ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")
}


class Cluster(NamedTuple):
    """Where tasks run: on a cluster of one's own, or on one that is there.

    Attributes
    ----------
    scheduler : str or None
        Address of a scheduler; None starts workers on this machine, which end with the context.
    workers : int or None
        Processes on this machine; by default one for each core.
    worker_memory_b : float or None
        Memory at most of each; by default an equal share of the machine's.
    """

    scheduler: str | None = None
    workers: int | None = None
    worker_memory_b: float | None = None


@contextlib.contextmanager
def connected(cluster: Cluster) -> "Iterator[Client]":
    """Connect to a cluster, or start one.

    Raises
    ------
    MissingExtraError
        When Dask is not installed.
    UnavailableError
        When the scheduler does not answer.
    """
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError:
        raise MissingExtraError("sweeps need dask and pyarrow: pip install 'tgvdp[sweep]'") from None
    with dask.config.set(_LOCAL), contextlib.ExitStack() as stack:
        if cluster.scheduler is None:
            count = usable_cores() if cluster.workers is None else cluster.workers
            address: Any = stack.enter_context(
                LocalCluster(
                    n_workers=count,
                    threads_per_worker=1,
                    processes=True,
                    memory_limit="auto" if cluster.worker_memory_b is None else int(cluster.worker_memory_b),
                    host="127.0.0.1",
                    dashboard_address="127.0.0.1:0" if has_dashboard() else None,
                    silence_logs=_SILENT,
                    env=_ONE_THREAD,
                )
            )
        else:
            address = cluster.scheduler
        try:
            client = stack.enter_context(Client(address, timeout=_CONNECT_S, set_as_default=False))
        except (OSError, ValueError) as error:
            raise UnavailableError(f"no scheduler answers at {cluster.scheduler}: {error}") from error
        yield client


_SILENT = 100  # above logging.CRITICAL: what goes wrong is reported by the sweep itself


def has_dashboard() -> bool:
    """Whether Dask can show its dashboard here."""
    from importlib.util import find_spec

    return find_spec("bokeh") is not None


def dashboard_of(client: "Client") -> str:
    """Address of the dashboard of a cluster; empty where it has none."""
    services = client.scheduler_info().get("services", {})
    return client.dashboard_link if "dashboard" in services and has_dashboard() else ""


class Engine:
    """Has batches solved, and returns records as they come.

    Parameters
    ----------
    client : distributed.Client
    batches : Batches
    """

    def __init__(self, client: "Client", batches: Batches) -> None:
        self._client = client
        self._batches = batches
        self._engine = engine_version()
        self._running: dict[Future, list[Task]] = {}
        self._finished: queue.SimpleQueue[Future] = queue.SimpleQueue()
        self._suspects: deque[Task] = deque()
        self._accused: deque[Task] = deque()
        self._deaths: dict[int, int] = {}

    def records(self) -> Iterator[list[Record]]:
        """Yield what has come since the last time, at least every fifth of a second, until all is done.

        Raises
        ------
        UnavailableError
            When the scheduler is gone.
        InputError
            When a worker is of another version.
        """
        while self._fill():
            yield self._collected()

    def _fill(self) -> bool:
        """Submit what there is room for; False when nothing is left, nor under way."""
        workers = max(len(self._client.nthreads()), 1)
        while len(self._running) < _AHEAD * workers:
            tasks = [self._suspects.popleft()] if self._suspects else self._batches.take(workers)
            if not tasks:
                break
            self._submit(tasks)
        if not self._running and self._accused:
            self._submit([self._accused.popleft()])
        return bool(self._running)

    def _submit(self, tasks: list[Task]) -> None:
        content = pickle.dumps(tasks, protocol=5)
        future = self._client.submit(solve_batch, content, self._engine, pure=False)
        self._running[future] = tasks
        future.add_done_callback(self._finished.put)

    def _collected(self) -> list[Record]:
        """Records of the batches that have finished; waits for the first a moment at most."""
        records: list[Record] = []
        with contextlib.suppress(queue.Empty):
            records += self._records_of(self._finished.get(timeout=_TICK_S))
            while True:
                records += self._records_of(self._finished.get_nowait())
        return records

    def _records_of(self, future: "Future") -> list[Record]:
        from distributed import KilledWorker

        tasks = self._running.pop(future)
        try:
            records: list[Record] = pickle.loads(future.result())
        except KilledWorker as error:
            return self._died(tasks, error.allowed_failures + 1)
        except InputError:
            raise
        except Exception as error:
            raise UnavailableError(f"the scheduler is gone: {type(error).__name__}") from error
        for task, record in zip(tasks, records, strict=True):
            if record.status != "failed":
                self._batches.pace.observe(task, record.elapsed_s)
        return records

    def _died(self, tasks: list[Task], deaths: int) -> list[Record]:
        """Narrow down of which task workers die."""
        if len(tasks) > 1:
            self._suspects.extend(tasks)
            return []
        (task,) = tasks
        self._deaths[task.id] = self._deaths.get(task.id, 0) + deaths
        if self._deaths[task.id] < MOST_DEATHS:
            self._accused.append(task)
            return []
        return [Record(task.id, "killed", f"{self._deaths[task.id]} workers died of it")]
