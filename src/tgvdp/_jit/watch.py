"""Who wants to know what is being compiled: people who wait, and tests that count."""

import contextlib
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from numba.core import config, event

from tgvdp._jit.cache import KernelCache


class Compiled(NamedTuple):
    """A kernel that Python called and that had to be compiled, and how long that took, s."""

    kernel: str
    elapsed_s: float


class _Listener(event.Listener):  # type: ignore[misc]
    """Takes note of the outermost ones: kernels are compiled within the kernels that call them."""

    def __init__(self, told: Callable[[bool], object]) -> None:
        self.compiled: list[Compiled] = []
        self._told = told
        self._started: list[float] = []

    def on_start(self, _: Any) -> None:
        self._started.append(time.perf_counter())
        if len(self._started) == 1:
            self._told(True)

    def on_end(self, ended: Any) -> None:
        if not self._started:  # another thread began that before anybody listened
            return
        started = self._started.pop()
        if not self._started:
            function = ended.data["dispatcher"].py_func
            name = f"{function.__module__}.{function.__name__}".removeprefix("tgvdp.")
            self.compiled.append(Compiled(name, time.perf_counter() - started))
            self._told(False)


@contextlib.contextmanager
def watch(told: Callable[[bool], object] = bool) -> Iterator[list[Compiled]]:
    """Collect what is compiled meanwhile; ``told`` hears True when a compilation begins, False when it ends."""
    listener = _Listener(told)
    with event.install_listener("numba:compile", listener):
        yield listener.compiled


def is_compiled() -> bool:
    """Whether kernels are compiled at all: with ``NUMBA_DISABLE_JIT=1`` they stay Python."""
    return not config.DISABLE_JIT


def is_missing(kernel: Any) -> bool:
    """Whether a kernel has to be compiled, there is a cache to keep it, and no other process is about to fill that."""
    cache = getattr(kernel, "_cache", None)
    return isinstance(cache, KernelCache) and cache.wait_for_it is None and not cache.is_filled()


def leave_to_another(kernel: Any, wait: Callable[[], object]) -> None:
    """Have another process compile a kernel that `is_missing`: who calls it here waits until that is done."""
    kernel._cache.wait_for_it = wait


def take_back(kernel: Any) -> None:
    """Wait for no other process any more, whether or not it was waited for."""
    kernel._cache.wait_for_it = None
