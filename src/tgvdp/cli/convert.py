"""``tgvdp convert``: a train, a line, a journey or a scenario from one format into another."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

from tgvdp.cli.numbers import LINE_SPEED
from tgvdp.errors import InputError
from tgvdp.units import kmh_to_mps

if TYPE_CHECKING:
    from tgvdp.formats import Scenario
    from tgvdp.formats.write import Target

#: Formats that can be written, and the suffix that means each.
_TARGETS = ("toml", "json", "ttobench")
_BY_SUFFIX = {".toml": "toml", ".json": "ttobench"}
_PARTS = ("train", "track", "journey", "map")

_EXAMPLES = """
\b
Examples:
  tgvdp convert train.yaml train.toml              native TOML, from any format that tgvdp reads
  tgvdp convert line.xml#t1:up line.json           TTOBench, from one track of a railML file
  tgvdp convert line.csv line.toml                 native TOML, from a table with units in its header
  tgvdp convert line.json line.toml                native TOML, to add to it by hand
  tgvdp convert --to json trip.toml trip.json      native JSON
  tgvdp convert --only train trip.toml emu.json    TTOBench, which holds one thing in a file
"""


@click.command("convert", epilog=_EXAMPLES)
@click.argument("source", metavar="IN", type=click.Path())
@click.argument("target", metavar="OUT", type=click.Path())
@click.option(
    "--to",
    type=click.Choice(_TARGETS),
    help="Format of OUT: toml and json are native.  [default: by its suffix; .json means ttobench]",
)
@click.option("--only", type=click.Choice(_PARTS), help="Write this part of IN alone.")
@click.option("--line-speed", "line_speed_kmh", **LINE_SPEED)
@click.option("--force", is_flag=True, help="Overwrite OUT.")
def command(
    source: str, target: str, to: str | None, only: str | None, line_speed_kmh: float | None, force: bool
) -> int:
    """Convert IN, a file in any format that tgvdp reads or a name of the catalog, to OUT.

    What OUT cannot hold is said on stderr, a line each. What it cannot do without is an error: nothing is written then.
    """
    from tgvdp.formats import load_scenario
    from tgvdp.formats.write import write_bytes
    from tgvdp.report.files import check_new, write_files

    out = Path(target)
    chosen = to or _BY_SUFFIX.get(out.suffix.lower())
    if chosen is None:
        raise click.UsageError(f"{target}: unknown suffix {out.suffix!r}: give --to", click.get_current_context())
    check_new(target, force=force)
    speed_mps = None if line_speed_kmh is None else kmh_to_mps(line_speed_kmh)
    scenario = _part(load_scenario(source, line_speed_mps=speed_mps), source, only)
    idle = "" if speed_mps is None else _idle(scenario, source, speed_mps)
    written = write_bytes(scenario, cast("Target", chosen))
    write_files(out.parent, {out.name: written.data})
    if idle:
        click.echo(f"tgvdp: note: {source}: {idle}", err=True)
    for loss in written.losses:
        click.echo(f"tgvdp: lost: {loss}", err=True)
    return 0


def _idle(scenario: "Scenario", source: str, line_speed_mps: float) -> str:
    """What a line speed, m/s, is for, if it is for nothing."""
    from tgvdp.formats.detect import idle_line_speed

    if scenario.track is None:
        context = click.get_current_context()
        raise click.UsageError(f"--line-speed is for lines: no line of {source} is written", context)
    return idle_line_speed(scenario.track, line_speed_mps)


def _part(scenario: "Scenario", source: str, only: str | None) -> "Scenario":
    """Only the wanted part of what was read."""
    from tgvdp.formats.write import scenario_of

    if only is None:
        return scenario
    part = getattr(scenario, only)
    if part is None:
        raise InputError(f"{source}: holds no {only}")
    return replace(scenario_of(part), kept=scenario.kept)
