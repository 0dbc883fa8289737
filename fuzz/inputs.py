"""The files that are changed: those of the catalog, small ones of the tests, and those of others where they are."""

import itertools
import json
import re
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import tomli_w

from tests.helpers import format_case, osrd_case, railml_case, railtoolkit_case, sfera_case
from tests.helpers.settings import SHARED
from tgvdp.formats.syntax.yaml import parse_yaml
from tgvdp.instances import find, index
from tgvdp.model import catalog

ROOT = Path(__file__).resolve().parents[1]
#: A number as a text, and one that is an attribute of XML or a cell of a table.
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
_NUMBER_ALONE = re.compile(rf'(?<=[",;\n]){_NUMBER.pattern}(?=["\s,;])')

#: Instances that are changed have so many steps at most.
_MOST_STEPS = 8
#: A run of two minutes and a half, recorded every two seconds.
_SPEED_KMH = [*range(0, 100, 4), *([100] * 25), *range(100, -1, -4)]

Place = tuple[str | int, ...]


class Original(NamedTuple):
    """A file that loads.

    Attributes
    ----------
    name : str
    kind : {"train", "track", "map", "scenario", "instance", "run", "result"}
    tree : object
        Tables, lists and values; a list of pieces of text, every second one a number, for XML and tables.
    write : callable
        Makes the file of such a tree.
    """

    name: str
    kind: str
    tree: Any
    write: Callable[[Any], str]


def originals() -> list[Original]:
    """All files, in the same order every time."""
    return [*_catalog(), *_small(), *_published()]


def of_other_commands() -> list[Original]:
    """Files that no search reads: instances of the formulations, a recorded run, a result."""
    instances = [name for name, row in index().items() if int(row["N"]) <= _MOST_STEPS]
    found = [
        Original(f"{name}.json", "instance", json.loads(find(name).read_bytes()), json.dumps) for name in instances
    ]
    rows = "".join(f"{2.0 * step:.1f},{_SPEED_KMH[step]:.1f}\n" for step in range(len(_SPEED_KMH)))
    found.append(Original("run.csv", "run", pieces(f"time_s,speed_kmh\n{rows}"), "".join))
    result = json.loads((ROOT / "results" / "example" / "result.json").read_bytes())
    return [*found, Original("result.json", "result", result, json.dumps)]


def _catalog() -> Iterator[Original]:
    for kind in catalog.KINDS:
        for name in catalog.names(kind):
            text = catalog.path(name, kind).read_text(encoding="utf-8")
            yield Original(f"{name}.toml", kind, tomllib.loads(text), tomli_w.dumps)


def _small() -> Iterator[Original]:
    yield Original("toy-train.json", "train", format_case.TTOBENCH_TRAIN_14, json.dumps)
    yield Original("toy-track.json", "track", format_case.TTOBENCH_TRACK, json.dumps)
    yield Original("toy.toml", "scenario", tomllib.loads(format_case.SCENARIO), tomli_w.dumps)
    yield Original("toy-stock.yaml", "train", railtoolkit_case.ROLLING_STOCK, json.dumps)
    yield Original("toy-paths.yaml", "track", railtoolkit_case.PATHS, json.dumps)
    yield Original("osrd-train.json", "train", osrd_case.OSRD_TRAIN, json.dumps)
    yield Original("osrd-path.json", "track", osrd_case.OSRD_PATH, json.dumps)
    for name, text in railml_case.SAMPLES.items():
        yield Original(f"{name}.xml", "track" if "line" in name else "train", pieces(text), "".join)
    yield Original("sfera.xml", "track", pieces(sfera_case.message()), "".join)


def _published() -> Iterator[Original]:
    folders = {"ttobench/trains": "train", "ttobench/tracks": "track", "osrd": "train",
               "railtoolkit/trains": "train", "railtoolkit/paths": "track"}  # fmt: skip
    for folder, kind in folders.items():
        for path in sorted((SHARED / folder).glob("*.[jy][sa][om][nl]")):
            text = path.read_text(encoding="utf-8")
            tree = json.loads(text) if path.suffix == ".json" else parse_yaml(text)[0]
            yield Original(path.name, kind, tree, json.dumps)


def pieces(text: str) -> list[str]:
    """A text cut before and after each number in it, so that every second piece is one."""
    cuts = [0, *(end for match in _NUMBER_ALONE.finditer(text) for end in match.span()), len(text)]
    return [text[start:end] for start, end in itertools.pairwise(cuts)]


def leaves(tree: Any, at: Place = ()) -> Iterator[tuple[Place, Any]]:
    """Every value of a tree with its place."""
    if not isinstance(tree, dict | list):
        yield at, tree
        return
    for step, child in tree.items() if isinstance(tree, dict) else enumerate(tree):
        yield from leaves(child, (*at, step))


def number_of(value: Any) -> float | None:
    """A value as a number; None where it is none."""
    if isinstance(value, bool):
        return None
    if isinstance(value, int | float):
        return float(value)
    if isinstance(value, str) and _NUMBER.fullmatch(value):
        return float(value)
    return None


def with_number(value: Any, number: float) -> Any:
    """A number in the shape of the value that it stands for."""
    return f"{number:.12g}" if isinstance(value, str) else number


def with_value(tree: Any, place: Place, change: Callable[[Any, str | int], None]) -> Any:
    """Copy a tree along one place only, where a function changes the table or list that holds it."""
    copy = dict(tree) if isinstance(tree, dict) else list(tree)
    if len(place) == 1:
        change(copy, place[0])
    else:
        copy[place[0]] = with_value(copy[place[0]], place[1:], change)
    return copy
