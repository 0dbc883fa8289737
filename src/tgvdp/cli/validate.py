"""``tgvdp validate``: what files hold, or what is wrong with them."""

import textwrap

import click

from tgvdp.cli.numbers import LINE_SPEED
from tgvdp.errors import InputError
from tgvdp.units import kmh_to_mps

_EXAMPLES = """
\b
Examples:
  tgvdp validate line.json train.json
  tgvdp validate scenario.toml
  tgvdp validate --line-speed 100 plan.railml    a line without speed limits
  tgvdp validate -v train.yaml                   with a report of unusual values and their lines
"""


@click.command("validate", epilog=_EXAMPLES)
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option("-v", "--verbose", is_flag=True, help="Hold the values of trains and lines against their usual ranges.")
@click.option("--line-speed", "line_speed_kmh", **LINE_SPEED)
def command(files: tuple[str, ...], verbose: bool, line_speed_kmh: float | None) -> int:
    """Say what each FILE holds or what is wrong with it.

    All files are read. The exit code is 3 when any of them is wrong; a value that is unusual is a warning only.
    """
    from tgvdp.formats import describe_file
    from tgvdp.formats.review.plausibility import review_file

    speed_mps = None if line_speed_kmh is None else kmh_to_mps(line_speed_kmh)
    exit_code = 0
    for file in files:
        try:
            click.echo(f"{file}: {describe_file(file, line_speed_mps=speed_mps)}")
            for review in review_file(file, line_speed_mps=speed_mps) if verbose else ():
                click.echo(textwrap.indent(str(review), "  "))
        except InputError as error:
            click.echo(f"tgvdp: error: {error}", err=True)
            exit_code = error.exit_code
    return exit_code
