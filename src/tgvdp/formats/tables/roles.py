"""What a column of a table can mean, and how its header says that and its unit."""

import re
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.units import to_si


class Role(NamedTuple):
    """What a column can mean: its quantity, words that name it, and how a header is written."""

    name: str
    quantity: str
    words: frozenset[str]
    example: str


def _role(name: str, quantity: str, words: str, example: str) -> Role:
    return Role(name, quantity, frozenset(words.split(", ")), example)


POSITION = _role(
    "position", "length",
    "position, pos, chainage, stationing, kilometrage, mileage, distance, km, kp, pk, s, from, start, begin",
    "position_m or Position [km]",
)  # fmt: skip
END = _role("end", "length", "to, end, until", "to_m or To [km]")
SPEED = _role(
    "speed", "speed", "speed limit, limit, speed, max speed, maximum speed, line speed, vmax, v max, v",
    "speed_kmh or Speed limit [km/h]",
)  # fmt: skip
GRADIENT = _role("gradient", "gradient", "gradient, slope, grade, inclination", "gradient_permil or Gradient [‰]")
RADIUS = _role("radius", "length", "radius, curve radius, r", "radius_m or Radius [m]")
STOP = _role("stop", "", "stop, stops, station, halt, stop name", "stop")
EFFORT = _role(
    "effort", "force", "effort, tractive effort, braking effort, force, tractive force, braking force, traction, f, z",
    "effort_kn or Effort [kN]",
)  # fmt: skip

#: How people write a unit in a header, in small letters → as `tgvdp.units` knows it.
_UNITS = {
    "m": "m", "km": "km", "km/h": "km/h", "kmh": "km/h", "kph": "km/h", "kmph": "km/h", "m/s": "m/s", "mps": "m/s",
    "n": "N", "kn": "kN", "permil": "‰", "‰": "‰", "per mille": "‰", "o/oo": "‰", "promille": "‰", "percent": "%",
    "%": "%", "pct": "%",
}  # fmt: skip
_BRACKETED = re.compile(r"(.*?)\s*[\[(]\s*(?:in\s+)?(.*?)\s*[\])]\s*")
_SEPARATED = re.compile(r"(.*?)[\s_]+(?:in[\s_]+)?(per mille|[^\s_]+)")


def unit_text(header: str, role: Role) -> str | None:
    """Unit text of a header that names a role, empty without one; None when it names another thing."""
    text = re.sub(r"\s+", " ", header.strip().lower()).replace("km_h", "km/h").replace("m_s", "m/s")
    name, unit = text, "km" if text == "km" else ""
    for pattern in (_BRACKETED, _SEPARATED):
        match = pattern.fullmatch(text)
        if match and role.quantity and (pattern is _BRACKETED or match[2] in _UNITS):
            name, unit = match[1], match[2]
            break
    return unit if re.sub(r"[-_ ]+", " ", name).strip() in role.words else None


def unit_of(header: str, role: Role) -> str:
    """Unit of a column as its header gives it; empty where it needs none.

    Raises
    ------
    InputError
        When it is missing or does not fit.
    """
    if not role.quantity:
        return ""
    text = unit_text(header, role)
    if not text:
        raise InputError(f"give its unit in the header, such as {role.example}")
    unit = _UNITS.get(text, text)
    to_si(1.0, unit, role.quantity)
    return unit
