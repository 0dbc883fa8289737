"""``tgvdp sweep report``: what a finished sweep says about its network."""

from pathlib import Path

import click

from tgvdp.cli import echo_json
from tgvdp.cli.completions import complete_folder
from tgvdp.cli.groups import GroupedCommand
from tgvdp.cli.numbers import number
from tgvdp.cli.screen import Screen

_EXAMPLES = """
\b
Examples:
  tgvdp sweep report network
  tgvdp sweep report network --margin 8 --out network-8
"""


@click.command("report", cls=GroupedCommand, epilog=_EXAMPLES)
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option(
    "--margin", "margin_pct", metavar="PCT", type=number("%", at_least=0.0), default="5", show_default=True,
    help="Running time above the fastest run's.",
)  # fmt: skip
@click.option(
    "--out", metavar="DIR", shell_complete=complete_folder, help="Folder of the report.  [default: DIR/report]"
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object on stdout, everything else on stderr.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors and what --json asks for.")
def command(folder: Path, margin_pct: float, out: str | None, as_json: bool, quiet: bool) -> None:
    """Say what a margin saves over the network that a sweep in DIR ran.

    Writes report.md and .json, a table with the saving of each scenario and one of what it depends on, and pictures:
    how savings are spread, on what they depend (tornado), and maps over two axes.
    """
    from tgvdp.report import check_writable
    from tgvdp.sweeps.output import write_report
    from tgvdp.sweeps.summary import read_savings

    home = Path(out) if out is not None else folder / "report"
    with Screen(quiet=quiet) as screen:
        screen.progress("reading")
        savings = read_savings(folder, margin_pct)
        check_writable(home)
        screen.progress("drawing and writing")
        content, files = write_report(savings, folder, home)
    if as_json:
        echo_json(content)
    if not quiet:
        network, shares = content["network"], content["distribution_pct"]
        click.echo(
            f"{margin_pct:g} % more running time saves {network['saved_pct']:.2f} %: {network['saved_kwh']:.6g} of"
            f" {network['fastest_kwh']:.6g} kWh; median {shares['50']:.2f} %, nine of ten scenarios between"
            f" {shares['5']:.2f} and {shares['95']:.2f} %",
            err=as_json,
        )
        for one in content["sensitivity"]:
            ends = sorted(one["levels"], key=lambda level: level["saved_pct"])
            click.echo(
                f"  by {one['axis']}: {ends[0]['saved_pct']:.2f} % at {ends[0]['value']}"
                f" to {ends[-1]['saved_pct']:.2f} % at {ends[-1]['value']}",
                err=as_json,
            )
        if "warning" in content:
            click.echo(f"tgvdp: warning: {content['warning']}", err=True)
        for note in content.get("notes", ()):
            click.echo(f"tgvdp: note: {note}", err=True)
        click.echo(f"in {home}: {', '.join(file.name for file in files)}", err=as_json)
