"""A uniform stretch of the line, and the rows of a run along it, as kernels take them."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part
from tgvdp.errors import NumericalError
from tgvdp.memory import ask_for, scratch

#: Rows of one run at most, a hundred times those of the fastest run on 500 km: more of them are no motion of a train.
MOST_ROWS = 1 << 22


class Cell(NamedTuple):
    """One cell of the line, or the rest of one.

    Attributes
    ----------
    start_m, end_m, length_m : float
        Where it is, and its length, which is not the rounded difference of the two, m.
    grade_n : float
        Force of gradients and curves, N, positive uphill.
    air : float
        Coefficient of v² in the running resistance, N/(m/s)².
    limit_w : float
        Squared speed limit, m²/s².
    """

    start_m: float
    end_m: float
    length_m: float
    grade_n: float
    air: float
    limit_w: float


class Rows(NamedTuple):
    """Room for rows of a run, (size,) float64 each: positions, m, and squared speeds, m²/s²."""

    x: NDArray[np.float64]
    w: NDArray[np.float64]


def room_for_rows(count: int, purpose: str) -> Rows:
    """Room for so many rows, which is this thread's until it asks for some of the same purpose again.

    Raises
    ------
    NumericalError
        When these are more than `MOST_ROWS`.
    BudgetExceededError
        When there is not enough memory.
    """
    if count > MOST_ROWS:
        raise NumericalError(f"one run takes more than {MOST_ROWS:,} rows")
    ask_for(16.0 * count, f"{count:,} rows of runs")
    return Rows(*scratch(purpose, 2, count))


def room_for_marches(count: int, purpose: str) -> Rows:
    """Room for the rows of one march at a time, which `overrun` watches; else as `room_for_rows`."""
    march = room_for_rows(count, purpose)
    march.x[-1] = np.nan
    return march


def overrun(march: Rows) -> bool:
    """Whether a march had more rows than there was room for: what was made of it counts for nothing."""
    return not math.isnan(march.x[-1])


@part
def append(x, w, rows, n):
    """Append a row to those that there are; returns their new number, −1 where there is no room for it.

    Also where there was none for the one before.
    """
    if n < 0 or n >= rows.x.shape[0]:
        return -1
    rows.x[n] = x
    rows.w[n] = w
    return n + 1


@leaf
def is_row_of(run, j, rows, g):
    """Whether row j of a run is row g of others, bit by bit: runs of a front have many in common."""
    starts_alike = run.x[j] == rows.x[g] and run.w[j] == rows.w[g]
    return starts_alike and run.x[j + 1] == rows.x[g + 1] and run.w[j + 1] == rows.w[g + 1]


@leaf
def cell_at(cells, k):
    """One of the cells of `line.cells.Cells`."""
    return Cell(
        cells.station_m[k], cells.station_m[k + 1], cells.length_m[k], cells.grade_n[k], cells.air[k], cells.limit_w[k]
    )


@leaf
def begin_of(cell, end, length):
    """A cell up to ``end``."""
    return Cell(cell.start_m, end, length, cell.grade_n, cell.air, cell.limit_w)


@leaf
def rest_of(cell, start, length):
    """What is left of a cell from ``start`` on."""
    return Cell(start, cell.end_m, length, cell.grade_n, cell.air, cell.limit_w)


@leaf
def limited(cell, limit_w):
    """A cell with another speed limit."""
    return Cell(cell.start_m, cell.end_m, cell.length_m, cell.grade_n, cell.air, limit_w)
