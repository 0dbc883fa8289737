"""``tgvdp validate``: what files hold, or what is wrong with them."""

import textwrap

import click

from tgvdp.errors import InputError

_EXAMPLES = """
\b
Examples:
  tgvdp validate line.json train.json
  tgvdp validate scenario.toml
  tgvdp validate -v train.yaml                   with a report of unusual values and their lines
"""


@click.command("validate", epilog=_EXAMPLES)
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option("-v", "--verbose", is_flag=True, help="Hold the values of trains and lines against their usual ranges.")
def command(files: tuple[str, ...], verbose: bool) -> int:
    """Say what each FILE holds or what is wrong with it.

    All files are read. The exit code is 3 when any of them is wrong; a value that is unusual is a warning only.
    """
    from tgvdp.formats import describe_file
    from tgvdp.formats.review.plausibility import review_file

    exit_code = 0
    for file in files:
        try:
            click.echo(f"{file}: {describe_file(file)}")
            for review in review_file(file) if verbose else ():
                click.echo(textwrap.indent(str(review), "  "))
        except InputError as error:
            click.echo(f"tgvdp: error: {error}", err=True)
            exit_code = error.exit_code
    return exit_code
