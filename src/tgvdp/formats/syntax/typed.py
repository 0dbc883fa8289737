"""From a tree of values to typed structs, with errors that name the file, the field and the value."""

import re
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args, get_origin

import msgspec

from tgvdp.formats.syntax.reading import bad, field_text, shown
from tgvdp.units import LARGEST_WRITTEN, SMALLEST_WRITTEN

T = TypeVar("T")

_FEW = 8
Positive = Annotated[float, msgspec.Meta(ge=SMALLEST_WRITTEN, le=LARGEST_WRITTEN)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0, le=LARGEST_WRITTEN)]
Finite = Annotated[float, msgspec.Meta(ge=-LARGEST_WRITTEN, le=LARGEST_WRITTEN)]

_WORDS = {
    "float": "a number",
    "int": "a whole number",
    "str": "text",
    "bool": "true or false",
    "array": "a list",
    "object": "a table",
    "null": "null",
}


def in_unit(unit: str) -> msgspec.Meta:
    """Annotation of a field that has a unit which its name does not end in: errors say it."""
    return msgspec.Meta(extra={"unit": unit})


def decode(path: Path, tree: Any, kind: type[T], within: tuple[str, ...] = ()) -> T:
    """Turn a tree into a struct; unknown, missing and mistyped fields are `InputError`.

    ``within`` says where in the file the tree is, when it is only a part: msgspec does not name the keys of tables
    whose fields are free, so the reader walks through those itself.
    """
    try:
        return msgspec.convert(tree, kind)
    except msgspec.ValidationError as error:
        text, _, place = str(error).partition(" - at `$")
        at, value = _locate(tree, place.rstrip("`"))
        raise bad(path, _explain(text, (*within, *at), value, _kinds_at(kind, at))) from None


def extensions(path: Path, tree: Any, kind: Any) -> tuple[str, ...]:
    """Fields that a format with room for extensions does not define, as a note; a slip of the pen is an error.

    Parameters
    ----------
    path : Path
    tree : dict
        As `decode` has accepted it.
    kind : type
        Struct that lets unknown fields pass.

    Returns
    -------
    tuple of str
        One note, or none.

    Raises
    ------
    InputError
        When an unknown field is nearly the name of a known one that is absent.
    """
    places: dict[str, None] = {}  # in order, each once
    for table, struct, at in _tables(tree, kind, ()):
        known = list(_kinds_of_fields(struct))
        for name in table.keys() - set(known):
            near = get_close_matches(str(name).lower(), [one for one in known if one not in table], n=1, cutoff=0.8)
            if near:
                where = f"{field_text(at)}: " if at else ""
                raise bad(path, f"{where}unknown field {shown(name)}, did you mean {near[0]!r}?")
            places[shown(re.sub(r"\[\d+\]", "[]", field_text((*at, name))))] = None
    if not places:
        return ()
    more = f" and {len(places) - _FEW} more" if len(places) > _FEW else ""
    return (f"fields that are not part of the format: {', '.join(sorted(places)[:_FEW])}{more}",)


def _tables(
    tree: Any, kind: Any, at: tuple[str | int, ...]
) -> Iterator[tuple[dict[str, Any], type[msgspec.Struct], tuple[str | int, ...]]]:
    """Every table of a typed tree, its struct and its place."""
    for one in _alternatives(kind):
        if _is_struct(one) and isinstance(tree, dict):
            yield tree, one, at
            for name, below in _kinds_of_fields(one).items():
                if name in tree and _holds_tables(below):
                    yield from _tables(tree[name], below, (*at, name))
        elif get_origin(one) is list and isinstance(tree, list):
            for index, child in enumerate(tree):
                yield from _tables(child, get_args(one)[0], (*at, index))


@cache
def _kinds_of_fields(struct: type[msgspec.Struct]) -> dict[str, Any]:
    """Type of each field of a struct, by its name in files."""
    return {field.encode_name: field.type for field in msgspec.structs.fields(struct)}


@cache
def _holds_tables(kind: Any) -> bool:
    """Whether a type is a struct or a list that holds structs somewhere; long lists of numbers are not walked."""
    return any(
        _is_struct(one) or (get_origin(one) is list and _holds_tables(get_args(one)[0])) for one in _alternatives(kind)
    )


