"""The certified optimum of an instance: from the index beside it, or proved on the spot by the dynamic program."""

import csv
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.formulations.problem.instances import Instance
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.instances import INDEX
from tgvdp.solvers.registry import solve


@dataclass(frozen=True)
class Case:
    """An instance of the benchmark with its source."""

    instance: Instance
    path: Path
    sha256: str


@dataclass(frozen=True)
class Reference:
    """What is known about an instance.

    Attributes
    ----------
    objective : float or None
        Certified optimum; None where nothing is proved, or where nothing is feasible.
    n_optimal : int or None
        Number of optimal schedules, where it was counted.
    feasible : bool
        False where it is proved that no schedule satisfies all constraints.
    source : str
    """

    objective: float | None
    n_optimal: int | None
    feasible: bool
    source: str

    @property
    def certified(self) -> bool:
        """Whether a success can be told from a failure."""
        return self.objective is not None or not self.feasible


def read_cases(places: Sequence[Path], most_steps: int | None = None) -> list[Case]:
    """Read instances from files, and from all JSON files of folders, by size and name; longer ones are left out.

    Raises
    ------
    InputError
        When a file is wrong, two instances have the same id, or there is none.
    """
    paths = [path for place in places for path in (sorted(place.glob("*.json")) if place.is_dir() else [place])]
    cases: dict[str, Case] = {}
    longer: list[int] = []
    for path in paths:
        instance = read_instance(path)
        if most_steps is not None and instance.steps > most_steps:
            longer.append(instance.steps)
            continue
        if instance.id in cases:
            raise InputError(f"{path}: the id {instance.id!r} is also that of {cases[instance.id].path}")
        cases[instance.id] = Case(instance, path, hashlib.sha256(path.read_bytes()).hexdigest())
    if not cases:
        where = ", ".join(map(str, places)) or "instances"
        if longer:
            raise InputError(f"{where}: no instance of at most {most_steps} steps, the shortest has {min(longer)}")
        raise InputError(f"{where}: no instance (*.json) there")
    return sorted(cases.values(), key=lambda case: (case.instance.steps, case.instance.id))


def reference_of(case: Case) -> dict[str, Any]:
    """What is known about an instance, as values that JSON can hold; `Reference` takes them."""
    listed = _listed(case)
    if listed is not None:
        return listed
    try:
        solution = solve(case.instance, "dp")
    except InfeasibleError:
        return {"objective": None, "n_optimal": None, "feasible": False, "source": "dp"}
    except BudgetExceededError:
        return {"objective": None, "n_optimal": None, "feasible": True, "source": "none"}
    if not solution.optimal:
        return {"objective": None, "n_optimal": None, "feasible": True, "source": "none"}
    return {
        "objective": solution.objective, "n_optimal": solution.n_optimal, "feasible": True, "source": "dp",
    }  # fmt: skip


def _listed(case: Case) -> dict[str, Any] | None:
    index = case.path.parent / INDEX
    if not index.is_file():
        return None
    with index.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            if row.get("sha256") == case.sha256:
                try:
                    counted = int(row["n_optimal"]) if row["n_optimal"] else None
                    best = float(row["objective"]) if row["objective"] else None  # else open
                    return {"objective": best, "n_optimal": counted, "feasible": True, "source": INDEX}
                except (KeyError, ValueError) as error:
                    raise InputError(f"{index}: the row of {case.instance.id!r} is wrong: {error}") from None
    return None
