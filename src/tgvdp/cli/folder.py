"""The folder that a command writes into: nobody else's files are overwritten, and no file of an earlier run stays."""

import contextlib
import hashlib
import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path, PurePosixPath

from tgvdp.errors import InputError

#: The file that says which files of a folder a command wrote, and its schema.
_LEDGER = "provenance.json"
_SCHEMA = "tgvdp.provenance/"
#: Which command that was tells the first of these files that is among them.
_MAIN = {
    "journey.json": "tgvdp journey",
    "result.json": "tgvdp search",
    "score.json": "tgvdp score",
    "compare.json": "tgvdp compare",
}


class OutFolder:
    """A folder for results.

    Parameters
    ----------
    path : str
    main : str
        The file that tells the results of this command from those of others.
    force : bool
        Whether files in it may be overwritten that this command did not write.
    parts : sequence of str
        Folders in it that have results of their own, which may be there without those of all of them: the run before
        ended between two.

    Raises
    ------
    InputError
        When it cannot be written, or holds what this command did not write.
    """

    def __init__(self, path: str, main: str, *, force: bool, parts: Sequence[str] = ()) -> None:
        from tgvdp.report import check_writable
        from tgvdp.report.files import is_draft

        check_writable(path)
        self._path = Path(path)
        self._earlier = _written_before(self._path)
        if force:
            return
        if self._earlier is None:
            others = [file for file in self._path.iterdir() if not is_draft(file.name)] if self._path.is_dir() else []
            if not all(file.name in parts and _written_before(file) is not None for file in others):
                raise InputError(
                    f"{self._path}: is not empty, and no results of tgvdp are in it (--force writes there)"
                )
            return
        names = {PurePosixPath(name).name for name in self._earlier}
        owner = next((name for name in _MAIN if name in names), main)
        if owner != main:
            raise InputError(f"{path}: holds results of {_MAIN[owner]}, which would be lost (--force writes there)")

    def drop_earlier(self, kept: Iterable[Path]) -> None:
        """Remove what the run before wrote and this one did not, where it is still as it was written."""
        names = {file.relative_to(self._path).as_posix() for file in kept}
        for name, digest in (self._earlier or {}).items():
            file = self._path / name
            if name not in names and file.is_file() and hashlib.sha256(file.read_bytes()).hexdigest() == digest:
                os.unlink(file)
                if file.parent != self._path:
                    with contextlib.suppress(OSError):  # not empty
                        file.parent.rmdir()


def _written_before(folder: Path) -> dict[str, str] | None:
    """Files that an earlier run wrote, by their paths in the folder, with their SHA-256; None where none did."""
    try:
        ledger = json.loads((folder / _LEDGER).read_bytes())
        if not str(ledger["schema"]).startswith(_SCHEMA):
            return None
        return {name: str(digest) for name, digest in ledger["files"].items() if _is_inside(PurePosixPath(name))}
    except (OSError, ValueError, TypeError, KeyError, AttributeError):  # absent, or somebody else's
        return None


def _is_inside(path: PurePosixPath) -> bool:
    return not path.is_absolute() and ".." not in path.parts
