"""What each worker of an own cluster, or what it is forked from, loads as it starts, while the driver makes ready."""

from tgvdp.start import start_fast

start_fast(needs_scipy=False)

from tgvdp.sweeps.scenario import engine_version  # noqa: E402
from tgvdp.sweeps.work import load_what_is_compiled  # noqa: E402

engine_version()
load_what_is_compiled("front")  # what most sweeps need
