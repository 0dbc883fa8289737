"""A sweep without files: an iterable of scenarios in, an iterator of results out."""

import inspect
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from tgvdp.errors import InputError
from tgvdp.formats import load_track, load_train
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.pareto import ParetoFront
from tgvdp.sweeps.batches import Batches
from tgvdp.sweeps.cluster import Cluster, started
from tgvdp.sweeps.engine import Engine
from tgvdp.sweeps.scenario import Kind, Task
from tgvdp.sweeps.work import Record


@dataclass(frozen=True, eq=False)
class SweepResult:
    """What came of a scenario.

    Attributes
    ----------
    number : int
        Its place among those that were given, from 0.
    scenario : mapping
        As it was given.
    status : {"done", "partial", "failed", "killed"}
        Partial: its budget ended it. Failed: it has an error. Killed: three workers died of it.
    error : str or None
    fastest_time_s, fastest_energy_j : float or None
        The fastest run, s and J.
    front : ParetoFront or None
    price_kwh_per_min : (n,) float64 or None
        What a minute saves at each point; not finite where there is none.
    elapsed_s : float
        What it took the worker, s.
    """

    number: int
    scenario: Mapping[str, Any]
    status: str
    error: str | None
    fastest_time_s: float | None
    fastest_energy_j: float | None
    front: ParetoFront | None
    price_kwh_per_min: Any
    elapsed_s: float


def sweep(
    scenarios: Iterable[Mapping[str, Any]],
    *,
    kind: Kind = "search",
    scheduler: str | None = None,
    workers: int | None = None,
    worker_memory_b: float | None = None,
) -> Iterator[SweepResult]:
    """Search, or run journeys, for many scenarios on the cores of this machine or on a Dask cluster.

    Scenarios are taken as workers get free, so that the iterable may be long or endless, and nothing is kept.

    Parameters
    ----------
    scenarios : iterable of mapping
        Arguments of `tgvdp.search`, or of `tgvdp.journey`, each: ``{"train": "tgv", "track": "lgv-100km",
        "wind_mps": 5.0}``. Trains and lines that several have in common are best the same objects.
    kind : {"search", "journey"}
    scheduler : str, optional
        Address of a Dask cluster; by default workers are started on this machine.
    workers : int, optional
        Their number on this machine; by default one for each core.
    worker_memory_b : float, optional
        Memory of each at most, B; by default its share of the machine's.

    Yields
    ------
    SweepResult
        As they are finished, in no order: `SweepResult.number` is that of the scenario.

    Raises
    ------
    InputError
        When a scenario is none: an argument is unknown, train or track are missing or cannot be read.
    MissingExtraError
        When Dask is not installed.
    UnavailableError
        When the scheduler does not answer.

    Notes
    -----
    Workers are processes that import the main module: a script starts its sweep below ``if __name__ == "__main__":``.
    """
    given: dict[int, Mapping[str, Any]] = {}

    def tasks() -> Iterator[Task]:
        read = _Reader()
        for number, scenario in enumerate(scenarios):
            given[number] = scenario
            yield _task(number, scenario, kind, read)

    with started(Cluster(scheduler, workers, worker_memory_b)) as connect:
        for records in Engine(connect(), Batches(tasks(), lambda: None)).records():
            for record in records:
                yield _result(record, given.pop(record.id))


class _Reader:
    """Reads each file once."""

    def __init__(self) -> None:
        self._known: dict[tuple[str, str], Any] = {}

    def __call__(self, role: str, source: Any) -> Any:
        if isinstance(source, Train | Track):
            return source
        if (role, str(source)) not in self._known:
            self._known[role, str(source)] = load_train(source) if role == "train" else load_track(source)
        return self._known[role, str(source)]


def _task(number: int, scenario: Mapping[str, Any], kind: Kind, read: _Reader) -> Task:
    from tgvdp import api

    known = inspect.signature(getattr(api, kind)).parameters
    if not isinstance(scenario, Mapping) or not {"train", "track"} <= set(scenario) <= set(known):
        unknown = sorted(set(scenario) - set(known)) if isinstance(scenario, Mapping) else []
        what = f"{kind} has no argument {unknown[0]!r:.40}" if unknown else "must have a train and a track"
        raise InputError(f"scenario {number}: {what}")
    arguments = {name: value for name, value in scenario.items() if name not in ("train", "track")}
    try:
        train, track = (read(role, scenario[role]) for role in ("train", "track"))
    except InputError as error:
        raise InputError(f"scenario {number}: {error}") from None
    return Task(number, kind, train, track, (), arguments, None)


def _result(record: Record, scenario: Mapping[str, Any]) -> SweepResult:
    front = record.front
    return SweepResult(
        number=record.id,
        scenario=scenario,
        status=record.status,
        error=record.error,
        fastest_time_s=record.fastest_time_s,
        fastest_energy_j=record.fastest_energy_j,
        front=None if front is None else ParetoFront.of(front.time_s, front.energy_j),
        price_kwh_per_min=None if front is None else front.price_kwh_per_min,
        elapsed_s=record.elapsed_s,
    )
