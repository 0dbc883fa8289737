"""``tgvdp search``: the Pareto front of one trip, as files, a table or one JSON object."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from tgvdp.cli import echo_json
from tgvdp.cli.clock import left_s, preparing_within, search_s
from tgvdp.cli.folder import OutFolder
from tgvdp.cli.groups import GroupedCommand
from tgvdp.cli.notes import idle, idle_restrictions, large_gaps, remarked, unusual
from tgvdp.cli.screen import Screen, advice_line, energy_table, front_table, power_and_cost
from tgvdp.cli.search_case import Case, merged, read_case, read_map, resolved, suited
from tgvdp.cli.search_options import search_options
from tgvdp.cli.timetable_section import section_on
from tgvdp.constants import METHODS
from tgvdp.errors import BudgetExceededError
from tgvdp.options.search import arguments_of
from tgvdp.second_process import SecondProcess

if TYPE_CHECKING:
    from tgvdp.api import SearchResult
    from tgvdp.certificate.front import Certificate
    from tgvdp.methods.budget import Clock
    from tgvdp.model.trip import Trip
    from tgvdp.referee.replay import Verdict

#: What follows a search: replay, proof, and tables.
_PARTS_AFTER = 3

#: Points that a warning names.
_NAMED = 20

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
  tgvdp search --from 20km --to 41.5km --speed-restriction 30km:32km:80 --wind 30
  tgvdp search --reverse --set train.mass_t=450 --set train.auxiliary_power_kw=300
  tgvdp search --every 100 --profiles xlsx --format svg,pdf
  tgvdp search --energy pantograph --price-per-kwh 0.15 --co2-g-per-kwh 60
  tgvdp search --json --quiet --no-pictures > result.json
"""


@click.command("search", cls=GroupedCommand, epilog=_EXAMPLES)
@search_options
def command(
    track: str | None,
    train: str | None,
    scenario: str | None,
    journey: str | None,
    line_speed_kmh: float | None,
    certify: bool,
    profiles: str,
    every_m: float | None,
    trace: bool,
    format: tuple[str, ...],
    pictures: bool,
    price_per_kwh: float | None,
    co2_g_per_kwh: float | None,
    out: str,
    as_json: bool,
    quiet: bool,
    force: bool,
    changes: tuple[str, ...],
    **given: Any,
) -> int:
    """Search the Pareto front of delay against energy for one trip.

    Writes result.json, front.csv, profiles.csv and pictures into a folder; docs/results.md says what they hold. Options
    marked front, exact or best-first belong to these methods; the last two search a grid. A search that ends by its
    budget writes what it has, labelled as partial, and exits with code 5.
    """
    context = click.get_current_context()
    if every_m is not None and profiles == "railtoolkit":
        raise click.UsageError("--every is for profiles as csv, parquet or xlsx", context)
    if journey is not None and track is None and scenario is None:
        raise click.UsageError("--journey needs the --track that it belongs to", context)
    if not pictures and context.get_parameter_source("format") is ParameterSource.COMMANDLINE:
        raise click.UsageError("--format is of pictures: it and --no-pictures exclude each other", context)
    started_s = time.perf_counter()
    folder = OutFolder(out, "result.json", force=force)
    with Screen(quiet=quiet) as screen, SecondProcess() as second:
        if pictures:
            second.load("tgvdp.api.warm")
        with preparing_within(given["time_limit_s"]):
            case = read_case(train, track, scenario, line_speed_kmh)
            asked = {name: value for name, value in given.items() if value is not None}
            options = merged(suited(case.options, asked, scenario), asked)
            _require_traced(trace, options)
            case = case.with_fields(changes)
            options = case.placed(options)
            read_map(options, case)
            section = None
            if journey is not None:
                case, read = case.with_timetable(journey)
                section = section_on(read, case.track, options, given)
        screen.progress(f"searching: {case.train.name} on {case.track.name}")
        # These bring numba: neither --help nor an error in the input waits for it.
        from tgvdp import api
        from tgvdp.api import warm
        from tgvdp.api.budget import budget_of
        from tgvdp.options.search import SearchOptions
        from tgvdp.report import make_provenance, make_tariff, write_results

        arguments = arguments_of(options)
        declared = SearchOptions(**arguments)
        trip = resolved(case, declared, time.perf_counter() - started_s)
        if not quiet:
            for text in _remarks(case, trip, arguments):
                screen.note(text)
        warm.compile_beside(second, screen.waiting, declared, certified=certify)
        if pictures:
            second.load("tgvdp.report.gallery")
        with screen.compiling():
            budget = budget_of(arguments)
            clock = budget.start(time.perf_counter() - started_s)
            limited = arguments | {"time_limit_s": search_s(clock, _PARTS_AFTER)}
            result = api.search(case.train, case.track, **limited)
            result = replace(result, options=result.options | {"time_limit_s": budget.time_limit_s})
            if section is not None:
                result = replace(result, warnings=(*result.warnings, *section.broken_by(result.fastest.time_s)))
            about = make_provenance(result.options | case.changed, case.inputs, result.elapsed_s)
            formats = format if pictures else ()
            runs = _asked(second, "run_files", formats, clock, result, about, price_per_kwh)
            verdicts, certificate, checks_s = _checked(result, certify, screen, clock)
            front = _asked(second, "front_files", formats, clock, result, about, certificate)
            tariff = make_tariff(price_per_kwh, co2_g_per_kwh)
            files, content, undrawn = write_results(
                result, out, about | checks_s, verdicts, certificate, profiles=profiles, every_m=every_m,
                trace=result.trace() if trace else None,
                pictures=formats, tariff=tariff, drawn=lambda: front() | runs(), progress=screen.progress,
                time_s=left_s(clock),
            )  # fmt: skip
        folder.drop_earlier(files)

    if as_json:
        echo_json(content)
    if not quiet:
        _show(content, _title(result, changes), f"in {out}: {', '.join(file.name for file in files)}", as_json)
    return _judge(content, certificate is None or certificate.complete, undrawn, quiet)


