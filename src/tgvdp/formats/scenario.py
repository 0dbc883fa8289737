"""What was read from a file, with what it was made of."""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from tgvdp.model.energy import EnergyMap
from tgvdp.model.journey import Journey
from tgvdp.model.track import Track
from tgvdp.model.train import Train


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """What a file holds, references resolved.

    Attributes
    ----------
    name : str
    format : str
        "native", "TTOBench", "railtoolkit", "OSRD", "OSRD path", "CSV table", "Excel table", "SFERA", or "railML" with
        its version.
    train : Train or None
    track : Track or None
    map : EnergyMap or None
    journey : Journey or None
    options : dict
        Search options by their names on the command line, with ``_`` for ``-`` and the unit at the end (``from_m``,
        ``start_speed_kmh``, ``max_margin_pct``, ...); those that the file does not give are absent.
    kept : dict
        By kind: fields of a TTOBench file that no run uses, as they stand there, for a file that is written again.
    inputs : dict
        SHA-256 of every file that was read, by its path or as ``catalog:name``.
    remarks : dict
        By kind: what the readers of foreign files and tables noted, each begun with the file's name.
    outline : dict
        Of a file that is nothing without another one: what it holds, by name.
    """

    name: str
    format: str
    train: Train | None = None
    track: Track | None = None
    map: EnergyMap | None = None
    journey: Journey | None = None
    options: dict[str, Any] = field(default_factory=dict)
    kept: dict[str, Mapping[str, Any]] = field(default_factory=dict)
    inputs: dict[str, str] = field(default_factory=dict)
    remarks: dict[str, tuple[str, ...]] = field(default_factory=dict)
    outline: Mapping[str, str] = field(default_factory=dict)


def fingerprint_beside(files: Mapping[str, str], remarks: Sequence[str]) -> dict[str, Any]:
    """What provenance says of files that others refer to.

    Parameters
    ----------
    files : mapping of str to str
        SHA-256 by path. Provenance names no folders but those that tell files of one name apart.
    remarks : sequence of str
        What readers noted.

    Returns
    -------
    dict
        ``beside`` and ``notes``, where there are any.
    """
    at = {Path(os.path.abspath(path)).parts: digest for path, digest in files.items()}
    beside = {"beside": {_tail(parts, at): digest for parts, digest in at.items()}} if files else {}
    return beside | ({"notes": list(remarks)} if remarks else {})


def _tail(path: tuple[str, ...], others: Iterable[tuple[str, ...]]) -> str:
    """The end of a path, as short as it can be and be that of no other one."""
    length = next(n for n in range(1, len(path) + 1) if sum(path[-n:] == other[-n:] for other in others) == 1)
    return "/".join(path[-length:])


class Read(NamedTuple):
    """What was read from a file: a train, a track, a map, a journey or a whole scenario, and the bytes it was made of.

    ``part`` is what was chosen in the file, ``sha256`` that of its bytes, in hexadecimal, ``remarks`` what readers
    noted and ``format`` what it is, as in `Scenario`, ``beside`` the SHA-256 of other files that it refers to, by
    their paths. ``section`` is the part where it chooses no journey of the file: a run from stop to stop.
    """

    value: Any
    path: Path
    part: str | None
    sha256: str
    remarks: tuple[str, ...]
    format: str
    beside: Mapping[str, str] = MappingProxyType({})
    section: str | None = None

    @property
    def fingerprint(self) -> dict[str, Any]:
        """The file without its folder, what was chosen in it, the hash of what was read, and what the reader noted."""
        chosen = {} if self.part is None else {"part": self.part}
        others = fingerprint_beside(self.beside, self.remarks)
        return {"file": self.path.name, **chosen, "sha256": self.sha256, **others}
