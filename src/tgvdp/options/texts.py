"""What people write: quantities (``20km``), and where they want points on a front (``3%, 5%, 1050s, 17:30``)."""

import math
import re
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.units import SECONDS_PER_MINUTE, converted

_NUMBER = r"\d+(?:\.\d*)?|\.\d+"
_MARGIN = re.compile(rf"({_NUMBER})\s*%")
_SECONDS = re.compile(rf"({_NUMBER})\s*s")
_CLOCK = re.compile(r"(?:(\d+):)?(\d+):(\d{2}(?:\.\d*)?)")
_GRAMMAR = "a margin such as 5%, or a running time such as 1050s, 17:30 (min:s) or 1:07:30 (h:min:s)"


_QUANTITY = re.compile(rf"([-+]?(?:{_NUMBER})(?:[eE][-+]?\d+)?)\s*(\D\S*)")


def parse_quantity(text: str, unit: str) -> float:
    """Read a number of a unit: plain, or with that unit or another of the same quantity behind it.

    ``20km``, ``20 km`` and ``20000`` are the same where the unit is m.

    Raises
    ------
    InputError
        When it is no number, or of another quantity. NaN and infinities pass.
    """
    try:
        return float(text)
    except ValueError:
        match = _QUANTITY.fullmatch(text.strip())
    value = None if match is None else converted(float(match[1]), match[2], unit)
    if value is None:
        raise InputError(f"must be a number of {unit}, got {text!r:.60}")
    return value


class Targets(NamedTuple):
    """Margins, as shares of the fastest running time, and running times, s."""

    margin: tuple[float, ...]
    time_s: tuple[float, ...]


def parse_targets(text: str) -> Targets:
    """Read a list of points with commas between them.

    Each is a margin over the fastest run in percent (``5%``), or a running time in seconds (``1050s``) or on the clock
    (``17:30`` min:s, ``1:07:30`` h:min:s, decimals of the seconds allowed).

    Raises
    ------
    InputError
        When a part is none of these.
    """
    margin, time_s = [], []
    for part in (part.strip() for part in text.split(",")):
        if match := _MARGIN.fullmatch(part):
            margin.append(float(match[1]) / 100.0)
        elif match := _SECONDS.fullmatch(part):
            time_s.append(float(match[1]))
        elif match := _CLOCK.fullmatch(part):
            time_s.append(_clock_s(match[1], match[2], match[3], part))
        else:
            raise InputError(f"at: must be {_GRAMMAR}, got {part!r:.40}")
    if not all(map(math.isfinite, (*margin, *time_s))):
        raise InputError(f"at: must be finite, got {text!r:.40}")
    if not all(time > 0.0 for time in time_s):
        raise InputError(f"at: running times must be above 0 s, got {text!r:.40}")
    return Targets(tuple(margin), tuple(time_s))


def _clock_s(hours: str | None, minutes: str, seconds: str, part: str) -> float:
    if float(seconds) >= SECONDS_PER_MINUTE or (hours is not None and float(minutes) >= SECONDS_PER_MINUTE):
        raise InputError(f"at: minutes after hours and seconds must be below 60, got {part!r:.40}")
    return (float(hours or 0) * SECONDS_PER_MINUTE + float(minutes)) * SECONDS_PER_MINUTE + float(seconds)
