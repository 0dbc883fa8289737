"""The published runs: ``python -m benchmarks quantum`` fills results/quantum and goes on where it was.

Random families by tuned solvers (benchmarks.families, benchmarks.quantum_tuning), the published instances by the exact
ones, embeddings, and the statements of docs/quantum-benchmark.md.
"""

import sys
import time
from pathlib import Path

from benchmarks import (
    quantum_effort,
    quantum_greedy,
    quantum_multiplier,
    quantum_printed,
    quantum_resources,
    quantum_short,
    quantum_weights,
    substation_weights,
    substations,
)
from benchmarks.families import FAMILIES, SIZES, members, write
from benchmarks.output import replace_between
from benchmarks.quantum_claims import BEGIN, END, claims
from benchmarks.quantum_penalties import penalty_rows
from benchmarks.quantum_tuning import TUNING, chosen_words
from benchmarks.timing import ROOT
from tgvdp.cli import main as tgvdp
from tgvdp.instances import find, index
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text
from tgvdp.trials.execute import Plan, Results, merged, run_benchmark
from tgvdp.trials.output import write_benchmark
from tgvdp.trials.reference import read_cases
from tgvdp.trials.spec import parse_spec

#: The page that states what the runs show.
PAGE = ROOT / "docs" / "quantum-benchmark.md"
#: Where the instances of the families are written.
INSTANCES = ROOT / "build" / "quantum-families"
#: Solvers that are not tuned.
EXACT = ("dp", "milp:time-limit=2")
#: Sizes of the families that are run, and attempts on each instance; at N = 40 only single instances are (`NAMED`).
REPORTED = SIZES[:-1]
READS = 50
#: Embeddings, of the sizes that minorminer embeds within a minute.
EMBEDDED = tuple(f"easy-n{steps:03d}" for steps in (4, 6, 8, 10, 12, 14, 16, 20))
#: All single trains of the library by the exact solvers.
LIBRARY = ("dp", "milp:time-limit=10:runs=1", "closed")
#: Published instances on which the solvers tuned for their family and a size are run as well, and further words there:
#: QAOA with optimised angles, and with a longer ramp than the least effort asks for.
NAMED = {
    "easy-n008": (8, ("qaoa:unary:penalty=0.1:layers=3:starts=1",)),
    "easy-n009": (8, ("qaoa:unary:angles=ramp:penalty=0.1:step=1.2:layers=100",)),
    "easy-n040": (40, ()),
    "zones-n040": (40, ()),
}


def families(folder: Path) -> Results:
    """Runs of the tuned solvers on the random families, one run of each on each instance."""
    write(INSTANCES)
    words = chosen_words(TUNING)
    parts = []
    for steps in REPORTED:
        for family in FAMILIES:
            cases = read_cases([INSTANCES / f"{one.name}.json" for one in members(family, steps, "sample")])
            solvers = [*EXACT, *(f"{word}:reads={READS}" for word in words.get((family, steps), ()))]
            plan = Plan(tuple(cases), tuple(map(parse_spec, solvers)), 1)
            parts.append(run_benchmark(plan, folder, _progress))
    return merged(parts)


def named(folder: Path) -> None:
    """Runs of the tuned solvers on published instances."""
    started, words = time.perf_counter(), chosen_words(TUNING)
    parts = []
    for name, (steps, more) in NAMED.items():
        solvers = [f"{word}:reads=100" for word in (*words[name.partition("-")[0], steps], *more)]
        plan = Plan(tuple(read_cases([find(name)])), tuple(map(parse_spec, solvers)), 1)
        parts.append(run_benchmark(plan, folder, _progress))
    write_benchmark(merged(parts), folder, time.perf_counter() - started)


def _progress(done: int, total: int, what: str) -> None:
    if done == total:
        print(f"{time.strftime('%H:%M:%S')} {total} works", flush=True)


def commands(folder: Path) -> list[list[str]]:
    """Arguments of `tgvdp bench` for what is not of the families."""
    single = [name for name, row in index().items() if row["kind"] != "substation"]
    drawn = ",".join(f"random:{word}:reads=100:runs=1" for word in ("bits", "unary", "unary+multiplier"))
    return [
        [*EMBEDDED, "--solvers", drawn, "--embed", "pegasus,zephyr", "--out", str(folder / "embeddings")],
        [*single, "--solvers", ",".join(LIBRARY), "--runs", "3", "--out", str(folder / "exact")],
    ]


def main(folder: Path) -> None:
    """Make the runs that are missing, all tables and pictures, and the statements of the page."""
    started = time.perf_counter()
    write_benchmark(families(folder), folder, time.perf_counter() - started)
    named(folder / "named")
    for arguments in commands(folder):
        code = tgvdp(["bench", *arguments])
        if code:
            sys.exit(code)
    write_files(folder, {"penalties.csv": csv_text(penalty_rows())})
    quantum_printed.main(folder / "printed")
    quantum_multiplier.main(folder)
    quantum_resources.main(folder)
    quantum_greedy.main(folder)
    quantum_effort.main(folder)
    quantum_weights.main(folder)
    quantum_short.main(folder)
    substations.main(folder / "substations")
    substation_weights.main(folder / "substations")
    replace_between(PAGE, BEGIN, END, claims(folder))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results" / "quantum")
