"""Samplers on trains at one substation with a weight for each kind of violation: ``-m benchmarks.substation_weights``.

Writes results/quantum/substations/weights.csv. The grid of `benchmarks.substations` gives all violations one weight.
The power of a step is an equation of large whole numbers, of which one is worth half a J/kg or less, and its violation
is squared: a weight that holds registers in order and distances freezes moves that change power. Here settings are
drawn at random, the same number with one weight and with one for each kind, picked on the instance itself, and the best
is run again with attempts of its own.
"""

import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.entry import Draw
from benchmarks.quantum_draws import drawn_words, successes
from benchmarks.substations import COMPARED, LIMITS, names
from benchmarks.timing import ROOT
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.formulations.qubo.names import kinds_of
from tgvdp.instances import find, index
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text
from tgvdp.solvers.registry import solve
from tgvdp.trials.spec import parse_spec

#: Settings that are drawn, those that are tried again, and attempts at first, then, and of what is reported.
DRAWN, KEPT = 20, 3
FIRST, AGAIN, READS = 10, 20, 50
#: Tenths of decades of a weight, by kind; one weight for all is from the whole of them.
_RANGES = {"logic": (-10, 10), "distance": (-20, 10), "limit": (-30, 0)}
_WHOLE = (-30, 10)
_BETAS = ("0.2..10", "0.3..5", "1..20", "1..40", "2..20", "3..12", "5..40")
#: Settings of their own; attempts are of 10000 sweeps, of all replicas together, as in `benchmarks.substations`.
_OWN: dict[str, dict[str, tuple[object, ...]]] = {
    "sa:unary:sweeps=10000": {"beta": _BETAS},
    "pt:unary:replicas=8:sweeps=1250": {"beta": _BETAS},
    "tabu:unary:sweeps=10000": {"tenure": (0.02, 0.05, 0.1, 0.25, 0.5)},
}


class Trial(NamedTuple):
    """A sampler, with its effort, on an instance."""

    word: str
    name: str

    @property
    def solver(self) -> str:
        """Name of the sampler."""
        return self.word.partition(":")[0]

    def settings(self, weights: str) -> list[str]:
        """Words that are tried, with ``one`` weight for all or one ``each``."""
        draw = Draw(f"{self.name} {self.word} {weights}")
        ranges = [_WHOLE] if weights == "one" else [_RANGES[kind] for kind in kinds_of("unary", shared=True)]
        return drawn_words(draw, self.word, ranges, _OWN[self.word], DRAWN)


class Outcome(NamedTuple):
    """Attempts that reach the certified optimum, and those that obey all constraints: the more the better."""

    successful: int
    feasible: int


def trials() -> Iterator[Trial]:
    """Each sampler on each of the smaller instances."""
    for (trains, steps), name in zip(LIMITS, names(), strict=True):
        if trains * steps <= COMPARED:
            yield from (Trial(word, name) for word in _OWN)


def outcome(trial: Trial, setting: str, reads: int, seed: int) -> Outcome:
    """What so many attempts with a setting come to."""
    spec = parse_spec(f"{setting}:reads={reads}")
    instance = read_instance(find(trial.name))
    found = solve(instance, spec.solver, spec.encoding, spec.penalty, spec.allowance(seed))
    reached = successes(found, float(index()[trial.name]["objective"]))
    return Outcome(reached, found.details["feasible_reads"])


def row(trial: Trial, weights: str) -> dict[str, Any]:
    """The setting that is picked, and what other attempts with it come to."""

    def ranked(settings: list[str], reads: int, seed: int) -> list[str]:
        return sorted(settings, key=lambda one: outcome(trial, one, reads, seed), reverse=True)

    first = ranked(trial.settings(weights), FIRST, 1)
    best = ranked(first[:KEPT], AGAIN, 2)[0]
    found = outcome(trial, best, READS, 3)
    return {
        "instance": trial.name, "solver": trial.solver, "weights": weights, "setting": best, "attempts": READS,
        "feasible": found.feasible, "successful": found.successful,
    }  # fmt: skip


def main(folder: Path) -> None:
    """Write the table, again after each row: all take some twenty minutes."""
    warnings.simplefilter("ignore", FormulationWarning)
    rows: list[dict[str, Any]] = []
    for trial in trials():
        for weights in ("one", "each"):
            rows.append(row(trial, weights))
            print(rows[-1], flush=True)
            write_files(folder, {"weights.csv": csv_text(rows)})


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results" / "quantum" / "substations")
