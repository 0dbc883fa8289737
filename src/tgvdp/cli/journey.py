"""``tgvdp journey``: a train over all stops of a line, and the split of its supplement over the sections."""

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from tgvdp.cli import echo_json
from tgvdp.cli.compare import compare_table
from tgvdp.cli.folder import OutFolder
from tgvdp.cli.groups import GroupedCommand, apply_all, heading
from tgvdp.cli.notes import unusual
from tgvdp.cli.numbers import LINE_SPEED, number
from tgvdp.cli.screen import ROWS, Screen, aligned, column, duration, spread
from tgvdp.cli.search_case import merged, read_case, read_map
from tgvdp.cli.search_options import SET_HELP, TRACK_HELP, TRAIN_HELP, complete, complete_fields, declared
from tgvdp.errors import BudgetExceededError
from tgvdp.options.search import BY_FIELD, JOURNEY_FIELDS, TRIP, arguments_of
from tgvdp.units import joule_to_kwh

if TYPE_CHECKING:
    from tgvdp.api import JourneyResult
    from tgvdp.journeys.bound import JourneyBound
    from tgvdp.journeys.delays import Robustness

_EXAMPLES = """
\b
Examples:
  tgvdp journey --track line.json --train train.json
  tgvdp journey --track line.json --train train.json --dwell 45 --at "5%,8%"
  tgvdp journey --track line.json --train train.json --journey journey.json --out timetable
  tgvdp journey --track line.json --train train.json --train other.json --out trains
  tgvdp journey --track line.json --train train.json --points 100 --json --no-pictures > journey.json
"""
_JOURNEY_HELP = "A timetable: its stops count in place of the line's, its windows are kept."
_DELAY_HELP = "Mean delay of departures: simulates how late and how dear the splits of the middle point are."
_TRAINS_HELP = f"{TRAIN_HELP} May be given several times."
_MAIN = "journey.json"
_SEVERAL, _COMPARED = "tgvdp.journeys/1", ("compare.json", "compare.csv", "compare.png")
_trip = heading(TRIP)
_output = heading("Proof and output")
_OPTIONS = [
    _trip("--track", metavar="FILE|NAME", shell_complete=complete, help=TRACK_HELP),
    _trip("--train", "trains", metavar="FILE|NAME", multiple=True, shell_complete=complete, help=_TRAINS_HELP),
    _trip("--journey", "timetable", metavar="FILE", shell_complete=complete, help=_JOURNEY_HELP),
    _trip(
        "--dwell",
        "dwell_s",
        metavar="S",
        default="30",
        show_default=True,
        type=number("s", at_least=0.0),
        help="Standstill at each stop on the way.",
    ),
    _trip("--line-speed", "line_speed_kmh", **LINE_SPEED),
    _trip("--set", "changes", metavar="FIELD=VALUE", multiple=True, shell_complete=complete_fields, help=SET_HELP),
    *(declared(BY_FIELD[field]) for field in JOURNEY_FIELDS),
    _output("--delay", "mean_delay_s", metavar="S", type=number("s", above=0.0), help=_DELAY_HELP),
    _output("--certify", is_flag=True, help="Prove how far the optimum can be; takes seconds."),
    _output("--pictures/--no-pictures", default=True, show_default=True, help="Draw pictures."),
    _output("--out", metavar="DIR", default="journey", show_default=True, help="Folder of the results."),
    _output("--force", is_flag=True, help="Write into a folder that holds files of others."),
    _output("--json", "as_json", is_flag=True, help="Print one JSON object on stdout, everything else on stderr."),
    _output("--quiet", is_flag=True, help="Print nothing but errors and what --json asks for."),
]


@click.command("journey", cls=GroupedCommand, epilog=_EXAMPLES)
@partial(apply_all, _OPTIONS)
def command(trains: tuple[str, ...], out: str, force: bool, as_json: bool, quiet: bool, **asked: Any) -> int:
    """Run a train over all stops of a line: least energy for each running time, and the best split of the time.

    Each section between two stops has its own front. The journey's front splits the supplement so that one more second
    saves the same in every section; beside it stands what today's practices take. Writes journey.json, front.csv,
    allocation.csv and pictures into a folder; docs/journeys.md says what they hold. Of several trains each has a folder
    of its own in there, beside a table and a picture of who saves what.
    """
    several = len(trains) > 1
    folder = OutFolder(out, _MAIN, force=force)
    homes = [Path(out) / f"train-{number}" for number in range(1, len(trains) + 1)] if several else [Path(out)]
    for home in homes:
        OutFolder(str(home), _MAIN, force=force)
    with Screen(quiet=quiet) as screen:
        done = [_run(screen, train, home, quiet, **asked) for train, home in zip(trains or (None,), homes, strict=True)]
        files = [file for one in done for file in one.files]
        compared = _compared(done, out, files) if several else None
    folder.drop_earlier(files if compared is None else [*files, *compared.files])
    content = {"schema": _SEVERAL, "trains": [{"train": one.result.trip.train.name, **one.content} for one in done]}
    if as_json:
        echo_json(content if several else done[0].content)
    if not quiet:
        click.echo(_table(*done[0][:3]) if compared is None else compare_table(compared.content), err=as_json)
        names = [*(home.name for home in homes), *_COMPARED] if several else [file.name for file in done[0].files]
        click.echo(f"in {out}: {', '.join(names)}", err=as_json)
    for one in done:
        if one.robustness is not None and not quiet:
            click.echo(_robustness_table(one.robustness), err=as_json)
        if one.failed:
            click.echo(f"tgvdp: warning: {one.failed} runs of sections do not pass the replay", err=True)
        for text in () if quiet else _warnings(one):
            click.echo(f"tgvdp: warning: {text}", err=True)
    if compared is not None and "warning" in compared.content and not quiet:
        click.echo(f"tgvdp: warning: {compared.content['warning']}", err=True)
    complete = all(one.result.found.complete and (one.bound is None or one.bound.complete) for one in done)
    return 0 if complete else BudgetExceededError.exit_code


