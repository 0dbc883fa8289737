"""``python -m benchmarks.proof [--trips all|descents] [--seeds N] [--first SEED] ...``: survey random trips."""

import argparse
import sys
import time
from pathlib import Path

from benchmarks.proof.descents import descent_trip
from benchmarks.proof.survey import surveyed
from benchmarks.proof.tables import summary, write
from benchmarks.proof.trips import proof_trip
from benchmarks.timing import ROOT
from tgvdp.report.plain import markdown_table

_DRAWN = {"all": proof_trip, "descents": descent_trip}


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.proof", description="Survey random trips.")
    parser.add_argument("--trips", choices=list(_DRAWN), default="all", help="of all sorts, or neutral on descents")
    parser.add_argument("--seeds", type=int, default=1000, help="number of trips")
    parser.add_argument("--first", type=int, help="first seed; by default one that was not seen before: the clock's")
    parser.add_argument("--minutes", type=float, default=60.0, help="no trip is begun after these")
    parser.add_argument("--out", type=Path, default=ROOT / "results", help="folder of proof.md and proof.csv")
    options = parser.parse_args(arguments)
    first = int(time.time()) if options.first is None else options.first
    started = time.perf_counter()
    rows = []
    for seed in range(first, first + options.seeds):
        if rows and time.perf_counter() - started > 60.0 * options.minutes:
            break
        rows.append(surveyed(_DRAWN[options.trips](seed)))
        row = rows[-1]
        print(
            seed,
            row["kind"],
            row["feature"],
            row["error"] or f"dearer {row['dearer_pct']:.4f} % gap {row['gap_pct']:.4f} %",
            flush=True,
        )
    write(rows, options.out, time.perf_counter() - started)
    print(markdown_table(summary(rows)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
