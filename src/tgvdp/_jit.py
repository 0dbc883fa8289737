"""The only numba decorator of the package, and the cache of compiled kernels behind it.

numba's own ``cache=True`` has two faults that hurt a package of many modules: it keeps a stale kernel when a kernel
that it calls changes in another module, and a truncated cache file crashes the import. So the kernels of tgvdp live
in a folder of their own, named by everything that decides what they compile to: the SHA-256 of the sources of all
rooms that can matter to a kernel, the versions of Python, numba and numpy, and the switches of numba that change the
code. Each entry carries
its own digest; what cannot be read or does not match is deleted and compiled again. Where nothing can be written,
one warning says so and compilation goes on without a cache.

The folder is ``$TGVDP_CACHE_DIR``, else the user's cache folder of the platform. Deleting it is always safe, also
under a running program.
"""

import contextlib
import functools
import gc
import hashlib
import os
import pickle
import shutil
import signal
import sys
import threading
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator
from numba.core.serialize import dumps
from numba.core.types.misc import unliteral

PACKAGE = Path(__file__).resolve().parent
CACHE_DIR_VARIABLE = "TGVDP_CACHE_DIR"
#: Key folders that are kept, by last use: editions and modes (bounds checks) that take turns do not evict each other.
KEPT_FOLDERS = 8
#: Rooms that no kernel lives in or imports (a test sees to it): their changes leave the kernels as they are.
KERNEL_FREE = ("cli", "formats", "formulations", "report", "solvers")
_KEY_LENGTH = 32
#: Switches of numba that change the machine code but are no part of its own cache key.
_MODES = ("BOUNDSCHECK", "OPT", "DEBUGINFO_DEFAULT", "LOOP_VECTORIZE", "SLP_VECTORIZE")

_Function = TypeVar("_Function", bound=Callable[..., Any])


def sources_digest(folder: Path) -> str:
    """SHA-256, in hexadecimal, of the names and contents of the ``*.py`` files below a folder that kernels may use."""
    digest = hashlib.sha256()
    for parent, folders, names in os.walk(folder):
        free = KERNEL_FREE if parent == str(folder) else ()
        folders[:] = sorted(name for name in folders if name != "__pycache__" and name not in free)
        for name in sorted(names):
            if name.endswith(".py"):
                path = os.path.join(parent, name)
                with open(path, "rb") as file:
                    content = file.read()
                digest.update(f"{os.path.relpath(path, folder)}\0{len(content)}\0".encode())
                digest.update(content)
    return digest.hexdigest()


def cache_key(package: Path) -> str:
    """Name of the cache folder for the sources in ``package`` under this Python, numba, numpy and numba's modes."""
    modes = [(name, getattr(config, name, None)) for name in _MODES]
    parts = (sources_digest(package), sys.implementation.cache_tag, numba.__version__, np.__version__, modes)
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:_KEY_LENGTH]


def cache_root() -> Path:
    """Folder that holds the key folders: ``$TGVDP_CACHE_DIR`` or the platform's cache folder of this user."""
    override = os.environ.get(CACHE_DIR_VARIABLE)
    if override:
        return Path(override).absolute()
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or os.path.expanduser("~/AppData/Local")
    elif sys.platform == "darwin":
        base = os.path.expanduser("~/Library/Caches")
    else:
        base = os.environ.get("XDG_CACHE_HOME", "")
        if not os.path.isabs(base):  # the XDG specification: a relative path is to be ignored
            base = os.path.expanduser("~/.cache")
    if not os.path.isabs(base):
        raise OSError("this user has no home folder")
    return Path(base) / "tgvdp"


def remove_old_folders(root: Path, kept: int = KEPT_FOLDERS) -> None:
    """Delete the key folders used longest ago. A process that still uses one of them merely compiles again."""
    used = []
    for folder in root.iterdir():
        if len(folder.name) == _KEY_LENGTH and set(folder.name) <= set("0123456789abcdef"):
            with contextlib.suppress(FileNotFoundError):  # another process cleans up as well
                used.append((folder.stat().st_mtime, folder))
    for _, folder in sorted(used, reverse=True)[kept:]:
        shutil.rmtree(folder, ignore_errors=True)


@functools.cache
def _key_folder() -> Path:
    folder = cache_root() / cache_key(PACKAGE)
    with contextlib.suppress(OSError):  # absent or read-only: only the order of clearing up depends on it
        os.utime(folder)
    return folder


@functools.cache
def _make_key_folder() -> None:
    folder = _key_folder()
    if not folder.is_dir():
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)  # private: what lies here is executed
        remove_old_folders(folder.parent)


@functools.cache
def _warn_uncached(reason: str) -> None:
    warnings.warn(
        f"compiled kernels cannot be cached ({reason}), so every start compiles them again;"
        f" set {CACHE_DIR_VARIABLE} to a folder that can be written",
        RuntimeWarning,
        stacklevel=2,
    )


@functools.cache
def _file_digest(path: str) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


