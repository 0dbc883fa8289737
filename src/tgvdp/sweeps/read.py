"""From SPEC.toml to a sweep: trains and lines are read once, here, so that workers need no files."""

import functools
import itertools
import operator
from collections import Counter
from collections.abc import Hashable, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from msgspec import Meta, Struct

from tgvdp.errors import InputError
from tgvdp.formats import read_source
from tgvdp.formats.detect import load_all
from tgvdp.formats.native.changes import Changed, changed, fields
from tgvdp.formats.native.reader import run_options
from tgvdp.formats.syntax.reading import bad, errors_named, read_document, shown
from tgvdp.formats.syntax.typed import decode, suggestion
from tgvdp.formats.unknown import SWEEP_FIELDS
from tgvdp.model import catalog
from tgvdp.model.track import Track
from tgvdp.options.search import BY_FIELD, JOURNEY_FIELDS, SearchOptions, arguments_of, by_argument
from tgvdp.options.texts import parse_quantity
from tgvdp.sweeps.scenario import Kind, Part, Section, section_name
from tgvdp.sweeps.spec import SET, Axis, SweepSpec, Tables, changes_of, is_default

#: Files of a folder that may hold a train or a line.
_SUFFIXES = {".toml", ".json", ".yaml", ".yml", ".xml", ".railml", ".csv", ".xlsx"}
#: Options and fields whose place the sections take; a journey stops where the line says.
_PLACES = {
    "search": ("from_m", "to_m", "track.length_m", "track.stops_m"),
    "journey": ("from_m", "to_m", "track.length_m"),
}
_WHOLE, _STOPS, _JOURNEY = "whole", "stops", "journey"
_Role = Literal["train", "track"]
_Names = Annotated[list[str], Meta(min_length=1)]


class _File(Struct, forbid_unknown_fields=True):
    """The tables of a spec; see docs/sweeps.md."""

    trains: _Names
    lines: _Names
    sections: str | _Names = _WHOLE
    dwell_s: Annotated[float, Meta(ge=0.0)] | None = None
    profiles_every_m: Annotated[float, Meta(gt=0.0)] | None = None
    csv: bool = True
    run: dict[str, Any] = {}
    product: dict[str, Any] = {}  # lists: names of free fields are missing from errors of `decode`
    zip: list[dict[str, Any]] = []


def read_spec(path: Path) -> SweepSpec:
    """Read a spec, and the trains and lines that it names; relative paths count from its folder.

    Raises
    ------
    InputError
        When the file, one that it names, or a value in it is wrong: the error names file and field.
    """
    document = read_document(path)
    if not document.tree.keys() & SWEEP_FIELDS:
        raise bad(path, "is no spec of a sweep: it names neither trains nor lines")
    file = decode(path, document.tree, _File)
    kind: Kind = "journey" if file.sections == _JOURNEY else "search"
    if kind == "search" and file.dwell_s is not None:
        raise bad(path, f"dwell_s: belongs to sections = {_JOURNEY!r}")
    if kind == "journey" and file.profiles_every_m is not None:
        raise bad(path, f"profiles_every_m: is for sections from stop to stop, not for {_JOURNEY!r}")
    trains = tuple(_parts(path, "trains", file.trains, "train"))
    lines = tuple(_parts(path, "lines", file.lines, "track"))
    placed = _axes(path, file)
    run = run_options(path, file.run)
    tables = _tables(
        path, [made for place, axis in placed for made in _made(path, place, axis, run, trains[0], lines[0])]
    )
    _check_fields(path, kind, [("run", field) for field in run])
    _check_fields(path, kind, [(place, name) for place, axis in placed for name in axis.names])
    _check_together(path, run, [axis for _, axis in placed])
    sections = tuple(tuple(_sections(path, file.sections, line)) for line in lines)
    is_listed = not isinstance(file.sections, str)
    return SweepSpec(
        trains=trains,
        lines=lines,
        sections=sections,
        sections_back=sections if is_listed else tuple(map(tuple, map(_back, sections, lines))),
        axes=tuple(axis for _, axis in placed),
        tables=tables,
        run=run,
        kind=kind,
        profiles_every_m=file.profiles_every_m,
        dwell_s=file.dwell_s,
        csv=file.csv,
        text=document.data.decode(),
    )


