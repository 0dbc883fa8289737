"""Runs of the front method without phases that are too short to drive: the points of a front, one by one."""

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.costate.mesh import Mesh, Run
from tgvdp.methods.phases.prune import Pruner
from tgvdp.methods.phases.way import way_of
from tgvdp.physics.cell import Rows
from tgvdp.physics.codes import BRAKING, COASTING, DYNAMIC, HOLDING, TRACTION

#: What leaving phases out may add to E + λT, as a share of a run's energy; but of no less than this share of the energy
#: for traction of the fastest run, as net energies may be 0.
_LOSS = 1e-5
_LEAST_SHARE = 0.1
#: ... and as a share of what the next run costs less: the order of runs stays what it is.
_OF_STEP = 0.2
#: Regime of a profile for each of a row: the dynamic brake brakes.
_PROFILE_REGIMES = np.full(DYNAMIC + 1, -1, dtype=np.int8)
_PROFILE_REGIMES[[TRACTION, HOLDING, COASTING, BRAKING, DYNAMIC]] = TRACTION, HOLDING, COASTING, BRAKING, BRAKING


def drivable(
    mesh: Mesh,
    runs: list[Run],
    aims_s: NDArray[np.float64],
    tolerance_s: float,
    min_phase_s: float,
    counters: dict[str, int],
) -> tuple[list[Run], list[NDArray[np.int8] | None]]:
    """Leave short phases out of runs.

    Parameters
    ----------
    mesh : Mesh
        On which they were found.
    runs : list of Run
        In the order of their running times, slower than the fastest one.
    aims_s : (n,) float64
        Running times that are wanted, s.
    tolerance_s : float
        How well they are met, s.
    min_phase_s : float
        Shorter phases are left out, s.
    counters : dict of str to int, modified in place
        ``short`` counts those that had to stay.

    Returns
    -------
    runs : list of Run
    regimes : list of (n,) int8
        Regime of each row, as `runs.profile` numbers them.
    """
    way = way_of(mesh.train, mesh.cells, Rows(mesh.envelope.x_m, mesh.envelope.w), mesh.tables)
    pruner = Pruner(way, max((len(run.x_m) for run in runs), default=0))
    energies_j = np.array([run.energy_j for run in runs])
    steps_j = -np.diff(energies_j, prepend=np.inf, append=-np.inf)
    least_j = _LEAST_SHARE * mesh.usual_multiplier * min((run.time_s for run in runs), default=0.0)
    found: list[Run] = []
    regimes: list[NDArray[np.int8] | None] = []
    for run, step_j in zip(runs, np.minimum(steps_j[1:], steps_j[:-1]).tolist(), strict=True):
        most_j = min(_LOSS * max(abs(run.energy_j), least_j), _OF_STEP * step_j)
        early_s = float(aims_s[np.argmin(np.abs(aims_s - run.time_s))] - run.time_s)
        if abs(early_s) > tolerance_s:  # it stands for a time that no run takes
            early_s = 0.0
        window_s = early_s - tolerance_s, early_s + tolerance_s
        pruned = pruner.prune(run.x_m, run.w, run.multiplier, min_phase_s, most_j, window_s)
        counters["short"] += pruned.short
        found.append(
            Run(run.time_s + pruned.time_s, run.energy_j + pruned.energy_j, run.multiplier, pruned.x_m, pruned.w)
        )
        regimes.append(_PROFILE_REGIMES[pruned.regime])
    return found, regimes
