"""The runs themselves: which there are, which are missing, and what is kept of each."""

import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError, MissingExtraError, UnavailableError
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.formulations.problem.instances import BinaryInstance
from tgvdp.formulations.problem.schedule import Solution
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.formulations.qubo.names import Encoding
from tgvdp.report.plain import plain
from tgvdp.solvers.registry import solve
from tgvdp.solvers.samplers.embedding import embedding_of, fineness
from tgvdp.trials.reference import Case, Reference, reference_of
from tgvdp.trials.spec import SolverSpec
from tgvdp.trials.store import Store

_REFERENCE = "certified optimum"
#: Entries of a solution's details that lists of thousands of rows need not carry.
_LONG = ("gamma", "beta")


@dataclass(frozen=True)
class Plan:
    """What a benchmark is to do.

    Attributes
    ----------
    cases : tuple of Case
    specs : tuple of SolverSpec
    runs : int
        Of each solver on each instance, where the solver has no number of its own.
    seed : int
        Run r of every solver draws with seed + r.
    topologies : tuple of str
        Graphs of annealers into which the QUBOs are embedded.
    embedding_limit_s : float
        Time for one embedding.
    """

    cases: tuple[Case, ...]
    specs: tuple[SolverSpec, ...]
    runs: int
    seed: int = 1
    topologies: tuple[str, ...] = ()
    embedding_limit_s: float = 60.0

    @property
    def encodings(self) -> tuple[Encoding, ...]:
        """Encodings that the solvers use."""
        return tuple(sorted({spec.encoding for spec in self.specs if spec.encoding is not None}))


class Work(NamedTuple):
    """One run: its case, what names it in the store, its number, and how it is done."""

    case: Case
    name: str
    number: int
    do: Callable[[], dict[str, Any]]


@dataclass(frozen=True)
class Results:
    """All runs of a plan.

    Attributes
    ----------
    plan : Plan
    references : dict of instance id to Reference
    runs : dict of (instance id, solver's word) to list of dict
    embeddings : dict of (instance id, encoding, topology) to dict
    """

    plan: Plan
    references: dict[str, Reference]
    runs: dict[tuple[str, str], list[dict[str, Any]]]
    embeddings: dict[tuple[str, str, str], dict[str, Any]]


def merged(parts: Sequence[Results]) -> Results:
    """Results of plans of the same runs and seed, on other instances or by other solvers, as one."""
    cases = {case.instance.id: case for part in parts for case in part.plan.cases}
    specs = {spec.label: spec for part in parts for spec in part.plan.specs}
    plan = replace(parts[0].plan, cases=tuple(cases.values()), specs=tuple(specs.values()))
    known: list[dict[Any, Any]] = [
        {key: value for part in parts for key, value in getattr(part, name).items()}
        for name in ("references", "runs", "embeddings")
    ]
    return Results(plan, *known)


def run_benchmark(plan: Plan, folder: Path, progress: Callable[[int, int, str], None]) -> Results:
    """Make the runs that are missing in a folder, one after the other, and return all.

    Parameters
    ----------
    plan : Plan
    folder : Path
        Of the results; what is finished is kept there, also when this is interrupted.
    progress : callable
        Gets the number of finished runs, that of all, and what comes next.

    Raises
    ------
    InputError
        When a kept file is damaged, the folder cannot be written, or an extra or an account is missing.
    """
    store = Store(folder, plan.seed)
    works = list(_works(plan))
    done: dict[tuple[str, str], dict[int, dict[str, Any]]] = {}
    for number, work in enumerate(works):
        key = (work.case.instance.id, work.name)
        if key not in done:
            done[key] = store.runs(key[0], work.case.sha256, work.name)
        if work.number in done[key]:
            continue
        progress(number, len(works), f"{key[0]} {work.name}")
        record: dict[str, Any] = plain(work.do())
        store.keep(key[0], work.case.sha256, work.name, work.number, record)
        done[key][work.number] = record
    progress(len(works), len(works), "tables and pictures")
    return _results(plan, done)


def _works(plan: Plan) -> Iterator[Work]:
    for case in plan.cases:
        yield Work(case, _REFERENCE, 0, partial(reference_of, case))
        for spec in plan.specs:
            for number in range(spec.runs or plan.runs):
                yield Work(case, spec.label, number, partial(one_run, case, spec, plan.seed + number))
        for encoding, topology in _embeddings(plan, case):
            name = _embedding_name(encoding, topology, plan)
            yield Work(case, name, 0, partial(_embedded, case, encoding, topology, plan))


