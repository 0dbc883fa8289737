"""``tgvdp journey``: a train over all stops of a line, and the split of its supplement over the sections."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click
from click.core import ParameterSource

from tgvdp.cli import echo_json
from tgvdp.cli.advised import UNADVISED, advisable, advised
from tgvdp.cli.clock import left_s, preparing_within, search_s
from tgvdp.cli.compare import compare_table
from tgvdp.cli.completions import complete_source
from tgvdp.cli.folder import OutFolder
from tgvdp.cli.groups import GroupedCommand, apply_all, heading
from tgvdp.cli.journey_tables import front_table, journey_advice_lines, margins_table, robustness_table
from tgvdp.cli.notes import remarked, unusual
from tgvdp.cli.numbers import number
from tgvdp.cli.screen import Screen
from tgvdp.cli.search_case import merged, read_case, read_map, resolved
from tgvdp.cli.search_options import (
    LINE_AND_FIELDS,
    PICTURES,
    TRACK_HELP,
    TRAIN_HELP,
    declared,
    folder_and_screen,
)
from tgvdp.errors import BudgetExceededError, InputError
from tgvdp.model.margin import checked_ranges
from tgvdp.options.search import BY_FIELD, JOURNEY_FIELDS, TRIP, JourneyOptions, arguments_of
from tgvdp.options.texts import parse_margins

if TYPE_CHECKING:
    from tgvdp.api import JourneyResult
    from tgvdp.api.margins import Margins
    from tgvdp.journeys.bound import JourneyBound
    from tgvdp.methods.budget import Clock
    from tgvdp.referee.replay import Verdict
    from tgvdp.report.journeys import Extras

_EXAMPLES = """
\b
Examples:
  tgvdp journey --track line.json --train train.json
  tgvdp journey --track line.json --train train.json --dwell 45 --at "5%,8%"
  tgvdp journey --track line.json --train train.json --journey timetable.csv --out timetable
  tgvdp journey --track net.xml#t1:up --train stock.xml --journey times.xml#4711    railML: the train of that number
  tgvdp journey --track das.xml --train train.json --journey das.xml    SFERA: advice goes back in sfera.xml
  tgvdp journey --track line.json --train train.json --train other.json --out trains
  tgvdp journey --track line.json --train train.json --margins 5% --margins "0:10km:5%,10km::4.5min/100km"
  tgvdp journey --track line.json --train train.json --points 100 --json --no-pictures > journey.json
