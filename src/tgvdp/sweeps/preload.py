"""What each worker of an own cluster, or what it is forked from, loads as it starts, while the driver makes ready."""

import logging

from tgvdp.start import start_fast

start_fast(needs_scipy=False)
logging.disable()  # a worker that is closed as it starts would say so: what goes wrong is reported by the sweep itself

from tgvdp.sweeps.scenario import engine_version  # noqa: E402
from tgvdp.sweeps.work import load_what_is_compiled  # noqa: E402

engine_version()
load_what_is_compiled("front")  # what most sweeps need
