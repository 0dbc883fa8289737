"""The published runs of `tgvdp bench`: ``python -m benchmarks quantum`` fills results/quantum and goes on where it was.

Penalties and sweeps were tuned for the shortest TTS99 on easy-n010, easy-n014 and easy-n024, none of which is reported
(docs/quantum-benchmark.md has the grid). QAOA starts from a ramp, the angles of one layer less, and one random point.
"""

import sys
from pathlib import Path

from benchmarks.output import replace_between
from benchmarks.quantum_claims import BEGIN, END, claims
from benchmarks.quantum_penalties import penalty_rows
from benchmarks.timing import ROOT
from tgvdp.cli import main as tgvdp
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text

#: The page that states what the runs show.
PAGE = ROOT / "docs" / "quantum-benchmark.md"

#: N = 4..60: constant energy without and with slow zones.
REPORTED = (
    *(f"easy-n{steps:03d}" for steps in (4, 6, 8, 9, 12, 16, 20, 30, 40, 60)),
    *(f"zones-n{steps:03d}" for steps in (6, 8, 12, 20, 40, 60)),
)
SOLVERS = (
    "dp",
    "milp:time-limit=60",
    "sa:bits:reads=40",
    "sa:bits:penalty=0.2:sweeps=10000:reads=40",
    "sa:unary:reads=40",
    "sa:unary:penalty=0.2:reads=40",
    "tabu:bits:penalty=0.2:reads=40",
    "tabu:unary:penalty=0.3:sweeps=2000:reads=40",
    *(f"qaoa:{encoding}:layers={p}:starts=1:reads=1000:runs=1" for encoding in ("bits", "unary") for p in (1, 2, 3)),
    "random:bits:reads=1000:runs=1",
    "random:unary:reads=1000:runs=1",
)
#: Embeddings, of the sizes that minorminer embeds within a minute.
EMBEDDED = tuple(f"easy-n{steps:03d}" for steps in (4, 6, 8, 10, 12, 14, 16, 20))
#: The whole library by the exact solvers.
EXACT = ("dp", "milp:time-limit=10:runs=1", "closed")


def runs(folder: Path) -> list[list[str]]:
    """Arguments of the commands."""
    drawn = "random:bits:reads=100:runs=1,random:unary:reads=100:runs=1"
    return [
        [*REPORTED, "--solvers", ",".join(SOLVERS), "--runs", "5", "--out", str(folder)],
        [*EMBEDDED, "--solvers", drawn, "--embed", "pegasus,zephyr", "--out", str(folder / "embeddings")],
        ["--up-to", "200", "--solvers", ",".join(EXACT), "--runs", "3", "--out", str(folder / "exact")],
    ]


def main(folder: Path) -> None:
    """Make the runs that are missing, all tables and pictures, and the statements of the page."""
    for arguments in runs(folder):
        code = tgvdp(["bench", *arguments])
        if code:
            sys.exit(code)
    write_files(folder, {"penalties.csv": csv_text(penalty_rows())})
    replace_between(PAGE, BEGIN, END, claims(folder))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results" / "quantum")
