"""Study random windows.

``python -m benchmarks.windows [--seeds N] [--first SEED] [--minutes M] [--late] [--out FOLDER]``
"""

import argparse
import sys
import time
from pathlib import Path

from benchmarks.timing import ROOT
from benchmarks.windows.study import judged
from benchmarks.windows.tables import summary, write
from tgvdp.report.plain import markdown_table, shown


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.windows", description="Study random windows.")
    parser.add_argument("--seeds", type=int, default=120, help="number of lines")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--minutes", type=float, default=60.0, help="no line is begun after these")
    parser.add_argument("--late", action="store_true", help="windows that open later than runs that save energy pass")
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "journeys", help="folder of the results")
    options = parser.parse_args(arguments)
    started = time.perf_counter()
    rows = []
    for seed in range(options.first, options.first + options.seeds):
        if rows and time.perf_counter() - started > 60.0 * options.minutes:
            break
        rows.append(judged(seed, options.late))
        row = rows[-1]
        found = row["refused"] or f"{row['points']} points, above the grid {shown(row['above_grid_pct'])} %"
        print(seed, found, flush=True)
    write(rows, options.out, time.perf_counter() - started)
    print(markdown_table(summary(rows)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
