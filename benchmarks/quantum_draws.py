"""What the studies of drawn settings share: how words are drawn, known optima, and which attempts reach them."""

import csv
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from benchmarks.entry import Draw
from benchmarks.families import OPTIMA
from tgvdp.formulations.problem.schedule import Solution

#: Relative difference to the certified optimum below which an objective is the optimum.
_SAME = 1e-12


@cache
def optima() -> dict[str, float]:
    """Certified optimum of each random instance, by its name."""
    with OPTIMA.open(encoding="utf-8", newline="") as file:
        return {row["id"]: float(row["objective"]) for row in csv.DictReader(file)}


def successes(found: Solution, optimum: float) -> int:
    """Number of attempts of a sampler that reach the optimum."""
    is_best = found.feasible and found.objective <= optimum * (1.0 + _SAME)
    return found.details["best_reads"] if is_best else 0


def solved_medians(reached: Path, steps: int) -> set[tuple[str, str]]:
    """Solvers and families whose median instance of a size is solved, by the table of ensembles."""
    with reached.open(encoding="utf-8", newline="") as file:
        return {
            (row["solver"], row["family"]) for row in csv.DictReader(file)
            if int(row["N"]) == steps and float(row["p median"]) > 0.0
        }  # fmt: skip


def drawn_words(
    draw: Draw, word: str, ranges: Sequence[tuple[int, int]], own: Mapping[str, Sequence[object]], count: int
) -> list[str]:
    """So many words with random weights, of ranges in tenths of decades, and random settings of a solver's own."""

    def drawn() -> str:
        penalty = "/".join(f"{10.0 ** (draw.whole(*one) / 10.0):.2g}" for one in ranges)
        chosen = (f"{key}={values[draw.whole(0, len(values) - 1)]}" for key, values in own.items())
        return ":".join((word, f"penalty={penalty}", *chosen))

    return [drawn() for _ in range(count)]
