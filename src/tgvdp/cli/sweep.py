"""``tgvdp sweep``: thousands of searches or journeys from one spec, on this machine or on a cluster."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tgvdp.cli import echo_json
from tgvdp.cli.completions import complete_folder
from tgvdp.cli.groups import GroupedCommand, apply_all, heading
from tgvdp.cli.notes import remarked
from tgvdp.cli.numbers import number
from tgvdp.cli.screen import Screen, duration
from tgvdp.errors import BudgetExceededError, TasksFailedError
from tgvdp.units import counted, to_si

if TYPE_CHECKING:
    from tgvdp.sweeps.run import Progress
    from tgvdp.sweeps.spec import SweepSpec

#: Errors that are shown; the rest is in the table.
_SHOWN = 5

_EXAMPLES = """
\b
Examples:
  tgvdp sweep spec.toml --dry-run
  tgvdp sweep spec.toml --out network
  tgvdp sweep spec.toml --out network --resume
  tgvdp sweep spec.toml --out network --scheduler tcp://10.0.0.1:8786
  tgvdp sweep report network --margin 5
"""
_where = heading("Where it runs")
_output = heading("Output")
_OPTIONS = [
    _where(
        "--scheduler", metavar="ADDRESS", help="A Dask cluster that is there, such as tcp://10.0.0.1:8786."
    ),
    _where("--workers", type=click.IntRange(min=1), metavar="N", help="Processes on this machine.  [default: cores]"),
    _where(
        "--worker-memory", metavar="MB", type=number("MB", above=0.0),
        help="Memory of each of them at most.  [default: its share of the machine's]",
    ),
    _output(
        "--out", metavar="DIR", default="sweep", show_default=True, shell_complete=complete_folder,
        help="Folder of the results.",
    ),
    _output("--resume", is_flag=True, help="Go on with what the folder holds, after an interruption or a longer spec."),
    _output("--retry", is_flag=True, help="With --resume: solve again what failed, was killed or ended by its budget."),
    _output("--dry-run", is_flag=True, help="Only count the scenarios, and estimate how long they take."),
    _output("--json", "as_json", is_flag=True, help="Print one JSON object on stdout, everything else on stderr."),
    _output("-q", "--quiet", is_flag=True, help="Print nothing but errors and what --json asks for."),
]  # fmt: skip


class _SweepCommand(GroupedCommand):
    """The command, which hands ``report`` on to one of its own."""

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        if args[:1] != ["report"]:
            return super().make_context(info_name, args, parent, **extra)
        from tgvdp.cli.sweep_report import command as report

        context: click.Context = report.make_context(f"{info_name} report", args[1:], parent, **extra)
        return context


def _options(function: Callable[..., Any]) -> Callable[..., Any]:
    return apply_all(_OPTIONS, function)


@click.command("sweep", cls=_SweepCommand, epilog=_EXAMPLES)
@click.argument("path", metavar="SPEC | report DIR", type=click.Path(path_type=Path))
@_options
def command(
    path: Path,
    scheduler: str | None,
    workers: int | None,
    worker_memory: float | None,
    out: str,
    resume: bool,
    retry: bool,
    dry_run: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Run all scenarios that SPEC names, and write them as one data set.

    SPEC is a TOML file with trains, lines, sections and what varies; docs/sweeps.md describes it and the tables. What
    is finished is kept at once: after an interruption of any kind --resume goes on. Exits with code 6 when scenarios
    failed; their errors are in scenarios.csv, all others are done. "tgvdp sweep report DIR" sums a finished one up.
    """
    if scheduler is not None and (workers is not None or worker_memory is not None):
        raise click.UsageError("--workers and --worker-memory are for this machine, not for a --scheduler's")
    if retry and not resume:
        raise click.UsageError("--retry goes with --resume")
    from tgvdp.report import check_writable
    from tgvdp.sweeps.cluster import Cluster
    from tgvdp.sweeps.forks import start_fork_server

    if not dry_run:
        check_writable(out)
    forked = scheduler is None and not dry_run and start_fork_server()  # loads while this process does
    memory_b = None if worker_memory is None else to_si(worker_memory, "MB", "memory")
    cluster = Cluster(scheduler, workers, memory_b, forked)
    from tgvdp.sweeps.read import read_spec

    spec = read_spec(path)
    with Screen(quiet=quiet) as screen:
        told = [remark for part in (*spec.trains, *spec.lines) for remark in part.remarks]
        for text in remarked(list(dict.fromkeys((*told, *spec.tables.remarks)))):
            screen.note(text)
        if dry_run:
            return _estimate(spec, cluster, screen, as_json)
        from tgvdp.sweeps.run import run_sweep

        screen.progress(f"starting: {len(spec)} scenarios")
        started_s = time.perf_counter()
        done = run_sweep(spec, Path(out), cluster, resume=resume, retry=retry, told=teller(screen))
    content = done.content | {"elapsed_s": time.perf_counter() - started_s}
    if as_json:
        echo_json(content)
    if not quiet:
        click.echo(_summary(content, out), err=as_json)
        for text in done.errors[:_SHOWN]:
            click.echo(f"tgvdp: warning: {text}", err=True)
    if content["failed"] + content["killed"]:
        return TasksFailedError.exit_code
    return BudgetExceededError.exit_code if content["partial"] else 0


def _estimate(spec: "SweepSpec", cluster: Any, screen: Screen, as_json: bool) -> int:
    """Say how many scenarios there are and about how long they take."""
    from tgvdp.sweeps.estimate import estimate
    from tgvdp.sweeps.review import multiplied

    screen.progress("solving a few of them")
    with screen.compiling():
        content = estimate(spec, cluster)
    if as_json:
        echo_json(content)
        return 0
    click.echo(f"{counted(content['scenarios'], 'scenario')}: {multiplied(spec)}")
    if content["failed"]:
        click.echo(f"tgvdp: warning: {content['failed']} of {content['sampled']} failed: {content['error']}", err=True)
    if content["seconds_each"] is not None:
        each = f"{content['seconds_each'] * 1e3:.3g} ms each, by {content['sampled']} of them"
        workers = f"{content['workers']} worker{'' if content['workers'] == 1 else 's'}"
        click.echo(f"about {duration(content['elapsed_s'])} on {workers}, {each}")
    return 0


def teller(screen: Screen) -> "Callable[[Progress], None]":
    """What shows how far a sweep is."""
    shown = False

    def tell(progress: "Progress") -> None:
        nonlocal shown
        if progress.dashboard and not shown:
            screen.note(f"dashboard at {progress.dashboard}")
            shown = True
        left = "" if progress.left_s is None else f", {duration(progress.left_s)} left"
        failed = f", {progress.failed} failed" if progress.failed else ""
        screen.progress(f"{progress.done} of {progress.total} done{failed}, {progress.per_second:.3g}/s{left}")

    return tell


def _summary(content: dict[str, Any], out: str) -> str:
    """One line for people."""
    counted = [f"{content[name]} {name}" for name in ("done", "partial", "failed", "killed") if content[name]]
    same = content["scenarios"] - content["distinct"]
    again = f", {same} the same as others" if same else ""
    before = f", {content['earlier']} of them before" if content["earlier"] else ""
    return (
        f"{content['scenarios']} scenarios{again}: {', '.join(counted)}{before}, in {duration(content['elapsed_s'])}\n"
        f"in {out}: {', '.join(content['files'])}"
    )
