"""``tgvdp validate``: what files hold, or what is wrong with them."""

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from tgvdp.cli.completions import complete_file
from tgvdp.cli.numbers import LINE_SPEED
from tgvdp.errors import InputError
from tgvdp.units import kmh_to_mps

if TYPE_CHECKING:
    from tgvdp.formats import Description
    from tgvdp.formats.review.plausibility import Review

_EXAMPLES = """
\b
Examples:
  tgvdp validate line.json train.json
  tgvdp validate scenario.toml
  tgvdp validate --line-speed 100 plan.railml    a line without speed limits
  tgvdp validate -v train.yaml                   with all values that have usual ranges, and their lines
  tgvdp validate sweep.toml                      what a sweep would run
"""


@click.command("validate", epilog=_EXAMPLES)
@click.argument("files", nargs=-1, required=True, metavar="FILE...", shell_complete=complete_file)
@click.option("-v", "--verbose", is_flag=True, help="Also tell values of trains and lines in their usual ranges.")
@click.option("--line-speed", "line_speed_kmh", **LINE_SPEED)
def command(files: tuple[str, ...], verbose: bool, line_speed_kmh: float | None) -> int:
    """Say what each FILE holds or what is wrong with it.

    All files are read. The exit code is 3 when any of them is wrong; a value that is unusual is a warning only.
    """
    speed_mps = None if line_speed_kmh is None else kmh_to_mps(line_speed_kmh)
    exit_code, are_lines = 0, False
    for file in files:
        try:
            held, reviews = _held(file, speed_mps)
            click.echo(f"{file}: {held}")
            are_lines |= any(review.kind == "track" for review in reviews)
            for review in reviews if verbose else (review.unusual for review in reviews if review.warnings):
                click.echo(textwrap.indent(str(review), "  "))
        except InputError as error:
            click.echo(f"tgvdp: error: {error}", err=True)
            exit_code = error.exit_code
    if line_speed_kmh is not None and not exit_code and not are_lines:
        raise click.UsageError("--line-speed is for lines: no file holds one", click.get_current_context())
    return exit_code


def _held(file: str, line_speed_mps: float | None) -> "tuple[Description, Sequence[Review]]":
    """What a file holds, and how usual that is."""
    from tgvdp.formats import describe_file
    from tgvdp.formats.review.plausibility import review_file
    from tgvdp.formats.sources import locate
    from tgvdp.formats.syntax.reading import bad, read_document, shown
    from tgvdp.formats.unknown import is_sweep
    from tgvdp.sweeps.read import read_spec
    from tgvdp.sweeps.review import describe_spec, review_spec

    path, part = locate(file)
    if is_sweep(read_document(path)):
        if part is not None:
            raise bad(path, f"is the spec of a sweep, of which {shown(part)} chooses nothing")
        if line_speed_mps is not None:
            raise bad(path, "is the spec of a sweep: a line speed would change nothing")
        spec = read_spec(path)
        return describe_spec(spec, path.stem), review_spec(spec)
    held = describe_file(file, line_speed_mps=line_speed_mps)
    return held, review_file(file, line_speed_mps=line_speed_mps)