def _require_traced(trace: bool, options: Mapping[str, Any]) -> None:
    method = options.get("method", METHODS[0])
    if trace and method != "best-first":
        raise click.UsageError(f"--trace belongs to method best-first, not to {method}", click.get_current_context())


def _remarks(case: Case, trip: "Trip", arguments: Mapping[str, Any]) -> Iterator[str]:
    """What readers noted, what is unusual, and what was given and changes nothing."""
    yield from remarked(case.remarks)
    yield from unusual(case.train, case.track)
    yield from idle_restrictions(trip, arguments.get("speed_restrictions", ()))
    yield from idle(trip)


def _show(content: Mapping[str, Any], title: str, written: str, beside: bool) -> None:
    """Print a result for people, on stderr where stdout is taken."""
    tables = (front_table(content), energy_table(content), power_and_cost(content), advice_line(content))
    for text in (title, *filter(None, tables), written):
        click.echo(text, err=beside)
    for text in large_gaps(content):
        click.echo(f"tgvdp: note: {text}", err=True)


def _asked(
    second: SecondProcess, task: str, formats: Sequence[str], clock: "Clock", *shown: Any
) -> Callable[[], dict[str, bytes]]:
    """Have pictures drawn in formats, if any, as far as time allows; what is returned waits for their files."""
    if not formats:
        return dict

    ask = partial(second.promise, f"tgvdp.report.gallery:{task}", formats)
    if second.is_there:
        return ask(left_s(clock), *shown)

    def begun_when_waited_for() -> dict[str, bytes]:
        files: dict[str, bytes] = ask(left_s(clock), *shown)()
        return files

    return begun_when_waited_for


def _checked(
    result: "SearchResult", certify: bool, screen: Screen, clock: "Clock"
) -> "tuple[list[Verdict], Certificate | None, dict[str, float]]":
    """Replay a result and, if asked for, prove it; with entries of the provenance: how long each took, s."""
    screen.progress("replaying")
    started_s = time.perf_counter()
    verdicts = result.verify(left_s(clock, 2))
    checks_s = {"elapsed_verify_s": time.perf_counter() - started_s}
    if not certify:
        return verdicts, None, checks_s
    screen.progress("proving")
    started_s = time.perf_counter()
    certificate = result.certify(left_s(clock, 1))
    checks_s["elapsed_certify_s"] = time.perf_counter() - started_s
    return verdicts, certificate, checks_s


def _title(result: "SearchResult", changes: Sequence[str]) -> str:
    """What ran where, and what was set."""
    title = f"{result.trip.train.name} on {result.trip.track.name}"
    return f"{title}, with {', '.join(changes)}" if changes else title


def _judge(content: Mapping[str, Any], is_proved: bool, undrawn: int, quiet: bool) -> int:
    """Exit code of a result, and a word on stderr where it is not all that was asked for."""
    front = content["front"]
    failed = [str(point["id"]) for point in front if point["replay"]["ok"] is False]
    if failed:
        more = f" and {len(failed) - _NAMED} more" if len(failed) > _NAMED else ""
        click.echo(f"tgvdp: warning: points {', '.join(failed[:_NAMED])}{more} do not pass the replay", err=True)
    unknown = sum(point["replay"]["ok"] is None for point in front)
    bare = sum(point["peak_power_kw"] is None for point in front)
    if not content["complete"]:
        ended = content["warning"]
    elif unknown:
        ended = f"the time limit ended the replay, {unknown} points had none"
    elif bare:
        ended = f"the time limit ended the summing up, {bare} points lack it"
    elif not is_proved:
        ended = "the budget ended the proof, bounds are missing or loose"
    elif undrawn:
        ended = f"the time limit left no time for {undrawn} pictures"
    else:
        ended = ""
    if content["complete"] and "warning" in content and not quiet:
        click.echo(f"tgvdp: warning: {content['warning']}", err=True)
    if not ended:
        return 0
    click.echo(f"tgvdp: budget reached: {ended}", err=True)
    return BudgetExceededError.exit_code
