"""Single fields of a train or line, set by their names in the native format: ``train.mass_t=450``.

The train or line is written as native tables, the field is put there, and the tables are read back: names, units,
ranges and errors are those of the format.
"""

import copy
import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from msgspec import Struct, structs

from tgvdp.errors import InputError
from tgvdp.formats.detect import read_scenario
from tgvdp.formats.native.specs import TrackSpec, TrainSpec
from tgvdp.formats.native.write import native_tree
from tgvdp.formats.scenario import Scenario, fingerprint_beside
from tgvdp.formats.syntax.reading import Document, errors_named, shown
from tgvdp.formats.syntax.typed import suggestion
from tgvdp.model.track import Track
from tgvdp.model.train import Train

_SPECS: dict[str, type[Struct]] = {"train": TrainSpec, "track": TrackSpec}
_STEP = re.compile(r"(\w+)((?:\[\d+\])*)")
_SHARE = re.compile(r"(\d+(?:\.\d*)?|\.\d+)\s*%")
#: Stands for the path of a file in errors.
_OWNER = Path("--set")


def fields() -> list[str]:
    """Fields of a train and a line, without those deeper inside."""
    return [f"{part}.{field}" for part in _SPECS for field in _fields_of(part)]


@cache
def _fields_of(part: str) -> list[str]:
    return [field.encode_name for field in structs.fields(_SPECS[part])]


class Changed(NamedTuple):
    """Train and track with fields set.

    Attributes
    ----------
    train : Train
    track : Track
    settled : tuple of str
        The assignments, those that name a file by what it holds: they need it no more.
    inputs : mapping of str to str
        SHA-256 of files that were read, by path.
    remarks : tuple of str
        Notes on these.
    """

    train: Train
    track: Track
    settled: tuple[str, ...]
    inputs: Mapping[str, str]
    remarks: tuple[str, ...]

    @property
    def fingerprint(self) -> dict[str, Any]:
        """The files and the notes, as `tgvdp.formats.scenario.Read` gives them; empty where no file was read."""
        return fingerprint_beside(self.inputs, self.remarks) if self.inputs else {}


class _Assignment(NamedTuple):
    """A value and the steps to the field that gets it, as it is written."""

    text: str
    steps: list[str | int]
    value: Any

    @property
    def part(self) -> str:
        return str(self.steps[0])

    def settled(self, parts: Mapping[str, Train | Track]) -> str:
        """The assignment by what came of it, an effort curve, where it names a file."""
        if self.steps[-1] != "file" and not (isinstance(self.value, dict) and "file" in self.value):
            return self.text
        field = str(self.steps[1])
        return f"{self.part}.{field}={written(_tree_of(self.part, parts[self.part])[self.part][field])}"


def changed(train: Train, track: Track, assignments: Sequence[str], owner: Path = _OWNER) -> Changed:
    """Return train and track with fields set, each as ``train.FIELD=VALUE`` or ``track.FIELD=VALUE``.

    A field may lie deeper (``train.traction.force_kn``) or in a row (``track.speed_limits[2].speed_kmh``); a value is
    written as in TOML, and what TOML cannot read is text; ``train.mass_t=110%`` is a share of the number that is there.

    Parameters
    ----------
    train : Train
    track : Track
    assignments : sequence of str
    owner : Path
        What errors name, and beside which files are looked for.

    Raises
    ------
    InputError
        When there is no such field, or the value is wrong there.
    """
    parts: dict[str, Any] = {"train": train, "track": track}
    inputs: dict[str, str] = {}
    remarks: list[str] = []
    with errors_named(owner):
        parsed = list(map(_parsed, assignments))
        for part in dict.fromkeys(one.part for one in parsed):
            tree = _tree_of(part, parts[part])
            for one in parsed:
                tree = _with(tree, one.steps, one.value) if one.part == part else tree
            scenario = read_scenario(Document(owner, "", "TOML", tree, b""))
            parts[part] = getattr(scenario, part)
            inputs |= {path: digest for path, digest in scenario.inputs.items() if digest}
            remarks += scenario.remarks.get(part, ())
    settled = tuple(one.settled(parts) for one in parsed)
    return Changed(parts["train"], parts["track"], settled, inputs, tuple(remarks))


def written(value: Any) -> str:
    """Return a value as ``--set`` takes it."""
    return value if isinstance(value, str) else _toml(value)


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return f"{{{', '.join(f'{name} = {_toml(one)}' for name, one in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return str(value).lower() if isinstance(value, bool) else str(value)


@lru_cache(maxsize=4)
def _tree_of(part: str, held: Train | Track) -> dict[str, Any]:
    """Native tables of a train or a line, which a sweep changes time and again; not to be written to."""
    parts: dict[str, Any] = {part: held}
    return native_tree(Scenario(name=held.name, format="native", **parts))


def _parsed(assignment: str) -> _Assignment:
    place, equals, text = assignment.partition("=")
    matches = [_STEP.fullmatch(step) for step in place.strip().split(".")]
    if not equals or len(matches) < 2 or not all(matches):
        raise InputError(f"must be train.FIELD=VALUE or track.FIELD=VALUE, got {shown(assignment)}")
    steps: list[str | int] = []
    for match in filter(None, matches):
        steps += [match[1], *(int(index) for index in re.findall(r"\d+", match[2]))]
    part, name = str(steps[0]), str(steps[1])
    if part not in _SPECS:
        raise InputError(f"{part}: must be train or track, got {shown(part)}{suggestion(part, list(_SPECS))}")
    known = _fields_of(part)
    if name not in known:
        raise InputError(
            f"{part}.{name}: unknown field {shown(name)}{suggestion(name, known)} (known: {', '.join(known)})"
        )
    return _Assignment(assignment, steps, _value(text.strip()))


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _share_of(held: Any, value: Any, at: str) -> Any:
    """A value; with % a share of the number that is there."""
    match = _SHARE.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        return value
    if isinstance(held, bool) or not isinstance(held, int | float):
        raise InputError(f"{at}: there is no number of which {value} could be taken")
    return held * float(match[1]) / 100.0


def _with(tree: Any, steps: Sequence[str | int], value: Any, at: str = "") -> Any:
    """The tree with a field set, all else shared; tables on the way are made where they are absent, rows are not."""
    step, *below = steps
    kind: Any = list if isinstance(step, int) else dict
    if not isinstance(tree, kind):
        raise InputError(f"{at}: holds no {'rows' if isinstance(step, int) else 'fields'}")
    if isinstance(step, int) and step >= len(tree):
        raise InputError(f"{at}: has rows [0] to [{len(tree) - 1}], got [{step}]")
    here = f"{at}[{step}]" if isinstance(step, int) else f"{at}.{step}".lstrip(".")
    held = tree[step] if isinstance(step, int) else tree.get(step)
    changed = copy.copy(tree)
    if below:
        changed[step] = _with({} if held is None else held, below, value, here)
    else:
        changed[step] = _share_of(held, value, here)
    return changed
