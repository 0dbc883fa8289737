"""Attempts that are shorter than those that tuning tried: ``python -m benchmarks.quantum_short`` writes short.csv.

Tuning (benchmarks.quantum_tuning) tries attempts of 100 sweeps or 3 layers at least, and where those win the effort to
a success need not be the least there is: it is too large at small sizes, so that its growth with N comes out too small
(Rønnow et al., Science 345, 420, 2014, on sweeps that are not optimal). Here shorter attempts with the same settings
are tried where that is so for unary, chosen on the instances of tuning and run on the reported ones.
"""

import csv
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks.families import SIZES
from benchmarks.quantum_tuning import TUNABLES, TUNING, chosen_words
from benchmarks.quantum_weights import READS, Trial, outcome, score
from benchmarks.timing import ROOT
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text

#: Efforts that are tried besides the least of tuning, in sweeps (of up to eight replicas together) and in layers.
SHORTER = {"sweeps=100": ("sweeps=8", "sweeps=16", "sweeps=32"), "layers=3": ("layers=1", "layers=2")}


def short_rows(reached: Path) -> Iterator[dict[str, Any]]:
    """One row per solver, family and size where the least effort of tuning had won."""
    warnings.simplefilter("ignore", FormulationWarning)
    with reached.open(encoding="utf-8", newline="") as file:
        known = {(row["solver"], row["family"], row["N"]): row for row in csv.DictReader(file)}
    solvers = [tunable.word for tunable in TUNABLES]
    for (family, steps), words in chosen_words(TUNING).items():
        for word in words:
            solver = max((one for one in solvers if word.startswith(one + ":")), key=len)
            least = word.rsplit(":", 1)[1]
            if ":unary" not in solver or least not in SHORTER or steps not in SIZES[:-1]:
                continue
            trial = Trial(solver, family, steps)
            tried = [word, *(word.removesuffix(least) + shorter for shorter in SHORTER[least])]
            best = min(tried, key=lambda one: score(trial, one, READS))
            row = {"solver": solver, "family": family, "N": steps, **outcome(trial, best)}
            row["TTS99 sweeps of tuning"] = known[solver, family, str(steps)]["TTS99 sweeps"]
            print(row, flush=True)
            yield row


def main(folder: Path) -> None:
    """Write the table."""
    write_files(folder, {"short.csv": csv_text(list(short_rows(folder / "ensembles.csv")))})


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results" / "quantum")
