"""Optima by others: a table ``reference/optimum.csv`` beside a folder ``ttobench`` with its trains and lines.

Columns: track, train, from_stop_m, to_stop_m, variant (A: energy at the wheel), margin_pct, T_min_s, T_s, E_ref_kWh.
"""

import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tgvdp.api.run import search
from tgvdp.errors import InputError
from tgvdp.formats import load_track, load_train
from tgvdp.units import JOULE_PER_KWH
from tgvdp.verification.case import Case, equal

PART = "reference optima"
_TABLE = Path("reference", "optimum.csv")
_TRIP = ("track", "train", "from_stop_m", "to_stop_m")
_NUMBERS = ("from_stop_m", "to_stop_m", "T_min_s", "T_s", "E_ref_kWh")
_WHEEL = "A"


def cases(folder: Path) -> Iterator[Case]:
    """Fastest running time of each trip, and the sum of its least energies at the reference's running times.

    Raises
    ------
    InputError
        When the table or one of its trains and lines cannot be read.
    """
    trips: dict[tuple[str, ...], list[dict[str, str]]] = {}
    for row in _rows(folder / _TABLE):
        trips.setdefault(tuple(row[name] for name in _TRIP), []).append(row)
    for (track, train, from_m, to_m), rows in trips.items():
        rows.sort(key=lambda row: float(row["T_s"]))
        found = search(
            load_train(folder / "ttobench" / "trains" / f"{train}.json"),
            load_track(folder / "ttobench" / "tracks" / f"{track}.json"),
            origin_m=float(from_m), destination_m=float(to_m), at_s=[float(row["T_s"]) for row in rows],
        )  # fmt: skip
        name = f"{track} {float(from_m):g} to {float(to_m):g} m"
        fastest_s = float(rows[0]["T_min_s"])
        yield equal(PART, f"{name}: fastest time, s", found.fastest.time_s, fastest_s, 4.0)
        expected_j = JOULE_PER_KWH * sum(float(row["E_ref_kWh"]) for row in rows)
        found_j = float(np.sum(found.front.energy_j[-len(rows) :]))
        yield equal(PART, f"{name}: least energies at {len(rows)} times, J", found_j, expected_j, 3.0)


def _rows(table: Path) -> list[dict[str, str]]:
    try:
        with table.open(encoding="utf-8", newline="") as file:
            rows = [row for row in csv.DictReader(file) if row.get("variant") == _WHEEL]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{table}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
    for number, row in enumerate(rows, start=2):
        for name in _NUMBERS:
            try:
                float(row[name])
            except (KeyError, TypeError, ValueError):
                raise InputError(
                    f"{table}: line {number}: {name} must be a number, got {row.get(name)!r:.40}"
                ) from None
    if not rows:
        raise InputError(f"{table}: holds no rows of variant {_WHEEL}")
    return rows