"""
_JOURNEY_HELP = (
    "A timetable, such as a table of arrivals and departures (or of railML 2.x, SFERA, OSRD, TTOBench): its stops count"
    " in place of the line's, its windows are kept."
)
_DELAY_HELP = "Mean delay of departures: simulates how late and how dear the splits of the middle point are."
_MARGINS_HELP = (
    "Take this supplement as a linear, economy and uniform margin, beside the optimum: 5%, 4.5min/100km, 90s, or by"
    " ranges FROM:TO:... with commas between. May be given several times."
)
_WITHIN_HELP = "Of the uniform margin: how far times between any two points are from the linear ones at most."
_TRAINS_HELP = f"{TRAIN_HELP} May be given several times."
_MAIN = "journey.json"
#: What follows a search: replay, proof and files; and margins, one by one.
_PARTS_AFTER = 3
_SEVERAL, _COMPARED = "tgvdp.journeys/1", ("compare.json", "compare.csv", "compare.png")
_WITHIN = number("%", above=0.0, below=100.0)
_trip = heading(TRIP)
_output = heading("Proof and output")


def _readable_margins(_: click.Context, __: click.Parameter, texts: tuple[str, ...]) -> tuple[str, ...]:
    """Check supplements, and leave them as they are."""
    for text in texts:
        try:
            parse_margins(text)
        except InputError as error:
            raise click.BadParameter(str(error)) from None
    return texts


_OPTIONS = [
    _trip("--track", metavar="FILE|NAME", shell_complete=complete_source, help=TRACK_HELP),
    _trip("--train", "trains", metavar="FILE|NAME", multiple=True, shell_complete=complete_source, help=_TRAINS_HELP),
    _trip("--journey", "timetable", metavar="FILE", shell_complete=complete_source, help=_JOURNEY_HELP),
    _trip(
        "--dwell",
        "dwell_s",
        metavar="S",
        default="30",
        show_default=True,
        type=number("s", at_least=0.0),
        help="Standstill at each stop on the way; less where a timetable leaves less.",
    ),
    *LINE_AND_FIELDS,
    *(declared(BY_FIELD[field]) for field in JOURNEY_FIELDS),
    _output("--margins", "margins", metavar="LIST", multiple=True, callback=_readable_margins, help=_MARGINS_HELP),
    _output("--within", "within_pct", metavar="PCT", default="2", show_default=True, type=_WITHIN, help=_WITHIN_HELP),
    _output("--delay", "mean_delay_s", metavar="S", type=number("s", above=0.0), help=_DELAY_HELP),
    _output("--certify", is_flag=True, help="Prove how far the optimum can be; takes seconds."),
    PICTURES,
    *folder_and_screen("journey"),
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
    context = click.get_current_context()
    if not asked["margins"] and context.get_parameter_source("within_pct") is ParameterSource.COMMANDLINE:
        raise click.UsageError("--within goes with --margins", context)
    started_s = time.perf_counter()
    several = len(trains) > 1
    homes = [Path(out) / f"train-{number}" for number in range(1, len(trains) + 1)] if several else [Path(out)]
    folder = OutFolder(out, _MAIN, force=force, parts=[home.name for home in homes] if several else [])
    for home in homes:
        OutFolder(str(home), _MAIN, force=force)
    with Screen(quiet=quiet) as screen:
        done = [
            _run(screen, train, home, quiet, started_s, number / len(homes), **asked)
            for number, (train, home) in enumerate(zip(trains or (None,), homes, strict=True), start=1)
        ]
        files = [file for one in done for file in one.files]
        compared = _compared(done, out, files) if several else None
    folder.drop_earlier(files if compared is None else [*files, *compared.files])
    content = {"schema": _SEVERAL, "trains": [{"train": one.result.trip.train.name, **one.content} for one in done]}
    if as_json:
        echo_json(content if several else done[0].content)
    if not quiet:
        table = _front(done[0]) if compared is None else compare_table(compared.content)
        click.echo(table, err=as_json)
        names = [*(home.name for home in homes), *_COMPARED] if several else [file.name for file in done[0].files]
        click.echo(f"in {out}: {', '.join(names)}", err=as_json)
    for one in done:
        for table in () if quiet else _more_tables(one):
            click.echo(table, err=as_json)
        if one.failed:
            click.echo(f"tgvdp: warning: {one.failed} runs of sections do not pass the replay", err=True)
        for text in () if quiet else _warnings(one):
            click.echo(f"tgvdp: warning: {text}", err=True)
    if compared is not None and "warning" in compared.content and not quiet:
        click.echo(f"tgvdp: warning: {compared.content['warning']}", err=True)
    for text in dict.fromkeys(text for one in done for text in one.ended):
        click.echo(f"tgvdp: budget reached: {text}", err=True)
    complete = all(one.result.found.complete and not one.ended for one in done)
    return 0 if complete else BudgetExceededError.exit_code


class _Done(NamedTuple):
    """A journey with its object, what was asked for beside it, its files, and how many of its runs do not replay.

    And what the time limit ended after its search.
    """

    result: "JourneyResult"
    content: dict[str, Any]
    extras: "Extras"
    files: list[Path]
    failed: int
    ended: tuple[str, ...]


def _run(
    screen: Screen,
    train: str | None,
    home: Path,
    quiet: bool,
    started_s: float,
    share: float,
    *,
    track: str | None,
    timetable: str | None,
    dwell_s: float,
    line_speed_kmh: float | None,
    changes: tuple[str, ...],
    margins: tuple[str, ...],
    within_pct: float,
    mean_delay_s: float | None,
    certify: bool,
    pictures: bool,
    **given: Any,
) -> _Done:
    """Run one train and write its files, until a share of the time limit has passed since the command began."""
    from tgvdp.formats import whole_of

    with preparing_within(given["time_limit_s"]):
        case = read_case(train, track, None, line_speed_kmh).with_fields(changes)
        for text in margins:
            checked_ranges(parse_margins(text), case.track.length_m)
        options = merged({}, {name: value for name, value in given.items() if value is not None})
        read_map(options, case)
        stops = None
        if timetable is not None:
            case, read = case.with_timetable(timetable, reverse=options.get("reverse", False))
            stops = whole_of(read)
        message = advisable(case)
    if not quiet:
        for text in (*remarked(case.remarks), *unusual(case.train, case.track)):
            screen.note(text)
    screen.progress(f"searching: {case.train.name} on {case.track.name}")
    # These bring numba: neither --help nor an error in the input waits for it.
    from tgvdp import api
    from tgvdp.api.budget import budget_of
    from tgvdp.api.journeys import require_without_windows
    from tgvdp.report import make_provenance
    from tgvdp.report.journeys import Extras, write_journey

    arguments = arguments_of(options)
    if stops is not None and (margins or mean_delay_s is not None):
        require_without_windows(stops, dwell_s, "margins are taken" if margins else "delays are simulated")
    resolved(case, JourneyOptions(**arguments), time.perf_counter() - started_s)
    with screen.compiling():
        budget = budget_of(arguments)
        own_budget = replace(budget, time_limit_s=share * budget.time_limit_s)
        clock = own_budget.start(time.perf_counter() - started_s)
        arguments["time_limit_s"] = search_s(clock, _PARTS_AFTER + len(margins))
        result = api.journey(case.train, case.track, stops, dwell_s=dwell_s, **arguments)
        result = replace(result, options=result.options | {"time_limit_s": budget.time_limit_s})
        screen.progress("replaying")
        verify_started_s = time.perf_counter()
        verdicts = [own for point in result.verify(left_s(clock, 2 + len(margins))) for own in point]
        about = make_provenance(result.options | case.changed, case.inputs, result.elapsed_s)
        about["elapsed_verify_s"] = time.perf_counter() - verify_started_s
        bound = None
        if certify:
            screen.progress("proving")
            bound = result.certify(left_s(clock, 1 + len(margins)))
        taken, margins_ended = _margins(screen, result, margins, within_pct / 100.0, clock)
        delays = None if mean_delay_s is None else result.robustness(mean_delay_s=mean_delay_s)
        verdicts += [own for one in taken.values() for runs in one.verify(left_s(clock)).values() for own in runs]
        ended = (*_ended(verdicts, bound), *margins_ended)
        extras = Extras(bound, delays, taken, ended, advised(message, result))
        if message is not None and not extras.beside and not quiet:
            screen.note(UNADVISED)
        screen.progress("drawing and writing")
        written = write_journey(result, home, about, extras, pictures=pictures, expired=lambda: clock.expired)
    failed = sum(verdict.ok is False for verdict in verdicts)
    return _Done(result, written.content, extras, written.files, failed, written.ended)


def _margins(
    screen: Screen, result: "JourneyResult", margins: Sequence[str], within: float, clock: "Clock"
) -> tuple[dict[str, "Margins"], tuple[str, ...]]:
    """Supplements that were asked for, as far as time allows, and what the time limit ended, for people."""
    taken: dict[str, Margins] = {}
    for at, text in enumerate(margins):
        screen.progress("taking margins")
        try:
            taken[text] = result.margins(text, within, left_s(clock, len(margins) - at))
        except BudgetExceededError:
            return taken, (f"the time limit ended the margins before {', '.join(margins[at:])}",)
    return taken, ()


def _ended(verdicts: Sequence["Verdict"], bound: "JourneyBound | None") -> Iterator[str]:
    """What the time limit ended after the search, for people."""
    if unknown := sum(verdict.ok is None for verdict in verdicts):
        yield f"the time limit ended the replay, {unknown} runs of sections had none"
    if bound is not None and not bound.complete:
        yield "the budget ended the proof, bounds are missing or loose"


def _front(done: _Done) -> str:
    """The table of a front."""
    return front_table(done.result, done.content, done.extras.bound)


def _more_tables(done: _Done) -> Iterator[str]:
    """What stands beside a front."""
    if "advice" in done.content:
        yield journey_advice_lines(done.content, done.result.trip.train.name)
    if done.extras.robustness is not None:
        yield robustness_table(done.extras.robustness)
    yield from map(margins_table, done.content.get("margins", ()))


def _warnings(done: _Done) -> Iterator[str]:
    """Where a result is less than was asked for."""
    yield from done.result.warnings
    if done.extras.bound is not None and done.result.trip.energy.map is not None:
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
