"""``tgvdp formulate``: an instance as a file of another program, and a trip as an instance."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tgvdp.cli.completions import complete_file, complete_instance
from tgvdp.cli.formulate_trip import trip_instance, trip_options
from tgvdp.cli.groups import GroupedCommand
from tgvdp.cli.solve import qubo_options
from tgvdp.solvers.allowance import FORMS

if TYPE_CHECKING:
    from tgvdp.formulations.problem.instances import Instance

TARGETS = ("instance", "bqm", "coo", "qs", "ising", "lp", "mps", "qasm3", "graph", "cqm")

_EXAMPLES = """
\b
Examples:
  tgvdp formulate easy-n008 --to lp -o trip.lp
  tgvdp formulate trip.json --encoding unary --to coo -o trip.coo
  tgvdp formulate trip.json --encoding bits --to qasm3 --layers 2 -o -
  tgvdp formulate --train tgv --track lgv-100km --steps 40 --to instance -o tgv.json
  tgvdp formulate --train alstom-emu --between 20km:30km --steps 12 --model demand --to instance -o emu.json
"""


@click.command("formulate", cls=GroupedCommand, epilog=_EXAMPLES)
@click.argument("instance", metavar="[INSTANCE]", required=False, shell_complete=complete_instance)
@trip_options
@qubo_options
@click.option("--form", type=click.Choice(FORMS), help="cqm of a demand instance: its approximation.  [default: split]")
@click.option("--to", "target", type=click.Choice(TARGETS), required=True, help="Format.")
@click.option("--layers", type=click.IntRange(1, 100), help="qasm3: layers of QAOA.  [default: 1]")
@click.option(
    "-o", "--output", metavar="FILE", required=True, shell_complete=complete_file, help="File to write; - for stdout."
)
@click.option("--force", is_flag=True, help="Overwrite FILE, and its sidecar.")
def command(
    instance: str | None,
    encoding: Any,
    penalty: Any,
    form: Any,
    target: str,
    layers: int | None,
    output: str,
    force: bool,
    **trip: Any,
) -> None:
    """Write INSTANCE, a built-in name or a JSON file, in a format of other programs.

    bqm, coo, qs, ising, graph and qasm3 hold the QUBO of an encoding (dimod's file, coordinates with a sidecar
    FILE.json of offset and labels, the format of QOBLIB, JSON of fields and couplings of spins, node-link JSON, an
    OpenQASM 3 circuit whose angles are a ramp); lp and mps hold the linear program, cqm (dimod's file) the constrained
    quadratic model, which is the only format of demand problems.

    With --steps the instance is made of a trip, and --to instance writes it. What it leaves out of train and line is
    said on stderr, a line each, and stands in its notes.
    """
    from tgvdp.report.files import check_new, write_files
    from tgvdp.solvers.exchange import exported

    context = click.get_current_context()
    if output == "-" and target in ("bqm", "cqm", "coo"):
        what = "comes with a sidecar" if target == "coo" else "is binary"
        raise click.UsageError(f"--to {target} {what}: give a file", context)
    if target == "instance" and (encoding is not None or penalty is not None or form is not None):
        raise click.UsageError("--to instance holds the problem itself: no encoding, penalty or form", context)
    if layers is not None and target != "qasm3":
        raise click.UsageError(f"--layers is of --to qasm3, not of --to {target}", context)
    problem, source = _problem(context, instance, {name: value for name, value in trip.items() if value is not None})
    contents = {"": source} if target == "instance" else exported(problem, target, encoding, penalty, layers or 1, form)
    if output == "-":
        click.echo(contents[""].decode(), nl=False)
        return
    for suffix in contents:
        check_new(f"{output}{suffix}", force=force)
    path = Path(output)
    write_files(path.parent, {path.name + suffix: content for suffix, content in contents.items()})


def _problem(context: click.Context, instance: str | None, trip: dict[str, Any]) -> "tuple[Instance, bytes]":
    """The instance and its file, of a name or a path, or made of a trip."""
    from tgvdp import instances
    from tgvdp.formulations.problem.reading import parse_instance, read_instance

    if instance is not None and trip:
        raise click.UsageError(f"INSTANCE and {', '.join(f'--{name}' for name in trip)} exclude each other", context)
    if instance is not None:
        path = instances.find(instance)
        return read_instance(path), path.read_bytes()
    if "steps" not in trip:
        raise click.UsageError("give INSTANCE, or --steps to make one of a trip", context)
    made = trip_instance(**trip)
    for loss in made.losses:
        click.echo(f"tgvdp: left out: {loss}", err=True)
    return parse_instance(Path("trip"), made.tree), (
        json.dumps(made.tree, indent=1, ensure_ascii=False) + "\n"
    ).encode()