def suggestion(name: str, known: Sequence[str]) -> str:
    """Return ``, did you mean 'x'?`` for the nearest known name, or else the known ones where they are few."""
    near = get_close_matches(name.lower(), known, n=1, cutoff=0.6)
    if near:
        return f", did you mean {near[0]!r}?"
    return f"; known: {', '.join(known)}" if 0 < len(known) <= _FEW else ""


def _explain(text: str, at: tuple[str | int, ...], value: Any, kinds: list[Any]) -> str:
    where = f"{field_text(at)}: " if at else ""
    name = "".join(re.findall(r"field `(.*)`", text))
    if text.startswith("Object contains unknown field"):
        return f"{where}unknown field {shown(name)}{suggestion(name, _fields_of(kinds))}"
    if text.startswith("Object missing required field"):
        return f"{where}missing field {shown(name)}"
    expected = re.match(r"Expected (.*?)(, got .*)?$", text)
    if expected is None:
        return f"{where}{text[0].lower()}{text[1:]}, got {shown(value)}"
    wanted = re.sub(r"`([^`]*)`", lambda types: _words(types[1]), expected[1]).replace("-0.0", "0.0")
    wanted = re.sub(rf"a number [<>]= -?{LARGEST_WRITTEN}", f"a number within ±{LARGEST_WRITTEN:g}", wanted)
    if isinstance(value, int | float) and value <= 0.0:
        wanted = wanted.replace(f">= {SMALLEST_WRITTEN}", "> 0.0")
    if wanted.startswith("a list of length") and isinstance(value, list):
        return f"{where}must be {wanted}, got {len(value)} values"
    unit = _unit_of(kinds)
    if unit:
        wanted = wanted.replace("a number", f"a number in {unit}", 1)
    got = (
        f"{shown(value)} {unit}"
        if unit and isinstance(value, int | float) and not isinstance(value, bool)
        else shown(value)
    )
    return f"{where}must be {wanted}, got {got}"


def _words(types: str) -> str:
    return " or ".join(_WORDS.get(name, name) for name in types.split(" | "))


def _locate(tree: Any, place: str) -> tuple[tuple[str | int, ...], Any]:
    """Follow msgspec's path (``.speed limits.values[3]``; keys are not quoted) into the tree."""
    at: list[str | int] = []
    value = tree
    while place:
        if isinstance(value, list):
            index, _, place = place[1:].partition("]")
            step: str | int = int(index)
        else:
            # A key may itself hold dots or brackets: the longest one that fits is meant.
            fits = [key for key in value if place[1:].startswith(key)] if isinstance(value, dict) else []
            if not fits:
                break
            key = max(fits, key=len)
            place = place[1 + len(key) :]
            step = key
        at.append(step)
        value = value[step]
    return tuple(at), value


def _kinds_at(kind: Any, at: tuple[str | int, ...]) -> list[Any]:
    """Types at a place in a typed tree, and what they are annotated with."""
    kinds = _alternatives(kind)
    for step in at:
        below: list[Any] = []
        for one in kinds:
            if isinstance(step, int):
                below += [part for part in get_args(one) if get_origin(one) in (list, tuple)]
            elif _is_struct(one):
                below += [field.type for field in msgspec.structs.fields(one) if field.encode_name == step]
        kinds = [alternative for part in below for alternative in _alternatives(part)]
    return kinds


def _unit_of(kinds: list[Any]) -> str:
    """Unit that a field is annotated with, empty without one."""
    parts = (part for one in kinds for part in (one, *get_args(one)))  # of Annotated[...] | None, too
    return next((part.extra["unit"] for part in parts if isinstance(part, msgspec.Meta) and part.extra), "")


def _fields_of(kinds: list[Any]) -> list[str]:
    """Names of the fields of structs."""
    return [field.encode_name for one in kinds if _is_struct(one) for field in msgspec.structs.fields(one)]


def _alternatives(kind: Any) -> list[Any]:
    return [kind] if get_origin(kind) in (list, tuple) or _is_struct(kind) else list(get_args(kind))


def _is_struct(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, msgspec.Struct)
