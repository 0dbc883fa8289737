"""``tgvdp journey``: a train over all stops of a line, and the split of its supplement over the sections."""

import json
import time
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from tgvdp.cli.folder import OutFolder
from tgvdp.cli.groups import GroupedCommand, apply_all, heading
from tgvdp.cli.notes import unusual
from tgvdp.cli.numbers import LINE_SPEED, number
from tgvdp.cli.screen import ROWS, Screen, aligned, column, duration, spread
from tgvdp.cli.search_case import merged, read_case, read_map
from tgvdp.cli.search_options import SET_HELP, TRACK_HELP, TRAIN_HELP, complete, complete_fields, declared
from tgvdp.errors import BudgetExceededError
from tgvdp.options.search import BY_FIELD, TRIP, arguments_of

if TYPE_CHECKING:
    from tgvdp.api import JourneyResult
    from tgvdp.journeys.bound import JourneyBound

_EXAMPLES = """
\b
Examples:
  tgvdp journey --track line.json --train train.json
  tgvdp journey --track line.json --train train.json --dwell 45 --at "5%,8%"
  tgvdp journey --track line.json --train train.json --journey journey.json --out timetable
  tgvdp journey --track line.json --train train.json --points 100 --json --no-pictures > journey.json
"""
_JOURNEY_HELP = "A timetable: its stops count in place of the line's, its windows are kept."
#: Options of a search that a journey has, too, by their names in files.
_SHARED = (
    *("reverse", "speed_restriction", "energy", "convention", "mass_model", "limits", "curves", "tunnels", "wind_kmh"),
    *("points", "max_margin_pct", "at", "time_limit_s"),
)
_trip = heading(TRIP)
_output = heading("Proof and output")
_OPTIONS = [
    _trip("--track", metavar="FILE|NAME", shell_complete=complete, help=TRACK_HELP),
    _trip("--train", metavar="FILE|NAME", shell_complete=complete, help=TRAIN_HELP),
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
    *(declared(BY_FIELD[field]) for field in _SHARED),
    _output("--certify", is_flag=True, help="Prove how far the optimum can be; takes seconds."),
    _output("--pictures/--no-pictures", default=True, show_default=True, help="Draw pictures."),
    _output("--out", metavar="DIR", default="journey", show_default=True, help="Folder of the results."),
    _output("--force", is_flag=True, help="Write into a folder that holds files of others."),
    _output("--json", "as_json", is_flag=True, help="Print one JSON object on stdout, everything else on stderr."),
    _output("--quiet", is_flag=True, help="Print nothing but errors and what --json asks for."),
]


@click.command("journey", cls=GroupedCommand, epilog=_EXAMPLES)
@partial(apply_all, _OPTIONS)
def command(
    track: str | None,
    train: str | None,
    timetable: str | None,
    dwell_s: float,
    line_speed_kmh: float | None,
    changes: tuple[str, ...],
    certify: bool,
    pictures: bool,
    out: str,
    force: bool,
    as_json: bool,
    quiet: bool,
    **given: Any,
) -> int:
    """Run a train over all stops of a line: least energy for each running time, and the best split of the time.

    Each section between two stops has its own front. The journey's front splits the supplement so that one more second
    saves the same in every section; beside it stands what today's practices take. Writes journey.json, front.csv,
    allocation.csv and pictures into a folder; docs/journeys.md says what they hold.
    """
    folder = OutFolder(out, force=force)
    with Screen(quiet=quiet) as screen:
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
            screen.progress("drawing and writing")
            files = write_journey(result, out, about, bound, pictures=pictures)
        folder.drop_earlier(files)
    content = journey_object(result)
    if as_json:
        click.echo(json.dumps(content, ensure_ascii=False, allow_nan=False))
    if not quiet:
        click.echo(_table(result, content, bound), err=as_json)
        click.echo(f"in {out}: {', '.join(file.name for file in files)}", err=as_json)
    if failed:
        click.echo(f"tgvdp: warning: {failed} runs of sections do not pass the replay", err=True)
    for text in () if quiet else result.warnings:
        click.echo(f"tgvdp: warning: {text}", err=True)
    complete = result.found.complete and (bound is None or bound.complete)
    return 0 if complete else BudgetExceededError.exit_code


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
        columns.append(column("gap", "%", 6, [f"{gap_pct[index]:.3f}" for index in chosen]))
    lines = ["  ".join(cells) for cells in zip(*columns, strict=True)]
    lines.append(
        f"{len(result.sections)} sections, fastest {duration(result.fastest_time_s)} without"
        f" {len(result.sections) - 1} dwells of {result.options['dwell_s']:g} s"
    )
    return "\n".join(lines)
