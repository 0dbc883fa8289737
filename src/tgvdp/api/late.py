"""Kernels that another process compiles while a search begins: each is called for a run that no search made.

A kernel is compiled for the types that it is called with, and each has one set of them, whatever the train, the line,
the energy and the convention are.
"""

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit.watch import Compiled, watch
from tgvdp.formats import load_train
from tgvdp.line.resolved import resolve
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.phases.prune import prune_fastest
from tgvdp.model.track import Gradient, SpeedLimit, Track
from tgvdp.model.trip import Trip
from tgvdp.runs.batch import Batch
from tgvdp.runs.bends import cut_at_bends
from tgvdp.runs.profile import profile_of

TRAIN = "alstom-emu"  # its effort has a drop
TRACK = Track(length_m=2e3, speed_limits=(SpeedLimit(0.0, 20.0),), gradients=(Gradient(0.0, 0.0), Gradient(900.0, 8.0)))


def some_run() -> tuple[Trip, NDArray[np.float64], NDArray[np.float64]]:
    """A trip with rows of a run: positions from its origin, m, and squared speeds, m²/s²."""
    trip = Trip(train=load_train(TRAIN), track=TRACK, origin_m=0.0, destination_m=TRACK.length_m)
    x_m, w = np.array([(0.0, 0.0), (20.0, 30.0), (200.0, 150.0), (900.0, 150.0), (1800.0, 150.0), (2000.0, 0.0)]).T
    return trip, x_m.copy(), w.copy()


def measuring() -> list[Compiled]:
    """Make a profile; returns the kernels that had to be compiled, as all of these do."""
    with watch() as compiled:
        profile_of(*some_run())
    return compiled


def cutting() -> list[Compiled]:
    """Cut rows where motion bends."""
    trip, x_m, w = some_run()
    with watch() as compiled:
        cut_at_bends(trip.train, resolve(trip), Batch.of([(x_m, w)]))
    return compiled


def solving() -> list[Compiled]:
    """Solve no multiplier on a mesh."""
    mesh = Mesh.along(*some_run())
    with watch() as compiled:
        mesh.switching_speeds(np.empty(0), np.empty((0, len(mesh.fast), 4)))
    return compiled


def driving() -> list[Compiled]:
    """Drive on a mesh."""
    with watch() as compiled:
        Mesh.along(*some_run()).share()
    return compiled


def pruning() -> list[Compiled]:
    """Leave short phases out."""
    with watch() as compiled:
        prune_fastest(*some_run(), 1.0)
    return compiled
