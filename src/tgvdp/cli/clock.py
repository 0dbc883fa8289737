"""The time limit of a whole command, from its first line on: what each of its parts may take of it."""

import contextlib
import signal
import threading
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

from tgvdp.errors import BudgetExceededError

if TYPE_CHECKING:
    from tgvdp.methods.budget import Clock

#: What a search leaves to each part that follows it: that share of the limit, but no more than so many seconds.
_PART_SHARE, _MOST_PART_S = 0.125, 1.0
#: Share of the limit that a search has at least, however long it took to get there.
_SEARCH_SHARE = 0.25
#: What files, and the line after them, may take in any case, s: a limit that is shorter still gets the fastest run.
_PREPARING_S = 0.3
#: ... and an alarm comes again after so many seconds: Python passes over what is raised in a finalizer.
_AGAIN_S = 0.1
#: What is left when all the time is up, s: who looks at the clock does nothing then.
_NOTHING_S = 1e-9


def search_s(clock: "Clock", parts_after: int) -> float:
    """Time that a search may take, s, so that the parts after it have theirs."""
    return max(left_s(clock, parts_after), _SEARCH_SHARE * clock.limit_s)


def left_s(clock: "Clock", parts_after: int = 0) -> float:
    """Time that a part of a command may take, s, so that those after it have theirs."""
    part_s = min(_PART_SHARE * clock.limit_s, _MOST_PART_S)
    return max(clock.left_s() - parts_after * part_s, _NOTHING_S)


@contextlib.contextmanager
def preparing_within(limit_s: float | None, elapsed_s: float = 0.0) -> Iterator[None]:
    """Give up what leaves a search no time, where the system has alarms: 20 MB of rows take many seconds to read.

    For what runs no kernels only: an alarm while one is compiled or loaded would leave half of it behind.

    Parameters
    ----------
    limit_s : float, optional
        The time limit of the command, s.
    elapsed_s : float
        What has passed of it, s.

    Raises
    ------
    BudgetExceededError
        When the share of the limit that is no search's is up.
    """
    if limit_s is None or not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return
    started_s = time.perf_counter() - elapsed_s

    def give_up(*_: object) -> None:
        taken = f"files and line have taken {time.perf_counter() - started_s:.2g} s so far"
        raise BudgetExceededError(f"the time limit of {limit_s:g} s leaves no time to search: {taken}")

    handler = signal.signal(signal.SIGALRM, give_up)
    first_s = max((1.0 - _SEARCH_SHARE) * limit_s - elapsed_s, _PREPARING_S)
    timer = signal.setitimer(signal.ITIMER_REAL, first_s, _AGAIN_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, *timer)
        signal.signal(signal.SIGALRM, handler)
