"""``python -m tgvdp`` and the console command ``tgvdp``."""

import os
import signal
import sys
from types import FrameType
from typing import NoReturn

from tgvdp.start import start_fast

#: Subcommands that may use scipy themselves.
_NEEDS_SCIPY = {"solve", "bench"}
#: Subcommands that load much, and have tidied up when they return.
_LEAVES_ALL = {"sweep"}
_INTERRUPTED = 130
#: Neither the input nor the user is at fault.
_BROKEN = 1


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
    if code == cli.EXIT_INTERRUPTED or _LEAVES_ALL & set(sys.argv[1:2]):
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
