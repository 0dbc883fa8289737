"""From a name or a path to all that a file holds, references resolved; the format is told by content, not suffix."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, get_args

from tgvdp.errors import InputError
from tgvdp.formats.content import Content, Kind
from tgvdp.formats.native import reader as native
from tgvdp.formats.osrd import path as osrd_path
from tgvdp.formats.osrd import stock as osrd
from tgvdp.formats.railml import reader as railml
from tgvdp.formats.railtoolkit import reader as railtoolkit
from tgvdp.formats.scenario import Read, Scenario
from tgvdp.formats.sfera import reader as sfera
from tgvdp.formats.sources import Source, Target, label, locate
from tgvdp.formats.syntax.reading import Document, bad, errors_named, parse_document, read_document, require_not_alone
from tgvdp.formats.tables import reader as tables
from tgvdp.formats.ttobench import reader as ttobench
from tgvdp.formats.unknown import require_known_content
from tgvdp.model import catalog
from tgvdp.model.checks import require_number
from tgvdp.model.track import Track
from tgvdp.units import mps_to_kmh

NATIVE = "native"
KINDS: tuple[Kind, ...] = get_args(Kind)
_NOTHING: Mapping[Kind, str] = MappingProxyType({})
#: Speeds that differ by less differ by rounding.
_SAME_MPS = 1e-9

#: Each returns what a document holds, or None when it is not of its format.
_FOREIGN = (
    sfera.open_document,
    railml.open_document,
    tables.open_document,
    osrd.open_document,
    osrd_path.open_document,
    ttobench.open_document,
    railtoolkit.open_document,
)


def read_source(
    source: Source, kind: Kind | None = None, *, line_speed_mps: float | None = None, track: Track | None = None
) -> Read:
    """Locate and read a train, track, map or journey, or everything that a file holds, ONCE: value and fingerprint.

    Parameters
    ----------
    source : str or path
    kind : {"train", "track", "map", "journey"}, optional
        All that it holds, when absent.
    line_speed_mps : float, optional
        See `tgvdp.formats.load.load_track`.
    track : Track, optional
        See `tgvdp.formats.load.load_journey`.

    Raises
    ------
    InputError
        When there is no such name or file, or when it holds nothing valid of that kind.
    """
    if kind == "journey" and isinstance(source, str) and source:
        source = Path(source)  # the catalog has none: text is a file
    target = locate(source, None if kind == "journey" else kind)
    document = replace(read_target(target, line_speed_mps), places=() if track is None else track.places)
    content, part, section = _open(document), target.part, None
    if kind == "journey" and part is not None and not (content and content.has(kind, part)):
        part, section = None, part
    scenario = _scenario(document, content, part, KINDS if kind is None else (kind,))
    value = scenario if kind is None else getattr(scenario, kind)
    remarks = tuple(remark for one in scenario.remarks.values() for remark in one)
    own = label(document.path)
    beside = {path: digest for path, digest in sorted(scenario.inputs.items()) if path != own}
    return Read(value, target.path, target.part, document.digest, remarks, scenario.format, beside, section)


def read_scenario(document: Document) -> Scenario:
    """Make everything that a document holds; see `tgvdp.formats.load.load_scenario`."""
    return _scenario(document, _open(document), None, KINDS)


def load_all(path: Source, *, line_speed_mps: float | None = None) -> tuple[Scenario, ...]:
    """Load everything that a file holds: one scenario, or one each where it holds several trains or tracks.

    Parameters
    ----------
    path : str or path
    line_speed_mps : float, optional
        See `tgvdp.formats.load.load_track`.

    Raises
    ------
    InputError
        When the file, something in it or one that it references is missing or wrong.
    """
    target = locate(path)
    document = read_target(target, line_speed_mps)
    return _each(document, _open(document), target.part)


def load_to_describe(path: Source, *, line_speed_mps: float | None = None) -> tuple[Scenario, ...]:
    """Load everything that a file holds, or the outline of what is nothing without another file; see `load_all`."""
    target = locate(path)
    document = read_target(target, line_speed_mps)
    content = _open(document)
    if content is None or not content.outline:
        return _each(document, content, target.part)
    inputs = {label(document.path): document.digest}
    outline = {f"{one.what} {one.id}": one.text for one in content.outlined(document.path, target.part)}
    return (Scenario(name=document.path.stem, format=content.format, inputs=inputs, outline=outline),)


def load_bytes(name: str, data: bytes, *, line_speed_mps: float | None = None) -> tuple[Scenario, ...]:
    """Load everything that the bytes of a file hold which came from elsewhere; no other file is opened for it.

    Parameters
    ----------
    name : str
        Of the file, for errors and for what its suffix says; nothing is looked for there.
    data : bytes
    line_speed_mps : float, optional
        See `tgvdp.formats.load.load_track`.

    Raises
    ------
    InputError
        When something in it is wrong, or when it references another file.
    """
    document = replace(parse_document(Path(name), data), is_alone=True)
    document = _with_line_speed(document, line_speed_mps)
    return _each(document, _open(document), None)


def _each(document: Document, content: Content | None, part: str | None) -> tuple[Scenario, ...]:
    if content is None or part is not None or content.is_one:
        return (_scenario(document, content, part, KINDS),)
    # Named as they are chosen: names for people need not be unique.
    return tuple(
        replace(_held(document, content, {kind: item.id}), name=item.id)
        for kind in content.items
        for item in content.each(kind)
    )


def _read(
    target: Target, kinds: tuple[Kind, ...], chain: tuple[Path, ...] = (), line_speed_mps: float | None = None
) -> Scenario:
    document = read_target(target, line_speed_mps)
    return _scenario(document, _open(document), target.part, kinds, chain)


def read_target(target: Target, line_speed_mps: float | None) -> Document:
    """Read the file of a target, to be taken with a line speed; see `tgvdp.formats.load.load_track`."""
    return _with_line_speed(read_document(target.path), line_speed_mps)


def _with_line_speed(document: Document, line_speed_mps: float | None) -> Document:
    if line_speed_mps is None:
        return document
    speed_mps = require_number("line speed", "line_speed", line_speed_mps, "m/s", above=0.0)
    return replace(document, line_speed_mps=speed_mps)


def _open(document: Document) -> Content | None:
    """What a document of a foreign format holds; None when it can only be a native one."""
    for open_document in _FOREIGN:
        content = open_document(document)
        if content is not None:
            return content
    return None


def _scenario(
    document: Document,
    content: Content | None,
    part: str | None,
    kinds: tuple[Kind, ...],
    chain: tuple[Path, ...] = (),
) -> Scenario:
    """Make what a document holds and references, as far as wanted: ONE kind must be there, of several any."""
    if content is None:
        if part is not None:
            raise bad(document.path, f"is a native file, of which {part!r:.40} chooses nothing")
        return _native(document, kinds, chain)
    if content.outline:
        raise bad(document.path, "; ".join(content.lacking.values()))
    article = "an" if content.format.startswith(tuple("AEIO")) else "a"
    held_text = f"{article} {content.format} {' and a '.join(content.items)}"
    _require_kind(document.path, held_text, kinds, tuple(content.items), content.lacking)
    held = {kind: part for kind in kinds if kind in content.items}
    if part is not None and len(held) > 1:
        held = {kind: part for kind in held if content.has(kind, part)} or held
    return _held(document, content, held)


def _held(document: Document, content: Content, parts: dict[Kind, str | None]) -> Scenario:
    """Make the chosen things of a foreign document."""
    made: dict[str, Any] = {}
    kept: dict[str, Mapping[str, Any]] = {}
    own: dict[str, tuple[str, ...]] = {}
    for kind, part in parts.items():
        if kind == "track" and document.line_speed_mps is not None and not content.takes_line_speed:
            raise _never_missing(document, content.format)
        item = content.choose(document.path, kind, part)
        with errors_named(document.path):
            made[kind] = _without_effect(item.make(), document.line_speed_mps)
        kept[kind], own[kind] = item.kept, item.own
    name = next(iter(made.values())).name
    inputs = {label(document.path): document.digest} | dict(content.inputs)
    remarks = {
        kind: tuple(f"{document.path.name}: {note}" for note in one.notes if note not in own[kind])
        for kind, one in made.items()
    }
    return Scenario(name=name, format=content.format, inputs=inputs, kept=kept, remarks=remarks, **made)


def _without_effect(made: Any, line_speed_mps: float | None) -> Any:
    """Note on a track that a line speed found no place without a limit."""
    if line_speed_mps is None or not isinstance(made, Track):
        return made
    note = idle_line_speed(made, line_speed_mps)
    return replace(made, notes=(note, *made.notes)) if note else made


def idle_line_speed(track: Track, line_speed_mps: float) -> str:
    """Say of a track that it was read with a line speed, m/s, for nothing; empty where it has that somewhere."""
    if any(abs(row.speed_mps - line_speed_mps) <= _SAME_MPS for row in track.speed_limits):
        return ""
    return (
        f"the line speed asked for, {mps_to_kmh(line_speed_mps):g} km/h, changes nothing: there is a limit everywhere"
    )


def _never_missing(document: Document, format: str) -> InputError:
    return bad(document.path, f"{format} lines have a speed limit everywhere: a line speed would change nothing")


def _native(document: Document, kinds: tuple[Kind, ...], chain: tuple[Path, ...]) -> Scenario:
    path = document.path
    require_known_content(document)
    file = native.read_native(document)
    held = tuple(kind for kind in catalog.KINDS if getattr(file, kind) is not None)
    _require_kind(path, f"a {' and a '.join(held)}" if held else "run options", kinds, held)
    if isinstance(file.track, Track) and "track" in kinds and document.line_speed_mps is not None:
        raise _never_missing(document, NATIVE)
    inputs = {label(path): document.digest} | file.inputs
    found: dict[str, Any] = {}
    kept: dict[str, Mapping[str, Any]] = {}
    remarks = {"train": file.remarks} if "train" in kinds else {}
    for kind in (kind for kind in catalog.KINDS if kind in kinds):
        found[kind] = getattr(file, kind)
        if isinstance(found[kind], str):
            target = _follow(document, kind, found[kind], chain)
            found[kind] = getattr(target, kind)
            inputs |= target.inputs
            kept |= target.kept
            remarks |= target.remarks
    scenario = Scenario(
        name=file.name, format=NATIVE, options=file.options, inputs=inputs, kept=kept, remarks=remarks, **found
    )
    _require_run_on_track(path, scenario)
    return scenario


def _follow(document: Document, kind: catalog.Kind, reference: str, chain: tuple[Path, ...]) -> Scenario:
    """Read the file that another one references."""
    path, speed_mps = document.path, document.line_speed_mps
    chain = (*chain, path)
    with errors_named(path, kind):
        if reference not in catalog.names(kind):
            require_not_alone(document, reference)
        target = locate(reference, kind, path.parent)
        if any(_same(target.path, before) for before in chain):
            raise InputError(f"the references go round in a circle, got {reference!r:.60}")
        return _read(target, (kind,), chain, speed_mps)


def _same(one: Path, other: Path) -> bool:
    return one.resolve() == other.resolve()


def _require_kind(
    path: Path, held: str, wanted: tuple[Kind, ...], kinds: tuple[Kind, ...], lacking: Mapping[Kind, str] = _NOTHING
) -> None:
    if len(wanted) == 1 and wanted[0] not in kinds:
        why = f": {lacking[wanted[0]]}" if wanted[0] in lacking else ""
        raise bad(path, f"holds {held}, not a {wanted[0]}{why}")


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
