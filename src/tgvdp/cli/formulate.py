"""``tgvdp formulate``: an instance as a file of another program."""

from pathlib import Path
from typing import Any

import click

from tgvdp.cli.solve import Penalty
from tgvdp.formulations.qubo.names import ENCODINGS

TARGETS = ("bqm", "coo", "lp", "mps", "qasm3", "graph", "cqm")

_EXAMPLES = """
\b
Examples:
  tgvdp formulate easy-n008 --to lp -o trip.lp
  tgvdp formulate trip.json --encoding unary --to coo -o trip.coo
  tgvdp formulate trip.json --encoding bits --to qasm3 --layers 2 -o -
"""


@click.command("formulate", epilog=_EXAMPLES)
@click.argument("instance", metavar="INSTANCE")
@click.option("--encoding", type=click.Choice(ENCODINGS), help="Of the QUBO.  [default: bits]")
@click.option(
    "--penalty", type=Penalty(), metavar=Penalty.name, help="Weight of violations in the QUBO.  [default: as of solve]"
)
@click.option("--to", "target", type=click.Choice(TARGETS), required=True, help="Format.")
@click.option("--layers", type=click.IntRange(1, 100), default=1, show_default=True, help="qasm3: layers of QAOA.")
@click.option("-o", "--output", metavar="FILE", required=True, help="File to write; - for stdout.")
def command(instance: str, encoding: Any, penalty: Any, target: str, layers: int, output: str) -> None:
    """Write INSTANCE, a built-in name or a JSON file, in a format of other programs.

    bqm, coo, graph and qasm3 hold the QUBO of an encoding (dimod's file, coordinates with a sidecar FILE.json of offset
    and labels, node-link JSON, an OpenQASM 3 circuit whose angles are a ramp); lp and mps hold the linear program,
    cqm (dimod's file) the constrained quadratic model, which is the only format of demand problems.
    """
    from tgvdp import instances
    from tgvdp.formulations.problem.instances import read_instance
    from tgvdp.report.files import write_files
    from tgvdp.solvers.exchange import exported

    if output == "-" and target in ("bqm", "cqm", "coo"):
        what = "comes with a sidecar" if target == "coo" else "is binary"
        raise click.UsageError(f"--to {target} {what}: give a file", click.get_current_context())
    contents = exported(read_instance(instances.find(instance)), target, encoding, penalty, layers)
    if output == "-":
        click.echo(contents[""].decode(), nl=False)
        return
    path = Path(output)
    write_files(path.parent, {path.name + suffix: content for suffix, content in contents.items()})
