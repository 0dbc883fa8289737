"""From a folder that ``tgvdp search``, ``journey`` or ``bench`` wrote to what the page shows."""

import csv
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from tgvdp.errors import InputError
from tgvdp.explorer.exhibit import PROFILE_COLUMNS, Exhibit, search_exhibit
from tgvdp.report.files import require_folder
from tgvdp.report.journeys import SCHEMA as JOURNEY_SCHEMA
from tgvdp.report.tables import SCHEMA as SEARCH_SCHEMA
from tgvdp.report.written import read_object, require_schema
from tgvdp.runs.profile import REGIMES

#: Columns of a benchmark that the page shows, by table.
_BENCH_COLUMNS = {
    "ensembles.csv": (
        "family", "N", "solver", "instances", "solved", "p median", "p least", "p most", "TTS99 s", "TTS99 s low",
        "TTS99 s high",
    ),
    "benchmark.csv": ("Problem", "N", "encoding", "# Decision Variables", "# Non-Zero Coefficients"),
    "embeddings.csv": ("N", "encoding", "topology", "qubits"),
}  # fmt: skip


def read_folder(folder: str) -> Exhibit:
    """Read what a command wrote.

    Parameters
    ----------
    folder : path

    Raises
    ------
    InputError
        When there is no result, or one of another version, or one that misses what the page shows.
    """
    home = Path(folder)
    for name, read in _READERS.items():
        if (home / name).is_file():
            return read(home, read_object(home / name))
    require_folder(folder)
    raise InputError(f"{folder}: holds none of {', '.join(_READERS)}, which search, journey and bench write")


def read_search(folder: str) -> tuple[dict[str, Any], dict[str, dict[str, Any]]] | None:
    """Read result.json, and the columns of profiles.csv by the id of the run; None where no search wrote."""
    home = Path(folder)
    if not (home / "result.json").is_file():
        return None
    return _checked(home, read_object(home / "result.json")), _profiles(home)


def _checked(home: Path, content: dict[str, Any]) -> dict[str, Any]:
    path = home / "result.json"
    _require(path, content, SEARCH_SCHEMA, ("trip", "front", "fastest", "line", "energy", "tariff", "provenance"))
    if not content["front"]:
        raise InputError(f"{path}: front holds no point")
    return content


def _require(path: Path, content: dict[str, Any], schema: str, fields: Sequence[str]) -> None:
    require_schema(path, content, schema)
    for name in fields:
        if name not in content:
            raise InputError(f"{path}: holds no {name}")


def _search(home: Path, content: dict[str, Any]) -> Exhibit:
    _checked(home, content)
    trace = home / "trace.json"
    profiles = _profiles(home)
    return search_exhibit(_name_of(home), content, profiles, trace=read_object(trace) if trace.is_file() else None)


def _profiles(home: Path) -> dict[str, dict[str, Any]]:
    """Columns of profiles.csv by the id of the run."""
    path = home / "profiles.csv"
    if not path.is_file():
        raise InputError(f"{path}: no such file: the page reads profiles as csv (tgvdp search --profiles csv)")
    profiles: dict[str, dict[str, list[Any]]] = {}
    for number, row in enumerate(_rows(path), start=2):
        own = profiles.setdefault(row.get("id", ""), {name: [] for name in (*PROFILE_COLUMNS, "regime")})
        try:
            for name in PROFILE_COLUMNS:
                own[name].append(float(row[name]))
            own["regime"].append(REGIMES.index(row["regime"]))
        except (KeyError, ValueError, TypeError) as error:
            raise InputError(f"{path}: line {number}: {error}") from None
    return profiles


def _rows(path: Path) -> list[dict[str, str]]:
    try:
        with path.open(newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None


def _journey(home: Path, content: dict[str, Any]) -> Exhibit:
    _require(home / "journey.json", content, JOURNEY_SCHEMA, ("sections", "fastest", "front", "practices"))
    return _plain("journey", home, content=content)


def _benchmark(home: Path, content: dict[str, Any]) -> Exhibit:
    tables = {
        name: [_numbers(row, columns) for row in _rows(home / name)] if (home / name).is_file() else []
        for name, columns in _BENCH_COLUMNS.items()
    }
    return _plain("benchmark", home, content=content, tables=tables)


def _numbers(row: Mapping[str, str], columns: tuple[str, ...]) -> dict[str, Any]:
    """Cells of some columns: numbers where they are, texts elsewhere, None where there is nothing finite."""
    return {name: _cell(row.get(name, "")) for name in columns}


def _cell(text: str) -> Any:
    try:
        value = float(text)
    except ValueError:
        return text or None
    return value if math.isfinite(value) else None


def _plain(kind: str, home: Path, **held: Any) -> Exhibit:
    provenance = home / "provenance.json"
    about = {"provenance": read_object(provenance)} if provenance.is_file() else {}
    name = _name_of(home)
    return Exhibit(kind, name, msgspec.json.encode({"kind": kind, "name": name, **about, **held}))


def _name_of(home: Path) -> str:
    """Name of a folder, of which ``.`` and ``..`` say nothing."""
    return home.resolve().name


_READERS: dict[str, Callable[[Path, dict[str, Any]], Exhibit]] = {
    "result.json": _search,
    "journey.json": _journey,
    "benchmark.json": _benchmark,
}
