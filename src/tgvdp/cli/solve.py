"""``tgvdp solve``: solve one instance of the formulations and replay what comes out."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import click

from tgvdp.cli import echo_json
from tgvdp.cli.completions import complete_instance
from tgvdp.cli.numbers import number
from tgvdp.cli.screen import Screen
from tgvdp.errors import BudgetExceededError, InputError
from tgvdp.formulations.qubo.names import ENCODINGS, PENALTIES, parse_encoding, parse_penalty
from tgvdp.solvers.allowance import ITEMS, Allowance, Item, beta_range
from tgvdp.solvers.registry import SOLVERS

if TYPE_CHECKING:
    from tgvdp.formulations.problem.instances import Instance
    from tgvdp.formulations.problem.schedule import Schedule, Solution

_METAVARS: dict[Any, str] = {str: "NAME", int: "INTEGER", beta_range: "LOW..HIGH"}

_Command = TypeVar("_Command", bound=Callable[..., Any])

SCHEMA = "tgvdp.solve/2"

_EXAMPLES = """
\b
Examples:
  tgvdp solve easy-n008 --solver dp
  tgvdp solve trip.json --solver sa --encoding unary --penalty sufficient --json
"""


class _Word(click.ParamType[Any]):
    """Text that a function reads, and that it refuses with a `ValueError`."""

    def __init__(self, name: str, read: Callable[[str], Any], what: str) -> None:
        self.name = name
        self._read = read
        self._what = what

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read it."""
        try:
            return self._read(str(value))
        except ValueError:
            self.fail(f"{value!r} is not {self._what}", param, ctx)


_PENALTY = _Word(
    f"{'|'.join(PENALTIES)}|NUMBER[/NUMBER...]", parse_penalty,
    f"{', '.join(PENALTIES)}, a positive number, or two to four of them with / between",
)  # fmt: skip
_ENCODING = _Word(
    "WORD", parse_encoding,
    f"{', '.join(ENCODINGS)}, or bits[+slack|+total|+total-equality][+left|+right][+mccormick][+cubic]",
)  # fmt: skip


def qubo_options(command: _Command) -> _Command:
    """Add ``--encoding`` and ``--penalty``."""
    command = click.option(
        "--penalty", type=_PENALTY, metavar=_PENALTY.name,
        help="Weight of violations in a QUBO, or one each of logic/distance/stop/limit.  "
        "[default: the instance's lambda_uniform, else sufficient]",
    )(command)  # fmt: skip
    return click.option(
        "--encoding", type=_ENCODING, metavar="WORD",
        help=f"Of a QUBO: {', '.join(ENCODINGS)}, or a printed form such as bits+total-equality+right+mccormick.  "
        "[default: unary where both steps are equal, else bits+slack]",
    )(command)  # fmt: skip


def _budget(command: _Command) -> _Command:
    """Add the options of an `Allowance`, as they are declared."""
    for item in reversed(ITEMS):
        default = getattr(Allowance, item.field)
        help_text = item.help if default is None else f"{item.help}  [default: {default}]"
        metavar = None if item.choices else _METAVARS.get(item.read, item.unit.upper() or "NUMBER")
        command = click.option(f"--{item.key}", item.field, type=_type(item), metavar=metavar, help=help_text)(command)
    return command


def _type(item: Item) -> Any:
    if item.choices:
        return click.Choice(item.choices)
    ranged: dict[Any, Any] = {int: click.IntRange(item.least, item.most), float: number(item.unit, above=0.0)}
    return ranged.get(item.read, item.read)


@click.command("solve", epilog=_EXAMPLES)
@click.argument("instance", metavar="INSTANCE", shell_complete=complete_instance)
@click.option("--solver", type=click.Choice(tuple(SOLVERS)), default="dp", show_default=True, help="What solves it.")
@qubo_options
@_budget
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of a table.")
def command(instance: str, solver: str, encoding: Any, penalty: Any, as_json: bool, **budget: Any) -> int:
    """Solve INSTANCE, a problem of the formulations by its built-in name or as a JSON file, and replay the solution.

    The objective is what the model minimises. It is an energy for the kinetic model (J per kg of train), by the cost
    map of the demand model (J), and where trains share a substation (J per kg of a train of mass 1); for the constant
    and the efficiency model, in (m/s)², it is none. The energy by replay always is one. The exit code is 4 when nothing
    satisfies all constraints, and 5 when none was found that does.
    """
    from tgvdp import instances
    from tgvdp.formulations.problem.reading import read_instance
    from tgvdp.solvers.registry import solve

    problem = read_instance(instances.find(instance))
    given = {name: value for name, value in budget.items() if value is not None}
    _require_used(solver, given, {"--encoding": encoding, "--penalty": penalty})
    try:
        allowance = Allowance(**given)
    except InputError as error:
        raise click.UsageError(str(error), click.get_current_context()) from None
    with Screen(quiet=False) as screen, screen.timing(solver):
        solution = solve(problem, solver, encoding, penalty, allowance)
    content = solution_object(problem, solution)
    if as_json:
        echo_json(content)
    else:
        click.echo(table(problem, solution))
    return 0 if solution.feasible else BudgetExceededError.exit_code


