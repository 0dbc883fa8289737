"""Kernels compiled before somebody waits for them: short runs that call all that a search may call.

A kernel is compiled for the types that it is called with, and each has one set of them, whatever the train, the line,
the energy and the convention are; tests count them.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit.cache import key_folder, make_folder
from tgvdp._jit.watch import Compiled, is_compiled, is_missing, leave_to_another, watch
from tgvdp.api.beside import late_kernels
from tgvdp.api.journeys import journey
from tgvdp.api.run import search
from tgvdp.certificate.ascent import climb
from tgvdp.certificate.cell_bounds import WHOLE
from tgvdp.certificate.kinked import kinked
from tgvdp.certificate.ledger import Ledger
from tgvdp.certificate.line import BoundingProblem
from tgvdp.certificate.speed_bound import Caps
from tgvdp.cores import on_one_core
from tgvdp.formats import load_train
from tgvdp.line.cells import Cells
from tgvdp.methods.costate.bridge import most_effort_n
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.phases.prune import prune_fastest
from tgvdp.model.track import Gradient, SpeedLimit, Track
from tgvdp.model.train import BrakingRate
from tgvdp.model.trip import Trip
from tgvdp.options.search import SearchOptions
from tgvdp.referee.drive import replay_rows
from tgvdp.referee.replay import replay
from tgvdp.runs.profile import profile_of
from tgvdp.second_process import SecondProcess

__all__ = [
    "TOURS",
    "Compiled",
    "ascents",
    "checks",
    "compile_beside",
    "driving",
    "is_compiled",
    "key_folder",
    "kinks",
    "make_folder",
    "margins",
    "pruning",
    "tour",
    "watch",
]

Waiting = Callable[[], AbstractContextManager[None]]

_TRAIN = "alstom-emu"  # its effort has a drop
_TRACK = Track(
    length_m=2e3, speed_limits=(SpeedLimit(0.0, 20.0),), gradients=(Gradient(0.0, 0.0), Gradient(900.0, 8.0))
)
_GRID = {"segment_m": 500.0, "speeds": 8}
#: Searches that call all kernels between them, by name.
TOURS: dict[str, dict[str, Any]] = {
    "front": {"points": 4, "energy": "pantograph"},
    "clean": {"points": 4, "clean": True},
    "map": {"points": 3, "energy": "map"},
    "exact": {"method": "exact", **_GRID},
    "best-first": {"method": "best-first", "paths": 3, **_GRID},
}


def tour(name: str) -> list[Compiled]:
    """Run one of `TOURS` and replay it; returns the kernels that had to be compiled."""
    train = load_train(_TRAIN)
    with watch() as compiled, on_one_core():  # whoever asks for tours has a second process of their own
        search(train, _TRACK, **TOURS[name]).verify()
        most_effort_n(train, np.array([1.0, 2.0]))  # asked between extremals that lie far apart: none here
    return compiled


def margins() -> list[Compiled]:
    """Take a margin, whose first part meets another one: what a journey calls beside its searches."""
    with watch() as compiled:
        journey(load_train(_TRAIN), replace(_TRACK, stops_m=(0.0, 2e3)), points=2).margins("0:1000:5%,1000::10%")
    return compiled


def driving() -> list[Compiled]:
    """Drive on a mesh that no search made: what a search calls after its first extremals can be compiled beside it."""
    with watch() as compiled:
        _ = Mesh.along(*_some_run()).course
    return compiled


def pruning() -> list[Compiled]:
    """Leave short phases out of a run that no search made: what ends a front can be compiled beside it."""
    with watch() as compiled:
        prune_fastest(*_some_run(), 1.0)
    return compiled


def checks(certified: bool = True) -> list[Compiled]:
    """Replay and certify a run that no search made: what comes after a search can be compiled beside it."""
    trip, x_m, w = _some_run()
    with watch() as compiled:
        profile = profile_of(trip, x_m, w)
        replay(trip, profile)
        if certified:
            BoundingProblem(trip).line(profile.position_m, profile.speed_mps**2, 1e4)
    return compiled


def ascents() -> list[Compiled]:
    """Raise a bound by better costates: the largest kernel of a certificate, compiled beside the others of `checks`."""
    trip, _, _ = _some_run()
    problem = BoundingProblem(trip)
    cells = Cells._make(column.copy() for column in problem.cells)
    count = len(cells.length_m)
    caps = Caps(cells.limit_w, np.append(cells.limit_w, cells.limit_w[-1]), np.zeros((count, 2)))
    flat = np.zeros(count)
    found = Ledger(
        flat, flat, flat, flat, np.zeros(count + 1), cells, caps, caps.node.copy(), np.zeros(count, dtype=np.int8)
    )
    with watch() as compiled:
        problem.climbed(found, 1.0, WHOLE, np.full((count, 2), np.inf), 1e6, None)
    return compiled


def kinks() -> list[Compiled]:
    """Certify a run of a train whose braking rates drop, and one of cheap time: what few trips need."""
    trip, x_m, w = _some_run()
    rates = BrakingRate(0.0, 0.9), BrakingRate(15.0, 0.6)
    problem = BoundingProblem(replace(trip, train=replace(trip.train, braking_rates=rates)))
    with watch() as compiled:
        found = problem.ledger(x_m, w, 1e4, gain_j=1e6)
        kinked(problem, found, 1e4, gain_j=1e6)
        problem.curved(found, 1e4, gain_j=1e6)
    return compiled


def _some_run() -> tuple[Trip, NDArray[np.float64], NDArray[np.float64]]:
    trip = Trip(train=load_train(_TRAIN), track=_TRACK, origin_m=0.0, destination_m=_TRACK.length_m)
    x_m, w = np.array([(0.0, 0.0), (20.0, 30.0), (200.0, 150.0), (900.0, 150.0), (1800.0, 150.0), (2000.0, 0.0)]).T
    return trip, x_m.copy(), w.copy()


def compile_beside(second: SecondProcess, waiting: Waiting, options: SearchOptions, *, certified: bool) -> None:
    """Have a second process compile what a search calls late; here it is waited for where it is called.

    Parameters
    ----------
    second : SecondProcess
    waiting : function
        Makes a context in which people are told that they wait.
    options : SearchOptions
    certified : bool
        Whether the search will be certified.
    """
    ascended = certified and is_missing(climb)
    parts: list[tuple[Any, Callable[[], object], Callable[[], object]]] = [
        (kernel, second.promise(task), list) for kernel, task in late_kernels(options)
    ]
    if is_missing(replay_rows) or ascended:  # who waits for the checks has time for the ascent
        checked = second.promise(f"{__name__}:checks", certified)
        parts.append((replay_rows, checked, ascents if ascended else list))
    for first, done, meanwhile in parts:
        if second.is_there:
            leave_to_another(first, _waited_for(done, waiting, meanwhile))


def _waited_for(done: Callable[[], object], waiting: Waiting, meanwhile: Callable[[], object]) -> Callable[[], None]:
    def wait() -> None:
        with waiting():
            meanwhile()
            done()

    return wait
