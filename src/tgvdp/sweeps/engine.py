"""Dask's workers solve batches; whoever kills its worker is found and set aside.

A batch is one task of Dask. When its worker dies, its tasks run again one by one; when a worker dies with a single one,
that runs again with nothing else under way, so that nobody else can be the reason; when three workers have died of it
alone, it is reported as killed. So one poison scenario costs five workers and itself, and nothing else.
"""

import contextlib
import math
import pickle
import queue
import time
from collections import deque
from collections.abc import Iterator
from concurrent.futures import CancelledError
from typing import TYPE_CHECKING

from tgvdp.errors import UnavailableError
from tgvdp.sweeps.batches import Batches
from tgvdp.sweeps.cluster import count_workers
from tgvdp.sweeps.scenario import Task, engine_version
from tgvdp.sweeps.work import Record, solve_batch

if TYPE_CHECKING:
    from distributed import Client, Future

#: Workers that die of a task alone before it is reported as killed.
MOST_DEATHS = 3
#: Batches under way for each worker: one runs, one waits.
_AHEAD = 2
#: Time within which a worker of an own cluster has to be there, s; on others they may have to queue.
PATIENCE_S = 120.0
#: Time between two looks at the clock, s.
_TICK_S = 0.2
#: Time between two questions how many workers there are, s.
_ASK_S = 1.0


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
        self._running: dict[Future[bytes], list[Task]] = {}
        self._finished: queue.SimpleQueue[Future[bytes]] = queue.SimpleQueue()
        self._suspects: deque[Task] = deque()
        self._accused: deque[Task] = deque()
        self._alone: Future[bytes] | None = None
        self._deaths: dict[int, int] = {}
        self._count, self._asked_s = 1, -math.inf
        self._seen_s = time.monotonic()

    def records(self) -> Iterator[list[Record]]:
        """Yield what has come since the last time, at least every fifth of a second, until all is done.

        Raises
        ------
        UnavailableError
            When the scheduler is gone, or no worker of an own cluster outlives its start.
        InputError
            When a worker is of another version.
        """
        try:
            while self._fill():
                yield self._collected()
        except (OSError, CancelledError) as error:
            raise UnavailableError("the scheduler is gone; with another one --resume goes on") from error

    def _fill(self) -> bool:
        """Submit what there is room for; False when nothing is left, nor under way."""
        workers = self._workers()
        while len(self._running) < _AHEAD * workers:
            tasks = [self._suspects.popleft()] if self._suspects else self._batches.take(workers)
            if not tasks:
                break
            self._submit(tasks)
        if not self._running and self._accused:
            self._alone = self._submit([self._accused.popleft()])
        return bool(self._running)

    def _workers(self) -> int:
        """Number of workers, which come and go, or 1 where there are none yet; asked for now and then."""
        if time.monotonic() >= self._asked_s + _ASK_S:
            count, self._asked_s = count_workers(self._client), time.monotonic()
            if count or self._client.cluster is None:
                self._seen_s = self._asked_s
            elif self._asked_s > self._seen_s + PATIENCE_S:
                raise UnavailableError(f"no worker starts within {PATIENCE_S:g} s: each may need more memory")
            self._count = max(count, 1)
        return self._count

    def _submit(self, tasks: list[Task]) -> "Future[bytes]":
        content = pickle.dumps(tasks, protocol=5)
        future = self._client.submit(solve_batch, content, self._engine, pure=False)
        self._running[future] = tasks
        future.add_done_callback(self._finished.put)
        return future

    def _collected(self) -> list[Record]:
        """Records of the batches that have finished; waits for the first a moment at most."""
        records: list[Record] = []
        with contextlib.suppress(queue.Empty):
            records += self._records_of(self._finished.get(timeout=_TICK_S))
            while True:
                records += self._records_of(self._finished.get_nowait())
        return records

    def _records_of(self, future: "Future[bytes]") -> list[Record]:
        from distributed import KilledWorker

        tasks = self._running.pop(future)
        try:
            records: list[Record] = pickle.loads(future.result())
        except KilledWorker as error:
            return self._died(tasks, error.allowed_failures + 1, is_alone=future is self._alone)
        for task, record in zip(tasks, records, strict=True):
            if record.status != "failed":
                self._batches.pace.observe(task, record.cpu_s)
        return records

    def _died(self, tasks: list[Task], deaths: int, *, is_alone: bool) -> list[Record]:
        """Narrow down of which task workers die."""
        if len(tasks) > 1:
            self._suspects.extend(tasks)
            return []
        (task,) = tasks
        if is_alone:
            self._deaths[task.id] = self._deaths.get(task.id, 0) + deaths
        if self._deaths.get(task.id, 0) < MOST_DEATHS:
            self._accused.append(task)
            return []
        return [Record(task.id, "killed", f"{MOST_DEATHS} workers died of it")]
