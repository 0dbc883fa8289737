"""The cores of this machine, and work side by side on them."""

import contextlib
import functools
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextvars import ContextVar, copy_context
from typing import Any, TypeVar

from tgvdp.progress import heard_by

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")

_on_one: ContextVar[bool] = ContextVar("on_one", default=False)


def usable_cores() -> int:
    """Cores that this process may use, which containers often restrict."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextlib.contextmanager
def on_one_core() -> Iterator[None]:
    """Leave the other cores to processes of the same kind, which work beside this one."""
    token = _on_one.set(True)
    try:
        yield
    finally:
        _on_one.reset(token)


def shares(work: float, least: float, each: int = 1) -> int:
    """Into how many parts to cut some work for `side_by_side`, so that none is less than ``least``.

    At most so many for ``each`` core: several where it is not known how long a part takes.
    """
    if _on_one.get() or work < 2.0 * least:
        return 1
    cores = usable_cores()
    return min(each * cores, int(work / least)) if cores > 1 else 1


def even_parts(items: Sequence[_Item], count: int) -> list[Sequence[_Item]]:
    """Neighbouring items in so many parts, or as many as there are items, of about as many each."""
    count = min(count, len(items))
    return [items[len(items) * i // count : len(items) * (i + 1) // count] for i in range(count)]


def side_by_side(function: Callable[..., _Result], *arguments: Iterable[Any]) -> list[_Result]:
    """What a function returns for arguments, as of ``map``: on all usable cores, or one after the other on one.

    What it calls works on one core, unheard, and else in the context of the caller. All have ended when this returns,
    or raises the first of their errors.
    """
    calls = list(zip(*arguments, strict=True))
    cores = 1 if _on_one.get() or len(calls) < 2 else usable_cores()
    if cores == 1:
        return [function(*call) for call in calls]
    with on_one_core(), heard_by(None):
        tasks = [functools.partial(copy_context().run, function, *call) for call in calls]
    # The last call is this thread's own, and whatever of the others nobody has begun: to hand on work takes time.
    futures = [_threads(cores - 1).submit(task) for task in tasks[:-1]]
    here: list[Future[_Result]] = []
    try:
        while True:
            here.append(_done(tasks[len(futures)]))
            if not futures or not futures[-1].cancel():
                return [future.result() for future in (*futures, *reversed(here))]
            futures.pop()
    finally:
        for future in futures:
            future.cancel()
        wait(futures)


def _done(task: Callable[[], _Result]) -> "Future[_Result]":
    """A future of what has been done here: its error waits until those of earlier calls are known."""
    future: Future[_Result] = Future()
    try:
        future.set_result(task())
    except Exception as error:
        future.set_exception(error)
    return future


@functools.cache
def _threads(count: int) -> ThreadPoolExecutor:
    """Threads that stay: to start them takes as long as a short run."""
    return ThreadPoolExecutor(count, "tgvdp")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_threads.cache_clear)  # a child has but the thread that forked it
