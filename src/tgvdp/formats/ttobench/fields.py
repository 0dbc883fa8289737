"""What the files of TTOBench have in common: metadata, quantities with a unit, names of fields."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from msgspec import Struct, UnsetType, structs

from tgvdp.formats.syntax.reading import errors_named
from tgvdp.units import to_si


def spaced(name: str) -> str:
    """Name of a field in a file."""
    return name.replace("_", " ")


class Metadata(Struct, rename=spaced):
    """The README requires these two; other keys are free text."""

    id: str
    library_version: str


class Quantity(Struct, forbid_unknown_fields=True):
    """A number and its unit."""

    unit: str
    value: float


#: What stands between notes in the description of a file.
BETWEEN_NOTES = "; "
#: Braking data of a train, and what a track adds to it.
ETCS = "ETCS braking data"


def kept(tree: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of a train or track that no run uses, for a file that is written again."""
    return {name: tree[name] for name in ("num seats", "num coaches", ETCS) if name in tree}


def number_si(path: Path, name: str, given: Quantity | UnsetType, quantity: str, *, default: float = math.nan) -> float:
    """Return a quantity in SI, or the default where an optional field is absent."""
    return value_si(path, name, given.value, given.unit, quantity) if given else default


def value_si(path: Path, place: str, value: float, unit: str, quantity: str) -> float:
    """Return a value in SI; errors name the file and the place."""
    with errors_named(path, place):
        return to_si(value, unit, quantity)


def rows_si(path: Path, place: str, table: Any, *quantities: str) -> Iterator[list[float]]:
    """Rows of a table in SI; the fields of its ``units`` are its columns, each of a quantity."""
    names, units = table.units.__struct_encode_fields__, structs.astuple(table.units)
    for index, row in enumerate(table.values):
        if index == 0:  # all rows have the same units: an unknown one is named at the first
            for name, unit, quantity in zip(names, units, quantities, strict=True):
                value_si(path, f"{place}.units.{name}", 0.0, unit, quantity)
        with errors_named(path, f"{place}.values[{index}]"):
            si = [to_si(float(one), unit, quantity) for one, unit, quantity in zip(row, units, quantities, strict=True)]
        yield si
