"""Trains, lines and energy maps that come with tgvdp, as data files beside this module.

The catalog knows names and files only; `tgvdp.formats` reads them like any other file.
"""

import functools
from importlib.resources import files
from pathlib import Path
from typing import Literal, get_args

from tgvdp.errors import InputError

Kind = Literal["train", "track", "map"]
KINDS: tuple[Kind, ...] = get_args(Kind)

_SUFFIX = ".toml"


@functools.cache
def names(kind: Kind) -> tuple[str, ...]:
    """Names of the built-in trains, tracks or maps, in alphabetical order."""
    return tuple(sorted(file.stem for file in _folder(kind).iterdir() if file.suffix == _SUFFIX))


def path(name: str, kind: Kind) -> Path:
    """File of a built-in train, track or map.

    Raises
    ------
    InputError
        When there is none of that name.
    """
    if name not in names(kind):
        raise InputError(f"unknown {kind} {name!r:.60}; built in: {', '.join(names(kind))}")
    return _folder(kind) / f"{name}{_SUFFIX}"


def _folder(kind: Kind) -> Path:
    return Path(str(files(__package__) / f"{kind}s"))
