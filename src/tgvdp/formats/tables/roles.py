"""What a column of a table can mean, and the words that name it in the languages of those who write such tables."""

from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.formats.tables.headers import split
from tgvdp.units import to_si


class Role(NamedTuple):
    """What a column can mean: its quantity, words that name it, and how a header is written.

    ``weak`` are those of its words that name it only where no column has another one: a speed beside a speed limit is
    none.
    """

    name: str
    quantity: str
    words: frozenset[str]
    weak: frozenset[str]
    example: str


def _role(name: str, quantity: str, words: str, example: str, weak: str = "") -> Role:
    gives_way = frozenset(filter(None, weak.split(", ")))
    return Role(name, quantity, frozenset(words.split(", ")) | gives_way, gives_way, example)


#: Names of a column that need no unit, as they are one.
_OWN_UNIT = {"km": "km", "kilometer": "km", "kilometre": "km", "streckenkilometer": "km"}

POSITION = _role(
    "position", "length",
    "position, pos, chainage, stationing, kilometrage, mileage, distance, km, kp, pk, s, from, start, begin, "
    "start position, start chainage, start distance, kilometer, kilometre, streckenkilometer, von, anfang, beginn, "
    "weg, stationierung, kilometrierung, point kilométrique, abscisse, début, progressiva",
    "position_m or Position [km]",
)  # fmt: skip
END = _role(
    "end", "length", "to, end, until, end position, end chainage, end distance, bis, ende, fin", "to_m or To [km]"
)
SPEED = _role(
    "speed", "speed",
    "speed limit, limit, speedlimit, max speed, maximum speed, line speed, permitted speed, allowed speed, "
    "permissible speed, max velocity, vmax, v max, v limit, v lim, höchstgeschwindigkeit, zulässige geschwindigkeit, "
    "streckengeschwindigkeit, vitesse limite, vitesse max, vitesse maximale",
    "speed_kmh or Speed limit [km/h]",
    weak="speed, velocity, v, geschwindigkeit, vitesse, velocità, velocidad",
)  # fmt: skip
GRADIENT = _role(
    "gradient", "gradient",
    # "Gefälle", "pente" and the like count downhill for some.
    "gradient, slope, grade, inclination, neigung, längsneigung, steigung, déclivité, pendenza",
    "gradient_permil or Gradient [‰]",
)  # fmt: skip
RADIUS = _role(
    "radius", "length",
    "radius, curve radius, r, kurvenradius, bogenradius, bogenhalbmesser, halbmesser, rayon, raggio",
    "radius_m or Radius [m]",
)  # fmt: skip
STOP = _role(
    "stop", "", "stop, stops, halt, stop name, haltestelle, arrêt, fermata", "stop",
    weak="station, station name, bahnhof, gare, stazione, estación",
)  # fmt: skip

#: Where a train stops, and when: a table with one of these is a timetable.
ARRIVAL = _role(
    "arrival", "time",
    "arrival, arrival time, arr, arrives, scheduled arrival, ankunft, ankunftszeit, arrivée, heure d'arrivée, arrivo, "
    "llegada",
    "arrival",
)  # fmt: skip
DEPARTURE = _role(
    "departure", "time",
    "departure, departure time, dep, departs, scheduled departure, abfahrt, abfahrtszeit, départ, heure de départ, "
    "partenza, salida",
    "departure",
)  # fmt: skip

_TRACTION = "tractive effort, tractive force, traction effort, traction force, traction, zugkraft, effort de traction"
_BRAKING = "braking effort, braking force, brake effort, brake force, braking, bremskraft, effort de freinage"
_EFFORT = "effort, force, f, z, kraft"
#: Effort of traction or braking: the two may stand in one table, and a curve that is of neither may serve for both.
EFFORT = {
    "traction": _role("tractive effort", "force", _TRACTION, "effort_kn or Effort [kN]", weak=_EFFORT),
    "braking": _role("braking effort", "force", _BRAKING, "effort_kn or Effort [kN]", weak=_EFFORT),
}


def is_weak(header: str, role: Role) -> bool:
    """Whether a header that names a role gives way to others that do."""
    return split(header)[0] in role.weak


def unit_text(header: str, role: Role) -> str | None:
    """Unit text of a header that names a role, empty without one; None when it names another thing."""
    name, unit = split(header) if role.quantity else (split(f"{header} []")[0], "")
    return (unit or _OWN_UNIT.get(name, "")) if name in role.words else None


def unit_of(header: str, role: Role) -> str:
    """Unit of a column as its header gives it; empty where it needs none, as marks and times of day do.

    Raises
    ------
    InputError
        When it is missing or does not fit.
    """
    if not role.quantity:
        return ""
    unit = unit_text(header, role)
    if not unit and role.quantity == "time":
        return ""
    if not unit:
        raise InputError(f"give its unit in the header, such as {role.example}")
    to_si(1.0, unit, role.quantity)
    return unit
