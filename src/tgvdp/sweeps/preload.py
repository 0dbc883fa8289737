"""What each worker of an own cluster, or what it is forked from, loads as it starts, while the driver makes ready."""

from tgvdp.start import start_fast

start_fast(needs_scipy=False)

from tgvdp.api import warm  # noqa: E402, F401
