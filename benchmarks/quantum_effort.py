"""What more effort and wider penalties reach than the tuned ones: ``python -m benchmarks.quantum_effort``.

Writes results/quantum/effort.csv. Tuning takes the least effort to one success, in the mean over few instances, among
penalties up to 0.8 but on `efficiency`. Where its choice does not solve the median instance of the largest reported
size, the most sweeps and penalties up to eight times as large are tried here, on reported instances, which favours
the solvers.
"""

import sys
import warnings
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

from benchmarks.families import FAMILIES, SIZES, members
from benchmarks.quantum_draws import optima, solved_medians, successes
from benchmarks.quantum_tuning import TUNABLES, Tunable
from benchmarks.timing import ROOT
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text
from tgvdp.solvers.registry import solve
from tgvdp.trials.spec import parse_spec

STEPS = SIZES[-2]
#: Of the thirty instances, and attempts on each.
INSTANCES, READS = 10, 5
PENALTIES = (0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4)


def effort_rows(reached: Path) -> Iterator[dict[str, Any]]:
    """One row per setting, of each solver and family whose median instance the published runs do not solve."""
    warnings.simplefilter("ignore", FormulationWarning)
    solved = solved_medians(reached, STEPS)
    for tunable in TUNABLES:
        for family in FAMILIES:
            if tunable.most_steps >= STEPS and tunable.encoding == "unary" and (tunable.word, family) not in solved:
                yield from (_row(tunable, family, *one) for one in product(PENALTIES, tunable.settings))


def _row(tunable: Tunable, family: str, penalty: float, setting: str) -> dict[str, Any]:
    spec = parse_spec(f"{tunable.word}:penalty={penalty}:{setting}:{tunable.efforts[-1]}:reads={READS}")
    chances = []
    for member in members(family, STEPS, "sample")[:INSTANCES]:
        found = solve(member.entry.instance, spec.solver, spec.encoding, spec.penalty, spec.allowance(1))
        chances.append(successes(found, optima()[member.name]) / READS)
    print(family, spec.label, sorted(chances), flush=True)
    return {
        "solver": tunable.word, "family": family, "N": STEPS, "setting": spec.label, "instances": INSTANCES,
        "solved": sum(chance > 0.0 for chance in chances), "mean success": sum(chances) / INSTANCES,
    }  # fmt: skip


def main(folder: Path) -> None:
    """Write the table."""
    write_files(folder, {"effort.csv": csv_text(list(effort_rows(folder / "ensembles.csv")))})


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results" / "quantum")
