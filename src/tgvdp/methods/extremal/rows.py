"""Rows of a run that commands make: what belongs to one, how they are cut at the envelope, and what they cost."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part
from tgvdp.methods.extremal.course import account
from tgvdp.physics.cell import Cell
from tgvdp.physics.codes import HOLDING, RETARDED
from tgvdp.physics.forces import resistance_at
from tgvdp.physics.motion import net_force_at

#: Regime of rows on the envelope, besides those of `physics.codes`.
ENVELOPE = 8
#: Positions that are one, m.
SAME_M = 1e-9
#: Slopes that differ by less than this share are of the same effort, until w differs by this share.
_ALONG = 0.02
_ALONG_W = 2e-5


class Rows(NamedTuple):
    """Rows of a run, (size,) each: position, squared speed, time and energy since the start; of the row that ends
    there: regime, cell and mean effort.
    """

    x: NDArray[np.float64]
    w: NDArray[np.float64]
    time: NDArray[np.float64]
    energy: NDArray[np.float64]
    effort: NDArray[np.float64]
    regime: NDArray[np.int64]
    cell: NDArray[np.int64]


def rows_of(size: int) -> Rows:
    """Room for the rows of a run."""
    return Rows(*np.empty((5, size)), *np.zeros((2, size), dtype=np.int64))


@leaf
def is_anchor(regime):
    """Whether a run that meets a row of a regime goes on as that row does: on a held speed, or on the envelope."""
    return regime == HOLDING or regime >= RETARDED


@part
def effort_of(train, regime, grade, air, v):
    """Effort of a regime at a speed, comfort limits included."""
    net = net_force_at(train, regime, Cell(0.0, 0.0, 0.0, grade, air, math.inf), v)
    return net + resistance_at(train, air, v) + grade


@part
def clip(course, e, xs, ws, first, n, tol):
    """Cut rows first … n − 1 where they pass above the envelope; returns n, its row, and whether they do."""
    ex = course.x_m
    ew = course.w
    last = ex.shape[0] - 2
    for j in range(first, n):
        x0 = xs[j - 1]
        w0 = ws[j - 1]
        x1 = xs[j]
        slope = (ws[j] - w0) / (x1 - x0) if x1 > x0 else 0.0
        xa = x0
        while True:
            while e < last and ex[e + 1] <= xa:
                e += 1
            xb = min(x1, ex[e + 1])
            es = (ew[e + 1] - ew[e]) / (ex[e + 1] - ex[e])
            fb = w0 + slope * (xb - x0) - (ew[e] + es * (xb - ex[e]))
            # What runs along the envelope at the same effort joins it where that changes: not within one of its rows.
            along = es != 0.0 and abs(slope - es) < _ALONG * abs(es)
            if fb > (_ALONG_W if along else tol) * ew[e]:
                fa = w0 + slope * (xa - x0) - (ew[e] + es * (xa - ex[e]))
                xh = xa if fa >= 0.0 else xa + (xb - xa) * (-fa) / (fb - fa)
                xs[j] = xh
                ws[j] = ew[e] + es * (xh - ex[e])
                return (j if xh <= x0 + SAME_M else j + 1), e, True
            if xb >= x1:
                break
            xa = xb
    return n, e, False


@part
def account_rows(train, returned, grade, air, rows, first, n):
    """Time, energy and effort of rows first … n − 1."""
    for j in range(first, n):
        d = rows.x[j] - rows.x[j - 1]
        duration, energy, rows.effort[j] = account(train, returned, grade, air, d, rows.w[j - 1], rows.w[j])
        rows.time[j] = rows.time[j - 1] + duration
        rows.energy[j] = rows.energy[j - 1] + energy
