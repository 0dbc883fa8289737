"""``python -m tgvdp`` and the console command ``tgvdp``."""

import gc
import os
import signal
import sys
from types import FrameType
from typing import NoReturn

#: Imports and pictures make many objects that stay; looking for cycles among them takes a tenth of a short run.
_GC_THRESHOLD = 100_000
#: Subcommands that may use scipy themselves.
_NEEDS_SCIPY = {"solve", "bench"}
_INTERRUPTED = 130
#: Neither the input nor the user is at fault.
_BROKEN = 1
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
    """Run the command line in this process, which is its own and should start fast, and end so at Ctrl-C."""
    heard: list[int] = []
    has_begun = False

    def interrupt(number: int, frame: FrameType | None) -> None:
        heard.append(number)
        if not has_begun:  # libraries that are being loaded make other errors of it, or nothing
            _end_interrupted()
        signal.default_int_handler(number, frame)

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, interrupt)
    start_fast(bool(_NEEDS_SCIPY & set(sys.argv[1:2])))
    try:
        from tgvdp import cli

        has_begun = True
        code = cli.main()
    except ImportError as error:  # packages that one may do without are asked for where they are used
        print(f"tgvdp: error: the installation lacks something: {error}", file=sys.stderr)
        return _BROKEN
    except BaseException:
        if not heard:  # commands load libraries, too
            raise
        _end_interrupted()
    if code == cli.EXIT_INTERRUPTED:
        _leave(code)
    return code


def _end_interrupted() -> NoReturn:
    print("tgvdp: error: interrupted", file=sys.stderr)
    _leave(_INTERRUPTED)


def _leave(code: int) -> NoReturn:
    """End without unloading libraries, which takes half a second; files and processes are tidied up."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


if __name__ == "__main__":
    sys.exit(main())
