"""``tgvdp search``: the Pareto front of one trip, as files, a table or one JSON object."""

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from tgvdp.cli.journeys import read_section
from tgvdp.cli.numbers import number
from tgvdp.cli.screen import Screen, energy_table, front_table
from tgvdp.constants import (
    CONVENTION_NAMES,
    CURVE_FORMULAS,
    HEURISTICS,
    LIMIT_RULES,
    MASS_MODELS,
    METHOD_OPTIONS,
    METHODS,
)
from tgvdp.errors import BudgetExceededError, InputError
from tgvdp.units import kmh_to_mps

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

    from tgvdp.model.energy import EnergyMap
    from tgvdp.model.track import Track
    from tgvdp.model.train import Train
    from tgvdp.report.provenance import Input

DEFAULT_TRAIN = "tgv"
PROFILE_FORMATS = ("csv", "parquet", "railtoolkit")
_PROFILES_HELP = "Format of the speed profiles; railtoolkit is the driving course that TrainRuns.jl prints."
DEFAULT_TRACK = "lgv-100km"
_PATHS_HELP = "best-first: stop after so many complete paths.  [default: 100]"
_TRAIN_HELP = f"Train: a file, or a name of the catalog.  [default: {DEFAULT_TRAIN}]"
_TRACK_HELP = f"Line: a file, or a name of the catalog.  [default: {DEFAULT_TRACK}]"
_AT_HELP = (
    "front: points exactly there instead: margins (5%) or running times (1050s, 17:30, 1:07:30), with commas between."
)
_ENERGY_HELP = (
    "What is minimised: wheel, pantograph, or a map of the power drawn: a file, a name of the catalog, or map for that"
    " of the scenario, else alstom-map.  [default: wheel]"
)
_MARGIN_HELP = "Longest running time, above the fastest run's.  [default: 25]"
_CONVENTION_HELP = "Whose reading of the line: gravity and the four switches below.  [default: ttobench]"
_MASS_HELP = "Gradients and curves act at the head, or averaged over the length.  [default: the convention's]"
_LIMITS_HELP = "A higher speed limit counts once the head, or the tail, has passed it."
_CURVES_HELP = "Formula of curve resistance."

_JOURNEY_HELP = "From the journey's section N (default: 1): origin, destination, and the longest running time."

_EXAMPLES = """
\b
Examples:
  tgvdp search
  tgvdp search --track line.json --train train.json --from 12000 --to 43500
  tgvdp search --scenario trip.toml --points 20 --out trip
  tgvdp search --train stock.yaml#RB50 --track line.json --journey journey.json#2
  tgvdp search --at "3%,5%,10%"
  tgvdp search --train alstom-emu --track flat-100km --energy pantograph
  tgvdp search --track flat-100km --at 26:00,27:30
  tgvdp search --method exact --segment 1000 --speeds 30
  tgvdp search --method best-first --paths 10 --heuristic ratio --time-limit 10
  tgvdp search --json --quiet > result.json
"""


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


def _targets(_: click.Context, parameter: click.Parameter, text: str | None) -> str | None:
    """Check what --at asks for."""
    from tgvdp.formats.targets import parse_targets

    if text is not None:
        try:
            parse_targets(text)
        except InputError as error:
            raise click.BadParameter(str(error).removeprefix(f"{parameter.name}: ")) from None
    return text


def _complete(_: click.Context, parameter: click.Parameter, incomplete: str) -> "list[CompletionItem]":
    """Complete names of the catalog where the option takes them, and files."""
    from click.shell_completion import CompletionItem

    from tgvdp.model import catalog
    from tgvdp.model.energy import ENERGY_KINDS

    wanted = "map" if parameter.name == "energy" else parameter.name
    names = [name for kind in catalog.KINDS if kind == wanted for name in catalog.names(kind)]
    if parameter.name == "energy":
        names += ENERGY_KINDS
    items = [CompletionItem(name) for name in names if name.startswith(incomplete)]
    return [*items, CompletionItem(incomplete, type="file")]


