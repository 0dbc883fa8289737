"""What each worker of an own cluster, or what it is forked from, loads as it starts, while the driver makes ready."""

import logging
import os
import sys
from pathlib import Path

from tgvdp.start import start_fast

start_fast(needs_scipy=False)

from tgvdp.sweeps.scenario import engine_version  # noqa: E402
from tgvdp.sweeps.work import load_what_is_compiled  # noqa: E402

engine_version()
load_what_is_compiled("front")  # what most sweeps need

# A worker that is closed as it starts, or dies of a closed connection, would say so on the terminal: what goes wrong is
# reported by the sweep itself.
logging.disable()
sys.stderr = Path(os.devnull).open("w")  # noqa: SIM115
