"""One row per instance and solver: the fields of QOBLIB, and what is needed to judge a sampler.

QOBLIB (arXiv 2504.03832) asks for the first columns of each row, under these names. Ours follow: attempts and
successes, the probability of success with its interval, TTS99, and the random baseline. Durations of QOBLIB's columns
are averages over runs, as it asks, those of ours are medians.
"""

import statistics
from collections.abc import Mapping, Sequence
from typing import Any

from tgvdp.formulations.problem.instances import BinaryInstance
from tgvdp.trials.execute import Results
from tgvdp.trials.reference import Case, Reference
from tgvdp.trials.spec import SolverSpec
from tgvdp.trials.statistics import attempts_to_success, proportion_interval

Record = Mapping[str, Any]
Row = dict[str, Any]

#: Two objectives count as equal when they differ by less than this part: both are rounded once.
_SAME = 1e-12


def rows_of(results: Results, hardware: str) -> list[Row]:
    """All rows, by size of the instance and in the order of the solvers."""
    cases = {case.instance.id: case for case in results.plan.cases}
    specs = {spec.label: spec for spec in results.plan.specs}
    return [
        _row(cases[name], specs[label], results.references[name], runs, hardware)
        for (name, label), runs in results.runs.items()
    ]


def _row(case: Case, spec: SolverSpec, reference: Reference, runs: Sequence[Record], hardware: str) -> Row:
    found = [run for run in runs if run["status"] == "ok"]
    feasible = [run for run in found if run["feasible"]]
    best = min((run["objective"] for run in feasible), default=None)
    bounds = [bound for run in found if (bound := _bound(run)) is not None]
    solved = [run for run in runs if succeeded(run, reference)]
    return {
        "Problem": case.instance.id,
        "Best Objective Value": best,
        "Optimality Bound": max(bounds, default=None),
        "Modeling Approach": _approach(case, spec),
        **_sizes(case, found),
        "Workflow": spec.label,
        "Algorithm Type": "Deterministic" if not spec.draws else "Stochastic",
        "# Runs": len(runs),
        "# Feasible Runs": len(feasible),
        "# Successful Runs": len(solved) if reference.certified else None,
        "Success Threshold": 0.0,
        "Hardware Specifications": hardware,
        "Total Runtime": statistics.fmean(run["wall_s"] for run in runs),
        "CPU Runtime": statistics.fmean(run["cpu_s"] for run in runs),
        "GPU Runtime": None,
        "QPU Runtime": _mean_of(found, "qpu_s"),
        "Other HW Runtime": None,
        "Remarks": _remarks(runs),
        **_ours(case, spec, reference, runs, found),
    }


def succeeded(run: Record, reference: Reference) -> bool:
    """Whether a run ended with a feasible schedule of the certified optimum, or proved rightly that there is none."""
    if not reference.feasible:
        return bool(run["status"] == "infeasible")
    return run["status"] == "ok" and run["feasible"] and _reaches(run["objective"], reference)


def _reaches(objective: float, reference: Reference) -> bool:
    best = reference.objective
    return best is not None and abs(objective - best) <= _SAME * max(abs(objective), abs(best))


def _ours(case: Case, spec: SolverSpec, reference: Reference, runs: Sequence[Record], found: Sequence[Record]) -> Row:
    attempts = sum(run["attempts"] for run in found)
    successes = sum(run["best_attempts"] for run in found if succeeded(run, reference))
    chance = _chance(spec, reference, runs, found, attempts, successes)
    elapsed_s, setup_s = _median(found, "elapsed_s"), _median(found, "setup_s")
    per_attempt_s = (
        statistics.median((run["elapsed_s"] - run["setup_s"]) / run["attempts"] for run in found) if found else None
    )
    bits = next((run["qubo"]["variables"] for run in found if run["qubo"]), None)
    row: Row = {
        "kind": "binary" if isinstance(case.instance, BinaryInstance) else "demand",
        "N": case.instance.steps,
        "solver": spec.solver,
        "encoding": spec.encoding,
        "status": _status(runs),
        "certified optimum": reference.objective,
        "optimum from": reference.source,
        "optimal schedules": reference.n_optimal,
        "attempts": attempts,
        "feasible attempts": sum(run["feasible_attempts"] for run in found),
        "successful attempts": successes if reference.certified else None,
        **chance,
        "random p_success": random_chance(spec.encoding, case, reference, bits),
        "elapsed_s median": elapsed_s,
        "elapsed_s least": min((run["elapsed_s"] for run in found), default=None),
        "elapsed_s most": max((run["elapsed_s"] for run in found), default=None),
        "cpu_s median": _median(runs, "cpu_s"),
        "setup_s median": setup_s,
    }
    for name, p in (("TTS99", "p_success"), ("TTS99 low", "p high"), ("TTS99 high", "p low")):
        needed = None if row[p] is None else attempts_to_success(row[p])
        known = needed is not None and per_attempt_s is not None
        row[f"{name} attempts"] = needed
        row[f"{name} sweeps"] = None if needed is None else needed * _sweeps(found)
        row[f"{name} s"] = setup_s + needed * per_attempt_s if known else None  # type: ignore[operator]
    return row


def _sweeps(found: Sequence[Record]) -> int:
    """Updates per bit of one attempt: sweeps of a sampler, layers of a circuit, else one."""
    details = found[0]["details"] if found else {}
    return int(details.get("sweeps") or details.get("layers") or 1)


