"""The published instances: ``python -m benchmarks.library`` writes src/tgvdp/instances, the same every time.

Each instance is one JSON file with the fields that `tgvdp.formulations.problem.instances` names and no others. What is
known about it stands beside, in ``optima.csv``: the certified optimum, the number of optimal plans, the closed form
where one exists, the solver that proves the optimum and the ones that confirm it by other means.
"""

import csv
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.entry import Entry, farthest
from benchmarks.substations import substation
from benchmarks.timing import ROOT
from tgvdp.errors import TgvdpError
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.formulations.problem.demand import drive
from tgvdp.formulations.problem.instances import BinaryInstance, DemandInstance, Instance, SubstationInstance
from tgvdp.instances import FOLDER, INDEX
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.exact.brute_force import MOST_STEPS
from tgvdp.solvers.registry import solve

#: Steps up to which HiGHS and SCIP confirm an optimum within a minute; the constant model is easier than the others.
MILP_STEPS = {"constant": 200, "kinetic": 40, "efficiency": 20}
SCIP_STEPS = 8
MILP_LIMIT_S = 60.0
#: Plans of a demand instance that brute force tries.
BRUTE_PLANS = 1_000_000
#: Trains times steps up to which HiGHS confirms the optimum of a substation within a minute.
SUBSTATION_SIZE = 80
#: Runs of other solvers on what the dynamic program leaves open; their best plans are beside.
LARGE_RUNS = ROOT / "results" / "quantum" / "substations" / "large" / "benchmark.csv"


def entries() -> list[Entry]:
    """All instances, by family and size."""
    return [entry for family in FAMILIES for entry in family()]


