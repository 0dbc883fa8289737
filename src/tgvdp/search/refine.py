"""The generic refinement: the front for any energy of an arc, by discrete differential dynamic programming.

For each of a few multipliers λ the run of least E + λT is found by repeated dynamic programs over a few speeds around
an incumbent, with ever smaller steps (docs/refine.md). Between two neighbouring runs the front lies above their
tangents, so that multipliers are added only until a blend of the two is as good as any run could be.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import TgvdpError
from tgvdp.line.cells import cells_of
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.physics.forces import kernel_train
from tgvdp.physics.profile import Profile
from tgvdp.search.budget import SearchBudget
from tgvdp.search.optimal import OptimalRuns
from tgvdp.search.pilots import Mesh
from tgvdp.search.refine_kernel import EnergyTables, blend, descend, envelope_kernel, measure

#: Speeds of the first program of a multiplier that has no neighbours, from standstill to the fastest run.
_COARSE = 24
#: Speeds above and below the incumbent in a sweep.
_HALF = 3
#: First step around a neighbour's run, as a share of the fastest run's v².
_FIRST_STEP = 0.02
#: Last step, as a share of the first.
_FINEST = 1e-4
#: Gap between the chord of two neighbouring runs and their tangents, as a share of energy, that needs no run between.
_BEND = 3e-4
#: How well a point meets its running time by default: a share of the step to the next point.
_STEP_TOL = 0.03
#: Step of ln λ towards slower runs, and how many steps without saving end the front.
_MARCH = 1.0
_IDLE_STEPS = 6
_SAME_PRICE = 2e-3
_SAME = 1e-9
_MOST_RUNS = 250

_NO_NODES = np.empty(0)
_NO_MAP = np.empty((0, 0))


def linear_energy(traction: float, regeneration: float) -> EnergyTables:
    """Energy that is piecewise linear in work at the wheel: ``traction`` per joule pulled, ``regeneration`` back."""
    return EnergyTables(float(traction), float(regeneration), _NO_NODES, _NO_NODES, _NO_MAP)


#: Traction work at the wheel, max(X, 0).
WHEEL = linear_energy(1.0, 0.0)


def pantograph_energy(train: Train) -> EnergyTables:
    """Energy at the pantograph with the train's constant efficiencies; the dynamic brake regenerates."""
    return linear_energy(1.0 / train.traction_efficiency, train.regeneration_efficiency)


@dataclass(frozen=True)
class _Run:
    price: float
    w: NDArray[np.float64]
    time_s: float
    energy_j: float


class _Refinement:
    def __init__(self, mesh: Mesh, energy: EnergyTables, tolerance_s: float) -> None:
        self.mesh, self.energy, self.tolerance_s = mesh, energy, tolerance_s
        cells = mesh.cells
        self.slopes = (cells.length_m, cells.grade_n, cells.air)
        n = len(cells.length_m) + 1
        self.low, self.fast = np.empty(n), np.empty(n)
        trip = mesh.trip
        envelope_kernel(mesh.train, *self.slopes, cells.limit_w, trip.start_speed_mps**2, trip.end_speed_mps**2, self.low, self.fast)
        width = 2 * _COARSE + 1
        self.scratch = (np.empty((n, width)), np.empty(n, np.int64), np.empty((n, width), np.int16), np.empty((2, width)))
        self.counters = {"pilots": 0, "runs": 0, "sweeps": 0}
        self.runs = [self._run(math.inf, self.fast)]
        self.scale_j = mesh.usual_price * self.runs[0].time_s
        self.price = mesh.usual_price
        self.idle = 0

    def _run(self, price, w):
        time_s, energy_j = measure(self.mesh.train, self.energy, *self.slopes, w)
        return _Run(price, w, time_s, energy_j)

    def _descend(self, price, w, step, half, finest):
        step[0] = step[-1] = 0.0
        self.counters["sweeps"] += descend(self.mesh.train, self.energy, *self.slopes, self.low, self.fast, price, half, finest, w, step, *self.scratch)

    def solve(self, price, near=None, step=None):
        self.counters["pilots"] += 1
        if near is None:
            w = self.fast.copy()
            self._descend(price, w, np.full(len(w), self.fast.max() / _COARSE), _COARSE, 1.0)
            step = np.full(len(w), self.fast.max() / (2 * _COARSE))
        else:
            w = near
        self._descend(price, w, step, _HALF, _FINEST)
        return self._run(price, w)
