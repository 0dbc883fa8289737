"""The unary form with a multiplier: what its outer loop solves, and what its repair does alone.

``python -m benchmarks.quantum_multiplier`` writes results/quantum/multiplier.csv, from the random families.
"""

import sys
from pathlib import Path
from typing import Any

from benchmarks.families import FAMILIES, members
from benchmarks.timing import ROOT
from tgvdp.formulations.problem.instances import BinaryInstance
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text
from tgvdp.solvers.allowance import Allowance, BetaRange
from tgvdp.solvers.registry import solve

SIZES = (8, 12, 20, 30)
#: Of the thirty of each family and size, as many as fit into minutes.
INSTANCES = 10
ALLOWANCE = Allowance(reads=10, sweeps=200, beta=BetaRange(0.5, 20.0))


def multiplier_rows() -> list[dict[str, Any]]:
    """One row per family and size."""
    return [_row(family, steps) for family in FAMILIES for steps in SIZES]


def _row(family: str, steps: int) -> dict[str, Any]:
    counts = dict.fromkeys(("best_reads", "best_reads_unrepaired", "repair_alone"), 0)
    for member in members(family, steps, "sample")[:INSTANCES]:
        instance = member.entry.instance
        assert isinstance(instance, BinaryInstance)
        optimum = solve(instance, "dp").objective
        found = solve(instance, "multiplier", allowance=ALLOWANCE)
        if _same(found.objective, optimum):
            for name in ("best_reads", "best_reads_unrepaired"):
                counts[name] += found.details[name]
        counts["repair_alone"] += _same(found.details["repair_alone"], optimum)
    print(family, steps, counts, flush=True)
    return {
        "family": family, "N": steps, "instances": INSTANCES, "attempts": INSTANCES * ALLOWANCE.reads,
        "successes": counts["best_reads"], "without repair": counts["best_reads_unrepaired"],
        "solved by the repair alone": counts["repair_alone"],
    }  # fmt: skip


def _same(objective: float | None, optimum: float) -> bool:
    return objective is not None and abs(objective - optimum) <= 1e-12 * abs(optimum)


def main(folder: Path) -> None:
    """Write the table."""
    write_files(folder, {"multiplier.csv": csv_text(multiplier_rows())})


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results" / "quantum")
