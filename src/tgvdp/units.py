"""The only place where a unit changes: SI inside, the field's customary units at the edges."""

import math

from tgvdp.errors import InputError

#: What people may write, in whatever unit: in SI it stays far from where arithmetic ends (`tgvdp.model.checks`).
LARGEST_WRITTEN = 1e12
#: ... where it must be above 0.
SMALLEST_WRITTEN = 1e-12

KMH_PER_MPS = 3.6
JOULE_PER_KWH = 3.6e6
SECONDS_PER_MINUTE = 60.0
KILO = 1000.0

#: How a unit becomes SI, by quantity: multiply by the first number and divide by the second. Two numbers, because
#: km/h / 3.6 is exact for round speeds and km/h · 0.2777… is not. A gradient stays in ‰, a ratio is a plain number.
_TO_SI: dict[str, dict[str, tuple[float, float]]] = {
    "length": {"m": (1.0, 1.0), "km": (1000.0, 1.0)},
    "area": {"m^2": (1.0, 1.0)},
    "speed": {"m/s": (1.0, 1.0), "km/h": (1.0, 3.6)},
    "time": {"s": (1.0, 1.0), "min": (60.0, 1.0), "h": (3600.0, 1.0)},
    "acceleration": {"m/s^2": (1.0, 1.0)},
    "mass": {"kg": (1.0, 1.0), "t": (1000.0, 1.0)},
    "force": {"N": (1.0, 1.0), "kN": (1000.0, 1.0)},
    "power": {"W": (1.0, 1.0), "kW": (1000.0, 1.0), "MW": (1e6, 1.0)},
    "force per speed": {
        "N/(m/s)": (1.0, 1.0),
        "kN/(m/s)": (1000.0, 1.0),
        "N/(km/h)": (3.6, 1.0),
        "kN/(km/h)": (3600.0, 1.0),
    },
    "force per squared speed": {
        "N/(m/s)^2": (1.0, 1.0),
        "kN/(m/s)^2": (1000.0, 1.0),
        "N/(km/h)^2": (12.96, 1.0),
        "kN/(km/h)^2": (12960.0, 1.0),
        "kg/m": (1.0, 1.0),
    },
    "gradient": {"permil": (1.0, 1.0), "‰": (1.0, 1.0), "%": (10.0, 1.0)},
    "memory": {"B": (1.0, 1.0), "MB": (1e6, 1.0), "GB": (1e9, 1.0)},
    "ratio": {"-": (1.0, 1.0), "%": (1.0, 100.0)},
}


def to_si(value: float, unit: str, quantity: str) -> float:
    """Convert a value from the unit that a file names.

    Parameters
    ----------
    value : float
    unit : str
        As in the file; ``²`` and ``^2`` are the same.
    quantity : str
        One of length, area, speed, time, acceleration, mass, force, power, force per speed, force per squared speed,
        gradient (result in ‰), memory, ratio.

    Raises
    ------
    InputError
        When the unit is not one of that quantity, or the value is beyond sense in any unit; infinities pass.
    """
    known = _TO_SI[quantity]
    factors = known.get(unit.replace("²", "^2"))
    if factors is None:
        raise InputError(f"unknown unit {unit!r:.40} of {quantity}; known: {', '.join(known)}")
    if abs(value) > LARGEST_WRITTEN and math.isfinite(value):
        raise InputError(f"must be within ±{LARGEST_WRITTEN:g} {unit}, got {value:g} {unit}")
    return value * factors[0] / factors[1]


def from_si(value: float, unit: str, quantity: str) -> float:
    """Convert a value to a unit; the inverse of `to_si`."""
    factors = _TO_SI[quantity][unit]
    return value * factors[1] / factors[0]


def converted(value: float, unit: str, wanted: str) -> float | None:
    """Convert a value to another unit of the same quantity; None where the two have none in common."""
    for quantity, known in _TO_SI.items():
        if unit in known and wanted in known:
            return value if unit == wanted else from_si(to_si(value, unit, quantity), wanted, quantity)
    return None


def kmh_to_mps(speed_kmh: float) -> float:
    """Convert km/h to m/s."""
    return speed_kmh / KMH_PER_MPS


def mps_to_kmh(speed_mps: float) -> float:
    """Convert m/s to km/h."""
    return speed_mps * KMH_PER_MPS


def per_kmh_to_per_mps(value: float, power: int = 1) -> float:
    """Convert a coefficient of V**power, V in km/h, to one of v**power, v in m/s."""
    # Rounded powers: 3.6**2 in binary is 12.960000000000001.
    return value * (1.0, 3.6, 12.96, 46.656)[power]


def joule_to_kwh(energy_j: float) -> float:
    """Convert J to kWh."""
    return energy_j / JOULE_PER_KWH


def counted(count: int, noun: str) -> str:
    """A number of things in words: 1 step, 2 steps."""
    return f"{count} {noun}{'' if count == 1 else 's'}"
