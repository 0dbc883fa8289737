"""Loaded into Dask's workers by tests (``DASK_DISTRIBUTED__WORKER__PRELOAD``): searches that are slow or deadly.

``SWEEP_FAULT`` says what the scenario with a head wind of 10 km/h and an even number does to its worker: ``signal`` or
``memory``; ``SWEEP_PAUSE_S`` how long each search sleeps, so that a test can step in.
"""

import os
import signal
import time

from tgvdp import api

_WIND_MPS = 10 / 3.6
_CHUNK_B = 20_000_000


def dask_setup(worker):
    search = api.search

    def faulty(train, track, **arguments):
        time.sleep(float(os.environ.get("SWEEP_PAUSE_S", "0")))
        fault = os.environ.get("SWEEP_FAULT")
        is_poison = train.mass_kg == 200e3 and track.name == "west" and arguments.get("wind_mps") == _WIND_MPS
        if fault and is_poison and not arguments.get("origin_m"):
            if fault == "signal":
                os.kill(os.getpid(), signal.SIGKILL)
            held = []
            while True:  # until the nanny sees it
                held.append(bytearray(os.urandom(1) * _CHUNK_B))
                time.sleep(0.01)
        return search(train, track, **arguments)

    api.search = faulty
