"""The only numba decorators of the package; `cache` keeps what they compile."""

import contextlib
import functools
import signal
import threading
import time
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
from numba.core import config

from tgvdp._jit.cache import KernelCache, warn_uncached
from tgvdp._jit.steps import shortened

_Function = TypeVar("_Function", bound=Callable[..., Any])


class _InterruptHold(contextlib.ContextDecorator):
    """Holds Ctrl-C back while a kernel is compiled: LLVM's callbacks would swallow it and leave half a library behind.

    Compilations nest, callees within their caller. The interrupt is delivered at the end of the innermost one, between
    two steps of its caller's type inference, where an exception does no harm.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._held = False
        self._handler: Any = None

    def __enter__(self) -> None:
        if threading.current_thread() is threading.main_thread():  # the only one that gets signals
            self._depth += 1
            if self._depth == 1:
                self._handler = signal.getsignal(signal.SIGINT)
                self._install(self._hold)

    def __exit__(self, *_: object) -> None:
        if threading.current_thread() is threading.main_thread():
            self._depth -= 1
            if self._held or self._depth == 0:
                self._install(self._handler)
            if self._held:
                self._held = False
                signal.raise_signal(signal.SIGINT)
                if self._depth:  # the handler chose to go on
                    self._install(self._hold)

    def _install(self, handler: Any) -> None:
        if self._handler is not None:  # None: not made by Python, so it could not be put back
            signal.signal(signal.SIGINT, handler)

    def _hold(self, *_: object) -> None:
        self._held = True


_interrupt_hold = _InterruptHold()


class _Stopwatch(contextlib.ContextDecorator):
    """Measures how long kernels were compiled or loaded in this process, whatever nests, in whatever threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._total_s = 0.0
        self._depth = 0
        self._started_s = 0.0

    def __enter__(self) -> None:
        with self._lock:
            self._depth += 1
            if self._depth == 1:
                self._started_s = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._depth -= 1
            if self._depth == 0:
                self._total_s += time.perf_counter() - self._started_s

    def total_s(self) -> float:
        return self._total_s + (time.perf_counter() - self._started_s if self._depth else 0.0)


_stopwatch = _Stopwatch()


def working_s() -> float:
    """Seconds since some point in time, without those in which kernels were compiled: that is no part of any work."""
    return time.perf_counter() - _stopwatch.total_s()


#: No Python objects, no GIL, IEEE division. What a `leaf` calls is no leaf: numba hands that on unless it is told.
_OPTIONS = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True, "forceinline": False}


def _compiled(function: _Function, *, is_loop: bool = False, **options: Any) -> Any:
    """Compile a function, by the shortened steps where numba's version is one that they were tested with."""
    options = _OPTIONS | options
    if config.DISABLE_JIT or not shortened():
        return numba.njit(**options)(function)
    compiled, linked = _pipeline().compiled_and_linked(function, is_loop=is_loop, **options)
    linked.compile = _interrupt_hold(linked.compile)
    return compiled


def _pipeline() -> Any:
    """The shortened steps; here, because other versions of numba may lack what they are made of."""
    from tgvdp._jit import pipeline

    return pipeline


def _cached(function: _Function, compiled: Any) -> _Function:
    """Keep on disk what is compiled, and compile it quickly."""
    if not config.DISABLE_JIT:
        try:
            compiled._cache = KernelCache(function)
        except OSError as error:  # no home folder, or sources that are no files
            warn_uncached(str(error))
        compile_ = _pipeline().quick_compilation(compiled.compile) if shortened() else compiled.compile
        compiled.compile = _stopwatch(_after_others(compiled, _interrupt_hold(compile_)))
    return cast(_Function, compiled)


def _after_others(compiled: Any, compile_: _Function) -> _Function:
    """Compile or load a kernel once another process has done what it was asked to; Ctrl-C ends the waiting."""

    @functools.wraps(compile_)
    def compile_after_others(*args: Any, **kwargs: Any) -> Any:
        cache = compiled._cache
        if isinstance(cache, KernelCache):
            cache.await_others()
        return compile_(*args, **kwargs)

    return cast(_Function, compile_after_others)


def kernel(function: _Function) -> _Function:
    """Compile a function with numba: no Python objects, no GIL, IEEE division, no new arrays, cached on disk.

    No fastmath: costs are compared with infinity. With ``NUMBA_DISABLE_JIT=1`` the function is returned as it is.
    """
    return _cached(function, _compiled(function))


def entry(function: _Function) -> _Function:
    """Compile a kernel that Python alone calls, many times in a search: numba looks at its arguments' types once.

    At each call it would look at every array in every tuple, which takes as long as a short run. Calls whose arguments
    have the Python types of an earlier call go to the machine code itself. It takes arrays for what they were then, so
    this is for kernels whose arrays are made beside the call, contiguous and of one dtype, never given by somebody.
    Where bounds are checked, so are types, each time.
    """
    compiled: Any = kernel(function)
    if config.DISABLE_JIT or config.BOUNDSCHECK:
        return cast(_Function, compiled)
    known: dict[tuple[type, ...], Callable[..., Any]] = {}

    @functools.wraps(function)
    def call(*args: Any) -> Any:
        kinds = tuple(map(type, args))
        run = known.get(kinds)
        if run is not None:
            return run(*args)
        result = compiled(*args)
        if len(compiled.overloads) == 1:
            (overload,) = compiled.overloads.values()
            known[kinds] = overload.entry_point
        else:
            known.clear()
        return result

    cast(Any, call)._cache = compiled._cache
    return cast(_Function, call)


def allocating(function: _Function) -> _Function:
    """Compile a kernel that makes the arrays which it fills: by numba's own steps, with reference counts."""
    return _cached(function, numba.njit(**_OPTIONS)(function))


def leaf(function: _Function) -> _Function:
    """Compile a small function that other kernels call in their innermost loops, always inlined into them.

    A train is a tuple of a dozen words: not passing it makes an arc 2.5 times as fast (28 → 12 ns) and carrying a
    costate back 1.7 times (71 → 41 ns). Not cached: its machine code is part of its callers'.
    """
    return cast(_Function, _compiled(function, forceinline=True))


def part(function: _Function) -> _Function:
    """Compile a step of a larger kernel, split off for the reader, or a loop that several kernels share.

    Not cached: its machine code is part of its callers'.
    """
    return cast(_Function, _compiled(function))


def loop(function: _Function) -> _Function:
    """Compile a short loop over the items of arrays, whose turns do not depend on each other, for vector registers.

    Indices count from 0, what it calls are leaves, and nothing ends a turn early.
    """
    return cast(_Function, _compiled(function, is_loop=True))
