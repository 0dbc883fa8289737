"""The formulations as printed, measured: ``python -m benchmarks.quantum_printed`` writes results/quantum/printed.

`demand_rows` solves the approximations of the published demand instances, as programs by SCIP and as the constrained
quadratic models that a hybrid service gets, and drives what comes out on the true curves. `qubo_rows` lists all strings
of the printed QUBOs of small binary instances and judges those of least energy.
"""

import sys
import warnings
from pathlib import Path
from typing import Any

from benchmarks.timing import ROOT
from tgvdp.errors import BudgetExceededError, InputError
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.formulations.problem.instances import BinaryInstance, DemandInstance
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.formulations.qubo.names import PENALTIES, Encoding, PenaltyName
from tgvdp.formulations.qubo.qubo import bits_of
from tgvdp.instances import find, index
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text
from tgvdp.solvers.allowance import FORMS, Allowance, FormChoice
from tgvdp.solvers.registry import solve
from tgvdp.solvers.samplers.sampling import lowest

FOLDER = ROOT / "results" / "quantum" / "printed"
LIMIT_S = 60.0
#: Most bits of which all strings are listed.
MOST_BITS = 20
#: Forms of the two-bit QUBO: corrected, and as printed piece by piece, up to the whole of it.
WORDS = ("bits", "bits+slack", "bits+total", "bits+total-equality", "bits+total-equality+right+mccormick", "bits+cubic")

#: Columns of what came out of an approximation.
_DRIVEN = (
    "plan", "elapsed_s", "feasible by replay", "distance missed m", "tolerance m", "end speed m/s",
    "approximate cost J", "cost by replay J", "certified optimum J", "dearer %",
)  # fmt: skip


def demand_rows() -> list[dict[str, Any]]:
    """One row per published demand instance, solver and form."""
    known = {name: float(row["objective"]) for name, row in index().items() if row["kind"] == "demand"}
    cases = [(read_instance(find(name)), optimum_j) for name, optimum_j in known.items()]
    return [
        _demand_row(instance, optimum_j, solver, form)
        for instance, optimum_j in cases
        if isinstance(instance, DemandInstance)
        for solver in ("scip", "cqm")
        for form in FORMS
    ]


def _demand_row(instance: DemandInstance, optimum_j: float, solver: str, form: FormChoice) -> dict[str, Any]:
    row: dict[str, Any] = {"Problem": instance.id, "N": instance.steps, "solver": solver, "form": form}
    print(*row.values(), flush=True)
    try:
        found = solve(instance, solver, allowance=Allowance(form=form, time_limit_s=LIMIT_S))
    except BudgetExceededError as error:
        return row | dict.fromkeys(_DRIVEN) | {"plan": "none in time" if "within" in str(error) else "none"}
    driven = found.replay
    values = (
        "optimum" if found.details["approximate_optimum_proved"] else "best in time",
        found.elapsed_s,
        driven["feasible"],
        driven["distance_error_m"],
        instance.tol_m,
        driven["end_speed_error_mps"],
        found.details["approximate_objective_j"],
        driven["objective"],
        optimum_j,
        100.0 * (driven["objective"] / optimum_j - 1.0),
    )
    return row | dict(zip(_DRIVEN, values, strict=True))


def qubo_rows() -> list[dict[str, Any]]:
    """One row per published binary instance of few steps, form and rule; counts where its strings can be listed."""
    rows = []
    for name, known in index().items():
        instance = read_instance(find(name))
        if isinstance(instance, BinaryInstance) and 2 * instance.steps <= MOST_BITS:
            rows += [
                row
                for word in WORDS
                for penalty in PENALTIES
                if (row := _qubo_row(instance, word, penalty, float(known["objective"]))) is not None
            ]
    return rows


def _qubo_row(instance: BinaryInstance, word: Encoding, penalty: PenaltyName, optimum: float) -> dict[str, Any] | None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormulationWarning)
        try:
            encoded = encode(instance, word, penalty)
        except InputError:
            return None  # the cubic objective is that of one model
    row = {
        "Problem": instance.id, "N": instance.steps, "encoding": word, "penalty": penalty, "bits": encoded.qubo.n,
        "weight": encoded.penalty, "ground states": None, "feasible": None, "optimal": None,
    }  # fmt: skip
    if encoded.qubo.n > MOST_BITS:
        return row
    ground = lowest(encoded.qubo.all_energies(), encoded.qubo)
    schedules = [encoded.decode(bits_of(int(string), encoded.qubo.n)) for string in ground]
    feasible = [one for one in schedules if one.feasible]
    optimal = sum(abs(one.objective - optimum) <= 1e-12 * max(1.0, abs(optimum)) for one in feasible)
    return row | {"ground states": len(schedules), "feasible": len(feasible), "optimal": optimal}


def main(folder: Path) -> None:
    """Write both tables."""
    write_files(folder, {"qubo.csv": csv_text(qubo_rows()), "demand.csv": csv_text(demand_rows())})


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