def _require_used(solver: str, given: Mapping[str, Any], qubo: Mapping[str, Any]) -> None:
    """Refuse what a solver does not use, all of it by name."""
    context = click.get_current_context()
    idle = [item for item in ITEMS if item.field in given and item.field not in SOLVERS[solver].uses]
    if idle:
        flags = ", ".join(f"--{item.key}" for item in idle)
        users = [other for other, entry in SOLVERS.items() if all(item.field in entry.uses for item in idle)]
        do = f"{', '.join(users)} do" if users else "no solver uses all of them"
        raise click.UsageError(f"solver {solver} does not use {flags}; {do}", context)
    named = [flag for flag, value in qubo.items() if value is not None]
    if named and not SOLVERS[solver].qubo:
        have = "has" if len(named) == 1 else "have"
        raise click.UsageError(f"solver {solver} makes no QUBO: {' and '.join(named)} {have} no effect", context)


def solution_object(problem: "Instance", solution: "Solution") -> dict[str, Any]:
    """Object of schema tgvdp.solve/2."""
    from tgvdp.formulations.problem.instances import DemandInstance
    from tgvdp.report.plain import plain

    schedule = solution.schedule
    content = {
        "schema": SCHEMA,
        "id": problem.id,
        "solver": solution.solver,
        "objective": solution.objective,
        "objective_unit": problem.objective_unit,
        "optimal": solution.optimal,
        "n_optimal": solution.n_optimal,
        "feasible": solution.feasible,
        **(
            {"demand": schedule.controls, "speeds_mps": schedule.speeds, "distance_m": schedule.distance}
            if isinstance(problem, DemandInstance)
            else {"speeds_dv": schedule.speeds, "distance_dv_dt": schedule.distance}
        ),
        "constraints": [
            {"name": check.name, "violation": check.violation, "unit": check.unit} for check in schedule.checks
        ],
        "replay": solution.replay,
        **({"qubo": solution.qubo} if solution.qubo is not None else {}),
        "details": solution.details,
        "elapsed_s": solution.elapsed_s,
    }
    plain_content: dict[str, Any] = plain(content)
    return plain_content


def _meaning(problem: "Instance") -> str:
    """What an objective is of, so that nobody takes it for an energy where it is none."""
    from tgvdp.formulations.problem.instances import BinaryInstance, DemandInstance

    if isinstance(problem, DemandInstance):
        return "by the cost map"
    if not isinstance(problem, BinaryInstance):
        return "from the substation"
    return f"of the {problem.model} model" + ("" if problem.model == "kinetic" else ", not an energy")


def _speeds(problem: "Instance", schedule: "Schedule") -> Iterator[tuple[str, Sequence[float]]]:
    """Speeds of each train."""
    from tgvdp.formulations.problem.instances import SubstationInstance

    if not isinstance(problem, SubstationInstance):
        yield "speeds", schedule.speeds
        return
    start = 0
    for k, train in enumerate(problem.trains, start=1):
        yield f"speeds, train {k}", schedule.speeds[start : start + train.trip.steps + 1]
        start += train.trip.steps + 1


def _reads(solution: "Solution") -> list[tuple[str, str]]:
    """How often a sampler came to what."""
    details = solution.details
    if "reads" not in details:
        return []
    reads, feasible, best = (details[name] for name in ("reads", "feasible_reads", "best_reads"))
    share = f", {100.0 * best / reads:.1f} % of all" if best else ""
    rows = [("reads", f"{reads}, {feasible} feasible; {best} reach this objective{share}")]
    chance = details.get("success_probability")
    if chance is not None:
        what = "of the optimum, in these shots" if details.get("backend") else "of the optimum, of a shot, exact"
        rows.append(("success", f"{chance:.4g} {what}"))
    return rows


def table(problem: "Instance", solution: "Solution") -> str:
    """What people read: result, constraints, replay."""
    from tgvdp.formulations.problem.instances import DemandInstance

    schedule, replayed = solution.schedule, solution.replay
    whole = not isinstance(problem, DemandInstance)
    proof = "optimal, proved" if solution.optimal else "best found" if solution.feasible else "no feasible plan found"
    rows = [("objective", f"{solution.objective:.9g} {problem.objective_unit} {_meaning(problem)}  ({proof})")]
    if solution.n_optimal is not None:
        rows.append(("optima", f"{solution.n_optimal}"))
    if whole:
        rows += [(name, " ".join(f"{v:g}" for v in speeds) + " Δv") for name, speeds in _speeds(problem, schedule)]
    else:
        rows.append(("demand", " ".join(f"{d:g}" for d in schedule.controls)))
        rows.append(("speeds", " ".join(f"{v:.4g}" for v in schedule.speeds) + " m/s"))
    rows.append(("distance", f"{schedule.distance:.9g} {'Δv·Δt' if whole else 'm'}"))
    rows += [
        (check.name, "holds" if check.satisfied else f"violated by {check.violation:.6g} {check.unit}")
        for check in schedule.checks
    ]
    errors = f"distance {replayed['distance_error_m']:+.4g} m, end speed {replayed['end_speed_error_mps']:+.4g} m/s"
    rows.append(("replay", f"{'feasible' if replayed['feasible'] else 'NOT feasible'}, {errors}"))
    energy = f"{replayed['energy']:.6g} {replayed['energy_unit']}"
    if not whole:
        energy += f" by the cost map, {replayed['mechanical_j']:.6g} J of traction at the wheel"
    rows.append(("energy by replay", energy))
    if solution.qubo is not None:
        rows.append(("QUBO", f"{solution.qubo['variables']} variables, {solution.qubo['couplers']} couplers"))
    rows += _reads(solution)
    if solution.elapsed_s:
        rows.append((solution.solver, f"{solution.elapsed_s:.4g} s"))
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {text}" for name, text in rows)
