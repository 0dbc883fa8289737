"""What ``tgvdp search`` is asked for: the case from files and names, and its options beside the command line's."""

from typing import TYPE_CHECKING, Any, NamedTuple

import click

from tgvdp.cli.search_options import DEFAULT_TRACK, DEFAULT_TRAIN
from tgvdp.constants import METHODS
from tgvdp.errors import InputError
from tgvdp.options.search import BY_FIELD, excluded_by

if TYPE_CHECKING:
    from tgvdp.model.energy import EnergyMap
    from tgvdp.model.track import Track
    from tgvdp.model.train import Train
    from tgvdp.report.provenance import Input


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
    foreign = [name for name in {**held, **given} if method not in BY_FIELD[name].methods]
    for name in foreign:
        belongs = f"belongs to method {' and '.join(BY_FIELD[name].methods)}, not to {method}"
        if name in given:
            raise click.UsageError(f"{BY_FIELD[name].flag} {belongs}", click.get_current_context())
        if "method" not in given:
            raise InputError(f"{scenario}: run.{name}: {belongs}")
    return {name: value for name, value in held.items() if name not in foreign}


def merged(held: dict[str, Any], given: dict[str, Any]) -> dict[str, Any]:
    """Options of a scenario and of the command line, which wins; some exclude each other."""
    for name in given:
        for other in excluded_by(BY_FIELD[name]):
            if other.field in given:
                raise click.UsageError(
                    f"{BY_FIELD[name].flag} and {other.flag} exclude each other", click.get_current_context()
                )

    def ousted(name: str) -> bool:
        rivals = {one.field for one in excluded_by(BY_FIELD[name])}
        return bool(rivals & set(given)) or any(BY_FIELD[name] in excluded_by(BY_FIELD[one]) for one in given)

    return {name: value for name, value in held.items() if not ousted(name)} | given
