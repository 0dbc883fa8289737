"""Runs of the front method without phases that are too short to drive: the points of a front, one by one."""

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from tgvdp.cores import shares, side_by_side
from tgvdp.methods.budget import Clock
from tgvdp.methods.costate.mesh import Mesh, Run
from tgvdp.methods.phases.prune import Pruned, prune
from tgvdp.methods.phases.way import way_of
from tgvdp.physics.cell import Rows
from tgvdp.runs.batch import ROWS_OF_A_THREAD

#: What leaving phases out may add to E + λT, as a share of a run's energy; but of no less than `Mesh.least_energy_j`.
_LOSS = 5e-5
#: ... and as a share of what the next run costs less: the order of runs stays what it is.
_OF_STEP = 0.2
#: Rows between two looks at the clock: a tenth of a second. Usual runs have some thousand; one of more than these stays
#: as it is.
_ROWS_AT_ONCE = 200_000


def drivable(
    mesh: Mesh,
    runs: list[Run],
    aims_s: NDArray[np.float64],
    tolerance_s: float,
    min_phase_s: float,
    counters: dict[str, int],
    clock: Clock,
) -> tuple[list[Run], list[NDArray[np.int8] | None], bool]:
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
    clock : Clock
        Runs that it leaves no time for stay as they are.

    Returns
    -------
    runs : list of Run
    regimes : list of (n,) int8 or None
        Regime of each row, as `runs.profile` numbers them; None of a run that stayed as it is.
    complete : bool
        False where the time was up.
    """
    way = way_of(mesh.train, mesh.cells, Rows(mesh.envelope.x_m, mesh.envelope.w), mesh.tables)
    times_s, energies_j, price = np.array([(run.time_s, run.energy_j, run.multiplier) for run in runs]).reshape(-1, 3).T
    steps_j = np.full(len(runs) + 1, np.inf)
    steps_j[1:-1] = energies_j[:-1] - energies_j[1:]
    drawn_j = energies_j + mesh.tables.auxiliary_w * times_s
    most_j = np.minimum(
        _LOSS * np.maximum(np.abs(drawn_j), mesh.least_energy_j), _OF_STEP * np.minimum(steps_j[1:], steps_j[:-1])
    )
    early_s = aims_s[np.abs(aims_s - times_s[:, np.newaxis]).argmin(axis=1)] - times_s
    early_s[np.abs(early_s) > tolerance_s] = 0.0  # it stands for a time that no run takes
    found = list(runs)
    regimes: list[NDArray[np.int8] | None] = [None] * len(runs)

    def pruned(part: slice) -> list[Pruned]:
        given = [(run.x_m, run.w) for run in runs[part]]
        return prune(way, given, price[part].copy(), min_phase_s, most_j[part], early_s[part], tolerance_s)

    rows = [len(run.x_m) for run in runs]
    count = shares(sum(rows), ROWS_OF_A_THREAD)
    parts = list(_parts(rows, min(_ROWS_AT_ONCE, math.ceil(sum(rows) / count))))
    for first in range(0, len(parts), count):
        if clock.expired:
            return found, regimes, False
        wave = [part for part in parts[first : first + count] if sum(rows[part]) <= _ROWS_AT_ONCE]
        for part, ones in zip(wave, side_by_side(pruned, wave), strict=True):
            counters["short"] += sum(one.short for one in ones)
            found[part] = [
                Run(run.time_s + one.time_s, run.energy_j + one.energy_j, run.multiplier, one.x_m, one.w)
                for run, one in zip(runs[part], ones, strict=True)
            ]
            regimes[part] = [one.regime for one in ones]
    return found, regimes, True


def _parts(rows: Sequence[int], most: int) -> Iterator[slice]:
    """Neighbouring runs that have few enough rows together, or one that has more."""
    first = together = 0
    for index, count in enumerate(rows):
        if index > first and together + count > most:
            yield slice(first, index)
            first = index
            together = 0
        together += count
    yield slice(first, len(rows))
