"""``tgvdp decode``: bit strings from outside, decoded, judged and replayed."""

from pathlib import Path
from typing import Any

import click

from tgvdp.cli import echo_json
from tgvdp.cli.completions import complete_file, complete_instance
from tgvdp.cli.solve import qubo_options, solution_object, table
from tgvdp.errors import BudgetExceededError, InputError

_EXAMPLES = """
\b
Examples:
  tgvdp formulate easy-n008 --to bqm -o easy.bqm      what another program samples
  tgvdp decode easy-n008 samples.json                 its SampleSet, or counts of bit strings
  tgvdp decode trip.json samples.csv --encoding bits --penalty 2 --json
"""


@click.command("decode", epilog=_EXAMPLES)
@click.argument("instance", metavar="INSTANCE", shell_complete=complete_instance)
@click.argument("samples", metavar="SAMPLES", shell_complete=complete_file)
@qubo_options
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of a table.")
def command(instance: str, samples: str, encoding: Any, penalty: Any, as_json: bool) -> int:
    """Decode SAMPLES of the QUBO of INSTANCE that another program drew, and replay the best of them.

    SAMPLES is JSON of a dimod SampleSet (to_serializable), JSON of counts as qiskit returns them (the last bit is the
    first qubit), or CSV with a column for each bit and perhaps one "count". Encoding and penalty are those with which
    the QUBO was written. The exit code is 5 when no sample satisfies all constraints.
    """
    from tgvdp import instances
    from tgvdp.formulations.problem.instances import DemandInstance
    from tgvdp.formulations.problem.reading import read_instance
    from tgvdp.formulations.qubo.encodings import default_encoding, encode
    from tgvdp.solvers.outside import samples_of_file
    from tgvdp.solvers.samplers.sampling import sampled_solution

    problem = read_instance(instances.find(instance))
    if isinstance(problem, DemandInstance):
        raise InputError(f"{problem.id}: a demand instance is no QUBO: there are no bits to decode")
    encoded = encode(problem, encoding or default_encoding(problem), penalty)
    try:
        content = Path(samples).read_bytes()
    except OSError as error:
        raise InputError(f"{samples}: cannot be read: {error.strerror}") from None
    found = samples_of_file(content, samples, encoded.qubo)
    solution = sampled_solution("decode", encoded, found, 0.0, {})
    if as_json:
        echo_json(solution_object(problem, solution))
    else:
        click.echo(table(problem, solution))
    return 0 if solution.feasible else BudgetExceededError.exit_code
