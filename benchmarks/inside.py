"""The only place where benchmarks reach into the search: cells of a chosen size, and clocks around its phases."""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest import mock

import tgvdp.api.run
from tgvdp.methods.budget import SearchBudget
from tgvdp.methods.costate import backward, mesh
from tgvdp.methods.costate.front import optimal_front
from tgvdp.methods.costate.multipliers import ExtremalFront


@contextmanager
def finer_cells(factor: float) -> Iterator[None]:
    """Within this context the front method takes cells smaller by a factor."""
    chosen = mesh._cell_size
    with mock.patch.object(mesh, "_cell_size", lambda trip, fastest: chosen(trip, fastest) / factor):
        yield


def mesh_of(result: Any) -> mesh.Mesh:
    """The mesh that a search used: the last one of the same search done once more."""
    used: list[mesh.Mesh] = []
    reach = ExtremalFront.reach

    def noted(front: ExtremalFront, last_s: float) -> bool:
        used.append(front.mesh)
        return reach(front, last_s)

    with mock.patch.object(ExtremalFront, "reach", noted):
        optimal_front(result.trip, result.fastest.profile, result.front.time_s, SearchBudget())
    return used[-1]


def _clocked(call: Callable[..., Any], name: str, spent_s: dict[str, float]) -> Callable[..., Any]:
    def clocked(*arguments: Any, **options: Any) -> Any:
        started = time.perf_counter()
        try:
            return call(*arguments, **options)
        finally:
            spent_s[name] += time.perf_counter() - started

    return clocked


def phases_of(search: Callable[[], Any]) -> dict[str, float]:
    """Wall time in s of a search, by phase; the phases add up to its total. Clocks take about 1 µs a call."""
    spent_s = dict.fromkeys(("fastest run", "mesh", "backward passes", "drives"), 0.0)
    places = (
        (tgvdp.api.run, "fastest_run", "fastest run"),
        (mesh.Mesh, "of", "mesh"),
        (backward, "switching_speeds", "backward passes"),
        (mesh, "drive", "drives"),
    )
    with ExitStack() as stack:
        for owner, attribute, name in places:
            clocked = _clocked(getattr(owner, attribute), name, spent_s)
            if attribute == "of":  # a class method, bound already
                clocked = staticmethod(clocked)
            stack.enter_context(mock.patch.object(owner, attribute, clocked))
        started = time.perf_counter()
        search()
        total_s = time.perf_counter() - started
    return spent_s | {"choice of points, copies": total_s - sum(spent_s.values())}
