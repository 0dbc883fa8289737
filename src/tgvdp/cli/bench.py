"""``tgvdp bench``: solvers against each other on many instances, with everything that is finished kept."""

import sys
import time
from pathlib import Path
from typing import Any

import click

from tgvdp.cli import echo_json
from tgvdp.cli.completions import complete_instance
from tgvdp.cli.screen import Screen, duration
from tgvdp.solvers.allowance import ITEMS

SOLVERS = "dp,milp:time-limit=60,sa:bits,sa:unary,tabu:unary,random:unary"
#: Most steps of the built-in instances that are taken when none is named: samplers take hours on the largest.
BUILT_IN_STEPS = 20
_BAR = 24

_EXAMPLES = """
\b
Examples:
  tgvdp bench trip.json --out trip-bench
  tgvdp bench --up-to 200 --solvers dp,milp --runs 5 --out exact
  tgvdp bench easy-n008 --solvers dp,sa:unary:sweeps=3000:penalty=2,qaoa:bits:layers=2:runs=1 --out quantum
  tgvdp bench easy-n020 --solvers sa:bits,sa:unary --embed pegasus,zephyr --out sizes
"""


@click.command("bench", epilog=_EXAMPLES)
@click.argument("words", metavar="[INSTANCES]...", nargs=-1, shell_complete=complete_instance)
@click.option(
    "--solvers", default=SOLVERS, show_default=True, metavar="LIST",
    help="Words NAME[:ENCODING][:KEY=VALUE ...] with commas; keys: penalty, runs, "
    f"{', '.join(item.key for item in ITEMS if item.field != 'seed')}.",
)  # fmt: skip
@click.option(
    "--up-to",
    type=click.IntRange(min=1),
    metavar="N",
    help=f"Leave out instances of more steps.  [default: {BUILT_IN_STEPS} without INSTANCES, else none]",
)
@click.option("--runs", type=click.IntRange(1, 10_000), default=5, show_default=True, help="Of each on each instance.")
@click.option("--seed", type=click.IntRange(0, 2**30), default=1, show_default=True, help="Of the first run.")
@click.option("--embed", default="", metavar="LIST", help="Embed the QUBOs into pegasus, zephyr. Takes long.")
@click.option(
    "--embed-limit", type=click.IntRange(1, 86_400), default=60, show_default=True, metavar="S",
    help="Time for one embedding.",
)  # fmt: skip
@click.option(
    "--out", type=click.Path(path_type=Path), default=Path("bench"), show_default=True, help="Folder to fill."
)
@click.option(
    "--qoblib", type=click.Path(path_type=Path), metavar="DIR", help="Write submissions to QOBLIB there, and a checker."
)
@click.option("--submitter", metavar="NAME", help="Of the submissions.  [default: N/A]")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of a table.")
@click.option("-q", "--quiet", is_flag=True, help="No progress bar.")
def command(
    words: tuple[str, ...],
    solvers: str,
    up_to: int | None,
    runs: int,
    seed: int,
    embed: str,
    embed_limit: int,
    out: Path,
    qoblib: Path | None,
    submitter: str | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Run solvers on INSTANCES, and compare what they reach with certified optima.

    INSTANCES are built-in names, JSON files, or folders of them; without any, all that are built in. Each finished run
    is kept in the folder, so that the same command goes on after an interruption, and makes only what is new after a
    change. The folder gets benchmark.csv with the fields of QOBLIB, runs.csv, benchmark.md and .json, and pictures.
    """
    from tgvdp import instances
    from tgvdp.errors import InputError
    from tgvdp.report import check_writable
    from tgvdp.solvers.samplers.embedding import TOPOLOGIES
    from tgvdp.trials.execute import Plan, run_benchmark
    from tgvdp.trials.output import write_benchmark
    from tgvdp.trials.qoblib import write_submissions
    from tgvdp.trials.reference import read_cases
    from tgvdp.trials.spec import parse_specs
    from tgvdp.trials.store import RUNS

    context = click.get_current_context()
    if submitter is not None and qoblib is None:
        raise click.UsageError("--submitter is of the submissions that --qoblib writes", context)
    topologies = tuple(dict.fromkeys(word.strip() for word in embed.split(",") if word.strip()))
    if unknown := next((word for word in topologies if word not in TOPOLOGIES), None):
        raise click.UsageError(f"--embed: there is no {unknown!r}; there are {', '.join(TOPOLOGIES)}", context)
    try:
        specs = parse_specs(solvers)
    except InputError as error:
        raise click.UsageError(f"--{error}", context) from None
    places = [instances.find(word) for word in words] or [instances.FOLDER]
    cases = read_cases(places, up_to or (None if words else BUILT_IN_STEPS))
    plan = Plan(tuple(cases), tuple(specs), runs, seed, topologies, float(embed_limit))
    check_writable(out)
    if out.is_dir() and any(out.iterdir()) and not (out / RUNS).is_dir():
        raise InputError(f"{out}: is not empty, and no benchmark is in it")
    started = time.perf_counter()
    with Screen(quiet=quiet) as screen:
        bar = _Bar(screen)
        results = run_benchmark(plan, out, bar)
        content = write_benchmark(results, out, time.perf_counter() - started)
        submissions = write_submissions(results, content["rows"], qoblib, submitter or "N/A") if qoblib else 0
    if as_json:
        echo_json(content)
    else:
        click.echo(_table(content["rows"]))
    if not as_json:
        click.echo(f"{len(content['rows'])} rows; {', '.join(content['files'])} in {out}", file=sys.stderr)
        if qoblib:
            print(f"{submissions} submissions and a checker in {qoblib}", file=sys.stderr)


class _Bar:
    """A bar with what comes next and the time that is left, by the pace of this process."""

    def __init__(self, screen: Screen) -> None:
        self._screen = screen
        self._started: tuple[float, int] | None = None

    def __call__(self, done: int, total: int, what: str) -> None:
        now = time.perf_counter()
        self._started = self._started or (now, done)
        began, first = self._started
        made = done - first
        left = f", {duration((now - began) / made * (total - done))} left" if made and done < total else ""
        filled = _BAR * done // total
        self._screen.progress(f"{'█' * filled}{'░' * (_BAR - filled)} {done}/{total}{left}  {what}")


def _table(rows: list[dict[str, Any]]) -> str:
    """What people read at once: one line per solver, over all instances."""
    labels = list(dict.fromkeys(row["Workflow"] for row in rows))
    width = max(map(len, ["solver", *labels]))
    head = f"{'solver':<{width}}  {'instances':>9}  {'solved':>6}  {'feasible':>8}"
    lines = [f"{head}  {'p of success':>12}  {'median time':>12}"]
    for label in labels:
        own = [row for row in rows if row["Workflow"] == label]
        taken = [row for row in own if row["status"] != "refused"]
        solved = sum(bool(row["# Successful Runs"]) for row in taken)
        feasible = sum(bool(row["# Feasible Runs"]) for row in taken)
        chances = sorted(row["p_success"] for row in taken if row["p_success"] is not None)
        times = sorted(row["elapsed_s median"] for row in taken if row["elapsed_s median"] is not None)
        chance = f"{chances[len(chances) // 2]:.3g}" if chances else "–"
        time_s = duration(times[len(times) // 2]) if times else "–"
        lines.append(f"{label:<{width}}  {len(taken):>9}  {solved:>6}  {feasible:>8}  {chance:>12}  {time_s:>12}")
    return "\n".join(lines)
