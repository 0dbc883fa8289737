"""Trains that share a substation: the family that stays hard, drawn byte for byte the same every time.

Distances are 50 to 85 % of the farthest within random caps, departures lie within an eighth of the trip. The limit of
the substation is `limit` of the trains: a part of the peak that it would have if each drove its own cheapest plan, the
least of those tried at which a descent finds a plan of all trains. The limits stand here, so that the files do not
depend on what a solver finds. ``python -m benchmarks.substations`` compares solvers on the smaller ones.
"""

import time
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.entry import Draw, Entry, farthest
from benchmarks.timing import ROOT
from tgvdp.formulations.problem.instances import SubstationInstance
from tgvdp.formulations.problem.substation import delivered, joint_speeds, shares
from tgvdp.instances import find, index
from tgvdp.report.files import write_files
from tgvdp.solvers.exact.joint_descent import descend
from tgvdp.solvers.exact.joint_prices import SCALE, train_of
from tgvdp.solvers.registry import solve
from tgvdp.trials.execute import Plan, Results, merged, run_benchmark
from tgvdp.trials.output import write_benchmark
from tgvdp.trials.reference import read_cases
from tgvdp.trials.spec import parse_spec

#: Limit of each instance, by (trains, steps).
LIMITS = {
    (2, 6): 2, (2, 8): 5, (2, 12): 9, (2, 20): 11, (2, 40): 16, (3, 8): 6, (3, 12): 7, (3, 20): 9, (3, 30): 22,
    (3, 60): 27, (4, 16): 10, (4, 20): 10, (4, 30): 28, (4, 40): 28, (4, 60): 46, (4, 80): 56, (4, 100): 77,
    (5, 20): 12, (5, 30): 24, (5, 40): 52, (5, 60): 53, (5, 80): 108, (5, 100): 121, (6, 20): 31, (6, 30): 33,
    (6, 40): 26, (6, 50): 45, (6, 60): 73, (6, 80): 91, (6, 100): 92,
}  # fmt: skip
#: Trains times steps up to which all solvers are compared.
COMPARED = 60
#: Equal tuning on the very instances, which favours the samplers: the same penalties and attempts of the same number of
#: sweeps (of all replicas together) with two settings of its own for each, and the best of them counts.
_PENALTIES = (0.1, 0.3, 1.0, 3.0)
_SETTINGS = {
    "sa:unary:sweeps=10000": ("beta=0.2..10", "beta=1..20"),
    "pt:unary:replicas=8:sweeps=1250": ("beta=0.3..5", "beta=1..20"),
    "tabu:unary:sweeps=10000": ("tenure=0.05", "tenure=0.25"),
}
SOLVERS = (
    "dp", "milp:time-limit=60", "scip:time-limit=60", "greedy", "random:unary:reads=50",
    *(
        f"{word}:reads=50:penalty={penalty}:{setting}"
        for word, settings in _SETTINGS.items()
        for penalty, setting in product(_PENALTIES, settings)
    ),
)  # fmt: skip
#: Trains times steps from which programs get ten minutes; SCIP up to another size, where nothing else proves them.
LARGE, SCIP_SIZE = 240, 300
PROGRAM, SCIP = ("milp:time-limit=600", "greedy"), ("scip:time-limit=600",)
#: Part of braking energy that others get, by the number of trains.
_ALPHA = {2: 0.5, 3: 0.0, 4: 0.5, 5: 0.75, 6: 0.5}
#: Parts of the peak of trains that do not heed each other, in per cent.
_PARTS = (60, 70, 80, 90, 100)


def substation() -> Iterator[Entry]:
    """All instances, by trains and steps."""
    for (trains, steps), power_units in LIMITS.items():
        yield drawn(trains, steps, power_units)


def drawn(trains: int, steps: int, power_units: int) -> Entry:
    """The instance of so many trains and steps, under a limit."""
    name = f"substation-k{trains}-n{steps:03d}"
    draw = Draw(name)
    params: dict[str, Any] = {
        "kind": "substation", "dt_s": 10.0, "dv_mps": 1.0, "power_units": power_units, "alpha": _ALPHA[trains],
        "trains": [_train(draw, steps) for _ in range(trains)],
    }  # fmt: skip
    return Entry("substation", name, params)


def _train(draw: Draw, steps: int) -> dict[str, Any]:
    own = steps - draw.whole(0, steps // 8)
    cap = draw.whole(max(1, own // 4), max(1, own // 3))
    far = farthest(own, [cap] * own)
    return {
        "N": own, "start": draw.whole(0, steps // 8), "mass_units": draw.whole(1, 2), "cap_units": cap,
        "D_units": draw.whole(far // 2 + 1, far * 85 // 100),
    }  # fmt: skip


def limit(trains: int, steps: int) -> int:
    """How a limit of `LIMITS` was found."""
    free = drawn(trains, steps, 1_000_000).instance
    assert isinstance(free, SubstationInstance)
    plans = [np.array(solve(train.trip, "dp").schedule.speeds) for train in free.trains]
    peak = -(-int(delivered(free, joint_speeds(free, plans)).max()) // shares(free).q)
    for part in _PARTS:
        power_units = max(1, peak * part // 100)
        instance = drawn(trains, steps, power_units).instance
        assert isinstance(instance, SubstationInstance)
        own = [train_of(train) for train in instance.trains]
        if descend(instance, own, np.full(instance.steps, SCALE)) is not None:
            return power_units
    raise AssertionError(f"{trains} trains of {steps} steps that do not heed each other keep within their peak")


def names() -> list[str]:
    """Names of all instances, in the order of `LIMITS`."""
    return [f"substation-k{trains}-n{steps:03d}" for trains, steps in LIMITS]


def main(folder: Path) -> None:
    """All solvers on the smaller instances, and below that programs on the large ones."""
    known, sizes = index(), {name: trains * steps for (trains, steps), name in zip(LIMITS, names(), strict=True)}
    small = [name for name, size in sizes.items() if size <= COMPARED]
    large = [name for name, size in sizes.items() if size >= LARGE]
    scip = [name for name in large if sizes[name] <= SCIP_SIZE and known[name]["best_known"]]
    for groups, to in ((((small, SOLVERS),), folder), (((large, PROGRAM), (scip, SCIP)), folder / "large")):
        started = time.perf_counter()
        plans = (
            Plan(tuple(read_cases([find(name) for name in chosen])), tuple(map(parse_spec, words)), 1)
            for chosen, words in groups
        )
        results = merged([run_benchmark(plan, to, lambda *_: None) for plan in plans])
        write_benchmark(results, to, time.perf_counter() - started)
        write_files(to, best_plans(results))


def best_plans(results: Results) -> dict[str, bytes]:
    """Plans of open instances that are as good as the best known, a control a line, as check.py reads them."""
    known = {name: float(row["best_known"]) for name, row in index().items() if row["best_known"]}
    found: dict[str, bytes] = {}
    for (name, _), runs in results.runs.items():
        for run in runs:
            if name in known and run["status"] == "ok" and run["feasible"] and run["objective"] <= known[name]:
                known[name] = run["objective"]
                found[f"{name}.sol"] = "".join(f"{control!r}\n" for control in run["controls"]).encode()
    return found


if __name__ == "__main__":
    main(ROOT / "results" / "quantum" / "substations")
