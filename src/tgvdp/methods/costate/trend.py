"""Effort curves as the costate program takes them: their trend, where they go up and down within a cell.

Curves that were measured or read off a drawing are noisy. One step of the backward pass knows the slope of an effort at
one speed alone; where it changes its sign several times among the speeds of a cell it says nothing of the next cell,
and costates go astray. Runs are driven, and charged, by the curve itself: what a policy of its trend costs more is of
the second order in what noise there is.
"""

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.cells import Cells
from tgvdp.physics.forces import KernelTrain, per_kilogram, read_only

_Floats = NDArray[np.float64]

#: An effort that rises by less than this share does not turn.
_ROUNDING = 1e-6
#: Where a curve turns up so often within a cell, that is noise; gears and drops are further apart.
_OFTEN = 2


def unit_train_on(train: KernelTrain, cells: Cells) -> KernelTrain:
    """The train per unit of inertia, with the trends of its effort curves over cells as long as most of the line's are.

    Breaks of a line may leave them far shorter than a mesh would have them, and a trend over more is another train's.
    """
    length_m = cells.length_m
    return per_kilogram(train_of_trends(train, float(length_m @ length_m / length_m.sum())))


def train_of_trends(train: KernelTrain, cell_m: float) -> KernelTrain:
    """A train with the trends of its effort curves over the speeds that it passes in a cell of so many metres."""
    share = cell_m / train.inertia_kg
    return train._replace(traction=_trend(train.traction, share), braking=_trend(train.braking, share))


def _trend(table: _Floats, share: float) -> _Floats:
    """The curve, (n, 6), with means over v² where it is noisy; efforts change v² by twice their ``share`` in a cell."""
    if len(table) <= _OFTEN:  # it turns up at the start of a piece, but not of the first one
        return table
    v = table[:, 0]
    starts_n, ends_n = _effort_n(table, v), _effort_n(table[:-1], v[1:])
    turns_w = v[_turns_up(starts_n, ends_n)] ** 2
    if len(turns_w) < _OFTEN:
        return table
    w = v**2
    aside_w = np.minimum(share * starts_n, w)
    low_w, high_w = w - aside_w, w + aside_w
    is_noisy = np.searchsorted(turns_w, high_w, "right") - np.searchsorted(turns_w, low_w) >= _OFTEN
    is_noisy &= aside_w > 0.0
    if not is_noisy.any():
        return table
    sums = np.concatenate(([0.0], np.cumsum(_sum(table[:-1], v[1:]) - _sum(table[:-1], v[:-1]))))
    middle_n = starts_n.copy()
    work = _sum_up_to(table, sums, np.sqrt(high_w)) - _sum_up_to(table, sums, np.sqrt(low_w))
    middle_n[is_noisy] = work[is_noisy] / (high_w - low_w)[is_noisy]
    made = table.copy()
    ends_n = np.where(is_noisy[1:], middle_n[1:], ends_n)
    slope = (ends_n - middle_n[:-1]) / np.diff(v)
    cut = is_noisy[:-1] | is_noisy[1:]
    made[:-1][cut] = np.column_stack((v[:-1], np.zeros((len(cut), 5))))[cut]
    made[:-1, 2][cut] = (middle_n[:-1] - slope * v[:-1])[cut]
    made[:-1, 3][cut] = slope[cut]
    if is_noisy[-1]:
        made[-1, 1:] = 0.0
        made[-1, 2] = middle_n[-1]
    return read_only(made)


def _turns_up(starts_n: _Floats, ends_n: _Floats) -> NDArray[np.bool_]:
    """Where pieces begin, (n,), whether the effort has fallen before, and rises from there on."""
    along_n = np.column_stack((starts_n, np.append(ends_n, starts_n[-1]))).ravel()
    change_n = np.diff(along_n)
    change_n[np.abs(change_n) <= _ROUNDING * along_n[:-1]] = 0.0
    moves = np.flatnonzero(change_n)
    turns = moves[1:][(change_n[moves[1:]] > 0.0) & (change_n[moves[:-1]] < 0.0)]
    found = np.zeros(len(starts_n), dtype=np.bool_)
    found[(turns + 1) // 2] = True  # changes along pieces are the even ones, jumps to the next piece the odd ones
    return found


def _effort_n(table: _Floats, v: _Floats) -> _Floats:
    """Efforts of pieces (n, 6) at a speed each."""
    _, power_w, c0, c1, c2, c3 = table.T
    hyperbolic = np.divide(power_w, v, out=np.zeros_like(v), where=power_w != 0.0)
    return np.asarray(hyperbolic + c0 + v * (c1 + v * (c2 + v * c3)))


def _sum(table: _Floats, v: _Floats) -> _Floats:
    """∫F dv² of pieces (n, 6), from a standstill on, up to a speed each."""
    _, power_w, c0, c1, c2, c3 = table.T
    return np.asarray(2.0 * v * (power_w + v * (c0 / 2.0 + v * (c1 / 3.0 + v * (c2 / 4.0 + v * c3 / 5.0)))))


def _sum_up_to(table: _Floats, sums: _Floats, v: _Floats) -> _Floats:
    """∫F dv² of a curve up to speeds, by the ``sums`` up to its pieces."""
    i = np.searchsorted(table[:, 0], v, "right") - 1
    return np.asarray(sums[i] + _sum(table[i], v) - _sum(table[i], table[i, 0]))
