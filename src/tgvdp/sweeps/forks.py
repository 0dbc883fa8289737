"""Where workers on this machine come from: deaf to Ctrl-C, and forked from a process that has loaded what they need.

That process is multiprocessing's fork server, of which a process has one at most. So it is for commands, whose process
is the program's own; it loads while the driver does, on another core, and once for all workers, those that stand in for
dead ones too. Other platforms than Linux do not stand it: there, and without it, each worker is started from nothing.
"""

import contextlib
import multiprocessing
import os
import signal
import sys
from collections.abc import Iterator
from multiprocessing import forkserver, resource_tracker

#: What workers of an own cluster load as they start.
PRELOAD = "tgvdp.sweeps.preload"
_DASK = "distributed.nanny"
#: Memory that a worker keeps for the next front, B. Dask has glibc give it back at once, and large arrays at each
#: release, so that every front is computed in fresh pages: an eighth of its time. Other systems do not look here.
_KEPT_B = 64 << 20
#: glibc looks at them when a process starts.
MALLOC = {"MALLOC_TRIM_THRESHOLD_": str(_KEPT_B), "MALLOC_MMAP_THRESHOLD_": str(_KEPT_B // 2)}
ONE_THREAD = {name: "1" for name in ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")}


def start_fork_server() -> bool:
    """Start the process that workers are forked from, which loads from now on; whether there is one.

    For a process that is the program's own: its environment changes.
    """
    if sys.platform != "linux":
        return False
    os.environ.update(MALLOC | ONE_THREAD)
    multiprocessing.set_forkserver_preload([PRELOAD, _DASK])
    with deaf_threads():
        forkserver.ensure_running()
    return True


@contextlib.contextmanager
def deaf_threads() -> Iterator[None]:
    """Have threads made meanwhile, and the processes that they start, not hear Ctrl-C, which terminals send to all."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    _start_tracker()  # which would have the first worker hear it
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start_tracker() -> None:
    """Start the process that clears up after multiprocessing, and have it say nothing of what Ctrl-C leaves behind."""
    options = sys.warnoptions[:]
    sys.warnoptions.append("ignore:resource_tracker:UserWarning")
    try:
        resource_tracker.ensure_running()
    finally:
        sys.warnoptions[:] = options