def _chance(
    spec: SolverSpec,
    reference: Reference,
    runs: Sequence[Record],
    found: Sequence[Record],
    attempts: int,
    successes: int,
) -> Row:
    """Probability that an attempt succeeds: exact where a statevector tells it, else counted, with its interval.

    Solvers that draw nothing succeed always or never.
    """
    unknown: Row = {"p_success": None, "p low": None, "p high": None, "p from": None}
    tried = [run for run in runs if run["status"] != "refused"]
    if not reference.certified or not tried:
        return unknown
    if not spec.draws:
        p = float(all(succeeded(run, reference) for run in tried))
        return {"p_success": p, "p low": p, "p high": p, "p from": "no draw"}
    if not found:
        return unknown
    exact = [run["exact_probability"] for run in found if run["exact_probability"] is not None]
    if exact:
        p = statistics.median(exact)
        return {"p_success": p, "p low": min(exact), "p high": max(exact), "p from": "statevector"}
    low, high = proportion_interval(successes, attempts)
    return {"p_success": successes / attempts, "p low": low, "p high": high, "p from": "attempts"}


def random_chance(encoding: str | None, case: Case, reference: Reference, bits: int | None) -> float | None:
    """Probability that tossing coins gives an optimum: degeneracy / 2ⁿ.

    Only where each optimal schedule has exactly one string, and every one has it: without slack bits and limits on Σx.
    """
    if bits is None or reference.n_optimal is None or not isinstance(case.instance, BinaryInstance):
        return None
    low, high = case.instance.distance_range
    if encoding not in ("bits", "unary") or low < high:
        return None
    return float(reference.n_optimal / 2**bits)


def _approach(case: Case, spec: SolverSpec) -> str:
    if spec.encoding is not None:
        return f"QUBO, {spec.encoding}"
    if spec.solver in ("milp", "scip"):
        return "MILP" if spec.solver == "milp" else "MIQP"
    if spec.solver in ("cqm", "leap"):
        return "CQM"
    return "binary model" if isinstance(case.instance, BinaryInstance) else "demand model"


def _sizes(case: Case, found: Sequence[Record]) -> Row:
    """Size of what the solver gets: of the QUBO, of the program, else one control of few values per step."""
    steps = case.instance.steps
    span: Sequence[float] | None = None
    if found and found[0]["qubo"]:
        qubo = found[0]["qubo"]
        variables = binaries = qubo["variables"]
        integers, nonzeros, span = 0, qubo["variables"] + qubo["couplers"], qubo["coefficient_range"]
    elif found and "variables" in found[0]["details"]:
        details = found[0]["details"]
        variables, nonzeros = details["variables"], details["nonzeros"]
        binaries, integers = details.get("binaries"), details.get("integers")
    else:
        variables, binaries, integers, nonzeros = steps, 0, steps, None
    known = binaries is not None and integers is not None
    return {
        "# Decision Variables": variables,
        "# Binary Variables": binaries,
        "# Integer Variables": integers,
        "# Continuous Variables": variables - binaries - integers if known else None,
        "# Non-Zero Coefficients": nonzeros,
        "Coefficients Type": "continuous" if span else "integer",
        "Coefficients Range": f"{span[0]:.6g} to {span[1]:.6g}" if span else None,
    }


def _bound(run: Record) -> float | None:
    """Proved lower bound of a run."""
    bound: float | None = run["objective"] if run["optimal"] else run["bound"]
    return bound


def _status(runs: Sequence[Record]) -> str:
    return " ".join(sorted({run["status"] for run in runs}))


def _remarks(runs: Sequence[Record]) -> str | None:
    texts = {text for run in runs for text in (run["message"], *run["warnings"]) if text}
    return "; ".join(sorted(texts)) or None


def _median(runs: Sequence[Record], name: str) -> float | None:
    return statistics.median(run[name] for run in runs) if runs else None


def _mean_of(runs: Sequence[Record], name: str) -> float | None:
    values = [run["details"][name] for run in runs if run["details"].get(name) is not None]
    return statistics.fmean(values) if values else None


def embedding_rows(results: Results) -> list[Row]:
    """One row per instance, encoding and topology that was embedded."""
    cases = {case.instance.id: case for case in results.plan.cases}
    return [
        {
            "Problem": name, "N": cases[name].instance.steps, "encoding": encoding, "topology": topology,
            "status": found["status"], "variables": found.get("variables"), "couplers": found.get("couplers"),
            "qubits": found.get("qubits"), "longest chain": found.get("longest_chain"),
            "method": found.get("method"), "elapsed_s": found.get("elapsed_s"),
            "chain strength": found.get("chain_strength"), "finest coupling": found.get("finest_coupling"),
        }
        for (name, encoding, topology), found in results.embeddings.items()
    ]  # fmt: skip


def run_rows(results: Results) -> list[Row]:
    """One row per run, as it was kept."""
    names = ("seed", "status", "objective", "optimal", "feasible", "attempts", "feasible_attempts", "best_attempts")
    durations = ("elapsed_s", "setup_s", "wall_s", "cpu_s")
    return [
        {
            "Problem": name, "Workflow": label, "run": number,
            **{field: run.get(field) for field in (*names, "exact_probability", *durations)},
        }
        for (name, label), runs in results.runs.items()
        for number, run in enumerate(runs)
    ]  # fmt: skip
