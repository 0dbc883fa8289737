"""Options of a search: what they mean, and which are refused."""

from typing import Any

from tgvdp.constants import HEURISTICS, METHOD_OPTIONS, METHODS
from tgvdp.errors import InfeasibleError, InputError
from tgvdp.formats import load_energy_map
from tgvdp.model.checks import require_number
from tgvdp.model.energy import BUILT_IN_MAP, ENERGY_KINDS, EnergyMap, EnergyModel


def check_options(method: str, points: int, max_margin: float, paths: int, heuristic: str) -> None:
    """Refuse options that are unknown or out of range."""
    if method not in METHODS:
        raise InputError(f"search: method must be one of {', '.join(METHODS)}, got {method!r}")
    if heuristic not in HEURISTICS:
        raise InputError(f"search: heuristic must be one of {', '.join(HEURISTICS)}, got {heuristic!r}")
    for name, count, least in (("points", points, 2), ("paths", paths, 0)):
        require_number("search", name, count, name, at_least=least)
        if count != int(count):
            raise InputError(f"search: {name} must be a whole number, got {count:g}")
    require_number("search", "max_margin", max_margin, "of the fastest running time", above=0.0)


def check_effect(options: dict[str, Any], defaults: dict[str, Any]) -> None:
    """Refuse options that would change nothing; one that is set to its default asks for nothing."""
    method = options["method"]
    changed = {name for name, value in options.items() if value != defaults[name]}
    for name in METHOD_OPTIONS:
        if name in changed and method not in METHOD_OPTIONS[name]:
            owners = " and ".join(METHOD_OPTIONS[name])
            raise InputError(f"search: {name} belongs to method {owners}, it has no effect on {method}")
    if changed & {"at_s", "at_margin"} and changed & {"points", "max_margin"}:
        even = " and ".join(sorted(changed & {"points", "max_margin"}))
        raise InputError(f"search: at_s and at_margin say where the points are, so {even} has no effect")


def margin_of(fastest_s: float, max_margin: float, max_time_s: float | None) -> float:
    """Largest supplement, as a share of the fastest running time."""
    if max_time_s is None:
        return max_margin
    require_number("search", "max_time_s", max_time_s, "s", above=0.0)
    if max_time_s < fastest_s:
        raise InfeasibleError(f"no run takes {max_time_s:.6g} s or less: the fastest one takes {fastest_s:.6g} s")
    return max_time_s / fastest_s - 1.0


def energy_model(energy: str | EnergyMap) -> EnergyModel:
    """Make the energy model that an argument names."""
    if isinstance(energy, EnergyMap):
        return EnergyModel("map", energy)
    if not isinstance(energy, str):
        raise InputError(f"search: energy must be one of {', '.join(ENERGY_KINDS)} or a map, got {energy!r:.60}")
    if energy in ("wheel", "pantograph"):
        return EnergyModel(energy)
    return EnergyModel("map", load_energy_map(BUILT_IN_MAP if energy == "map" else energy))
