"""Where batches are solved: workers on this machine, or a Dask cluster that is there."""

import asyncio
import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, NamedTuple

from tgvdp.cores import usable_cores
from tgvdp.errors import MissingExtraError, UnavailableError
from tgvdp.sweeps.forks import MALLOC, ONE_THREAD, PRELOAD, deaf_threads

if TYPE_CHECKING:
    from distributed import Client, LocalCluster

#: Time for a scheduler to answer, s.
_CONNECT_S = 10.0
#: Time for workers that stand in for dead ones to run before all are ended, s, and between two looks at them.
_SETTLE_S = 10.0
_SETTLE_LOOK_S = 0.02
#: Above logging.CRITICAL: what goes wrong is reported by the sweep itself.
_SILENT = 100
#: Of an own cluster: a death is counted here, not there; nothing is spilled or moved, for workers keep nothing, and no
#: worker pauses near its limit, for nothing would bring it back; looks at clocks, memory and machine are rarer, which
#: otherwise take a few percent of a core; and workers are not asked a hundred times a second what they are doing, which
#: takes a sixteenth of their time.
_CONFIG = {
    **{f"distributed.nanny.pre-spawn-environ.{name}": size_b for name, size_b in MALLOC.items()},
    "distributed.scheduler.allowed-failures": 0,
    "distributed.worker.profile.enabled": False,
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.scheduler.active-memory-manager.start": False,
    "distributed.worker.memory.monitor-interval": "250ms",
    "distributed.scheduler.work-stealing-interval": "500ms",
    "distributed.client.scheduler-info-interval": "30s",
    "distributed.admin.tick.interval": "2s",
    "distributed.admin.tick.cycle": "10s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.system-monitor.gil.enabled": False,
}


class Cluster(NamedTuple):
    """Where tasks run.

    Attributes
    ----------
    scheduler : str or None
        Address of a scheduler; None starts workers on this machine, which end with the context.
    workers : int or None
        Processes on this machine; by default one for each core.
    worker_memory_b : float or None
        Memory at most of each; by default an equal share of the machine's.
    forked : bool
        Whether workers on this machine are forked from the process that `forks.start_fork_server` has started.
    """

    scheduler: str | None = None
    workers: int | None = None
    worker_memory_b: float | None = None
    forked: bool = False

    @property
    def size(self) -> int | None:
        """Number of workers, where it is decided here."""
        return None if self.scheduler is not None else self.workers or usable_cores()


@contextlib.contextmanager
def started(cluster: Cluster) -> "Iterator[Callable[[], Client]]":
    """Start a cluster, unless there is one, and yield what connects to it: workers come while the driver makes ready.

    Raises
    ------
    MissingExtraError
        When Dask is not installed.
    UnavailableError
        When the scheduler does not answer.
    """
    try:
        import dask
        from distributed import Client
        from distributed.comm import get_address_host_port
        from distributed.utils import silence_logging_cmgr
    except ImportError:
        raise MissingExtraError("sweeps need dask and pyarrow: pip install 'tgvdp[sweep]'") from None
    with contextlib.ExitStack() as stack:
        stack.enter_context(silence_logging_cmgr(_SILENT))
        preload = [*dask.config.get("distributed.worker.preload", []), PRELOAD]
        own = {
            "distributed.worker.preload": preload,
            "distributed.worker.multiprocessing-method": "forkserver" if cluster.forked else "spawn",
        }
        stack.enter_context(dask.config.set(_CONFIG | own))
        with _answering(cluster):
            if cluster.scheduler is not None:
                get_address_host_port(cluster.scheduler)  # a client that cannot read it would take long to end
            # Entering one waits for its workers.
            address: Any = cluster.scheduler or stack.enter_context(_own(cluster))

        def connect() -> Client:
            with _answering(cluster):
                return stack.enter_context(Client(address, timeout=_CONNECT_S, set_as_default=False))

        try:
            yield connect
        except KeyboardInterrupt:
            # Closing waits for batches that run. Nobody waits for it: workers end with this process, if not before.
            threading.Thread(target=_close_unheard, args=(stack.pop_all(),), daemon=True).start()
            raise


def _close_unheard(stack: contextlib.ExitStack) -> None:
    """Close what was started; the process may end in the midst of it, and then Dask's loop is gone at any point."""
    with contextlib.suppress(Exception):
        stack.close()


@contextlib.contextmanager
def _answering(cluster: Cluster) -> Iterator[None]:
    """Name the scheduler that does not answer."""
    try:
        yield
    except (OSError, ValueError) as error:
        raise UnavailableError(f"no scheduler answers at {cluster.scheduler or 'this machine'}: {error}") from error


@contextlib.contextmanager
def _own(cluster: Cluster) -> "Iterator[LocalCluster]":
    """Workers on this machine, which end with the context."""
    local: Any = _local(cluster)
    with contextlib.closing(local):
        try:
            yield local
        finally:
            local.sync(_settle, local)


async def _settle(local: Any) -> None:
    """Wait until workers that stand in for dead ones run.

    When a worker dies within a moment of its start, Dask takes the next one for running though it has no process yet:
    to end such a one fails.
    """
    limit_s = time.monotonic() + _SETTLE_S
    while any(_is_starting(nanny) for nanny in local.workers.values()) and time.monotonic() < limit_s:
        await asyncio.sleep(_SETTLE_LOOK_S)


def _is_starting(nanny: Any) -> bool:
    worker = nanny.process
    return worker is not None and nanny.status.name == "running" and (worker.status.name != "running" or not worker.pid)


def _local(cluster: Cluster) -> "LocalCluster":
    """Start workers on this machine; they come one after the other, and come back when they die."""
    from distributed import LocalCluster

    with deaf_threads():
        local = LocalCluster(
            n_workers=0,
            threads_per_worker=1,
            processes=True,
            memory_limit="auto" if cluster.worker_memory_b is None else int(cluster.worker_memory_b),
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",  # any free port: sweeps may run side by side
            silence_logs=_SILENT,
            env=ONE_THREAD,
        )
    local.scale(cluster.size)
    return local


def count_workers(client: "Client") -> int:
    """Number of workers; of an own cluster those that died as they started, whom Dask gives up, are started anew.

    The scheduler of an own cluster is an object of this process: it is looked at, which takes no messages.
    """
    local: Any = client.cluster
    if local is None:
        return len(client.nthreads())
    if _lost(local):
        local.sync(_revive, local)
    return len(local.scheduler.workers)


def _lost(local: "LocalCluster") -> list[Any]:
    return [name for name, nanny in list(local.workers.items()) if nanny.status.name in ("closed", "failed")]


async def _revive(local: "LocalCluster") -> None:
    lost = _lost(local)
    for name in lost:
        del local.workers[name]
    if lost:
        local.scale(len(local.worker_spec))  # makes those that it does not hold


def dashboard_of(client: "Client") -> str:
    """Address of the dashboard of a cluster; empty where it has none."""
    services = client.scheduler_info().get("services", {})
    return str(client.dashboard_link) if "dashboard" in services and find_spec("bokeh") is not None else ""
