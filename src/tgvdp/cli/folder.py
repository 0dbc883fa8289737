"""The folder that a search writes into: nobody else's files are overwritten, and no file of an earlier search stays."""

import hashlib
import json
import os
from pathlib import Path

from tgvdp.errors import InputError

#: The file that says which files of a folder a search wrote, and its schema.
_LEDGER = "provenance.json"
_SCHEMA = "tgvdp.provenance/"


class OutFolder:
    """A folder for results.

    Parameters
    ----------
    path : str
    force : bool
        Whether files in it may be overwritten that no search wrote.

    Raises
    ------
    InputError
        When it cannot be written, or holds what no search wrote.
    """

    def __init__(self, path: str, *, force: bool) -> None:
        from tgvdp.report import check_writable

        check_writable(path)
        self._path = Path(path)
        self._earlier = _written_before(self._path)
        if self._earlier is None and not force and self._path.is_dir() and any(self._path.iterdir()):
            raise InputError(f"{path}: is not empty, and no results of tgvdp are in it (--force writes there)")

    def drop_earlier(self, kept: list[Path]) -> None:
        """Remove what the search before wrote and this one did not, where it is still as it was written."""
        names = {file.name for file in kept}
        for name, digest in (self._earlier or {}).items():
            file = self._path / name
            if name not in names and file.is_file() and hashlib.sha256(file.read_bytes()).hexdigest() == digest:
                os.unlink(file)


def _written_before(folder: Path) -> dict[str, str] | None:
    """Files that an earlier search wrote, with their SHA-256; None where none did."""
    try:
        ledger = json.loads((folder / _LEDGER).read_bytes())
        if not str(ledger["schema"]).startswith(_SCHEMA):
            return None
        return {Path(name).name: str(digest) for name, digest in ledger["files"].items()}
    except (OSError, ValueError, TypeError, KeyError, AttributeError):  # absent, or somebody else's
        return None
