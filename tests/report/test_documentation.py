"""docs/results.md lists what is written, all of it and nothing else."""

import csv
import json
import re
from pathlib import Path

import pytest

from tgvdp.cli import main

PAGE = Path(__file__).resolve().parents[2] / "docs" / "results.md"
SHORT = ("--track", "flat-100km", "--to", "3km", "--quiet")
#: Groups whose entries differ from case to case, or are documented once for all.
OPEN = ("counters", "features", "options", "inputs", "files", "provenance", "balance", "ride", "distance_pct")


def documented(section):
    """Names in backticks in the first column of a section's table."""
    text = PAGE.read_text(encoding="utf-8").split(f"\n## {section}\n")[1].split("\n## ")[0]
    rows = [line for line in text.splitlines() if line.startswith("| `")]
    assert rows
    return {name for row in rows for name in re.findall(r"`([^`]+)`", row.split(" | ")[0])}


def paths(value, name="", *, closed=()):
    """Paths of all fields: ``a.b`` within objects, ``a[].b`` within lists of objects, ``a.*`` for open groups."""
    if isinstance(value, dict):
        for key, item in value.items():
            path = f"{name}.{key}" if name else key
            if key in OPEN and path not in closed:
                yield f"{path}.*"
            else:
                yield from paths(item, path, closed=closed)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for item in value:
            yield from paths(item, f"{name}[]", closed=closed)
    else:
        yield name


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Folders that together hold every field: a map that violates, a tariff, a front that ends early, a record."""
    home = tmp_path_factory.mktemp("documented")
    tariff = ("--price-per-kwh", "0.1", "--co2-g-per-kwh", "50")
    for name, arguments in {
        "wheel": ("search", *SHORT, "--points", "4", *tariff),
        "map": (
            "search",
            *SHORT,
            "--train",
            "alstom-emu",
            "--energy",
            "alstom-map",
            "--points",
            "4",
            "--max-margin",
            "1900",
        ),
        "course": ("search", *SHORT, "--points", "3", "--profiles", "railtoolkit", "--no-pictures"),
        "compare": ("compare", str(home / "wheel"), str(home / "map"), "--quiet"),
    }.items():
        assert main([*arguments, "--out", str(home / name)]) == 0
    (home / "run.csv").write_text("time_s,speed_mps\n" + "\n".join(f"{t},{min(t, 30, 130 - t)}" for t in range(131)))
    assert main(["score", str(home / "run.csv"), "--track", "flat-100km", "--quiet", "--out", str(home / "score")]) == 0
    return home


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def head(path):
    with path.open(newline="", encoding="utf-8") as file:
        return set(next(csv.reader(file)))


def test_result_json(written):
    closed = ("front[].balance", "front[].ride")
    contents = [read(written / name / "result.json") for name in ("wheel", "map")]
    assert {path for content in contents for path in paths(content, closed=closed)} == documented("result.json")


def test_tables(written):
    assert head(written / "wheel" / "front.csv") == documented("front.csv")
    assert head(written / "wheel" / "advice.csv") == documented("advice.csv")
    assert head(written / "wheel" / "profiles.csv") == documented("profiles.csv")
    assert head(written / "course" / "driving_course.csv") == documented("driving_course.csv")


def test_provenance(written):
    assert set(paths(read(written / "wheel" / "provenance.json"))) == documented("provenance.json")


def test_compare_and_score(written):
    assert set(paths(read(written / "compare" / "compare.json"))) == documented("compare.json")
    rows = {name.removeprefix("rows[].") for name in documented("compare.json") if name.startswith("rows[].")}
    assert head(written / "compare" / "compare.csv") == rows
    assert set(paths(read(written / "score" / "score.json"))) == documented("score.json")


def test_files(written):
    text = PAGE.read_text(encoding="utf-8").split("\n## ")[0]
    files = {name for row in text.splitlines() if row.startswith("| `") for name in re.findall(r"^\| `([^`]+)`", row)}
    assert {path.name for path in (written / "wheel").iterdir()} == files
