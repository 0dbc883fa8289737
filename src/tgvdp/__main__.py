"""``python -m tgvdp`` and the console command ``tgvdp``."""

import gc
import sys

from tgvdp import cli

#: Imports and pictures make many objects that stay; looking for cycles among them takes a tenth of a short run.
_GC_THRESHOLD = 100_000


def main() -> int:
    """Run the command line in this process, which is its own and should start fast."""
    gc.set_threshold(_GC_THRESHOLD)
    # numba imports scipy, where it is installed, for kernels that call BLAS: ours do not, and it takes 0.2 s.
    sys.modules.setdefault("scipy", None)  # type: ignore[arg-type]
    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
