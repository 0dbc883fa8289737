"""``tgvdp validate``: what files hold, or what is wrong with them."""

import click

from tgvdp.errors import InputError

_EXAMPLES = """
\b
Examples:
  tgvdp validate line.json train.json
  tgvdp validate scenario.toml
"""


@click.command("validate", epilog=_EXAMPLES)
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
def command(files: tuple[str, ...]) -> int:
    """Say what each FILE holds or what is wrong with it.

    All files are read. The exit code is 3 when any of them is wrong.
    """
    from tgvdp.formats import describe_file

    exit_code = 0
    for file in files:
        try:
            click.echo(f"{file}: {describe_file(file)}")
        except InputError as error:
            click.echo(f"tgvdp: error: {error}", err=True)
            exit_code = error.exit_code
    return exit_code
