"""Rows as they come in, in part files: whole and on disk, or not there."""

import os
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from tgvdp.sweeps.work import Record

#: Kinds of rows, each in a folder of its own: points of fronts, sections' shares of journeys, rows of speed profiles.
FRONTS, ALLOCATION, PROFILES = "fronts", "allocation", "profiles"


def part_path(folder: Path, kind: str, number: int) -> Path:
    """Where the rows of a part lie."""
    return folder / kind / f"{number:08d}.parquet"


def write_part(folder: Path, number: int, records: Sequence[Record]) -> None:
    """Write the rows of some records; they are on disk when this returns.

    A file of that number that an interruption left behind is replaced.
    """
    for kind, columns_of in _COLUMNS.items():
        made = [columns_of(record) for record in records]
        held = [(record.id, columns) for record, columns in zip(records, made, strict=True) if columns is not None]
        if held:
            _write(part_path(folder, kind, number), _joined(held))


def _joined(held: Iterable[tuple[int, dict[str, Any]]]) -> dict[str, Any]:
    """Columns of several tasks below each other, with the task that each row belongs to."""
    listed = list(held)
    names = list(listed[0][1])
    lengths = [len(columns[names[0]]) for _, columns in listed]
    ids = np.repeat([id for id, _ in listed], lengths)
    return {"id": ids} | {name: np.concatenate([columns[name] for _, columns in listed]) for name in names}


def _front(record: Record) -> dict[str, Any] | None:
    if record.front is None:
        return None
    return {"point": np.arange(len(record.front.time_s), dtype=np.int32), **record.front._asdict()}


def _allocation(record: Record) -> dict[str, Any] | None:
    if record.allocation is None:
        return None
    time_s, energy_j, ends_m = record.allocation
    points, sections = time_s.shape
    return {
        "point": np.repeat(np.arange(points, dtype=np.int32), sections),
        "from_m": np.tile(ends_m[:-1], points),
        "to_m": np.tile(ends_m[1:], points),
        "time_s": time_s.ravel(),
        "energy_j": energy_j.ravel(),
    }


def _profiles(record: Record) -> dict[str, Any] | None:
    return None if record.profiles is None else dict(record.profiles)


_COLUMNS: dict[str, Callable[[Record], dict[str, Any] | None]] = {
    FRONTS: _front,
    ALLOCATION: _allocation,
    PROFILES: _profiles,
}


def _write(path: Path, columns: dict[str, Any]) -> None:
    arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_suffix(".tmp")
    with open(draft, "wb") as file:
        table = arrow.table(columns)
        parquet.write_table(table, file, compression="none", use_dictionary=False, write_statistics=False)
        file.flush()
        os.fsync(file.fileno())
    os.replace(draft, path)
    sync_folder(path.parent)


def sync_folder(folder: Path) -> None:
    """Have the names of a folder on disk, where the system can do that."""
    if hasattr(os, "O_DIRECTORY"):
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
