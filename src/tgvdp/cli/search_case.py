"""What ``tgvdp search`` is asked for: the case from files and names, and options as arguments of the search."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from tgvdp.cli.search_options import DEFAULT_TRACK, DEFAULT_TRAIN
from tgvdp.constants import METHOD_OPTIONS, METHODS
from tgvdp.errors import InputError
from tgvdp.units import kmh_to_mps

if TYPE_CHECKING:
    from tgvdp.model.energy import EnergyMap
    from tgvdp.model.track import Track
    from tgvdp.model.train import Train
    from tgvdp.report.provenance import Input


def _percent_to_fraction(percent: float) -> float:
    return percent / 100.0


#: Option of the command line and of scenario files → argument of `tgvdp.search` and how its unit changes.
_ARGUMENTS: dict[str, tuple[str, Callable[[Any], Any] | None]] = {
    "from_m": ("origin_m", None),
    "to_m": ("destination_m", None),
    "start_speed_kmh": ("start_speed_mps", kmh_to_mps),
    "end_speed_kmh": ("end_speed_mps", kmh_to_mps),
    "energy": ("energy", None),
    "convention": ("convention", None),
    "mass_model": ("mass_model", None),
    "limits": ("limits", None),
    "curves": ("curves", None),
    "tunnels": ("tunnels", None),
    "method": ("method", None),
    "points": ("points", None),
    "max_margin_pct": ("max_margin", _percent_to_fraction),
    "max_time_s": ("max_time_s", None),
    "paths": ("paths", None),
    "heuristic": ("heuristic", None),
    "segment_m": ("segment_m", None),
    "speeds": ("speeds", None),
    "dominance": ("dominance", None),
    "bounds": ("bounds", None),
    "max_labels": ("max_labels", None),
    "time_limit_s": ("time_limit_s", None),
}


class Case(NamedTuple):
    """Train, line and map, the options that came with them, and where each was read from."""

    train: "Train"
    track: "Track"
    map: "EnergyMap | None"
    options: dict[str, Any]
    inputs: dict[str, "Input"]  # by role: what was read from a file of its own, or the values


def read_case(train: str | None, track: str | None, scenario: str | None) -> Case:
    """Read what the command line names, then what the scenario holds, then the defaults."""
    from tgvdp.formats import Scenario, load_scenario, load_track, load_train
    from tgvdp.formats.sources import locate

    held = Scenario(name="", format="") if scenario is None else load_scenario(scenario)
    inputs: dict[str, Input] = {} if scenario is None else {"scenario": locate(scenario)}
    if train is None and held.train is not None:
        the_train = inputs["train"] = held.train
    else:
        train = DEFAULT_TRAIN if train is None else train
        inputs["train"] = locate(train, "train")
        the_train = load_train(train)
    if track is None and held.track is not None:
        the_track = inputs["track"] = held.track
    else:
        track = DEFAULT_TRACK if track is None else track
        inputs["track"] = locate(track, "track")
        the_track = load_track(track)
    return Case(the_train, the_track, held.map, held.options, inputs)


def read_map(options: dict[str, Any], case: Case) -> None:
    """Put the energy map that is asked for in place of its name: the scenario's own, one of the catalog, or a file."""
    from tgvdp.formats import load_energy_map
    from tgvdp.formats.sources import source_path
    from tgvdp.model.energy import BUILT_IN_MAP

    name = options.get("energy", "wheel")
    if name in ("wheel", "pantograph"):
        return
    if name == "map" and case.map is not None:
        options["energy"] = case.inputs["map"] = case.map
        return
    path = case.inputs["map"] = source_path(BUILT_IN_MAP if name == "map" else name, "map")
    options["energy"] = load_energy_map(path)


def suited(held: dict[str, Any], given: dict[str, Any], scenario: str | None) -> dict[str, Any]:
    """Options of a scenario that the method has; others are an error, unless the command line chose another method."""
    method = given.get("method", held.get("method", METHODS[0]))
    foreign = {name: owners for name in {**held, **given} if method not in (owners := _owners(name))}
    context = click.get_current_context()
    for name, owners in foreign.items():
        if name in given:
            flag = next(parameter.opts[0] for parameter in context.command.params if parameter.name == name)
            raise click.UsageError(f"{flag} belongs to method {' and '.join(owners)}, not to {method}", context)
        if "method" not in given:
            raise InputError(f"{scenario}: run.{name}: belongs to method {' and '.join(owners)}, not to {method}")
    return {name: value for name, value in held.items() if name not in foreign}


def _owners(option: str) -> tuple[str, ...]:
    """Methods that have an option."""
    argument = "at_s" if option == "at" else _ARGUMENTS[option][0]
    return METHOD_OPTIONS.get(argument, METHODS)


def merged(held: dict[str, Any], given: dict[str, Any]) -> dict[str, Any]:
    """Options of a scenario and of the command line, which wins; --at and an even front exclude each other."""
    even = ("points", "max_margin_pct")
    if "at" in given:
        for name in even:
            if name in given:
                option = name.removesuffix("_pct").replace("_", "-")
                raise click.UsageError(f"--at and --{option} exclude each other", click.get_current_context())
        held = {name: value for name, value in held.items() if name not in even}
    elif any(name in given for name in even):
        held = {name: value for name, value in held.items() if name != "at"}
    return held | given


def arguments_of(options: Mapping[str, Any]) -> dict[str, Any]:
    """Turn options in the units of people into arguments of the search, in SI; what is absent keeps its default."""
    from tgvdp.formats.native.points import parse_targets

    arguments: dict[str, Any] = {}
    for name, value in options.items():
        if name == "at":
            arguments["at_margin"], arguments["at_s"] = parse_targets(value)
            continue
        argument, convert = _ARGUMENTS[name]
        arguments[argument] = value if convert is None else convert(value)
    return arguments
