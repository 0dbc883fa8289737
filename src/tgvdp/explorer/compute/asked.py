"""What the page asks for: a train, a line, options and edits, checked field by field."""

from collections.abc import Mapping
from typing import Any

import msgspec

from tgvdp.errors import ArgumentError, InputError
from tgvdp.model import catalog
from tgvdp.options.search import BY_FIELD, OPTIONS, SearchOptions, arguments_of

#: Options that the page does not offer: how much memory a child process has is not its business.
_WITHHELD = {"max_memory_mb"}
OFFERED = {name: one for name, one in BY_FIELD.items() if name not in _WITHHELD}
_UPLOAD = "upload:"
_PARTS = ("train", "track")


class FieldError(InputError):
    """Something is wrong with one field of a form.

    Attributes
    ----------
    field : str
        Name of the field; empty where it is none in particular.
    """

    def __init__(self, field: str, message: str) -> None:
        super().__init__(message)
        self.field = field


class File(msgspec.Struct, frozen=True):
    """An uploaded file: its name, for people, and its bytes."""

    name: str
    data: bytes


class Asked(msgspec.Struct, frozen=True, kw_only=True):
    """What a run is asked for.

    Attributes
    ----------
    train, track : str
        A name of the catalog, or ``upload:ID:N``, the N-th thing that an uploaded file holds.
    options : dict
        By their names in files, in the units of people.
    line_speed_kmh : float, optional
        Speed limit wherever an uploaded line gives none.
    mass_t : float, optional
        Another mass of the train.
    limits_kmh : dict of str to float
        Other speed limits, by the index of their row on the line.
    """

    train: str = "tgv"
    track: str = "lgv-100km"
    options: dict[str, Any] = msgspec.field(default_factory=dict)
    line_speed_kmh: float | None = None
    mass_t: float | None = None
    limits_kmh: dict[str, float] = msgspec.field(default_factory=dict)

    @property
    def edits(self) -> dict[str, list[str]]:
        """Edits as ``--set`` takes them, by the field that asks for them: numbers only, so that none names a file."""
        mass = [] if self.mass_t is None else [f"train.mass_t={self.mass_t!r}"]
        limits = [f"track.speed_limits[{row}].speed_kmh={value!r}" for row, value in self.limits_kmh.items()]
        return {"mass_t": mass, "limits_kmh": limits}


def read_asked(data: bytes, uploads: Mapping[str, File]) -> Asked:
    """Read and check what the page sends.

    Parameters
    ----------
    data : bytes
        JSON object with the fields of `Asked`.
    uploads : mapping
        Uploaded files by id.

    Raises
    ------
    FieldError
        When a field is wrong.
    """
    try:
        asked = msgspec.json.decode(data, type=Asked, strict=True)
    except (msgspec.DecodeError, RecursionError) as error:
        raise FieldError("", f"request: {error}") from None
    for part in _PARTS:
        _check_source(part, getattr(asked, part), uploads)
    for row in asked.limits_kmh:
        if not row.isdecimal():
            raise FieldError("limits_kmh", f"must be the index of a row of the line, got {row!r:.40}")
    _check_options(asked.options, uploads)
    return asked


def _check_source(part: Any, source: str, uploads: Mapping[str, File]) -> None:
    if is_upload(source):
        upload_of(source, uploads, part)
    elif source not in catalog.names(part):
        raise FieldError(part, f"unknown {part} {source!r:.40}; built in: {', '.join(catalog.names(part))}")


def upload_of(source: str, uploads: Mapping[str, File], field: str) -> tuple[File, int]:
    """Find the file that ``upload:ID:N`` means, and N.

    Raises
    ------
    FieldError
        When there is none.
    """
    number, _, item = source.removeprefix(_UPLOAD).partition(":")
    if number not in uploads or not item.isdecimal():
        raise FieldError(field, "this file is no longer here: upload it again")
    return uploads[number], int(item)


def is_upload(source: str) -> bool:
    """Whether a source is an uploaded file."""
    return source.startswith(_UPLOAD)


def _check_options(options: Mapping[str, Any], uploads: Mapping[str, File]) -> None:
    arguments: dict[str, Any] = {}
    fields: dict[str, str] = {}
    for name, value in options.items():
        if name not in OFFERED:
            raise FieldError(name, f"there is no option {name!r:.40}")
        made = _checked(name, value, uploads)
        arguments |= made
        fields |= dict.fromkeys(made, name)
    try:
        SearchOptions(**arguments)
    except ArgumentError as error:
        raise FieldError(fields[error.argument], error.reason) from None


def _checked(name: str, value: Any, uploads: Mapping[str, File]) -> dict[str, Any]:
    """Arguments that one option sets."""
    one = OFFERED[name]
    if one.open and is_upload(str(value)):
        upload_of(str(value), uploads, name)
        return {}
    known = (*one.choices, *catalog.names("map"))
    if one.open and value not in known:  # else it would be the path of a file
        raise FieldError(name, f"must be one of {', '.join(known)}, got {value!r:.40}")
    try:
        if one.kind in (int, float):
            one.check_given(value)
        arguments = arguments_of({name: value})
        for option in OPTIONS:
            if option.argument in arguments:
                arguments[option.argument] = option.check(arguments[option.argument])
    except ArgumentError as error:
        raise FieldError(name, error.reason) from None
    except InputError as error:
        raise FieldError(name, str(error)) from None
    except (TypeError, ValueError, AttributeError):
        raise FieldError(name, f"must be a value of another kind, got {value!r:.40}") from None
    return arguments
