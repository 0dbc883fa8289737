"""What a weight for each kind of violation reaches: ``python -m benchmarks.quantum_weights`` writes weights.csv.

Tuning (benchmarks.quantum_tuning) gives all violations of a QUBO the same weight. A missed unit of distance is squared
and far more common than a broken order or a wrong end, and the objective gains little by it, so that one weight for all
is either too small for the others or so large for the distance that nothing moves. Here settings are drawn at random,
the same number with one weight and with one for each kind, tried on the instances of tuning, and the best is run on the
reported ones: bits at the sizes that tuning did not reach, unary where the tuned settings do not solve the median
instance of the largest reported size, and circuits.
"""

import statistics
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.entry import Draw
from benchmarks.families import FAMILIES, SIZES, members
from benchmarks.quantum_draws import drawn_words, optima, solved_medians, successes
from benchmarks.quantum_tuning import effort_of
from benchmarks.timing import ROOT
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.formulations.qubo.names import kinds_of
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text
from tgvdp.solvers.registry import solve
from tgvdp.trials.spec import parse_spec
from tgvdp.trials.statistics import attempts_to_success

#: Settings that are drawn, those that are tried again with more attempts, and attempts on each instance.
DRAWN, KEPT = 20, 3
FIRST, READS = 10, 50
#: Tenths of decades of a weight: of the distance, whose violation is squared and may be large, and of others.
_DISTANCE, _OTHER = (-25, 5), (-10, 10)
_BETAS = ("0.5..10", "1..20", "1..40", "2..20", "3..12", "5..40")
_OWN: dict[str, dict[str, tuple[object, ...]]] = {
    "sa": {"beta": _BETAS},
    "pt": {"beta": _BETAS, "replicas": (4, 8)},
    "tabu": {"tenure": (0.02, 0.05, 0.1, 0.25, 0.5)},
    "qaoa": {"step": (0.4, 0.8, 1.2, 1.6), "layers": (3, 10, 32)},
}
_SWEEPS = 3000
_BITS_STEPS, _CIRCUIT_STEPS = (12, 16, 20), 8
#: Left out for the time that it takes, although tuning covers it; its bits hold no slow zones, but may decode to plans
#: that keep them.
LEFT_OUT = "zones"
_FAMILIES = tuple(family for family in FAMILIES if family != LEFT_OUT)


class Trial(NamedTuple):
    """A solver on an encoding, with its variant, on a family and size."""

    word: str
    family: str
    steps: int

    def settings(self, weights: str) -> list[str]:
        """Words that are tried, with ``one`` weight for all or one ``each``."""
        draw = Draw(f"{self.word} {self.family} {self.steps} {weights}")
        solver, encoding = self.word.split(":")[:2]
        ranges = [_DISTANCE if kind == "distance" else _OTHER for kind in kinds_of(encoding)]
        if weights == "one":
            ranges = [(_DISTANCE[0], _OTHER[1])]
        words = drawn_words(draw, self.word, ranges, _OWN[solver], DRAWN)
        return words if solver == "qaoa" else [f"{word}:sweeps={_SWEEPS}" for word in words]


def trials(reached: Path) -> Iterator[Trial]:
    """What is tried: ``reached`` is the table that says which median instances the published runs solve."""
    steps = SIZES[-2]
    solved = solved_medians(reached, steps)
    for family in _FAMILIES:
        for solver in ("sa", "pt", "tabu"):
            if (f"{solver}:unary", family) not in solved:
                yield Trial(f"{solver}:unary", family, steps)
            yield from (Trial(f"{solver}:bits", family, one) for one in _BITS_STEPS)
        for encoding in ("unary", "bits"):
            yield Trial(f"qaoa:{encoding}:angles=ramp", family, _CIRCUIT_STEPS)


def weight_rows(reached: Path) -> Iterator[dict[str, Any]]:
    """Two rows per trial, with one weight and with one for each kind of violation."""
    warnings.simplefilter("ignore", FormulationWarning)
    for trial in trials(reached):
        for weights in ("one", "each"):
            yield _row(trial, weights)


def _row(trial: Trial, weights: str) -> dict[str, Any]:
    first = sorted((score(trial, word, FIRST), word) for word in trial.settings(weights))
    best = min((score(trial, word, READS), word) for _, word in first[:KEPT])[1]
    row = {"solver": trial.word, "family": trial.family, "N": trial.steps, "weights": weights, **outcome(trial, best)}
    print(row, flush=True)
    return row


def outcome(trial: Trial, word: str) -> dict[str, Any]:
    """What a setting reaches on the reported instances."""
    found = chances(trial, word, "sample", READS)
    return {
        "setting": word, "instances": len(found), "solved": sum(chance > 0.0 for chance in found),
        "p median": statistics.median(found), "p least": min(found), "p most": max(found),
        "TTS99 sweeps": attempts_to_success(statistics.median(found)) * effort_of(word),
    }  # fmt: skip


def score(trial: Trial, word: str, reads: int) -> float:
    """Effort to a success with probability 99 %, by the mean success on the instances of tuning."""
    return attempts_to_success(statistics.fmean(chances(trial, word, "tuning", reads))) * effort_of(word)


def chances(trial: Trial, word: str, kind: str, reads: int) -> list[float]:
    """Success of an attempt on each instance: exact for a circuit, else the share of the attempts."""
    spec = parse_spec(f"{word}:reads={reads}")
    found = []
    for member in members(trial.family, trial.steps, kind):
        solution = solve(member.entry.instance, spec.solver, spec.encoding, spec.penalty, spec.allowance(1))
        details = solution.details
        if "success_probability" in details:
            found.append(details["success_probability"])
            continue
        found.append(successes(solution, optima()[member.name]) / reads)
    return found


def main(folder: Path) -> None:
    """Write the table, again after each row: all take some twenty minutes."""
    rows: list[dict[str, Any]] = []
    for row in weight_rows(folder / "ensembles.csv"):
        rows.append(row)
        write_files(folder, {"weights.csv": csv_text(rows)})


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results" / "quantum")
