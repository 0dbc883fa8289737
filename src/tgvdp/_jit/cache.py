"""The cache of compiled kernels.

numba's own ``cache=True`` has two faults that hurt a package of many modules: it keeps a stale kernel when a kernel
that it calls changes in another module, and a truncated cache file crashes the import. So the kernels of tgvdp live
in a folder of their own, named by everything that decides what they compile to: the SHA-256 of the sources of all
rooms that can matter to a kernel, the versions of Python, numba and numpy, the steps of compilation, and the switches
of numba that change the code. Each entry carries its own digest; what cannot be read or does not match is deleted and
compiled again. Where nothing can be written, one warning says so and compilation goes on without a cache; what is
there is used, so that a filled folder may be read-only. The key folder has mode 0700, and one that another user (but
root) owns or others can write is not read: its entries are pickles and machine code.

The folder is ``$TGVDP_CACHE_DIR``, else the user's cache folder of the platform. Deleting it is always safe, also
under a running program.
"""

import contextlib
import functools
import hashlib
import os
import pickle
import shutil
import stat
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator
from numba.core.runtime import rtsys
from numba.core.serialize import dumps

from tgvdp._jit.steps import shortened

PACKAGE = Path(__file__).resolve().parents[1]
CACHE_DIR_VARIABLE = "TGVDP_CACHE_DIR"
#: Key folders that are kept, by last use: editions and modes (bounds checks) that take turns do not evict each other.
KEPT_FOLDERS = 8
#: Rooms that no kernel lives in or imports (a test sees to it): their changes leave the kernels as they are.
KERNEL_FREE = (
    *("api", "cli", "explorer", "formats", "formulations", "instances", "journeys", "options", "report"),
    *("sweeps", "trials", "verification"),
    *("solvers/circuit", "solvers/programs", "solvers/samplers"),
)
_KEY_LENGTH = 32
#: Switches of numba that change the machine code but are no part of its own cache key.
_MODES = ("BOUNDSCHECK", "OPT", "DEBUGINFO_DEFAULT", "LOOP_VECTORIZE", "SLP_VECTORIZE")


def sources_digest(folder: Path) -> str:
    """SHA-256, in hexadecimal, of the names and contents of the ``*.py`` files below a folder that kernels may use."""
    digest = hashlib.sha256()
    for parent, folders, names in os.walk(folder):
        room = Path(parent).relative_to(folder)
        folders[:] = sorted(
            name for name in folders if name != "__pycache__" and (room / name).as_posix() not in KERNEL_FREE
        )
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
    versions = (sys.implementation.cache_tag, numba.__version__, np.__version__)
    parts = (sources_digest(package), *versions, modes, shortened())
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
def key_folder() -> Path:
    """Folder of the kernels of these sources, absent or safe to load from.

    Raises
    ------
    OSError
        When there is no place for it, or others could have written into it.
    """
    folder = cache_root() / cache_key(PACKAGE)
    _require_private(folder)
    with contextlib.suppress(OSError):  # absent or read-only: only the order of clearing up depends on it
        os.utime(folder)
    return folder


def _require_private(folder: Path) -> None:
    """Refuse a folder that somebody else owns or can write: what lies there is executed.

    The folders above need no look: whoever can put another one in its place owns that.
    """
    if not hasattr(os, "geteuid"):
        return
    with contextlib.suppress(FileNotFoundError, NotADirectoryError):
        status = folder.stat()
        if status.st_uid not in (os.geteuid(), 0):
            raise OSError(f"{folder} belongs to another user")
        if status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            raise OSError(f"{folder} can be written by others")


@functools.cache
def make_folder() -> Path:
    """Make `key_folder` where it is absent; raises `OSError`, too, when it cannot be made."""
    folder = key_folder()
    if not folder.is_dir():
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)  # private: what lies here is executed
        remove_old_folders(folder.parent)
    return folder


@functools.cache
def warn_uncached(reason: str) -> None:
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
        make_folder()
        super().ensure_cache_path()

    def get_cache_path(self) -> str:
        # Relative to the package, so that two installations of the same sources share their kernels.
        place = os.path.relpath(os.path.dirname(self._py_file), PACKAGE)
        return str(key_folder() / hashlib.sha256(place.encode()).hexdigest()[:16])

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
        # It counts references, and without numba's runtime it would call address 0. Kernels may, after an allocating
        # one in the same process: numba compiles what both need, such as the texts of errors, once, for the first.
        if b"NRT_" in content:
            rtsys.initialize(target_context)
        return super().rebuild(target_context, pickle.loads(content))


class KernelCache(FunctionCache):
    """The cache of one kernel: never the reason why a program fails."""

    _impl_class = _CheckedImpl
    #: Where another process fills it: waits until that is done.
    wait_for_it: Callable[[], object] | None = None

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self._waiting = threading.RLock()

    def await_others(self) -> None:
        """Wait until another process has filled it, if one is to: all threads that come meanwhile do."""
        with self._waiting:
            wait, self.wait_for_it = self.wait_for_it, None
            if wait is not None:
                wait()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        # A damaged pickle may raise anything at all. None makes the dispatcher compile and save afresh. The public
        # method first loads all that numba could compile, linear algebra and all: machine code needs none of it.
        try:
            return self._load_overload(sig, target_context)
        except Exception:
            self._wipe()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except OSError as error:
            self.disable()
            warn_uncached(f"{cache_root()}: {error.strerror or error}")

    def is_filled(self) -> bool:
        """Whether there are files of this kernel: for guesses, since they may be damaged."""
        return any(self._files())

    def _files(self) -> Iterator[Path]:
        return Path(self.cache_path).glob(f"{self._impl.filename_base}.*")

    def _wipe(self) -> None:
        with contextlib.suppress(OSError):  # what cannot be deleted cannot be replaced either: saving will say so
            for path in self._files():
                path.unlink(missing_ok=True)
