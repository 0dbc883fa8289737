"""Kernels compiled before somebody waits for them: short runs that call all that a search may call.

A kernel is compiled for the types that it is called with, and each has one set of them, whatever the train, the line,
the energy and the convention are; tests count them.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from tgvdp._jit.cache import key_folder, make_folder
from tgvdp._jit.watch import Compiled, is_compiled, is_missing, watch
from tgvdp.api.beside import Left, Waiting, leave, left_to_another
from tgvdp.api.journeys import journey
from tgvdp.api.late import TRACK, TRAIN, some_run
from tgvdp.api.run import search
from tgvdp.certificate.ascent import climb
from tgvdp.certificate.banded import banded
from tgvdp.certificate.ledger import Ledger
from tgvdp.certificate.line import BoundingProblem
from tgvdp.certificate.speed_bound import Caps
from tgvdp.cores import on_one_core
from tgvdp.formats import load_train
from tgvdp.line.cells import Cells
from tgvdp.methods.costate.bridge import most_effort_n
from tgvdp.methods.refine.mesh import hold_fastest
from tgvdp.model.train import BrakingRate
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
    "is_compiled",
    "key_folder",
    "kinks",
    "make_folder",
    "margins",
    "tour",
    "watch",
]

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
    train = load_train(TRAIN)
    with watch() as compiled, on_one_core():  # whoever asks for tours has a second process of their own
        search(train, TRACK, **TOURS[name]).verify()
        most_effort_n(train, np.array([1.0, 2.0]))  # asked between extremals that lie far apart: none here
        if name == "map":
            hold_fastest(some_run()[0])
    return compiled


def margins() -> list[Compiled]:
    """Take a margin, whose first part meets another one: what a journey calls beside its searches."""
    with watch() as compiled:
        journey(load_train(TRAIN), replace(TRACK, stops_m=(0.0, 2e3)), points=2).margins("0:1000:5%,1000::10%")
    return compiled


def checks(certified: bool = True) -> list[Compiled]:
    """Replay and certify a run that no search made: what comes after a search can be compiled beside it."""
    trip, x_m, w = some_run()
    with watch() as compiled:
        profile = profile_of(trip, x_m, w)
        replay(trip, profile)
        if certified:
            BoundingProblem(trip).line(profile.position_m, profile.speed_mps**2, 1e4)
    return compiled


def ascents() -> list[Compiled]:
    """Raise a bound by better costates: the largest kernel of a certificate, compiled beside the others of `checks`."""
    trip, _, _ = some_run()
    problem = BoundingProblem(trip)
    cells = Cells._make(column.copy() for column in problem.cells)
    count = len(cells.length_m)
    caps = Caps(cells.limit_w, np.append(cells.limit_w, cells.limit_w[-1]), np.zeros((count, 2)))
    flat = np.zeros(count)
    found = Ledger(flat, flat, flat, flat, cells, caps, caps.node.copy(), np.zeros(count, dtype=np.int8))
    with watch() as compiled:
        problem.ascended(found, 1.0, 1e6)
    return compiled


def kinks() -> list[Compiled]:
    """Certify a run of a train whose braking rates drop: what few trips need."""
    trip, x_m, w = some_run()
    rates = BrakingRate(0.0, 0.9), BrakingRate(15.0, 0.6)
    problem = BoundingProblem(replace(trip, train=replace(trip.train, braking_rates=rates)))
    with watch() as compiled:
        found = problem.ledger(x_m, w, 1e4, gain_j=1e6)
        banded(problem, found, 1e4, gain_j=1e6)
    return compiled


def compile_beside(second: SecondProcess, waiting: Waiting, options: SearchOptions, *, certified: bool) -> None:
    """Have a second process compile half of what a search calls; here it is waited for where it is called.

    Parameters
    ----------
    second : SecondProcess
    waiting : function
        Makes a context in which people are told that they wait.
    options : SearchOptions
    certified : bool
        Whether the search will be certified.
    """
    parts = left_to_another(options)
    ascended = certified and is_missing(climb)
    if is_missing(replay_rows) or ascended:  # who waits for the checks has time for the ascent
        parts.append(Left(replay_rows, f"{__name__}:checks", ascents if ascended else list, (certified,)))
    leave(second, parts, waiting)
