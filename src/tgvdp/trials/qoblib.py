"""Runs as submissions to QOBLIB (arXiv 2504.03832): a folder per solver, in it one per instance.

Each holds ``NAME_summary.csv`` with QOBLIB's 27 columns in its order, runtimes averaged over runs and N/A where there
is nothing to say, and ``NAME_solution.sol`` with the controls of the best run, one a line. Its checker demands a
solution, so that instances on which a solver found no feasible plan are left out. ``check.py`` beside them, which needs
nothing but Python, judges a solution of an instance (`tgvdp.instances.check`).
"""

import csv
import io
import re
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tgvdp import __version__
from tgvdp.instances import CHECKER
from tgvdp.report.files import write_files
from tgvdp.trials.execute import Results
from tgvdp.trials.rows import Row

COLUMNS = (
    "Problem", "Submitter", "Date", "Reference", "Best Objective Value", "Optimality Bound", "Modeling Approach",
    "# Decision Variables", "# Binary Variables", "# Integer Variables", "# Continuous Variables",
    "# Non-Zero Coefficients", "Coefficients Type", "Coefficients Range", "Workflow", "Algorithm Type", "# Runs",
    "# Feasible Runs", "# Successful Runs", "Success Threshold", "Hardware Specifications", "Total Runtime",
    "CPU Runtime", "GPU Runtime", "QPU Runtime", "Other HW Runtime", "Remarks",
)  # fmt: skip
_NOTHING = "N/A"


def write_submissions(results: Results, rows: Sequence[Row], folder: Path, submitter: str) -> int:
    """Write all instances that some solver solved feasibly; returns how many folders of instances there are.

    Raises
    ------
    InputError
        When a file cannot be written.
    """
    cases = {case.instance.id: case for case in results.plan.cases}
    written = 0
    for row in rows:
        name = row["Problem"]
        runs = [run for run in results.runs[name, row["Workflow"]] if run["status"] == "ok" and run["feasible"]]
        if not runs:
            continue
        best = min(runs, key=lambda run: run["objective"])
        home = folder / _slug(row["Workflow"]) / _slug(name)
        summary = row | {
            "Problem": home.name, "Submitter": submitter, "Date": datetime.now(UTC).date().isoformat(),
            "Reference": f"tgvdp {__version__}",
        }  # fmt: skip
        solution = "".join(f"{control!r}\n" for control in best["controls"])
        write_files(
            home,
            {f"{home.name}_summary.csv": _csv(summary), f"{home.name}_solution.sol": solution.encode()},
        )
        write_files(folder / "instances", {f"{home.name}.json": cases[name].path.read_bytes()})
        written += 1
    write_files(folder, {CHECKER.name: CHECKER.read_bytes()})
    return written


def _slug(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9._-]+", "-", text)


def _csv(row: dict[str, Any]) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerow([_NOTHING if row.get(name) is None else row[name] for name in COLUMNS])
    return text.getvalue().encode()
