"""railtoolkit running paths (schemas 2022.05 and 2024.07) and rolling stock (2022.05), YAML or JSON.

A path is a list of sections: position in m, speed limit in km/h, and resistance in ‰, which lumps gradients, curves and
all else; its last row only marks the end. A train is a formation of vehicles; how that becomes one train is said in
`railtoolkit.train`.
Source: railtoolkit/schema (Kannenberg, TU Dresden, ISC) and its reading by TrainRuns.jl. Rolling stock of 2024.07 is a
draft that has changed under that number, with nested tables and units of its own, and that no tool reads: refused.
"""

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

from msgspec import UNSET, Meta, Struct, UnsetType

from tgvdp.formats.content import Content, Item, Kind
from tgvdp.formats.railtoolkit.train import RollingStock, train_of
from tgvdp.formats.syntax.reading import Document, bad, shown
from tgvdp.formats.syntax.typed import Finite, Positive, decode, extensions
from tgvdp.model.track import VERTICAL_PERMIL, Gradient, SpeedLimit, Track
from tgvdp.units import kmh_to_mps

STOCK_VERSIONS = ("2022.05",)
PATH_VERSIONS = ("2022.05", "2024.07")
_SITE = "railtoolkit.org"
_FEWEST_ROWS = 2

Permil = Annotated[float, Meta(gt=-VERTICAL_PERMIL, lt=VERTICAL_PERMIL)]


class _Section(Struct):
    """A row of 2024.07; speed and resistance hold on where they are absent."""

    position: Finite
    speed: Positive | UnsetType = UNSET
    resistance: Permil | UnsetType = UNSET


class _Path(Struct):
    id: str | int
    characteristic_sections: Annotated[list[tuple[Finite, Positive, Permil] | _Section], Meta(min_length=_FEWEST_ROWS)]
    name: str | int | UnsetType = UNSET
    description: Any = UNSET
    UUID: Any = UNSET
    points_of_interest: Any = UNSET


class _Paths(Struct):
    paths: Annotated[list[_Path], Meta(min_length=1)]
    schema: str = ""
    schema_version: str | float = PATH_VERSIONS[0]


def open_document(document: Document) -> Content | None:
    """Tell what a document holds; None when it is of another format.

    Raises
    ------
    InputError
        When a field is missing, mistyped or out of range.
    """
    path, tree = document.path, document.tree
    ours = _SITE in str(tree.get("schema", ""))
    if "vehicles" in tree and (ours or "trains" in tree):
        stock = decode(path, tree, RollingStock)
        _require_version(path, stock.schema_version, STOCK_VERSIONS, "rolling stock")
        notes = extensions(path, tree, RollingStock)
        trains = (
            Item(str(one.id), partial(train_of, path, stock, index, notes), (_text(one.name),))
            for index, one in enumerate(stock.trains)
        )
        return _content(path, "trains", "train", trains)
    if "paths" in tree:
        file = decode(path, tree, _Paths)
        _require_version(path, file.schema_version, PATH_VERSIONS, "running paths")
        notes = extensions(path, tree, _Paths)
        tracks = (
            Item(str(one.id), partial(_track, path, index, one, notes), (_text(one.name),))
            for index, one in enumerate(file.paths)
        )
        return _content(path, "paths", "track", tracks)
    if ours:
        raise bad(path, "is a railtoolkit file, but holds neither vehicles nor paths")
    return None


def _content(path: Path, place: str, kind: Kind, items: Iterable[Item]) -> Content:
    by_id: dict[str, Item] = {}
    for index, item in enumerate(items):
        if item.id in by_id:
            raise bad(path, f"{place}[{index}].id: {shown(item.id)} is given twice")
        by_id[item.id] = item
    return Content(format="railtoolkit", items={kind: tuple(by_id.values())})


def _text(name: str | int | UnsetType) -> str:
    return "" if name is UNSET else str(name)


def _require_version(path: Path, version: str | float, known: tuple[str, ...], what: str) -> None:
    """The version is text, but 2022.05 without quotes is a number."""
    text = version if isinstance(version, str) else f"{version:.2f}"
    if text not in known:
        raise bad(path, f"schema_version: {what} must be of {' or '.join(known)}, got {shown(version)}")


def _track(path: Path, index: int, given: _Path, notes: tuple[str, ...]) -> Track:
    rows = list(_carried(path, index, given.characteristic_sections))
    start_m = rows[0][0]
    for row, ((before_m, *_), (position_m, *_)) in enumerate(pairwise(rows), start=1):
        if not position_m > before_m:
            place = f"paths[{index}].characteristic_sections[{row}]"
            raise bad(path, f"{place}: position must increase, got {position_m:.12g} m after {before_m:.12g} m")
    more = ["resistance in ‰ is read as gradient: it lumps gradients, curves and tunnels"]
    if start_m != 0.0:
        more.append(f"positions count from the start of the path at {start_m:.12g} m")
    if given.points_of_interest is not UNSET:
        more.append("points_of_interest are not used")
    return Track(
        name=str(given.id),
        length_m=rows[-1][0] - start_m,
        speed_limits=tuple(SpeedLimit(position_m - start_m, kmh_to_mps(kmh)) for position_m, kmh, _ in rows[:-1]),
        gradients=tuple(Gradient(position_m - start_m, permil) for position_m, _, permil in rows[:-1]),
        notes=(*more, *notes),
    )


def _carried(
    path: Path, index: int, sections: Sequence[tuple[float, float, float] | _Section]
) -> Iterator[tuple[float, float, float]]:
    """Rows with what a later one leaves out carried forward from the one before it; level where none came before."""
    speed_kmh: float | UnsetType = UNSET
    permil = 0.0
    for row, section in enumerate(sections):
        if not isinstance(section, _Section):
            yield section
            continue
        speed_kmh = speed_kmh if section.speed is UNSET else section.speed
        permil = permil if section.resistance is UNSET else section.resistance
        if speed_kmh is UNSET:
            raise bad(path, f"paths[{index}].characteristic_sections[{row}]: missing field 'speed'")
        yield section.position, speed_kmh, permil
