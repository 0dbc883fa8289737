"""What each worker of an own cluster loads as it starts, while the first batch for it is made."""

from tgvdp.start import start_fast

start_fast(needs_scipy=False)

from tgvdp.api import warm  # noqa: E402, F401