class _Done(NamedTuple):
    """A journey with its object, its proof, its simulation, its files, and how many of its runs do not replay."""

    result: "JourneyResult"
    content: dict[str, Any]
    bound: "JourneyBound | None"
    robustness: "Robustness | None"
    files: list[Path]
    failed: int


def _run(
    screen: Screen,
    train: str | None,
    home: Path,
    quiet: bool,
    *,
    track: str | None,
    timetable: str | None,
    dwell_s: float,
    line_speed_kmh: float | None,
    changes: tuple[str, ...],
    mean_delay_s: float | None,
    certify: bool,
    pictures: bool,
    **given: Any,
) -> _Done:
    """Run one train and write its files."""
    case = read_case(train, track, None, line_speed_kmh).with_fields(changes)
    options = merged({}, {name: value for name, value in given.items() if value is not None})
    read_map(options, case)
    stops = None
    if timetable is not None:
        from tgvdp.formats import read_source

        read = read_source(timetable, "journey")
        stops, case.inputs["journey"] = read.value, read.fingerprint
    if not quiet:
        for text in unusual(case.train, case.track):
            screen.note(text)
    screen.progress(f"searching: {case.train.name} on {case.track.name}")
    # These bring numba: neither --help nor an error in the input waits for it.
    from tgvdp import api
    from tgvdp.report import make_provenance
    from tgvdp.report.journeys import journey_object, write_journey

    with screen.compiling():
        result = api.journey(case.train, case.track, stops, dwell_s=dwell_s, **arguments_of(options))
        screen.progress("replaying")
        started_s = time.perf_counter()
        failed = sum(not verdict.ok for point in result.verify() for verdict in point)
        about = make_provenance(result.options | case.changed, case.inputs, result.elapsed_s)
        about["elapsed_verify_s"] = time.perf_counter() - started_s
        bound = None
        if certify:
            screen.progress("proving")
            bound = result.certify()
        robustness = None if mean_delay_s is None else result.robustness(mean_delay_s=mean_delay_s)
        screen.progress("drawing and writing")
        files = write_journey(result, home, about, bound, robustness, pictures=pictures)
    return _Done(result, journey_object(result), bound, robustness, files, failed)


def _warnings(done: _Done) -> Iterator[str]:
    """Where a result is less than was asked for."""
    yield from done.result.warnings
    if done.bound is not None and done.result.trip.energy.map is not None:
        yield "--certify: energies by a map have no bound"


class _Compared(NamedTuple):
    """Who saves what, and the files that say so."""

    content: dict[str, Any]
    files: list[Path]


def _compared(done: Sequence[_Done], out: str, beneath: Sequence[Path]) -> _Compared:
    """Write who saves what."""
    from tgvdp.report.journeys import trains_object, write_trains

    results = [one.result for one in done]
    return _Compared(trains_object(results), write_trains(results, out, beneath))


def _table(result: "JourneyResult", content: Mapping[str, Any], bound: "JourneyBound | None") -> str:
    """A dozen points at most: time, energy, price, what the practices take more, and the gap where it is known."""
    front = content["front"]
    chosen = spread(len(front), ROWS)
    rows = [front[index] for index in chosen]
    columns = [
        column("margin", "%", 8, [f"{100.0 * (row['time_s'] / result.fastest_time_s - 1.0):.2f}" for row in rows]),
        column("time", "", 9, [duration(row["time_s"]) for row in rows]),
        column("energy", "kWh", 8, aligned([row["energy_kwh"] for row in rows], 5)),
        column("price", "kWh/min", 7, aligned([row["price_kwh_per_min"] for row in rows], 4)),
    ]
    for name, practice in content["practices"].items():
        more = [practice[index]["energy_kwh"] - front[index]["energy_kwh"] for index in chosen]
        columns.append(column(name.replace("_", " "), "kWh more", 8, aligned(more, 4)))
    if bound is not None:
        gap_pct = bound.gap_pct(result.front.energy_j)
        gaps = [f"{gap_pct[index]:.3f}" if math.isfinite(gap_pct[index]) else "–" for index in chosen]
        columns.append(column("gap", "%", 6, gaps))
    lines = ["  ".join(cells) for cells in zip(*columns, strict=True)]
    lines.append(
        f"{len(result.sections)} sections, fastest {duration(result.fastest_time_s)} without"
        f" {len(result.sections) - 1} dwells of {result.options['dwell_s']:g} s"
    )
    return "\n".join(lines)


def _robustness_table(robustness: "Robustness") -> str:
    """The optimum, today's practices, and the allocation on both fronts."""
    named = [at for at, name in enumerate(robustness.names) if "%" not in name]
    rows = dict.fromkeys([*named, robustness.on_both])
    columns = [
        column("", "with delays", 11, [robustness.names[at].replace("_", " ") for at in rows]),
        column("planned", "kWh", 8, aligned([joule_to_kwh(float(robustness.planned_j[at])) for at in rows], 5)),
        column("expected", "kWh", 8, aligned([joule_to_kwh(float(robustness.energy_j[at])) for at in rows], 5)),
        column("delay", "s", 7, aligned([float(robustness.delay_s[at]) for at in rows], 4)),
        column("punctual", "%", 8, [f"{100.0 * robustness.punctual[at]:.1f}" for at in rows]),
    ]
    lines = ["  ".join(cells) for cells in zip(*columns, strict=True)]
    return "\n".join([*lines, f"cheapest as planned on the second front: {robustness.names[robustness.on_both]}"])
