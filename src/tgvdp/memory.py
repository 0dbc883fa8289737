"""How much memory may be taken: whoever makes arrays whose size the input decides asks first.

The limit is that of ``--max-memory``, by default a share of what the machine, or the container around, has. It is held
against what the process has in use, as the system says where it does, and what is asked for.

Memory that is new to a process takes time, for the system clears each page of it: some 5 % of a short search. What is
used in every search and returned by none is kept from one to the next, for each thread.
"""

import contextlib
import functools
import math
import os
import threading
from collections.abc import Iterator
from contextvars import ContextVar
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import BudgetExceededError

#: Share of the machine's memory that may be taken unless somebody says otherwise.
_SHARE = 0.5
#: Less than this share of the limit is taken without a look at what is in use: a search asks a dozen times.
_LITTLE = 1e-4
#: Where containers say how much they may take.
_CONTAINER = Path("/sys/fs/cgroup/memory.max")
#: Arrays of more numbers than this, 64 MB, are not kept.
_MOST_KEPT = 2**23

_most_b: ContextVar[float | None] = ContextVar("most_b", default=None)
_of_thread = threading.local()


@functools.cache
def usual_limit_b() -> float:
    """A share of the memory of the machine or the container, B; infinite where neither tells."""
    known = [math.inf]
    with contextlib.suppress(ValueError, OSError, AttributeError):
        known.append(float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")))
    with contextlib.suppress(ValueError, OSError):  # no container, or "max"
        known.append(float(_CONTAINER.read_text()))
    return _SHARE * min(known)


@contextlib.contextmanager
def limited_memory(most_b: float | None) -> Iterator[None]:
    """Hold what is done meanwhile to a limit, B; None is `usual_limit_b`."""
    token = _most_b.set(most_b)
    try:
        yield
    finally:
        _most_b.reset(token)


def ask_for(size_b: float, what: str) -> None:
    """Ask for memory before it is taken.

    Parameters
    ----------
    size_b : float
    what : str
        What it is for, for people.

    Raises
    ------
    BudgetExceededError
        When there is not as much.
    """
    given = _most_b.get()
    most_b = usual_limit_b() if given is None else given
    if size_b > _LITTLE * most_b and (used_b := _used_b()) + size_b > most_b:
        scale_b, unit = (1e9, "GB") if most_b >= 1e9 else (1e6, "MB")
        asked, used, most = (f"{one_b / scale_b:.3g} {unit}" for one_b in (size_b, used_b, most_b))
        raise BudgetExceededError(f"{what} would take {asked} beside {used} in use, more than {most} (--max-memory)")


def _used_b() -> float:
    """Memory that this process has in use, B; 0 where the system does not say."""
    with contextlib.suppress(OSError, ValueError, IndexError):
        return float(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return 0.0


def scratch(purpose: str, rows: int, columns: int) -> NDArray[np.float64]:
    """An array that is this thread's until it asks for one of the same purpose again; what is in it is anything.

    Returns
    -------
    (rows, columns) float64
        Contiguous, as each of its rows is.
    """
    size = rows * columns
    kept: NDArray[np.float64] | None = getattr(_of_thread, purpose, None)
    if kept is None or len(kept) < size:
        kept = np.empty(size)
        if size <= _MOST_KEPT:
            setattr(_of_thread, purpose, kept)
    return kept[:size].reshape(rows, columns)