@click.command("search", epilog=_EXAMPLES)
@click.option("--track", metavar="FILE|NAME", shell_complete=_complete, help=_TRACK_HELP)
@click.option("--train", metavar="FILE|NAME", shell_complete=_complete, help=_TRAIN_HELP)
@click.option(
    "--scenario",
    metavar="FILE",
    shell_complete=_complete,
    help="Train, line and options in one file; the command line wins over it.",
)
@click.option("--journey", metavar="FILE[#N]", shell_complete=_complete, help=_JOURNEY_HELP)
@click.option("--from", "from_m", metavar="M", type=number("m", at_least=0.0), help="Origin on the line.  [default: 0]")
@click.option("--to", "to_m", metavar="M", type=number("m"), help="Destination on the line.  [default: its end]")
@click.option("--start-speed", "start_speed_kmh", metavar="KMH", type=number("km/h", at_least=0.0), help="[default: 0]")
@click.option("--end-speed", "end_speed_kmh", metavar="KMH", type=number("km/h", at_least=0.0), help="[default: 0]")
@click.option("--energy", metavar="MODEL", shell_complete=_complete, help=_ENERGY_HELP)
@click.option("--convention", type=click.Choice(CONVENTION_NAMES), help=_CONVENTION_HELP)
@click.option("--mass-model", type=click.Choice(MASS_MODELS), help=_MASS_HELP)
@click.option("--limits", type=click.Choice(LIMIT_RULES), help=_LIMITS_HELP)
@click.option("--curves", type=click.Choice(CURVE_FORMULAS), help=_CURVES_HELP)
@click.option("--tunnels/--no-tunnels", default=None, help="Count the train's drag in tunnels.")
@click.option("--method", type=click.Choice(METHODS), help="How to search.  [default: front]")
@click.option("--points", metavar="N", type=click.IntRange(min=2), help="front: number of points.  [default: 60]")
@click.option("--max-margin", "max_margin_pct", metavar="PCT", type=number("%", above=0.0), help=_MARGIN_HELP)
@click.option("--at", metavar="LIST", callback=_targets, help=_AT_HELP)
@click.option("--paths", metavar="N", type=click.IntRange(min=1), help=_PATHS_HELP)
@click.option("--heuristic", type=click.Choice(HEURISTICS), help="best-first: what orders the queue.  [default: ratio]")
@click.option(
    "--segment",
    "segment_m",
    metavar="M",
    type=number("m", above=0.0),
    help="exact, best-first: largest segment of the grid.  [default: a 40th, a 20th of the trip]",
)
@click.option(
    "--speeds", metavar="N", type=click.IntRange(min=2), help="exact, best-first: number of speeds.  [default: 40, 20]"
)
@click.option(
    "--dominance/--no-dominance", default=None, help="best-first: drop dominated paths.  [default: dominance]"
)
@click.option(
    "--bounds/--no-bounds", default=None, help="best-first: prune by bounds of the cost to go.  [default: bounds]"
)
@click.option(
    "--max-labels", metavar="N", type=click.IntRange(min=1), help="exact, best-first: end after so many partial paths."
)
@click.option(
    "--time-limit", "time_limit_s", metavar="S", type=number("s", above=0.0), help="End after so many seconds."
)
@click.option("--certify/--no-certify", default=True, show_default=True, help="Prove how far the optimum can be.")
@click.option("--profiles", type=click.Choice(PROFILE_FORMATS), default="csv", show_default=True, help=_PROFILES_HELP)
@click.option("--out", metavar="DIR", default="out", show_default=True, help="Folder of the results.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object on stdout, everything else on stderr.")
@click.option("--quiet", is_flag=True, help="Print nothing but errors and what --json asks for.")
def command(
    track: str | None,
    train: str | None,
    scenario: str | None,
    journey: str | None,
    certify: bool,
    profiles: str,
    out: str,
    as_json: bool,
    quiet: bool,
    **given: Any,
) -> int:
    """Search the Pareto front of delay against energy for one trip.

    Writes result.json, front.csv, profiles.csv and pictures into a folder. Options marked front, exact or best-first
    belong to these methods; the last two search a grid. A search that ends by its budget writes what it has, labelled
    as partial, and exits with code 5.
    """
    from tgvdp.report import check_writable, make_provenance, result_object, write_results

    if journey is not None and track is None and scenario is None:
        raise click.UsageError("--journey needs the --track that it belongs to", click.get_current_context())
    check_writable(out)
    with Screen(quiet=quiet) as screen:
        case = _read_case(train, track, scenario)
        asked = {name: value for name, value in given.items() if value is not None}
        options = _merged(_suited(case.options, asked, scenario), asked)
        _read_map(options, case)
        section = None if journey is None else read_section(journey, case.track, case.inputs, options, given)
        screen.progress(f"searching: {case.train.name} on {case.track.name}")
        from tgvdp import api  # brings numba: neither --help nor an error in the input waits for it

        result = api.search(case.train, case.track, **_arguments(options))
        if section is not None:
            result = replace(result, warnings=(*result.warnings, *section.broken_by(result.fastest.time_s)))
        screen.progress("replaying")
        replaying_s = time.perf_counter()
        verdicts = result.verify()
        checks_s = {"verify": time.perf_counter() - replaying_s}
        certificate = None
        if certify:
            screen.progress("proving")
            proving_s = time.perf_counter()
            certificate = result.certify()
            checks_s["certify"] = time.perf_counter() - proving_s
        screen.progress("drawing and writing")
        provenance = make_provenance(result.options, case.inputs, result.elapsed_s, checks_s)
        files = write_results(result, out, provenance, verdicts, certificate, profiles)

    content = result_object(result, verdicts, provenance, certificate)
    if as_json:
        click.echo(json.dumps(content, ensure_ascii=False, allow_nan=False))
    if not quiet:
        click.echo(f"{case.train.name} on {case.track.name}", err=as_json)
        click.echo(front_table(content), err=as_json)
        if where := energy_table(content):
            click.echo(where, err=as_json)
        click.echo(f"in {out}: {', '.join(file.name for file in files)}", err=as_json)
    return _judge(content, quiet)


