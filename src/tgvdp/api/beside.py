"""A second process that compiles half of what a search calls, while this one compiles the other half.

On two cores somebody waits a third less for a first front. Nothing depends on it: where it is of no use, or fails, all
is compiled here.
"""

import contextlib
import functools
import threading
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from tgvdp._jit.watch import is_missing, leave_to_another, take_back
from tgvdp.api import late
from tgvdp.cores import shares
from tgvdp.methods.costate.backward import switching_speeds
from tgvdp.methods.costate.interpolate import drive
from tgvdp.methods.phases.prune import prune_runs
from tgvdp.options.search import SearchOptions
from tgvdp.runs.bends import cut_runs
from tgvdp.runs.measure import measure_runs
from tgvdp.second_process import SecondProcess

Waiting = Callable[[], contextlib.AbstractContextManager[None]]

#: Free until a search has asked: never released.
_unasked = threading.Lock()


class Left(NamedTuple):
    """A kernel that is left to another process, the task that compiles it, and what who waits for it does meanwhile."""

    kernel: Any
    task: str
    meanwhile: Callable[[], object] = list
    arguments: tuple[Any, ...] = ()  # of the task


def left_to_another(options: SearchOptions) -> list[Left]:
    """Kernels that another process compiles for a search, in the order in which it does.

    They take about as long as the others, which are compiled here before anybody would wait. Without the largest of
    them nobody waits for so long that another process is worth its while.
    """
    if options.method != "front" or not is_missing(drive):
        return []
    solves = is_missing(switching_speeds)
    prunes = options.min_phase_s > 0.0 and is_missing(prune_runs)
    all_of_them = (
        Left(measure_runs, f"{late.__name__}:measuring"),
        Left(cut_runs, f"{late.__name__}:cutting", late.solving if solves else list),
        Left(drive, f"{late.__name__}:driving", late.pruning if prunes else list),
    )
    return [left for left in all_of_them if is_missing(left.kernel)]


def leave(second: SecondProcess, parts: list[Left], waiting: Waiting = contextlib.nullcontext) -> None:
    """Leave kernels to a second process, where there is one; who calls one here waits for it, in a context."""
    for part in parts:
        done = second.promise(part.task, *part.arguments)
        if second.is_there:
            leave_to_another(part.kernel, functools.partial(_wait, part.meanwhile, done, waiting))


def _wait(meanwhile: Callable[[], object], done: Callable[[], object], waiting: Waiting) -> None:
    with waiting():
        meanwhile()
        done()


@contextlib.contextmanager
def compiling_beside(options: SearchOptions) -> Iterator[None]:
    """Have a second process compile half of what a search calls, where it is missing and there is another core.

    Parameters
    ----------
    options : SearchOptions
        Of the search.
    """
    asks = options.method == "front" and shares(2.0, 1.0) > 1 and _is_first()
    parts = left_to_another(options) if asks else []
    if not parts:
        yield
        return
    with SecondProcess(draws=False) as second:
        leave(second, parts)
        try:
            yield
        finally:
            for part in parts:
                take_back(part.kernel)


def _is_first() -> bool:
    """Whether no front of this process has asked before: after one nothing is missing."""
    return _unasked.acquire(blocking=False)
