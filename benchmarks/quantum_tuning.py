"""Equal tuning of all solvers, on instances that are not reported: ``python -m benchmarks.quantum_tuning``.

Each solver on each encoding gets 16 settings (four penalties by four of its own; on efficiency seven penalties,
because the largest of four won there), tried at one of the sizes of `TUNED_AT`, and then four efforts (sweeps,
layers) at every reported size, always with the same number of attempts on the same instances. The score is the effort
after which an attempt has succeeded with probability 99 %, as in Rønnow et al. (Science 345, 420, 2014), by the mean
success over the instances: of four instances a median says little. A solver that no effort made succeed at a size is
not run there.
"""

import csv
import statistics
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.families import FAMILIES, SIZES, members, write
from benchmarks.timing import ROOT
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text
from tgvdp.trials.execute import Plan, run_benchmark
from tgvdp.trials.reference import Case, read_cases
from tgvdp.trials.rows import rows_of
from tgvdp.trials.spec import parse_spec
from tgvdp.trials.statistics import attempts_to_success

FOLDER = ROOT / "build" / "quantum-tuning"
TUNING = ROOT / "results" / "quantum" / "tuning.csv"
#: Sizes at which settings are compared: a reported size takes those of the largest that is not above it, or the first.
TUNED_AT = (8, 16, 30)
READS = 10
_BETAS = ("beta=0.2..10", "beta=1..20", "beta=2..20", "beta=5..40")
_LADDERS = ("beta=1..20:replicas=4", "beta=1..20:replicas=8", "beta=3..12:replicas=4", "beta=5..10:replicas=4")
_TENURES = ("tenure=0.05", "tenure=0.1", "tenure=0.25", "tenure=0.5")
_STEPS = ("step=0.4", "step=0.8", "step=1.2", "step=1.6")
_PENALTIES = {"unary": (0.1, 0.2, 0.4, 0.8), "bits": (0.2, 0.4, 0.8, 1.6)}
#: Further penalties of a family by encoding, where the largest of those had won.
_LARGER_PENALTIES = {"efficiency": {"unary": (1.6, 3.2, 6.4), "bits": (3.2, 6.4, 12.8)}}
_SWEEPS = tuple(f"sweeps={sweeps}" for sweeps in (100, 300, 1000, 3000))
_LAYERS = tuple(f"layers={layers}" for layers in (3, 10, 32, 100))


class Tunable(NamedTuple):
    """A solver on an encoding: its own settings, its efforts, of which the third is used to compare settings."""

    word: str
    settings: tuple[str, ...]
    efforts: tuple[str, ...]
    most_steps: int

    @property
    def encoding(self) -> str:
        """Part of the word."""
        return self.word.split(":")[1]

    def words(self, family: str) -> Iterator[str]:
        """All settings on a family, without an effort."""
        larger = _LARGER_PENALTIES.get(family, {}).get(self.encoding, ())
        for penalty, setting in product((*_PENALTIES[self.encoding], *larger), self.settings):
            yield f"{self.word}:penalty={penalty}:{setting}"

    def groups(self) -> dict[int, list[int]]:
        """Sizes that it can do, by the size whose settings they take."""
        found: dict[int, list[int]] = {}
        for steps in SIZES:
            if steps <= self.most_steps:
                found.setdefault(max((one for one in TUNED_AT if one <= steps), default=TUNED_AT[0]), []).append(steps)
        return found


TUNABLES = (
    *(
        Tunable(f"{solver}:{encoding}", settings, _SWEEPS, SIZES[-1] if encoding == "unary" else 16)
        for encoding in ("unary", "bits")
        for solver, settings in (("sa", _BETAS), ("pt", _LADDERS), ("tabu", _TENURES))
    ),
    Tunable("qaoa:unary:angles=ramp", _STEPS, _LAYERS, 8),
    Tunable("qaoa:bits:angles=ramp", _STEPS, _LAYERS, 8),
    Tunable("qaoa:unary:angles=ramp:mixer=walls", _STEPS, _LAYERS, 10),
)


def effort_of(word: str) -> int:
    """Sweeps or layers of a word: updates per bit and attempt."""
    budget = parse_spec(word).budget
    return int(budget.get("sweeps", budget.get("layers", 1)))


def compare(words: Sequence[str], cases: Sequence[Case], folder: Path) -> list[dict[str, Any]]:
    """One row per word with its score, and which is best."""
    specs = {word: parse_spec(f"{word}:reads={READS}") for word in words}
    results = run_benchmark(Plan(tuple(cases), tuple(specs.values()), 1), folder, lambda *_: None)
    rows = rows_of(results, "")
    found = []
    for word, spec in specs.items():
        own = [row for row in rows if row["Workflow"] == spec.label]
        chance = statistics.fmean(row["p_success"] for row in own)
        score = attempts_to_success(chance) * effort_of(word)
        found.append({"setting": word, "mean success": chance, "sweeps to 99 %": score})
    best = min(found, key=lambda row: (row["sweeps to 99 %"], -effort_of(row["setting"])))
    return [row | {"chosen": row is best} for row in found]


def tune(tunable: Tunable, family: str, instances: Path, folder: Path) -> Iterator[dict[str, Any]]:
    """Rows of the settings at the sizes of `TUNED_AT`, and of the efforts at every size with the best of them."""

    def compared(stage: str, steps: int, words: Sequence[str]) -> list[dict[str, Any]]:
        cases = read_cases([instances / f"{one.name}.json" for one in members(family, steps, "tuning")])
        known = {"family": family, "solver": tunable.word, "stage": stage, "N": steps}
        return [known | row for row in compare(words, cases, folder)]

    usual = tunable.efforts[2]
    for tuned_at, sizes in tunable.groups().items():
        settings = compared("setting", tuned_at, [f"{word}:{usual}" for word in tunable.words(family)])
        yield from settings
        best = next(row["setting"] for row in settings if row["chosen"]).removesuffix(f":{usual}")
        for steps in sizes:
            yield from compared("effort", steps, [f"{best}:{effort}" for effort in tunable.efforts])


def chosen_words(tuning: Path) -> dict[tuple[str, int], list[str]]:
    """Words of all tuned solvers for each family and size, where tuning found a success."""
    found: dict[tuple[str, int], list[str]] = {}
    with tuning.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            if row["stage"] == "effort" and row["chosen"] == "True" and row["sweeps to 99 %"] != "inf":
                found.setdefault((row["family"], int(row["N"])), []).append(row["setting"])
    return found


def main() -> None:
    instances = FOLDER / "instances"
    write(instances)
    rows = []
    for tunable in TUNABLES:
        for family in FAMILIES:
            rows += list(tune(tunable, family, instances, FOLDER))
            print(tunable.word, family, *(row["setting"] for row in rows[-4:] if row["chosen"]), flush=True)
    write_files(TUNING.parent, {TUNING.name: csv_text(rows)})


if __name__ == "__main__":
    main()
