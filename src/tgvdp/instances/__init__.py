"""The published instances of the formulations, as JSON files beside this module, and what is known about them.

106 problems of N = 4..200 steps in twelve families, made by ``python -m benchmarks.library``, the same every time.
``optima.csv`` lists the certified optimum of each (where none is proved, the best known objective and a bound), the
number of optimal schedules, the closed form where one is known, and what proved and confirmed them;
docs/quantum-benchmark.md explains families and columns. This room knows names and files only;
`tgvdp.formulations.problem.reading` reads them like any other file.
"""

import csv
import os
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path

from tgvdp.errors import InputError

FOLDER = Path(str(files(__package__)))
#: Name of the index of a library of instances, in their folder.
INDEX = "optima.csv"
#: Standalone judge of solutions.
CHECKER = FOLDER / "check.py"


def index() -> dict[str, dict[str, str]]:
    """Rows of the index by the instance's name, in its order: by family and size."""
    with (FOLDER / INDEX).open(encoding="utf-8", newline="") as file:
        return {row["id"]: row for row in csv.DictReader(file)}


def find(source: str | os.PathLike[str]) -> Path:
    """Find the file that the name of a published instance, or a path, means.

    Text that is a name means that instance, so a file of the same name is reached as ``./name``.

    Raises
    ------
    InputError
        When the text is neither a name nor looks like a path, nor is a file.
    """
    text = os.fspath(source)
    names = tuple(index())
    if text in names:
        return FOLDER / f"{text}.json"
    path = Path(text)
    if any(mark in text for mark in (".", "/", os.sep)) or (text and path.exists()):
        return path
    near = get_close_matches(text.lower(), names, n=3, cutoff=0.6)
    hint = f", did you mean {' or '.join(map(repr, near))}?" if near else ""
    raise InputError(
        f"unknown instance {text!r:.60}{hint} ({len(names)} are built in: tgvdp catalog lists them; or give a file)"
    )
