"""A fast start of a process that is the program's own."""

import gc
import os
import sys
from typing import Any

#: Imports and pictures make many objects that stay; looking for cycles among them takes a tenth of a short run.
_GC_THRESHOLD = 100_000
#: What matplotlib and numba read while they are loaded, and refuse to be loaded for where it means nothing to them.
#: Pictures are drawn into files without a backend, and kernels run in one thread.
_NO_CONCERN = ("MPLBACKEND", "NUMBA_NUM_THREADS")


class _NoPandas:
    """Has pandas not be found, which pyarrow and Dask import where it is installed: 0.3 s for nothing here.

    None in its place, as below, pyarrow would take for the package.
    """

    @staticmethod
    def find_spec(name: str, *_: Any) -> None:
        """Refuse one name, and leave all others to those who know them."""
        if name == "pandas":
            raise ModuleNotFoundError("pandas is not loaded into processes of the command line", name=name)


def start_fast(needs_scipy: bool) -> None:
    """Prepare a process for a fast start, before it imports anything else."""
    gc.set_threshold(_GC_THRESHOLD)
    for name in _NO_CONCERN:
        os.environ.pop(name, None)
    # numba imports these where they are installed, for BLAS and for line coverage in kernels: 0.25 s for nothing here.
    for name in ("coverage",) if needs_scipy else ("scipy", "coverage"):
        sys.modules.setdefault(name, None)  # type: ignore[arg-type]
    if not needs_scipy:  # what needs it may need pandas as well
        sys.meta_path.insert(0, _NoPandas)