def _embeddings(plan: Plan, case: Case) -> list[tuple[Encoding, str]]:
    if not isinstance(case.instance, BinaryInstance):
        return []
    return [(encoding, topology) for encoding in plan.encodings for topology in plan.topologies]


def _embedding_name(encoding: str, topology: str, plan: Plan) -> str:
    return f"embedding:{encoding}:{topology}:time-limit={plan.embedding_limit_s:g}"


def _results(plan: Plan, done: dict[tuple[str, str], dict[int, dict[str, Any]]]) -> Results:
    references: dict[str, Reference] = {}
    runs: dict[tuple[str, str], list[dict[str, Any]]] = {}
    embeddings: dict[tuple[str, str, str], dict[str, Any]] = {}
    for case in plan.cases:
        name = case.instance.id
        references[name] = Reference(**done[name, _REFERENCE][0])
        for spec in plan.specs:
            found = done[name, spec.label]
            runs[name, spec.label] = [found[number] for number in range(spec.runs or plan.runs)]
        for encoding, topology in _embeddings(plan, case):
            embeddings[name, encoding, topology] = done[name, _embedding_name(encoding, topology, plan)][0]
    return Results(plan, references, runs, embeddings)


def one_run(case: Case, spec: SolverSpec, seed: int) -> dict[str, Any]:
    """Run a solver once.

    Returns
    -------
    dict
        ``status``: ``ok``, or ``infeasible`` (proved), ``budget`` (nothing found) and ``refused`` (not for such
        instances), with a ``message``; the seed; wall time and processor time of everything in s, from the instance
        to the replayed solution; and of what is ``ok``, what `_found` says.
    """
    wall, cpu = time.perf_counter(), time.process_time()
    record: dict[str, Any] = {"status": "ok", "message": None, "seed": seed if spec.draws else None}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", FormulationWarning)
        try:
            solution = solve(case.instance, spec.solver, spec.encoding, spec.penalty, spec.allowance(seed))
        except (MissingExtraError, UnavailableError):
            raise  # of this machine, not of the instance: nothing to keep
        except InfeasibleError as error:
            record |= {"status": "infeasible", "message": str(error)}
        except BudgetExceededError as error:
            record |= {"status": "budget", "message": str(error)}
        except InputError as error:
            record |= {"status": "refused", "message": str(error)}
        else:
            record |= _found(solution)
    record["warnings"] = sorted({str(one.message) for one in caught})
    return record | {"wall_s": time.perf_counter() - wall, "cpu_s": time.process_time() - cpu}


def _found(solution: Solution) -> dict[str, Any]:
    """What a solution says: an attempt is a read or a shot, and the whole run of a solver that makes none."""
    details = dict(solution.details)
    attempts = details.pop("reads", None)
    probability = details.pop("success_probability", None)  # of a circuit without noise
    return {
        "objective": solution.objective,
        "optimal": solution.optimal,
        "n_optimal": solution.n_optimal,
        # The replay trusts nothing that the schedule says of itself.
        "feasible": bool(solution.feasible and solution.replay["feasible"]),
        "replay_energy": solution.replay["energy"],
        "controls": list(solution.schedule.controls),
        "elapsed_s": solution.elapsed_s,
        "setup_s": details.pop("setup_s", 0.0),
        "attempts": 1 if attempts is None else attempts,
        "feasible_attempts": int(solution.feasible) if attempts is None else details.pop("feasible_reads"),
        "best_attempts": int(solution.feasible) if attempts is None else details.pop("best_reads"),
        "exact_probability": None if details.get("backend") else probability,
        "bound": details.pop("bound", None),
        "qubo": solution.qubo,
        "details": {name: value for name, value in details.items() if name not in _LONG},
    }


def _embedded(case: Case, encoding: Encoding, topology: str, plan: Plan) -> dict[str, Any]:
    """Size of an embedding; ``status`` is ``refused`` where the encoding does not fit the instance."""
    assert isinstance(case.instance, BinaryInstance)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormulationWarning)
        try:
            qubo = encode(case.instance, encoding, "sufficient").qubo
        except InputError as error:
            return {"status": "refused", "message": str(error)}
    found = embedding_of(qubo, topology, plan.seed, plan.embedding_limit_s)
    status = "none found" if found.qubits is None else "ok"
    return {
        "status": status, **found._asdict(), "variables": qubo.n, "couplers": qubo.stats.couplers,
        **fineness(qubo)._asdict(),
    }  # fmt: skip
