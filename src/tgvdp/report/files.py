"""Files that are either whole or absent."""

import contextlib
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from tgvdp.errors import InputError

_DRAFT = ".tmp"
#: As commands that can write to it call it.
_STDOUT = "-"


def check_writable(folder: str | os.PathLike[str]) -> None:
    """Find out before a long run whether results can be written into a folder; leaves no trace.

    Raises
    ------
    InputError
        When the folder, or the nearest folder above it that exists, cannot be written, or it has no name, or that of
        stdout, or it is no path.
    """
    if not isinstance(folder, str | os.PathLike):
        raise InputError(f"a folder for results must be a path, got {folder!r:.60}")
    if not os.fspath(folder):
        raise InputError("a folder for results must have a name, got an empty text")
    if os.fspath(folder) == _STDOUT:
        raise InputError(f"a folder for results cannot be stdout, got {_STDOUT!r} (a folder of that name is ./-)")
    path = Path(folder).absolute()
    existing = next(candidate for candidate in (path, *path.parents) if os.path.lexists(candidate))
    if not existing.is_dir():
        raise InputError(f"{folder}: cannot be written: {existing} is not a folder")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InputError(f"{folder}: cannot be written: no permission in {existing}")


def check_new(path: str | os.PathLike[str], *, force: bool) -> None:
    """Refuse to overwrite a file, unless that is asked for; a device or a pipe loses nothing.

    Raises
    ------
    InputError
        When there is a file, or a link to one; or a folder; or where the name is that of stdout, or the folder that it
        is to be in is not there.
    """
    if not os.fspath(path):
        raise InputError("a file to write must have a name, got an empty text")
    if os.fspath(path) == _STDOUT:
        raise InputError(f"this is not written to stdout, got {_STDOUT!r} (a file of that name is ./-)")
    if Path(path).is_dir():
        raise InputError(f"{path}: is a folder, not a file")
    if not force and os.path.lexists(path) and not _is_stream(Path(path)):
        raise InputError(f"{path}: exists already (--force overwrites it)")
    if not Path(path).parent.is_dir():
        raise InputError(f"{path}: there is no folder {Path(path).parent}")


def require_folder(path: str | os.PathLike[str]) -> None:
    """Raise `InputError` unless there is a folder."""
    if not os.path.isdir(path):
        raise InputError(f"{path}: {'is a file, not a folder' if os.path.lexists(path) else 'no such folder'}")


def _is_stream(path: Path) -> bool:
    """Whether what is written there goes on to somebody: a device, a pipe."""
    return path.exists() and not path.is_file() and not path.is_dir()


def is_draft(name: str) -> bool:
    """Whether a file is what a process that was killed had begun to write."""
    return name.startswith(".") and name.endswith(_DRAFT)


@contextlib.contextmanager
def made_folder(folder: Path) -> Iterator[None]:
    """Make a folder, and those above it; where what is done inside fails, those that it leaves empty go again."""
    absent = [one for one in (folder, *folder.parents) if not os.path.lexists(one)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for one in absent:
            with contextlib.suppress(OSError):  # it was not made, or something is in it
                one.rmdir()
        raise


def write_files(folder: str | os.PathLike[str], contents: Mapping[str, bytes]) -> list[Path]:
    """Write files into a folder, which is made when absent, each by an atomic replacement.

    All are written beside their destination before the first one is replaced, so that a full disk or an interruption
    leaves the folder as it was, or absent. A link stays one, and so does a device or a pipe, into which is written.

    Parameters
    ----------
    folder : path
    contents : mapping of file name to bytes

    Returns
    -------
    list of Path

    Raises
    ------
    InputError
        When the folder or a file cannot be written.
    """
    home = Path(folder)
    targets = [home / name for name in contents]
    files = dict(zip(targets, contents.values(), strict=True))
    streams = {target: files.pop(target) for target in targets if _is_stream(target)}
    places = [Path(os.path.realpath(target)) if target.is_symlink() else target for target in files]
    drafts = [place.with_name(f".{place.name}.{os.getpid()}{_DRAFT}") for place in places]
    try:
        with made_folder(home):
            _write(files, streams, dict(zip(drafts, places, strict=True)))
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror or error}") from error
    return targets


def _write(files: Mapping[Path, bytes], streams: Mapping[Path, bytes], drafts: Mapping[Path, Path]) -> None:
    """Write files by way of drafts, each with its place, and into streams."""
    try:
        for draft, content in zip(drafts, files.values(), strict=True):
            draft.write_bytes(content)
        for stream, content in streams.items():
            stream.write_bytes(content)
        for draft, place in drafts.items():
            os.replace(draft, place)
    finally:
        _remove(drafts)


def _remove(drafts: Iterable[Path]) -> None:
    """Remove what an error left behind; a folder that is out of reach holds no drafts."""
    for draft in drafts:
        try:
            draft.unlink()
        except OSError:
            continue