class _Locator(_CacheLocator):
    """Puts the entries of a function below the key folder, in a folder per folder of sources."""

    def __init__(self, py_func: Callable[..., Any], py_file: str) -> None:
        self._py_file = os.path.abspath(py_file)
        self._line = py_func.__code__.co_firstlineno

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> "_Locator":
        return cls(py_func, py_file)

    def ensure_cache_path(self) -> None:
        _make_key_folder()
        super().ensure_cache_path()

    def get_cache_path(self) -> str:
        # Relative to the package, so that two installations of the same sources share their kernels.
        place = os.path.relpath(os.path.dirname(self._py_file), PACKAGE)
        return str(_key_folder() / hashlib.sha256(place.encode()).hexdigest()[:16])

    def get_source_stamp(self) -> str:
        return _file_digest(self._py_file)

    def get_disambiguator(self) -> str:
        return str(self._line)


class _CheckedImpl(CompileResultCacheImpl):
    """Stores a compiled kernel with its digest: damaged machine code must not be run."""

    _locator_classes = [_Locator]  # noqa: RUF012 (its base class declares a list)

    def reduce(self, cres: Any) -> tuple[bytes, bytes]:
        content = dumps(super().reduce(cres))
        return hashlib.sha256(content).digest(), content

    def rebuild(self, target_context: Any, payload: tuple[bytes, bytes]) -> Any:
        digest, content = payload
        if hashlib.sha256(content).digest() != digest:
            raise ValueError("damaged cache entry")
        return super().rebuild(target_context, pickle.loads(content))


class _KernelCache(FunctionCache):
    """The cache of one kernel: never the reason why a program fails."""

    _impl_class = _CheckedImpl

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        # A damaged pickle may raise anything at all. None makes the dispatcher compile and save afresh.
        try:
            return super().load_overload(sig, target_context)
        except Exception:
            self._wipe()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except OSError as error:
            self.disable()
            _warn_uncached(f"{cache_root()}: {error.strerror or error}")

    def _wipe(self) -> None:
        with contextlib.suppress(OSError):  # what cannot be deleted cannot be replaced either: saving will say so
            for path in Path(self.cache_path).glob(f"{self._impl.filename_base}.*"):
                path.unlink(missing_ok=True)


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
    """Compiles with LLVM's first level of optimisation and without garbage collections.

    A cold search takes 7.3 s instead of 9.2 s of processor time so, and no kernel runs slower: what they do is scalar
    arithmetic that the first level does not leave undone. Compilations nest; numba lets one thread compile at a time.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._depth = 0
        self._before: tuple[Any, bool] = (config.OPT, False)

    def __enter__(self) -> None:
        self._lock.acquire()
        self._depth += 1
        if self._depth == 1:
            self._before = (config.OPT, gc.isenabled())
            config.OPT = config._OptLevel(min(int(config.OPT), 1))
            gc.disable()

    def __exit__(self, *_: object) -> None:
        self._depth -= 1
        if self._depth == 0:
            config.OPT, collecting = self._before
            if collecting:
                gc.enable()
        self._lock.release()


_quick_compilation = _QuickCompilation()


def _compiled(function: _Function, **options: Any) -> Any:
    """Compile a kernel once, not once for each constant that its callers pass: numba specialises on literal integers.

    One `march` instead of seven, and 13 s instead of 21 s of a cold start; the code is as fast, because LLVM still
    folds constants where it inlines.
    """
    compiled: Any = numba.njit(nogil=True, error_model="numpy", no_cfunc_wrapper=True, **options)(function)
    if not config.DISABLE_JIT:
        resolve = compiled.get_call_template

        def get_call_template(args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
            plain = {name: unliteral(kind) for name, kind in kws.items()}
            return resolve(tuple(unliteral(kind) for kind in args), plain)

        compiled.get_call_template = get_call_template
    return compiled


def kernel(function: _Function) -> _Function:
    """Compile a function with numba: no Python objects, no GIL, IEEE division, cached on disk.

    No fastmath: costs are compared with infinity. With ``NUMBA_DISABLE_JIT=1`` the function is returned as it is.
    """
    compiled = _compiled(function)
    if not config.DISABLE_JIT:
        try:
            compiled._cache = _KernelCache(function)
        except OSError as error:  # no home folder, or sources that are no files
            _warn_uncached(str(error))
        compiled.compile = _interrupt_hold(_quick_compilation(compiled.compile))
    return cast(_Function, compiled)


def leaf(function: _Function) -> _Function:
    """Compile a small function that other kernels call in their innermost loops, always inlined into them.

    A train is a tuple of a dozen words: not passing it makes an arc 2.5 times as fast (28 → 12 ns) and carrying a
    costate back 1.7 times (71 → 41 ns). Not cached: its machine code is part of its callers'.
    """
    return cast(_Function, _compiled(function, forceinline=True))


def part(function: _Function) -> _Function:
    """Mark a step of a larger kernel, split off for the reader: compiled within its caller, never on its own.

    numba links and optimises the whole call tree of a kernel again for each of its callers, so a cold start pays for
    every level of the tree.
    """
    return cast(_Function, _compiled(function, inline="always"))