class _Case(NamedTuple):
    train: "Train"
    track: "Track"
    map: "EnergyMap | None"
    options: dict[str, Any]
    inputs: dict[str, "Input"]  # by role: what was read from a file of its own, or the values


def _read_case(train: str | None, track: str | None, scenario: str | None) -> _Case:
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
    return _Case(the_train, the_track, held.map, held.options, inputs)


def _read_map(options: dict[str, Any], case: _Case) -> None:
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


def _suited(held: dict[str, Any], given: dict[str, Any], scenario: str | None) -> dict[str, Any]:
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


def _merged(held: dict[str, Any], given: dict[str, Any]) -> dict[str, Any]:
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


def _arguments(options: Mapping[str, Any]) -> dict[str, Any]:
    """Turn options in the units of people into arguments of the search, in SI; what is absent keeps its default."""
    from tgvdp.formats.targets import parse_targets

    arguments: dict[str, Any] = {}
    for name, value in options.items():
        if name == "at":
            arguments["at_margin"], arguments["at_s"] = parse_targets(value)
            continue
        argument, convert = _ARGUMENTS[name]
        arguments[argument] = value if convert is None else convert(value)
    return arguments


def _judge(content: Mapping[str, Any], quiet: bool) -> int:
    """Exit code of a result, and a word on stderr where it is not all that was asked for."""
    failed = [str(point["id"]) for point in content["front"] if not point["replay"]["ok"]]
    if failed:
        click.echo(f"tgvdp: warning: points {', '.join(failed)} do not pass the replay", err=True)
    if content["complete"]:
        if "warning" in content and not quiet:
            click.echo(f"tgvdp: warning: {content['warning']}", err=True)
        return 0
    click.echo(f"tgvdp: budget reached: {content['warning']}", err=True)
    return BudgetExceededError.exit_code
