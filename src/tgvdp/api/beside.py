"""A second process that compiles half of what a search calls, while this one compiles what it begins with.

On two cores somebody waits a third less for a first front. Nothing depends on it: where it is of no use, or fails, all
is compiled here.
"""

import contextlib
import threading
from collections.abc import Iterator
from typing import Any

from tgvdp._jit.watch import is_missing, leave_to_another, take_back
from tgvdp.cores import shares
from tgvdp.methods.costate.interpolate import drive
from tgvdp.methods.phases.prune import prune_runs
from tgvdp.options.search import SearchOptions
from tgvdp.second_process import SecondProcess

#: Free until a search has asked: never released.
_unasked = threading.Lock()


def late_kernels(options: SearchOptions) -> list[tuple[Any, str]]:
    """Kernels that a search calls late and that have to be compiled, in that order, with the tasks that do it."""
    kernels: list[tuple[Any, str]] = [(drive, "tgvdp.api.warm:driving")]
    if options.min_phase_s > 0.0:
        kernels.append((prune_runs, "tgvdp.api.warm:pruning"))
    return [(kernel, task) for kernel, task in kernels if options.method == "front" and is_missing(kernel)]


@contextlib.contextmanager
def compiling_beside(options: SearchOptions) -> Iterator[None]:
    """Have a second process compile what a search calls late, where that is missing and there is another core for it.

    Parameters
    ----------
    options : SearchOptions
        Of the search.
    """
    asks = options.method == "front" and shares(2.0, 1.0) > 1 and _is_first()
    late = late_kernels(options) if asks else []
    if not late:
        yield
        return
    with SecondProcess(draws=False) as second:
        for kernel, task in late:
            done = second.promise(task)
            if second.is_there:
                leave_to_another(kernel, done)
        try:
            yield
        finally:
            for kernel, _ in late:
                take_back(kernel)


def _is_first() -> bool:
    """Whether no front of this process has asked before: after one nothing is missing."""
    return _unasked.acquire(blocking=False)
