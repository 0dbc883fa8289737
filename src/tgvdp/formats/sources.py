"""From what a user typed to a file: a name of the catalog, or a path, with the part of it behind a ``#``."""

import os
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.formats.syntax.reading import shown
from tgvdp.model import catalog

Source = str | os.PathLike[str]


class Target(NamedTuple):
    """A file, and which of several things in it is meant; None where that is not said."""

    path: Path
    part: str | None = None


def source_path(source: Source, kind: catalog.Kind | None = None, folder: Path | None = None) -> Path:
    """Find the file that a name of the catalog or a path means; see `locate`."""
    return locate(source, kind, folder).path


def locate(source: Source, kind: catalog.Kind | None = None, folder: Path | None = None) -> Target:
    """Find the file, and the part of it, that a name of the catalog or a path means.

    Text that is a name of the catalog means that one, so a file of the same name is reached as ``./name``. In
    ``FILE#PART`` the last ``#`` before which a file is named separates it from its part, unless there is a file of
    the whole name.

    Parameters
    ----------
    source : str or path
    kind : {"train", "track"}, optional
        What is looked for; either, when absent.
    folder : path, optional
        What relative paths are relative to; the working directory, when absent.

    Raises
    ------
    InputError
        When the text is neither a name of the catalog nor looks like a path, nor is a file.
    """
    kinds = catalog.KINDS if kind is None else (kind,)
    if isinstance(source, str):
        for one in kinds:
            if source in catalog.names(one):
                return Target(catalog.path(source, one))
    elif not isinstance(source, os.PathLike):
        raise InputError(f"expected the name of a {' or '.join(kinds)} or a path, got {shown(source)}")
    text = os.fspath(source)
    if not text:
        raise InputError(f"expected the name of a {' or '.join(kinds)} or a path, got an empty text")
    path, part = Path(folder or "", text), None
    if "#" in text and not _exists(path):
        cuts = [at for at, mark in enumerate(text) if mark == "#"][::-1]
        cut = next((at for at in cuts if _exists(Path(folder or "", text[:at]))), cuts[0])
        text, part = text[:cut], text[cut + 1 :]
        path = Path(folder or "", text)
    if isinstance(source, str) and not _looks_like_path(text) and not _exists(path):
        raise _unknown(text, kinds, part)
    return Target(path, part)


def label(path: Path) -> str:
    """Name a file for provenance: its path as given, or the name it has in the catalog."""
    for kind in catalog.KINDS:
        if path.stem in catalog.names(kind) and path == catalog.path(path.stem, kind):
            return f"catalog:{path.stem}"
    return str(path)


def _looks_like_path(text: str) -> bool:
    return any(mark in text for mark in (".", "/", os.sep, os.altsep or "/"))


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # too long, no permission, or a null byte
        return False


def _unknown(text: str, kinds: tuple[catalog.Kind, ...], part: str | None) -> InputError:
    what = " or ".join(kinds)
    for other in catalog.KINDS:
        if text in catalog.names(other):
            if other in kinds:
                return InputError(f"the built-in {other} {text!r} has no part {part!r}: it is one {other}")
            return InputError(f"{text!r} is a {other}, not a {what}")
    known = [name for kind in kinds for name in catalog.names(kind)]
    near = get_close_matches(text.lower(), known, n=1, cutoff=0.5)
    hint = f", did you mean {near[0]!r}?" if near else ""
    return InputError(f"unknown {what} {shown(text)}{hint} (built in: {', '.join(known)}; or give a file)")
