"""The points of a front: runs of a search without phases that are too short to drive, as true runs."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.cores import shares, side_by_side
from tgvdp.line.resolved import resolve
from tgvdp.methods.budget import Clock
from tgvdp.methods.costate.found import Found
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.phases.prune import Pruned, prune
from tgvdp.methods.phases.way import Way, way_of
from tgvdp.physics.cell import Rows
from tgvdp.runs.batch import Batch
from tgvdp.runs.bends import allowed_off_s, are_cut
from tgvdp.runs.followed import Followed, follow_all

_Floats = NDArray[np.float64]

#: What leaving phases out may add to E + λT, cheap ones aside (`phases.prune`), as a share of a run's energy; but of no
#: less than `Mesh.least_energy_j`.
_LOSS = 5e-5
#: ... and as a share of what the next run costs less: the order of runs stays what it is.
_OF_STEP = 0.2
#: Rows that are worth a thread of its own: to hand them over takes some tenths of a millisecond, they some whole ones.
_ROWS_OF_A_THREAD = 7000
#: Rows between two looks at the clock: a tenth of a second. Usual runs have some thousand; one of more than these stays
#: as it is.
_ROWS_AT_ONCE = 200_000


class Drivable(NamedTuple):
    """True runs.

    Attributes
    ----------
    outcome : (n, 3) float64
        Running times, s, energies by the trip's model, J, and multipliers, J/s, with auxiliaries.
    parts : list of Followed
        Some runs each, in order; regimes are −1 in a run that stayed as it is.
    complete : bool
        False where the time was up.
    """

    outcome: _Floats
    parts: list[Followed]
    complete: bool


class _Leaving(NamedTuple):
    """What leaving phases out of n runs asks for, as `prune` does."""

    way: Way
    price: _Floats
    least_s: float
    most_j: _Floats
    early_s: _Floats
    slack_s: float

    def done(self, part: slice, runs: Batch) -> Pruned:
        """Some of the runs, without their short phases."""
        return prune(
            self.way, runs, self.price[part], self.least_s, self.most_j[part], self.early_s[part], self.slack_s
        )


def drivable(
    mesh: Mesh,
    runs: Found,
    wanted_s: _Floats,
    tolerance_s: float,
    min_phase_s: float,
    counters: dict[str, int],
    clock: Clock,
) -> Drivable:
    """Leave short phases out of runs, and make them true ones.

    Parameters
    ----------
    mesh : Mesh
        On which they were found.
    runs : Found
        One at least; their times, s, rise, and they are slower than the fastest run.
    wanted_s : (n,) float64
        Running time that is wanted of each, s; its own where it stands for a time that no run takes.
    tolerance_s : float
        How well they are met, s.
    min_phase_s : float
        Shorter phases are left out, s; 0 leaves all.
    counters : dict of str to int, modified in place
        ``short`` counts those that had to stay.
    clock : Clock
        Runs that it leaves no time for keep their phases.
    """
    outcome = runs.outcome.copy()
    leaving = _leaving(mesh, outcome, wanted_s, tolerance_s, min_phase_s) if min_phase_s > 0.0 else None
    outcome[:, 1] += mesh.tables.auxiliary_w * outcome[:, 0]
    most_s = allowed_off_s(np.maximum(outcome[:, 1], mesh.least_drawn_j), outcome[:, 2])
    bends = are_cut(resolve(mesh.trip), outcome[:, 0], most_s)

    def driven(part: slice) -> tuple[Followed, int, bool]:
        own, regime, in_time, short = runs.rows.part(part), None, True, 0
        time_s, energy_j = outcome[part, 0], outcome[part, 1]
        if leaving is not None:
            in_time = not clock.expired
            if in_time and len(own.x_m) <= _ROWS_AT_ONCE:
                pruned = leaving.done(part, own)
                own, regime, short = pruned.runs, pruned.regime, pruned.short
                time_s = time_s + pruned.time_s
                energy_j = energy_j + pruned.energy_j + mesh.tables.auxiliary_w * pruned.time_s
            else:
                regime = np.full(len(own.x_m), -1, dtype=np.int8)
        return follow_all(mesh.trip, own, regime, time_s, energy_j, most_s[part], bends=bends), short, in_time

    parts = list(_parts(runs.rows.sizes.tolist()))
    true, shorts, in_times = zip(*side_by_side(driven, parts), strict=True)
    counters["short"] += sum(shorts)
    outcome[:, 0] = np.concatenate([one.time_s for one in true])
    outcome[:, 1] = np.concatenate([one.energy_j for one in true])
    return Drivable(outcome, list(true), all(in_times))


def _leaving(mesh: Mesh, outcome: _Floats, wanted_s: _Floats, tolerance_s: float, min_phase_s: float) -> _Leaving:
    """What leaving phases out of runs, whose energies are without auxiliaries, may cost, and change of their times."""
    times_s, energies_j, price = outcome.T.copy()
    steps_j = np.full(len(outcome) + 1, np.inf)
    steps_j[1:-1] = energies_j[:-1] - energies_j[1:]
    drawn_j = energies_j + mesh.tables.auxiliary_w * times_s
    most_j = np.minimum(
        _LOSS * np.maximum(np.abs(drawn_j), mesh.least_energy_j), _OF_STEP * np.minimum(steps_j[1:], steps_j[:-1])
    )
    way = way_of(mesh.train, mesh.cells, Rows(mesh.envelope.x_m, mesh.envelope.w), mesh.tables)
    return _Leaving(way, price, min_phase_s, most_j, wanted_s - times_s, tolerance_s)


def _parts(rows: Sequence[int]) -> Iterator[slice]:
    """Neighbouring runs, of so many rows each, that are done together: few rows, or one run that has more."""
    all_rows = sum(rows)
    most = min(_ROWS_AT_ONCE, math.ceil(all_rows / shares(all_rows, _ROWS_OF_A_THREAD)))
    first = together = 0
    for index, count in enumerate(rows):
        if index > first and together + count > most:
            yield slice(first, index)
            first = index
            together = 0
        together += count
    yield slice(first, len(rows))