class _Found(NamedTuple):
    """A train or line of a folder or file, as it is read, and its name in the results."""

    source: str
    name: str


def _parts(path: Path, field: str, sources: Sequence[str], role: _Role) -> Iterator[Part]:
    """All trains or lines that are named; of a folder and of a file all that it holds."""
    names: set[str] = set()
    for index, source in enumerate(sources):
        with errors_named(path, f"{field}[{index}]"):
            for found in _found(path, source, role):
                if found.name in names:
                    raise InputError(f"two {field} are called {shown(found.name)}")
                names.add(found.name)
                read = read_source(found.source, role)
                yield Part(found.name, read.value, read.path.name, read.sha256, tuple(read.remarks))


def _found(spec: Path, source: str, role: _Role) -> Iterator[_Found]:
    """What a name, a file or a folder beside the spec holds."""
    if source in catalog.names(role):
        yield _Found(source, source)
        return
    place = spec.parent / source
    if place.is_dir():
        files = [file for file in sorted(place.iterdir()) if file.is_file() and file.suffix.lower() in _SUFFIXES]
        files = [file for file in files if not file.samefile(spec)]
        held = [found for file in files for found in _held(file, role)]
        if not held:
            raise InputError(f"{place}: no file in this folder holds a {role}")
        yield from held
    elif "#" in source and not place.exists():
        yield _Found(str(place), Path(source).name)
    else:
        yield from _held(place, role) or [_Found(str(place), place.stem)]  # whose error says what it holds instead


def _held(file: Path, role: _Role) -> list[_Found]:
    """Each train or line that a file holds."""
    held = [one for one in load_all(file) if getattr(one, role) is not None]
    if len(held) == 1:
        return [_Found(str(file), file.stem)]
    return [_Found(f"{file}#{one.name}", f"{file.stem}#{one.name}") for one in held]


def _sections(path: Path, given: str | Sequence[str], line: Part) -> Iterator[Section]:
    """Sections of a line: the whole, from stop to stop, over all stops, or those that are listed."""
    track: Track = line.value
    if isinstance(given, str):
        if given not in (_WHOLE, _STOPS, _JOURNEY):
            raise bad(path, f"sections: must be {_WHOLE}, {_STOPS}, {_JOURNEY} or a list of FROM:TO, got {given!r:.40}")
        ends_m = (0.0, track.length_m) if given != _STOPS or len(track.stops_m) < 2 else track.stops_m
        yield from (Section(_JOURNEY if given == _JOURNEY else section_name(*pair), *pair) for pair in pairwise(ends_m))
        return
    names: set[str] = set()
    for index, text in enumerate(given):
        with errors_named(path, f"sections[{index}]"):
            section = _section(text)
            if section.name in names:
                raise InputError(f"stands there twice, got {text!r:.40}")
            names.add(section.name)
            if section.to_m > track.length_m:
                raise InputError(f"ends beyond the {track.length_m:.12g} m of line {line.name}, got {text!r:.40}")
            yield section


def _back(sections: Sequence[Section], line: Part) -> Iterator[Section]:
    """Sections of a line as they are run in the other direction, positions from its end."""
    length_m = line.value.length_m
    for one in reversed(sections):
        ends_m = length_m - one.to_m, length_m - one.from_m
        yield one if ends_m == (one.from_m, one.to_m) else Section(section_name(*ends_m), *ends_m)


def _section(text: str) -> Section:
    start, colon, end = text.partition(":")
    if not colon:
        raise InputError(f"must be FROM:TO such as 0:12.5km, got {text!r:.40}")
    from_m, to_m = parse_quantity(start, "m"), parse_quantity(end, "m")
    if not 0.0 <= from_m < to_m:
        raise InputError(f"must be FROM:TO with 0 <= FROM < TO, got {text!r:.40}")
    return Section(section_name(from_m, to_m), from_m, to_m)


