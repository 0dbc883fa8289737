"""A scenario: one search or journey of a sweep, and the key that it is known by wherever it runs."""

import functools
import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple

from tgvdp import __version__
from tgvdp.model.track import Track
from tgvdp.model.train import Train

Kind = Literal["search", "journey"]
_PACKAGE = Path(__file__).resolve().parents[1]
_DIGEST_LENGTH = 12
KEY_BYTES = 16
_ENCODER = json.JSONEncoder(sort_keys=True, default=asdict)


@dataclass(frozen=True, eq=False)
class Part:
    """A train or a line of a sweep, and where it comes from.

    Attributes
    ----------
    name : str
        As results name it; no other part of its kind in the sweep has it.
    value : Train or Track
    file, sha256 : str
        The file without its folder, with what was chosen in it, and the hash of its bytes; of what was built in
        memory no file and the hash of its values.
    remarks : tuple of str
        What the reader of the file noted.
    """

    name: str
    value: Any
    file: str = ""
    sha256: str = ""
    remarks: tuple[str, ...] = ()

    @functools.cached_property
    def digest(self) -> str:
        """SHA-256 of the values, hexadecimal: what decides the results, whatever file they come from."""
        return _digest(asdict(self.value))


class Section(NamedTuple):
    """A stretch of a line, m; the name is how results join."""

    name: str
    from_m: float
    to_m: float


def section_name(from_m: float, to_m: float) -> str:
    """Name of a stretch, wherever it comes from."""
    return f"{from_m:.12g}-{to_m:.12g}"


@dataclass(frozen=True, eq=False)
class Scenario:
    """One search or journey.

    Attributes
    ----------
    number : int
        Its place in the sweep, from 0.
    train, line : Part
    section : Section
    changes : tuple of str
        Fields of train and line that are set, as ``--set`` takes them.
    arguments : mapping
        Of `tgvdp.search` or `tgvdp.journey`, in SI.
    parameters : mapping
        What varies over the sweep, by the names of the spec: columns of the results.
    profiles_every_m : float or None
        Distance of the rows of its speed profiles, m; None: no profiles.
    """

    number: int
    train: Part
    line: Part
    section: Section
    kind: Kind = "search"
    changes: tuple[str, ...] = ()
    arguments: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    profiles_every_m: float | None = None

    def key(self, engine: str) -> bytes:
        """Hash of all that decides the result: canonical parameters, and the engine that solves it, (16,) bytes."""
        own = (self.kind, self.train.digest, self.line.digest, self.changes, dict(self.arguments))
        return bytes.fromhex(_digest((engine, *own, self.profiles_every_m)))[:KEY_BYTES]


class Task(NamedTuple):
    """What a worker needs of a scenario; tasks of one train and line share the objects."""

    id: int
    kind: Kind
    train: Train
    track: Track
    changes: tuple[str, ...]
    arguments: Mapping[str, Any]
    profiles_every_m: float | None


def task_of(scenario: Scenario, id: int) -> Task:
    """Make the task of a scenario, under a number of its own."""
    own = (scenario.kind, scenario.train.value, scenario.line.value, scenario.changes, dict(scenario.arguments))
    return Task(id, *own, scenario.profiles_every_m)


@functools.cache
def engine_version() -> str:
    """Version of tgvdp and digest of its sources and catalog: results of different engines are never mixed."""
    digest = hashlib.sha256()
    for path in sorted([*_PACKAGE.rglob("*.py"), *_PACKAGE.rglob("*.toml")]):
        digest.update(f"{path.relative_to(_PACKAGE).as_posix()}\0".encode() + path.read_bytes())
    return f"{__version__}+{digest.hexdigest()[:_DIGEST_LENGTH]}"


def _digest(content: Any) -> str:
    return hashlib.sha256(_ENCODER.encode(content).encode()).hexdigest()
