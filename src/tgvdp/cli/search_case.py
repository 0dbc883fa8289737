"""What ``tgvdp search`` is asked for: the case from files and names, and its options beside the command line's."""

import os
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import click

from tgvdp.cli.clock import preparing_within
from tgvdp.cli.places import positions_on
from tgvdp.cli.search_options import DEFAULT_TRACK, DEFAULT_TRAIN
from tgvdp.constants import ENERGY_KINDS, METHODS
from tgvdp.errors import InputError
from tgvdp.options.search import BY_FIELD, excluded_by
from tgvdp.units import kmh_to_mps

if TYPE_CHECKING:
    from tgvdp.formats.scenario import Read
    from tgvdp.model.energy import EnergyMap
    from tgvdp.model.track import Track
    from tgvdp.model.train import Train
    from tgvdp.model.trip import Trip
    from tgvdp.options.search import SearchOptions
    from tgvdp.report.provenance import Input


class Case(NamedTuple):
    """Train, line and map, the options that came with them, and where each was read from."""

    train: "Train"
    track: "Track"
    map: "EnergyMap | None"
    options: dict[str, Any]
    inputs: dict[str, "Input"]  # by role: the fingerprint of a file of its own, or the values
    changed: dict[str, Any]  # for the provenance: what was set beside the files
    remarks: tuple[str, ...]  # what the readers of foreign files noted
    line: "Read | None" = None  # what the line was read from, where that is a file of its own

    def with_fields(self, assignments: Sequence[str]) -> "Case":
        """Set fields of train and line, as ``--set`` says."""
        from tgvdp.formats.native.changes import changed

        if not assignments:
            return self
        made = changed(self.train, self.track, assignments)
        inputs = self.inputs | ({"set": made.fingerprint} if made.fingerprint else {})
        told = tuple(dict.fromkeys((*self.remarks, *made.remarks)))
        fields = self.changed | {"set": list(assignments)}
        return self._replace(train=made.train, track=made.track, inputs=inputs, changed=fields, remarks=told)

    def placed(self, options: Mapping[str, Any]) -> dict[str, Any]:
        """Options with positions in place of names of stops, in the direction that they ask for."""
        from tgvdp.model.variants import reversed_track

        return positions_on(reversed_track(self.track) if options.get("reverse") else self.track, options)

    def with_timetable(self, timetable: str, *, reverse: bool = False) -> tuple["Case", "Read"]:
        """Read a timetable, which is one more thing that was read."""
        from tgvdp.formats import read_source
        from tgvdp.model.variants import reversed_track

        read = read_source(timetable, "journey", track=reversed_track(self.track) if reverse else self.track)
        remarks = dict.fromkeys((*self.remarks, *read.remarks))  # it may stand in the file of the line
        return self._replace(inputs=self.inputs | {"journey": read.fingerprint}, remarks=tuple(remarks)), read


def read_case(train: str | None, track: str | None, scenario: str | None, line_speed_kmh: float | None = None) -> Case:
    """Read what the command line names, then what the scenario holds, then the defaults; each file once."""
    from tgvdp.formats import Scenario, read_source

    held = Scenario(name="", format="")
    inputs: dict[str, Input] = {}
    remarks: list[str] = []
    reads: dict[str, Read] = {}
    line_speed_mps = None if line_speed_kmh is None else kmh_to_mps(line_speed_kmh)
    if scenario is not None:
        read = read_source(scenario, line_speed_mps=line_speed_mps if track is None else None)
        held, inputs["scenario"] = read.value, read.fingerprint

    def part(kind: Literal["train", "track"], given: str | None, default: str) -> Any:
        made = getattr(held, kind)
        if given is None and made is not None:
            inputs[kind] = made
            remarks.extend(held.remarks.get(kind, ()))
            return made
        speed_mps = line_speed_mps if kind == "track" else None
        read = read_source(default if given is None else given, kind, line_speed_mps=speed_mps)
        inputs[kind], reads[kind] = read.fingerprint, read
        remarks.extend(read.remarks)
        return read.value

    the_train, the_track = part("train", train, DEFAULT_TRAIN), part("track", track, DEFAULT_TRACK)
    changed = {} if line_speed_kmh is None else {"line_speed_kmh": line_speed_kmh}
    told = tuple(dict.fromkeys(remarks))
    return Case(the_train, the_track, held.map, held.options, inputs, changed, told, reads.get("track"))


def resolved(case: Case, options: "SearchOptions", elapsed_s: float) -> "Trip":
    """The trip that is asked for, its line resolved as far as time allows: a hundred thousand transitions take long."""
    # These bring numba: neither --help nor an error in the input waits for it.
    from tgvdp.api.trip import resolve_line, trip_of

    trip = trip_of(case.train, case.track, options)
    with preparing_within(options.time_limit_s, elapsed_s):
        resolve_line(trip, options.max_memory_b)
    return trip


def read_map(options: dict[str, Any], case: Case) -> None:
    """Put the energy map that is asked for in place of its name: the scenario's own, one of the catalog, or a file."""
    from tgvdp.formats import read_source
    from tgvdp.model.energy import BUILT_IN_MAP

    name = options.get("energy", "wheel")
    if name in ("wheel", "pantograph"):
        return
    if name == "map" and case.map is not None:
        options["energy"] = case.inputs["map"] = case.map
        return
    near = get_close_matches(name.lower(), ENERGY_KINDS, n=1)
    if near and name.isalpha() and name != "map" and not os.path.exists(name):  # no name of the catalog is one word
        raise InputError(f"unknown energy {name!r}, did you mean {near[0]!r}?")
    read = read_source(BUILT_IN_MAP if name == "map" else name, "map")
    options["energy"], case.inputs["map"] = read.value, read.fingerprint


def suited(held: dict[str, Any], given: dict[str, Any], scenario: str | None) -> dict[str, Any]:
    """Options of a scenario that the method has; others are an error, unless the command line chose another method."""
    method = given.get("method", held.get("method", METHODS[0]))
    foreign = [name for name in {**held, **given} if method not in BY_FIELD[name].methods]
    belongs = {name: f"belongs to method {' and '.join(BY_FIELD[name].methods)}, not to {method}" for name in foreign}
    told = [f"{BY_FIELD[name].flag} {belongs[name]}" for name in foreign if name in given]
    if told:
        raise click.UsageError("; ".join(told), click.get_current_context())
    if foreign and "method" not in given:
        raise InputError(f"{scenario}: {'; '.join(f'run.{name}: {belongs[name]}' for name in foreign)}")
    return {name: value for name, value in held.items() if name not in foreign}


def merged(held: dict[str, Any], given: dict[str, Any]) -> dict[str, Any]:
    """Options of a scenario and of the command line, which wins; some exclude each other."""
    for name in given:
        others = ", ".join(other.flag for other in excluded_by(BY_FIELD[name]) if other.field in given)
        if others:
            raise click.UsageError(
                f"{BY_FIELD[name].flag} and {others} exclude each other", click.get_current_context()
            )

    def ousted(name: str) -> bool:
        rivals = {one.field for one in excluded_by(BY_FIELD[name])}
        return bool(rivals & set(given)) or any(BY_FIELD[name] in excluded_by(BY_FIELD[one]) for one in given)

    return {name: value for name, value in held.items() if not ousted(name)} | given
