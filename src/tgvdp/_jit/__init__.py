"""The only numba decorators of the package; `cache` keeps what they compile."""

import contextlib
import gc
import signal
import threading
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
from numba.core import config
from numba.core.types.misc import unliteral

from tgvdp._jit.cache import KernelCache, warn_uncached
from tgvdp._jit.pipeline import KernelCompiler, LinkedCompiler, Resolutions

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


class _QuickCompilation(contextlib.ContextDecorator):
    """Compiles with LLVM's first level of optimisation, without garbage collections, and with a memory for types.

    No kernel runs slower so: what they do is scalar arithmetic that the first level does not leave undone. Compilations
    nest; numba lets one thread compile at a time.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._depth = 0
        self._before: tuple[Any, bool] = (config.OPT, False)
        self._resolutions = Resolutions()

    def __enter__(self) -> None:
        self._lock.acquire()
        self._depth += 1
        if self._depth == 1:
            self._before = (config.OPT, gc.isenabled())
            config.OPT = config._OptLevel(min(int(config.OPT), 1))
            gc.disable()
            self._resolutions.__enter__()

    def __exit__(self, *_: object) -> None:
        self._depth -= 1
        if self._depth == 0:
            self._resolutions.__exit__()
            config.OPT, collecting = self._before
            if collecting:
                gc.enable()
        self._lock.release()


_quick_compilation = _QuickCompilation()


#: No Python objects, no GIL, IEEE division.
_OPTIONS = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}


def _compiled(function: _Function, **options: Any) -> Any:
    """Compile a function twice, if need be: for Python, and to be linked into the kernels that call it.

    Once for these, and not once for each constant that they pass: numba specialises on literal integers. Nothing is
    allocated in kernels, so that they need none of the reference counts that numba keeps (``_nrt``).
    """
    options |= _OPTIONS | {"_nrt": False}
    compiled: Any = numba.njit(pipeline_class=KernelCompiler, **options)(function)
    if not config.DISABLE_JIT:
        linked = numba.njit(pipeline_class=LinkedCompiler, no_cpython_wrapper=True, **options)(function)
        linked.compile = _interrupt_hold(linked.compile)
        linked.add_overload = lambda result: linked.overloads.__setitem__(tuple(result.signature.args), result)

        def get_call_template(args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
            plain = {name: unliteral(kind) for name, kind in kws.items()}
            return linked.get_call_template(tuple(unliteral(kind) for kind in args), plain)

        compiled.get_call_template = get_call_template
        compiled.get_overload = linked.get_overload
        compiled.linked = linked
    return compiled


def _cached(function: _Function, compiled: Any, *, allocates: bool) -> _Function:
    """Keep on disk what is compiled, and compile it quickly."""
    if not config.DISABLE_JIT:
        try:
            compiled._cache = KernelCache(function, allocates=allocates)
        except OSError as error:  # no home folder, or sources that are no files
            warn_uncached(str(error))
        compiled.compile = _interrupt_hold(_quick_compilation(compiled.compile))
    return cast(_Function, compiled)


def kernel(function: _Function) -> _Function:
    """Compile a function with numba: no Python objects, no GIL, IEEE division, no new arrays, cached on disk.

    No fastmath: costs are compared with infinity. With ``NUMBA_DISABLE_JIT=1`` the function is returned as it is.
    """
    return _cached(function, _compiled(function), allocates=False)


def allocating(function: _Function) -> _Function:
    """Compile a kernel that makes the arrays which it fills: by numba's own steps, with reference counts."""
    return _cached(function, numba.njit(**_OPTIONS)(function), allocates=True)


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
