"""From a name or a path to trains, tracks, maps and scenarios; the format is told by content, not by suffix."""

from dataclasses import dataclass, field
from difflib import get_close_matches
from hashlib import sha256
from pathlib import Path
from typing import Any

from tgvdp.errors import InputError
from tgvdp.formats import native, ttobench
from tgvdp.formats.reading import Document, bad, read_bytes, read_document, with_path
from tgvdp.formats.sources import Source, label, source_path
from tgvdp.model import catalog
from tgvdp.model.energy import EnergyMap
from tgvdp.model.track import Track
from tgvdp.model.train import Train

NATIVE = "native"
TTOBENCH = "TTOBench"


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """What a file holds, references resolved.

    Attributes
    ----------
    name : str
    format : str
        "native" or "TTOBench".
    train : Train or None
    track : Track or None
    map : EnergyMap or None
    options : dict
        Search options by their names on the command line, with ``_`` for ``-`` and the unit at the end (``from_m``,
        ``start_speed_kmh``, ``max_margin_pct``, ...); those that the file does not give are absent.
    inputs : dict
        SHA-256 of every file that was read, by its path or as ``catalog:name``.
    """

    name: str
    format: str
    train: Train | None = None
    track: Track | None = None
    map: EnergyMap | None = None
    options: dict[str, Any] = field(default_factory=dict)
    inputs: dict[str, str] = field(default_factory=dict)


def load_train(path_or_name: Source) -> Train:
    """Load a train from the catalog or from a file.

    Parameters
    ----------
    path_or_name : str or path
        A name of the catalog, or a TTOBench train, or a native file that holds or references a train.

    Raises
    ------
    InputError
        When there is no such name or file, or when it holds no valid train.
    """
    train = _read(source_path(path_or_name, "train"), ("train",)).train
    assert train is not None
    return train


def load_track(path_or_name: Source) -> Track:
    """Load a track from the catalog or from a file.

    Parameters
    ----------
    path_or_name : str or path
        A name of the catalog, or a TTOBench track, or a native file that holds or references a track.

    Raises
    ------
    InputError
        When there is no such name or file, or when it holds no valid track.
    """
    track = _read(source_path(path_or_name, "track"), ("track",)).track
    assert track is not None
    return track


def load_energy_map(path_or_name: Source) -> EnergyMap:
    """Load a map of the power drawn over speed and demand from the catalog or from a file.

    Parameters
    ----------
    path_or_name : str or path
        A name of the catalog, or a native file that holds or references a map.

    Raises
    ------
    InputError
        When there is no such name or file, or when it holds no valid map.
    """
    the_map = _read(source_path(path_or_name, "map"), ("map",)).map
    assert the_map is not None
    return the_map


def load_scenario(path: Source) -> Scenario:
    """Load everything that a file holds, and what it references.

    Raises
    ------
    InputError
        When the file or one that it references is missing or wrong.
    """
    return _read(source_path(path), catalog.KINDS)


def input_digest(path_or_name: Source) -> str:
    """SHA-256, in hexadecimal, of the bytes of a file or of a file of the catalog."""
    return sha256(read_bytes(source_path(path_or_name))).hexdigest()


def _read(path: Path, kinds: tuple[catalog.Kind, ...], chain: tuple[Path, ...] = ()) -> Scenario:
    """Read a file and what it references, as far as wanted: a kind wanted alone must be there, of several any."""
    document = read_document(path)
    inputs = {label(path): document.digest}
    kind = ttobench.kind_of(document.tree)
    if kind == "journey":
        raise bad(path, "holds a TTOBench journey (not supported yet)")
    if kind is not None:
        _require_kind(path, f"a {TTOBENCH} {kind}", kinds, (kind,))
    if kind == "train":
        train = ttobench.read_train(document)
        return Scenario(name=train.name, format=TTOBENCH, train=train, inputs=inputs)
    if kind == "track":
        track = ttobench.read_track(document)
        return Scenario(name=track.name, format=TTOBENCH, track=track, inputs=inputs)
    return _native(document, kinds, inputs, chain)


def _native(
    document: Document, kinds: tuple[catalog.Kind, ...], inputs: dict[str, str], chain: tuple[Path, ...]
) -> Scenario:
    path = document.path
    _require_known_content(document)
    file = native.read_native(document)
    held = tuple(kind for kind in catalog.KINDS if getattr(file, kind) is not None)
    _require_kind(path, f"a {' and a '.join(held)}" if held else "run options", kinds, held)
    found: dict[str, Any] = {}
    for kind in kinds:
        found[kind] = getattr(file, kind)
        if isinstance(found[kind], str):
            target = _follow(path, kind, found[kind], (*chain, path))
            found[kind] = getattr(target, kind)
            inputs |= target.inputs
    scenario = Scenario(name=file.name, format=NATIVE, options=file.options, inputs=inputs, **found)
    _require_run_on_track(path, scenario)
    return scenario


def _follow(path: Path, kind: catalog.Kind, reference: str, chain: tuple[Path, ...]) -> Scenario:
    """Read the file that another one references."""
    try:
        target = source_path(reference, kind, path.parent)
        if any(_same(target, before) for before in chain):
            raise InputError(f"the references go round in a circle, got {reference!r:.60}")
        return _read(target, (kind,), chain)
    except InputError as error:
        raise with_path(path, InputError(f"{kind}: {error}")) from None


def _same(one: Path, other: Path) -> bool:
    return one.resolve() == other.resolve()


def _require_kind(path: Path, held: str, wanted: tuple[catalog.Kind, ...], kinds: tuple[catalog.Kind, ...]) -> None:
    if len(wanted) == 1 and wanted[0] not in kinds:
        raise bad(path, f"holds {held}, not a {wanted[0]}")


def _require_known_content(document: Document) -> None:
    """Say what was expected when nothing at the top of a file is known; a slip beside known fields shows later."""
    fields = document.tree.keys()
    if fields & {"train", "track", "map", "run"}:
        return
    if "metadata" in fields:
        raise bad(document.path, "is neither a TTOBench train nor a TTOBench track: it has none of their fields")
    known = ["train", "track", "map", "run"]
    near = [match for name in fields for match in get_close_matches(name.lower(), known, n=1)]
    hint = f", did you mean {near[0]!r}?" if near else ""
    got = ", ".join(repr(name)[:40] for name in list(fields)[:3]) or "nothing"
    raise bad(document.path, f"holds none of train, track, map and run, nor a TTOBench train or track, got {got}{hint}")


def _require_run_on_track(path: Path, scenario: Scenario) -> None:
    if scenario.track is None:
        return
    length_m = scenario.track.length_m
    from_m = scenario.options.get("from_m", 0.0)
    to_m = scenario.options.get("to_m", length_m)
    if to_m > length_m:
        raise bad(path, f"run.to_m: must lie within the track's {length_m:.12g} m, got {to_m:.12g} m")
    if not from_m < to_m:
        raise bad(path, f"run.from_m: must lie before the destination at {to_m:.12g} m, got {from_m:.12g} m")
