"""Places on a line as people give them: a position, or the name of a stop."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import click

from tgvdp.cli.numbers import number
from tgvdp.errors import InputError

if TYPE_CHECKING:
    from tgvdp.model.track import Track

#: Options that are places.
_FLAGS = {"from_m": "--from", "to_m": "--to"}
#: What numbers begin with; and what reads as one and begins with a letter. There is a stop 's-Hertogenbosch.
_DIGITS, _NUMBERS = "+-.0123456789", ("nan", "inf", "infinity")


def place(*, at_least: float | None = None) -> Callable[[str], float | str]:
    """Make the type of an option that takes a position, m, or the name of a place, which the line has to tell."""
    position = number("m", at_least=at_least)

    def convert(text: str) -> float | str:
        name = text.strip()
        is_name = name and name[0] not in _DIGITS and name.lower() not in _NUMBERS
        return name if is_name else position(text)

    return convert


def positions_on(track: "Track", given: Mapping[str, Any]) -> dict[str, Any]:
    """Give origin and destination, where they are names of places, as positions on a line; all else stays.

    Raises
    ------
    click.BadParameter
        When the line has no such place, or several of that name.
    """
    ends = {name: _position_on(track, given[name], flag) for name, flag in _FLAGS.items() if name in given}
    return {**given, **ends}


def _position_on(track: "Track", given: float | str | None, flag: str) -> float | None:
    """Position on a line, m, that an option gives."""
    from tgvdp.formats.calls import position_of

    if not isinstance(given, str):
        return given
    try:
        return position_of(given, track.places)
    except InputError as error:
        raise click.BadParameter(str(error), click.get_current_context(), param_hint=repr(flag)) from None
