"""What a trip is prepared with for lower bounds: tables that break where braking rates do, and speed bounds."""

import numpy as np
from numpy.typing import NDArray

from tgvdp.certificate.speed_bound import speed_bound
from tgvdp.line.cells import Cells
from tgvdp.memory import ask_for
from tgvdp.physics.cell import Rows
from tgvdp.physics.forces import KernelTrain, read_only

_Floats = NDArray[np.float64]


def _broken_at(table: _Floats, more_mps: _Floats) -> _Floats:
    """An effort curve's table, (n, 6), whose pieces also break at given speeds."""
    from_mps = np.union1d(table[:, 0], more_mps)
    broken = table[np.searchsorted(table[:, 0], from_mps, side="right") - 1]
    broken[:, 0] = from_mps
    return read_only(np.asarray(broken))


def with_rates(train: KernelTrain) -> KernelTrain:
    """The train with tables of the dynamic brake, or none, that break where its braking rates do."""
    if len(train.rates) == 0:
        return train
    return train._replace(
        braking=_broken_at(train.braking, train.rates[:, 0]),
        no_effort=_broken_at(train.no_effort, train.rates[:, 0]),
    )


def speed_bound_rows(train: KernelTrain, cells: Cells, pieces: _Floats, end_w: float, *, forward: bool) -> Rows:
    """Rows of an outer bound of the fastest run: by traction from the origin, or by braking to the destination.

    ``end_w`` is the squared speed there, ``pieces`` (3n, 6) scratch.
    """
    size = 16384 + 4 * len(cells.length_m)
    while True:
        ask_for(16.0 * size, f"a speed bound of {size:,} rows")
        rows = Rows(*np.empty((2, size)))
        n = speed_bound(train, forward, cells, end_w, pieces, rows)
        if n >= 0:
            return Rows(rows.x[:n].copy(), rows.w[:n].copy())
        size *= 2
