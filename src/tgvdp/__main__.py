"""``python -m tgvdp`` and the console command ``tgvdp``."""

import gc
import os
import sys

#: Imports and pictures make many objects that stay; looking for cycles among them takes a tenth of a short run.
_GC_THRESHOLD = 100_000
#: Subcommands that may use scipy themselves.
_NEEDS_SCIPY = {"solve", "bench"}
#: What matplotlib and numba read while they are loaded, and refuse to be loaded for where it means nothing to them.
#: Pictures are drawn into files without a backend, and kernels run in one thread.
_NO_CONCERN = ("MPLBACKEND", "NUMBA_NUM_THREADS")


def start_fast(needs_scipy: bool) -> None:
    """Prepare this process, which is the program's own, for a fast start."""
    gc.set_threshold(_GC_THRESHOLD)
    for name in _NO_CONCERN:
        os.environ.pop(name, None)
    # numba imports these where they are installed, for BLAS and for line coverage in kernels: 0.25 s for nothing here.
    for name in ("coverage",) if needs_scipy else ("scipy", "coverage"):
        sys.modules.setdefault(name, None)  # type: ignore[arg-type]


def main() -> int:
    """Run the command line in this process, which is its own and should start fast."""
    start_fast(bool(_NEEDS_SCIPY & set(sys.argv[1:2])))
    from tgvdp import cli

    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
