"""What a plan without search solves: ``python -m benchmarks.quantum_greedy`` writes results/quantum/greedy.csv.

Of the library and of all reported instances of the random families: where the greedy plan is an optimum, a sampler that
finds one has not shown that it was needed.
"""

import sys
import warnings
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import Any

from benchmarks.families import FAMILIES, SIZES, members
from benchmarks.library import entries
from benchmarks.quantum_draws import optima
from benchmarks.timing import ROOT
from tgvdp.errors import BudgetExceededError, InputError
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.formulations.problem.instances import Instance
from tgvdp.instances import index
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text
from tgvdp.solvers.registry import solve


def greedy_rows() -> Iterator[dict[str, Any]]:
    """One row per family of the library, and per family and size of the random ones."""
    warnings.simplefilter("ignore", FormulationWarning)
    published = {name: float(row["objective"]) for name, row in index().items() if row["objective"]}
    for family, found in groupby((one for one in entries() if one.name in published), lambda one: one.family):
        above = [_above(one.instance, published[one.name]) for one in found]
        if None not in above:
            yield _row("library", family, "", above)
    for family in FAMILIES:
        for steps in SIZES:
            drawn = members(family, steps, "sample")
            yield _row("random", family, steps, [_above(one.entry.instance, optima()[one.name]) for one in drawn])


def _above(instance: Instance, optimum: float) -> float | None:
    """Excess over the optimum in per cent, infinite without a plan; nothing where such instances are refused."""
    try:
        found = solve(instance, "greedy")
    except InputError:
        return None
    except BudgetExceededError:
        return float("inf")
    if not found.feasible:
        return float("inf")
    excess = found.objective - optimum
    return 100.0 * excess / optimum if excess else 0.0  # of nothing where all braking energy comes back


def _row(where: str, family: str, steps: int | str, above: list[float | None]) -> dict[str, Any]:
    found = [one for one in above if one is not None]
    print(where, family, steps, flush=True)
    return {
        "instances from": where, "family": family, "N": steps, "instances": len(found),
        "solved": sum(one <= 1e-10 for one in found), "no plan": sum(one == float("inf") for one in found),
        "worst above %": round(max((one for one in found if one < float("inf")), default=0.0), 6),
    }  # fmt: skip


def main(folder: Path) -> None:
    """Write the table."""
    write_files(folder, {"greedy.csv": csv_text(list(greedy_rows()))})


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results" / "quantum")
