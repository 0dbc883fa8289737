"""Workers on this machine, as they die and are ended."""

import contextlib
import subprocess
import sys
import threading

import pytest

from tgvdp.sweeps import cluster

pytest.importorskip("distributed")

#: Workers that die as soon as they are connected, sooner than Dask looks, and whose successors take long to begin.
DEATH_BEFORE_THE_END = """
import os, time
from multiprocessing.process import BaseProcess
from distributed import KilledWorker
from distributed.nanny import WorkerProcess
from tgvdp.sweeps.cluster import Cluster, started

with started(Cluster(workers=1)) as connect:
    client = connect()
    assert client.submit(abs, -1).result() == 1
    begin = BaseProcess.start
    BaseProcess.start = lambda process: (time.sleep(2), begin(process))
    WorkerProcess._init_msg_interval = 1
    for _ in range(2):
        try:
            client.submit(lambda: os._exit(1), pure=False).result()
        except KilledWorker:
            print("killed")
"""


def test_ended_while_a_dead_worker_is_replaced():
    command = [sys.executable, "-c", DEATH_BEFORE_THE_END]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=200)
    assert (done.returncode, done.stdout, done.stderr) == (0, "killed\nkilled\n", "")


def test_an_interruption_says_nothing_of_what_cannot_be_closed_any_more(monkeypatch):
    """Dask's loop may end before its workers: a traceback of a thread stood above "interrupted"."""
    closing, unheard, closed = [], [], threading.Event()

    @contextlib.contextmanager
    def own(_):
        try:
            yield "tcp://127.0.0.1:1"
        finally:
            closing.append(threading.current_thread())
            closed.set()
            raise UnboundLocalError("cannot access local variable 'result'")

    monkeypatch.setattr(cluster, "_own", own)
    monkeypatch.setattr(threading, "excepthook", unheard.append)
    with pytest.raises(KeyboardInterrupt), cluster.started(cluster.Cluster(workers=1)):
        raise KeyboardInterrupt
    assert closed.wait(10.0)
    closing[0].join(10.0)
    assert unheard == []
