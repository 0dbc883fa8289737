"""The cores of this machine, and work side by side on them."""

import contextlib
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar
from typing import Any, TypeVar

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


def side_by_side(function: Callable[..., _Result], *arguments: Iterable[Any]) -> list[_Result]:
    """What a function returns for arguments, as of ``map``: on all usable cores, or one after the other on one."""
    cores = 1 if _on_one.get() else usable_cores()
    if cores == 1:
        return list(map(function, *arguments))
    with ThreadPoolExecutor(cores) as threads:
        return list(threads.map(function, *arguments))
