"""What people write: quantities (``20km``), speed restrictions, and where they want points (``3%, 1050s, 17:30``)."""

import math
import re
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.model.margin import MarginRange, Supplement
from tgvdp.model.track import SpeedRestriction
from tgvdp.units import SECONDS_PER_MINUTE, converted, kmh_to_mps, to_si

_NUMBER = r"\d+(?:\.\d*)?|\.\d+"
_MARGIN = re.compile(rf"({_NUMBER})\s*%")
_SECONDS = re.compile(rf"({_NUMBER})\s*s")
_CLOCK = re.compile(r"(?:(\d+):)?(\d+):(\d{2}(?:\.\d*)?)")
_PER_LENGTH = re.compile(rf"({_NUMBER})\s*(s|min)\s*/\s*({_NUMBER})?\s*(m|km)")
_ADDED = re.compile(rf"({_NUMBER})\s*(s|min)")
_MARGIN_GRAMMAR = "5%, 4.5min/100km or 90s, with FROM:TO: before it for a range of the line (0:10km:5%)"
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


def parse_restriction(text: str) -> SpeedRestriction:
    """Read a temporary speed restriction, ``FROM:TO:SPEED`` in m, m and km/h or with units: ``50km:52km:80``.

    Raises
    ------
    InputError
        When it is none.
    """
    parts = text.split(":")
    if len(parts) != len(SpeedRestriction._fields):
        raise InputError(f"must be FROM:TO:KMH such as 50km:52km:80, got {text!r:.60}")
    from_m, to_m = (parse_quantity(part, "m") for part in parts[:2])
    speed_kmh = parse_quantity(parts[2], "km/h")
    if not (0.0 <= from_m < to_m < math.inf and 0.0 < speed_kmh < math.inf):
        raise InputError(f"must be FROM:TO:KMH with 0 <= FROM < TO and a speed above 0 km/h, got {text!r:.60}")
    return SpeedRestriction(from_m, to_m, kmh_to_mps(speed_kmh))


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
            raise InputError(f"must be {_GRAMMAR}, got {part!r:.40}")
    if not all(map(math.isfinite, (*margin, *time_s))):
        raise InputError(f"must be finite, got {text!r:.40}")
    if not all(time > 0.0 for time in time_s):
        raise InputError(f"running times must be above 0 s, got {text!r:.40}")
    return Targets(tuple(margin), tuple(time_s))


def parse_margins(text: str) -> tuple[MarginRange, ...]:
    """Read a running-time supplement: ``5%``, ``4.5min/100km`` or ``90s``, of the whole line or by ranges of it.

    Ranges have commas between them: ``0:10km:5%,10km::4.5min/100km``. An end that is left out is that of the run.

    Raises
    ------
    InputError
        When a part is none of these.
    """
    return tuple(_range_of(part.strip()) for part in text.split(","))


def _range_of(part: str) -> MarginRange:
    *ends, value = part.split(":")
    if len(ends) not in (0, 2):
        raise InputError(f"must be {_MARGIN_GRAMMAR}, got {part!r:.60}")
    from_m, to_m = (parse_quantity(end, "m") if end.strip() else None for end in ends or ("", ""))
    return MarginRange(
        0.0 if from_m is None else from_m, math.inf if to_m is None else to_m, _supplement(value.strip())
    )


def _supplement(text: str) -> Supplement:
    if match := _MARGIN.fullmatch(text):
        return Supplement(share=float(match[1]) / 100.0)
    if match := _PER_LENGTH.fullmatch(text):
        length_m = to_si(float(match[3] or 1.0), match[4], "length")
        if length_m > 0.0:
            return Supplement(s_per_m=to_si(float(match[1]), match[2], "time") / length_m)
    if match := _ADDED.fullmatch(text):
        return Supplement(total_s=to_si(float(match[1]), match[2], "time"))
    raise InputError(f"must be {_MARGIN_GRAMMAR}, got {text!r:.60}")


def _clock_s(hours: str | None, minutes: str, seconds: str, part: str) -> float:
    if float(seconds) >= SECONDS_PER_MINUTE or (hours is not None and float(minutes) >= SECONDS_PER_MINUTE):
        raise InputError(f"minutes after hours and seconds must be below 60, got {part!r:.40}")
    return (float(hours or 0) * SECONDS_PER_MINUTE + float(minutes)) * SECONDS_PER_MINUTE + float(seconds)