def _axes(path: Path, file: _File) -> list[tuple[str, Axis]]:
    """What varies: every field of ``product`` on its own, those of each ``zip`` together, each with its table."""
    product = _lists(path, "product", file.product)
    axes = [("product", Axis((name,), tuple((value,) for value in values))) for name, values in product.items()]
    for index, given in enumerate(file.zip):
        table = _lists(path, f"zip[{index}]", given)
        lengths = {name: len(values) for name, values in table.items()}
        if len(set(lengths.values())) != 1:
            got = ", ".join(f"{name} with {length}" for name, length in lengths.items())
            raise bad(path, f"zip[{index}]: all lists must be equally long, got {got or 'none'}")
        axes.append((f"zip[{index}]", Axis(tuple(table), tuple(zip(*table.values(), strict=True)))))
    for place, axis in axes:
        if not axis.rows:
            raise bad(path, f"{place}.{axis.names[0]}: must have values")
        rows = Counter(map(_hashable, axis.rows))
        twice = [row for row in axis.rows if rows[_hashable(row)] > 1]
        if twice:
            got = ", ".join(shown(value) for value in twice[0])
            raise bad(path, f"{place}.{' and '.join(axis.names)}: must have each value once, got {got} twice")
    names = [name for _, axis in axes for name in axis.names]
    for place, axis in axes:
        for name in axis.names:
            if "." in name and not name.startswith(SET):  # options have no dot
                raise bad(path, f"{place}: unknown field {shown(name)}{suggestion(name, fields())}")
    for name in names:
        if names.count(name) > 1 or name in file.run:
            raise bad(path, f"{name}: stands in more than one of run, product and zip")
    return axes


def _lists(path: Path, place: str, table: Mapping[str, Any]) -> dict[str, list[Any]]:
    """The values of each field."""
    return {name: decode(path, values, list[Any], (place, name)) for name, values in table.items()}


def _hashable(value: Any) -> Hashable:
    """A value, by which equal ones are found."""
    if isinstance(value, list | tuple):
        return tuple(map(_hashable, value))
    return value if isinstance(value, Hashable) else str(value)


def _made(
    path: Path, place: str, axis: Axis, run: Mapping[str, Any], train: Part, line: Part
) -> Iterator[tuple[list[str], Changed]]:
    """Fields that an axis sets, a row each, and what becomes of a train and a line by them.

    Values that no search could take are refused, before the first one starts.
    """
    for row in axis.rows:
        given = dict(zip(axis.names, row, strict=True))
        options = {name: value for name, value in given.items() if not name.startswith(SET)}
        run_options(path, {**run, **options}, place)
        with errors_named(path, place):
            for argument, value in arguments_of(options).items():
                by_argument(argument).check(value)
        if changes := changes_of(given):
            yield changes, changed(train.value, line.value, changes, path)


def _tables(path: Path, made: Sequence[tuple[list[str], Changed]]) -> Tables:
    """Files that were read for what is made."""
    read = [(changes, one) for changes, one in made if one.inputs]
    return Tables(
        {change: settled for changes, one in read for change, settled in zip(changes, one.settled, strict=True)},
        {file: digest for _, one in read for file, digest in one.inputs.items()},
        tuple(dict.fromkeys(remark for _, one in read for remark in one.remarks)),
    )


def _check_fields(path: Path, kind: Kind, given: Sequence[tuple[str, str]]) -> None:
    """Refuse options that a sweep has another place for, or that journeys lack."""
    for place, field in given:
        if field.partition("[")[0] in _PLACES[kind]:
            raise bad(path, f"{place}.{field}: the sections of a sweep say from where to where")
        if kind == "journey" and not field.startswith(SET) and field not in JOURNEY_FIELDS:
            raise bad(path, f"{place}.{field}: journeys have no {BY_FIELD[field].flag}")


def _check_together(path: Path, run: Mapping[str, Any], axes: Sequence[Axis]) -> None:
    """Refuse options that have no effect beside others: what they are asked for matters, not the values."""
    choices = []
    for axis in axes:
        kinds: dict[Hashable, dict[str, Any]] = {}
        for row in axis.rows:
            options = {name: value for name, value in zip(axis.names, row, strict=True) if not name.startswith(SET)}
            asked = frozenset(name for name, value in arguments_of(options).items() if not is_default(name, value))
            kinds.setdefault((asked, options.get("method")), options)
        choices.append(list(kinds.values()))
    with errors_named(path, "run, product and zip together"):
        for combination in itertools.product(*choices):
            SearchOptions(**arguments_of(functools.reduce(operator.or_, combination, dict(run))))
