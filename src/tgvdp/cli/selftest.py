"""``tgvdp selftest``: verify what tgvdp computes on this machine."""

import time
from pathlib import Path

import click

from tgvdp.cli import echo_json
from tgvdp.cli.screen import Screen
from tgvdp.errors import TgvdpError

_EXAMPLES = """
\b
Examples:
  tgvdp selftest
  tgvdp selftest --json > selftest.json
  tgvdp selftest --references data --out verification.md
"""


@click.command("selftest", epilog=_EXAMPLES)
@click.option(
    "--references",
    metavar="FOLDER",
    type=click.Path(path_type=Path),
    help="Compare with optima by others, too: FOLDER holds reference/optimum.csv and the files of TTOBench.",
)
@click.option("--out", metavar="FILE", type=click.Path(path_type=Path), help="Write a page of Markdown.")
@click.option("--force", is_flag=True, help="Overwrite FILE.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors and what --json asks for.")
def command(references: Path | None, out: Path | None, force: bool, as_json: bool, quiet: bool) -> int:
    """Verify what tgvdp computes on this machine (docs/verification.md).

    Formulas, orders of convergence, enumeration, the methods against each other, the balance of energy and random
    trips: each case says in how many digits two numbers agree. Exit code 1 where one agrees in fewer than it must.
    """
    from tgvdp.report.files import check_new, check_writable, write_files

    if out is not None:
        check_new(out, force=force)
    started_s = time.perf_counter()
    with Screen(quiet=quiet) as screen:
        screen.progress("verifying")
        from tgvdp.verification.report import content_of, page_of, text_of, verify

        if out is not None:
            check_writable(out.parent)
        with screen.compiling():
            cases = verify(references, screen.progress)
        inputs = {} if references is None else {"reference": references / "reference" / "optimum.csv"}
        content = content_of(cases, started_s, inputs)
        if out is not None:
            write_files(out.parent, {out.name: page_of(cases, content).encode()})
    if as_json:
        echo_json(content)
    if not quiet:
        click.echo(text_of(cases), err=as_json)
    return 0 if content["ok"] else TgvdpError.exit_code
