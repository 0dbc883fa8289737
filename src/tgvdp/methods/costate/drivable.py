"""Runs of the front method without phases that are too short to drive: the points of a front, one by one."""

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from tgvdp.cores import shares, side_by_side
from tgvdp.methods.budget import Clock
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.phases.prune import Pruned, prune
from tgvdp.methods.phases.way import way_of
from tgvdp.physics.cell import Rows
from tgvdp.runs.batch import ROWS_OF_A_THREAD, Batch

_Floats = NDArray[np.float64]

#: What leaving phases out may add to E + λT, as a share of a run's energy; but of no less than `Mesh.least_energy_j`.
_LOSS = 5e-5
#: ... and as a share of what the next run costs less: the order of runs stays what it is.
_OF_STEP = 0.2
#: Rows between two looks at the clock: a tenth of a second. Usual runs have some thousand; one of more than these stays
#: as it is.
_ROWS_AT_ONCE = 200_000


def drivable(
    mesh: Mesh,
    outcome: _Floats,
    runs: Batch,
    aims_s: _Floats,
    tolerance_s: float,
    min_phase_s: float,
    counters: dict[str, int],
    clock: Clock,
) -> tuple[_Floats, Batch, NDArray[np.int8], bool]:
    """Leave short phases out of runs.

    Parameters
    ----------
    mesh : Mesh
        On which they were found.
    outcome : (n, 3) float64
        Running times, s, which rise, energies without auxiliaries, J, and multipliers, J/s.
    runs : Batch
        Rows of these runs, one at least, which are slower than the fastest one.
    aims_s : (m,) float64
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
    outcome : (n, 3) float64
    runs : Batch
    regime : (N,) int8
        Regime of each row, as `runs.profile` numbers them; −1 in a run that stayed as it is.
    complete : bool
        False where the time was up.
    """
    way = way_of(mesh.train, mesh.cells, Rows(mesh.envelope.x_m, mesh.envelope.w), mesh.tables)
    times_s, energies_j, price = outcome.T.copy()
    steps_j = np.full(len(outcome) + 1, np.inf)
    steps_j[1:-1] = energies_j[:-1] - energies_j[1:]
    drawn_j = energies_j + mesh.tables.auxiliary_w * times_s
    most_j = np.minimum(
        _LOSS * np.maximum(np.abs(drawn_j), mesh.least_energy_j), _OF_STEP * np.minimum(steps_j[1:], steps_j[:-1])
    )
    early_s = aims_s[np.abs(aims_s - times_s[:, np.newaxis]).argmin(axis=1)] - times_s
    early_s[np.abs(early_s) > tolerance_s] = 0.0  # it stands for a time that no run takes

    rows = np.diff(runs.first).tolist()
    count = shares(len(runs.x_m), ROWS_OF_A_THREAD)
    parts = list(_parts(rows, min(_ROWS_AT_ONCE, math.ceil(len(runs.x_m) / count))))
    pieces = [runs.part(part.start, part.stop) for part in parts]
    regimes = [np.full(len(piece.x_m), -1, dtype=np.int8) for piece in pieces]

    def pruned(i: int) -> Pruned:
        part = parts[i]
        return prune(way, pieces[i], price[part], min_phase_s, most_j[part], early_s[part], tolerance_s)

    changes = np.zeros_like(outcome)
    complete = True
    for first in range(0, len(parts), count):
        if clock.expired:
            complete = False
            break
        wave = [i for i in range(first, min(first + count, len(parts))) if len(pieces[i].x_m) <= _ROWS_AT_ONCE]
        for i, one in zip(wave, side_by_side(pruned, wave), strict=True):
            counters["short"] += one.short
            changes[parts[i], 0], changes[parts[i], 1] = one.time_s, one.energy_j
            pieces[i], regimes[i] = one.runs, one.regime
    return outcome + changes, Batch.joined(pieces), np.concatenate(regimes), complete


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