def _binary(family: str, steps: int, distance: float, **changes: Any) -> Entry:
    """A level trip in unit steps; the name tells model and size."""
    params: dict[str, Any] = {
        "kind": "binary", "model": "constant", "N": steps, "dt_s": 10.0, "dv_mps": 1.0, "acc_units": 1, "dec_units": 1,
        "cap_units": max(1, steps // 2), "D_units": distance, "alpha": 0.3,
    } | changes  # fmt: skip
    return Entry(family, f"{family}-n{steps:03d}", params)


def easy() -> Iterator[Entry]:
    """Constant energy, one cap that never binds, two thirds of the longest distance."""
    for steps in (4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 20, 24, 30, 40, 50, 60, 80, 100, 150, 200):
        yield _binary("easy", steps, steps * steps // 6)


def tight() -> Iterator[Entry]:
    """The longest distance that is possible: one plan is left."""
    for steps in (4, 8, 12, 20, 40, 60, 100):
        yield _binary("tight", steps, (steps // 2) * (steps - steps // 2))


def degenerate() -> Iterator[Entry]:
    """All braking energy comes back, so that every plan is optimal."""
    for steps in (6, 10, 20, 40, 100):
        yield _binary("degenerate", steps, steps * steps // 8, alpha=1.0)


def kinetic() -> Iterator[Entry]:
    """Kinetic energy, half of what braking takes out given back."""
    for steps in (5, 8, 12, 20, 40, 60, 100):
        yield _binary("kinetic", steps, steps * steps // 6, model="kinetic", alpha=0.5)


def efficiency() -> Iterator[Entry]:
    """The efficiency function, which at a fixed distance only maximises the sum of v²."""
    for steps in (6, 10, 20, 40, 60):
        yield _binary(
            "efficiency", steps, steps * steps // 8, model="efficiency", alpha=0.0, eta0=0.9, deta=0.8 / (steps // 2)
        )


def zones() -> Iterator[Entry]:
    """Slow zones: a lower cap in the second quarter of the trip, and one that a fraction of Δv lies above, later."""
    for steps in (6, 8, 12, 20, 40, 60, 100, 200):
        high, slow = steps // 3, max(1, steps // 8)
        caps = [slow if steps // 4 <= k < steps // 2 else high for k in range(1, steps + 1)]
        caps[3 * steps // 4 - 1] = max(1, high // 2) + 0.5
        yield _binary("zones", steps, int(0.6 * farthest(steps, caps)), cap_units=caps)


def unequal() -> Iterator[Entry]:
    """Braking in larger steps than traction; the kinetic model, because braking would earn in the constant one."""
    for steps, acc, dec in ((5, 1, 2), (8, 1, 2), (12, 1, 2), (20, 2, 3), (40, 1, 3), (60, 2, 3), (100, 1, 2)):
        yield _binary(
            "unequal", steps, steps * steps * acc // 8, model="kinetic", acc_units=acc, dec_units=dec,
            cap_units=acc * steps // 2,
        )  # fmt: skip


def tolerance() -> Iterator[Entry]:
    """A distance with a tolerance, half of it a fraction of a unit."""
    for steps in (6, 10, 20, 60):
        yield _binary("tolerance", steps, steps * steps / 7.0 // 0.5 * 0.5, tol_units=steps / 4)


def fine() -> Iterator[Entry]:
    """Δv = 0.1 m/s, where the rule of thumb for the penalty can pick a wrong minimum."""
    for steps in (5, 8, 20):
        yield _binary("fine", steps, steps * steps // 6, dv_mps=0.1)


def penalised() -> Iterator[Entry]:
    """The instance's own uniform penalty: too small, then large enough."""
    for steps, weight in ((6, 0.1), (8, 20.0)):
        yield _binary("penalised", steps, steps * steps // 6, lambda_uniform=weight)


def demand() -> Iterator[Entry]:
    """The demand model on the true curves; distances are those of a plan that pulls, coasts and brakes."""
    sizes = ((4, 30.0, 1), (5, 30.0, 2), (6, 20.0, 2), (8, 20.0, 2), (10, 15.0, 2), (12, 15.0, 1), (16, 15.0, 2))
    for steps, dt_s, notches in sizes:
        yield _demand(steps, dt_s, notches, _design_distance_m(steps, dt_s), 40.0)
    yield _demand(40, 15.0, 4, 20_000.0, 30.0)


def _demand(steps: int, dt_s: float, notches: int, distance_m: float, tol_m: float) -> Entry:
    params = {
        "kind": "demand", "N": steps, "dt_s": dt_s, "notches": notches, "mass_kg": 300000.0, "rot": 1.08,
        "davis_SI": [1770.0, 35.4, 6.6], "vmax_kmh": 160.0, "D_m": distance_m, "tol_m": tol_m, "v_end_max_mps": 1.5,
        "P_max_W": 9800000.0, "cost_ref_kmh": 220.0, "alpha": 0.3,
    }  # fmt: skip
    return Entry("demand", f"demand-n{steps:03d}", params)


def _design_distance_m(steps: int, dt_s: float) -> float:
    probe = Entry("", "probe", _demand(steps, dt_s, 1, 1.0, 0.0).params).instance
    assert isinstance(probe, DemandInstance)
    pulling = max(1, round(30.0 / dt_s))
    for braking in range(1, steps - pulling):
        motion = drive(probe, [1.0] * pulling + [0.0] * (steps - pulling - braking) + [-1.0] * braking)
        if motion.speed_mps[-1] <= probe.end_speed_max_mps:
            return round(float(motion.distance_m), -1)
    raise ValueError(f"{steps} steps are too few to stop")


FAMILIES: tuple[Callable[[], Iterator[Entry]], ...] = (
    easy, tight, degenerate, kinetic, efficiency, zones, unequal, tolerance, fine, penalised, demand,
    substation,
)  # fmt: skip


def certified(entry: Entry, others: Sequence[str] | None = None) -> dict[str, Any]:
    """Row of the index: the optimum by the dynamic program, and which other methods reach the same value.

    Of a substation whose dynamic program ends by its budget, the best known objective and bound instead: its own or
    those of the published runs of other solvers.

    Parameters
    ----------
    entry : Entry
    others : sequence of str, optional
        Solvers that confirm it; by default all that share no algorithm with the dynamic program and end soon.

    Raises
    ------
    AssertionError
        When two methods disagree, or nothing is proved.
    """
    instance = entry.instance
    proof = solve(instance, "dp")
    is_open = isinstance(instance, SubstationInstance) and not proof.optimal
    assert (proof.optimal or is_open) and proof.feasible and proof.replay["feasible"], entry.name
    known = _known(entry.name, proof.objective, proof.details["bound"]) if is_open else ("", "")
    closed, confirmed = None, []
    for solver in () if is_open else _others(instance) if others is None else others:
        try:
            other = solve(
                instance, solver, allowance=Allowance(time_limit_s=MILP_LIMIT_S if solver == "milp" else None)
            )
        except TgvdpError:
            continue  # not for such instances
        if not other.optimal:
            continue
        assert _same(other.objective, proof.objective), f"{entry.name}: {solver} {other.objective} {proof.objective}"
        assert other.n_optimal in (None, proof.n_optimal), f"{entry.name}: {solver} counts {other.n_optimal}"
        confirmed.append(solver)
        closed = other.objective if solver == "closed" else closed
    return {
        "file": f"{entry.name}.json",
        "sha256": entry.sha256,
        "id": entry.name,
        "family": entry.family,
        "kind": entry.params["kind"],
        "model": entry.params.get("model", ""),
        "N": instance.steps,
        "objective": "" if is_open else repr(proof.objective),
        "unit": "(m/s)^2" if isinstance(instance, BinaryInstance) else instance.objective_unit,
        "n_optimal": proof.n_optimal,
        "closed_form": "" if closed is None else repr(closed),
        "certified_by": "" if is_open else "dp",
        "confirmed_by": " ".join(confirmed),
        "best_known": known[0],
        "bound": known[1],
    }


def _known(name: str, objective: float, bound: float) -> tuple[str, str]:
    """Best objective and bound of the dynamic program and the published runs."""
    with LARGE_RUNS.open(encoding="utf-8", newline="") as file:
        own = [row for row in csv.DictReader(file) if row["Problem"] == name]
    plans = [float(row["Best Objective Value"]) for row in own if row["Best Objective Value"]]
    bounds = [float(row["Optimality Bound"]) for row in own if row["Optimality Bound"]]
    return repr(min([objective, *plans])), repr(max([bound, *bounds]))


def _others(instance: Instance) -> list[str]:
    """Solvers that share no algorithm with the dynamic program and end soon."""
    if isinstance(instance, DemandInstance):
        return ["brute"] if len(instance.levels or ()) ** instance.steps <= BRUTE_PLANS else []
    if isinstance(instance, SubstationInstance):
        return ["milp"] if len(instance.trains) * instance.steps <= SUBSTATION_SIZE else []
    found = ["closed"]
    if instance.steps <= min(10, MOST_STEPS):
        found.append("brute")
    if instance.steps <= MILP_STEPS[instance.model]:
        found.append("milp")
    if instance.steps <= SCIP_STEPS:
        found.append("scip")
    return found


def _same(one: float, other: float) -> bool:
    return bool(np.isclose(one, other, rtol=1e-12, atol=0.0))


def main(folder: Path) -> None:
    """Write all instances and the index."""
    warnings.simplefilter("ignore", FormulationWarning)
    rows = []
    for entry in entries():
        rows.append(certified(entry))
        print(*(rows[-1][key] for key in ("id", "objective", "n_optimal", "confirmed_by")), flush=True)
    files = {f"{entry.name}.json": entry.content for entry in entries()}
    write_files(folder, {**files, INDEX: csv_text(rows)})


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
