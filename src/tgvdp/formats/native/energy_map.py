"""Maps of the power drawn from the line over speed and demand: the ``map`` table of the native format."""

from msgspec import Struct

from tgvdp.formats.syntax.typed import Finite
from tgvdp.model.energy import EnergyMap
from tgvdp.units import KILO, kmh_to_mps


class MapSpec(Struct, forbid_unknown_fields=True):
    """Nodes of speed and demand, and a row of powers for each speed."""

    speed_kmh: list[Finite]
    demand: list[Finite]
    power_kw: list[list[Finite]]
    name: str = ""
    notes: list[str] = []


def make_map(spec: MapSpec, name: str) -> EnergyMap:
    """Make the map of a native file, which names it where the table does not; raises `InputError`."""
    return EnergyMap(
        name=spec.name or name,
        speed_mps=tuple(map(kmh_to_mps, spec.speed_kmh)),
        demand=tuple(spec.demand),
        power_w=tuple(tuple(KILO * value for value in row) for row in spec.power_kw),
        notes=tuple(spec.notes),
    )
